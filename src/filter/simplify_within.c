#include "filter/simplify_within.h"
#include "core/job.h"
#include "core/memory.h"
#include "filter/corner_set.h"
#include "filter/near_cells.h"
#include "filter/simplify_share.h"
#include "measure/beyond.h"
#include "measure/bvh.h"

#include <math.h>
#include <stdint.h>
#include <string.h>

typedef struct within {
    const vv_mesh *mesh;
    vvi_simplify_options options;
    double error;
    vvi_simplify_told *told;
    vv_mesh_tree *before, *after;
    uint8_t *still; /* by vertex */
    uint8_t *keep;  /* by triangle: it went though what is around it stays: of no area, back to back */
    size_t n_kept;
    vvi_beyond beyond;    /* with room for the triangles of either mesh */
    double largest;       /* distance that was seen in the last attempt */
    uint8_t *skip;        /* by triangle of the new mesh: known */
    vvi_corner_set known; /* triangles that are not beyond the mesh: its own, and new ones */
    uint8_t *near_before; /* by triangle of the mesh: it is not beyond the new mesh, or was not at the last look, */
    uint32_t *looked_at;  /* whose n_looked_at triangles have these corners; 0: there was none */
    size_t n_looked_at;
    vvi_corner_set there; /* those of the new mesh */
    vvi_near_cells gone;  /* where triangles have gone since the last look */
    vv_job *job;
} within;

vv_status vvi_simplify_measure(vv_figure *out, const vv_mesh_tree *before, const vv_mesh_tree *after, vv_job *job)
{
    vv_mesh_distances distances;
    vv_mesh_distance_options options;
    vv_mesh_distance_options_init(&options, sizeof options);
    options.density = 1e-30; /* no samples: vertices, and the search for the bound between them */
    const vv_status st = vv_mesh_distance(&distances, before, after, &options, job);
    if (st == VV_OK)
        *out = distances.hausdorff;
    return st;
}

/* Distances of more than half the error are seen as they are: of one way, at some triangles. */
static vv_status sample_largest(within *w, const vv_mesh_tree *a, const vv_mesh_tree *b)
{
    enum { ENOUGH = 8192 };
    vvi_beyond *beyond = &w->beyond;
    beyond->step = a->n / ENOUGH + 1;
    beyond->skip = NULL;
    const vv_status st = vvi_mesh_beyond(beyond, a, b, w->error, w->job);
    w->largest = fmax(w->largest, beyond->largest);
    return st;
}

/* Where all are less than half of it, they are measured. */
static vv_status measure(within *w, bool all_within)
{
    vv_figure *distance = &w->told->distance;
    vv_status st = VV_OK;
    if (all_within && w->largest <= 0 && (st = sample_largest(w, w->before, w->after)) == VV_OK)
        st = sample_largest(w, w->after, w->before);
    if (all_within && w->largest > 0) {
        *distance = (vv_figure){.value = w->largest, .error = w->error - w->largest};
        return st;
    }
    if (st == VV_OK)
        st = vvi_simplify_measure(distance, w->before, w->after, w->job);
    if (st == VV_OK && all_within)
        distance->error = fmin(distance->error, w->error - distance->value);
    return st;
}

/* Triangles that come again in the next attempt --------------------------------------------------------------------
 */

static void recall(within *w)
{
    for (size_t t = 0; t < w->told->result.n_triangles; t++)
        w->skip[t] = vvi_corner_set_has(&w->known, w->options.corners + 3 * t);
}

static void remember(within *w)
{
    for (size_t t = 0; t < w->told->result.n_triangles; t++)
        if (w->beyond.of[t] == VVI_NOT_BEYOND)
            vvi_corner_set_add(&w->known, w->options.corners + 3 * t);
}

/* A triangle of the mesh is near to what it was near to in the last attempt, unless something there has gone; and to
 * itself. */
static void recall_forth(within *w)
{
    const vv_mesh_info *m = vv_mesh_get_info(w->mesh);
    vvi_corner_set_clear(&w->there);
    for (size_t t = 0; t < w->told->result.n_triangles; t++)
        vvi_corner_set_add(&w->there, w->options.corners + 3 * t);
    vvi_near_cells_clear(&w->gone);
    for (size_t t = 0; t < w->n_looked_at; t++)
        if (!vvi_corner_set_has(&w->there, w->looked_at + 3 * t))
            vvi_near_cells_mark(&w->gone, m->positions, w->looked_at + 3 * t);
    for (size_t t = 0; t < m->n_triangles; t++) {
        const uint32_t *corner = m->triangles + 3 * t;
        w->near_before[t] &= !vvi_near_cells_touch(&w->gone, m->positions, corner);
        w->near_before[t] |= vvi_corner_set_has(&w->there, corner);
    }
}

static void remember_forth(within *w)
{
    for (size_t t = 0; t < vv_mesh_get_info(w->mesh)->n_triangles; t++)
        w->near_before[t] = w->beyond.of[t] == VVI_NOT_BEYOND;
    w->n_looked_at = w->told->result.n_triangles;
    memcpy(w->looked_at, w->options.corners, 3 * w->n_looked_at * sizeof *w->looked_at);
}

static vv_status take_room(within *w)
{
    const vv_mesh_info *m = vv_mesh_get_info(w->mesh);
    const size_t n = m->n_triangles;
    w->still = vvi_alloc_zeroed(w->job, m->n_vertices, VVI_MEM_SCRATCH);
    w->keep = vvi_alloc_zeroed(w->job, n, VVI_MEM_SCRATCH);
    w->skip = vvi_alloc(w->job, n, VVI_MEM_SCRATCH);
    w->near_before = vvi_alloc_zeroed(w->job, n, VVI_MEM_SCRATCH);
    w->beyond.of = vvi_alloc(w->job, n * sizeof *w->beyond.of, VVI_MEM_SCRATCH);
    w->options.corners = vvi_alloc(w->job, 3 * n * sizeof *w->options.corners, VVI_MEM_SCRATCH);
    w->looked_at = vvi_alloc(w->job, 3 * n * sizeof *w->looked_at, VVI_MEM_SCRATCH);
    if (!w->still || !w->keep || !w->skip || !w->near_before || !w->beyond.of || !w->options.corners || !w->looked_at)
        return vv_fail_memory(3 * n * sizeof *w->looked_at);
    vv_status st = vvi_corner_set_init(&w->known, 2 * n, w->job);
    for (size_t t = 0; st == VV_OK && t < n; t++) /* what stays as it was is near to what it was */
        vvi_corner_set_add(&w->known, m->triangles + 3 * t);
    if (st == VV_OK && (st = vvi_corner_set_init(&w->there, n, w->job)) == VV_OK)
        st = vvi_near_cells_init(&w->gone, m, w->error, w->job);
    return st;
}

static void give_room_back(within *w)
{
    vvi_free(w->still);
    vvi_free(w->keep);
    vvi_free(w->skip);
    vvi_free(w->near_before);
    vvi_free(w->beyond.of);
    vvi_free(w->options.corners);
    vvi_free(w->looked_at);
    vvi_corner_set_finish(&w->known);
    vvi_corner_set_finish(&w->there);
    vvi_near_cells_finish(&w->gone);
}

/* What lies too far away --------------------------------------------------------------------------------------------
 */

enum { HELD = 1, NEW = 2, NEXT = 4 }; /* of vertices that stay */

static void hold_triangle(within *w, size_t triangle, uint8_t how)
{
    const uint32_t *corner = vv_mesh_get_info(w->mesh)->triangles + 3 * triangle;
    for (int k = 0; k < 3; k++)
        w->still[corner[k]] |= how;
}

/* Where that has not helped: what was around the corners of new triangles that lie too far away, so that they do not
 * come again. beyond is that of the look back. */
static void hold_corners(within *w)
{
    for (size_t k = 0; k < 3 * w->told->result.n_triangles; k++)
        if (w->beyond.of[k / 3] != VVI_NOT_BEYOND)
            w->still[w->options.corners[k]] |= NEW;
}

/* Another ring of triangles around what is new. */
static void widen(within *w)
{
    const vv_mesh_info *m = vv_mesh_get_info(w->mesh);
    for (size_t t = 0; t < m->n_triangles; t++) {
        const uint32_t *c = m->triangles + 3 * t;
        if ((w->still[c[0]] | w->still[c[1]] | w->still[c[2]]) & NEW)
            hold_triangle(w, t, NEXT);
    }
    for (size_t v = 0; v < m->n_vertices; v++)
        w->still[v] |= w->still[v] & NEXT ? NEW : 0;
}

/* What was held in the last attempt and is gone all the same. */
static void keep_triangle(within *w, size_t triangle)
{
    const uint32_t *c = vv_mesh_get_info(w->mesh)->triangles + 3 * triangle;
    if (w->keep[triangle] || !((w->still[c[0]] | w->still[c[1]] | w->still[c[2]]) & HELD) ||
        vvi_corner_set_has(&w->there, c))
        return;
    w->keep[triangle] = 1;
    w->n_kept++;
}

/* One way: from the mesh to the new one or back. *n_out: triangles with places that lie too far away. */
static vv_status look(size_t *n_out, within *w, bool back)
{
    vvi_beyond *beyond = &w->beyond;
    const size_t n = vv_mesh_get_info(w->mesh)->n_triangles, n_after = w->told->result.n_triangles;
    (back ? recall : recall_forth)(w);
    beyond->step = 1;
    beyond->skip = back ? w->skip : w->near_before;
    const vv_status st =
        vvi_mesh_beyond(beyond, back ? w->after : w->before, back ? w->before : w->after, w->error, w->job);
    if (st != VV_OK)
        return st;
    for (size_t t = 0; t < (back ? n_after : n); t++)
        if (beyond->of[t] != VVI_NOT_BEYOND)
            hold_triangle(w, back ? beyond->of[t] : t, NEW);
    for (size_t t = 0; !back && t < n; t++)
        if (beyond->of[t] != VVI_NOT_BEYOND)
            keep_triangle(w, t);
    (back ? remember : remember_forth)(w);
    *n_out += beyond->n;
    w->largest = fmax(w->largest, beyond->largest);
    return VV_OK;
}

/* What has moved too far stays as it was from now on, and so does what is nearest to new triangles that lie too far
 * away. */
static vv_status hold_beyond(size_t *n_out, within *w)
{
    *n_out = 0;
    w->largest = 0;
    const vv_status st = look(n_out, w, false);
    return st == VV_OK ? look(n_out, w, true) : st;
}

static size_t count_held(const within *w)
{
    size_t n = 0;
    for (size_t v = 0; v < vv_mesh_get_info(w->mesh)->n_vertices; v++)
        n += w->still[v] != 0;
    return n;
}

static vv_status attempt(vv_mesh **out, within *w)
{
    vv_mesh_release(*out);
    vv_mesh_tree_release(w->after);
    *out = NULL;
    w->after = NULL;
    const vv_status st = vvi_mesh_simplify(out, &w->told->result, w->mesh, &w->options, w->job);
    return st == VV_OK && w->told->result.n_triangles > 0 ? vv_mesh_tree_new(&w->after, *out, NULL, w->job) : st;
}

/* The places that moved too far are left as they were, and what comes to lie too far away beside them, until nothing
 * does; with a wider ring around them where that does not help, and where it costs next to nothing. */
static vv_status approach(vv_mesh **out, within *w)
{
    enum { TRIES = 12, FEW = 500 };
    const size_t n_vertices = vv_mesh_get_info(w->mesh)->n_vertices;
    size_t n_beyond = 0, n_before = SIZE_MAX, n_held = 0, n_kept = 0;
    vv_status st = attempt(out, w);
    w->told->distance = (vv_figure){.value = INFINITY, .error = 0};
    w->options.still = w->still;
    w->options.keep = w->keep;
    for (int i = 0; st == VV_OK && w->after; i++) {
        if ((st = hold_beyond(&n_beyond, w)) != VV_OK || n_beyond == 0 || i == TRIES)
            break;
        const bool wide = n_beyond > n_before / 4 || n_beyond < w->told->result.n_triangles / FEW;
        const size_t n_held_before = n_held;
        const bool more_kept = w->n_kept > n_kept;
        if (wide) {
            hold_corners(w);
            widen(w);
        }
        n_before = n_beyond;
        n_held = count_held(w);
        n_kept = w->n_kept;
        if (wide && n_held == n_held_before && !more_kept) /* the next attempt would be this one again */
            break;
        for (size_t v = 0; v < n_vertices; v++)
            w->still[v] = w->still[v] ? HELD : 0;
        st = attempt(out, w);
    }
    return st == VV_OK && w->after ? measure(w, n_beyond == 0) : st;
}

vv_status vvi_simplify_within(vv_mesh **out, vvi_simplify_told *told, const vv_mesh *mesh,
                              const vvi_simplify_options *options, vv_job *job)
{
    within w = {.mesh = mesh, .options = *options, .error = options->error, .told = told, .job = job};
    vv_status st = vv_mesh_tree_new(&w.before, mesh, NULL, job);
    double share = 1;
    if (st == VV_OK && (st = vvi_simplify_find_share(&share, w.before, options, job)) == VV_OK &&
        (st = take_room(&w)) == VV_OK) {
        w.options.error *= share;
        st = approach(out, &w);
    }
    vv_mesh_tree_release(w.before);
    vv_mesh_tree_release(w.after);
    give_room_back(&w);
    if (st == VV_OK)
        return VV_OK;
    vv_mesh_release(*out);
    *out = NULL;
    return st;
}
