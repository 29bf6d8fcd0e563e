#include "measure/mesh_difference.h"
#include "core/memory.h"
#include "core/units.h"
#include "core/vec.h"
#include "grid/mesh.h"
#include "measure/far_triangles.h"
#include <float.h>
#include <math.h>
#include <string.h>

/* One array after another ----------------------------------------------------------------------------------------- */

static bool same_array(const void *a, const void *b, size_t bytes)
{
    return (a != NULL) == (b != NULL) && (!a || !bytes || memcmp(a, b, bytes) == 0);
}

/* Origins may differ and the places be the same. */
static bool same_places(const vv_mesh_info *a, const vv_mesh_info *b)
{
    bool same = a->n_vertices == b->n_vertices;
    for (size_t i = 0; same && i < 3 * a->n_vertices; i++)
        same = (&a->origin.x)[i % 3] + (double)a->positions[i] == (&b->origin.x)[i % 3] + (double)b->positions[i];
    return same;
}

static bool same_data(const vv_mesh_info *a, const vv_mesh_info *b)
{
    const size_t n = a->n_vertices;
    return n == b->n_vertices && same_array(a->normals, b->normals, 3 * n * sizeof *a->normals) &&
           same_array(a->values, b->values, n * sizeof *a->values) && same_array(a->colors, b->colors, 4 * n);
}

static bool same_topology(const vv_mesh_info *a, const vv_mesh_info *b)
{
    return a->n_vertices == b->n_vertices && a->n_triangles == b->n_triangles &&
           same_array(a->triangles, b->triangles, 3 * a->n_triangles * sizeof *a->triangles);
}

static double bounds_difference(const vv_bounds *a, const vv_bounds *b)
{
    const vv_vec3 lo = vvi_sub(a->lo, b->lo), hi = vvi_sub(a->hi, b->hi);
    double squares = 0;
    for (int i = 0; i < 3; i++) /* the corner that has the larger difference along each axis */
        squares += fmax((&lo.x)[i] * (&lo.x)[i], (&hi.x)[i] * (&hi.x)[i]);
    return isfinite(squares) ? sqrt(squares) : NAN;
}

/* Distances ------------------------------------------------------------------------------------------------------- */

/* How far a place may be from what a file of floats meant. */
static double rounding(const vv_mesh_info *m)
{
    float largest = 0;
    for (size_t i = 0; i < 3 * m->n_vertices; i++)
        largest = fmaxf(largest, fabsf(m->positions[i]));
    return 2 * (double)FLT_EPSILON * (double)largest;
}

enum { FIGURES = 8 };

static void list_figures(vv_figure *out[FIGURES], vvi_mesh_difference *d)
{
    vv_figure *const figures[FIGURES] = {&d->least,
                                         &d->distance.a_to_b.mean,
                                         &d->distance.a_to_b.rms,
                                         &d->distance.a_to_b.max,
                                         &d->distance.b_to_a.mean,
                                         &d->distance.b_to_a.rms,
                                         &d->distance.b_to_a.max,
                                         &d->distance.hausdorff};
    memcpy(out, figures, sizeof figures);
}

static void add_rounding(vvi_mesh_difference *d, double off)
{
    vv_figure *figure[FIGURES];
    list_figures(figure, d);
    for (size_t i = 0; i < FIGURES; i++)
        figure[i]->error += off;
}

static void have_no_distances(vvi_mesh_difference *d)
{
    vv_figure *figure[FIGURES];
    list_figures(figure, d);
    for (size_t i = 0; i < FIGURES; i++)
        *figure[i] = (vv_figure){.value = NAN, .error = NAN};
}

/* What vvi_mesh_beyond() leaves for it. */
static double tree_rounding(const vv_mesh_tree *tree)
{
    return 4 * (double)FLT_EPSILON * tree->radius;
}

static vv_status measure_distances(vvi_mesh_difference *out, const vv_mesh *a, const vv_mesh *b, vv_job *job)
{
    vv_mesh_tree *tree_a = NULL, *tree_b = NULL;
    vv_mesh_foot on_a, on_b;
    vv_status st = vv_mesh_tree_new(&tree_a, a, NULL, job);
    if (st == VV_OK && (st = vv_mesh_tree_new(&tree_b, b, NULL, job)) == VV_OK &&
        (st = vv_mesh_least_distance(&on_a, &on_b, tree_a, tree_b, job)) == VV_OK &&
        (st = vv_mesh_distance(&out->distance, tree_a, tree_b, NULL, job)) == VV_OK) {
        out->least.value = on_a.distance;
        add_rounding(out, hypot(rounding(vv_mesh_get_info(a)), rounding(vv_mesh_get_info(b))));
        out->rounding = tree_rounding(tree_a) + tree_rounding(tree_b);
    }
    vv_mesh_tree_release(tree_a);
    vv_mesh_tree_release(tree_b);
    return st;
}

static vv_status look_at(vvi_mesh_about *out, const vv_mesh *mesh, vv_job *job)
{
    vv_mesh_measure_options options;
    vv_mesh_measure_options_init(&options, sizeof options);
    options.open = true;
    const vv_status st = vv_mesh_count_topology(&out->topology, mesh, job);
    return st == VV_OK ? vv_mesh_measure(&out->measures, mesh, &options, job) : st;
}

/* Where one has no real unit, numbers are lengths of both. */
static vv_status agree_on_unit(vv_mesh **out, const vv_mesh *a, const vv_mesh *b, vv_job *job)
{
    const char *unit = vv_mesh_get_info(a)->unit, *other = vv_mesh_get_info(b)->unit;
    const double metres = vvi_length_unit_metres(unit), of_other = vvi_length_unit_metres(other);
    if (metres > 0 && of_other > 0 && metres != of_other)
        return vvi_mesh_scaled(out, b, of_other / metres, unit, job);
    *out = vv_mesh_retain(b);
    return VV_OK;
}

static void look_at_arrays(vvi_mesh_difference *out, const vv_mesh_info *a, const vv_mesh_info *b)
{
    out->same_topology = same_topology(a, b);
    out->same_places = same_places(a, b);
    out->same_data = same_data(a, b);
    out->apart = (a->n_triangles > 0) != (b->n_triangles > 0);
}

vv_status vvi_mesh_compare(vvi_mesh_difference *out, const vv_mesh *a, const vv_mesh *b, vv_job *job)
{
    const vv_mesh_info *m = vv_mesh_get_info(a), *other = vv_mesh_get_info(b);
    *out = (vvi_mesh_difference){.same_world = strcmp(m->unit, other->unit) == 0 && m->space == other->space};
    memcpy(out->unit[0], m->unit, sizeof out->unit[0]);
    memcpy(out->unit[1], other->unit, sizeof out->unit[1]);
    vv_status st = agree_on_unit(&out->b, a, b, job);
    if (st != VV_OK || (st = look_at(&out->about[0], a, job)) != VV_OK ||
        (st = look_at(&out->about[1], out->b, job)) != VV_OK)
        return st;
    other = vv_mesh_get_info(out->b);
    look_at_arrays(out, m, other);
    out->bounds_difference = bounds_difference(&out->about[0].measures.bounds, &out->about[1].measures.bounds);
    if (out->apart)
        have_no_distances(out);
    const bool same_surface = out->same_topology && out->same_places;
    return m->n_triangles && other->n_triangles && !same_surface ? measure_distances(out, a, out->b, job) : VV_OK;
}

static vv_status count_beyond(size_t *n, const vv_mesh_tree *a, const vv_mesh_tree *b, size_t n_triangles, double limit,
                              vv_job *job)
{
    vvi_beyond beyond = {.step = 1};
    if (!(beyond.of = vvi_alloc(job, n_triangles * sizeof *beyond.of, VVI_MEM_SCRATCH)))
        return vv_fail_memory(n_triangles * sizeof *beyond.of);
    const vv_status st = vvi_mesh_beyond(&beyond, a, b, limit, job);
    *n += beyond.n;
    vvi_free(beyond.of);
    return st;
}

vv_status vvi_mesh_within(bool *out, const vvi_mesh_difference *d, const vv_mesh *a, double limit, vv_job *job)
{
    const vv_figure far = d->distance.hausdorff;
    limit += 2 * d->rounding;
    vv_mesh_tree *tree_a = NULL, *tree_b = NULL;
    size_t n = 0;
    *out = !d->apart && far.value + far.error <= limit;
    if (*out || d->apart || far.value > limit)
        return VV_OK;
    vv_status st = vv_mesh_tree_new(&tree_a, a, NULL, job);
    if (st == VV_OK && (st = vv_mesh_tree_new(&tree_b, d->b, NULL, job)) == VV_OK &&
        (st = count_beyond(&n, tree_a, tree_b, vv_mesh_get_info(a)->n_triangles, limit, job)) == VV_OK)
        st = count_beyond(&n, tree_b, tree_a, vv_mesh_get_info(d->b)->n_triangles, limit, job);
    *out = n == 0;
    vv_mesh_tree_release(tree_a);
    vv_mesh_tree_release(tree_b);
    return st;
}
