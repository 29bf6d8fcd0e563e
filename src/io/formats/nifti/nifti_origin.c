/* From NIfTI to NIfTI: what the header of the file says from which the samples come, and the result's info does not.
 * Its spaces stay what they were wherever the samples went in them; what it says of values goes when these are others.
 */
#include "core/job.h"
#include "core/vec.h"
#include "grid/field.h"
#include "io/formats/nifti/nifti.h"
#include "io/placement.h"
#include <math.h>
#include <string.h>

/* Far below what matters, and above what rounding to floats does. */
#define SAME_VOXELS 1e-4

enum { ALIGNED = 2 }; /* "aligned to something": the code of a space that nobody has named */

/* Of a file of NIfTI, alone or as time steps, its header is the first that is kept. */
static bool is_nifti(const vv_file *file)
{
    int32_t code;
    size_t n;
    return file && vvi_notes_kept(vvi_file_notes(file), 0, &code, &n) && code == VVI_NIFTI_KEPT_HEADER;
}

static const void *find_header(const vv_file *file, size_t *n_out)
{
    int32_t code = 0;
    const void *bytes = NULL;
    const vv_notes *notes = vvi_file_notes(file);
    for (size_t i = 0; (bytes = vvi_notes_kept(notes, i, &code, n_out)) != NULL; i++)
        if (code == VVI_NIFTI_KEPT_WORDS || (i == 0 && code == VVI_NIFTI_KEPT_HEADER))
            return bytes;
    return NULL;
}

/* The header of the origin, or of what that was made of; false when there is none. */
static bool unpack_origin(vvi_nifti *old, const vv_write_options *options)
{
    size_t n = 0;
    bool pair;
    const void *bytes = options->origin ? find_header(options->origin, &n) : NULL;
    *old = (vvi_nifti){0};
    if (!bytes || n < VVI_NIFTI1_BYTES)
        return false;
    old->version = vvi_nifti_version(bytes, n, &old->swapped, &pair);
    if (!old->version || n < (old->version == 1 ? VVI_NIFTI1_BYTES : VVI_NIFTI2_BYTES))
        return false;
    vvi_nifti_unpack(old, bytes);
    return true;
}

static bool same_place(const vv_grid *a, const vv_grid *b)
{
    return memcmp(a->dims, b->dims, sizeof a->dims) == 0 && strcmp(a->unit, b->unit) == 0 &&
           vvi_placement_distance(&a->index_to_world, &b->index_to_world, a->dims) <= 1e-6 * vv_grid_voxel(b);
}

/* Which index axis runs along the line that axis `was` ran along, and -1 in *sign if against it; -1: none. */
static int axis_along(int *sign, const vv_grid *now, const vv_grid *then, int was)
{
    const vv_vec3 p = then->index_to_world.axis[was];
    for (int i = 0; i < 3; i++) {
        const vv_vec3 q = now->index_to_world.axis[i];
        const double along = vvi_dot(p, q);
        *sign = along < 0 ? -1 : 1;
        if (fabs(along) >= (1 - 1e-9) * vvi_length(p) * vvi_length(q))
            return i;
    }
    return -1;
}

/* Axes are numbered from 1 there, two bits each; 0 where nobody knows. */
static int moved_dim_info(int dim_info, const vv_grid *now, const vv_grid *then)
{
    int out = dim_info & ~0x3f, sign;
    for (int shift = 0; shift < 6; shift += 2) {
        const int was = dim_info >> shift & 3, is = was ? axis_along(&sign, now, then, was - 1) : 0;
        if (is < 0)
            return 0;
        out |= (was ? is + 1 : 0) << shift;
    }
    return out;
}

/* The qform for what has become of the samples: steps from index to index are the same in both spaces. */
static bool move_qform(vv_affine *q, const vv_grid *now, const vv_grid *then)
{
    vv_affine back;
    if (strcmp(now->unit, then->unit) != 0 || !vv_affine_invert(&back, then->index_to_world))
        return false;
    *q = vv_affine_compose(*q, vv_affine_compose(back, now->index_to_world));
    return vvi_affine_finite(q);
}

static void take_place(vvi_nifti *h, const vvi_nifti *old, const vv_grid *now, const vv_grid *then)
{
    const vv_affine *p = &now->index_to_world;
    vv_affine s, q;
    const bool s_good = vvi_nifti_sform(&s, old), q_good = vvi_nifti_qform(&q, old);
    if (!s_good && !q_good) { /* others put it where they did before as long as it stands where it stood */
        const int code = old->sform_code <= 0 && old->qform_code <= 0 && same_place(now, then) ? 0 : ALIGNED;
        h->sform_code = code;
        h->qform_code = h->qform_code ? code : 0;
    } else if (!s_good) {
        h->sform_code = h->qform_code ? 0 : old->qform_code;
        h->qform_code = h->qform_code ? old->qform_code : 0;
    } else {
        h->sform_code = old->sform_code;
        const bool one = !q_good || vvi_placement_distance(&s, &q, then->dims) <= SAME_VOXELS * vv_grid_voxel(then);
        if (!one && move_qform(&q, now, then))
            h->qform_code = vvi_nifti_set_qform(h, &q) ? old->qform_code : 0;
        else if (!one || !q_good)
            h->qform_code = 0;
        else
            h->qform_code = vvi_nifti_set_qform(h, p) ? old->qform_code : 0;
    }
}

static void take_time(vvi_nifti *h, const vvi_nifti *old, const vv_field_info *info)
{
    if (!info->frame_unit[0])
        h->xyzt_units |= old->xyzt_units & 0x38;
    if (info->frame_step == 0)
        h->pixdim[4] = old->pixdim[4];
    h->toffset = old->toffset + (info->frame > 0 && isfinite(old->pixdim[4]) ? info->frame * old->pixdim[4] : 0);
}

/* Acquired the other way round. */
static int reversed_code(int code)
{
    static const int codes[] = {0, 2, 1, 4, 3, 6, 5};
    return code >= 0 && code <= 6 ? codes[code] : 0;
}

/* Slices of an axis that may run backwards, or begin elsewhere. False: the header cannot say when they were acquired.
 */
static bool move_slices(vvi_nifti *h, const vvi_nifti *old, const vv_grid *now, const vv_grid *then)
{
    const int was = (old->dim_info >> 4 & 3) - 1;
    int sign;
    const int is = was < 0 ? -1 : axis_along(&sign, now, then, was);
    vv_affine back;
    if (is < 0 || strcmp(now->unit, then->unit) != 0 || !vv_affine_invert(&back, then->index_to_world) ||
        fabs(vv_grid_spacing(now, is) / vv_grid_spacing(then, was) - 1) > SAME_VOXELS)
        return false;
    const vv_vec3 first = vv_affine_point(back, now->index_to_world.origin);
    const double at = was == 0 ? first.x : was == 1 ? first.y : first.z, whole = floor(at + 0.5);
    const double a = (old->slice_start - whole) * sign, b = (old->slice_end - whole) * sign;
    const double last = (double)(now->dims[is] - 1), start = fmin(a, b), end = fmax(a, b);
    const bool cut = start < 0 || end > last, in_order = old->slice_code == 1 || old->slice_code == 2;
    if (fabs(at - whole) > 1e-2 || (cut && !in_order) || end < 0 || start > last)
        return false;
    h->slice_start = fmax(start, 0);
    h->slice_end = fmin(end, last);
    h->slice_duration = old->slice_duration;
    h->slice_code = sign < 0 ? reversed_code(old->slice_code) : old->slice_code;
    return true;
}

static bool tells_slices(const vvi_nifti *h)
{
    return h->slice_code != 0 || h->slice_duration != 0 || h->slice_start != 0 || h->slice_end != 0;
}

/* False: what it says of the order of slices is lost. */
static bool take_slices(vvi_nifti *h, const vvi_nifti *old, const vv_grid *now, const vv_grid *then)
{
    h->dim_info = moved_dim_info(old->dim_info, now, then);
    if (!tells_slices(old))
        return true;
    if (fabs(old->slice_start) > INT32_MAX || fabs(old->slice_end) > INT32_MAX)
        return false;
    if (!same_place(now, then))
        return move_slices(h, old, now, then);
    h->slice_start = old->slice_start;
    h->slice_end = old->slice_end;
    h->slice_duration = old->slice_duration;
    h->slice_code = old->slice_code;
    return true;
}

static void take_values(vvi_nifti *h, const vvi_nifti *old, const vv_field_info *info, const vv_field_info *then)
{
    h->cal_min = old->cal_min;
    h->cal_max = old->cal_max;
    if (info->meaning != then->meaning || info->components != then->components)
        return;
    h->intent_code = old->intent_code;
    memcpy(h->intent_p, old->intent_p, sizeof h->intent_p);
}

bool vvi_nifti_take_origin(vvi_nifti *h, const vv_field_info *info, const vv_write_options *options)
{
    vvi_nifti old;
    if (!unpack_origin(&old, options))
        return true;
    const vv_field_info *then = vv_file_info(options->origin);
    vv_grid now_grid, then_grid;
    vvi_nifti_file_grid(&now_grid, &info->grid);
    vvi_nifti_file_grid(&then_grid, &then->grid);
    h->version = h->version > old.version ? h->version : old.version; /* the second holds what the first does not */
    take_place(h, &old, &now_grid, &then_grid);
    take_time(h, &old, info);
    const bool slices = take_slices(h, &old, &now_grid, &then_grid);
    if (!options->new_values)
        take_values(h, &old, info, then);
    if (old.description[0])
        memcpy(h->description, old.description, sizeof h->description);
    memcpy(h->aux_file, old.aux_file, sizeof h->aux_file);
    return slices;
}

static bool is_own_intent(int code)
{
    return code != 0 && code != VVI_NIFTI_INTENT_LABEL && code != VVI_NIFTI_INTENT_VECTOR &&
           code != VVI_NIFTI_INTENT_RGB && code != VVI_NIFTI_INTENT_RGBA;
}

void vvi_nifti_log_lost(const char *path, const char *format, const vv_write_options *options, vv_job *job)
{
    static const char *const spaces[] = {"Talairach", "MNI152", "a template"};
    vvi_text t = {0};
    vvi_nifti old;
    if (vvi_nifti_is_kept_by(format) || !unpack_origin(&old, options))
        return;
    const bool by_sform = old.sform_code > 0;
    const int code = by_sform ? old.sform_code : old.qform_code;
    if (code > ALIGNED)
        vvi_text_printf(&t, ", %s %d (%s)", by_sform ? "sform_code" : "qform_code", code,
                        code <= 5 ? spaces[code - 3] : "unknown");
    if (is_own_intent(old.intent_code) && !options->new_values)
        vvi_text_printf(&t, ", intent_code %d", old.intent_code);
    if (old.description[0] && strcmp(old.description, "VolVis") != 0)
        vvi_text_printf(&t, ", descrip '%s'", old.description);
    if (old.aux_file[0])
        vvi_text_printf(&t, ", aux_file '%s'", old.aux_file);
    if (tells_slices(&old))
        vvi_text_add(&t, ", the order of slices in time");
    if (t.n > 0 && !t.bad) {
        vvi_text_clean(t.s);
        vvi_log(job, VV_LOG_WARNING, "io",
                "%s: the format %s cannot keep what the NIfTI header says: %s; write .nii.gz to keep all", path, format,
                t.s + 2);
    }
    vvi_text_free(&t);
}

/* Extensions ------------------------------------------------------------------------------------------------------- */

static bool holds(const char *bytes, size_t n, const char *word)
{
    const size_t m = strlen(word);
    for (const char *at = bytes; n >= m && (at = memchr(at, word[0], n - m + 1 - (size_t)(at - bytes))) != NULL; at++)
        if (memcmp(at, word, m) == 0)
            return true;
    return false;
}

static bool names_labels(const char *bytes, size_t n)
{
    return holds(bytes, n, "<LabelTable") || holds(bytes, n, "VALUE_LABEL_DTABLE");
}

/* Whether the result is one of the labels of its origin: the same table still tells them. */
static bool same_labels(const vv_field_info *info, const vv_write_options *options)
{
    size_t n;
    const vv_label *then = vv_file_labels(options->origin, &n);
    return !options->new_values && n > 0 && info->meaning == VV_MEANING_LABEL && options->labels == then &&
           options->n_labels == n;
}

void vvi_nifti_take_extensions(vvi_text *out, const vvi_nifti *h, const vv_field_info *info,
                               const vv_write_options *options, bool *labels_out)
{
    int32_t code;
    size_t n;
    const char *bytes;
    *labels_out = false;
    if (!is_nifti(options->origin))
        return;
    const bool same = same_labels(info, options);
    const vv_notes *notes = vvi_file_notes(options->origin);
    for (size_t i = 1; (bytes = vvi_notes_kept(notes, i, &code, &n)) != NULL; i++) {
        const bool labels = names_labels(bytes, n);
        *labels_out |= labels && same;
        if (!labels || same)
            vvi_nifti_add_extension(out, h, code, bytes, n);
    }
}
