/* How far one surface is from another: mean, root mean square, largest. */
#include "core/job.h"
#include "core/memory.h"
#include "core/vec.h"
#include "measure/farthest_place.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

enum { VERTICES = 2048, TRIANGLES = 2048 }; /* to an item */

/* What one item of triangles finds. */
typedef struct found {
    double largest;         /* squared */
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
    double *square;    /* of each vertex of a: squared distance to b, */
    uint32_t *nearest; /* and the triangle there, in the order of b's tree */
    double *bound;     /* of each triangle: squared, no distance to b in it is larger */
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

/* Evenly in a triangle. */
static vv_vec3 sample_of(const vvi_spot p[3], double u, double v)
{
    const double r = sqrt(u);
    return vvi_add(vvi_add(vvi_scaled(p[0].at, 1 - r), vvi_scaled(p[1].at, r * (1 - v))), vvi_scaled(p[2].at, r * v));
}

static void take_samples(found *f, const way *w, size_t triangle, const vvi_spot p[3], size_t *near)
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

static vvi_spot spot_of(const way *w, uint32_t vertex)
{
    return (vvi_spot){vvi_bvh_vertex(w->a, vertex), w->square[vertex], w->nearest[vertex]};
}

static vv_status triangle_item(void *scratch, void *shared, size_t item)
{
    (void)scratch;
    const way *w = shared;
    found f = {.largest = -1};
    const size_t n = w->mesh->n_triangles, end = (item + 1) * TRIANGLES < n ? (item + 1) * TRIANGLES : n;
    size_t near = w->nearest[w->mesh->triangles[3 * item * TRIANGLES]];
    for (size_t t = item * TRIANGLES; t < end; t++) {
        const uint32_t *corner = w->mesh->triangles + 3 * t;
        vvi_spot p[3];
        for (int k = 0; k < 3; k++) {
            p[k] = spot_of(w, corner[k]);
            take_if_larger(&f, p[k].square, p[k].at);
        }
        w->bound[t] = vvi_spots_bound(w->b, w->shift, p);
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

static void tell(vv_mesh_deviation *out, const found *f, double most, const way *w, const char *unit)
{
    const double n = (double)f->n, mean = f->sum / n, square = f->sum2 / n, rms = sqrt(square);
    const double spread = sqrt(fmax(0, square - mean * mean) / n),
                 spread2 = sqrt(fmax(0, f->sum4 / n - square * square) / n);
    const double largest = sqrt(f->largest), rounding = 4 * (double)FLT_EPSILON * (w->a->radius + w->b->radius);
    const double missed = fmax(0, sqrt(most) - largest);
    vv_mesh_foot foot;
    out->worst = vvi_add(f->worst, w->a->origin);
    vv_mesh_tree_nearest(&foot, w->b, out->worst);
    out->worst_foot = foot.at;
    out->n_samples = f->n;
    out->mean = figure(f->n ? mean : NAN, f->n ? 2 * spread + rounding : INFINITY, unit);
    out->rms = figure(f->n ? rms : NAN, f->n ? (rms > 0 ? spread2 / rms : 0) + rounding : INFINITY, unit);
    out->max = figure(largest, missed + rounding, unit);
}

/* The largest distance, and how much larger one may be. */
static vv_status search(found *all, double *most, const way *w, vv_job *job)
{
    vvi_farthest f = {.a = w->a,
                      .b = w->b,
                      .shift = w->shift,
                      .square = w->square,
                      .nearest = w->nearest,
                      .bound = w->bound,
                      .largest = all->largest,
                      .worst = all->worst};
    const vv_status st = vvi_farthest_search(&f, job);
    all->largest = f.largest;
    all->worst = f.worst;
    *most = f.most;
    return st;
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
    w->bound = vvi_alloc(job, (w->mesh->n_triangles + 1) * sizeof *w->bound, VVI_MEM_SCRATCH);
    if (!w->square || !w->nearest || !w->bound || !w->found)
        st = vv_fail_memory((nv + 1) * sizeof *w->square);
    if (st == VV_OK)
        st = vvi_parallel_for(job, &vertices, w, n_vertex);
    if (st == VV_OK && (st = vvi_parallel_for(job, &triangles, w, n_triangle)) == VV_OK) {
        found all = join(w->found, n_triangle);
        double most;
        if ((st = search(&all, &most, w, job)) == VV_OK)
            tell(out, &all, most, w, unit);
    }
    vvi_free(w->square);
    vvi_free(w->nearest);
    vvi_free(w->bound);
    vvi_free(w->found);
    return st;
}

static vv_status one_way(vv_mesh_deviation *out, const vv_mesh_tree *a, const vv_mesh_tree *b,
                         const vv_mesh_distance_options *o, const char *unit, vv_job *job)
{
    const double density = o->density > 0 ? o->density : a->area > 0 ? 200000 / a->area : 0;
    if (!(density * a->area <= 0x1p40))
        return vv_fail(VV_E_ARGUMENT, "%g samples per area make %g on this surface; at most 2^40 are possible", density,
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
        return vv_fail(VV_E_ARGUMENT, "%g is not a number of samples per area", o.density);
    const char *unit = o.unit[0] ? o.unit : vv_mesh_get_info(a->mesh)->unit;
    if ((st = one_way(&out->a_to_b, a, b, &o, unit, job)) != VV_OK ||
        (st = one_way(&out->b_to_a, b, a, &o, unit, job)) != VV_OK)
        return st;
    const vv_figure ab = out->a_to_b.max, ba = out->b_to_a.max;
    out->hausdorff = ab.value >= ba.value ? ab : ba;
    out->hausdorff.error = fmax(ab.value + ab.error, ba.value + ba.error) - out->hausdorff.value;
    return VV_OK;
}
