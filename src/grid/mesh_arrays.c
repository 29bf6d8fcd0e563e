/* Meshes of arrays that come from outside: checked, then copied. */
#include "grid/mesh.h"
#include <math.h>
#include <string.h>

static vv_status check_finite(const float *values, size_t n_vertices, const char *what)
{
    for (size_t i = 0; values && i < 3 * n_vertices; i++)
        if (!isfinite(values[i]))
            return vv_fail(VV_E_ARGUMENT, "the %s of vertex %zu is not finite: %g, %g, %g", what, i / 3,
                           (double)values[i / 3 * 3], (double)values[i / 3 * 3 + 1], (double)values[i / 3 * 3 + 2]);
    return VV_OK;
}

static vv_status check_triangles(const vv_mesh_info *m)
{
    for (size_t i = 0; i < 3 * m->n_triangles; i++)
        if (m->triangles[i] >= m->n_vertices)
            return vv_fail(VV_E_ARGUMENT, "triangle %zu names vertex %u, but there are %zu, counted from 0", i / 3,
                           m->triangles[i], m->n_vertices);
    return VV_OK;
}

static vv_status check_text(const char *text, size_t room, const char *what)
{
    return memchr(text, 0, room)
               ? VV_OK
               : vv_fail(VV_E_ARGUMENT, "the %s of the mesh does not end within its %zu bytes", what, room);
}

static vv_status check_coordinates(const vv_mesh_info *m)
{
    const size_t n = m->coordinate_of ? 3 * m->n_triangles : 0;
    if (!m->coordinates)
        return m->coordinate_of || m->n_coordinates
                   ? vv_fail(VV_E_ARGUMENT, "the mesh counts texture coordinates but has no array of them")
                   : VV_OK;
    for (size_t i = 0; i < 2 * m->n_coordinates; i++)
        if (!isfinite(m->coordinates[i]))
            return vv_fail(VV_E_ARGUMENT, "texture coordinate %zu is not finite", i / 2);
    for (size_t i = 0; i < n; i++)
        if (m->coordinate_of[i] >= m->n_coordinates)
            return vv_fail(VV_E_ARGUMENT, "triangle %zu names texture coordinate %u, but there are %zu, counted from 0",
                           i / 3, m->coordinate_of[i], m->n_coordinates);
    return m->coordinate_of || m->n_coordinates == m->n_vertices
               ? VV_OK
               : vv_fail(VV_E_ARGUMENT, "%zu texture coordinates were given for %zu vertices", m->n_coordinates,
                         m->n_vertices);
}

static vv_status check_textures(const vv_mesh_info *m)
{
    vv_status st = VV_OK;
    if (m->n_textures && !m->textures)
        return vv_fail(VV_E_ARGUMENT, "the mesh counts textures but has no array of them");
    for (size_t i = 0; i < m->n_textures && st == VV_OK; i++) {
        const vv_mesh_texture *t = &m->textures[i];
        st = check_text(t->name, sizeof t->name, "name of a texture");
        if (st == VV_OK && (t->width < 1 || t->height < 1 || !t->pixels || t->wrap[0] < VV_WRAP_REPEAT ||
                            t->wrap[0] > VV_WRAP_CLAMP || t->wrap[1] < VV_WRAP_REPEAT || t->wrap[1] > VV_WRAP_CLAMP))
            st = vv_fail(VV_E_ARGUMENT, "texture %zu has no pixels, or goes on in no known way", i);
    }
    return st;
}

/* One after the other, all triangles. */
static vv_status check_parts(const vv_mesh_info *m)
{
    size_t next = 0;
    for (size_t i = 0; i < m->n_parts; i++) {
        const vv_mesh_part *p = &m->parts[i];
        const vv_color *c = &p->color;
        if (!isfinite(c->r) || !isfinite(c->g) || !isfinite(c->b) || !isfinite(c->a))
            return vv_fail(VV_E_ARGUMENT, "the color of part %zu is not finite", i);
        if (p->first_triangle != next || p->n_triangles > m->n_triangles - next)
            return vv_fail(VV_E_ARGUMENT,
                           "part %zu has triangles %zu to %zu: expected them from %zu on, of %zu in the mesh", i,
                           p->first_triangle, p->first_triangle + p->n_triangles, next, m->n_triangles);
        if (p->texture > m->n_textures)
            return vv_fail(VV_E_ARGUMENT, "part %zu has texture %zu, but there are %zu, counted from 1", i, p->texture,
                           m->n_textures);
        const vv_status st = check_text(p->name, sizeof p->name, "name of a part");
        if (st != VV_OK)
            return st;
        next += p->n_triangles;
    }
    if (m->n_parts && next != m->n_triangles)
        return vv_fail(VV_E_ARGUMENT, "the parts have %zu of the %zu triangles: expected all of them", next,
                       m->n_triangles);
    return VV_OK;
}

vv_status vvi_mesh_check(const vv_mesh_info *m)
{
    vv_status st;
    if ((m->n_vertices && !m->positions) || (m->n_triangles && !m->triangles) || (m->n_parts && !m->parts))
        return vv_fail(VV_E_ARGUMENT, "the mesh counts %s but has no array of them",
                       !m->positions && m->n_vertices ? "vertices"
                       : m->n_parts && !m->parts      ? "parts"
                                                      : "triangles");
    if (!isfinite(m->origin.x) || !isfinite(m->origin.y) || !isfinite(m->origin.z))
        return vv_fail(VV_E_ARGUMENT, "the origin of the mesh is not finite");
    if ((st = check_text(m->unit, sizeof m->unit, "unit")) != VV_OK ||
        (st = check_text(m->value_name, sizeof m->value_name, "name of values")) != VV_OK ||
        (st = check_text(m->value_unit, sizeof m->value_unit, "unit of values")) != VV_OK ||
        (st = check_finite(m->positions, m->n_vertices, "position")) != VV_OK ||
        (st = check_finite(m->normals, m->n_vertices, "normal")) != VV_OK || (st = check_triangles(m)) != VV_OK ||
        (st = check_coordinates(m)) != VV_OK || (st = check_textures(m)) != VV_OK)
        return st;
    return check_parts(m);
}

/* Of length 1, or 0 where it had no length. */
static void copy_normals(float *out, const float *in, size_t n)
{
    for (size_t i = 0; i < n; i++, out += 3, in += 3) {
        const double length = sqrt((double)in[0] * in[0] + (double)in[1] * in[1] + (double)in[2] * in[2]);
        for (int a = 0; a < 3; a++)
            out[a] = length > 0 ? (float)(in[a] / length) : 0;
    }
}

static void copy(void *out, const void *in, size_t bytes)
{
    if (in && bytes)
        memcpy(out, in, bytes);
}

vv_status vv_mesh_new(vv_mesh **out, const vv_mesh_info *info, vv_job *job)
{
    vvi_mesh_arrays a;
    vvi_mesh_textures *textures;
    vv_mesh_info m = *info;
    *out = NULL;
    if (m.n_vertices > UINT32_MAX || m.n_triangles > UINT32_MAX) /* before 3 of each are counted */
        return vv_fail(VV_E_LIMIT, "a mesh of %zu vertices and %zu triangles is too large; 2^32 of each are possible",
                       m.n_vertices, m.n_triangles);
    vv_status st = vvi_mesh_check(info);
    if (!m.unit[0])
        strcpy(m.unit, "units");
    if (st != VV_OK || (st = vvi_mesh_new(out, &a, &m, vvi_mesh_arrays_of(&m), job)) != VV_OK)
        return st;
    copy(a.positions, m.positions, 3 * m.n_vertices * sizeof *a.positions);
    copy(a.triangles, m.triangles, 3 * m.n_triangles * sizeof *a.triangles);
    copy(a.values, m.values, m.n_vertices * sizeof *a.values);
    copy(a.colors, m.colors, 4 * m.n_vertices);
    copy(a.parts, m.parts, m.n_parts * sizeof *a.parts);
    if (m.normals)
        copy_normals(a.normals, m.normals, m.n_vertices);
    copy(a.coordinates, m.coordinates, 2 * m.n_coordinates * sizeof *a.coordinates);
    copy(a.coordinate_of, m.coordinate_of, 3 * m.n_triangles * sizeof *a.coordinate_of);
    st = vvi_mesh_textures_copy(&textures, &m, job);
    vvi_mesh_set_textures(*out, textures);
    if (st == VV_OK)
        return VV_OK;
    vv_mesh_release(*out);
    *out = NULL;
    return st;
}
