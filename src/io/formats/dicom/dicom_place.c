/* Where a stack lies: LPS millimetres of the file to RAS, the step from slice to slice from where they really are. */
#include "io/formats/dicom/dicom_contours.h"
#include "io/notes.h"
#include "io/placement.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

#define TILT_DEGREES 0.1 /* less is the rounding of positions */

static vv_vec3 ras(const double v[3], double scale)
{
    return (vv_vec3){-v[0] * scale, -v[1] * scale, v[2] * scale};
}

static vv_vec3 sum(vv_vec3 a, vv_vec3 b, double scale)
{
    return (vv_vec3){a.x + b.x * scale, a.y + b.y * scale, a.z + b.z * scale};
}

static double dot(vv_vec3 a, vv_vec3 b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

static vv_vec3 cross(vv_vec3 a, vv_vec3 b)
{
    return (vv_vec3){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

static bool is_step(double v)
{
    return isfinite(v) && v > 0;
}

const vvi_dicom_image *vvi_dicom_first(const vvi_dicom_plan *plan, size_t *index_out)
{
    size_t i = 0;
    while (plan->slice[i].image < 0)
        i++;
    if (index_out)
        *index_out = i;
    return &plan->image[plan->slice[i].image];
}

/* The distance of rows and of columns, else of the detector's elements, else none. */
static void plane_spacing(double out[2], bool *known, const vvi_dicom_image *image, const vvi_dicom_values *v)
{
    const double *detector = &image->number[VVI_DICOM_DETECTOR_SPACING];
    *known = true;
    if (is_step(v->spacing[0]) && is_step(v->spacing[1])) {
        memcpy(out, v->spacing, 2 * sizeof *out);
    } else if (is_step(detector[0]) && is_step(detector[1])) {
        memcpy(out, detector, 2 * sizeof *out);
    } else {
        out[0] = out[1] = 1;
        *known = false;
    }
}

static double slice_step(const vvi_dicom_values *v, const double spacing[2])
{
    const double between = fabs(v->between);
    return is_step(between) ? between : is_step(v->thickness) ? v->thickness : fmin(spacing[0], spacing[1]);
}

/* Images that do not say where they lie: as they are, downwards as in the file. */
static vv_status place_plain(vv_field_info *info, const vvi_dicom_image *image, const vvi_dicom_values *v,
                             vv_notes *notes)
{
    double spacing[2];
    bool known;
    plane_spacing(spacing, &known, image, v);
    double step = slice_step(v, spacing);
    const bool stacked = info->grid.dims[2] > 1;
    if (image->offset && image->n_offset > 1 && is_step(fabs(image->offset[1] - image->offset[0])))
        step = fabs(image->offset[1] - image->offset[0]);
    info->grid.index_to_world =
        (vv_affine){{{spacing[1], 0, 0}, {0, spacing[0], 0}, {0, 0, known ? step : 1}}, {0, 0, 0}};
    info->grid.space = VV_SPACE_PLAIN;
    snprintf(info->grid.unit, sizeof info->grid.unit, known ? "mm" : "voxels");
    if (!stacked || !known)
        return VV_OK;
    return vvi_notes_warn(notes, "does not give its position: its slices are taken to be %g mm apart", step);
}

static vv_vec3 position_of(const vvi_dicom_plan *plan, const vvi_dicom_slice *s, vv_vec3 normal)
{
    const vvi_dicom_image *image = &plan->image[s->image];
    const vv_vec3 p = ras(vvi_dicom_frame_values(image, s->frame)->position, 1);
    if (!image->offset || (size_t)s->frame >= image->n_offset || isnan(image->offset[s->frame]))
        return p;
    return sum(p, normal, image->offset[s->frame] - image->offset[0]);
}

/* How far the worst slice lies beside the line from the first to the last, in its plane. */
static double sideways(const vvi_dicom_plan *plan, const vv_field_info *info, vv_vec3 first, vv_vec3 normal)
{
    double most = 0;
    for (int64_t k = 0; k < info->grid.dims[2]; k++) {
        if (plan->slice[k].image < 0)
            continue;
        const vv_vec3 there = sum(first, info->grid.index_to_world.axis[2], (double)k);
        const vv_vec3 off = sum(position_of(plan, &plan->slice[k], normal), there, -1);
        most = fmax(most, vvi_length(sum(off, normal, -dot(off, normal))));
    }
    return most;
}

static vv_status note_tilt(const vv_grid *grid, vv_vec3 normal, double beside, double spacing, vv_notes *notes)
{
    char text[64];
    const vv_vec3 step = grid->index_to_world.axis[2];
    const double angle = acos(fmin(1, dot(step, normal) / vvi_length(step))) * 180 / 3.14159265358979323846;
    vv_status st = VV_OK;
    if (angle > TILT_DEGREES) {
        snprintf(text, sizeof text, "%.4g degrees: slices are shifted against each other", angle);
        st = vvi_notes_add(notes, "tilt", text);
    }
    if (st == VV_OK && beside > 0.1 * spacing)
        st = vvi_notes_warn(notes, "slices are up to %.3g mm away from the straight line along which they are shown",
                            beside);
    return st;
}

/* The slices that are there of the first frame, first and last. */
static void find_ends(const vvi_dicom_plan *plan, int64_t n, int64_t *first, int64_t *last)
{
    *first = 0;
    *last = n - 1;
    while (*first < n - 1 && plan->slice[*first].image < 0)
        ++*first;
    while (*last > *first && plan->slice[*last].image < 0)
        --*last;
}

static vv_status place_in_body(vv_field_info *info, const vvi_dicom_plan *plan, const vvi_dicom_image *image,
                               const vvi_dicom_values *v, vv_notes *notes)
{
    double spacing[2];
    bool known;
    int64_t first, last;
    vv_affine *m = &info->grid.index_to_world;
    plane_spacing(spacing, &known, image, v);
    find_ends(plan, info->grid.dims[2], &first, &last);
    m->axis[0] = ras(v->row, spacing[1]);
    m->axis[1] = ras(v->column, spacing[0]);
    vv_vec3 normal = cross(ras(v->row, 1), ras(v->column, 1));
    const double length = vvi_length(normal);
    normal = sum((vv_vec3){0, 0, 0}, normal, 1 / length);
    m->origin = position_of(plan, &plan->slice[first], normal);
    m->axis[2] = sum((vv_vec3){0, 0, 0}, normal, slice_step(v, spacing));
    if (last > first) {
        const vv_vec3 way = sum(position_of(plan, &plan->slice[last], normal), m->origin, -1);
        m->axis[2] = sum((vv_vec3){0, 0, 0}, way, 1 / (double)(last - first));
    }
    m->origin = sum(m->origin, m->axis[2], -(double)first);
    info->grid.space = VV_SPACE_RAS;
    snprintf(info->grid.unit, sizeof info->grid.unit, "mm");
    const double beside = last > first ? sideways(plan, info, m->origin, normal) : 0;
    return note_tilt(&info->grid, normal, beside, fmin(spacing[0], spacing[1]), notes);
}

/* Directions at right angles and of length 1, to what decimals keep. */
static bool is_oriented(const vvi_dicom_values *v)
{
    double rr = 0, cc = 0, rc = 0, sums = 0;
    for (int a = 0; a < 3; a++) {
        rr += v->row[a] * v->row[a];
        cc += v->column[a] * v->column[a];
        rc += v->row[a] * v->column[a];
        sums += v->position[a];
    }
    return isfinite(sums) && fabs(rr - 1) < 0.05 && fabs(cc - 1) < 0.05 && fabs(rc) < 0.05;
}

vv_status vvi_dicom_place(vv_field_info *info, const vvi_dicom_plan *plan, const char *name, vv_notes *notes)
{
    size_t index;
    const vvi_dicom_image *image = vvi_dicom_first(plan, &index);
    const vvi_dicom_values *v = vvi_dicom_frame_values(image, plan->slice[index].frame);
    if (image->structures) {
        info->grid = image->structures->grid;
        return VV_OK;
    }
    vv_status st = is_oriented(v) ? place_in_body(info, plan, image, v, notes) : place_plain(info, image, v, notes);
    if (st == VV_OK && !vvi_affine_finite(&info->grid.index_to_world))
        st = vv_fail_at(VV_E_FORMAT, name, NULL, "its positions or spacings are too large to compute with");
    return st;
}
