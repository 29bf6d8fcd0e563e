#include "measure/closed.h"
#include "core/job.h"
#include "core/memory.h"

#include <stdlib.h>
#include <string.h>

/* Numbers of vertices such that those at the same place have the same: that of the first of them. */
typedef struct places {
    uint32_t *number;
    uint32_t *table; /* open addressing; UINT32_MAX: free */
    size_t mask;
} places;

static uint64_t hash_place(const float *p)
{
    uint32_t bits[3];
    const float clean[3] = {p[0] + 0.0f, p[1] + 0.0f, p[2] + 0.0f}; /* -0 becomes 0 */
    memcpy(bits, clean, sizeof bits);
    uint64_t z = ((uint64_t)bits[0] << 32 | bits[1]) * 0x9e3779b97f4a7c15u;
    z = (z ^ z >> 29 ^ bits[2]) * 0xbf58476d1ce4e5b9u;
    return z ^ z >> 32;
}

static uint32_t find_or_add(places *p, const float *positions, uint32_t vertex)
{
    const float *at = positions + 3 * (size_t)vertex;
    for (size_t i = hash_place(at) & p->mask;; i = (i + 1) & p->mask) {
        if (p->table[i] == UINT32_MAX)
            return p->table[i] = vertex;
        const float *other = positions + 3 * (size_t)p->table[i];
        if (other[0] == at[0] && other[1] == at[1] && other[2] == at[2])
            return p->table[i];
    }
}

static vv_status number_places(places *p, const vv_mesh_info *mesh, vv_job *job)
{
    size_t room = 16;
    while (room < 2 * mesh->n_vertices)
        room *= 2;
    p->mask = room - 1;
    p->number = vvi_alloc(job, (mesh->n_vertices + 1) * sizeof *p->number, VVI_MEM_SCRATCH);
    p->table = vvi_alloc(job, room * sizeof *p->table, VVI_MEM_SCRATCH);
    if (!p->number || !p->table)
        return vv_fail_memory(room * sizeof *p->table);
    memset(p->table, 0xff, room * sizeof *p->table);
    for (size_t v = 0; v < mesh->n_vertices; v++)
        p->number[v] = find_or_add(p, mesh->positions, (uint32_t)v);
    return vvi_job_poll(job);
}

/* The ends of edges by the lower of their vertices: those of vertex v are from first[v] to first[v + 1]. */
typedef struct edge_end {
    uint32_t high;
    int32_t way; /* 1: from low to high */
} edge_end;

typedef struct edge_lists {
    size_t *first;
    edge_end *ends;
} edge_lists;

static void ends_of(uint32_t low_high[2], int32_t *way, const places *p, const uint32_t *triangle, size_t side)
{
    const uint32_t a = p->number[triangle[side]], b = p->number[triangle[(side + 1) % 3]];
    *way = a < b ? 1 : -1;
    low_high[0] = a < b ? a : b;
    low_high[1] = a < b ? b : a;
}

static vv_status list_edges(edge_lists *l, const places *p, size_t n_vertices, const uint32_t *triangles, size_t n,
                            vv_job *job)
{
    uint32_t edge[2];
    int32_t way;
    l->first = vvi_alloc_zeroed(job, (n_vertices + 2) * sizeof *l->first, VVI_MEM_SCRATCH);
    l->ends = vvi_alloc(job, (3 * n + 1) * sizeof *l->ends, VVI_MEM_SCRATCH);
    if (!l->first || !l->ends)
        return vv_fail_memory((3 * n + 1) * sizeof *l->ends);
    size_t *next = l->first + 1;
    for (size_t i = 0; i < 3 * n; i++) {
        ends_of(edge, &way, p, triangles + i / 3 * 3, i % 3);
        next[edge[0] + 1]++;
    }
    for (size_t v = 1; v <= n_vertices; v++)
        next[v] += next[v - 1];
    for (size_t i = 0; i < 3 * n; i++) {
        ends_of(edge, &way, p, triangles + i / 3 * 3, i % 3);
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
    places p = {0};
    edge_lists l = {0};
    vv_status st;
    *n_out = 0;
    if ((st = number_places(&p, mesh, job)) == VV_OK &&
        (st = list_edges(&l, &p, mesh->n_vertices, triangles, n, job)) == VV_OK)
        count_open(n_out, first_out, &l, mesh->n_vertices);
    vvi_free(p.number);
    vvi_free(p.table);
    vvi_free(l.first);
    vvi_free(l.ends);
    return st;
}
