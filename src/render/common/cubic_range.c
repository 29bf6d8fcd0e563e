/* Between two samples of an axis the spline is a curve of Bezier, and so is it on either side of the middle between
 * them: four points on each side are means of the four coefficients around, the outer two are the spline at the ends,
 * and it lies between the least and the largest of them (and hardly reaches those: points of whole cells would let
 * noise look half as high again as it is). With three axes there are 8^3 points a cell, and neighbours share those of
 * their faces. An outer point that is not on the block's face lies between two inner ones, so a block is bounded by the
 * inner points of its cells and those of its faces. */
#include "render/common/cubic_range.h"
#include "core/cpu.h"
#include "core/job.h"
#include "core/memory.h"
#include "render/march/kernels.h"
#include <math.h>

/* Kernels compute in floats: no sum of 64 is as far from its exact value as this much of it. */
#define ROUNDING 1e-5f

typedef struct build {
    vvi_minmax *m;
    const vvi_lattice *lattice;
    const vvi_ray_kernels *kernels;
    vv_job *job;
} build;

/* What one worker has at hand. Rows have a coefficient more before the first sample, and two behind the last. */
typedef struct scratch {
    float *points; /* along y: rows of each slice */
    float *row;    /* the same along z as well: one row */
    float *lo, *hi;
} scratch;

enum { BEFORE = 1, BEHIND = 2 };

/* Rows are so long that kernels may go beyond their ends. */
static size_t row_of(const vvi_lattice *g)
{
    return ((size_t)g->n[0] + BEFORE + BEHIND + 2 * (size_t)VVI_RANGE_BEYOND) & ~(size_t)(VVI_RANGE_BEYOND - 1);
}

/* Of the coefficients 0 .. n-1, mirrored about the first and the last. */
static int64_t mirrored(int64_t i, int64_t n)
{
    if (n == 1)
        return 0;
    i = i < 0 ? -i : i;
    return i > n - 1 ? 2 * (n - 1) - i : i;
}

static int64_t least(int64_t a, int64_t b)
{
    return a < b ? a : b;
}

static int64_t cells_of(int64_t n)
{
    return n > 1 ? n - 1 : 1;
}

/* Cells of block b along an axis of n samples, from b << shift on. */
static int64_t cells_in(int64_t b, int shift, int64_t n)
{
    const int64_t side = (int64_t)1 << shift;
    return least(side, cells_of(n) - (b << shift));
}

/* Points along one axis of a block: those inside its cells, and its faces. */
static size_t count_points(int64_t cells)
{
    return (size_t)(VVI_RANGE_INNER * cells + 2);
}

/* The p-th of them: the cell that has it, and its weights. */
static int64_t find_point(const float **weight, size_t p, int64_t cells)
{
    if (p == 0) {
        *weight = vvi_range_weight[0];
        return 0;
    }
    *weight = vvi_range_weight[p == count_points(cells) - 1 ? VVI_RANGE_INNER + 1 : 1 + (p - 1) % VVI_RANGE_INNER];
    return least((int64_t)(p - 1) / VVI_RANGE_INNER, cells - 1);
}

/* The points along y in one slice of coefficients, of one row of blocks. */
static void find_rows(float *to, const build *b, int64_t by, int64_t k)
{
    const vvi_lattice *g = b->lattice;
    const int64_t cells = cells_in(by, b->m->shift, g->n[1]), n = g->n[0];
    const float *slice = (const float *)g->data + mirrored(k, g->n[2]) * g->slice;
    for (size_t p = 0; p < count_points(cells); p++) {
        const float *from[4], *weight;
        float *row = to + p * row_of(g) + BEFORE;
        const int64_t j = (by << b->m->shift) + find_point(&weight, p, cells);
        for (int64_t o = 0; o < 4; o++)
            from[o] = slice + mirrored(j + o - 1, g->n[1]) * g->row;
        b->kernels->range_mean(row, from, weight, (size_t)n);
        row[-1] = row[mirrored(-1, n)];
        for (int64_t i = n; i < n + BEHIND; i++)
            row[i] = row[n > 2 || i == n ? mirrored(i, n) : 0];
    }
}

static void reduce(float *lo_out, float *hi_out, const scratch *s, int64_t first, int64_t cells)
{
    float lo = s->lo[first], hi = s->hi[first];
    for (int64_t i = first + 1; i < first + cells; i++) {
        lo = s->lo[i] < lo ? s->lo[i] : lo;
        hi = s->hi[i] > hi ? s->hi[i] : hi;
    }
    const float slack = ROUNDING * fmaxf(fabsf(lo), fabsf(hi));
    *lo_out = lo - slack;
    *hi_out = hi + slack;
}

static vv_status start(void **scratch_out, void *shared, int worker)
{
    const build *b = shared;
    const size_t row = row_of(b->lattice), side = (size_t)1 << b->m->shift;
    const size_t rows = count_points((int64_t)side) * (side + 3), bytes = sizeof(scratch) + (rows + 3) * row * 4;
    (void)worker;
    scratch *s = vvi_alloc(b->job, bytes, VVI_MEM_SCRATCH);
    *scratch_out = s;
    if (!s)
        return vv_fail_memory(bytes);
    s->points = (float *)(s + 1);
    s->row = s->points + rows * row;
    s->lo = s->row + row;
    s->hi = s->lo + row;
    return VV_OK;
}

static void finish(void *scratch_in, void *shared)
{
    (void)shared;
    vvi_free(scratch_in);
}

/* Item: the blocks of one (y, z). */
static vv_status item(void *scratch_in, void *shared, size_t index)
{
    const build *b = shared;
    const scratch *s = scratch_in;
    const vvi_minmax *m = b->m;
    const int32_t *n = b->lattice->n;
    const int64_t by = (int64_t)index % m->n[1], bz = (int64_t)index / m->n[1];
    const int64_t cells[3] = {cells_of(n[0]), cells_in(by, m->shift, n[1]), cells_in(bz, m->shift, n[2])};
    const size_t row = row_of(b->lattice), slice = count_points(cells[1]) * row;
    for (int64_t k = 0; k < cells[2] + 3; k++)
        find_rows(s->points + (size_t)k * slice, b, by, (bz << m->shift) + k - 1);
    for (int64_t i = 0; i < cells[0]; i++) {
        s->lo[i] = INFINITY;
        s->hi[i] = -INFINITY;
    }
    for (size_t p = 0; p < count_points(cells[2]); p++) {
        const float *weight;
        const float *from = s->points + (size_t)find_point(&weight, p, cells[2]) * slice;
        for (size_t q = 0; q < slice; q += row) {
            const float *const four[4] = {from + q, from + slice + q, from + 2 * slice + q, from + 3 * slice + q};
            b->kernels->range_mean(s->row, four, weight, (size_t)cells[0] + 3);
            b->kernels->range_fold(s->lo, s->hi, s->row, (size_t)cells[0]);
        }
    }
    for (int64_t bx = 0; bx < m->n[0]; bx++) {
        const size_t at = index * (size_t)m->n[0] + (size_t)bx;
        reduce(&m->lo[at], &m->hi[at], s, bx << m->shift, cells_in(bx, m->shift, n[0]));
    }
    return VV_OK;
}

typedef struct request {
    const vvi_lattice *lattice;
    int shift;
} request;

static vv_status make(void **value_out, uint64_t *bytes_out, void *user, vv_job *job)
{
    const request *r = user;
    const int64_t dims[3] = {r->lattice->n[0], r->lattice->n[1], r->lattice->n[2]};
    build b = {.lattice = r->lattice, .kernels = vvi_ray_kernels_for(vvi_job_cpu(job)), .job = job};
    vv_status st = vvi_minmax_new(&b.m, dims, r->shift, job);
    if (st != VV_OK)
        return st;
    const vvi_work work = {.stage = NULL, .start = start, .item = item, .finish = finish};
    if ((st = vvi_parallel_for(job, &work, &b, (size_t)b.m->n[1] * (size_t)b.m->n[2])) != VV_OK) {
        vvi_minmax_free(b.m);
        return st;
    }
    *bytes_out = (uint64_t)b.m->n[0] * (uint64_t)b.m->n[1] * (uint64_t)b.m->n[2] * 2 * sizeof(float);
    *value_out = b.m;
    return VV_OK;
}

vv_status vvi_cubic_range_get(vvi_cached **out, const vvi_cache_key *key, const vvi_lattice *lattice, int shift,
                              vv_job *job)
{
    request r = {lattice, shift};
    return vvi_cache_get(out, key, make, vvi_minmax_free, &r, job);
}
