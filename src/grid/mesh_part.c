/* One part of a mesh, as a mesh of its own. */
#include "core/memory.h"
#include "grid/mesh.h"

#include <string.h>

/* New numbers of the vertices of the part, in their old order; UINT32_MAX: it is not one. */
static vv_status number_vertices(uint32_t **number_out, size_t *n_out, const vv_mesh_info *m, const vv_mesh_part *part,
                                 vv_job *job)
{
    uint32_t *number = vvi_alloc(job, (m->n_vertices + 1) * sizeof *number, VVI_MEM_SCRATCH);
    const uint32_t *corner = m->triangles + 3 * part->first_triangle;
    size_t n = 0;
    *number_out = number;
    if (!number)
        return vv_fail_memory((m->n_vertices + 1) * sizeof *number);
    memset(number, 0xff, m->n_vertices * sizeof *number);
    for (size_t k = 0; k < 3 * part->n_triangles; k++)
        number[corner[k]] = 0;
    for (size_t v = 0; v < m->n_vertices; v++)
        if (number[v] == 0)
            number[v] = (uint32_t)n++;
    *n_out = n;
    return VV_OK;
}

static void fill(vvi_mesh_arrays *a, const vv_mesh_info *m, const vv_mesh_part *part, const uint32_t *number)
{
    const uint32_t *corner = m->triangles + 3 * part->first_triangle;
    for (size_t v = 0; v < m->n_vertices; v++) {
        const size_t to = number[v];
        if (to == UINT32_MAX)
            continue;
        memcpy(a->positions + 3 * to, m->positions + 3 * v, 3 * sizeof *a->positions);
        if (m->normals)
            memcpy(a->normals + 3 * to, m->normals + 3 * v, 3 * sizeof *a->normals);
        if (m->values)
            a->values[to] = m->values[v];
        if (m->colors)
            memcpy(a->colors + 4 * to, m->colors + 4 * v, 4);
        if (m->coordinates && !m->coordinate_of)
            memcpy(a->coordinates + 2 * to, m->coordinates + 2 * v, 2 * sizeof *a->coordinates);
    }
    for (size_t k = 0; k < 3 * part->n_triangles; k++)
        a->triangles[k] = number[corner[k]];
    if (m->coordinates && m->coordinate_of) { /* coordinates of other parts stay */
        memcpy(a->coordinates, m->coordinates, 2 * m->n_coordinates * sizeof *a->coordinates);
        memcpy(a->coordinate_of, m->coordinate_of + 3 * part->first_triangle,
               3 * part->n_triangles * sizeof *a->coordinate_of);
    }
    a->parts[0] = *part;
    a->parts[0].first_triangle = 0;
}

vv_status vvi_mesh_part(vv_mesh **out, const vv_mesh *mesh, size_t index, vv_job *job)
{
    const vv_mesh_info *m = vv_mesh_get_info(mesh);
    vv_mesh_info info = *m;
    vvi_mesh_arrays a;
    uint32_t *number;
    *out = NULL;
    vv_status st = number_vertices(&number, &info.n_vertices, m, &m->parts[index], job);
    info.n_triangles = m->parts[index].n_triangles;
    info.n_parts = 1;
    info.n_coordinates = m->coordinate_of ? m->n_coordinates : info.n_vertices;
    if (st == VV_OK && (st = vvi_mesh_new(out, &a, &info, vvi_mesh_arrays_of(m), job)) == VV_OK) {
        fill(&a, m, &m->parts[index], number);
        vvi_mesh_take_textures(*out, mesh);
    }
    vvi_free(number);
    return st;
}
