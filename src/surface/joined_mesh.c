#include "surface/joined_mesh.h"
#include "grid/mesh.h"

#include <string.h>

/* The arrays that all meshes have. */
static unsigned common(vv_mesh *const *meshes, size_t n)
{
    unsigned with = VVI_MESH_NORMALS | VVI_MESH_VALUES | VVI_MESH_COLORS;
    for (size_t i = 0; i < n; i++) {
        const vv_mesh_info *m = vv_mesh_get_info(meshes[i]);
        if (!m->n_vertices)
            continue;
        with &= (m->normals ? ~0u : ~(unsigned)VVI_MESH_NORMALS) & (m->values ? ~0u : ~(unsigned)VVI_MESH_VALUES) &
                (m->colors ? ~0u : ~(unsigned)VVI_MESH_COLORS);
    }
    return with;
}

static void copy_vertices(const vvi_mesh_arrays *to, size_t first, const vv_mesh_info *m, vv_vec3 origin)
{
    const double shift[3] = {m->origin.x - origin.x, m->origin.y - origin.y, m->origin.z - origin.z};
    float *p = to->positions + 3 * first;
    for (size_t i = 0; i < 3 * m->n_vertices; i++)
        p[i] = (float)((double)m->positions[i] + shift[i % 3]);
    if (!m->n_vertices)
        return;
    if (to->normals)
        memcpy(to->normals + 3 * first, m->normals, 3 * m->n_vertices * sizeof(float));
    if (to->values)
        memcpy(to->values + first, m->values, m->n_vertices * sizeof(float));
    if (to->colors)
        memcpy(to->colors + 4 * first, m->colors, 4 * m->n_vertices);
}

vv_status vvi_mesh_join(vv_mesh **out, vv_mesh *const *meshes, const vv_mesh_part *parts, size_t n, vv_job *job)
{
    vv_mesh_info info = *vv_mesh_get_info(meshes[0]);
    vvi_mesh_arrays to;
    info.n_vertices = info.n_triangles = 0;
    info.n_parts = n;
    for (size_t i = 0; i < n; i++) {
        info.n_vertices += vv_mesh_get_info(meshes[i])->n_vertices;
        info.n_triangles += vv_mesh_get_info(meshes[i])->n_triangles;
    }
    const vv_status st = vvi_mesh_new(out, &to, &info, common(meshes, n), job);
    if (st != VV_OK)
        return st;
    size_t vertex = 0, triangle = 0;
    for (size_t i = 0; i < n; i++) {
        const vv_mesh_info *m = vv_mesh_get_info(meshes[i]);
        copy_vertices(&to, vertex, m, info.origin);
        for (size_t t = 0; t < 3 * m->n_triangles; t++)
            to.triangles[3 * triangle + t] = m->triangles[t] + (uint32_t)vertex;
        to.parts[i] = parts[i];
        to.parts[i].first_triangle = triangle;
        to.parts[i].n_triangles = m->n_triangles;
        vertex += m->n_vertices;
        triangle += m->n_triangles;
    }
    return VV_OK;
}
