#include "grid/mesh.h"
#include "core/memory.h"
#include "grid/crc.h"

#include <math.h>
#include <stdatomic.h>
#include <string.h>

struct vv_mesh {
    atomic_int references;
    vv_mesh_info info;
    vvi_mesh_arrays arrays;
    _Atomic uint64_t checksum; /* with bit 32 set, once somebody has asked: a shared mesh changes no more */
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

/* Without arrays. NULL, and the thread's error, when there is no memory or too much is asked for. */
static vv_mesh *new_mesh(const vv_mesh_info *info, vv_job *job)
{
    if (info->n_vertices > UINT32_MAX || info->n_triangles > UINT32_MAX) {
        vv_fail(VV_E_LIMIT, "a mesh of %zu vertices and %zu triangles is too large; 2^32 of each are possible",
                info->n_vertices, info->n_triangles);
        return NULL;
    }
    vv_mesh *m = vvi_alloc_zeroed(job, sizeof *m, VVI_MEM_MODEL);
    if (!m) {
        vv_fail_memory(sizeof *m);
        return NULL;
    }
    atomic_init(&m->references, 1);
    m->info = *info;
    return m;
}

static void show_arrays(vv_mesh *m)
{
    m->info.coordinates = m->arrays.coordinates;
    m->info.coordinate_of = m->arrays.coordinate_of;
    m->info.n_coordinates = m->arrays.coordinates ? m->info.n_coordinates : 0;
    m->info.textures = vvi_mesh_textures_get(&m->info.n_textures, m->arrays.textures);
    m->info.positions = m->arrays.positions;
    m->info.normals = m->arrays.normals;
    m->info.values = m->arrays.values;
    m->info.colors = m->arrays.colors;
    m->info.triangles = m->arrays.triangles;
    m->info.parts = m->arrays.parts;
}

vv_status vvi_mesh_new(vv_mesh **out, vvi_mesh_arrays *arrays, const vv_mesh_info *info, unsigned with, vv_job *job)
{
    vv_mesh *m = new_mesh(info, job);
    *out = NULL;
    *arrays = (vvi_mesh_arrays){0};
    if (!m)
        return vv_error_last()->status;
    vv_status st;
    const size_t point = 3 * sizeof(float);
    if ((st = take(&m->arrays.positions, info->n_vertices, point, job)) != VV_OK ||
        (st = take(&m->arrays.triangles, info->n_triangles, 3 * sizeof(uint32_t), job)) != VV_OK ||
        (with & VVI_MESH_NORMALS && (st = take(&m->arrays.normals, info->n_vertices, point, job)) != VV_OK) ||
        (with & VVI_MESH_VALUES && (st = take(&m->arrays.values, info->n_vertices, sizeof(float), job)) != VV_OK) ||
        (with & VVI_MESH_COLORS && (st = take(&m->arrays.colors, info->n_vertices, 4, job)) != VV_OK) ||
        (with & VVI_MESH_COORDINATES &&
         (st = take(&m->arrays.coordinates, info->n_coordinates, 2 * sizeof(float), job)) != VV_OK) ||
        (with & VVI_MESH_CORNERS &&
         (st = take(&m->arrays.coordinate_of, info->n_triangles, 3 * sizeof(uint32_t), job)) != VV_OK) ||
        (info->n_parts && (st = take_parts(m, job)) != VV_OK)) {
        vv_mesh_release(m);
        return st;
    }
    show_arrays(m);
    *arrays = m->arrays;
    *out = m;
    return VV_OK;
}

vv_status vvi_mesh_adopt(vv_mesh **out, const vvi_mesh_arrays *arrays, const vv_mesh_info *info, vv_job *job)
{
    vv_mesh *m = new_mesh(info, job);
    *out = m;
    if (!m)
        return vv_error_last()->status;
    m->arrays = *arrays;
    show_arrays(m);
    return VV_OK;
}

static void copy_text(char *out, size_t room, const char *text)
{
    const size_t n = strnlen(text, room - 1);
    memcpy(out, text, n);
    out[n] = 0;
}

static void copy(void *out, const void *in, size_t bytes)
{
    if (in && bytes)
        memcpy(out, in, bytes);
}

vv_status vvi_mesh_copy(vv_mesh **out, vvi_mesh_arrays *a, const vv_mesh *mesh, unsigned with, vv_job *job)
{
    const vv_mesh_info *m = &mesh->info;
    const vv_status st = vvi_mesh_new(out, a, m, with, job);
    if (st != VV_OK || !*out)
        return st;
    copy(a->positions, m->positions, 3 * m->n_vertices * sizeof *a->positions);
    copy(a->triangles, m->triangles, 3 * m->n_triangles * sizeof *a->triangles);
    copy(a->normals, a->normals ? m->normals : NULL, 3 * m->n_vertices * sizeof *a->normals);
    copy(a->values, a->values ? m->values : NULL, m->n_vertices * sizeof *a->values);
    copy(a->colors, a->colors ? m->colors : NULL, 4 * m->n_vertices);
    copy(a->parts, m->parts, m->n_parts * sizeof *a->parts);
    copy(a->coordinates, a->coordinates ? m->coordinates : NULL, 2 * m->n_coordinates * sizeof *a->coordinates);
    copy(a->coordinate_of, a->coordinate_of ? m->coordinate_of : NULL, 3 * m->n_triangles * sizeof *a->coordinate_of);
    vvi_mesh_take_textures(*out, mesh);
    return VV_OK;
}

void vvi_mesh_set_textures(vv_mesh *mesh, vvi_mesh_textures *textures)
{
    mesh->arrays.textures = textures;
    show_arrays(mesh);
}

void vvi_mesh_take_textures(vv_mesh *mesh, const vv_mesh *from)
{
    vvi_mesh_set_textures(mesh, vvi_mesh_textures_retain(from->arrays.textures));
}

void vvi_mesh_leave_textures(vv_mesh *mesh)
{
    for (size_t i = 0; i < mesh->info.n_parts; i++)
        mesh->arrays.parts[i].texture = 0;
}

unsigned vvi_mesh_arrays_of(const vv_mesh_info *m)
{
    return (m->normals ? VVI_MESH_NORMALS : 0u) | (m->values ? VVI_MESH_VALUES : 0u) |
           (m->colors ? VVI_MESH_COLORS : 0u) | (m->coordinates ? VVI_MESH_COORDINATES : 0u) |
           (m->coordinate_of ? VVI_MESH_CORNERS : 0u);
}

unsigned vvi_mesh_with(const vv_mesh *mesh)
{
    return vvi_mesh_arrays_of(&mesh->info);
}

vv_status vvi_mesh_scaled(vv_mesh **out, const vv_mesh *mesh, double factor, const char *unit, vv_job *job)
{
    vvi_mesh_arrays a;
    const vv_status st = vvi_mesh_copy(out, &a, mesh, vvi_mesh_arrays_of(&mesh->info), job);
    if (st != VV_OK || !*out)
        return st;
    vv_mesh_info *info = &(*out)->info;
    info->origin = (vv_vec3){info->origin.x * factor, info->origin.y * factor, info->origin.z * factor};
    copy_text(info->unit, sizeof info->unit, unit);
    for (size_t i = 0; i < 3 * info->n_vertices; i++)
        a.positions[i] = (float)((double)a.positions[i] * factor);
    return VV_OK;
}

static void turn_triangles(uint32_t *t, size_t n)
{
    for (size_t i = 0; i < n && t; i++, t += 3) {
        const uint32_t second = t[1];
        t[1] = t[2];
        t[2] = second;
    }
}

void vvi_mesh_turn(vv_mesh *mesh)
{
    turn_triangles(mesh->arrays.triangles, mesh->info.n_triangles);
    turn_triangles(mesh->arrays.coordinate_of, mesh->info.n_triangles);
    for (size_t i = 0; i < 3 * mesh->info.n_vertices && mesh->arrays.normals; i++)
        mesh->arrays.normals[i] = -mesh->arrays.normals[i];
}

void vvi_mesh_set_unit(vv_mesh *mesh, const char *unit)
{
    copy_text(mesh->info.unit, sizeof mesh->info.unit, unit);
}

vv_status vvi_mesh_add_values(float **out, vv_mesh *mesh, const char *name, const char *unit, vv_job *job)
{
    const vv_status st = take(out, mesh->info.n_vertices, sizeof(float), job);
    if (st != VV_OK)
        return st;
    vvi_free(mesh->arrays.values);
    mesh->arrays.values = *out;
    copy_text(mesh->info.value_name, sizeof mesh->info.value_name, name);
    copy_text(mesh->info.value_unit, sizeof mesh->info.value_unit, unit);
    show_arrays(mesh);
    return VV_OK;
}

vv_status vvi_mesh_add_parts(vv_mesh_part **out, vv_mesh *mesh, size_t n, vv_job *job)
{
    const vv_status st = take(out, n, sizeof **out, job);
    if (st != VV_OK)
        return st;
    for (size_t i = 0; i < n; i++)
        (*out)[i] = (vv_mesh_part){.color.a = -1};
    vvi_free(mesh->arrays.parts);
    mesh->arrays.parts = *out;
    mesh->info.n_parts = n;
    show_arrays(mesh);
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
    vvi_free(mesh->arrays.coordinates);
    vvi_free(mesh->arrays.coordinate_of);
    vvi_mesh_textures_release(mesh->arrays.textures);
    vvi_free(mesh);
}

const vv_mesh_info *vv_mesh_get_info(const vv_mesh *mesh)
{
    return &mesh->info;
}

uint64_t vvi_mesh_bytes(const vv_mesh *mesh)
{
    const vv_mesh_info *m = &mesh->info;
    const uint64_t vertex = 12 + (m->normals ? 12 : 0) + (m->values ? 4 : 0) + (m->colors ? 4 : 0);
    uint64_t bytes = m->n_vertices * vertex + m->n_triangles * (m->coordinate_of ? 24 : 12) +
                     m->n_parts * sizeof *m->parts + m->n_coordinates * 8;
    for (size_t i = 0; i < m->n_textures; i++)
        bytes += 4 * (uint64_t)m->textures[i].width * (uint64_t)m->textures[i].height;
    return bytes;
}

static uint32_t sum(uint32_t crc, const void *data, size_t n, size_t each)
{
    return data && n ? vvi_crc32(crc, data, n * each, vvi_crc_has_fold()) : crc;
}

static uint32_t sum_all(const vv_mesh_info *m)
{
    uint32_t crc = sum(0, &m->origin, 1, sizeof m->origin);
    crc = sum(crc, m->positions, 3 * m->n_vertices, sizeof *m->positions);
    crc = sum(crc, m->normals, 3 * m->n_vertices, sizeof *m->normals);
    crc = sum(crc, m->values, m->n_vertices, sizeof *m->values);
    crc = sum(crc, m->colors, 4 * m->n_vertices, 1);
    crc = sum(crc, m->triangles, 3 * m->n_triangles, sizeof *m->triangles);
    for (size_t i = 0; i < m->n_parts; i++) {
        crc = sum(crc, m->parts[i].name, strlen(m->parts[i].name), 1);
        crc = sum(crc, &m->parts[i].color, 1, sizeof m->parts[i].color);
        crc = sum(crc, &m->parts[i].texture, m->n_textures != 0, sizeof m->parts[i].texture);
    }
    crc = sum(crc, m->coordinates, 2 * m->n_coordinates, sizeof *m->coordinates);
    crc = sum(crc, m->coordinate_of, 3 * m->n_triangles, sizeof *m->coordinate_of);
    for (size_t i = 0; i < m->n_textures; i++) {
        const vv_mesh_texture *t = &m->textures[i];
        crc = sum(crc, &t->width, 1, sizeof t->width);
        crc = sum(crc, t->wrap, 1, sizeof t->wrap);
        crc = sum(crc, t->pixels, (size_t)t->width * (size_t)t->height, 4);
    }
    return crc;
}

uint32_t vv_mesh_checksum(const vv_mesh *mesh)
{
    const uint64_t known = UINT64_C(1) << 32;
    vv_mesh *m = (vv_mesh *)(uintptr_t)mesh;
    uint64_t checksum = atomic_load(&m->checksum);
    if (!checksum)
        atomic_store(&m->checksum, checksum = known | sum_all(&mesh->info));
    return (uint32_t)checksum;
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
