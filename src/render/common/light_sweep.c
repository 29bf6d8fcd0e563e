/* Light from slice to slice of a grid. */
#include "core/job.h"
#include "core/memory.h"
#include "core/vec.h"
#include "render/common/light_volume.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* A way to the light, and how much comes from there. */
typedef struct way {
    vv_vec3 to; /* world, length 1 */
    double weight;
} way;

/* What one worker adds up: ways over one grid, into cells of its own. */
typedef struct task {
    const way *ways;
    size_t n_ways;
    double inverse_radius; /* 0: nothing is born again */
    float *out;
} task;

/* exp(-x) for x >= 0, within 1e-4 where it matters; plain arithmetic, so that compilers do several at once. */
static inline float decay(float x)
{
    const float y = x * 0.125f;
    const float e = 1 / (1 + y * (1 + y * (0.5f + y * (1.0f / 6 + y * (1.0f / 24)))));
    const float e2 = e * e, e4 = e2 * e2;
    return e4 * e4;
}

/* One way as it runs through the grid: u and v are the axes of a slice, u the one with the smaller stride. */
typedef struct sweep {
    int axis[3]; /* u, v and across the slices */
    size_t stride[3];
    int32_t n[3];
    bool backwards; /* the light comes from high numbers */
    int shift[2];   /* cells from a cell to the first of those that its light comes from, -1 or 0 */
    float fraction[2];
    float half; /* half the way from slice to slice, world length */
    float inverse_radius, weight;
} sweep;

static void set_shift(sweep *s, int i, double cells)
{
    s->shift[i] = cells < 0 ? -1 : 0;
    s->fraction[i] = (float)fmin(fmax(cells - s->shift[i], 0), 1);
}

static void plan(sweep *s, const vvi_light_grid *g, const vv_affine *to_cell, const way *w, double inverse_radius)
{
    const vv_vec3 d = vv_affine_vector(*to_cell, w->to);
    const double along[3] = {d.x, d.y, d.z};
    const size_t strides[3] = {1, (size_t)g->n[0], (size_t)g->n[0] * (size_t)g->n[1]};
    int major = 2;
    for (int a = 1; a >= 0; a--)
        major = fabs(along[a]) > fabs(along[major]) * (1 + 1e-9) ? a : major;
    const int axes[3] = {major == 0 ? 1 : 0, major == 2 ? 1 : 2, major};
    for (int i = 0; i < 3; i++) {
        s->axis[i] = axes[i];
        s->stride[i] = strides[axes[i]];
        s->n[i] = g->n[axes[i]];
    }
    s->backwards = along[major] > 0;
    for (int i = 0; i < 2; i++)
        set_shift(s, i, along[axes[i]] / fabs(along[major]));
    s->half = (float)(0.5 / fabs(along[major]));
    s->inverse_radius = (float)inverse_radius;
    s->weight = (float)w->weight;
}

/* A line of cells: what arrives in their middles is added to `out`, what leaves them towards the next slice put into
 * `left`. from: the lines of the slice before, two rows of it. */
static void run_line(float *restrict left, float *restrict out, const float *restrict extinction,
                     const float *restrict row0, const float *restrict row1, const sweep *s)
{
    const float fu = s->fraction[0], fv = s->fraction[1], r = s->inverse_radius;
    const float w00 = (1 - fu) * (1 - fv), w10 = fu * (1 - fv), w01 = (1 - fu) * fv, w11 = fu * fv;
    const size_t step = s->stride[0];
    for (int32_t u = 0; u < s->n[0]; u++) {
        const float k = extinction[(size_t)u * step] + r;
        const float through = decay(k * s->half), born = (1 - through) * r / (k + 1e-30f);
        const float in = w00 * row0[u] + w10 * row0[u + 1] + w01 * row1[u] + w11 * row1[u + 1];
        const float here = in * through + born;
        out[(size_t)u * step] += s->weight * here;
        left[u] = here * through + born;
    }
}

/* Slices have a rim of one cell, into which all light falls. */
static void run_sweep(float *out, float *slice[2], const vvi_light_grid *g, const sweep *s)
{
    const size_t row = (size_t)s->n[0] + 2, cells = row * ((size_t)s->n[1] + 2);
    for (int i = 0; i < 2; i++)
        for (size_t c = 0; c < cells; c++)
            slice[i][c] = 1;
    for (int32_t k = 0; k < s->n[2]; k++) {
        const int32_t at = s->backwards ? s->n[2] - 1 - k : k;
        const float *before = slice[k % 2];
        float *next = slice[1 - k % 2];
        for (int32_t v = 0; v < s->n[1]; v++) {
            const float *rows = before + (size_t)(v + 1 + s->shift[1]) * row + 1 + s->shift[0];
            const size_t first = (size_t)at * s->stride[2] + (size_t)v * s->stride[1];
            run_line(next + (size_t)(v + 1) * row + 1, out + first, g->extinction + first, rows, rows + row, s);
        }
    }
}

typedef struct tasks {
    const vvi_light_grid *grid;
    vv_affine to_cell;
    const task *task;
    vv_job *job;
} tasks;

static vv_status run_task(void *scratch, void *shared, size_t index)
{
    const tasks *all = shared;
    const task *t = &all->task[index];
    const int32_t *n = all->grid->n;
    const size_t side = (size_t)(n[0] > n[1] ? n[0] : n[1]) + 2, other = (size_t)(n[1] > n[2] ? n[1] : n[2]) + 2;
    const size_t cells = side * other;
    (void)scratch;
    float *slices = vvi_alloc(all->job, 2 * cells * sizeof *slices, VVI_MEM_SCRATCH);
    if (!slices)
        return vv_fail_memory(2 * cells * sizeof *slices);
    memset(t->out, 0, vvi_light_cells(n) * sizeof *t->out);
    vv_status st = VV_OK;
    for (size_t i = 0; i < t->n_ways && st == VV_OK; i++) {
        sweep s;
        plan(&s, all->grid, &all->to_cell, &t->ways[i], t->inverse_radius);
        run_sweep(t->out, (float *[2]){slices, slices + cells}, all->grid, &s);
        st = vvi_job_poll(all->job);
    }
    vvi_light_smooth(t->out, n, t->inverse_radius == 0);
    vvi_free(slices);
    return st;
}

static vv_status run_tasks(const vvi_light_grid *grid, const task *list, size_t n, vv_job *job)
{
    static const vvi_work work = {.item = run_task};
    tasks all = {.grid = grid, .task = list, .job = job};
    if (!vv_affine_invert(&all.to_cell, grid->cell_to_world))
        return vv_fail(VV_E_ARGUMENT, "light: the cells of its grid have no volume");
    return n ? vvi_parallel_for(job, &work, &all, n) : VV_OK;
}

/* Ambient --------------------------------------------------------------------------------------------------------- */

enum { SPHERE = 26, GROUPS = 4 }; /* groups: added up one after the other, whoever works on them */

/* Lebedev's rule of degree 7: the ways to the faces, edges and corners of a cube. It is turned, so that none runs along
 * floors and walls, which are mostly at right angles to the axes. */
static void spread_over_sphere(way out[SPHERE])
{
    static const double weight[] = {0, 1.0 / 21, 4.0 / 105, 9.0 / 280};
    static const vv_affine turn = {
        {{2.0 / 3, 2.0 / 3, 1.0 / 3}, {-2.0 / 3, 1.0 / 3, 2.0 / 3}, {1.0 / 3, -2.0 / 3, 2.0 / 3}}, {0, 0, 0}};
    size_t n = 0;
    for (int z = -1; z <= 1; z++)
        for (int y = -1; y <= 1; y++)
            for (int x = -1; x <= 1; x++) {
                const int odd = abs(x) + abs(y) + abs(z);
                if (odd)
                    out[n++] = (way){vvi_scaled(vv_affine_vector(turn, vvi_vec(x, y, z)), 1 / sqrt(odd)), weight[odd]};
            }
}

vv_status vvi_light_ambient(float *out, const vvi_light_grid *grid, double radius, vv_job *job)
{
    const size_t cells = vvi_light_cells(grid->n), bytes = cells * (GROUPS - 1) * sizeof *out;
    way ways[SPHERE];
    task list[GROUPS];
    float *room = vvi_alloc(job, bytes, VVI_MEM_SCRATCH);
    if (!room)
        return vv_fail_memory(bytes);
    spread_over_sphere(ways);
    for (size_t i = 0; i < GROUPS; i++) {
        const size_t first = i * SPHERE / GROUPS, end = (i + 1) * SPHERE / GROUPS;
        list[i] = (task){ways + first, end - first, 1 / radius, i ? room + (i - 1) * cells : out};
    }
    const vv_status st = run_tasks(grid, list, GROUPS, job);
    for (size_t i = 0; i < GROUPS - 1 && st == VV_OK; i++)
        for (size_t c = 0; c < cells; c++)
            out[c] += room[i * cells + c];
    vvi_free(room);
    return st;
}

/* Lamps ----------------------------------------------------------------------------------------------------------- */

enum { DISC = 7 };

/* The middle of a disc, and six places in the middle of the rest of its area. */
static void spread_over_disc(way out[DISC], vv_vec3 to, double disc)
{
    const vv_vec3 other = fabs(to.x) < 0.7 ? vvi_vec(1, 0, 0) : vvi_vec(0, 1, 0);
    vv_vec3 u = vvi_cross(to, other);
    vvi_unit(&u);
    const vv_vec3 v = vvi_cross(to, u);
    const double radius = tan(disc / 2) * sqrt(4.0 / 7);
    for (int i = 0; i < DISC; i++) {
        const double angle = i * 2 * M_PI / (DISC - 1), r = i ? radius : 0;
        out[i].to = vvi_add(to, vvi_add(vvi_scaled(u, r * cos(angle)), vvi_scaled(v, r * sin(angle))));
        vvi_unit(&out[i].to);
        out[i].weight = 1.0 / DISC;
    }
}

/* Points: every cell looks for itself ---------------------------------------------------------------------------- */

typedef struct point_work {
    const vvi_light_grid *grid;
    vv_vec3 at; /* cells */
    float *out;
    vv_job *job;
} point_work;

static double extinction_at(const vvi_light_grid *g, const double p[3])
{
    int32_t i[3];
    double f[3], sum = 0;
    for (int a = 0; a < 3; a++) {
        const double q = fmin(fmax(p[a], 0), g->n[a] - 1);
        i[a] = (int32_t)fmin(q, fmax(g->n[a] - 2, 0));
        f[a] = q - i[a];
    }
    const size_t row = (size_t)g->n[0], slice = row * (size_t)g->n[1];
    const float *c = g->extinction + (size_t)i[2] * slice + (size_t)i[1] * row + (size_t)i[0];
    for (int b = 0; b < 8; b++) {
        const double w = (b & 1 ? f[0] : 1 - f[0]) * (b & 2 ? f[1] : 1 - f[1]) * (b & 4 ? f[2] : 1 - f[2]);
        if (w > 0)
            sum += w * (double)c[(b & 1 ? 1 : 0) + (b & 2 ? row : 0) + (b & 4 ? slice : 0)];
    }
    return sum;
}

/* How much of the way from a cell to the point, of length 1, lies in the grid. */
static double way_inside(const vvi_light_grid *g, const double from[3], const double to[3])
{
    double end = 1;
    for (int a = 0; a < 3; a++) {
        const double d = to[a] - from[a];
        if (d != 0)
            end = fmin(end, ((d > 0 ? g->n[a] - 0.5 : -0.5) - from[a]) / d);
    }
    return end;
}

static float from_point(const point_work *w, const double from[3])
{
    const vvi_light_grid *g = w->grid;
    const double to[3] = {w->at.x, w->at.y, w->at.z};
    const double end = way_inside(g, from, to);
    const double d[3] = {(to[0] - from[0]) * end, (to[1] - from[1]) * end, (to[2] - from[2]) * end};
    const double most = fmax(fmax(fabs(d[0]), fabs(d[1])), fabs(d[2]));
    const int steps = (int)ceil(most);
    const double length = vvi_length(vv_affine_vector(g->cell_to_world, vvi_vec(d[0], d[1], d[2])));
    double depth = 0;
    for (int i = 0; i < steps; i++) {
        const double t = (i + 0.5) / steps;
        depth += extinction_at(g, (double[3]){from[0] + t * d[0], from[1] + t * d[1], from[2] + t * d[2]});
    }
    return steps ? (float)exp(-depth * length / steps) : 1;
}

static vv_status point_slice(void *scratch, void *shared, size_t z)
{
    const point_work *w = shared;
    const int32_t *n = w->grid->n;
    (void)scratch;
    for (int32_t y = 0; y < n[1]; y++)
        for (int32_t x = 0; x < n[0]; x++)
            w->out[(z * (size_t)n[1] + (size_t)y) * (size_t)n[0] + (size_t)x] =
                from_point(w, (double[3]){x, y, (double)z});
    return vvi_job_poll(w->job);
}

static vv_status light_from_point(float *out, const vvi_light_grid *grid, vv_vec3 position, vv_job *job)
{
    static const vvi_work work = {.item = point_slice};
    vv_affine to_cell;
    if (!vv_affine_invert(&to_cell, grid->cell_to_world))
        return vv_fail(VV_E_ARGUMENT, "light: the cells of its grid have no volume");
    point_work w = {.grid = grid, .at = vv_affine_point(to_cell, position), .out = out, .job = job};
    const vv_status st = vvi_parallel_for(job, &work, &w, (size_t)grid->n[2]);
    if (st == VV_OK)
        vvi_light_smooth(out, grid->n, true);
    return st;
}

vv_status vvi_light_lamps(float *const out[], const vvi_light_grid *grid, const vv_lamp *lamps, size_t n_lamps,
                          double disc, vv_job *job)
{
    way ways[VVI_LIGHT_LAMPS][DISC];
    task list[VVI_LIGHT_LAMPS];
    size_t n = 0;
    vv_status st = VV_OK;
    for (size_t i = 0; i < n_lamps && st == VV_OK; i++) {
        if (lamps[i].kind != VV_LIGHT_DIRECTIONAL) {
            st = light_from_point(out[i], grid, lamps[i].position, job);
            continue;
        }
        spread_over_disc(ways[i], vvi_scaled(lamps[i].direction, -1), disc);
        list[n++] = (task){ways[i], DISC, 0, out[i]};
    }
    return st == VV_OK ? run_tasks(grid, list, n, job) : st;
}
