/* Meshes whose vertices have one place on textures each. */
#include "core/job.h"
#include "core/memory.h"
#include "grid/mesh.h"

#include <string.h>

enum { POLL = 1 << 16 };
#define NONE UINT32_MAX

/* Vertices with a coordinate: those of one vertex follow each other. */
typedef struct pairs {
    uint32_t *first; /* of each vertex: a pair, NONE: none */
    uint32_t *vertex, *coordinate, *next;
    size_t n;
} pairs;

static uint32_t find_or_add(pairs *p, uint32_t vertex, uint32_t coordinate)
{
    uint32_t at = p->first[vertex];
    while (at != NONE && p->coordinate[at] != coordinate)
        at = p->next[at];
    if (at != NONE)
        return at;
    at = (uint32_t)p->n++;
    p->vertex[at] = vertex;
    p->coordinate[at] = coordinate;
    p->next[at] = p->first[vertex];
    p->first[vertex] = at;
    return at;
}

/* *corner: of each triangle's corners its pair. */
static vv_status pair(pairs *p, uint32_t *corner, const vv_mesh_info *m, vv_job *job)
{
    vv_status st = VV_OK;
    memset(p->first, 0xff, m->n_vertices * sizeof *p->first);
    for (size_t k = 0; k < 3 * m->n_triangles && st == VV_OK; k++) {
        corner[k] = find_or_add(p, m->triangles[k], m->coordinate_of[k]);
        st = k % POLL ? VV_OK : vvi_job_poll(job);
    }
    return st;
}

static vv_status make(vv_mesh **out, const vv_mesh *mesh, const pairs *p, const uint32_t *corner, vv_job *job)
{
    const vv_mesh_info *m = vv_mesh_get_info(mesh);
    vv_mesh_info info = *m;
    vvi_mesh_arrays a;
    info.n_vertices = info.n_coordinates = p->n;
    const vv_status st = vvi_mesh_new(out, &a, &info, vvi_mesh_with(mesh) & ~(unsigned)VVI_MESH_CORNERS, job);
    if (st != VV_OK)
        return st;
    for (size_t i = 0; i < p->n; i++) {
        const size_t v = p->vertex[i], c = p->coordinate[i];
        memcpy(a.positions + 3 * i, m->positions + 3 * v, 3 * sizeof *a.positions);
        if (a.normals)
            memcpy(a.normals + 3 * i, m->normals + 3 * v, 3 * sizeof *a.normals);
        if (a.values)
            a.values[i] = m->values[v];
        if (a.colors)
            memcpy(a.colors + 4 * i, m->colors + 4 * v, 4);
        memcpy(a.coordinates + 2 * i, m->coordinates + 2 * c, 2 * sizeof *a.coordinates);
    }
    memcpy(a.triangles, corner, 3 * m->n_triangles * sizeof *a.triangles);
    if (m->n_parts)
        memcpy(a.parts, m->parts, m->n_parts * sizeof *a.parts);
    vvi_mesh_take_textures(*out, mesh);
    return VV_OK;
}

vv_status vvi_mesh_split_corners(vv_mesh **out, const vv_mesh *mesh, vv_job *job)
{
    const vv_mesh_info *m = vv_mesh_get_info(mesh);
    *out = NULL;
    if (!m->coordinate_of) {
        *out = vv_mesh_retain(mesh);
        return VV_OK;
    }
    const size_t n = 3 * m->n_triangles, bytes = (m->n_vertices + 4 * n + 1) * sizeof(uint32_t);
    uint32_t *room = vvi_alloc(job, bytes, VVI_MEM_SCRATCH);
    if (!room)
        return vv_fail_memory(bytes);
    pairs p = {.first = room, .vertex = room + m->n_vertices};
    p.coordinate = p.vertex + n;
    p.next = p.coordinate + n;
    uint32_t *corner = p.next + n;
    vv_status st = pair(&p, corner, m, job);
    if (st == VV_OK)
        st = make(out, mesh, &p, corner, job);
    vvi_free(room);
    return st;
}
