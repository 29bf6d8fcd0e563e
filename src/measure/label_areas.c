#include "measure/label_areas.h"

#include "core/job.h"
#include "core/memory.h"
#include "core/vec.h"
#include "grid/field.h"

#include <string.h>

typedef struct shared {
    const vv_field *labels;
    const vvi_region *region;
    const vvi_label_set *set;
    _Atomic uint64_t *pattern;
    int64_t n[3];
    vv_job *job;
} shared;

/* Numbers of the labels of two slices, and the labels of a row. */
typedef struct worker {
    uint32_t *slice[2];
    vv_label_id *row;
} worker;

static vv_status start(void **scratch_out, void *user, int number)
{
    (void)number;
    const shared *s = user;
    const size_t samples = (size_t)s->n[0] * (size_t)s->n[1],
                 bytes = sizeof(worker) + (size_t)s->n[0] * sizeof(vv_label_id) + 2 * samples * sizeof(uint32_t);
    worker *w = vvi_alloc(s->job, bytes, VVI_MEM_SCRATCH);
    *scratch_out = w;
    if (!w)
        return vv_fail_memory(bytes);
    w->row = (vv_label_id *)(void *)(w + 1);
    w->slice[0] = (uint32_t *)(void *)(w->row + s->n[0]);
    w->slice[1] = w->slice[0] + samples;
    return VV_OK;
}

static void finish(void *scratch, void *user)
{
    (void)user;
    vvi_free(scratch);
}

/* Neighbours mostly have one label, which is looked for once. */
static vv_status read_slice(uint32_t *out, const worker *w, const shared *s, int64_t k)
{
    const vv_box box = {{0, 0, k < s->n[2] ? k : s->n[2] - 1}, {s->n[0], s->n[1], 1}};
    vv_brick brick;
    const vv_status st = vv_field_brick(&brick, s->labels, &box, s->job);
    vv_label_id last = 0;
    uint32_t number = VVI_NO_LABEL;
    if (st != VV_OK)
        return st;
    for (int64_t j = 0; j < s->n[1]; j++) {
        vvi_label_read(w->row, &brick, 0, NULL, j, 0);
        for (int64_t i = 0; i < s->n[0]; i++) {
            if (w->row[i] != last)
                number = vvi_label_set_find(s->set, w->row[i]);
            last = w->row[i];
            *out++ = number;
        }
    }
    vv_brick_release(&brick);
    return VV_OK;
}

/* A cell of several labels: a pattern of each. */
static void take_cell(const shared *s, const uint32_t corner[8])
{
    for (int c = 0; c < 8; c++) {
        unsigned pattern = 0, before = 0;
        for (int i = 0; i < 8; i++)
            pattern |= (unsigned)(corner[i] == corner[c]) << i;
        before = pattern & ((1U << c) - 1); /* an earlier corner has it: told already */
        if (corner[c] != VVI_NO_LABEL && !before)
            atomic_fetch_add_explicit(&s->pattern[(size_t)corner[c] * VVI_CONFIGURATIONS + pattern], 1,
                                      memory_order_relaxed);
    }
}

static void take_row(const shared *s, uint32_t *const slice[2], int64_t j, int64_t k)
{
    const vvi_interval cells =
        vvi_region_points(s->region, vvi_vec(VVI_CELL_MIDDLE, VVI_CELL_MIDDLE, VVI_CELL_MIDDLE), j, k, 0, s->n[0]);
    const int64_t next = j + 1 < s->n[1] ? s->n[0] : 0;
    const uint32_t *const low = slice[0] + j * s->n[0], *const high = slice[1] + j * s->n[0];
    const uint32_t *const row[4] = {low, low + next, high, high + next};
    for (int64_t i = cells.lo; i < cells.end; i++) {
        const int64_t beside = i + 1 < s->n[0] ? i + 1 : i;
        uint32_t corner[8], differ = 0;
        for (int r = 0; r < 4; r++) {
            corner[2 * r] = row[r][i];
            corner[2 * r + 1] = row[r][beside];
            differ |= (corner[2 * r] ^ low[i]) | (corner[2 * r + 1] ^ low[i]);
        }
        if (differ)
            take_cell(s, corner);
    }
}

static vv_status item(void *scratch, void *user, size_t index)
{
    worker *w = scratch;
    const shared *s = user;
    const int64_t first = (int64_t)index * VVI_MEASURE_LAYERS;
    const int64_t end = first + VVI_MEASURE_LAYERS < s->n[2] ? first + VVI_MEASURE_LAYERS : s->n[2];
    vv_status st = read_slice(w->slice[0], w, s, first);
    for (int64_t k = first; k < end && st == VV_OK; k++) {
        if ((st = read_slice(w->slice[1], w, s, k + 1)) != VV_OK)
            break;
        for (int64_t j = 0; j < s->n[1]; j++)
            take_row(s, w->slice, j, k);
        uint32_t *const next = w->slice[0];
        w->slice[0] = w->slice[1];
        w->slice[1] = next;
    }
    return st;
}

vv_status vvi_label_patterns(_Atomic uint64_t **out, const vv_field *labels, const vvi_region *region,
                             const vvi_label_set *set, vv_job *job)
{
    static const vvi_work work = {.stage = "areas", .start = start, .item = item, .finish = finish};
    const int64_t *dims = vv_field_get_info(labels)->grid.dims;
    shared s = {.labels = labels, .region = region, .set = set, .job = job};
    size_t bytes;
    *out = NULL;
    memcpy(s.n, dims, sizeof s.n);
    if (!set->n || vvi_mul3_size(&bytes, set->n, VVI_CONFIGURATIONS, sizeof *s.pattern) != VV_OK ||
        vvi_memory_plan(job, bytes, "areas of all labels") != VV_OK)
        return VV_OK;
    s.pattern = vvi_alloc_zeroed(job, bytes, VVI_MEM_SCRATCH);
    if (!s.pattern)
        return VV_OK;
    const vv_status st = vvi_parallel_for(job, &work, &s, (size_t)((dims[2] - 1) / VVI_MEASURE_LAYERS) + 1);
    if (st == VV_OK)
        *out = s.pattern;
    else
        vvi_free(s.pattern);
    return st;
}
