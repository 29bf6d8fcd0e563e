/* Exact shortest paths. A window is an interval of an edge that a source sees straight through a strip of unfolded
 * triangles: the source is the first vertex of the path, or one where it turns. Windows are carried across triangles,
 * the most promising first. */
#include "core/job.h"
#include "core/memory.h"
#include "core/vec.h"
#include "measure/heap.h"
#include "measure/path_search.h"

#include <math.h>
#include <string.h>

/* In the plane of the triangle that it enters: the edge's start is at 0, its end at (length, 0), and the source, where
 * unfolding puts it, below. */
typedef struct window {
    uint32_t edge;   /* of the triangle that it enters */
    uint32_t parent; /* window that it comes of; VVI_NONE: of the source itself */
    uint32_t source; /* vertex */
    double b0, b1;   /* interval */
    double x, y;     /* of the source; y < 0 */
    double before;   /* distance from the path's first vertex to the source */
} window;

/* How a vertex was reached. */
typedef struct arrival {
    double distance;
    uint32_t window; /* VVI_NONE: along an edge, from */
    uint32_t from;
} arrival;

/* The window that reaches a triangle's corner soonest, of those through the opposite edge. */
typedef struct occupant {
    double distance, at;
} occupant;

enum { TURN, WINDOW };

typedef struct search {
    const vvi_path_mesh *mesh;
    const bool *allowed;
    vv_job *job;
    window *windows;
    size_t n, room;
    uint64_t most;
    arrival *arrival;   /* of vertices */
    occupant *occupant; /* of edges: of the corner opposite to each */
    vvi_heap heap;
    double shortest; /* known */
} search;

typedef struct point {
    double x, y;
} point;

static double apart(point a, point b)
{
    const double x = a.x - b.x, y = a.y - b.y;
    return sqrt(x * x + y * y);
}

/* The corner opposite to an edge, in the plane of windows on it. */
static point apex_of(const vvi_path_mesh *m, uint32_t edge)
{
    const double l = m->length[edge], right = m->length[vvi_edge_next(edge)],
                 left = m->length[vvi_edge_next(vvi_edge_next(edge))];
    const double x = (l * l + left * left - right * right) / (2 * l);
    return (point){x, sqrt(fmax(0, left * left - x * x))};
}

/* Where the edge's line is crossed between the source and a point above it. */
static double crossing(const window *w, point p)
{
    return w->x + (p.x - w->x) * -w->y / (p.y - w->y);
}

static double least_to_goal(const search *s, vv_vec3 a, vv_vec3 b)
{
    const vv_vec3 goal = s->mesh->place[s->mesh->to], way = vvi_sub(b, a);
    const double square = vvi_dot(way, way), t = square > 0 ? vvi_dot(vvi_sub(goal, a), way) / square : 0;
    return vvi_length(vvi_sub(goal, vvi_add(a, vvi_scaled(way, fmax(0, fmin(1, t))))));
}

/* Vertices -----------------------------------------------------------------------------------------------------------
 */

static vv_status reach(search *s, uint32_t v, arrival a)
{
    if (!(a.distance < s->arrival[v].distance))
        return VV_OK;
    s->arrival[v] = a;
    if (v == s->mesh->to)
        s->shortest = fmin(s->shortest, a.distance);
    if (v != s->mesh->from && !s->mesh->turning[v])
        return VV_OK;
    const double key = a.distance + least_to_goal(s, s->mesh->place[v], s->mesh->place[v]);
    if (key > s->shortest)
        return VV_OK;
    return vvi_heap_push(&s->heap, (vvi_heap_item){key, a.distance, v, TURN}, s->job);
}

/* Windows ------------------------------------------------------------------------------------------------------------
 */

static bool may_enter(const search *s, uint32_t edge)
{
    const uint32_t *t = s->mesh->triangle + edge / 3 * 3;
    return !s->allowed || (s->allowed[t[0]] && s->allowed[t[1]] && s->allowed[t[2]]);
}

/* Whether all that the window sees is nearer by way of a vertex: of its edge, or `third`, the far end of the edge that
 * it came through, which is `from_third` away from the end of the interval that is nearer to that edge. */
static bool is_useless(const search *s, const window *w, double from_third, bool third_at_start, uint32_t third)
{
    const vvi_path_mesh *m = s->mesh;
    const point source = {w->x, w->y};
    const double d0 = w->before + apart(source, (point){w->b0, 0}), d1 = w->before + apart(source, (point){w->b1, 0});
    const double slack = 1e-12 * (d0 + d1);
    if (s->arrival[vvi_edge_start(m, w->edge)].distance + w->b1 < d1 - slack ||
        s->arrival[vvi_edge_end(m, w->edge)].distance + m->length[w->edge] - w->b0 < d0 - slack)
        return true;
    return third != VVI_NONE && s->arrival[third].distance + from_third < (third_at_start ? d0 : d1) - slack;
}

static vv_status keep(search *s, const window *w)
{
    const vvi_path_mesh *m = s->mesh;
    const double foot = fmax(w->b0, fmin(w->b1, w->x));
    const vv_vec3 a = m->place[vvi_edge_start(m, w->edge)], way = vvi_sub(m->place[vvi_edge_end(m, w->edge)], a);
    const double l = m->length[w->edge];
    const double key = w->before + apart((point){w->x, w->y}, (point){foot, 0}) +
                       least_to_goal(s, vvi_add(a, vvi_scaled(way, w->b0 / l)), vvi_add(a, vvi_scaled(way, w->b1 / l)));
    if (key > s->shortest)
        return VV_OK;
    if (s->n == s->room) {
        const size_t room = s->room ? 2 * s->room : 4096;
        window *windows = vvi_realloc(s->job, s->windows, room * sizeof *windows, VVI_MEM_SCRATCH);
        if (!windows)
            return vv_fail_memory(room * sizeof *windows);
        s->windows = windows;
        s->room = room;
    }
    s->windows[s->n] = *w;
    return vvi_heap_push(&s->heap, (vvi_heap_item){key, key, (uint32_t)s->n++, WINDOW}, s->job);
}

/* A window on the other side of an edge of the triangle that `w` entered. p: its ends in the plane of w; near, far:
 * interval, from the end that it shares with the edge of w, which is p[0]. `third`: the other end of that edge. */
static vv_status carry(search *s, uint32_t index, uint32_t edge, const point p[2], uint32_t shared, uint32_t third,
                       point third_at, double near, double far)
{
    const window w = s->windows[index];
    const vvi_path_mesh *m = s->mesh;
    const uint32_t twin = m->twin[edge];
    const double l = m->length[edge];
    if (twin == VVI_NONE || !(far - near > 1e-12 * l) || !may_enter(s, twin))
        return VV_OK;
    const bool same = vvi_edge_start(m, twin) == shared;
    const point start = p[same ? 0 : 1], end = p[same ? 1 : 0];
    const point u = {(end.x - start.x) / l, (end.y - start.y) / l}, to = {w.x - start.x, w.y - start.y};
    const window child = {.edge = twin,
                          .parent = index,
                          .source = w.source,
                          .b0 = same ? near : l - far,
                          .b1 = same ? far : l - near,
                          .x = u.x * to.x + u.y * to.y,
                          .y = -fabs(u.x * to.y - u.y * to.x),
                          .before = w.before};
    const double part = near / l;
    const point nearest = {p[0].x + part * (p[1].x - p[0].x), p[0].y + part * (p[1].y - p[0].y)};
    if (!(child.y < -1e-14 * l) || is_useless(s, &child, apart(third_at, nearest), same, third))
        return VV_OK;
    return keep(s, &child);
}

/* What part of the way from `from` to the apex the ray through (x, 0) hits. */
static double hit(const window *w, double x, point from, point apex)
{
    const point d = {x - w->x, -w->y}, a = {apex.x - from.x, apex.y - from.y}, b = {w->x - from.x, w->y - from.y};
    const double below = a.x * d.y - a.y * d.x;
    const double q = (b.x * d.y - b.y * d.x) / below;
    return q >= 0 ? fmin(q, 1) : 0; /* 0 for what is no number too */
}

static vv_status cross_triangle(search *s, uint32_t index)
{
    const window w = s->windows[index];
    const vvi_path_mesh *m = s->mesh;
    const uint32_t right = vvi_edge_next(w.edge), left = vvi_edge_next(right);
    const double l = m->length[w.edge];
    const point apex = apex_of(m, w.edge), start = {0, 0}, end = {l, 0};
    const uint32_t v0 = vvi_edge_start(m, w.edge), v1 = vvi_edge_end(m, w.edge);
    const double at = crossing(&w, apex);
    bool to_left = w.b0<at, to_right = w.b1> at;
    vv_status st = VV_OK;
    if (at >= w.b0 - 1e-9 * l && at <= w.b1 + 1e-9 * l) {
        const double distance = w.before + apart((point){w.x, w.y}, apex);
        occupant *o = &s->occupant[w.edge];
        st = reach(s, vvi_edge_apex(m, w.edge), (arrival){distance, index, VVI_NONE});
        if (distance < o->distance) {
            *o = (occupant){distance, at};
        } else if (distance > o->distance * (1 + 1e-12)) { /* of all windows that see a corner only one is split */
            to_left &= at <= o->at;
            to_right &= at >= o->at;
        }
    }
    if (to_left && st == VV_OK)
        st = carry(s, index, left, (const point[2]){start, apex}, v0, v1, end,
                   hit(&w, w.b0, start, apex) * m->length[left],
                   w.b1 >= at ? m->length[left] : hit(&w, w.b1, start, apex) * m->length[left]);
    if (to_right && st == VV_OK)
        st = carry(s, index, right, (const point[2]){end, apex}, v1, v0, start,
                   hit(&w, w.b1, end, apex) * m->length[right],
                   w.b0 <= at ? m->length[right] : hit(&w, w.b0, end, apex) * m->length[right]);
    return st;
}

/* A vertex becomes a source: of its edges, and of windows on the edges opposite to it. */
static vv_status turn_at(search *s, uint32_t v)
{
    const vvi_path_mesh *m = s->mesh;
    const double before = s->arrival[v].distance;
    vv_status st = VV_OK;
    for (size_t i = m->first[v]; i < m->first[v + 1] && st == VV_OK; i++) {
        const uint32_t out = m->corner[i], far = vvi_edge_next(out), in = vvi_edge_next(far), twin = m->twin[far];
        if (!may_enter(s, out))
            continue;
        if ((st = reach(s, vvi_edge_end(m, out), (arrival){before + m->length[out], VVI_NONE, v})) != VV_OK ||
            (st = reach(s, vvi_edge_start(m, in), (arrival){before + m->length[in], VVI_NONE, v})) != VV_OK)
            return st;
        if (twin == VVI_NONE || !may_enter(s, twin))
            continue;
        const point apex = apex_of(m, far); /* of v, above its edge; the twin sees it below */
        const bool same = vvi_edge_start(m, twin) == vvi_edge_start(m, far);
        const window w = {.edge = twin,
                          .parent = VVI_NONE,
                          .source = v,
                          .b0 = 0,
                          .b1 = m->length[far],
                          .x = same ? apex.x : m->length[far] - apex.x,
                          .y = -apex.y,
                          .before = before};
        if (w.y < -1e-14 * w.b1 && !is_useless(s, &w, 0, false, VVI_NONE))
            st = keep(s, &w);
    }
    return st;
}

/* *least: what is left cannot be shorter. */
static vv_status spread(search *s, double *least)
{
    enum { OFTEN = 4096 };
    vv_status st = reach(s, s->mesh->from, (arrival){0, VVI_NONE, VVI_NONE});
    for (size_t turn = 1; s->heap.n > 0 && st == VV_OK; turn++) {
        const vvi_heap_item item = vvi_heap_pop(&s->heap);
        *least = item.key;
        if (item.key >= s->shortest || s->n >= s->most)
            break;
        if (item.kind == WINDOW) {
            const window *w = &s->windows[item.index];
            st = is_useless(s, w, 0, false, VVI_NONE) ? VV_OK : cross_triangle(s, item.index);
        } else if (item.value <= s->arrival[item.index].distance) {
            st = turn_at(s, item.index);
        }
        if (st == VV_OK && turn % OFTEN == 0)
            st = vvi_job_poll(s->job);
    }
    if (s->heap.n == 0)
        *least = s->shortest;
    return st;
}

/* The path, backwards ------------------------------------------------------------------------------------------------
 */

static vv_status add_on_edge(vvi_path *path, const search *s, const window *w, double x)
{
    const vvi_path_mesh *m = s->mesh;
    const uint32_t a = vvi_edge_start(m, w->edge), b = vvi_edge_end(m, w->edge);
    const vv_vec3 p = m->place[a], way = vvi_sub(m->place[b], p);
    return vvi_path_add(path, vvi_add(p, vvi_scaled(way, x / m->length[w->edge])), a, b, s->job);
}

/* A place on the edge of window `child` in the plane of its parent. */
static point in_parent(const search *s, const window *parent, const window *child, double x)
{
    const vvi_path_mesh *m = s->mesh;
    const point corner[3] = {{0, 0}, {m->length[parent->edge], 0}, apex_of(m, parent->edge)};
    const uint32_t vertex[3] = {vvi_edge_start(m, parent->edge), vvi_edge_end(m, parent->edge),
                                vvi_edge_apex(m, parent->edge)};
    point a = corner[0], b = corner[0];
    for (int i = 0; i < 3; i++) {
        if (vertex[i] == vvi_edge_start(m, child->edge))
            a = corner[i];
        if (vertex[i] == vvi_edge_end(m, child->edge))
            b = corner[i];
    }
    const double t = x / m->length[child->edge];
    return (point){a.x + t * (b.x - a.x), a.y + t * (b.y - a.y)};
}

static vv_status add_windows(vvi_path *path, const search *s, uint32_t index)
{
    point goal = apex_of(s->mesh, s->windows[index].edge);
    vv_status st = VV_OK;
    while (index != VVI_NONE && st == VV_OK) {
        const window *w = &s->windows[index];
        const double x = fmax(w->b0, fmin(w->b1, crossing(w, goal)));
        st = add_on_edge(path, s, w, x);
        index = w->parent;
        if (index != VVI_NONE)
            goal = in_parent(s, &s->windows[index], w, x);
    }
    return st;
}

static vv_status trace(vvi_path *path, const search *s)
{
    const vvi_path_mesh *m = s->mesh;
    vv_status st = vvi_path_add(path, m->place[m->to], m->to, m->to, s->job);
    for (uint32_t v = m->to; v != m->from && st == VV_OK;) {
        const arrival *a = &s->arrival[v];
        if (a->window != VVI_NONE && s->windows)
            st = add_windows(path, s, a->window);
        v = a->window != VVI_NONE && s->windows ? s->windows[a->window].source : a->from;
        if (st == VV_OK)
            st = vvi_path_add(path, m->place[v], v, v, s->job);
    }
    vvi_path_complete(path);
    return st;
}

static vv_status find(vvi_path *path, search *s)
{
    vvi_path found = {0};
    double least = path->length;
    vv_status st = spread(s, &least);
    if (st == VV_OK && isfinite(s->arrival[s->mesh->to].distance))
        st = trace(&found, s);
    if (st == VV_OK && found.n > 0 && found.length < path->length) {
        vvi_path_finish(path);
        *path = found;
    } else {
        vvi_path_finish(&found);
    }
    path->least = fmin(least, path->length);
    return st;
}

vv_status vvi_path_shorten(vvi_path *path, const vvi_path_mesh *mesh, const bool *allowed, uint64_t max_windows,
                           vv_job *job)
{
    search s = {.mesh = mesh, .allowed = allowed, .job = job};
    s.shortest = path->length * (1 + 1e-9); /* the same path is found again, and straightened */
    s.most = max_windows < UINT32_MAX - 64 ? max_windows : UINT32_MAX - 64;
    s.arrival = vvi_alloc(job, mesh->n_vertices * sizeof *s.arrival, VVI_MEM_SCRATCH);
    s.occupant = vvi_alloc(job, 3 * mesh->n_triangles * sizeof *s.occupant, VVI_MEM_SCRATCH);
    vv_status st = VV_OK;
    if (!s.arrival || !s.occupant) {
        st = vv_fail_memory(3 * mesh->n_triangles * sizeof *s.occupant);
    } else {
        for (size_t v = 0; v < mesh->n_vertices; v++)
            s.arrival[v] = (arrival){INFINITY, VVI_NONE, VVI_NONE};
        for (size_t e = 0; e < 3 * mesh->n_triangles; e++)
            s.occupant[e] = (occupant){INFINITY, 0};
        st = find(path, &s);
    }
    vvi_free(s.windows);
    vvi_free(s.arrival);
    vvi_free(s.occupant);
    vvi_free(s.heap.items);
    return st;
}
