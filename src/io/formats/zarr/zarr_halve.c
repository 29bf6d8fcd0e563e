/* Levels: blocks of two samples along each axis that is longer than a chunk become one, their mean, or of labels the
 * one that is there most often, the first of those that are equally often. At the ends blocks have what there is. */
#include "core/job.h"
#include "core/memory.h"
#include "grid/field.h"
#include "io/formats/zarr/zarr_write.h"
#include <math.h>
#include <string.h>

typedef struct halving {
    const vvi_zarr_writing *w;
    const vvi_zarr_level *from, *to;
    int64_t step[3]; /* 1 or 2 */
} halving;

typedef struct rows {
    double *in, *sum, *count;
} rows;

static vv_status start(void **scratch_out, void *shared, int worker)
{
    const halving *h = shared;
    const size_t n = (size_t)(h->from->dims[0] * h->w->info->components);
    (void)worker;
    *scratch_out = vvi_alloc(h->w->job, 3 * n * sizeof(double), VVI_MEM_SCRATCH);
    return *scratch_out ? VV_OK : vv_fail_memory(3 * n * sizeof(double));
}

static void finish(void *scratch, void *shared)
{
    (void)shared;
    vvi_free(scratch);
}

static const uint8_t *row_of(const halving *h, int64_t j, int64_t k)
{
    return h->from->slab + (size_t)((k * h->from->dims[1] + j) * h->from->dims[0]) * h->w->sample_bytes;
}

/* End of the block of samples that begins at `first`. */
static int64_t block_end(int64_t first, int64_t step, int64_t n)
{
    return first + step < n ? first + step : n;
}

static void add_row(const halving *h, rows *r, const uint8_t *row)
{
    const int64_t c = h->w->info->components, n = h->from->dims[0];
    vvi_samples_to_f64(r->in, row, h->w->info->type, (size_t)(n * c));
    for (int64_t i = 0; i < n; i++)
        for (int64_t k = 0; k < c; k++) {
            const double v = r->in[i * c + k];
            const int64_t o = i / h->step[0] * c + k;
            if (isnan(v))
                continue;
            r->sum[o] += v;
            r->count[o] += 1;
        }
}

static void mean_row(const halving *h, rows *r, uint8_t *out, int64_t j, int64_t k)
{
    const size_t n = (size_t)(h->to->dims[0] * h->w->info->components);
    const int64_t j0 = j * h->step[1], k0 = k * h->step[2];
    memset(r->sum, 0, n * sizeof *r->sum);
    memset(r->count, 0, n * sizeof *r->count);
    for (int64_t z = k0; z < block_end(k0, h->step[2], h->from->n); z++)
        for (int64_t y = j0; y < block_end(j0, h->step[1], h->from->dims[1]); y++)
            add_row(h, r, row_of(h, y, z));
    for (size_t i = 0; i < n; i++)
        r->sum[i] = r->count[i] > 0 ? r->sum[i] / r->count[i] : (double)NAN;
    vvi_samples_from_f64(out, r->sum, h->w->info->type, n);
}

/* The most frequent of n numbers by their bits. */
static uint64_t most_frequent(const uint64_t *value, int n)
{
    int best = 0, best_count = 0;
    for (int i = 0; i < n; i++) {
        int count = 0;
        for (int k = 0; k < n; k++)
            count += value[k] == value[i];
        if (count > best_count) {
            best = i;
            best_count = count;
        }
    }
    return value[best];
}

static void label_row(const halving *h, uint8_t *out, int64_t j, int64_t k)
{
    const size_t bytes = h->w->type_bytes;
    const int64_t j0 = j * h->step[1], k0 = k * h->step[2];
    for (int64_t i = 0; i < h->to->dims[0]; i++) {
        uint64_t value[8] = {0};
        int n = 0;
        const int64_t i0 = i * h->step[0];
        for (int64_t z = k0; z < block_end(k0, h->step[2], h->from->n); z++)
            for (int64_t y = j0; y < block_end(j0, h->step[1], h->from->dims[1]); y++)
                for (int64_t x = i0; x < block_end(i0, h->step[0], h->from->dims[0]); x++)
                    memcpy(&value[n++], row_of(h, y, z) + (size_t)x * bytes, bytes);
        const uint64_t label = most_frequent(value, n);
        memcpy(out + (size_t)i * bytes, &label, bytes);
    }
}

/* One slice. */
static vv_status halve_slice(void *scratch, void *shared, size_t index)
{
    const halving *h = shared;
    const vvi_zarr_level *to = h->to;
    const size_t n = (size_t)(h->from->dims[0] * h->w->info->components);
    rows r = {scratch, (double *)scratch + n, (double *)scratch + 2 * n};
    const int64_t k = (int64_t)index;
    vv_status st = vvi_job_poll(h->w->job);
    for (int64_t j = 0; j < to->dims[1] && st == VV_OK; j++) {
        uint8_t *out = to->slab + (size_t)(((to->n + k) * to->dims[1] + j) * to->dims[0]) * h->w->sample_bytes;
        if (h->w->label)
            label_row(h, out, j, k);
        else
            mean_row(h, &r, out, j, k);
    }
    return st;
}

vv_status vvi_zarr_halve(vvi_zarr_writing *w, int level)
{
    vvi_zarr_level *from = &w->level[level], *to = &w->level[level + 1];
    halving h = {.w = w, .from = from, .to = to};
    const vvi_work work = {.start = start, .item = halve_slice, .finish = finish};
    for (int a = 0; a < 3; a++)
        h.step[a] = to->factor[a] / from->factor[a];
    const int64_t n = (from->n + h.step[2] - 1) / h.step[2];
    vv_status st = vvi_parallel_for(w->job, &work, &h, (size_t)n);
    to->n += n;
    return st;
}
