#include "filter/simplify_attempts.h"
#include "core/memory.h"
#include "filter/corner_set.h"
#include "filter/near_cells.h"
#include "measure/bvh.h"
#include "measure/far_triangles.h"

#include <math.h>
#include <stdint.h>
#include <string.h>

typedef struct within {
    vvi_attempts *a;
    const vv_mesh_info *mesh;   /* that is simplified */
    const vv_mesh_info *before; /* that it has to stay near: mostly itself */
    vv_mesh_tree *now;          /* of the mesh */
    vvi_simplify_options options;
    uint8_t *still; /* by vertex */
    uint8_t *keep;  /* by triangle: it went though what is around it stays: of no area, back to back */
    size_t n_kept;
    vvi_beyond beyond;    /* with room for the triangles of either mesh */
    uint8_t *skip;        /* by triangle of the new mesh: known */
    vvi_corner_set known; /* triangles that are not beyond: the mesh's own, and new ones */
    uint8_t *near_before; /* by triangle of before: it is not beyond the new mesh, or was not at the last look, */
    uint32_t *looked_at;  /* whose n_looked_at triangles have these corners; 0: there was none */
    size_t n_looked_at;
    vvi_corner_set there; /* those of the new mesh */
    vvi_near_cells gone;  /* where triangles have gone since the last look */
    vv_job *job;
} within;

/* Triangles that come again in the next attempt --------------------------------------------------------------------
 */

static void recall(within *w)
{
    for (size_t t = 0; t < w->a->result.n_triangles; t++)
        w->skip[t] = vvi_corner_set_has(&w->known, w->options.corners + 3 * t);
}

static void remember(within *w)
{
    for (size_t t = 0; t < w->a->result.n_triangles; t++)
        if (w->beyond.of[t] == VVI_NOT_BEYOND)
            vvi_corner_set_add(&w->known, w->options.corners + 3 * t);
}

/* A triangle of what was before is near to what it was near to in the last attempt, unless something there has gone;
 * and to itself. */
static void recall_forth(within *w)
{
    vvi_corner_set_clear(&w->there);
    for (size_t t = 0; t < w->a->result.n_triangles; t++)
        vvi_corner_set_add(&w->there, w->options.corners + 3 * t);
    vvi_near_cells_clear(&w->gone);
    for (size_t t = 0; t < w->n_looked_at; t++)
        if (!vvi_corner_set_has(&w->there, w->looked_at + 3 * t))
            vvi_near_cells_mark(&w->gone, w->mesh->positions, w->looked_at + 3 * t);
    for (size_t t = 0; t < w->before->n_triangles; t++) {
        const uint32_t *corner = w->before->triangles + 3 * t;
        w->near_before[t] &= !vvi_near_cells_touch(&w->gone, w->before->positions, corner);
        w->near_before[t] |= w->before == w->mesh && vvi_corner_set_has(&w->there, corner);
    }
}

static void look_at(within *w, const uint32_t *corners, size_t n)
{
    memcpy(w->looked_at, corners, 3 * n * sizeof *w->looked_at);
    w->n_looked_at = n;
}

static void remember_forth(within *w)
{
    for (size_t t = 0; t < w->before->n_triangles; t++)
        w->near_before[t] = w->beyond.of[t] == VVI_NOT_BEYOND;
    look_at(w, w->options.corners, w->a->result.n_triangles);
}

static vv_status take_room(within *w)
{
    const vv_mesh_info *m = w->mesh;
    const size_t n = m->n_triangles, n_before = w->before->n_triangles, most = n > n_before ? n : n_before;
    w->still = vvi_alloc_zeroed(w->job, m->n_vertices, VVI_MEM_SCRATCH);
    w->keep = vvi_alloc_zeroed(w->job, n, VVI_MEM_SCRATCH);
    w->skip = vvi_alloc(w->job, n, VVI_MEM_SCRATCH);
    w->near_before = vvi_alloc_zeroed(w->job, n_before, VVI_MEM_SCRATCH);
    w->beyond.of = vvi_alloc(w->job, most * sizeof *w->beyond.of, VVI_MEM_SCRATCH);
    w->options.corners = vvi_alloc(w->job, 3 * n * sizeof *w->options.corners, VVI_MEM_SCRATCH);
    w->looked_at = vvi_alloc(w->job, 3 * n * sizeof *w->looked_at, VVI_MEM_SCRATCH);
    if (!w->still || !w->keep || !w->skip || !w->near_before || !w->beyond.of || !w->options.corners || !w->looked_at)
        return vv_fail_memory(3 * n * sizeof *w->looked_at);
    vv_status st = vvi_corner_set_init(&w->known, 2 * n, w->job);
    for (size_t t = 0; st == VV_OK && t < n; t++) /* what stays as it was is near to what it was */
        vvi_corner_set_add(&w->known, m->triangles + 3 * t);
    if (st == VV_OK && (st = vvi_corner_set_init(&w->there, n, w->job)) == VV_OK)
        st = vvi_near_cells_init(&w->gone, w->before, w->a->error, w->job);
    return st;
}

static void give_room_back(within *w)
{
    vv_mesh_tree_release(w->now);
    vvi_free(w->still);
    vvi_free(w->keep);
    vvi_free(w->skip);
    vvi_free(w->near_before);
    vvi_free(w->beyond.of);
    vvi_free(w->looked_at);
    vvi_corner_set_finish(&w->known);
    vvi_corner_set_finish(&w->there);
    vvi_near_cells_finish(&w->gone);
}

/* What stays -------------------------------------------------------------------------------------------------------
 */

enum { HELD = 1, NEW = 2, NEXT = 4 }; /* of vertices that stay */

static void hold_triangle(within *w, size_t triangle, uint8_t how)
{
    const uint32_t *corner = w->mesh->triangles + 3 * triangle;
    for (int k = 0; k < 3; k++)
        w->still[corner[k]] |= how;
}

/* Where that has not helped: what was around the corners of new triangles that lie too far away, so that they do not
 * come again. beyond is that of the look back. */
static void hold_corners(within *w)
{
    for (size_t k = 0; k < 3 * w->a->result.n_triangles; k++)
        if (w->beyond.of[k / 3] != VVI_NOT_BEYOND)
            w->still[w->options.corners[k]] |= NEW;
}

/* Another ring of triangles around what is new. */
static void widen(within *w)
{
    const vv_mesh_info *m = w->mesh;
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
    const uint32_t *c = w->mesh->triangles + 3 * triangle;
    if (w->keep[triangle] || !((w->still[c[0]] | w->still[c[1]] | w->still[c[2]]) & HELD) ||
        vvi_corner_set_has(&w->there, c))
        return;
    w->keep[triangle] = 1;
    w->n_kept++;
}

/* The triangles of the mesh where one of before is: itself, or what is nearest to its corners and its middle. How many
 * there are. */
static int find_here(size_t out[4], within *w, size_t triangle)
{
    if (w->before == w->mesh) {
        out[0] = triangle;
        return 1;
    }
    const uint32_t *corner = w->before->triangles + 3 * triangle;
    const vv_vec3 shift = vvi_sub(w->a->before->origin, w->now->origin);
    vv_vec3 at[4] = {{0}};
    double square;
    for (int k = 0; k < 3; k++) {
        at[k] = vvi_add(vvi_bvh_vertex(w->a->before, corner[k]), shift);
        at[3] = vvi_add(at[3], vvi_scaled(at[k], 1 / 3.0));
    }
    for (int k = 0; k < 4; k++)
        out[k] = w->now->order[vvi_bvh_nearest(&square, w->now, at[k], 0)];
    return 4;
}

/* Attempts ---------------------------------------------------------------------------------------------------------
 */

static void hold_there(within *w, size_t triangle, bool back)
{
    size_t here[4];
    const int n = find_here(here, w, triangle);
    for (int k = 0; k < n; k++) {
        if (!back)
            keep_triangle(w, here[k]);
        hold_triangle(w, here[k], NEW);
    }
}

/* One way: from what was before to the new mesh or back. *n_out: triangles with places that lie too far away. */
static vv_status look(size_t *n_out, within *w, bool back)
{
    vvi_beyond *beyond = &w->beyond;
    const size_t n = back ? w->a->result.n_triangles : w->before->n_triangles;
    const vv_mesh_tree *before = w->a->before, *after = w->a->after;
    (back ? recall : recall_forth)(w);
    beyond->step = 1;
    beyond->skip = back ? w->skip : w->near_before;
    const vv_status st = vvi_mesh_beyond(beyond, back ? after : before, back ? before : after, w->a->error, w->job);
    if (st != VV_OK)
        return st;
    for (size_t t = 0; t < n; t++)
        if (beyond->of[t] != VVI_NOT_BEYOND)
            hold_there(w, back ? beyond->of[t] : t, back);
    (back ? remember : remember_forth)(w);
    *n_out += beyond->n;
    w->a->largest = fmax(w->a->largest, beyond->largest);
    return VV_OK;
}

/* What has moved too far stays as it was from now on, and so does what is nearest to new triangles that lie too far
 * away. */
static vv_status hold_beyond(size_t *n_out, within *w)
{
    *n_out = 0;
    w->a->largest = 0;
    const vv_status st = look(n_out, w, false);
    return st == VV_OK ? look(n_out, w, true) : st;
}

static size_t count_held(const within *w)
{
    size_t n = 0;
    for (size_t v = 0; v < w->mesh->n_vertices; v++)
        n += w->still[v] != 0;
    return n;
}

static void forget(vvi_attempts *a)
{
    vv_mesh_release(a->out);
    vv_mesh_tree_release(a->after);
    a->out = NULL;
    a->after = NULL;
}

static vv_status attempt(within *w)
{
    vvi_attempts *a = w->a;
    forget(a);
    const vv_status st = vvi_mesh_simplify(&a->out, &a->result, a->mesh, &w->options, w->job);
    return st == VV_OK && a->result.n_triangles > 0 ? vvi_bvh_new(&a->after, a->out, w->job) : st;
}

static vv_status approach(within *w)
{
    enum { TRIES = 12, FEW = 500 };
    size_t n_beyond = 0, n_before = SIZE_MAX, n_held = 0, n_kept = 0;
    w->options.still = w->a->still ? w->still : NULL;
    vv_status st = attempt(w);
    w->options.still = w->still;
    w->options.keep = w->keep;
    for (int i = 0; st == VV_OK && w->a->after; i++) {
        if ((st = hold_beyond(&n_beyond, w)) != VV_OK || n_beyond == 0 || i == TRIES)
            break;
        const bool wide = n_beyond > n_before / 4 || n_beyond < w->a->result.n_triangles / FEW;
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
        for (size_t v = 0; v < w->mesh->n_vertices; v++)
            w->still[v] = w->still[v] ? HELD : 0;
        st = attempt(w);
    }
    w->a->kept = n_beyond == 0;
    return st;
}

/* A mesh that is within the error of what was before: what was near stays near as long as nothing goes. */
static vv_status begin(within *w)
{
    vv_status st = take_room(w);
    if (st == VV_OK && w->a->still)
        for (size_t v = 0; v < w->mesh->n_vertices; v++)
            w->still[v] = w->a->still[v] ? HELD : 0;
    if (st != VV_OK || w->before == w->mesh)
        return st;
    memset(w->near_before, 1, w->before->n_triangles);
    look_at(w, w->mesh->triangles, w->mesh->n_triangles);
    return vvi_bvh_new(&w->now, w->a->mesh, w->job);
}

vv_status vvi_simplify_attempts(vvi_attempts *a, vv_job *job)
{
    within w = {.a = a,
                .mesh = vv_mesh_get_info(a->mesh),
                .before = vv_mesh_get_info(a->before->mesh),
                .options = a->options,
                .job = job};
    a->out = NULL;
    a->after = NULL;
    vv_status st = begin(&w);
    if (st == VV_OK)
        st = approach(&w);
    give_room_back(&w);
    a->corners = w.options.corners;
    if (st != VV_OK)
        vvi_attempts_finish(a);
    return st;
}

void vvi_attempts_finish(vvi_attempts *a)
{
    forget(a);
    vvi_free(a->corners);
    a->corners = NULL;
}
