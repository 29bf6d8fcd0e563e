#include "grid/mesh.h"
#include "core/memory.h"

#include <math.h>
#include <stdatomic.h>

struct vv_mesh {
    atomic_int references;
    vv_mesh_info info;
    vvi_mesh_arrays arrays;
};

static vv_status take(void *out, size_t n, size_t each, vv_job *job)
{
    size_t bytes;
    const vv_status st = vvi_mul_size(&bytes, n, each);
    if (st != VV_OK)
        return st;
    void *memory = vvi_alloc(job, bytes ? bytes : 1, VVI_MEM_DERIVED);
    *(void **)out = memory;
    return memory ? VV_OK : vv_fail_memory(bytes);
}

static vv_status take_parts(vv_mesh *m, vv_job *job)
{
    const vv_status st = take(&m->arrays.parts, m->info.n_parts, sizeof *m->arrays.parts, job);
    for (size_t i = 0; i < m->info.n_parts && st == VV_OK; i++)
        m->arrays.parts[i] = (vv_mesh_part){.color.a = -1};
    return st;
}

vv_status vvi_mesh_new(vv_mesh **out, vvi_mesh_arrays *arrays, const vv_mesh_info *info, unsigned with, vv_job *job)
{
    *out = NULL;
    if (info->n_vertices > UINT32_MAX || info->n_triangles > UINT32_MAX)
        return vv_fail(VV_E_LIMIT, "a mesh of %zu vertices and %zu triangles is too large; 2^32 of each are possible",
                       info->n_vertices, info->n_triangles);
    vv_mesh *m = vvi_alloc_zeroed(job, sizeof *m, VVI_MEM_MODEL);
    if (!m)
        return vv_fail_memory(sizeof *m);
    atomic_init(&m->references, 1);
    m->info = *info;
    vv_status st;
    const size_t point = 3 * sizeof(float);
    if ((st = take(&m->arrays.positions, info->n_vertices, point, job)) != VV_OK ||
        (st = take(&m->arrays.triangles, info->n_triangles, 3 * sizeof(uint32_t), job)) != VV_OK ||
        (with & VVI_MESH_NORMALS && (st = take(&m->arrays.normals, info->n_vertices, point, job)) != VV_OK) ||
        (with & VVI_MESH_VALUES && (st = take(&m->arrays.values, info->n_vertices, sizeof(float), job)) != VV_OK) ||
        (with & VVI_MESH_COLORS && (st = take(&m->arrays.colors, info->n_vertices, 4, job)) != VV_OK) ||
        (info->n_parts && (st = take_parts(m, job)) != VV_OK)) {
        vv_mesh_release(m);
        return st;
    }
    m->info.positions = m->arrays.positions;
    m->info.normals = m->arrays.normals;
    m->info.values = m->arrays.values;
    m->info.colors = m->arrays.colors;
    m->info.triangles = m->arrays.triangles;
    m->info.parts = m->arrays.parts;
    *arrays = m->arrays;
    *out = m;
    return VV_OK;
}

vv_mesh *vv_mesh_retain(const vv_mesh *mesh)
{
    vv_mesh *m = (vv_mesh *)mesh; /* only the count changes */
    atomic_fetch_add_explicit(&m->references, 1, memory_order_relaxed);
    return m;
}

void vv_mesh_release(vv_mesh *mesh)
{
    if (!mesh || atomic_fetch_sub_explicit(&mesh->references, 1, memory_order_acq_rel) != 1)
        return;
    vvi_free(mesh->arrays.positions);
    vvi_free(mesh->arrays.normals);
    vvi_free(mesh->arrays.values);
    vvi_free(mesh->arrays.colors);
    vvi_free(mesh->arrays.triangles);
    vvi_free(mesh->arrays.parts);
    vvi_free(mesh);
}

const vv_mesh_info *vv_mesh_get_info(const vv_mesh *mesh)
{
    return &mesh->info;
}

vv_bounds vv_mesh_bounds(const vv_mesh *mesh)
{
    const vv_mesh_info *m = &mesh->info;
    vv_bounds b = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
    double *lo = &b.lo.x, *hi = &b.hi.x;
    for (size_t i = 0; i < m->n_vertices; i++)
        for (int a = 0; a < 3; a++) {
            const double v = m->positions[3 * i + (size_t)a];
            lo[a] = v < lo[a] ? v : lo[a];
            hi[a] = v > hi[a] ? v : hi[a];
        }
    for (int a = 0; a < 3; a++) {
        lo[a] += (&m->origin.x)[a];
        hi[a] += (&m->origin.x)[a];
    }
    return b;
}
