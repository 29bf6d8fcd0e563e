/* Faces are projected by homogeneous edges (after Olano and Greer 1997): the sign of v_i x v_j . d says on which side
 * of an edge the ray d passes, also where a face reaches behind the eye, so that nothing is clipped before the divide.
 * Every bound is taken over a whole cell, which makes coverage and depths safe for all rays through it. */
#include "render/march/parc.h"
#include "core/job.h"
#include "core/memory.h"
#include "scene/lens.h"
#include <math.h>

enum { BAND = 32, POLL = 1024 };

/* Boxes are made larger by this, in voxels: beyond any rounding of the places that kernels sample at. */
#define GROW (1.0 / 64)
/* Half a cell, and some of a pixel more. */
#define HALF (0.5 + 0.02 / (1 << VVI_PARC_SHIFT))

/* A place in index space on the image: (x, y, w) homogeneous in cells, z its depth. w is z in perspective, else 1. */
typedef struct point {
    double x, y, w, z;
} point;

typedef struct projection {
    vvi_parc *parc;
    const vvi_boxes *boxes;
    const vvi_parc_view *view;
    point base, axis[3];
    vv_vec3 from; /* index space: the eye; parallel: the direction of view */
    bool parallel;
    float slack; /* of depths: what floats lose */
    vv_job *job;
} projection;

/* One face on the image. */
typedef struct face {
    double edge[4][3];        /* (x, y, 1) is inside where all are >= 0 */
    double plane[3], key;     /* depth at (x, y): key / plane . (x, y, 1); parallel: plane . (x, y, 1) */
    double z_min, z_max;      /* of its corners */
    double x_min, x_max;      /* of its corners, in cells */
    int32_t row_min, row_max; /* rows of cells */
    bool front;
} face;

static point add(point a, point b, double s)
{
    return (point){a.x + s * b.x, a.y + s * b.y, a.w + s * b.w, a.z + s * b.z};
}

static double larger(double a, double b)
{
    return a > b ? a : b;
}

static double smaller(double a, double b)
{
    return a < b ? a : b;
}

/* Projection ---------------------------------------------------------------------------------------------------- */

/* A world vector (w: 0) or a place from the eye (w: 1). */
static point project(const vvi_parc_view *view, vv_vec3 v, double w)
{
    const vv_lens *lens = view->lens;
    const double cells = 1.0 / (1 << VVI_PARC_SHIFT), x = vvi_dot(v, lens->right), y = vvi_dot(v, lens->up);
    point p = {.z = vvi_dot(v, lens->forward)};
    p.w = lens->parallel ? w : p.z;
    p.x = (x / lens->half_width + p.w) * view->width / 2 * cells;
    p.y = ((p.w - y / lens->half_height) * view->height / 2 - p.w * view->top) * cells;
    return p;
}

static vv_status open_projection(projection *p)
{
    const vvi_parc_view *view = p->view;
    const vv_affine m = view->index_to_world;
    vv_affine back;
    if (!vv_affine_invert(&back, m))
        return vv_fail(VV_E_ARGUMENT, "place: flattens the volume; give it a scale other than 0");
    p->parallel = view->lens->parallel;
    p->from = p->parallel ? vv_affine_vector(back, view->lens->forward) : vv_affine_point(back, view->lens->eye);
    p->base = project(view, vvi_sub(m.origin, view->lens->eye), 1);
    double extent = 0;
    p->parc->origin = p->base.z;
    for (int a = 0; a < 3; a++) {
        p->axis[a] = project(view, m.axis[a], 0);
        p->parc->origin += p->axis[a].z * (view->lo[a] + view->hi[a]) / 2;
        extent += fabs(p->axis[a].z) * (view->hi[a] - view->lo[a] + 1);
    }
    p->slack = (float)(1e-6 * extent);
    return VV_OK;
}

/* Where boxes number `at` begin and end on an axis, grown. */
static void box_bounds(double out[2], const projection *p, int32_t at, int axis)
{
    const double side = 1 << p->boxes->shift, before = p->view->before;
    out[0] = (at == 0 ? p->view->lo[axis] : at * side - before) - GROW;
    out[1] = (at + 1 == p->boxes->n[axis] ? p->view->hi[axis] : (at + 1) * side - before) + GROW;
}

/* Faces --------------------------------------------------------------------------------------------------------- */

static void set_edge(double out[3], const point *a, const point *b, double sign)
{
    out[0] = sign * (a->y * b->w - a->w * b->y);
    out[1] = sign * (a->w * b->x - a->x * b->w);
    out[2] = sign * (a->x * b->y - a->y * b->x);
}

/* Depths of its corners, and the part of the image that they span: all of it where one is not before the eye. */
static void find_extent(face *f, const projection *p, const point corner[4])
{
    double y_min = INFINITY, y_max = -INFINITY, w_min = INFINITY;
    f->z_min = f->x_min = INFINITY;
    f->z_max = f->x_max = -INFINITY;
    for (int i = 0; i < 4; i++) {
        const point *c = &corner[i];
        const double x = c->x / c->w, y = c->y / c->w;
        f->z_min = smaller(f->z_min, c->z);
        f->z_max = larger(f->z_max, c->z);
        w_min = smaller(w_min, c->w);
        f->x_min = smaller(f->x_min, x);
        f->x_max = larger(f->x_max, x);
        y_min = smaller(y_min, y);
        y_max = larger(y_max, y);
    }
    if (!p->parallel && !(w_min > 1e-9 * fabs(f->z_max))) {
        f->x_min = y_min = 0;
        f->x_max = p->parc->width;
        y_max = p->parc->height;
    }
    const double top = p->parc->height;
    f->row_min = (int32_t)smaller(larger(floor(y_min + 0.5 - HALF), 0), top);
    f->row_max = (int32_t)larger(smaller(floor(y_max + HALF - 0.5), top - 1), -1);
}

/* Depth over the image: of the plane through a corner and two sides from it. */
static void find_plane(face *f, const projection *p, const point *at, const point *u, const point *v)
{
    const double n[3] = {u->y * v->z - u->z * v->y, u->z * v->x - u->x * v->z, u->x * v->y - u->y * v->x};
    const double key = n[0] * at->x + n[1] * at->y + n[2] * at->z;
    f->key = fabs(key);
    if (p->parallel) {
        f->plane[0] = -n[0] / n[2];
        f->plane[1] = -n[1] / n[2];
        f->plane[2] = key / n[2];
        return;
    }
    for (int i = 0; i < 3; i++)
        f->plane[i] = key < 0 ? -n[i] : n[i];
}

/* The face of a box on one side of an axis; false where it is seen from its edge, and so not at all. */
static bool project_face(face *f, const projection *p, double bounds[3][2], int axis, int side)
{
    const int a = (axis + 1) % 3, b = (axis + 2) % 3;
    const double at = bounds[axis][side], from[3] = {p->from.x, p->from.y, p->from.z};
    const double outwards = side ? 1 : -1;
    const double facing = p->parallel ? -from[axis] * outwards : (from[axis] - at) * outwards;
    if (facing == 0)
        return false;
    f->front = facing > 0;
    point corner[4], u = {0}, v = {0};
    corner[0] = add(add(add(p->base, p->axis[axis], at), p->axis[a], bounds[a][0]), p->axis[b], bounds[b][0]);
    u = add(u, p->axis[a], bounds[a][1] - bounds[a][0]);
    v = add(v, p->axis[b], bounds[b][1] - bounds[b][0]);
    corner[1] = add(corner[0], u, 1);
    corner[2] = add(corner[1], v, 1);
    corner[3] = add(corner[0], v, 1);
    find_extent(f, p, corner);
    /* which way round the corners go, seen from the eye: by the ray through the middle of the face */
    const point middle = add(corner[0], add(u, v, 1), 0.5);
    set_edge(f->edge[0], &corner[0], &corner[1], 1);
    const double turn = f->edge[0][0] * middle.x + f->edge[0][1] * middle.y + f->edge[0][2] * middle.w;
    if (turn == 0)
        return false;
    for (int i = 0; i < 4; i++)
        set_edge(f->edge[i], &corner[i], &corner[(i + 1) % 4], turn > 0 ? 1 : -1);
    find_plane(f, p, &corner[0], &u, &v);
    return true;
}

/* Buffer -------------------------------------------------------------------------------------------------------- */

/* The cells of a row that a face may touch: both at once, before rounding. */
static bool row_span(double span[2], const face *f, double y)
{
    span[0] = f->x_min - HALF;
    span[1] = f->x_max + HALF;
    for (int i = 0; i < 4; i++) {
        const double *e = f->edge[i];
        const double rest = e[1] * y + e[2] + (fabs(e[0]) + fabs(e[1])) * HALF;
        if (e[0] > 0)
            span[0] = larger(span[0], -rest / e[0]);
        else if (e[0] < 0)
            span[1] = smaller(span[1], -rest / e[0]);
        else if (rest < 0)
            return false;
    }
    return span[0] <= span[1];
}

/* The smallest (front) or largest depth that the face can have in the cell around (x, y). */
static double cell_depth(const face *f, bool parallel, double slope, double x, double y)
{
    const double at = f->plane[0] * x + f->plane[1] * y + f->plane[2];
    double z = f->front ? at - slope : at + slope;
    if (!parallel) { /* a larger divisor is a smaller depth */
        const double divisor = f->front ? at + slope : at - slope;
        z = divisor > 0 ? f->key / divisor : f->front ? f->z_min : f->z_max;
    }
    return smaller(larger(z, f->z_min), f->z_max);
}

static void draw_row(const face *f, const projection *p, int32_t row)
{
    vvi_parc *parc = p->parc;
    double span[2];
    if (!row_span(span, f, row + 0.5))
        return;
    /* columns whose centres x + 0.5 lie in the span */
    const int32_t first = (int32_t)smaller(larger(ceil(span[0] - 0.5), 0), parc->width);
    const int32_t last = (int32_t)larger(smaller(floor(span[1] - 0.5), parc->width - 1), -1);
    const double slope = (fabs(f->plane[0]) + fabs(f->plane[1])) * HALF;
    float *near = parc->near + (size_t)row * (size_t)parc->width, *far = parc->far + (near - parc->near);
    for (int32_t x = first; x <= last; x++) {
        const float z = (float)(cell_depth(f, p->parallel, slope, x + 0.5, row + 0.5) - parc->origin);
        if (f->front)
            near[x] = z - p->slack < near[x] ? z - p->slack : near[x];
        else
            far[x] = z + p->slack > far[x] ? z + p->slack : far[x];
    }
}

static void draw_box(const projection *p, size_t index, int32_t top, int32_t bottom)
{
    int32_t at[3];
    double bounds[3][2];
    const unsigned outer = p->boxes->outer[index];
    if (!outer)
        return;
    vvi_box_place(at, p->boxes, p->boxes->kept[index]);
    for (int a = 0; a < 3; a++)
        box_bounds(bounds[a], p, at[a], a);
    for (int i = 0; i < VVI_BOX_FACES; i++) {
        face f;
        if (!(outer >> i & 1) || !project_face(&f, p, bounds, i / 2, i % 2))
            continue;
        const int32_t first = f.row_min > top ? f.row_min : top;
        const int32_t last = f.row_max < bottom - 1 ? f.row_max : bottom - 1;
        for (int32_t row = first; row <= last; row++)
            draw_row(&f, p, row);
    }
}

/* Item: all boxes on BAND rows of the buffer. */
static vv_status draw_band(void *scratch, void *shared, size_t index)
{
    const projection *p = shared;
    const int32_t top = (int32_t)index * BAND;
    const int32_t bottom = top + BAND < p->parc->height ? top + BAND : p->parc->height;
    (void)scratch;
    for (size_t i = 0; i < p->boxes->n_kept; i++) {
        const vv_status st = i % POLL ? VV_OK : vvi_job_poll(p->job);
        if (st != VV_OK)
            return st;
        draw_box(p, i, top, bottom);
    }
    return VV_OK;
}

/* Whether the eye is in a kept box, grown: then every ray begins in it. */
static bool eye_inside(const projection *p)
{
    const double eye[3] = {p->from.x, p->from.y, p->from.z}, side = 1 << p->boxes->shift;
    int64_t at[3][2];
    if (p->parallel)
        return false; /* each ray has its own origin: near depths before them say the same */
    for (int a = 0; a < 3; a++) {
        if (!(eye[a] >= p->view->lo[a] - GROW && eye[a] <= p->view->hi[a] + GROW))
            return false;
        for (int i = 0; i < 2; i++) {
            const double box = floor((eye[a] + p->view->before + (i ? GROW : -GROW)) / side);
            at[a][i] = (int64_t)smaller(larger(box, 0), p->boxes->n[a] - 1);
        }
    }
    for (int c = 0; c < 8; c++)
        if (vvi_boxes_has(p->boxes, at[0][c & 1], at[1][c >> 1 & 1], at[2][c >> 2]))
            return true;
    return false;
}

vv_status vvi_parc_init(vvi_parc *out, const vvi_boxes *boxes, const vvi_parc_view *view, vv_job *job)
{
    *out = (vvi_parc){
        .width = vvi_parc_cells(view->width), .height = vvi_parc_cells(view->rows), .forward = view->lens->forward};
    projection p = {.parc = out, .boxes = boxes, .view = view, .job = job};
    size_t n = 0;
    vv_status st = vvi_mul_size(&n, (size_t)out->width, (size_t)out->height);
    if (st == VV_OK)
        st = open_projection(&p);
    if (st == VV_OK && !(out->near = vvi_alloc(job, 2 * n * sizeof *out->near, VVI_MEM_SCRATCH)))
        st = vv_fail_memory(2 * n * sizeof *out->near);
    if (st == VV_OK) {
        const float nearest = eye_inside(&p) ? -INFINITY : INFINITY;
        out->far = out->near + n;
        for (size_t i = 0; i < n; i++) {
            out->near[i] = nearest;
            out->far[i] = -INFINITY;
        }
        const vvi_work work = {.item = draw_band};
        st = vvi_parallel_for(job, &work, &p, (size_t)(out->height + BAND - 1) / BAND);
    }
    if (st != VV_OK)
        vvi_parc_finish(out);
    return st;
}

void vvi_parc_finish(vvi_parc *parc)
{
    vvi_free(parc->near);
    *parc = (vvi_parc){0};
}
