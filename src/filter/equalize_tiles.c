#include "filter/equalize_tiles.h"
#include "core/job.h"
#include "core/memory.h"
#include "grid/field.h"
#include "grid/slabs.h"

#include <math.h>
#include <string.h>

#define ITEM_SAMPLES ((int64_t)1 << 14)

enum { BINS = VVI_TILE_BINS };

typedef struct shared {
    const vv_field_info *info;
    vv_brick brick;
    vv_box box, tiles; /* tiles that the box needs */
    int64_t n[3];      /* of all tiles */
    double clip;
    double *range; /* of each component: the least and the largest stored number */
    double *maps;  /* of each tile and component: the share of samples below each of BINS + 1 ends */
    vvi_slabs slabs;
    char *out;
    vv_job *job;
} shared;

static int64_t tile_begin(const shared *s, int axis, int64_t tile)
{
    return tile * s->info->grid.dims[axis] / s->n[axis];
}

static double tile_middle(const shared *s, int axis, int64_t tile)
{
    return 0.5 * (double)(tile_begin(s, axis, tile) + tile_begin(s, axis, tile + 1) - 1);
}

/* The tile whose middle lies before a sample, and how far it is on the way to the next one's. */
static int64_t tile_before(double *part, const shared *s, int axis, int64_t i)
{
    int64_t t = ((2 * i + 1) * s->n[axis]) / (2 * s->info->grid.dims[axis]);
    *part = 0;
    t = t < s->n[axis] ? t : s->n[axis] - 1;
    while (t > 0 && tile_middle(s, axis, t) > (double)i)
        t--;
    while (t + 1 < s->n[axis] && tile_middle(s, axis, t + 1) <= (double)i)
        t++;
    const double middle = tile_middle(s, axis, t);
    if (t + 1 < s->n[axis] && (double)i > middle)
        *part = ((double)i - middle) / (tile_middle(s, axis, t + 1) - middle);
    return t;
}

static double bin_at(double v, const double range[2])
{
    const double at = (v - range[0]) / (range[1] - range[0]) * BINS;
    return at > 0 ? (at < BINS ? at : BINS) : 0;
}

/* Counts become shares below the ends of bins. */
static void make_map(double map[BINS + 1], const double count[BINS], double total, double clip)
{
    const double most = clip * total / BINS;
    double above = 0, below = 0;
    for (int b = 0; b < BINS; b++)
        above += fmax(count[b] - most, 0);
    map[0] = 0;
    for (int b = 0; b < BINS; b++) {
        below += total > 0 ? (fmin(count[b], most) + above / BINS) / total : 1. / BINS;
        map[b + 1] = below;
    }
}

static void count_row(double count[BINS], double *total, const char *in, int64_t n, const shared *s,
                      const double range[2])
{
    for (int64_t i = 0; i < n; i++) {
        double v;
        vvi_samples_to_f64(&v, in + i * s->brick.stride[0], s->info->type, 1);
        if (!isfinite(v))
            continue;
        const int bin = (int)bin_at(v, range);
        count[bin < BINS ? bin : BINS - 1]++;
        ++*total;
    }
}

static size_t map_place(const shared *s, const int64_t tile[3], int component)
{
    const int64_t *lo = s->tiles.lo, *n = s->tiles.n;
    const int64_t index = ((tile[2] - lo[2]) * n[1] + tile[1] - lo[1]) * n[0] + tile[0] - lo[0];
    return (size_t)(index * s->info->components + component) * (BINS + 1);
}

static vv_status count_tile(void *scratch, void *user, size_t index)
{
    const shared *s = user;
    const int64_t *n = s->tiles.n, i = (int64_t)index;
    const int64_t tile[3] = {s->tiles.lo[0] + i % n[0], s->tiles.lo[1] + i / n[0] % n[1],
                             s->tiles.lo[2] + i / n[0] / n[1]};
    vv_box box;
    for (int a = 0; a < 3; a++) {
        box.lo[a] = tile_begin(s, a, tile[a]);
        box.n[a] = tile_begin(s, a, tile[a] + 1) - box.lo[a];
    }
    const vv_brick b = vvi_brick_part(&s->brick, &box);
    for (int c = 0; c < s->info->components; c++) {
        double count[BINS] = {0}, total = 0;
        const char *in = (const char *)b.data + (size_t)c * vv_type_bytes(b.type);
        for (int64_t k = 0; k < box.n[2]; k++)
            for (int64_t j = 0; j < box.n[1]; j++)
                count_row(count, &total, in + j * b.stride[1] + k * b.stride[2], box.n[0], s, s->range + 2 * c);
        make_map(s->maps + map_place(s, tile, c), count, total, s->clip);
    }
    return vvi_job_poll(s->job);
}

static double share_below(const double *map, double at)
{
    const int bin = at < BINS ? (int)at : BINS - 1;
    return map[bin] + (map[bin + 1] - map[bin]) * (at - bin);
}

/* The maps of the eight tiles around a sample. */
static double mixed(double v, const shared *s, const int64_t before[3], const double part[3], int component)
{
    const double *range = s->range + 2 * component, at = bin_at(v, range);
    double share = 0;
    for (int corner = 0; corner < 8; corner++) {
        int64_t tile[3];
        double weight = 1;
        for (int a = 0; a < 3; a++) {
            const int next = corner >> a & 1;
            tile[a] = before[a] + next;
            weight *= next ? part[a] : 1 - part[a];
        }
        if (weight > 0)
            share += weight * share_below(s->maps + map_place(s, tile, component), at);
    }
    return range[0] + (range[1] - range[0]) * share;
}

static vv_status start(void **scratch_out, void *user, int worker)
{
    const shared *s = user;
    const size_t bytes = (size_t)(s->slabs.step[0] * s->info->components) * sizeof(double);
    *scratch_out = vvi_alloc(s->job, bytes, VVI_MEM_SCRATCH);
    return *scratch_out ? VV_OK : vv_fail_memory(bytes);
}

static void finish(void *scratch, void *user)
{
    vvi_free(scratch);
}

static void map_row(double *row, const shared *s, const vv_box *item, int64_t j, int64_t k)
{
    double part[3];
    int64_t before[3];
    before[1] = tile_before(&part[1], s, 1, item->lo[1] + j);
    before[2] = tile_before(&part[2], s, 2, item->lo[2] + k);
    for (int64_t i = 0; i < item->n[0]; i++) {
        before[0] = tile_before(&part[0], s, 0, item->lo[0] + i);
        for (int c = 0; c < s->info->components; c++) {
            double *v = &row[i * s->info->components + c];
            if (isfinite(*v) && s->range[2 * c] < s->range[2 * c + 1])
                *v = mixed(*v, s, before, part, c);
        }
    }
}

static vv_status map_item(void *scratch, void *user, size_t index)
{
    const shared *s = user;
    const vv_box box = vvi_slabs_item(&s->slabs, index);
    const vv_brick brick = vvi_brick_part(&s->brick, &box);
    const size_t n = (size_t)(box.n[0] * s->info->components), each = vv_type_bytes(s->info->type);
    for (int64_t k = 0; k < box.n[2]; k++)
        for (int64_t j = 0; j < box.n[1]; j++) {
            const int64_t at = vvi_slabs_row(&s->slabs, &box, j, k) * s->info->components;
            const char *in = (const char *)brick.data + j * brick.stride[1] + k * brick.stride[2];
            vvi_samples_to_f64(scratch, in, s->info->type, n);
            map_row(scratch, s, &box, j, k);
            vvi_samples_from_f64(s->out + (size_t)at * each, scratch, s->info->type, n);
        }
    return vvi_job_poll(s->job);
}

static vv_status find_ranges(shared *s, const vv_field *in)
{
    vv_statistics found;
    vv_status st = VV_OK;
    for (int c = 0; c < s->info->components && st == VV_OK; c++)
        if ((st = vv_field_statistics(&found, in, c, s->job)) == VV_OK) {
            const double a = (found.min - s->info->value_offset) / s->info->value_scale,
                         b = (found.max - s->info->value_offset) / s->info->value_scale;
            s->range[2 * c] = fmin(a, b);
            s->range[2 * c + 1] = fmax(a, b);
        }
    return st;
}

/* The tiles around a box, and all samples of them. */
static vv_box find_tiles(shared *s)
{
    vv_box needed;
    for (int a = 0; a < 3; a++) {
        double part;
        const int64_t first = tile_before(&part, s, a, s->box.lo[a]);
        const int64_t last = tile_before(&part, s, a, s->box.lo[a] + s->box.n[a] - 1) + 1;
        s->tiles.lo[a] = first;
        s->tiles.n[a] = (last < s->n[a] ? last + 1 : s->n[a]) - first;
        needed.lo[a] = tile_begin(s, a, first);
        needed.n[a] = tile_begin(s, a, first + s->tiles.n[a]) - needed.lo[a];
    }
    return needed;
}

static vv_status run_loops(shared *s, const vv_field *in)
{
    static const vvi_work counting = {.stage = "equalize", .item = count_tile};
    static const vvi_work mapping = {.stage = "equalize", .start = start, .item = map_item, .finish = finish};
    const vv_box needed = find_tiles(s);
    const size_t n_tiles = (size_t)(s->tiles.n[0] * s->tiles.n[1] * s->tiles.n[2]);
    size_t bytes; /* of the ranges, and of no fewer maps than there are */
    vv_status st = vvi_mul3_size(&bytes, n_tiles + 1, (BINS + 1) * sizeof(double), (size_t)s->info->components);
    if (st != VV_OK || (st = vvi_memory_plan(s->job, bytes, "the maps of tiles")) != VV_OK)
        return st;
    s->range = vvi_alloc(s->job, bytes, VVI_MEM_SCRATCH);
    if (!s->range)
        return vv_fail_memory(bytes);
    s->maps = s->range + 2 * s->info->components;
    st = find_ranges(s, in);
    if (st == VV_OK && (st = vv_field_brick(&s->brick, in, &needed, s->job)) == VV_OK) {
        if ((st = vvi_parallel_for(s->job, &counting, s, n_tiles)) == VV_OK)
            st = vvi_parallel_for(s->job, &mapping, s, s->slabs.n);
        vv_brick_release(&s->brick);
    }
    vvi_free(s->range);
    return st == VV_OK ? vv_field_health(in) : st;
}

vv_status vvi_equalize_tiles(vv_field **out, const vv_field *in, const int64_t n[3], double clip, const vv_box *box,
                             vv_job *job)
{
    shared s = {.info = vv_field_get_info(in),
                .box = *box,
                .n = {n[0], n[1], n[2]},
                .clip = clip,
                .slabs = vvi_slabs_of(box, ITEM_SAMPLES),
                .job = job};
    vv_field_info part = *s.info;
    vv_field *field;
    void *data;
    *out = NULL;
    part.grid = vv_grid_crop(&s.info->grid, box);
    part.value_unit[0] = 0;
    vv_status st = vv_field_new_empty(&field, &data, &part, job);
    if (st != VV_OK)
        return st;
    s.out = data;
    if ((st = run_loops(&s, in)) == VV_OK)
        *out = field;
    else
        vv_field_release(field);
    return st;
}
