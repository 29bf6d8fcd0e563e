/* What became of the pieces of a mesh that was simplified. Here pieces are joined by vertices, as everywhere but where
 * pieces have to be kept. */
#include "core/memory.h"
#include "grid/mesh.h"
#include "surface/simplify.h"

#include <string.h>

static size_t count(const uint8_t *there, size_t n)
{
    size_t sum = 0;
    for (size_t v = 0; v < n; v++)
        sum += there[v];
    return sum;
}

static size_t count_pieces(uint8_t *there, const uint32_t *first, const vv_mesh_info *m, const uint32_t *corners,
                           size_t n)
{
    memset(there, 0, m->n_vertices);
    for (size_t k = 0; k < n; k++)
        there[first[corners[k]]] = 1;
    return count(there, m->n_vertices);
}

vv_status vvi_simplify_count_pieces(vvi_simplify_result *out, const vv_mesh_info *m, const vv_mesh_info *made,
                                    const uint32_t *corners, vv_job *job)
{
    uint32_t *first = NULL, *first_made = NULL;
    uint8_t *there = vvi_alloc(job, m->n_vertices + 1, VVI_MEM_SCRATCH);
    vv_status st = there ? VV_OK : vv_fail_memory(m->n_vertices + 1);
    if (st == VV_OK && (st = vvi_mesh_number_placed_pieces(&first, m, NULL, job)) == VV_OK &&
        (st = vvi_mesh_number_placed_pieces(&first_made, made, NULL, job)) == VV_OK) {
        out->n_pieces = count_pieces(there, first, m, m->triangles, 3 * m->n_triangles);
        out->n_dropped = out->n_pieces - count_pieces(there, first, m, corners, 3 * made->n_triangles);
        out->n_pieces_left = 0;
        for (size_t v = 0; v < made->n_vertices; v++) /* each has triangles */
            out->n_pieces_left += first_made[v] == v;
    }
    vvi_free(there);
    vvi_free(first);
    vvi_free(first_made);
    return st;
}
