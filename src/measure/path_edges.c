/* Shortest paths along edges (Dijkstra 1959), and paths themselves. */
#include "core/job.h"
#include "core/memory.h"
#include "core/vec.h"
#include "measure/heap.h"
#include "measure/path_search.h"

#include <math.h>
#include <string.h>

vv_status vvi_path_add(vvi_path *path, vv_vec3 at, uint32_t a, uint32_t b, vv_job *job)
{
    if (path->n == path->room) {
        const size_t room = path->room ? 2 * path->room : 64;
        vvi_path_place *places = vvi_realloc(job, path->places, room * sizeof *places, VVI_MEM_SCRATCH);
        if (!places)
            return vv_fail_memory(room * sizeof *places);
        path->places = places;
        path->room = room;
    }
    path->places[path->n++] = (vvi_path_place){at, {a, b}};
    return VV_OK;
}

void vvi_path_finish(vvi_path *path)
{
    vvi_free(path->places);
    *path = (vvi_path){0};
}

void vvi_path_complete(vvi_path *p)
{
    p->length = 0;
    for (size_t i = 0; i < p->n / 2; i++) {
        const vvi_path_place swap = p->places[i];
        p->places[i] = p->places[p->n - 1 - i];
        p->places[p->n - 1 - i] = swap;
    }
    for (size_t i = 1; i < p->n; i++)
        p->length += vvi_length(vvi_sub(p->places[i].at, p->places[i - 1].at));
}

typedef struct search {
    const vvi_path_mesh *mesh;
    double *distance;
    uint32_t *before;
    vvi_heap heap;
    vv_job *job;
} search;

static double as_crow_flies(const vvi_path_mesh *m, uint32_t v)
{
    return vvi_length(vvi_sub(m->place[m->to], m->place[v]));
}

static vv_status reach(search *s, uint32_t v, double distance, uint32_t before)
{
    if (!(distance < s->distance[v]))
        return VV_OK;
    s->distance[v] = distance;
    s->before[v] = before;
    return vvi_heap_push(&s->heap, (vvi_heap_item){distance + as_crow_flies(s->mesh, v), distance, v, 0}, s->job);
}

static vv_status spread(search *s)
{
    const vvi_path_mesh *m = s->mesh;
    vv_status st = reach(s, m->from, 0, VVI_NONE);
    while (s->heap.n > 0 && st == VV_OK) {
        const vvi_heap_item item = vvi_heap_pop(&s->heap);
        const uint32_t v = item.index;
        if (v == m->to)
            break;
        if (item.value > s->distance[v])
            continue;
        for (size_t i = m->first[v]; i < m->first[v + 1] && st == VV_OK; i++) {
            const uint32_t out = m->corner[i], in = vvi_edge_next(vvi_edge_next(out));
            if ((st = reach(s, vvi_edge_end(m, out), item.value + m->length[out], v)) == VV_OK)
                st = reach(s, vvi_edge_start(m, in), item.value + m->length[in], v);
        }
    }
    return st;
}

vv_status vvi_path_along_edges(vvi_path *out, const vvi_path_mesh *mesh, vv_job *job)
{
    search s = {.mesh = mesh, .job = job};
    vv_status st = VV_OK;
    *out = (vvi_path){0};
    s.distance = vvi_alloc(job, mesh->n_vertices * sizeof *s.distance, VVI_MEM_SCRATCH);
    s.before = vvi_alloc(job, mesh->n_vertices * sizeof *s.before, VVI_MEM_SCRATCH);
    if (!s.distance || !s.before)
        st = vv_fail_memory(mesh->n_vertices * sizeof *s.distance);
    for (size_t v = 0; v < mesh->n_vertices && st == VV_OK; v++)
        s.distance[v] = INFINITY;
    if (st == VV_OK && (st = spread(&s)) == VV_OK && !isfinite(s.distance[mesh->to]))
        st = vv_fail(
            VV_E_ARGUMENT,
            "there is no path along the mesh between the two points: they lie on pieces that are not connected");
    for (uint32_t v = mesh->to; v != VVI_NONE && st == VV_OK; v = s.before[v])
        st = vvi_path_add(out, mesh->place[v], v, v, job);
    vvi_path_complete(out);
    out->least = as_crow_flies(mesh, mesh->from);
    vvi_free(s.distance);
    vvi_free(s.before);
    vvi_free(s.heap.items);
    return st;
}
