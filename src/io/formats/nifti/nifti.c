/* NIfTI-1 and -2: single files, .hdr/.img pairs, both byte orders; Analyze 7.5 pairs. */
#include "io/formats/nifti/nifti.h"
#include "core/memory.h"
#include "core/units.h"
#include "io/coding.h"
#include "registry.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

static int probe(const uint8_t *head, size_t n, const char *path)
{
    bool swapped, pair;
    const size_t n_path = strlen(path);
    if (vvi_nifti_version(head, n, &swapped, &pair))
        return 2;
    /* An .img file has no header of its own; a .hdr or .nii that is no NIfTI deserves a sentence that says so. */
    for (size_t i = 0; i < 2; i++) {
        const size_t m = i ? 3 : 0; /* before ".gz" */
        static const char *const own[] = {".img", ".hdr", ".nii"};
        for (size_t s = 0; s < 3; s++)
            if (n_path > m + 4 && strncasecmp(path + n_path - m - 4, own[s], 4) == 0 &&
                (m == 0 || strcasecmp(path + n_path - 3, ".gz") == 0))
                return 1;
    }
    return 0;
}

static void free_plan(void *plan)
{
    vvi_free(plan);
}

/* The header ------------------------------------------------------------------------------------------------------ */

static vv_status fail_magic(const uint8_t *head, size_t n, const char *name)
{
    static const uint8_t little[] = {0x5c, 1, 0, 0}, big[] = {0, 0, 1, 0x5c};
    if (n >= VVI_NIFTI1_BYTES && (memcmp(head, little, 4) == 0 || memcmp(head, big, 4) == 0))
        return vv_fail_at(VV_E_FORMAT, name, NULL,
                          "is neither NIfTI (its magic is not n+1 or ni1) nor Analyze 7.5 (dim[0] would be 1 to 7)");
    return vv_fail_at(VV_E_FORMAT, name, NULL,
                      "is not a NIfTI file: it begins with neither 348 and n+1 or ni1 nor 540 and n+2 or ni2");
}

static vv_status read_bytes(vvi_nifti *h, vv_source *source, vv_notes *notes)
{
    uint8_t bytes[VVI_NIFTI2_BYTES];
    size_t n;
    const uint8_t *head = vvi_source_peek(source, sizeof bytes, &n);
    if (!head)
        return vv_error_last()->status;
    h->version = vvi_nifti_version(head, n, &h->swapped, &h->pair);
    if (!h->version && vvi_nifti_is_analyze(head, n, &h->swapped)) {
        h->analyze = h->pair = true;
        h->version = 1;
    }
    if (!h->version)
        return fail_magic(head, n, vvi_source_name(source));
    vv_status st =
        vvi_source_read(source, bytes, h->version == 1 ? VVI_NIFTI1_BYTES : VVI_NIFTI2_BYTES, "the NIfTI header");
    if (st == VV_OK && h->analyze)
        vvi_nifti_unpack_analyze(h, bytes);
    else if (st == VV_OK)
        vvi_nifti_unpack(h, bytes);
    if (st != VV_OK || h->analyze)
        return st;
    return vvi_notes_keep(notes, VVI_NIFTI_KEPT_HEADER, bytes, h->version == 1 ? VVI_NIFTI1_BYTES : VVI_NIFTI2_BYTES);
}

static vv_status check_dims(const vvi_nifti *h, const char *name, const vv_limits *limits)
{
    if (h->dim[0] < 1 || h->dim[0] > 7)
        return vv_fail_at(VV_E_FORMAT, name, NULL, "dim[0] is %lld; it counts the axes, 1 to 7", (long long)h->dim[0]);
    for (int i = 1; i <= (int)h->dim[0]; i++) {
        if (h->dim[i] < 1 || h->dim[i] > (int64_t)limits->dim)
            return vv_fail_at(VV_E_FORMAT, name, NULL,
                              "dim[%d] is %lld; 1 to %llu are possible (--limit dim=N allows more)", i,
                              (long long)h->dim[i], (unsigned long long)limits->dim);
        if (i > 5 && h->dim[i] > 1)
            return vv_fail_at(VV_E_UNSUPPORTED, name, NULL,
                              "has %lld entries along axis %d; only x, y, z, time and channels can be shown",
                              (long long)h->dim[i], i);
    }
    return VV_OK;
}

typedef struct datatype {
    int code, bits;
    vv_type type;
    int components;
    const char *refused;
} datatype;

static const datatype datatypes[] = {
    {2, 8, VV_TYPE_U8, 1, NULL},          {4, 16, VV_TYPE_I16, 1, NULL},        {8, 32, VV_TYPE_I32, 1, NULL},
    {16, 32, VV_TYPE_F32, 1, NULL},       {64, 64, VV_TYPE_F64, 1, NULL},       {128, 24, VV_TYPE_U8, 3, NULL},
    {256, 8, VV_TYPE_I8, 1, NULL},        {512, 16, VV_TYPE_U16, 1, NULL},      {768, 32, VV_TYPE_U32, 1, NULL},
    {1024, 64, VV_TYPE_I64, 1, NULL},     {1280, 64, VV_TYPE_U64, 1, NULL},     {2304, 32, VV_TYPE_U8, 4, NULL},
    {1, 1, 0, 1, "single bits"},          {32, 64, 0, 1, "complex numbers"},    {1536, 128, 0, 1, "128-bit floats"},
    {1792, 128, 0, 1, "complex numbers"}, {2048, 256, 0, 1, "complex numbers"},
};

static vv_status find_datatype(const datatype **out, const vvi_nifti *h, const char *name)
{
    for (size_t i = 0; i < sizeof datatypes / sizeof *datatypes; i++) {
        const datatype *d = &datatypes[i];
        if (d->code != h->datatype)
            continue;
        if (d->refused)
            return vv_fail_at(VV_E_UNSUPPORTED, name, NULL, "its samples are %s (datatype %d), which cannot be shown",
                              d->refused, h->datatype);
        if (h->bitpix != d->bits && h->bitpix != 0)
            return vv_fail_at(VV_E_FORMAT, name, NULL, "datatype %d has %d bits per sample, but bitpix is %d", d->code,
                              d->bits, h->bitpix);
        *out = d;
        return VV_OK;
    }
    return vv_fail_at(VV_E_FORMAT, name, NULL, "datatype %d is not known", h->datatype);
}

static vv_status fill_layout(vv_field_info *info, vvi_nifti *h, const char *name)
{
    const datatype *d = NULL;
    vv_status st = find_datatype(&d, h, name);
    if (st != VV_OK)
        return st;
    int64_t dim[6] = {1, 1, 1, 1, 1, 1};
    for (int i = 1; i <= 5 && i <= (int)h->dim[0]; i++)
        dim[i] = h->dim[i];
    if (d->components > 1 && dim[5] > 1)
        return vv_fail_at(VV_E_UNSUPPORTED, name, NULL, "has %lld colours in each sample; one can be shown",
                          (long long)dim[5]);
    info->type = d->type;
    info->components = d->components > 1 ? d->components : (int)dim[5];
    info->n_frames = dim[4];
    memcpy(info->grid.dims, &dim[1], 3 * sizeof dim[0]);
    vvi_layout *l = &h->layout;
    *l = (vvi_layout){.type = d->type, .swap = h->swapped && vv_type_bytes(d->type) > 1};
    if (d->components > 1)
        l->axis[l->n_axes++] = (vvi_layout_axis){d->components, VVI_ROLE_COMPONENT};
    for (int i = 0; i < 3; i++)
        l->axis[l->n_axes++] = (vvi_layout_axis){dim[1 + i], (vvi_role)(VVI_ROLE_X + i)};
    l->axis[l->n_axes++] = (vvi_layout_axis){dim[4], VVI_ROLE_FRAME};
    if (dim[5] > 1)
        l->axis[l->n_axes++] = (vvi_layout_axis){dim[5], VVI_ROLE_COMPONENT};
    return VV_OK;
}

/* A slope of 0, or one that is not finite, means that stored numbers are the values. */
static vv_status fill_scale(vv_field_info *info, const vvi_nifti *h, const char *name, vv_notes *notes)
{
    const bool colour = h->datatype == 128 || h->datatype == 2304;
    if (!isfinite(h->slope))
        return vvi_notes_warn(notes, "its slope (scl_slope) is %g: stored numbers are taken to be the values",
                              h->slope);
    if (!isfinite(h->intercept))
        return vv_fail_at(VV_E_FORMAT, name, NULL,
                          "its intercept (scl_inter) is %g; expected a finite number; set scl_slope to 1 and "
                          "scl_inter to 0 if the samples are the values",
                          h->intercept);
    if (h->slope != 0 && !colour) {
        info->value_scale = h->slope;
        info->value_offset = h->intercept;
    }
    return VV_OK;
}

static void fill_meaning(vv_field_info *info, const vvi_nifti *h)
{
    const bool whole = !vv_type_is_float(info->type);
    if (h->datatype == 128 || (h->intent_code == VVI_NIFTI_INTENT_RGB && info->components == 3))
        info->meaning = VV_MEANING_RGB;
    else if (h->datatype == 2304 || (h->intent_code == VVI_NIFTI_INTENT_RGBA && info->components == 4))
        info->meaning = VV_MEANING_RGBA;
    else if (h->intent_code == VVI_NIFTI_INTENT_LABEL && whole && info->components == 1)
        info->meaning = VV_MEANING_LABEL;
    else if ((h->intent_code == VVI_NIFTI_INTENT_VECTOR || h->intent_code == VVI_NIFTI_INTENT_DISPLACEMENT) &&
             info->components > 1)
        info->meaning = VV_MEANING_VECTOR;
    memcpy(info->name, h->intent_name, sizeof h->intent_name);
}

/* The values between which it should be shown. */
static vv_status take_window(const vv_field_info *info, const vvi_nifti *h, vv_notes *notes)
{
    const vv_channel channel = {.lo = h->cal_min, .hi = h->cal_max};
    if (!isfinite(channel.lo) || !isfinite(channel.hi) || !(channel.lo < channel.hi) || info->components != 1 ||
        info->meaning != VV_MEANING_SCALAR)
        return VV_OK;
    return vvi_notes_channel(notes, &channel);
}

/* A table of labels says what the samples are, also where the intent does not. */
static void take_labels(vv_field_info *info, const vv_notes *notes)
{
    size_t n;
    vvi_notes_labels(notes, &n);
    if (n > 0 && info->meaning == VV_MEANING_SCALAR && info->components == 1 && !vv_type_is_float(info->type))
        info->meaning = VV_MEANING_LABEL;
}

static const char *const time_units[] = {"", "s", "ms", "us", "Hz", "ppm", "rad/s", ""};

static void fill_time(vv_field_info *info, const vvi_nifti *h)
{
    if (info->n_frames < 2)
        return;
    const double step = h->pixdim[4];
    info->frame_step = isfinite(step) && step > 0 ? step : 0;
    snprintf(info->frame_unit, sizeof info->frame_unit, "%s", time_units[h->xyzt_units >> 3 & 7]);
}

static vv_status note_text(vv_notes *notes, const char *key, const char *value)
{
    return value[0] ? vvi_notes_add(notes, key, value) : VV_OK;
}

static vv_status note_number(vv_notes *notes, const char *key, double value)
{
    char text[32];
    if (value == 0 || !isfinite(value))
        return VV_OK;
    vvi_print_number(text, value);
    return vvi_notes_add(notes, key, text);
}

/* When a volume by itself was: one of a series of files says it so. */
static vv_status note_time(vv_notes *notes, const vvi_nifti *h)
{
    char text[64];
    if (h->dim[0] >= 4 && h->dim[4] > 1)
        return VV_OK;
    if (h->toffset == 0 || !isfinite(h->toffset))
        return VV_OK;
    vvi_print_number(text, h->toffset);
    const size_t n = strlen(text);
    snprintf(text + n, sizeof text - n, " %s", time_units[h->xyzt_units >> 3 & 7]);
    return vvi_notes_add(notes, "time", text);
}

static vv_status fill_notes(vv_notes *notes, const vvi_nifti *h)
{
    const struct {
        const char *key;
        double value;
    } numbers[] = {{"cal_min", h->cal_min},       {"cal_max", h->cal_max},       {"toffset", h->toffset},
                   {"qform_code", h->qform_code}, {"sform_code", h->sform_code}, {"intent_code", h->intent_code},
                   {"xyzt_units", h->xyzt_units}, {"intent_p1", h->intent_p[0]}, {"intent_p2", h->intent_p[1]},
                   {"intent_p3", h->intent_p[2]}};
    vv_status st = note_text(notes, "descrip", h->description);
    if (st == VV_OK)
        st = note_time(notes, h);
    if (st == VV_OK)
        st = note_text(notes, "aux_file", h->aux_file);
    for (size_t i = 0; i < sizeof numbers / sizeof *numbers && st == VV_OK; i++)
        st = note_number(notes, numbers[i].key, numbers[i].value);
    return st;
}

/* Where the samples are ---------------------------------------------------------------------------------------------
 */

static vv_status find_offset(vvi_nifti *h, const char *name)
{
    const double least = h->pair ? 0 : h->version == 1 ? VVI_NIFTI1_BYTES : VVI_NIFTI2_BYTES;
    if (!isfinite(h->vox_offset) || h->vox_offset < 0 || h->vox_offset > 0x1p53 ||
        h->vox_offset != floor(h->vox_offset))
        return vv_fail_at(VV_E_FORMAT, name, NULL, "vox_offset is %g, which is not a position in a file",
                          h->vox_offset);
    if (h->vox_offset < least && h->vox_offset != 0)
        return vv_fail_at(VV_E_FORMAT, name, NULL, "vox_offset is %g, inside the header of %g bytes", h->vox_offset,
                          least);
    h->offset = (uint64_t)h->vox_offset;
    if (h->offset == 0 && !h->pair) /* left out; the header and its four bytes of extension flags */
        h->offset = (uint64_t)least + 4;
    return VV_OK;
}

static vv_status check_samples(vvi_nifti *h, vv_source *source, vv_job *job)
{
    uint64_t n;
    vvi_nifti_opened o = {0};
    vv_status st = vvi_layout_count(&n, &h->layout, vvi_source_name(source));
    if (st == VV_OK)
        st = vvi_nifti_open_samples(&o, h, source, job);
    const uint64_t bytes = st == VV_OK ? n * vv_type_bytes(h->layout.type) : 0;
    if (st == VV_OK)
        st = vvi_source_expect_half(o.source, h->offset, bytes, "samples");
    if (st == VV_OK)
        h->mappable = vvi_layout_mappable(&h->layout, h->offset) && vvi_source_mappable(o.source, h->offset, bytes);
    vvi_nifti_close(&o);
    return st;
}

static vv_status understand(vv_field_info *info, vvi_nifti *h, vv_source *source, vv_notes *notes)
{
    const char *name = vvi_source_name(source);
    vv_status st = check_dims(h, name, vvi_source_limits(source));
    if (st != VV_OK || (st = fill_layout(info, h, name)) != VV_OK || (st = fill_scale(info, h, name, notes)) != VV_OK ||
        (st = find_offset(h, name)) != VV_OK)
        return st;
    st = h->analyze ? vvi_nifti_place_analyze(&info->grid, h, name, notes)
                    : vvi_nifti_place(&info->grid, h, name, notes);
    if (st != VV_OK)
        return st;
    fill_meaning(info, h);
    fill_time(info, h);
    if ((st = fill_notes(notes, h)) != VV_OK || h->analyze)
        return st;
    st = h->pair || h->offset > (h->version == 1 ? 352u : 544u) ? vvi_nifti_read_extensions(info, h, source, notes)
                                                                : VV_OK;
    if (st == VV_OK)
        take_labels(info, notes);
    return st == VV_OK ? take_window(info, h, notes) : st;
}

static vv_status read_and_understand(vv_field_info *info, vvi_nifti *h, vv_source *source, vv_notes *notes, vv_job *job)
{
    vvi_nifti_opened header = {.source = source};
    vv_status st = VV_OK;
    if (vvi_nifti_is_image(source))
        st = vvi_nifti_open_other(&header, source, ".img", ".hdr", job);
    if (st == VV_OK)
        st = read_bytes(h, header.source, notes);
    if (st == VV_OK && vvi_nifti_is_image(source) && !h->pair)
        st = vv_fail_at(VV_E_FORMAT, vvi_source_name(header.source), NULL,
                        "says that it holds its samples itself; open it");
    if (st == VV_OK)
        st = understand(info, h, header.source, notes);
    vvi_nifti_close(&header);
    return st;
}

static vv_status read_header(vv_field_info *info, void **plan_out, vv_source *source, const vv_read_options *options,
                             vv_notes *notes, vv_job *job)
{
    *plan_out = NULL;
    vvi_nifti *h = vvi_alloc_zeroed(job, sizeof *h, VVI_MEM_MODEL);
    if (!h)
        return vv_fail_memory(sizeof *h);
    vv_status st = read_and_understand(info, h, source, notes, job);
    if (st == VV_OK)
        st = check_samples(h, source, job);
    if (st != VV_OK) {
        free_plan(h);
        return st;
    }
    *plan_out = h;
    return VV_OK;
}

static vv_status read_samples(vv_field **out, const vv_field_info *info, const void *plan, vv_source *source,
                              int64_t frame, const vv_box *region, vv_job *job)
{
    const vvi_nifti *h = plan;
    vvi_nifti_opened o = {0};
    *out = NULL;
    vv_status st = vvi_nifti_open_samples(&o, h, source, job);
    if (st == VV_OK)
        st = vvi_layout_read_plain(out, info, &h->layout, o.source, h->offset, frame, region, job);
    vvi_nifti_close(&o);
    return st;
}

static bool mappable(const vv_field_info *info, const void *plan)
{
    return ((const vvi_nifti *)plan)->mappable;
}

static const char *const suffixes[] = {".nii", ".hdr", ".img", NULL};
static const char *const encodings[] = {"raw", "gzip", NULL};

const vv_format vvi_format_nifti = {
    .beside = true,
    .api = VV_FORMAT_API,
    .name = "nifti",
    .doc = "NIfTI-1 and -2: .nii, .nii.gz, .hdr with .img (named by its .hdr to write); Analyze 7.5 (read)",
    .suffixes = suffixes,
    .encodings = encodings,
    .probe = probe,
    .read_header = read_header,
    .free_plan = free_plan,
    .read = read_samples,
    .mappable = mappable,
    .write = vvi_nifti_write,
    .keeps_scale = true,
    .takes_origin = true,
};
