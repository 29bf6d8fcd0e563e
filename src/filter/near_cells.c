#include "filter/near_cells.h"
#include "core/memory.h"

#include <math.h>
#include <string.h>

enum { SIDE = 128 }; /* cells along an axis */

typedef struct range {
    size_t lo[3], hi[3]; /* both are in it */
} range;

static size_t cell_at(const vvi_near_cells *cells, double place, int axis)
{
    const double at = (place - cells->lo[axis]) * cells->per_length[axis], last = (double)cells->n[axis] - 1;
    return (size_t)(!(at > 0) ? 0 : at < last ? at : last);
}

static range range_of(const vvi_near_cells *cells, const float *positions, const uint32_t corner[3], double around)
{
    range r;
    for (int a = 0; a < 3; a++) {
        double lo = INFINITY, hi = -INFINITY;
        for (int k = 0; k < 3; k++) {
            const double x = (double)positions[3 * (size_t)corner[k] + (size_t)a];
            lo = x < lo ? x : lo;
            hi = x > hi ? x : hi;
        }
        r.lo[a] = cell_at(cells, lo - around, a);
        r.hi[a] = cell_at(cells, hi + around, a);
    }
    return r;
}

vv_status vvi_near_cells_init(vvi_near_cells *cells, const vv_mesh_info *mesh, double distance, vv_job *job)
{
    cells->distance = distance * (1 + 1e-6);
    for (int a = 0; a < 3; a++) {
        double lo = INFINITY, hi = -INFINITY;
        for (size_t v = 0; v < mesh->n_vertices; v++) {
            lo = fmin(lo, (double)mesh->positions[3 * v + (size_t)a]);
            hi = fmax(hi, (double)mesh->positions[3 * v + (size_t)a]);
        }
        const double side = fmax((hi - lo) / SIDE, distance);
        cells->lo[a] = lo;
        cells->n[a] = (size_t)fmin(floor((hi - lo) / side), SIDE - 1) + 1;
        cells->per_length[a] = 1 / side;
    }
    const size_t n = cells->n[0] * cells->n[1] * cells->n[2];
    cells->marked = vvi_alloc_zeroed(job, n, VVI_MEM_SCRATCH);
    return cells->marked ? VV_OK : vv_fail_memory(n);
}

void vvi_near_cells_finish(vvi_near_cells *cells)
{
    vvi_free(cells->marked);
    *cells = (vvi_near_cells){0};
}

void vvi_near_cells_clear(vvi_near_cells *cells)
{
    memset(cells->marked, 0, cells->n[0] * cells->n[1] * cells->n[2]);
}

void vvi_near_cells_mark(vvi_near_cells *cells, const float *positions, const uint32_t corner[3])
{
    const range r = range_of(cells, positions, corner, cells->distance);
    for (size_t k = r.lo[2]; k <= r.hi[2]; k++)
        for (size_t j = r.lo[1]; j <= r.hi[1]; j++)
            memset(cells->marked + (k * cells->n[1] + j) * cells->n[0] + r.lo[0], 1, r.hi[0] - r.lo[0] + 1);
}

bool vvi_near_cells_touch(const vvi_near_cells *cells, const float *positions, const uint32_t corner[3])
{
    const range r = range_of(cells, positions, corner, 0);
    for (size_t k = r.lo[2]; k <= r.hi[2]; k++)
        for (size_t j = r.lo[1]; j <= r.hi[1]; j++)
            if (memchr(cells->marked + (k * cells->n[1] + j) * cells->n[0] + r.lo[0], 1, r.hi[0] - r.lo[0] + 1))
                return true;
    return false;
}
