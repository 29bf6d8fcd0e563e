/* MINC 2: HDF5 with a volume under /minc-2.0, placed in the space of the patient, its numbers scaled to a range that
 * may differ from slice to slice. https://en.wikibooks.org/wiki/MINC/Reference/MINC2.0_File_Format_Reference */
#include "core/memory.h"
#include "core/text.h"
#include "io/cf_axes.h"
#include "io/formats/hdf5/hdf5.h"
#include "io/placement.h"
#include "io/scan.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define IMAGE "/minc-2.0/image/0/image"
#define SLICES_MOST ((size_t)1 << 20)

bool vvi_minc_is(const vvi_h5 *h5)
{
    return vvi_h5_has(h5, IMAGE);
}

/* Axes ------------------------------------------------------------------------------------------------------------ */

static vv_status choose_roles(vvi_h5_plan *plan, const vvi_h5 *h5, hid_t data)
{
    char text[VVI_H5_TEXT], *rest = text, *name;
    int n = 0;
    if (!vvi_h5_text(text, sizeof text, data, "dimorder"))
        return vv_fail_at(VV_E_FORMAT, h5->name, IMAGE, "has no attribute 'dimorder'");
    while ((name = strsep(&rest, ",")) != NULL && n < plan->set.rank) {
        const char role = strcmp(name, "vector_dimension") == 0 ? 'c' : vvi_cf_role_named(name);
        if (!role || strchr(plan->roles, role))
            return vv_fail_at(VV_E_UNSUPPORTED, h5->name, IMAGE,
                              "has an axis '%.40s'; xspace, yspace, zspace, time and "
                              "vector_dimension are known, each once",
                              name);
        plan->roles[n++] = role;
    }
    if (n < plan->set.rank)
        return vv_fail_at(VV_E_FORMAT, h5->name, IMAGE, "has %d axes but 'dimorder' names %d", plan->set.rank, n);
    return VV_OK;
}

/* An axis whose samples lie unevenly keeps their places: from the first to the last in even steps. */
static void even_step(double *start, double *step, hid_t dimension, int64_t n)
{
    const hid_t space = H5Iget_type(dimension) == H5I_DATASET ? H5Dget_space(dimension) : -1;
    const hssize_t n_places = space >= 0 ? H5Sget_simple_extent_npoints(space) : 0;
    if (space >= 0)
        H5Sclose(space);
    double *place = n_places == n && n > 1 && n < (int64_t)SLICES_MOST ? vvi_calloc((size_t)n, sizeof *place) : NULL;
    if (place && vvi_h5_table(place, (size_t)n, dimension)) {
        *start = place[0];
        *step = (place[n - 1] - place[0]) / (double)(n - 1);
    }
    free(place);
}

static vv_status place_axis(vv_field_info *info, const vvi_h5 *h5, char role, int64_t n, vv_notes *notes)
{
    char path[64], text[VVI_H5_TEXT];
    vv_vec3 *axis = &info->grid.index_to_world.axis[role - 'x'], *origin = &info->grid.index_to_world.origin;
    double start = 0, step = 1, cosine[3] = {role == 'x', role == 'y', role == 'z'};
    snprintf(path, sizeof path, "/minc-2.0/dimensions/%cspace", role);
    const hid_t dimension = vvi_h5_object(h5, path);
    vv_status st = VV_OK;
    if (dimension < 0)
        return vvi_notes_warn(notes, "%s is missing; its samples are taken to be 1 mm apart", path);
    vvi_h5_numbers(&start, 1, dimension, "start");
    vvi_h5_numbers(&step, 1, dimension, "step");
    double given[3];
    if (vvi_h5_numbers(given, 3, dimension, "direction_cosines") == 3)
        memcpy(cosine, given, sizeof cosine);
    if (vvi_h5_text(text, sizeof text, dimension, "spacing") && strncmp(text, "irregular", 9) == 0) {
        even_step(&start, &step, dimension, n);
        st = vvi_notes_warn(notes, "the samples along %cspace are unevenly spaced; they are shown in even steps of %g",
                            role, step);
    }
    if (vvi_h5_text(text, sizeof text, dimension, "units"))
        vvi_unit_name(info->grid.unit, text, strlen(text));
    H5Oclose(dimension);
    *axis = (vv_vec3){step * cosine[0], step * cosine[1], step * cosine[2]};
    origin->x += start * cosine[0];
    origin->y += start * cosine[1];
    origin->z += start * cosine[2];
    return st;
}

static vv_status place(vv_field_info *info, const vvi_h5_plan *plan, const vvi_h5 *h5, vv_notes *notes)
{
    vv_affine *a = &info->grid.index_to_world;
    vv_status st = VV_OK;
    info->grid.space = VV_SPACE_RAS;
    snprintf(info->grid.unit, sizeof info->grid.unit, "mm");
    a->origin = (vv_vec3){0, 0, 0};
    for (int i = 0; i < plan->set.rank && st == VV_OK; i++)
        if (strchr("xyz", plan->roles[i]))
            st = place_axis(info, h5, plan->roles[i], plan->dims[i], notes);
    bool good = vvi_affine_finite(a);
    for (int i = 0; i < 3; i++)
        good = good && vvi_length(a->axis[i]) > 0;
    if (st == VV_OK && !good)
        st = vv_fail_at(VV_E_FORMAT, h5->name, "/minc-2.0/dimensions",
                        "a start, step or cosine is not a finite number or is 0");
    return st;
}

static void take_time(vv_field_info *info, const vvi_h5 *h5)
{
    char text[64];
    const hid_t time = vvi_h5_object(h5, "/minc-2.0/dimensions/time");
    if (time < 0)
        return;
    double step;
    if (vvi_h5_numbers(&step, 1, time, "step") == 1 && isfinite(step))
        info->frame_step = step;
    if (vvi_h5_text(text, sizeof text, time, "units"))
        vvi_unit_name(info->frame_unit, text, strlen(text));
    H5Oclose(time);
}

/* Values ---------------------------------------------------------------------------------------------------------- */

/* Doubles of image-min or image-max, yours to free(); their axes are the first of the image's, or none. */
static double *read_ends(size_t *n, int *rank, const vvi_h5_set *image, const vvi_h5 *h5, const char *path)
{
    hsize_t dims[VVI_H5_RANK];
    double *out = NULL;
    const hid_t data = vvi_h5_object(h5, path);
    const hid_t space = data >= 0 && H5Iget_type(data) == H5I_DATASET ? H5Dget_space(data) : -1;
    *n = 1;
    *rank = space >= 0 ? H5Sget_simple_extent_ndims(space) : -1;
    bool fits = *rank >= 0 && *rank <= 2 && *rank < image->rank && H5Sget_simple_extent_dims(space, dims, NULL) >= 0;
    for (int a = 0; a < *rank && fits; a++) {
        fits = dims[a] == image->dims[a] && *n <= SLICES_MOST / dims[a];
        *n *= (size_t)dims[a];
    }
    if (fits)
        out = vvi_calloc(*n, sizeof *out);
    if (out && !vvi_h5_table(out, *n, data)) {
        free(out);
        out = NULL;
    }
    if (space >= 0)
        H5Sclose(space);
    if (data >= 0)
        H5Oclose(data);
    return out;
}

static void find_valid_range(double range[2], const vvi_h5_set *set, hid_t data)
{
    double given[2];
    const int bits = 8 * (int)vv_type_bytes(set->type);
    const bool is_signed = set->type % 2 == 1; /* u8, i8, u16, i16, ... */
    range[0] = is_signed ? -ldexp(1, bits - 1) : 0;
    range[1] = ldexp(1, is_signed ? bits - 1 : bits) - 1;
    if (vvi_h5_numbers(given, 2, data, "valid_range") == 2 && given[1] > given[0] && isfinite(given[1] - given[0]))
        memcpy(range, given, sizeof given);
}

/* Slices of one scale keep their integers; of several they become floats as they are read. */
static vv_status use_ends(vv_field_info *info, vvi_h5_plan *plan, const double *lo, const double *hi, size_t n,
                          vv_job *job)
{
    const double *range = plan->valid_range;
    bool varies = false;
    for (size_t i = 1; i < n; i++)
        varies = varies || lo[i] != lo[0] || hi[i] != hi[0];
    if (!varies) {
        const double scale = (hi[0] - lo[0]) / (range[1] - range[0]);
        if (scale != 0 && isfinite(scale) && isfinite(lo[0])) {
            info->value_scale = scale;
            info->value_offset = lo[0] - range[0] * scale;
        }
        return VV_OK;
    }
    plan->slice_ends = vvi_alloc(job, 2 * n * sizeof *plan->slice_ends, VVI_MEM_MODEL);
    if (!plan->slice_ends)
        return vv_fail_memory(2 * n * sizeof *plan->slice_ends);
    for (size_t i = 0; i < n; i++) {
        plan->slice_ends[2 * i] = lo[i];
        plan->slice_ends[2 * i + 1] = hi[i];
    }
    vvi_h5_adapt(plan, &plan->set);
    return VV_OK;
}

static vv_status take_values(vv_field_info *info, vvi_h5_plan *plan, vvi_h5 *h5, hid_t data, vv_notes *notes)
{
    size_t n, n_lo;
    int rank;
    vv_status st = VV_OK;
    if (vv_type_is_float(plan->set.type))
        return VV_OK;
    find_valid_range(plan->valid_range, &plan->set, data);
    double *hi = read_ends(&n, &rank, &plan->set, h5, "/minc-2.0/image/0/image-max");
    double *lo = read_ends(&n_lo, &plan->n_slice_axes, &plan->set, h5, "/minc-2.0/image/0/image-min");
    if (lo && hi && n == n_lo && rank == plan->n_slice_axes)
        st = use_ends(info, plan, lo, hi, n, h5->job);
    else
        st = vvi_notes_warn(notes, "has no image-min and image-max that fit; stored numbers are shown");
    free(lo);
    free(hi);
    return st;
}

void vvi_minc_scale(const vvi_h5_plan *plan, float *slab, const hsize_t *start, const hsize_t *count)
{
    const double *range = plan->valid_range;
    const bool two = plan->n_slice_axes == 2;
    const hsize_t n_inner = two ? count[1] : 1;
    uint64_t row = 1;
    for (int a = two ? 2 : 1; a < plan->set.rank; a++)
        row *= count[a];
    for (hsize_t i = 0; i < count[0]; i++)
        for (hsize_t j = 0; j < n_inner; j++, slab += row) {
            const hsize_t slice = two ? (start[0] + i) * plan->set.dims[1] + start[1] + j : start[0] + i;
            const double *ends = plan->slice_ends + 2 * slice;
            const double scale = (ends[1] - ends[0]) / (range[1] - range[0]);
            for (uint64_t k = 0; k < row; k++)
                slab[k] = (float)((fmin(fmax(slab[k], range[0]), range[1]) - range[0]) * scale + ends[0]);
        }
}

vv_status vvi_minc_header(vv_field_info *info, vvi_h5_plan *plan, vvi_h5 *h5, vv_notes *notes)
{
    snprintf(plan->set.path, sizeof plan->set.path, IMAGE);
    plan->kind = VVI_H5_MINC;
    const hid_t data = vvi_h5_object(h5, IMAGE), root = vvi_h5_object(h5, "/minc-2.0");
    vv_status st = vvi_h5_describe(&plan->set, h5, data);
    if (st == VV_OK)
        st = vvi_h5_check(&plan->set, h5, data);
    if (st == VV_OK)
        st = choose_roles(plan, h5, data);
    for (int a = 0; a < VVI_H5_RANK; a++)
        plan->dims[a] = (int64_t)plan->set.dims[a];
    if (st == VV_OK)
        st = take_values(info, plan, h5, data, notes);
    if (st == VV_OK)
        st = vvi_h5_lay_out(info, plan, h5->name);
    if (st == VV_OK)
        st = place(info, plan, h5, notes);
    take_time(info, h5);
    if (st == VV_OK && root >= 0)
        st = vvi_h5_note_attributes(notes, root);
    H5Oclose(data);
    if (root >= 0)
        H5Oclose(root);
    return st;
}
