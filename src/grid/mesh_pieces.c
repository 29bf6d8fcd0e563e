/* Union-find: vertices point to others of their piece, the first of it to itself. */
#include "core/job.h"
#include "core/memory.h"
#include "grid/mesh.h"

enum { POLL = 1 << 16 };

static uint32_t first_of(uint32_t *parent, uint32_t v)
{
    while (parent[v] != v) {
        parent[v] = parent[parent[v]];
        v = parent[v];
    }
    return v;
}

static void join(uint32_t *parent, uint32_t a, uint32_t b)
{
    a = first_of(parent, a);
    b = first_of(parent, b);
    if (a < b)
        parent[b] = a;
    else
        parent[a] = b;
}

static uint32_t at(const uint32_t *place, size_t v)
{
    return place ? place[v] : (uint32_t)v;
}

vv_status vvi_mesh_number_placed_pieces(uint32_t **out, const vv_mesh_info *m, const uint32_t *place, vv_job *job)
{
    const size_t bytes = (m->n_vertices + 1) * sizeof(uint32_t);
    uint32_t *parent = *out = vvi_alloc(job, bytes, VVI_MEM_SCRATCH);
    vv_status st = parent ? VV_OK : vv_fail_memory(bytes);
    for (size_t v = 0; v < m->n_vertices && st == VV_OK; v++)
        parent[v] = at(place, v);
    for (size_t t = 0; t < m->n_triangles && st == VV_OK; t++) {
        const uint32_t *v = m->triangles + 3 * t;
        if (t % POLL == 0)
            st = vvi_job_poll(job);
        join(parent, at(place, v[0]), at(place, v[1]));
        join(parent, at(place, v[0]), at(place, v[2]));
    }
    for (size_t v = 0; v < m->n_vertices && st == VV_OK; v++) /* the first of a piece comes before the others */
        parent[v] = parent[parent[v]];
    if (st != VV_OK) {
        vvi_free(parent);
        *out = NULL;
    }
    return st;
}

vv_status vvi_mesh_number_pieces(uint32_t **out, const vv_mesh *mesh, vv_job *job)
{
    return vvi_mesh_number_placed_pieces(out, vv_mesh_get_info(mesh), NULL, job);
}
