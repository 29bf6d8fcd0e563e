#include "surface/chosen_triangles.h"
#include "core/memory.h"
#include "grid/mesh.h"
#include "grid/mesh_normals.h"

#include <string.h>

#define NONE UINT32_MAX

static size_t n_parts(const vvi_chosen *c)
{
    return c->parts ? c->mesh->n_parts : 0;
}

/* Vertices in their old order. How many there are. */
static size_t number_vertices(uint32_t *number, uint32_t *vertex, const vvi_chosen *c)
{
    const size_t n_all = c->mesh->n_vertices + c->n_copies;
    size_t n = 0;
    memset(number, 0xff, n_all * sizeof *number);
    for (size_t k = 0; k < 3 * c->n; k++)
        number[c->triangles[k]] = 0;
    for (size_t v = 0; v < n_all; v++)
        if (number[v] == 0) {
            vertex[n] = vvi_chosen_original(c, (uint32_t)v);
            number[v] = (uint32_t)n++;
        }
    return n;
}

static vv_status make(vv_mesh **out, const vvi_chosen *c, uint32_t *number, uint32_t *vertex, vv_job *job)
{
    const vv_mesh_info *m = c->mesh;
    const unsigned with =
        (m->normals ? VVI_MESH_NORMALS : 0u) | (m->values ? VVI_MESH_VALUES : 0u) | (m->colors ? VVI_MESH_COLORS : 0u);
    vvi_mesh_arrays a;
    vv_mesh_info info = *m;
    info.n_vertices = number_vertices(number, vertex, c);
    info.n_triangles = c->n;
    const vv_status st = vvi_mesh_new(out, &a, &info, with, job);
    if (st != VV_OK)
        return st;
    for (size_t i = 0; i < info.n_vertices; i++) {
        const size_t v = vertex[i];
        memcpy(a.positions + 3 * i, m->positions + 3 * v, 3 * sizeof *a.positions);
        if (m->values)
            a.values[i] = m->values[v];
        if (m->colors)
            memcpy(a.colors + 4 * i, m->colors + 4 * v, 4);
    }
    for (size_t k = 0; k < 3 * c->n; k++)
        a.triangles[k] = number[c->triangles[k]];
    if (n_parts(c))
        memcpy(a.parts, c->parts, n_parts(c) * sizeof *a.parts);
    vvi_mesh_leave_textures(*out);
    return m->normals ? vvi_normals_of(a.normals, a.positions, info.n_vertices, a.triangles, info.n_triangles, job)
                      : VV_OK;
}

vv_status vvi_chosen_mesh(vv_mesh **out, const vvi_chosen *c, vv_job *job)
{
    const size_t bytes = (c->mesh->n_vertices + c->n_copies + 1) * sizeof(uint32_t);
    uint32_t *number = vvi_alloc(job, bytes, VVI_MEM_SCRATCH), *vertex = vvi_alloc(job, bytes, VVI_MEM_SCRATCH);
    *out = NULL;
    const vv_status st = number && vertex ? make(out, c, number, vertex, job) : vv_fail_memory(bytes);
    vvi_free(number);
    vvi_free(vertex);
    if (st != VV_OK) {
        vv_mesh_release(*out);
        *out = NULL;
    }
    return st;
}

/* Some of it --------------------------------------------------------------------------------------------------------
 */

/* Numbers the vertices of some triangles in the order in which they come. How many there are. */
static size_t number_few(uint32_t *number, const uint32_t *triangles, size_t n)
{
    uint32_t next = 0;
    for (size_t k = 0; k < 3 * n; k++)
        if (number[triangles[k]] == NONE)
            number[triangles[k]] = next++;
    return next;
}

/* Their places and back numbers, and the triangles by the new ones. `number` is as it was then. */
static void take_few(float *positions, uint32_t *vertex, uint32_t *to, uint32_t *number, const vvi_chosen *c,
                     const uint32_t *triangles, size_t n)
{
    uint32_t next = 0;
    for (size_t k = 0; k < 3 * n; k++) {
        const uint32_t v = triangles[k];
        if (number[v] == next) {
            memcpy(positions + 3 * (size_t)next, c->mesh->positions + 3 * (size_t)vvi_chosen_original(c, v),
                   3 * sizeof *positions);
            vertex[next++] = v;
        }
        to[k] = number[v];
    }
    for (size_t i = 0; i < next; i++)
        number[vertex[i]] = NONE;
}

static void forget_few(uint32_t *number, const uint32_t *triangles, size_t n)
{
    for (size_t k = 0; k < 3 * n; k++)
        number[triangles[k]] = NONE;
}

vv_status vvi_chosen_places(vv_mesh **out, uint32_t **vertex_out, const vvi_chosen *c, uint32_t *number, vv_job *job)
{
    vvi_mesh_arrays a;
    vv_mesh_info info = *c->mesh;
    info.n_vertices = number_few(number, c->triangles, c->n);
    info.n_triangles = c->n;
    info.n_parts = n_parts(c);
    *vertex_out = NULL;
    const vv_status st = vvi_mesh_new(out, &a, &info, 0, job);
    if (st == VV_OK && (*vertex_out = vvi_alloc(job, (info.n_vertices + 1) * sizeof **vertex_out, VVI_MEM_SCRATCH))) {
        take_few(a.positions, *vertex_out, a.triangles, number, c, c->triangles, c->n);
        if (n_parts(c))
            memcpy(a.parts, c->parts, n_parts(c) * sizeof *a.parts);
        return VV_OK;
    }
    forget_few(number, c->triangles, c->n);
    if (st != VV_OK)
        return st;
    vv_mesh_release(*out);
    *out = NULL;
    return vv_fail_memory((info.n_vertices + 1) * sizeof **vertex_out);
}

/* Copies ------------------------------------------------------------------------------------------------------------
 */

/* For each vertex of `made` what it is called. */
static void name_vertices(vvi_chosen *c, uint32_t *name, const vv_mesh_info *made, uint32_t *number)
{
    for (size_t k = 0; k < 3 * c->n; k++) {
        const uint32_t v = c->triangles[k];
        uint32_t *mine = &name[made->triangles[k]];
        if (*mine == NONE && number[v] == NONE) {
            number[v] = v;
            *mine = v;
        } else if (*mine == NONE) {
            *mine = (uint32_t)(c->mesh->n_vertices + c->n_copies);
            c->copied[c->n_copies++] = v;
        }
    }
}

vv_status vvi_chosen_tell_copies(vvi_chosen *c, const vv_mesh_info *made, uint32_t *number, vv_job *job)
{
    const size_t bytes = (made->n_vertices + 1) * sizeof(uint32_t);
    uint32_t *name = vvi_alloc(job, bytes, VVI_MEM_SCRATCH), *copied = vvi_alloc(job, bytes, VVI_MEM_SCRATCH);
    vvi_free(c->copied);
    c->copied = copied;
    c->n_copies = 0;
    if (name && copied) {
        memset(name, 0xff, bytes);
        name_vertices(c, name, made, number);
        forget_few(number, c->triangles, c->n);
        for (size_t k = 0; k < 3 * c->n; k++)
            c->triangles[k] = name[made->triangles[k]];
    }
    vvi_free(name);
    return name && copied ? VV_OK : vv_fail_memory(bytes);
}
