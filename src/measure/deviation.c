/* How far one surface is from another: mean, root mean square, largest. */
#include "core/job.h"
#include "core/memory.h"
#include "core/vec.h"
#include "measure/bvh.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

enum { VERTICES = 2048, TRIANGLES = 2048 };    /* to an item */
enum { DEPTH = 4, QUESTIONS = 8 * TRIANGLES }; /* of dividing triangles to bound distances, in an item */

/* What one item of triangles finds. */
typedef struct found {
    double largest, bound;  /* squared; the bound is no less than any distance in the item */
    vv_vec3 worst;          /* from the origin of a */
    double sum, sum2, sum4; /* of the samples' distances and their powers */
    size_t n;
} found;

/* One way: from a to b. */
typedef struct way {
    const vv_mesh_tree *a, *b;
    const vv_mesh_info *mesh; /* of a */
    vv_vec3 shift;            /* from the origin of a to that of b */
    double density;
    uint64_t seed;
    double enough;     /* squared: bounds need not be better than that */
    double *square;    /* of each vertex of a: squared distance to b, */
    uint32_t *nearest; /* and the triangle there, in the order of b's tree */
    found *found;
} way;

static double random_unit(uint64_t seed, uint64_t triangle, uint64_t index)
{
    uint64_t z = seed * 0x9e3779b97f4a7c15u + triangle * 0xd1b54a32d192ed03u + (index + 1) * 0x8cb92ba72f3d8dd7u;
    for (int i = 0; i < 2; i++) { /* splitmix64 */
        z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9u;
        z = (z ^ z >> 27) * 0x94d049bb133111ebu;
        z ^= z >> 31;
    }
    return (double)(z >> 11) * 0x1p-53;
}

static vv_status vertex_item(void *scratch, void *shared, size_t item)
{
    (void)scratch;
    const way *w = shared;
    const size_t n = w->mesh->n_vertices, end = (item + 1) * VERTICES < n ? (item + 1) * VERTICES : n;
    size_t near = 0;
    for (size_t v = item * VERTICES; v < end; v++) {
        near = vvi_bvh_nearest(&w->square[v], w->b, vvi_add(vvi_bvh_vertex(w->a, v), w->shift), near);
        w->nearest[v] = (uint32_t)near;
    }
    return VV_OK;
}

static void take_if_larger(found *f, double square, vv_vec3 at)
{
    if (square > f->largest) {
        f->largest = square;
        f->worst = at;
    }
}

/* A place of a, from its origin, and what is nearest to it of b. */
typedef struct spot {
    vv_vec3 at;
    double square;
    size_t near; /* in the order of b's tree */
} spot;

static spot spot_at(const way *w, vv_vec3 at, size_t hint)
{
    spot s = {.at = at};
    s.near = vvi_bvh_nearest(&s.square, w->b, vvi_add(at, w->shift), hint);
    return s;
}

/* The largest squared distance of three places to one triangle of b: there is no larger one between them, as the
 * distance to something convex is convex. */
static double bound_by(const way *w, const spot p[3], size_t triangle)
{
    const vvi_triangle t = vvi_bvh_triangle(w->b, triangle);
    double largest = 0;
    for (int i = 0; i < 3; i++) {
        const double square = p[i].near == triangle ? p[i].square : vvi_triangle_square(vvi_add(p[i].at, w->shift), &t);
        largest = square > largest ? square : largest;
    }
    return largest;
}

/* A bound of all distances between three places, made better by dividing while it is more than `w->enough`, for at
 * most *left more questions. */
static double bound_of(found *f, const way *w, const spot p[3], double bound, int depth, size_t *left)
{
    for (int k = 0; k < 3; k++)
        bound = fmin(bound, bound_by(w, p, p[k].near));
    if (bound <= w->enough || depth == 0 || *left < 4)
        return bound;
    *left -= 4;
    const vv_vec3 middle = vvi_scaled(vvi_add(vvi_add(p[0].at, p[1].at), p[2].at), 1 / 3.0);
    const spot inside = spot_at(w, middle, p[0].near);
    take_if_larger(f, inside.square, inside.at);
    bound = fmin(bound, bound_by(w, p, inside.near));
    if (bound <= w->enough)
        return bound;
    spot m[3];
    for (int k = 0; k < 3; k++) {
        m[k] = spot_at(w, vvi_between(p[k].at, p[(k + 1) % 3].at, .5), p[k].near);
        take_if_larger(f, m[k].square, m[k].at);
    }
    const spot parts[4][3] = {{p[0], m[0], m[2]}, {m[0], p[1], m[1]}, {m[2], m[1], p[2]}, {m[0], m[1], m[2]}};
    double largest = 0;
    for (int k = 0; k < 4; k++)
        largest = fmax(largest, bound_of(f, w, parts[k], bound, depth - 1, left));
    return largest;
}

/* Evenly in a triangle. */
static vv_vec3 sample_of(const spot p[3], double u, double v)
{
    const double r = sqrt(u);
    return vvi_add(vvi_add(vvi_scaled(p[0].at, 1 - r), vvi_scaled(p[1].at, r * (1 - v))), vvi_scaled(p[2].at, r * v));
}

static void take_samples(found *f, const way *w, size_t triangle, const spot p[3], size_t *near)
{
    const double area = vvi_length(vvi_cross(vvi_sub(p[1].at, p[0].at), vvi_sub(p[2].at, p[0].at))) / 2;
    const uint64_t n = (uint64_t)(area * w->density + random_unit(w->seed, triangle, 0));
    for (uint64_t i = 0; i < n; i++) {
        double square;
        const vv_vec3 at =
            sample_of(p, random_unit(w->seed, triangle, 2 * i + 1), random_unit(w->seed, triangle, 2 * i + 2));
        *near = vvi_bvh_nearest(&square, w->b, vvi_add(at, w->shift), *near);
        take_if_larger(f, square, at);
        f->sum += sqrt(square);
        f->sum2 += square;
        f->sum4 += square * square;
        f->n++;
    }
}

static vv_status triangle_item(void *scratch, void *shared, size_t item)
{
    (void)scratch;
    const way *w = shared;
    found f = {.largest = -1};
    size_t left = QUESTIONS;
    const size_t n = w->mesh->n_triangles, end = (item + 1) * TRIANGLES < n ? (item + 1) * TRIANGLES : n;
    size_t near = w->nearest[w->mesh->triangles[3 * item * TRIANGLES]];
    for (size_t t = item * TRIANGLES; t < end; t++) {
        const uint32_t *corner = w->mesh->triangles + 3 * t;
        spot p[3];
        for (int k = 0; k < 3; k++) {
            p[k] = (spot){vvi_bvh_vertex(w->a, corner[k]), w->square[corner[k]], w->nearest[corner[k]]};
            take_if_larger(&f, p[k].square, p[k].at);
        }
        f.bound = fmax(f.bound, bound_of(&f, w, p, INFINITY, DEPTH, &left));
        take_samples(&f, w, t, p, &near);
    }
    w->found[item] = f;
    return VV_OK;
}

static found join(const found *found_, size_t n)
{
    found all = {.largest = -1};
    for (size_t i = 0; i < n; i++) {
        take_if_larger(&all, found_[i].largest, found_[i].worst);
        all.bound = fmax(all.bound, found_[i].bound);
        all.sum += found_[i].sum;
        all.sum2 += found_[i].sum2;
        all.sum4 += found_[i].sum4;
        all.n += found_[i].n;
    }
    return all;
}

static vv_figure figure(double value, double error, const char *unit)
{
    vv_figure f = {.value = value, .error = error};
    snprintf(f.unit, sizeof f.unit, "%s", unit);
    return f;
}

static void tell(vv_mesh_deviation *out, const found *f, const way *w, const char *unit)
{
    const double n = (double)f->n, mean = f->sum / n, square = f->sum2 / n, rms = sqrt(square);
    const double spread = sqrt(fmax(0, square - mean * mean) / n),
                 spread2 = sqrt(fmax(0, f->sum4 / n - square * square) / n);
    const double largest = sqrt(f->largest), rounding = 4 * (double)FLT_EPSILON * (w->a->radius + w->b->radius);
    const double missed = fmax(0, sqrt(f->bound) - largest);
    vv_mesh_foot foot;
    out->worst = vvi_add(f->worst, w->a->origin);
    vv_mesh_tree_nearest(&foot, w->b, out->worst);
    out->worst_foot = foot.at;
    out->n_samples = f->n;
    out->mean = figure(f->n ? mean : NAN, f->n ? 2 * spread + rounding : INFINITY, unit);
    out->rms = figure(f->n ? rms : NAN, f->n ? (rms > 0 ? spread2 / rms : 0) + rounding : INFINITY, unit);
    out->max = figure(largest, missed + rounding, unit);
}

/* A thousandth more than the largest distance of a vertex. */
static double enough_of(const way *w)
{
    double largest = 0;
    for (size_t v = 0; v < w->mesh->n_vertices; v++)
        largest = w->square[v] > largest ? w->square[v] : largest;
    return largest * 1.002;
}

static vv_status measure_way(vv_mesh_deviation *out, way *w, const char *unit, vv_job *job)
{
    const size_t nv = w->mesh->n_vertices, n_vertex = (nv + VERTICES - 1) / VERTICES;
    const size_t n_triangle = (w->mesh->n_triangles + TRIANGLES - 1) / TRIANGLES;
    const vvi_work vertices = {.stage = "distance", .item = vertex_item, .n_after = n_triangle};
    const vvi_work triangles = {.stage = "distance", .item = triangle_item, .n_before = n_vertex};
    w->square = vvi_alloc(job, (nv + 1) * sizeof *w->square, VVI_MEM_SCRATCH);
    w->nearest = vvi_alloc(job, (nv + 1) * sizeof *w->nearest, VVI_MEM_SCRATCH);
    w->found = vvi_alloc(job, (n_triangle + 1) * sizeof *w->found, VVI_MEM_SCRATCH);
    vv_status st = VV_OK;
    if (!w->square || !w->nearest || !w->found)
        st = vv_fail_memory((nv + 1) * sizeof *w->square);
    if (st == VV_OK)
        st = vvi_parallel_for(job, &vertices, w, n_vertex);
    w->enough = st == VV_OK ? enough_of(w) : 0;
    if (st == VV_OK && (st = vvi_parallel_for(job, &triangles, w, n_triangle)) == VV_OK) {
        const found all = join(w->found, n_triangle);
        tell(out, &all, w, unit);
    }
    vvi_free(w->square);
    vvi_free(w->nearest);
    vvi_free(w->found);
    return st;
}

static vv_status one_way(vv_mesh_deviation *out, const vv_mesh_tree *a, const vv_mesh_tree *b,
                         const vv_mesh_distance_options *o, const char *unit, vv_job *job)
{
    const double density = o->density > 0 ? o->density : a->area > 0 ? 200000 / a->area : 0;
    if (!(density * a->area <= 0x1p40))
        return vv_fail(VV_E_ARGUMENT, "%g samples by area are %g on this surface; at most 2^40 are possible", density,
                       density * a->area);
    way w = {.a = a,
             .b = b,
             .mesh = vv_mesh_get_info(a->mesh),
             .shift = vvi_sub(a->origin, b->origin),
             .density = density,
             .seed = o->seed};
    return measure_way(out, &w, unit, job);
}

void vv_mesh_distance_options_init(vv_mesh_distance_options *options, size_t size)
{
    const vv_mesh_distance_options all = {.size = size, .seed = 1};
    memcpy(options, &all, size < sizeof all ? size : sizeof all);
}

vv_status vv_mesh_distance(vv_mesh_distances *out, const vv_mesh_tree *a, const vv_mesh_tree *b,
                           const vv_mesh_distance_options *options, vv_job *job)
{
    vv_mesh_distance_options o;
    vv_status st;
    vv_mesh_distance_options_init(&o, sizeof o);
    if (options)
        memcpy(&o, options, options->size < sizeof o ? options->size : sizeof o);
    if (!(o.density >= 0) || !isfinite(o.density))
        return vv_fail(VV_E_ARGUMENT, "%g is no number of samples by area", o.density);
    const char *unit = o.unit[0] ? o.unit : vv_mesh_get_info(a->mesh)->unit;
    if ((st = one_way(&out->a_to_b, a, b, &o, unit, job)) != VV_OK ||
        (st = one_way(&out->b_to_a, b, a, &o, unit, job)) != VV_OK)
        return st;
    const vv_figure ab = out->a_to_b.max, ba = out->b_to_a.max;
    out->hausdorff = ab.value >= ba.value ? ab : ba;
    out->hausdorff.error = fmax(ab.value + ab.error, ba.value + ba.error) - out->hausdorff.value;
    return VV_OK;
}
