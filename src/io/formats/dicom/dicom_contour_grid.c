/* A grid for contours that have none: slices in their planes, samples close enough to tell what they enclose. */
#include "core/memory.h"
#include "io/formats/dicom/dicom_contours.h"
#include "io/notes.h"
#include "io/placement.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define SAME_MM 0.02 /* planes of one slice, with the decimals that files keep */
#define FLAT_MM 0.5
#define SLICES_MOST 4096
#define SAMPLES_ACROSS 256 /* at least, of what is not larger than that in mm and not far thinner than slices */
#define SAMPLES_LEAST 32
#define SAMPLES_A_SLICE 8 /* at most, in the distance of slices: rays take steps of the smallest spacing */
#define SAMPLES_MOST 1024
#define VOXELS_MOST 1.3e8

/* Directions ------------------------------------------------------------------------------------------------------ */

static vv_vec3 cross(vv_vec3 a, vv_vec3 b)
{
    return (vv_vec3){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

static double dot(vv_vec3 a, vv_vec3 b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

static vv_vec3 sum(vv_vec3 a, vv_vec3 b, double scale)
{
    return (vv_vec3){a.x + b.x * scale, a.y + b.y * scale, a.z + b.z * scale};
}

static vv_vec3 times(vv_vec3 a, double scale)
{
    return (vv_vec3){a.x * scale, a.y * scale, a.z * scale};
}

/* From the first point, so that what lies far away loses no digits (Newell). */
vv_vec3 vvi_dicom_contour_normal(const vvi_dicom_contour *c)
{
    const vv_vec3 from = {c->at[0], c->at[1], c->at[2]};
    vv_vec3 normal = {0, 0, 0}, last = {0, 0, 0};
    for (size_t i = 1; i < c->n_points; i++) {
        const double *p = c->at + 3 * i;
        const vv_vec3 here = sum((vv_vec3){p[0], p[1], p[2]}, from, -1);
        normal = sum(normal, cross(last, here), 1);
        last = here;
    }
    return normal;
}

bool vvi_dicom_contours_normal(vv_vec3 *out, const vvi_dicom_structures *s)
{
    double most = 0;
    for (size_t i = 0; i < s->n_contours; i++) {
        const vv_vec3 normal = vvi_dicom_contour_normal(&s->contour[i]);
        const double length = vvi_length(normal);
        if (length > most) {
            most = length;
            *out = times(normal, 1 / length);
        }
    }
    return most > 0;
}

void vvi_dicom_find_depths(vvi_dicom_structures *s, vv_vec3 normal)
{
    for (size_t i = 0; i < s->n_contours; i++) {
        vvi_dicom_contour *c = &s->contour[i];
        double total = 0;
        for (size_t p = 0; p < c->n_points; p++)
            total += dot((vv_vec3){c->at[3 * p], c->at[3 * p + 1], c->at[3 * p + 2]}, normal);
        c->depth = total / (double)c->n_points;
        c->off = 0;
        for (size_t p = 0; p < c->n_points; p++)
            c->off =
                fmax(c->off, fabs(dot((vv_vec3){c->at[3 * p], c->at[3 * p + 1], c->at[3 * p + 2]}, normal) - c->depth));
    }
}

/* As images lie that show the body in this direction: rows to its left, or to its back; columns to its back, or down.
 */
static void find_axes(vv_affine *out, vv_vec3 normal)
{
    const double x = fabs(normal.x), y = fabs(normal.y), z = fabs(normal.z);
    const bool sagittal = x > y && x > z, coronal = !sagittal && y > z;
    const double along = sagittal ? normal.x : coronal ? -normal.y : normal.z;
    const vv_vec3 row = sagittal ? (vv_vec3){0, -1, 0} : (vv_vec3){-1, 0, 0};
    normal = times(normal, along < 0 ? -1 : 1);
    out->axis[0] = sum(row, normal, -dot(row, normal));
    out->axis[0] = times(out->axis[0], 1 / vvi_length(out->axis[0]));
    out->axis[1] = cross(normal, out->axis[0]);
    out->axis[2] = normal;
}

/* Distances of planes --------------------------------------------------------------------------------------------- */

static int ascending(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static bool is_about(double distance, double least)
{
    return distance <= 1.01 * least + 0.005;
}

double vvi_dicom_usual_distance(const double *depth, size_t n, double *distances, size_t *n_out)
{
    size_t m = 0, best = 0, n_best = 0;
    double last = n > 0 ? depth[0] : 0, total = 0;
    for (size_t i = 1; i < n; i++)
        if (depth[i] - last > SAME_MM) {
            distances[m++] = depth[i] - last;
            last = depth[i];
        }
    qsort(distances, m, sizeof *distances, ascending);
    for (size_t i = 0, end = 0; i < m; i++) {
        while (end < m && is_about(distances[end], distances[i]))
            end++;
        if (end - i > n_best) {
            best = i;
            n_best = end - i;
        }
    }
    for (size_t i = 0; i < n_best; i++)
        total += distances[best + i];
    *n_out = m;
    return n_best > 0 ? total / (double)n_best : 0;
}

/* The grid -------------------------------------------------------------------------------------------------------- */

typedef struct extent {
    double lo[2], hi[2]; /* along rows and columns */
    double *depth;       /* n of them, sorted */
    size_t n;
    double anchor, step; /* a plane, and the distance of slices */
    double first, last;  /* slices, from the anchor */
} extent;

static vv_status find_extent(extent *out, const vvi_dicom_structures *s, const vv_affine *axes, vv_job *job)
{
    *out = (extent){.lo = {INFINITY, INFINITY}, .hi = {-INFINITY, -INFINITY}};
    const size_t bytes = (s->n_contours + 1) * sizeof *out->depth;
    if (!(out->depth = vvi_alloc(job, bytes, VVI_MEM_SCRATCH)))
        return vv_fail_memory(bytes);
    for (size_t i = 0; i < s->n_contours; i++) {
        const vvi_dicom_contour *c = &s->contour[i];
        if (c->off > FLAT_MM)
            continue;
        out->depth[out->n++] = c->depth;
        for (size_t p = 0; p < c->n_points; p++)
            for (int a = 0; a < 2; a++) {
                const double at = dot((vv_vec3){c->at[3 * p], c->at[3 * p + 1], c->at[3 * p + 2]}, axes->axis[a]);
                out->lo[a] = fmin(out->lo[a], at);
                out->hi[a] = fmax(out->hi[a], at);
            }
    }
    qsort(out->depth, out->n, sizeof *out->depth, ascending);
    return VV_OK;
}

/* Slices go through the planes that lie as far apart as most do; others are near one of them. */
static vv_status find_slices(extent *e, double thickness, double fallback, vv_job *job)
{
    size_t n;
    double *distances = vvi_alloc(job, e->n * sizeof *distances, VVI_MEM_SCRATCH);
    if (!distances)
        return vv_fail_memory(e->n * sizeof *distances);
    e->step = vvi_dicom_usual_distance(e->depth, e->n, distances, &n);
    vvi_free(distances);
    e->anchor = e->depth[0];
    if (n == 0)
        e->step = thickness > 0 ? thickness : fallback;
    const double whole = e->depth[e->n - 1] - e->depth[0];
    e->step = fmax(e->step, whole / (SLICES_MOST - 1));
    double last = e->depth[0];
    for (size_t i = 1; i < e->n; i++)
        if (e->depth[i] - last > SAME_MM) {
            if (fabs(e->depth[i] - last - e->step) <= 0.01 * e->step + 0.005) {
                e->anchor = last;
                break;
            }
            last = e->depth[i];
        }
    e->first = floor((e->depth[0] - e->anchor) / e->step + 0.5);
    e->last = floor((e->depth[e->n - 1] - e->anchor) / e->step + 0.5);
    return VV_OK;
}

/* 0.01, 0.02, 0.05, 0.1, ... */
static double round_spacing(int step)
{
    static const double digits[] = {1, 2, 5};
    const int tens = step / 3;
    return 0.01 * digits[step % 3] * pow(10, tens);
}

/* 1 mm, less where that would be few samples, more where it would be too many or far smaller than the distance of
 * slices. */
static double find_spacing(const extent *e)
{
    const double most = fmax(e->hi[0] - e->lo[0], e->hi[1] - e->lo[1]);
    const double fine = fmax(most / SAMPLES_ACROSS, fmin(e->step / SAMPLES_A_SLICE, most / SAMPLES_LEAST));
    int step = 0;
    while (round_spacing(step + 1) <= fmin(1, fine))
        step++;
    const double area = (e->hi[0] - e->lo[0]) * (e->hi[1] - e->lo[1]), slices = e->last - e->first + 1;
    while (most / round_spacing(step) > SAMPLES_MOST || area * slices / pow(round_spacing(step), 2) > VOXELS_MOST)
        step++;
    return round_spacing(step);
}

/* Samples at odd halves of the spacing: contours are often drawn along whole ones. */
static void place(vv_grid *out, const vv_affine *axes, const extent *e, double spacing)
{
    vv_affine *m = &out->index_to_world;
    m->origin = times(axes->axis[2], e->anchor + e->first * e->step);
    for (int a = 0; a < 2; a++) {
        const double first = floor(e->lo[a] / spacing) - 1;
        out->dims[a] = (int64_t)(floor(e->hi[a] / spacing) + 2 - first);
        m->axis[a] = times(axes->axis[a], spacing);
        m->origin = sum(m->origin, axes->axis[a], (first + 0.5) * spacing);
    }
    out->dims[2] = (int64_t)(e->last - e->first + 1);
    m->axis[2] = times(axes->axis[2], e->step);
    out->space = VV_SPACE_RAS;
    snprintf(out->unit, sizeof out->unit, "mm");
}

static vv_status tell(const vv_grid *grid, const extent *e, double thickness, vv_notes *notes)
{
    char text[128];
    snprintf(text, sizeof text, "%g x %g x %g mm, of the contours themselves", vv_grid_spacing(grid, 0),
             vv_grid_spacing(grid, 1), vv_grid_spacing(grid, 2));
    vv_status st = vvi_notes_add(notes, "grid", text);
    if (st == VV_OK && e->depth[e->n - 1] - e->depth[0] <= SAME_MM && !(thickness > 0))
        st = vvi_notes_warn(notes, "all contours lie in one plane; its slice is taken to be %g mm thick", e->step);
    return st;
}

vv_status vvi_dicom_own_grid(vv_grid *out, const vvi_dicom_image *image, const char *name, vv_notes *notes, vv_job *job)
{
    vvi_dicom_structures *s = image->structures;
    vv_affine axes;
    vv_vec3 normal;
    extent e;
    if (!vvi_dicom_contours_normal(&normal, s))
        return vv_fail_at(VV_E_FORMAT, name, NULL,
                          "is a structure set (RTSTRUCT) of %zu ROIs without closed contours that enclose anything; it "
                          "cannot be shown",
                          image->n_segments);
    find_axes(&axes, normal);
    vvi_dicom_find_depths(s, axes.axis[2]);
    vv_status st = find_extent(&e, s, &axes, job);
    if (st == VV_OK && e.n == 0)
        st = vv_fail_at(VV_E_FORMAT, name, NULL,
                        "is a structure set (RTSTRUCT) whose contours do not lie in planes; it cannot be shown");
    if (st == VV_OK)
        st = find_slices(&e, s->thickness, 1, job);
    if (st == VV_OK) {
        place(out, &axes, &e, find_spacing(&e));
        st = tell(out, &e, s->thickness, notes);
    }
    vvi_free(e.depth);
    return st;
}
