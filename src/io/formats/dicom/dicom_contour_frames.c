/* Which contours are seen in which slice, and a segmentation's frames of that. */
#include "core/memory.h"
#include "io/formats/dicom/dicom_contours.h"
#include "io/notes.h"
#include "io/placement.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define SAME_MM 0.02 /* planes of one slice, with the decimals that files keep */

typedef struct planes {
    vvi_dicom_image *image;
    vvi_dicom_structures *s;
    double first, step; /* of the slices, along the normal */
    double usual;       /* distance of all planes; 0: it cannot be said */
    double *depth, *distances;
    size_t *begin; /* of the planes of one region, in the contours */
    size_t n, room;
    uint8_t *seen; /* contours */
    vv_job *job;
} planes;

static int by_region(const void *a, const void *b)
{
    const vvi_dicom_contour *p = a, *q = b;
    if (p->roi != q->roi)
        return p->roi < q->roi ? -1 : 1;
    if (p->depth != q->depth)
        return p->depth < q->depth ? -1 : 1;
    if (p->n_points != q->n_points)
        return p->n_points < q->n_points ? -1 : 1;
    const int sign = memcmp(p->at, q->at, 3 * p->n_points * sizeof *p->at);
    return sign ? sign : (p->number > q->number) - (p->number < q->number);
}

static bool same_contour(const vvi_dicom_contour *a, const vvi_dicom_contour *b)
{
    return a->roi == b->roi && a->n_points == b->n_points && memcmp(a->at, b->at, 3 * a->n_points * sizeof *a->at) == 0;
}

/* What stands across the slices cannot be drawn in one; a contour that is there twice would undo itself. */
static vv_status leave_out(planes *p, vv_notes *notes)
{
    vvi_dicom_structures *s = p->s;
    size_t to = 0, n_across = 0, n_again = 0, n_bent = 0;
    double bent = 0;
    qsort(s->contour, s->n_contours, sizeof *s->contour, by_region);
    for (size_t i = 0; i < s->n_contours; i++) {
        vvi_dicom_contour *c = &s->contour[i];
        const bool across = c->off > 0.5 * p->step + SAME_MM, again = to > 0 && same_contour(&s->contour[to - 1], c);
        if (across || again) {
            n_across += across;
            n_again += !across && again;
            vvi_free(c->at);
            continue;
        }
        if (c->off > fmax(0.05 * p->step, 0.05)) {
            n_bent++;
            bent = fmax(bent, c->off);
        }
        s->contour[to++] = *c;
    }
    s->n_contours = to;
    vv_status st = VV_OK;
    if (n_across > 0)
        st = vvi_notes_warn(notes, "%zu contours cross the slices: left out", n_across);
    if (st == VV_OK && n_bent > 0)
        st = vvi_notes_warn(notes, "%zu contours are not flat, by up to %.3g mm; they are shown as if they were",
                            n_bent, bent);
    if (st == VV_OK && n_again > 0)
        st = vvi_notes_warn(notes, "%zu contours appear twice, and are shown once", n_again);
    return st;
}

/* The distance of all planes, whatever is drawn in them. */
static double usual_of(planes *p, size_t first, size_t end)
{
    size_t n;
    for (size_t i = first; i < end; i++)
        p->depth[i - first] = p->s->contour[i].depth;
    const double usual = vvi_dicom_usual_distance(p->depth, end - first, p->distances, &n);
    return n >= 2 ? usual : 0;
}

static int ascending(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double usual_of_all(planes *p)
{
    size_t n;
    for (size_t i = 0; i < p->s->n_contours; i++)
        p->depth[i] = p->s->contour[i].depth;
    qsort(p->depth, p->s->n_contours, sizeof *p->depth, ascending);
    const double usual = vvi_dicom_usual_distance(p->depth, p->s->n_contours, p->distances, &n);
    return n >= 2 ? usual : 0;
}

static vv_status add_frame(planes *p, double slice, size_t plane)
{
    vvi_dicom_structures *s = p->s;
    if (s->n_frames == p->room) {
        const size_t room = p->room ? 2 * p->room : 64;
        void *grown = vvi_realloc(p->job, s->frame, room * sizeof *s->frame, VVI_MEM_MODEL);
        if (!grown)
            return vv_fail_memory(room * sizeof *s->frame);
        s->frame = grown;
        p->room = room;
    }
    const size_t first = p->begin[plane], n = p->begin[plane + 1] - first;
    const double number = p->image->segment[s->contour[first].roi].number;
    s->frame[s->n_frames++] = (vvi_dicom_drawing){(int32_t)slice, (uint16_t)number, first, n};
    memset(p->seen + first, 1, n);
    return VV_OK;
}

static double slice_at(const planes *p, size_t plane)
{
    return (p->s->contour[p->begin[plane]].depth - p->first) / p->step;
}

/* Each slice shows the nearest plane: one that is nearest to it of all slices, or one no farther away than half of what
 * the planes of the region usually are apart, between the first and the last. */
static vv_status add_region(planes *p, size_t from, size_t end)
{
    const double own = usual_of(p, from, end), reach = 0.51 * (own > 0 ? own : p->usual) / p->step;
    vv_status st = VV_OK;
    p->n = 0;
    for (size_t i = from; i < end; i++)
        if (i == from || p->s->contour[i].depth - p->s->contour[p->begin[p->n - 1]].depth > SAME_MM)
            p->begin[p->n++] = i;
    p->begin[p->n] = end;
    const double lo = fmax(floor(slice_at(p, 0) + 0.5), 0);
    const double hi = fmin(floor(slice_at(p, p->n - 1) + 0.5), (double)(p->s->grid.dims[2] - 1));
    size_t plane = 0;
    for (double k = lo; k <= hi && st == VV_OK; k++) {
        while (plane + 1 < p->n && fabs(slice_at(p, plane + 1) - k) < fabs(slice_at(p, plane) - k))
            plane++;
        const double at = slice_at(p, plane);
        if (floor(at + 0.5) == k || fabs(at - k) <= reach)
            st = add_frame(p, k, plane);
    }
    return st;
}

static int by_slice(const void *a, const void *b)
{
    const vvi_dicom_drawing *p = a, *q = b;
    if (p->slice != q->slice)
        return p->slice < q->slice ? -1 : 1;
    return (p->label > q->label) - (p->label < q->label);
}

static bool reaches_out(const vvi_dicom_structures *s, const vvi_dicom_contour *c)
{
    for (size_t i = 0; i < c->n_points; i++) {
        const vv_vec3 at = vv_affine_point(s->to_index, (vv_vec3){c->at[3 * i], c->at[3 * i + 1], c->at[3 * i + 2]});
        if (at.x < -0.5 || at.y < -0.5 || at.x > (double)s->grid.dims[0] - 0.5 || at.y > (double)s->grid.dims[1] - 0.5)
            return true;
    }
    return false;
}

static vv_status tell(const planes *p, vv_notes *notes)
{
    size_t n_out = 0, n_between = 0;
    const vvi_dicom_structures *s = p->s;
    for (size_t i = 0; i < s->n_contours; i++) {
        const double k = (s->contour[i].depth - p->first) / p->step;
        const bool beyond = k < -0.5 || k >= (double)s->grid.dims[2] - 0.5;
        n_out += beyond || reaches_out(s, &s->contour[i]);
        n_between += !beyond && !p->seen[i];
    }
    vv_status st = VV_OK;
    if (n_out > 0)
        st = vvi_notes_warn(notes, "%zu of %zu contours extend beyond the grid: the rest is cut off", n_out,
                            s->n_contours);
    if (st == VV_OK && n_between > 0)
        st = vvi_notes_warn(notes, "%zu contours lie between slices that have nearer ones: left out", n_between);
    return st;
}

static vv_status find_all(planes *p, vv_notes *notes)
{
    vvi_dicom_structures *s = p->s;
    vv_status st = leave_out(p, notes);
    if (st != VV_OK)
        return st;
    p->usual = usual_of_all(p);
    for (size_t i = 0, end; i < s->n_contours && st == VV_OK; i = end) {
        for (end = i + 1; end < s->n_contours && s->contour[end].roi == s->contour[i].roi;)
            end++;
        st = add_region(p, i, end);
    }
    if (s->n_frames > 0)
        qsort(s->frame, s->n_frames, sizeof *s->frame, by_slice);
    return st == VV_OK ? tell(p, notes) : st;
}

static vv_status use_grid(planes *p, const char *name)
{
    vvi_dicom_structures *s = p->s;
    const vv_affine *m = &s->grid.index_to_world;
    const vv_vec3 a = m->axis[0], b = m->axis[1];
    vv_vec3 n = {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
    const double length = vvi_length(n);
    if (!(length > 0) || !vv_affine_invert(&s->to_index, *m))
        return vv_fail_at(VV_E_FORMAT, name, NULL, "its contours would be drawn on a grid without extent");
    n = (vv_vec3){n.x / length, n.y / length, n.z / length};
    p->step = m->axis[2].x * n.x + m->axis[2].y * n.y + m->axis[2].z * n.z;
    if (p->step < 0) {
        n = (vv_vec3){-n.x, -n.y, -n.z};
        p->step = -p->step;
    }
    s->normal = n;
    p->first = m->origin.x * n.x + m->origin.y * n.y + m->origin.z * n.z;
    vvi_dicom_find_depths(s, n);
    return VV_OK;
}

vv_status vvi_dicom_find_frames_drawn(vvi_dicom_image *image, const char *name, vv_notes *notes, vv_job *job)
{
    planes p = {.image = image, .s = image->structures, .job = job};
    const size_t n = p.s->n_contours + 2;
    p.depth = vvi_alloc(job, n * sizeof *p.depth, VVI_MEM_SCRATCH);
    p.distances = vvi_alloc(job, n * sizeof *p.distances, VVI_MEM_SCRATCH);
    p.begin = vvi_alloc(job, n * sizeof *p.begin, VVI_MEM_SCRATCH);
    p.seen = vvi_alloc_zeroed(job, n, VVI_MEM_SCRATCH);
    vv_status st =
        p.depth && p.distances && p.begin && p.seen ? use_grid(&p, name) : vv_fail_memory(n * sizeof *p.depth);
    if (st == VV_OK)
        st = find_all(&p, notes);
    vvi_free(p.seen);
    vvi_free(p.begin);
    vvi_free(p.distances);
    vvi_free(p.depth);
    return st;
}

vv_status vvi_dicom_draw(vvi_dicom_plan *plan, vvi_dicom_stack *stack, vv_source *source, vv_notes *notes, vv_job *job)
{
    const int32_t which = stack->slice[0].image;
    vvi_dicom_image *image = &plan->image[which];
    const char *name = vvi_source_name(source);
    bool found = false;
    vv_status st = vvi_dicom_contours_read(image, source, notes, job);
    if (st == VV_OK)
        st = vvi_dicom_series_grid(&image->structures->grid, &found, plan, image, source, notes, job);
    if (st == VV_OK && !found)
        st = vvi_dicom_own_grid(&image->structures->grid, image, name, notes, job);
    if (st == VV_OK)
        st = vvi_dicom_find_frames_drawn(image, name, notes, job);
    if (st != VV_OK)
        return st;
    const vvi_dicom_structures *s = image->structures;
    void *grown = vvi_realloc(job, stack->slice, (s->n_frames + 1) * sizeof *stack->slice, VVI_MEM_MODEL);
    if (!grown)
        return vv_fail_memory((s->n_frames + 1) * sizeof *stack->slice);
    stack->slice = grown;
    for (size_t i = 0; i < s->n_frames + 1; i++)
        stack->slice[i] = (vvi_dicom_slice){which, (int32_t)i, 0};
    stack->n = s->n_frames;
    stack->room = s->n_frames + 1;
    image->n_frames = (int64_t)s->n_frames;
    image->number[VVI_DICOM_COLUMNS] = (double)s->grid.dims[0];
    image->number[VVI_DICOM_ROWS] = (double)s->grid.dims[1];
    return VV_OK;
}
