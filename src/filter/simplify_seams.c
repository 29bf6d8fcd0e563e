#include "filter/simplify_seams.h"
#include "core/memory.h"

#include <string.h>

enum { LOOSE = 3 }; /* rings of triangles around a seam that are simplified */

/* 1: on a seam, 2: a triangle away, ... 0: farther than that. By vertex. */
static void find_rings(uint8_t *ring, const vv_mesh_info *m, const uint32_t *vertex, const uint8_t *seam,
                       const vvi_chosen *c)
{
    for (size_t v = 0; v < m->n_vertices; v++)
        ring[v] = seam[vvi_chosen_original(c, vertex[v])];
    for (int r = 1; r <= LOOSE; r++)
        for (size_t t = 0; t < m->n_triangles; t++) {
            const uint32_t *k = m->triangles + 3 * t;
            const bool near = ring[k[0]] == r || ring[k[1]] == r || ring[k[2]] == r;
            for (int i = 0; i < 3 && near; i++)
                ring[k[i]] = ring[k[i]] ? ring[k[i]] : (uint8_t)(r + 1);
        }
}

static vv_status attempt(vvi_attempts *a, const vv_mesh *mesh, const uint32_t *vertex, const uint8_t *seam,
                         const vvi_chosen *c, vv_job *job)
{
    const vv_mesh_info *m = vv_mesh_get_info(mesh);
    uint8_t *ring = vvi_alloc(job, m->n_vertices + 1, VVI_MEM_SCRATCH);
    if (!ring)
        return vv_fail_memory(m->n_vertices + 1);
    find_rings(ring, m, vertex, seam, c);
    for (size_t v = 0; v < m->n_vertices; v++)
        ring[v] = ring[v] == 0 || ring[v] > LOOSE;
    a->mesh = mesh;
    a->still = ring;
    a->options.fix_border = true;
    a->options.uncounted = true;
    const vv_status st = vvi_simplify_attempts(a, job);
    vvi_free(ring);
    return st;
}

static vv_status take(vvi_chosen *c, const vvi_attempts *a, const uint32_t *vertex, uint32_t *number, vv_job *job)
{
    const vv_mesh_info *m = vv_mesh_get_info(a->out);
    c->n = m->n_triangles;
    for (size_t k = 0; k < 3 * c->n; k++)
        c->triangles[k] = vvi_chosen_original(c, vertex[a->corners[k]]);
    if (c->parts)
        memcpy(c->parts, m->parts, m->n_parts * sizeof *c->parts);
    return vvi_chosen_tell_copies(c, m, number, job);
}

static vv_status simplify(vvi_attempts *a, vvi_chosen *c, const uint8_t *seam, uint32_t *number, vv_job *job)
{
    vv_mesh *mesh = NULL;
    uint32_t *vertex = NULL;
    vv_status st = vvi_chosen_places(&mesh, &vertex, c, number, job);
    if (st == VV_OK && (st = attempt(a, mesh, vertex, seam, c, job)) == VV_OK && a->kept && a->out)
        st = take(c, a, vertex, number, job);
    vvi_attempts_finish(a);
    vv_mesh_release(mesh);
    vvi_free(vertex);
    return st;
}

vv_status vvi_simplify_seams(vvi_chosen *c, size_t *n_crowded_out, const uint8_t *seam, const vvi_attempts *how,
                             vv_job *job)
{
    const size_t bytes = (c->mesh->n_vertices + c->n_copies + 1) * sizeof(uint32_t);
    vvi_attempts a = {.before = how->before, .error = how->error, .options = how->options};
    uint32_t *number = vvi_alloc(job, bytes, VVI_MEM_SCRATCH);
    if (!number)
        return vv_fail_memory(bytes);
    memset(number, 0xff, bytes);
    const vv_status st = c->n > 0 ? simplify(&a, c, seam, number, job) : VV_OK;
    vvi_free(number);
    *n_crowded_out = a.result.n_crowded;
    return st;
}
