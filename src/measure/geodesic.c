#include "core/job.h"
#include "core/memory.h"
#include "core/vec.h"
#include "measure/path_search.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <volvis/measure_path.h>

enum { RINGS = 6, ROUNDS = 8 };

/* Marks the vertices within some edges of the path's. */
static void mark_band(bool *allowed, const vvi_path_mesh *m, const vvi_path *path, uint8_t *ring)
{
    memset(ring, 255, m->n_vertices);
    for (size_t i = 0; i < path->n; i++)
        ring[path->places[i].vertex[0]] = ring[path->places[i].vertex[1]] = 0;
    for (int r = 0; r < RINGS; r++)
        for (size_t e = 0; e < 3 * m->n_triangles; e++) {
            const uint32_t a = vvi_edge_start(m, (uint32_t)e), b = vvi_edge_end(m, (uint32_t)e);
            if (ring[a] == r && ring[b] > r + 1)
                ring[b] = (uint8_t)(r + 1);
            if (ring[b] == r && ring[a] > r + 1)
                ring[a] = (uint8_t)(r + 1);
        }
    for (size_t v = 0; v < m->n_vertices; v++)
        allowed[v] = ring[v] <= RINGS;
}

/* The path becomes the shortest of the band around it, again and again until that is itself. */
static vv_status shorten_in_bands(vvi_path *path, const vvi_path_mesh *m, uint64_t max_windows, vv_job *job)
{
    bool *allowed = vvi_alloc(job, m->n_vertices * sizeof *allowed, VVI_MEM_SCRATCH);
    uint8_t *ring = vvi_alloc(job, m->n_vertices, VVI_MEM_SCRATCH);
    vv_status st = allowed && ring ? VV_OK : vv_fail_memory(2 * m->n_vertices);
    for (int i = 0; i < ROUNDS && st == VV_OK; i++) {
        const double before = path->length;
        mark_band(allowed, m, path, ring);
        st = vvi_path_shorten(path, m, allowed, max_windows, job);
        if (path->length > before * (1 - 1e-9))
            break;
    }
    vvi_free(allowed);
    vvi_free(ring);
    return st;
}

static vv_status find(vvi_path *path, const vvi_path_mesh *m, uint64_t max_windows, vv_job *job)
{
    enum { LARGE = 5000 }; /* triangles of which a band is a small part */
    vv_status st = vvi_path_along_edges(path, m, job);
    if (st == VV_OK && m->n_triangles > LARGE)
        st = shorten_in_bands(path, m, max_windows, job);
    if (st == VV_OK)
        st = vvi_path_shorten(path, m, NULL, max_windows, job);
    return st;
}

static vv_status tell(vv_mesh_path *out, const vvi_path *path, const vvi_path_mesh *m, const char *unit, vv_job *job)
{
    const size_t n = path->n > 1 ? path->n : 2; /* between a place and itself: that place twice */
    const double rounding = 1e-9 * path->length;
    const double longer = fmax(0, path->length - path->least);
    out->points = vvi_alloc(job, n * sizeof *out->points, VVI_MEM_MODEL);
    if (!out->points)
        return vv_fail_memory(n * sizeof *out->points);
    for (size_t i = 0; i < n; i++)
        out->points[i] = vvi_add(path->places[i < path->n ? i : 0].at, m->origin);
    out->n_points = n;
    out->shortest = longer <= 2 * rounding;
    out->length = (vv_figure){.value = path->length, .error = out->shortest ? 2 * rounding : longer};
    snprintf(out->length.unit, sizeof out->length.unit, "%s", unit);
    return VV_OK;
}

void vv_mesh_path_options_init(vv_mesh_path_options *options, size_t size)
{
    const vv_mesh_path_options all = {.size = size, .to_world = vv_affine_identity()};
    memcpy(options, &all, size < sizeof all ? size : sizeof all);
}

vv_status vv_mesh_geodesic(vv_mesh_path *out, const vv_mesh *mesh, vv_vec3 from, vv_vec3 to,
                           const vv_mesh_path_options *options, vv_job *job)
{
    vv_mesh_path_options o;
    vvi_path_mesh m;
    vvi_path path = {0};
    vv_mesh_path_options_init(&o, sizeof o);
    if (options)
        memcpy(&o, options, options->size < sizeof o ? options->size : sizeof o);
    *out = (vv_mesh_path){0};
    vv_status st = vvi_path_mesh_init(&m, vv_mesh_get_info(mesh), &o.to_world, from, to, job);
    if (st == VV_OK)
        st = find(&path, &m, o.max_windows ? o.max_windows : 8000000, job);
    if (st == VV_OK)
        st = tell(out, &path, &m, o.unit[0] ? o.unit : vv_mesh_get_info(mesh)->unit, job);
    vvi_path_finish(&path);
    vvi_path_mesh_finish(&m);
    return st;
}

void vv_mesh_path_finish(vv_mesh_path *path)
{
    vvi_free(path->points);
    *path = (vv_mesh_path){0};
}
