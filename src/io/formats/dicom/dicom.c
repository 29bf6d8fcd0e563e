#include "config.h"
#include "core/job.h"
#include "core/memory.h"
#include "io/format.h"
#include "io/formats/dicom/dicom_contours.h"
#include "io/formats/dicom/dicom_gdcm.h"
#include "io/notes.h"
#include "io/scan.h"
#include "registry.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

static int probe(const uint8_t *head, size_t n, const char *path)
{
    return vvi_dicom_probe(head, n);
}

static int probe_file(const vv_source *folder, const char *name, vv_job *job)
{
    vv_source *source;
    size_t n;
    if (vvi_source_open_beside(&source, folder, name, job) != VV_OK)
        return 0;
    const uint8_t *head = vvi_source_peek(source, 1024, &n);
    const int sure = head ? vvi_dicom_probe(head, n) : 0;
    vvi_source_close(source);
    return sure;
}

/* Whether a file is called as DICOM files are, and is one: of a few that are. */
static bool has_named(const vv_source *folder, const vvi_names *names, vv_job *job)
{
    int looked = 0;
    for (size_t i = 0; i < names->n && looked < 4; i++) {
        if (!vvi_format_has_suffix(&vvi_format_dicom, names->name[i], strlen(names->name[i])))
            continue;
        looked++;
        if (probe_file(folder, names->name[i], job) > 0)
            return true;
    }
    return false;
}

/* Some files of the folder, evenly: the first may be a text or a list. */
static int probe_folder(vv_source *folder, vv_job *job)
{
    vvi_names names;
    int sure = 0, found = 0, looked = 0;
    if (vvi_source_list(&names, folder, NULL, true, job) != VV_OK)
        return 0;
    const size_t step = names.n > 16 ? names.n / 16 : 1;
    for (size_t i = 0; i < names.n && looked < 20; i += step, looked++)
        found += probe_file(folder, names.name[i], job) > 0;
    if (found > 0 || has_named(folder, &names, job))
        sure = found > 0 && 2 * found >= looked ? 2 : 1;
    vvi_names_free(&names);
    return sure;
}

void vvi_dicom_plan_finish(vvi_dicom_plan *p)
{
    for (size_t i = 0; i < p->n_images; i++)
        vvi_dicom_image_finish(&p->image[i]);
    for (size_t i = 0; i < p->n_stacks; i++)
        vvi_free(p->stack[i].slice);
    vvi_free(p->stack);
    vvi_free(p->image);
    vvi_free(p->slice);
    vvi_free(p->painted);
    vvi_free(p->first_painted);
    vvi_names_free(&p->names);
}

static void free_plan(void *plan)
{
    if (plan)
        vvi_dicom_plan_finish(plan);
    vvi_free(plan);
}

static vv_status one_file(vvi_dicom_plan *plan, vv_source *source, vv_job *job)
{
    vv_status st = vvi_source_spool(source, job);
    if (st != VV_OK)
        return st;
    plan->image = vvi_alloc_zeroed(job, sizeof *plan->image, VVI_MEM_MODEL);
    if (!plan->image)
        return vv_fail_memory(sizeof *plan->image);
    plan->n_images = 1;
    size_t n;
    const uint8_t *head = vvi_source_peek(source, 1024, &n);
    if (!head)
        return vv_error_last()->status;
    if (vvi_dicom_probe(head, n) == 0)
        return vv_fail_at(VV_E_FORMAT, vvi_source_name(source), NULL,
                          "does not begin as DICOM files do: no DICM after 128 bytes, no element at its start");
    return vvi_dicom_image_read(plan->image, source, job);
}

/* Values ---------------------------------------------------------------------------------------------------------- */

static double slope_of(const vvi_dicom_values *v)
{
    return isfinite(v->slope) && v->slope != 0 ? v->slope : 1;
}

static double intercept_of(const vvi_dicom_values *v)
{
    return isfinite(v->intercept) ? v->intercept : 0;
}

/* One scale for all slices keeps what is stored; each its own makes floats of it. */
static void find_scale(vv_field_info *info, vvi_dicom_plan *plan)
{
    size_t first;
    const vvi_dicom_image *image = vvi_dicom_first(plan, &first);
    const vvi_dicom_values *v = vvi_dicom_frame_values(image, plan->slice[first].frame);
    const size_t n = (size_t)(info->n_frames * info->grid.dims[2]);
    if (image->components != 1)
        return;
    for (size_t i = first; i < n && !plan->own_scale; i++) {
        if (plan->slice[i].image < 0)
            continue;
        const vvi_dicom_values *w = vvi_dicom_frame_values(&plan->image[plan->slice[i].image], plan->slice[i].frame);
        plan->own_scale = slope_of(v) != slope_of(w) || intercept_of(v) != intercept_of(w);
    }
    if (plan->own_scale) {
        info->type = VV_TYPE_F32;
        return;
    }
    info->value_scale = slope_of(v);
    info->value_offset = intercept_of(v);
    const double dose = image->number[VVI_DICOM_DOSE_SCALING];
    if (isfinite(dose) && dose != 0)
        info->value_scale = dose;
}

/* Of PET (C.8.9.1.1.3): what has another spelling everywhere else. */
static const char *unit_of_term(const char *term)
{
    static const char *const terms[][2] = {{"BQML", "Bq/ml"},  {"GML", "g/ml"},     {"CM2ML", "cm2/ml"},
                                           {"CNTS", "counts"}, {"CPS", "counts/s"}, {"PCNT", "%"},
                                           {"NONE", ""}};
    for (size_t i = 0; i < sizeof terms / sizeof *terms; i++)
        if (strcmp(term, terms[i][0]) == 0)
            return terms[i][1];
    return term;
}

static void find_unit(vv_field_info *info, const vvi_dicom_image *image)
{
    const char *type = image->text[VVI_DICOM_RESCALE_TYPE], *unit = "";
    if (strcmp(image->text[VVI_DICOM_DOSE_UNITS], "GY") == 0)
        unit = "Gy";
    else if (*unit_of_term(image->text[VVI_DICOM_UNITS]))
        unit = unit_of_term(image->text[VVI_DICOM_UNITS]);
    else if (!type[0] && strcmp(image->text[VVI_DICOM_MODALITY], "CT") == 0 && isfinite(image->values.intercept))
        unit = "HU";
    else if (strlen(type) < sizeof info->value_unit && !strchr(type, ' ') && strcmp(type, "US") != 0 &&
             strcmp(type, "normalized") != 0)
        unit = type;
    snprintf(info->value_unit, sizeof info->value_unit, "%.15s", unit);
}

static void describe_samples(vv_field_info *info, vvi_dicom_plan *plan, const vvi_dicom_image *image)
{
    info->type = image->type;
    info->components = image->components;
    info->meaning = image->components == 3 ? VV_MEANING_RGB : VV_MEANING_SCALAR;
    if (image->number[VVI_DICOM_ALLOCATED] == 1)
        info->meaning = VV_MEANING_LABEL;
    find_scale(info, plan);
    find_unit(info, image);
}

static vv_status describe(vv_field_info *info, vvi_dicom_plan *plan, vv_source *source, vv_notes *notes, vv_job *job)
{
    const vvi_dicom_image *image = vvi_dicom_first(plan, NULL);
    info->grid.dims[0] = (int64_t)image->number[VVI_DICOM_COLUMNS];
    info->grid.dims[1] = (int64_t)image->number[VVI_DICOM_ROWS];
    if (!plan->first_painted) /* else that is told */
        describe_samples(info, plan, image);
    plan->straight = vvi_dicom_is_straight(info, plan);
    snprintf(info->name, sizeof info->name, "%.*s",
             (int)vvi_utf8_cut(image->text[VVI_DICOM_DESCRIPTION], strlen(image->text[VVI_DICOM_DESCRIPTION]), 63),
             image->text[VVI_DICOM_DESCRIPTION]);
    vv_status st = vvi_dicom_place(info, plan, vvi_source_name(source), notes);
    return st == VV_OK ? vvi_dicom_note(image, info, source, notes, job) : st;
}

/* Lossless JPEG, and RLE, need nothing. */
static bool needs_gdcm(const vvi_dicom_image *image)
{
    const char *syntax = image->text[VVI_DICOM_SYNTAX];
    return image->coding > VVI_DICOM_RLE && strcmp(syntax, "1.2.840.10008.1.2.4.57") != 0 &&
           strcmp(syntax, "1.2.840.10008.1.2.4.70") != 0;
}

static vv_status need_gdcm(const char *name)
{
#if VV_HAVE_GDCM
    const char *problem = vvi_gdcm_problem();
    return !problem ? VV_OK
                    : vv_fail_at(VV_E_UNSUPPORTED, name, NULL,
                                 "is packed as lossy JPEG, JPEG-LS or JPEG 2000, which needs " VVI_GDCM_MODULE
                                 ", but %s; install VolVis again, or unpack the file first, for example with "
                                 "gdcmconv --raw",
                                 problem);
#else
    return vv_fail_at(VV_E_UNSUPPORTED, name, NULL,
                      "is packed as lossy JPEG, JPEG-LS or JPEG 2000, for which this build lacks GDCM; unpack it "
                      "first, for example with gdcmconv --raw");
#endif
}

static vv_status check_codings(const vvi_dicom_plan *plan, const vvi_dicom_stack *stack, const char *name)
{
    for (size_t i = 0; i < stack->n; i++)
        if (needs_gdcm(&plan->image[stack->slice[i].image]))
            return need_gdcm(name);
    return VV_OK;
}

static vv_status understand(vv_field_info *info, vvi_dicom_plan *plan, vv_source *source,
                            const vv_read_options *options, vv_notes *notes, vv_job *job)
{
    const char *name = vvi_source_name(source);
    const char *layer = NULL;
    size_t chosen = 0;
    vv_status st =
        vvi_source_is_folder(source) ? vvi_dicom_gather(plan, source, true, notes, job) : one_file(plan, source, job);
    if (st == VV_OK)
        st = vvi_dicom_choose(plan, &chosen, &layer, options, name, notes, job);
    if (st == VV_OK)
        st = check_codings(plan, &plan->stack[chosen], name);
    vvi_dicom_stack *stack = st == VV_OK ? &plan->stack[chosen] : NULL;
    if (stack && vvi_dicom_is_structure_set(&plan->image[stack->slice[0].image]))
        st = vvi_dicom_draw(plan, stack, source, notes, job);
    if (st == VV_OK && stack && vvi_dicom_segmentation_of(&plan->image[stack->slice[0].image]))
        st = vvi_dicom_arrange_segments(info, plan, stack, layer, source, notes, job);
    else if (st == VV_OK && stack)
        st = vvi_dicom_arrange(info, plan, stack, name, notes, job);
    return st == VV_OK ? describe(info, plan, source, notes, job) : st;
}

static vv_status read_header(vv_field_info *info_out, void **plan_out, vv_source *source,
                             const vv_read_options *options, vv_notes *notes, vv_job *job)
{
    *plan_out = NULL;
    vvi_dicom_plan *plan = vvi_alloc_zeroed(job, sizeof *plan, VVI_MEM_MODEL);
    if (!plan)
        return vv_fail_memory(sizeof *plan);
    const vv_status st = understand(info_out, plan, source, options, notes, job);
    if (st != VV_OK) {
        free_plan(plan);
        return st;
    }
    *plan_out = plan;
    return VV_OK;
}

static bool mappable(const vv_field_info *info, const void *plan)
{
    const vvi_dicom_plan *p = plan;
    return p->straight && !p->image->big && p->image->pixels.at % vv_type_bytes(info->type) == 0;
}

static const char *const suffixes[] = {".dcm", ".dicom", ".ima", NULL};

const vv_format vvi_format_dicom = {
    .beside = true,
    .api = VV_FORMAT_API,
    .name = "dicom",
    .doc = "DICOM: folders of slices, multi-frame files",
    .suffixes = suffixes,
    .probe = probe,
    .probe_folder = probe_folder,
    .read_header = read_header,
    .free_plan = free_plan,
    .read = vvi_dicom_read,
    .mappable = mappable,
};
