/* Simplify: fewer triangles for nearly the same surface, as an operation. */
#include "filter/simplify.h"
#include "core/job.h"
#include "core/memory.h"
#include "measure/beyond.h"
#include "registry.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

typedef struct simplify_params {
    vv_object base;
    int64_t triangles;
    double share, error;
    bool lock_border;
    vvi_simplify_told *told; /* no property: see vvi_simplify_tell() */
} simplify_params;

static const vv_property properties[] = {
    {VV_PROP(simplify_params, triangles), .kind = VV_KIND_I64, .limited = true, .min = 1, .max = UINT32_MAX,
     .automatic = "as share says", .doc = "that are left, at most"},
    {VV_PROP(simplify_params, share), .kind = VV_KIND_F64, .quantity = VV_Q_RATIO, .limited = true, .min = 0, .max = 1,
     .automatic = "a quarter, unless triangles or error are given", .doc = "of the triangles that is left, at most"},
    {VV_PROP(simplify_params, error), .kind = VV_KIND_F64, .quantity = VV_Q_LENGTH, .limited = true, .min = 0,
     .max = 1e30, .automatic = "as much as the number of triangles asks for",
     .doc = "the largest distance between the surface and what it was (Hausdorff), measured; no piece vanishes, and a "
            "warning says so where the distance cannot be kept"},
    {VV_PROP(simplify_params, lock_border), .kind = VV_KIND_BOOL, .doc = "vertices at open edges stay where they are"},
    {0},
};

static const vv_class simplify_class = {
    .name = "simplify",
    .doc = "parameters of simplify",
    .size = sizeof(simplify_params),
    .properties = properties,
};

static uint64_t budget_of(const simplify_params *p, const vv_mesh *mesh)
{
    const double n = (double)vv_mesh_get_info(mesh)->n_triangles;
    if (vv_object_is_set(&p->base, "triangles"))
        return (uint64_t)p->triangles;
    if (vv_object_is_set(&p->base, "share"))
        return (uint64_t)(n * p->share) + 1;
    return vv_object_is_set(&p->base, "error") ? 0 : (uint64_t)(n / 4) + 1;
}

void vvi_simplify_tell(vv_object *params, vvi_simplify_told *told)
{
    ((simplify_params *)params)->told = told;
}

/* Within an error --------------------------------------------------------------------------------------------------
 */

typedef struct within {
    const vv_mesh *mesh;
    vvi_simplify_options options;
    double error;
    vvi_simplify_told *told;
    vv_mesh_tree *before, *after;
    uint8_t *still;    /* by vertex */
    vvi_beyond beyond; /* with room for the triangles of either mesh */
    double largest;    /* distance that was seen in the last attempt */
    uint8_t *skip;     /* by triangle of the new mesh: known */
    uint32_t *known;   /* corners of n_known triangles that are not beyond the mesh, hashed into `room` places */
    size_t room, n_known;
    vv_job *job;
} within;

/* Distances of more than half the error were seen as they are; where all are less, they are measured. Places between
 * the vertices are looked at by the search for the bound: samples would only cost time. */
static vv_status measure(const within *w, bool all_within)
{
    vv_mesh_distances distances;
    vv_mesh_distance_options options;
    vv_mesh_distance_options_init(&options, sizeof options);
    options.density = 1e-30;
    if (all_within && w->largest > 0) {
        w->told->distance = (vv_figure){.value = w->largest, .error = w->error - w->largest};
        return VV_OK;
    }
    const vv_status st = vv_mesh_distance(&distances, w->before, w->after, &options, w->job);
    if (st == VV_OK)
        w->told->distance = distances.hausdorff;
    if (st == VV_OK && all_within)
        w->told->distance.error = fmin(w->told->distance.error, w->error - w->told->distance.value);
    return st;
}

/* Triangles that come again in the next attempt --------------------------------------------------------------------
 */

/* Where a triangle is among those that are known, or would be. */
static uint32_t *place_of(const within *w, const uint32_t c[3])
{
    size_t at = (c[0] * 0x9e3779b1u ^ c[1] * 0x85ebca6bu ^ c[2] * 0xc2b2ae35u) & (w->room - 1);
    while (w->known[3 * at] != UINT32_MAX && memcmp(w->known + 3 * at, c, 3 * sizeof *c) != 0)
        at = (at + 1) & (w->room - 1);
    return w->known + 3 * at;
}

static void recall(within *w)
{
    for (size_t t = 0; t < w->told->result.n_triangles; t++)
        w->skip[t] = *place_of(w, w->options.corners + 3 * t) != UINT32_MAX;
}

static void remember(within *w)
{
    for (size_t t = 0; t < w->told->result.n_triangles && w->n_known < w->room / 2; t++) {
        uint32_t *place = place_of(w, w->options.corners + 3 * t);
        if (w->beyond.of[t] != VVI_NOT_BEYOND || *place != UINT32_MAX)
            continue;
        memcpy(place, w->options.corners + 3 * t, 3 * sizeof *place);
        w->n_known++;
    }
}

static vv_status take_room(within *w)
{
    const vv_mesh_info *m = vv_mesh_get_info(w->mesh);
    for (w->room = 64; w->room < 2 * m->n_triangles; w->room *= 2)
        ;
    w->still = vvi_alloc_zeroed(w->job, m->n_vertices, VVI_MEM_SCRATCH);
    w->skip = vvi_alloc(w->job, m->n_triangles, VVI_MEM_SCRATCH);
    w->beyond.of = vvi_alloc(w->job, m->n_triangles * sizeof *w->beyond.of, VVI_MEM_SCRATCH);
    w->options.corners = vvi_alloc(w->job, 3 * m->n_triangles * sizeof *w->options.corners, VVI_MEM_SCRATCH);
    w->known = vvi_alloc(w->job, 3 * w->room * sizeof *w->known, VVI_MEM_SCRATCH);
    if (!w->still || !w->skip || !w->beyond.of || !w->options.corners || !w->known)
        return vv_fail_memory(3 * w->room * sizeof *w->known);
    memset(w->known, 0xff, 3 * w->room * sizeof *w->known);
    return VV_OK;
}

static void give_room_back(within *w)
{
    vvi_free(w->still);
    vvi_free(w->skip);
    vvi_free(w->beyond.of);
    vvi_free(w->options.corners);
    vvi_free(w->known);
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

/* One way: from the mesh to the new one or back. *n_out: triangles with places that lie too far away. */
static vv_status look(size_t *n_out, within *w, bool back, size_t step)
{
    vvi_beyond *beyond = &w->beyond;
    const size_t n = vv_mesh_get_info(w->mesh)->n_triangles, n_after = w->told->result.n_triangles;
    beyond->step = step;
    beyond->skip = back && step == 1 && w->n_known > 0 ? w->skip : NULL;
    if (beyond->skip)
        recall(w);
    const vv_status st =
        vvi_mesh_beyond(beyond, back ? w->after : w->before, back ? w->before : w->after, w->error, w->job);
    if (st != VV_OK)
        return st;
    for (size_t t = 0; t < (back ? n_after : n); t++)
        if (beyond->of[t] != VVI_NOT_BEYOND)
            hold_triangle(w, back ? beyond->of[t] : t, NEW);
    if (back && step == 1)
        remember(w);
    *n_out += beyond->n;
    w->largest = fmax(w->largest, beyond->largest);
    return VV_OK;
}

/* What has moved too far stays as it was from now on, and so does what is nearest to new triangles that lie too far
 * away. */
static vv_status hold_beyond(size_t *n_out, within *w, size_t step)
{
    *n_out = 0;
    w->largest = 0;
    const vv_status st = look(n_out, w, false, step);
    return st == VV_OK ? look(n_out, w, true, step) : st;
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

/* The quadric error is an average over planes: with less of it until the surface has moved too far at so few places
 * that to leave them as they were costs fewer triangles than still less of it. Of many triangles, some say whether it
 * has. */
static vv_status lower_error(vv_mesh **out, within *w)
{
    enum { TRIES = 6, MANY = 4096, STEP = 16, FEW = 32 };
    const size_t step = vv_mesh_get_info(w->mesh)->n_triangles < STEP * MANY ? 1 : STEP;
    size_t n = 0;
    for (int i = 0; i < TRIES; i++) {
        vv_status st = attempt(out, w);
        if (st != VV_OK || !w->after || (st = hold_beyond(&n, w, step)) != VV_OK ||
            n * step <= w->told->result.n_triangles / FEW)
            return st;
        w->options.error *= 0.7;
    }
    return attempt(out, w);
}

/* Then those places are left as they were, and what comes to lie too far away beside them, until nothing does. */
static vv_status approach(vv_mesh **out, within *w)
{
    enum { TRIES = 12, NARROW = 6 };
    const size_t n_vertices = vv_mesh_get_info(w->mesh)->n_vertices;
    size_t n_beyond = 0;
    vv_status st = lower_error(out, w);
    w->told->distance = (vv_figure){.value = INFINITY, .error = 0};
    memset(w->still, 0, n_vertices);
    w->options.still = w->still;
    for (int i = 0; st == VV_OK && w->after; i++) {
        if ((st = hold_beyond(&n_beyond, w, 1)) != VV_OK || n_beyond == 0 || i == TRIES)
            break;
        if (i >= NARROW)
            widen(w);
        for (size_t v = 0; v < n_vertices; v++)
            w->still[v] = w->still[v] ? HELD : 0;
        st = attempt(out, w);
    }
    return st == VV_OK && w->after ? measure(w, n_beyond == 0) : st;
}

static vv_status simplify_within(vv_mesh **out, vvi_simplify_told *told, const vv_mesh *mesh,
                                 const vvi_simplify_options *options, vv_job *job)
{
    within w = {.mesh = mesh, .options = *options, .error = options->error, .told = told, .job = job};
    vv_status st = vv_mesh_tree_new(&w.before, mesh, NULL, job);
    if (st == VV_OK && (st = take_room(&w)) == VV_OK)
        st = approach(out, &w);
    vv_mesh_tree_release(w.before);
    vv_mesh_tree_release(w.after);
    give_room_back(&w);
    if (st == VV_OK)
        return VV_OK;
    vv_mesh_release(*out);
    *out = NULL;
    return st;
}

static void tell(const vvi_simplify_told *told, const vv_mesh_info *mesh, const vvi_simplify_options *options,
                 vv_job *job)
{
    const vvi_simplify_result *r = &told->result;
    const double most = told->distance.value + told->distance.error;
    vvi_log(job, VV_LOG_INFO, "simplify", "%zu of %zu triangles; the surface has moved by about %.3g %s",
            r->n_triangles, mesh->n_triangles, r->error, mesh->unit);
    if (r->over_budget)
        vvi_log(job, VV_LOG_WARNING, "simplify", "%zu triangles are left of the %llu asked for: no more can go %s",
                r->n_triangles, (unsigned long long)options->triangles,
                options->error > 0 ? "within the error" : "without opening the surface");
    if (r->n_crowded)
        vvi_log(job, VV_LOG_WARNING, "simplify",
                "%zu edges have more than two triangles: the surface touches itself there", r->n_crowded);
    if (options->error > 0 && most > options->error)
        vvi_log(job, VV_LOG_WARNING, "simplify",
                "the surface lies up to %.4g %s from what it was, more than the error of %.4g that was asked for", most,
                mesh->unit, options->error);
}

static vv_status mesh_of_meshes(vv_mesh **out, const vv_mesh *const *inputs, size_t n_inputs, const vv_object *params,
                                vv_job *job)
{
    (void)n_inputs;
    const simplify_params *p = (const simplify_params *)params;
    const vvi_simplify_options options = {
        .triangles = budget_of(p, inputs[0]), .error = p->error, .lock_border = p->lock_border};
    const vv_mesh_info *mesh = vv_mesh_get_info(inputs[0]);
    vvi_simplify_told told = {.distance.value = NAN};
    if (!mesh->n_triangles) { /* nothing to do, and no budget that says so */
        *out = vv_mesh_retain(inputs[0]);
        return VV_OK;
    }
    *out = NULL;
    const vv_status st = options.error > 0 ? simplify_within(out, &told, inputs[0], &options, job)
                                           : vvi_mesh_simplify(out, &told.result, inputs[0], &options, job);
    if (st != VV_OK)
        return st;
    tell(&told, mesh, &options, job);
    if (p->told)
        *p->told = told;
    return VV_OK;
}

const vv_operation vvi_operation_simplify = {
    .api = VV_OPERATION_API,
    .name = "simplify",
    .component = "surface",
    .doc = "a mesh of fewer triangles, nearly the same surface (quadric error)",
    .example = "volvis simplify skin.ply -o small.ply --share 20%",
    .params = &simplify_class,
    .min_inputs = 1,
    .max_inputs = 1,
    .mesh_of_meshes = mesh_of_meshes,
};
