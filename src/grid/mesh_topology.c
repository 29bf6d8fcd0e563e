/* Edges of a mesh, counted. Each run of a triangle along an edge goes to the lower of its two vertices: those that go
 * up from the front of the vertex's room, those that come down from its back, so that nothing but the other vertex is
 * kept. Sorted, the two lists then tell for each edge how many triangles run along it each way. */
#include "core/job.h"
#include "core/memory.h"
#include "grid/mesh.h"
#include <volvis/mesh.h>

#include <stdlib.h>
#include <string.h>

/* Work between two looks at whether the job is cancelled. */
enum { BLOCK = 1 << 16, SHORT_LIST = 16 };

typedef struct edges {
    const vv_mesh_info *mesh;
    const uint32_t *place; /* of each vertex the one that stands for it; NULL: itself */
    uint64_t *begin;       /* n_vertices + 1: of the room of each vertex */
    uint64_t *up;          /* n_vertices: the next free place at the front */
    uint64_t *down;        /* n_vertices: one after the next free place at the back */
    uint32_t *other;
} edges;

/* The corners of a triangle, as those that stand for them. */
static void corners_of(uint32_t out[3], const edges *e, size_t triangle)
{
    const uint32_t *t = e->mesh->triangles + 3 * triangle;
    for (size_t i = 0; i < 3; i++)
        out[i] = e->place ? e->place[t[i]] : t[i];
}

static bool is_degenerate(const uint32_t *t)
{
    return t[0] == t[1] || t[1] == t[2] || t[2] == t[0];
}

static bool has_no_area(const vv_mesh_info *m, const uint32_t *t)
{
    double u[3], v[3];
    for (size_t a = 0; a < 3; a++) {
        const double at = m->positions[3 * (size_t)t[0] + a];
        u[a] = m->positions[3 * (size_t)t[1] + a] - at;
        v[a] = m->positions[3 * (size_t)t[2] + a] - at;
    }
    return u[1] * v[2] == u[2] * v[1] && u[2] * v[0] == u[0] * v[2] && u[0] * v[1] == u[1] * v[0];
}

/* Rooms ----------------------------------------------------------------------------------------------------------- */

static vv_status take(edges *e, vv_job *job)
{
    const size_t n = e->mesh->n_vertices, edges_most = 3 * e->mesh->n_triangles;
    size_t bytes;
    vv_status st = vvi_mul_size(&bytes, 3 * (n + 1), sizeof *e->begin);
    if (st != VV_OK)
        return st;
    if (!(e->begin = vvi_alloc_zeroed(job, bytes, VVI_MEM_SCRATCH)))
        return vv_fail_memory(bytes);
    e->up = e->begin + n + 1;
    e->down = e->up + n;
    bytes = (edges_most + 1) * sizeof *e->other;
    e->other = vvi_alloc(job, bytes, VVI_MEM_SCRATCH);
    return e->other ? VV_OK : vv_fail_memory(bytes);
}

/* How many edges each vertex is the lower end of, then where their rooms begin. */
static vv_status measure_rooms(edges *e, const vv_job *job)
{
    const vv_mesh_info *m = e->mesh;
    for (size_t t = 0; t < m->n_triangles; t++) {
        uint32_t v[3];
        corners_of(v, e, t);
        if (t % BLOCK == 0 && vvi_job_poll(job) != VV_OK)
            return VV_E_CANCELLED;
        if (is_degenerate(v))
            continue;
        for (size_t i = 0; i < 3; i++) {
            const uint32_t a = v[i], b = v[(i + 1) % 3];
            e->begin[(a < b ? a : b) + 1]++;
        }
    }
    for (size_t i = 0; i < m->n_vertices; i++) {
        e->begin[i + 1] += e->begin[i];
        e->up[i] = e->begin[i];
        e->down[i] = e->begin[i + 1];
    }
    return VV_OK;
}

static vv_status fill_rooms(edges *e, const vv_job *job)
{
    const vv_mesh_info *m = e->mesh;
    for (size_t t = 0; t < m->n_triangles; t++) {
        uint32_t v[3];
        corners_of(v, e, t);
        if (t % BLOCK == 0 && vvi_job_poll(job) != VV_OK)
            return VV_E_CANCELLED;
        if (is_degenerate(v))
            continue;
        for (size_t i = 0; i < 3; i++) {
            const uint32_t a = v[i], b = v[(i + 1) % 3];
            if (a < b)
                e->other[e->up[a]++] = b;
            else
                e->other[--e->down[b]] = a;
        }
    }
    return VV_OK;
}

/* Counting -------------------------------------------------------------------------------------------------------- */

static int compare(const void *a, const void *b)
{
    const uint32_t x = *(const uint32_t *)a, y = *(const uint32_t *)b;
    return (x > y) - (x < y);
}

static void sort(uint32_t *v, size_t n)
{
    if (n > SHORT_LIST) {
        qsort(v, n, sizeof *v, compare);
        return;
    }
    for (size_t i = 1; i < n; i++) {
        const uint32_t x = v[i];
        size_t j = i;
        for (; j > 0 && v[j - 1] > x; j--)
            v[j] = v[j - 1];
        v[j] = x;
    }
}

/* How many in a row are the vertex; past them. */
static size_t run_of(const uint32_t **at, const uint32_t *end, uint32_t vertex)
{
    const uint32_t *first = *at;
    while (*at < end && **at == vertex)
        ++*at;
    return (size_t)(*at - first);
}

static void count_vertex(vvi_mesh_edges *out, const edges *e, size_t vertex)
{
    const uint64_t begin = e->begin[vertex], middle = e->up[vertex], end = e->begin[vertex + 1];
    sort(e->other + begin, (size_t)(middle - begin));
    sort(e->other + middle, (size_t)(end - middle));
    const uint32_t *up = e->other + begin, *up_end = e->other + middle, *down = up_end, *down_end = e->other + end;
    while (up < up_end || down < down_end) {
        const uint32_t to = down == down_end || (up < up_end && *up < *down) ? *up : *down;
        const size_t n_up = run_of(&up, up_end, to), n_down = run_of(&down, down_end, to);
        out->n++;
        out->open += n_up + n_down == 1;
        out->crowded += n_up + n_down > 2;
        out->turned += n_up + n_down == 2 && n_up != 1;
        if (n_up != n_down && out->uneven++ == 0) {
            out->first[0] = (uint32_t)vertex;
            out->first[1] = to;
        }
    }
}

/* Pieces ---------------------------------------------------------------------------------------------------------- */

static vv_status count_pieces(vv_mesh_topology *out, const vv_mesh *mesh, vv_job *job)
{
    const vv_mesh_info *m = vv_mesh_get_info(mesh);
    uint32_t *first = NULL;
    uint8_t *used = vvi_alloc_zeroed(job, m->n_vertices + 1, VVI_MEM_SCRATCH);
    const vv_status st = used ? vvi_mesh_number_pieces(&first, mesh, job) : vv_fail_memory(m->n_vertices + 1);
    for (size_t i = 0; i < 3 * m->n_triangles && st == VV_OK; i++)
        used[m->triangles[i]] = 1;
    for (size_t i = 0; i < m->n_vertices && st == VV_OK; i++) {
        out->n_unused += !used[i];
        out->n_pieces += used[i] && first[i] == i;
    }
    vvi_free(first);
    vvi_free(used);
    return st;
}

vv_status vvi_mesh_count_edges(vvi_mesh_edges *out, const vv_mesh_info *mesh, const uint32_t *place, vv_job *job)
{
    edges e = {.mesh = mesh, .place = place};
    *out = (vvi_mesh_edges){0};
    vv_status st = take(&e, job);
    if (st == VV_OK && (st = measure_rooms(&e, job)) == VV_OK)
        st = fill_rooms(&e, job);
    for (size_t v = 0; v < mesh->n_vertices && st == VV_OK; v++) {
        if (v % BLOCK == 0)
            st = vvi_job_poll(job);
        count_vertex(out, &e, v);
    }
    vvi_free(e.begin);
    vvi_free(e.other);
    return st;
}

vv_status vv_mesh_count_topology(vv_mesh_topology *out, const vv_mesh *mesh, vv_job *job)
{
    const vv_mesh_info *m = vv_mesh_get_info(mesh);
    vvi_mesh_edges found;
    const vv_status st = vvi_mesh_count_edges(&found, m, NULL, job);
    *out = (vv_mesh_topology){.n_edges = found.n,
                              .n_open_edges = found.open,
                              .n_crowded_edges = found.crowded,
                              .n_turned_edges = found.turned};
    for (size_t t = 0; t < m->n_triangles && st == VV_OK; t++) {
        const uint32_t *v = m->triangles + 3 * t;
        out->n_degenerate += is_degenerate(v) || has_no_area(m, v);
    }
    return st == VV_OK ? count_pieces(out, mesh, job) : st;
}
