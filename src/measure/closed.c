#include "measure/closed.h"
#include "core/job.h"
#include "core/memory.h"
#include "surface/places.h"

#include <stdlib.h>

/* The ends of edges by the lower of their vertices: those of vertex v are from first[v] to first[v + 1]. */
typedef struct edge_end {
    uint32_t high;
    int32_t way; /* 1: from low to high */
} edge_end;

typedef struct edge_lists {
    size_t *first;
    edge_end *ends;
} edge_lists;

static void ends_of(uint32_t low_high[2], int32_t *way, const uint32_t *place, const uint32_t *triangle, size_t side)
{
    const uint32_t a = place[triangle[side]], b = place[triangle[(side + 1) % 3]];
    *way = a < b ? 1 : -1;
    low_high[0] = a < b ? a : b;
    low_high[1] = a < b ? b : a;
}

static vv_status list_edges(edge_lists *l, const uint32_t *place, size_t n_vertices, const uint32_t *triangles,
                            size_t n, vv_job *job)
{
    uint32_t edge[2];
    int32_t way;
    l->first = vvi_alloc_zeroed(job, (n_vertices + 2) * sizeof *l->first, VVI_MEM_SCRATCH);
    l->ends = vvi_alloc(job, (3 * n + 1) * sizeof *l->ends, VVI_MEM_SCRATCH);
    if (!l->first || !l->ends)
        return vv_fail_memory((3 * n + 1) * sizeof *l->ends);
    size_t *next = l->first + 1;
    for (size_t i = 0; i < 3 * n; i++) {
        ends_of(edge, &way, place, triangles + i / 3 * 3, i % 3);
        next[edge[0] + 1]++;
    }
    for (size_t v = 1; v <= n_vertices; v++)
        next[v] += next[v - 1];
    for (size_t i = 0; i < 3 * n; i++) {
        ends_of(edge, &way, place, triangles + i / 3 * 3, i % 3);
        l->ends[next[edge[0]]++] = (edge_end){edge[1], way};
    }
    return vvi_job_poll(job);
}

static int compare(const void *a, const void *b)
{
    const uint32_t x = ((const edge_end *)a)->high, y = ((const edge_end *)b)->high;
    return (x > y) - (x < y);
}

static void count_open(size_t *n_out, uint32_t first_out[2], edge_lists *l, size_t n_vertices)
{
    for (size_t v = 0; v < n_vertices; v++) {
        edge_end *e = l->ends + l->first[v];
        const size_t n = l->first[v + 1] - l->first[v];
        qsort(e, n, sizeof *e, compare);
        for (size_t i = 0; i < n;) {
            const uint32_t high = e[i].high;
            int64_t more = 0;
            while (i < n && e[i].high == high)
                more += e[i++].way;
            if (more == 0 || high == v)
                continue;
            if ((*n_out)++ == 0) {
                first_out[0] = (uint32_t)v;
                first_out[1] = high;
            }
        }
    }
}

vv_status vvi_open_edges(size_t *n_out, uint32_t first_out[2], const vv_mesh_info *mesh, const uint32_t *triangles,
                         size_t n, vv_job *job)
{
    uint32_t *place;
    edge_lists l = {0};
    vv_status st;
    *n_out = 0;
    if ((st = vvi_number_places(&place, mesh->positions, mesh->n_vertices, job)) == VV_OK &&
        (st = list_edges(&l, place, mesh->n_vertices, triangles, n, job)) == VV_OK)
        count_open(n_out, first_out, &l, mesh->n_vertices);
    vvi_free(place);
    vvi_free(l.first);
    vvi_free(l.ends);
    return st;
}
