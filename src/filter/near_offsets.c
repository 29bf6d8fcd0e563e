#include "filter/near_offsets.h"
#include "core/memory.h"
#include "core/status.h"

#include <stdlib.h>

#define MOST 4200000 /* samples: a ball of 100 voxels */

static int compare(const void *a_in, const void *b_in)
{
    const vvi_near_offset *a = a_in, *b = b_in;
    return (a->away > b->away) - (a->away < b->away);
}

static double away(const vv_grid *grid, int64_t i, int64_t j, int64_t k)
{
    const vv_vec3 *a = grid->index_to_world.axis;
    const double x = a[0].x * (double)i + a[1].x * (double)j + a[2].x * (double)k;
    const double y = a[0].y * (double)i + a[1].y * (double)j + a[2].y * (double)k;
    const double z = a[0].z * (double)i + a[1].z * (double)j + a[2].z * (double)k;
    return x * x + y * y + z * z;
}

static void add_run(vvi_near_offsets *out, const vv_grid *grid, int64_t lo, int64_t length, int64_t j, int64_t k)
{
    for (int64_t i = lo; i < lo + length; i++)
        out->offset[out->n++] = (vvi_near_offset){away(grid, i, j, k), (int32_t)i, (int32_t)j, (int32_t)k};
}

static double count_of(const vvi_element *e)
{
    const int64_t *r = e->radius;
    double sum = 0;
    if (e->box)
        return (2.0 * (double)r[0] + 1) * (2.0 * (double)r[1] + 1) * (2.0 * (double)r[2] + 1);
    for (size_t c = 0; c < e->n_chords; c++)
        sum += (double)e->chords[c].length;
    return sum;
}

vv_status vvi_near_offsets_init(vvi_near_offsets *out, const vvi_element *e, const vv_grid *grid, const char *name,
                                vv_job *job)
{
    const double n = count_of(e);
    const int64_t *r = e->radius;
    *out = (vvi_near_offsets){0};
    if (!(n <= MOST))
        return vv_fail(VV_E_ARGUMENT, "%s: an element of %.0f samples is too large for labels; it may have %d", name, n,
                       MOST);
    out->offset = vvi_alloc(job, (size_t)n * sizeof *out->offset, VVI_MEM_SCRATCH);
    if (!out->offset)
        return vv_fail_memory((size_t)n * sizeof *out->offset);
    for (size_t c = 0; c < e->n_chords; c++)
        add_run(out, grid, e->chords[c].lo, e->chords[c].length, e->chords[c].y, e->chords[c].z);
    for (int64_t k = -r[2]; k <= r[2] && e->box; k++)
        for (int64_t j = -r[1]; j <= r[1]; j++)
            add_run(out, grid, -r[0], 2 * r[0] + 1, j, k);
    qsort(out->offset, out->n, sizeof *out->offset, compare);
    return VV_OK;
}

void vvi_near_offsets_finish(vvi_near_offsets *offsets)
{
    vvi_free(offsets->offset);
    *offsets = (vvi_near_offsets){0};
}
