#include "core/job.h"
#include "core/text.h"
#include "grid/field.h"
#include "grid/label_id.h"
#include "io/coding.h"
#include "io/formats/nifti/nifti.h"
#include "io/formats/nifti/nifti_labels.h"
#include "io/placement.h"
#include "io/sample_writer.h"
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

/* What the fixed header has no place for, as lines of a comment extension. */
static void build_comment(vvi_text *t, const vv_field_info *info, bool unit_fits, bool frame_unit_fits)
{
    if (info->grid.space != VV_SPACE_RAS)
        vvi_text_add(t, "space=plain\n");
    if (!unit_fits)
        vvi_text_printf(t, "unit=%s\n", info->grid.unit);
    if (!frame_unit_fits)
        vvi_text_printf(t, "frame_unit=%s\n", info->frame_unit);
    if (info->value_unit[0])
        vvi_text_printf(t, "value_unit=%s\n", info->value_unit);
    if (strlen(info->name) > 16)
        vvi_text_printf(t, "name=%s\n", info->name);
}

static int index_of(const char *const *names, int n, const char *name)
{
    for (int i = 0; i < n; i++)
        if (strcmp(names[i], name) == 0)
            return i;
    return -1;
}

static const char *const lengths[] = {"", "m", "mm", "um", NULL};

bool vvi_nifti_file_grid(vv_grid *out, const vv_grid *grid)
{
    return vvi_grid_in_unit(out, grid, lengths + 1);
}

/* -1: the format has no such unit. */
static int time_code(const vv_field_info *info)
{
    static const char *const times[] = {"", "s", "ms", "us", "Hz", "ppm", "rad/s"};
    return index_of(times, 7, info->frame_unit);
}

static void set_units(vvi_nifti *h, const char *length_unit, const vv_field_info *info)
{
    const int length = index_of(lengths, 4, length_unit), time = time_code(info);
    h->xyzt_units = (length > 0 ? length : 0) | (time > 0 ? time << 3 : 0);
}

static void set_type(vvi_nifti *h, const vv_field_info *info)
{
    static const int codes[VV_TYPE_COUNT] = {2, 256, 512, 4, 768, 8, 1280, 1024, 16, 64};
    const bool u8 = info->type == VV_TYPE_U8;
    h->datatype = codes[info->type];
    h->bitpix = (int)vv_type_bytes(info->type) * 8;
    if (info->meaning == VV_MEANING_LABEL)
        h->intent_code = VVI_NIFTI_INTENT_LABEL;
    else if (info->meaning == VV_MEANING_VECTOR)
        h->intent_code = VVI_NIFTI_INTENT_VECTOR;
    else if (info->meaning == VV_MEANING_RGB && u8)
        h->datatype = 128;
    else if (info->meaning == VV_MEANING_RGBA && u8)
        h->datatype = 2304;
    else if (info->meaning == VV_MEANING_RGB)
        h->intent_code = VVI_NIFTI_INTENT_RGB;
    else if (info->meaning == VV_MEANING_RGBA)
        h->intent_code = VVI_NIFTI_INTENT_RGBA;
    if (h->datatype == 128 || h->datatype == 2304)
        h->bitpix = h->datatype == 128 ? 24 : 32;
}

static bool is_packed_colour(const vvi_nifti *h)
{
    return h->datatype == 128 || h->datatype == 2304;
}

static void set_dims(vvi_nifti *h, const vv_field_info *info, size_t n_frames)
{
    const bool components = info->components > 1 && !is_packed_colour(h);
    h->dim[0] = components ? 5 : n_frames > 1 ? 4 : 3;
    for (int i = 0; i < 3; i++)
        h->dim[i + 1] = info->grid.dims[i];
    h->dim[4] = (int64_t)n_frames;
    h->dim[5] = components ? info->components : 1;
    h->dim[6] = h->dim[7] = 1;
    h->version = 1;
    for (int i = 1; i < 8; i++)
        if (h->dim[i] > INT16_MAX)
            h->version = 2;
}

static void set_placement(vvi_nifti *h, const vv_affine *p, double frame_step)
{
    const vv_vec3 column[4] = {p->axis[0], p->axis[1], p->axis[2], p->origin};
    for (int j = 0; j < 4; j++) {
        h->srow[0][j] = column[j].x;
        h->srow[1][j] = column[j].y;
        h->srow[2][j] = column[j].z;
    }
    h->pixdim[0] = 1;
    h->pixdim[4] = frame_step;
    h->sform_code = 1;
    h->qform_code = vvi_nifti_set_qform(h, p) ? 1 : 0;
}

/* Of an only channel; what the origin says comes over it. */
static void set_window(vvi_nifti *h, const vv_write_options *options)
{
    if (options->n_channels != 1 || !(options->channels[0].lo < options->channels[0].hi))
        return;
    h->cal_min = options->channels[0].lo;
    h->cal_max = options->channels[0].hi;
}

/* Numbers past the range of a float need the second version's doubles. */
static bool fits_floats(const vvi_nifti *h)
{
    double most = fmax(fabs(h->slope), fabs(h->intercept));
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 4; j++)
            most = fmax(most, fabs(h->srow[i][j]));
    return most < 1e37 && fabs(h->slope) > 1e-37;
}

void vvi_nifti_add_extension(vvi_text *t, const vvi_nifti *h, int32_t code, const void *bytes, size_t n)
{
    static const char zeros[16];
    const size_t padded = (n + 8 + 15) / 16 * 16;
    int32_t head[2] = {(int32_t)padded, code};
    if (h->swapped)
        vvi_swap_bytes(head, 4, 2);
    vvi_text_add_n(t, (const char *)head, sizeof head);
    vvi_text_add_n(t, bytes, n);
    vvi_text_add_n(t, zeros, padded - 8 - n);
}

/* Those of the file that the samples come from, ours, and the table of labels where it is not among them, one after the
 * other as they lie in the file. */
static vv_status build_extensions(vvi_text *out, const vvi_nifti *h, const char *comment, const vv_field_info *info,
                                  const vv_write_options *options)
{
    vvi_text text = {0};
    bool labelled;
    vvi_nifti_take_extensions(out, h, info, options, &labelled);
    if (comment) {
        vvi_text_printf(&text, "%s\n%s", VVI_NIFTI_EXTENSION, comment);
        vvi_nifti_add_extension(out, h, 6, text.s ? text.s : "", text.n);
    }
    bool bad = text.bad;
    vvi_text_free(&text);
    if (info->meaning == VV_MEANING_LABEL && options->n_labels > 0 && !labelled) {
        vvi_nifti_add_caret_labels(&text, options->labels, options->n_labels, vvi_label_is_unsigned(info->type));
        vvi_nifti_add_extension(out, h, 30, text.s ? text.s : "", text.n);
        bad |= text.bad;
        vvi_text_free(&text);
    }
    return bad || out->bad ? vv_fail_memory(out->n) : VV_OK;
}

static vv_status write_header(vv_sink *sink, vvi_nifti *h, const vvi_text *extensions)
{
    uint8_t bytes[VVI_NIFTI2_BYTES];
    const uint8_t flags[4] = {extensions->n > 0};
    const size_t fixed = h->version == 1 ? VVI_NIFTI1_BYTES : VVI_NIFTI2_BYTES;
    h->vox_offset = h->pair ? 0 : (double)(fixed + 4 + extensions->n);
    vvi_nifti_pack(bytes, h);
    vv_status st = vvi_sink_write(sink, bytes, fixed);
    if (st == VV_OK)
        st = vvi_sink_write(sink, flags, sizeof flags);
    return st == VV_OK && extensions->n ? vvi_sink_write(sink, extensions->s, extensions->n) : st;
}

/* NIfTI keeps the parts of a vector apart, the slowest of all; packed colours together. */
static vv_status write_samples(vv_sink *sink, const vvi_nifti *h, const vv_field *const *frames, size_t n_frames,
                               bool big_endian, vv_job *job)
{
    vv_status st = VV_OK;
    const int passes = is_packed_colour(h) ? 1 : (int)h->dim[5];
    for (int c = 0; c < passes && st == VV_OK; c++)
        for (size_t f = 0; f < n_frames && st == VV_OK; f++)
            st = vvi_samples_write(sink, frames[f], is_packed_colour(h) ? -1 : c, big_endian, job);
    return st;
}

static bool ends_in(const char *path, const char *suffix)
{
    const size_t n = strlen(path), m = strlen(suffix);
    return n > m && strcasecmp(path + n - m, suffix) == 0;
}

static vv_status open_image(vv_sink **image, vv_sink *sink, bool gz, int level)
{
    const char *path = vvi_sink_name(sink), *slash = strrchr(path, '/');
    const char *base = slash ? slash + 1 : path;
    const size_t n = strlen(base) - (ends_in(base, ".gz") ? 7 : 4);
    vvi_text name = {0};
    vvi_text_add_n(&name, base, n);
    vvi_text_add(&name, gz ? ".img.gz" : ".img");
    vv_status st = name.bad ? vv_fail_memory(n) : vvi_sink_beside(image, sink, name.s);
    vvi_text_free(&name);
    return st == VV_OK && gz ? vvi_sink_coding(*image, VVI_CODING_GZIP, level) : st;
}

/* Readers know a coded file by its name, so name and encoding must agree. */
static vv_status check_encoding(const char *path, const vv_write_options *options)
{
    if (ends_in(path, ".img") || ends_in(path, ".img.gz"))
        return vv_fail_at(VV_E_ARGUMENT, path, NULL, "is the samples' half of a pair; name the .hdr instead");
    if (!options->encoding || strcmp(path, "standard output") == 0)
        return VV_OK;
    const bool gzip = strcmp(options->encoding, "gzip") == 0;
    if (gzip == ends_in(path, ".gz"))
        return VV_OK;
    return vv_fail_at(VV_E_ARGUMENT, path, NULL, "the encoding is %s, so the name must %send in .gz", options->encoding,
                      gzip ? "" : "not ");
}

bool vvi_nifti_fill(vvi_nifti *h, const vv_field_info *info, size_t n_frames, const vv_write_options *options)
{
    vv_grid grid;
    h->slope = info->value_scale;
    h->intercept = info->value_offset;
    set_type(h, info);
    set_dims(h, info, n_frames);
    vvi_nifti_file_grid(&grid, &info->grid);
    set_placement(h, &grid.index_to_world, info->frame_step);
    set_units(h, grid.unit, info);
    set_window(h, options);
    snprintf(h->description, sizeof h->description, "VolVis");
    const bool slices = vvi_nifti_take_origin(h, info, options);
    if (!fits_floats(h))
        h->version = 2;
    memcpy(h->intent_name, info->name, strlen(info->name) < 16 ? strlen(info->name) : 16);
    return slices;
}

vv_status vvi_nifti_write(vv_sink *sink, const vv_field *const *frames, size_t n_frames,
                          const vv_write_options *options, vv_job *job)
{
    const vv_field_info *info = vv_field_get_info(frames[0]);
    const char *path = vvi_sink_name(sink);
    const bool hdr = ends_in(path, ".hdr"), hdr_gz = ends_in(path, ".hdr.gz");
    vv_status st = check_encoding(path, options);
    if (st != VV_OK)
        return st;
    vvi_nifti h = {.pair = hdr || hdr_gz, .swapped = vvi_order_swapped(options->big_endian)};
    if (!vvi_nifti_fill(&h, info, n_frames, options))
        vvi_log(job, VV_LOG_WARNING, "io",
                "%s: what the header says of when slices were acquired (slice_code, slice_duration, slice_start, "
                "slice_end) is left out: the slices are no longer those",
                path);
    vvi_text comment = {0}, extensions = {0};
    build_comment(&comment, info, index_of(lengths, 4, info->grid.unit) > 0, time_code(info) >= 0 || n_frames < 2);
    if (comment.n > 0)
        vvi_log(job, VV_LOG_INFO, "io", "%s: what NIfTI cannot store is written as a comment in its header", path);
    vvi_log_lost_unit(sink, &info->grid, "mm", job);
    vvi_log_lost_names(sink, options, VVI_KEEPS_LABELS | VVI_KEEPS_WINDOW, "nifti", job);
    vv_sink *image = sink;
    st = comment.bad ? vv_fail_memory(comment.n) : build_extensions(&extensions, &h, comment.s, info, options);
    if (st == VV_OK)
        st = write_header(sink, &h, &extensions);
    vvi_text_free(&comment);
    vvi_text_free(&extensions);
    if (st == VV_OK && h.pair)
        st = open_image(&image, sink, hdr_gz, options->level);
    return st == VV_OK ? write_samples(image, &h, frames, n_frames, options->big_endian, job) : st;
}
