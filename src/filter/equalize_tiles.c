#include "filter/equalize_tiles.h"
#include "core/cache.h"
#include "core/job.h"
#include "core/memory.h"
#include "grid/making.h"

#include <math.h>
#include <string.h>

#define ITEM_SAMPLES ((int64_t)1 << 14)
#define COUNTED ((int64_t)1 << 17) /* samples at a time, or a slice */

enum { BINS = VVI_TILE_BINS };

/* What a look at all samples finds, kept in the job's cache. */
typedef struct tables {
    double *range; /* of each component: the least and the largest stored number */
    double *maps;  /* of each tile and component: the share of samples below each of BINS + 1 ends */
} tables;

typedef struct shared {
    vvi_making making;
    const vv_field *in;
    const vv_field_info *info;
    int64_t n[3]; /* of tiles */
    double clip;
    tables *tables;
    vv_brick brick; /* slices that are counted, of tiles that lie in them */
    int64_t layer;  /* of tiles, along z */
    double *count;  /* of each of its tiles and components: BINS, and all */
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

static void count_row(double *count, const char *in, int64_t n, const vv_brick *b, const double range[2])
{
    for (int64_t i = 0; i < n; i++) {
        double v;
        vvi_samples_to_f64(&v, in + i * b->stride[0], b->type, 1);
        if (!isfinite(v))
            continue;
        const int bin = (int)bin_at(v, range);
        count[bin < BINS ? bin : BINS - 1]++;
        count[BINS]++;
    }
}

static double *map_of(const shared *s, const int64_t tile[3], int component)
{
    const int64_t index = (tile[2] * s->n[1] + tile[1]) * s->n[0] + tile[0];
    return s->tables->maps + (size_t)(index * s->info->components + component) * (BINS + 1);
}

/* The slices of a tile of the layer. */
static vv_status count_tile(void *scratch, void *user, size_t index)
{
    const shared *s = user;
    const int64_t tile[2] = {(int64_t)index % s->n[0], (int64_t)index / s->n[0]};
    vv_box box = s->brick.box;
    for (int a = 0; a < 2; a++) {
        box.lo[a] = tile_begin(s, a, tile[a]);
        box.n[a] = tile_begin(s, a, tile[a] + 1) - box.lo[a];
    }
    const vv_brick b = vvi_brick_part(&s->brick, &box);
    for (int c = 0; c < s->info->components; c++) {
        double *count = s->count + (index * (size_t)s->info->components + (size_t)c) * (BINS + 1);
        const char *in = (const char *)b.data + (size_t)c * vv_type_bytes(b.type);
        for (int64_t k = 0; k < box.n[2]; k++)
            for (int64_t j = 0; j < box.n[1]; j++)
                count_row(count, in + j * b.stride[1] + k * b.stride[2], box.n[0], &b, s->tables->range + 2 * c);
    }
    return vvi_job_poll(s->job);
}

/* A few slices at a time: a layer of tiles may be more than memory holds. */
static vv_status count_layer(shared *s, size_t count_bytes)
{
    const int64_t *d = s->info->grid.dims, first = tile_begin(s, 2, s->layer), end = tile_begin(s, 2, s->layer + 1);
    const vv_box all = {{0, 0, first}, {d[0], d[1], end - first}};
    int64_t slices = COUNTED / (d[0] * d[1]) + 1;
    const size_t n_tiles = (size_t)(s->n[0] * s->n[1]), n_layers = (size_t)s->n[2], at = (size_t)s->layer;
    vv_status st = VV_OK;
    memset(s->count, 0, count_bytes);
    for (int64_t k = first; k < end && st == VV_OK;) {
        const vvi_work work = {.stage = "equalize",
                               .item = count_tile,
                               .n_before = at * n_tiles,
                               .n_after = (n_layers - at - 1) * n_tiles};
        vv_box part = all;
        part.lo[2] = k;
        part.n[2] = end - k < slices ? end - k : slices;
        if ((st = vv_field_brick(&s->brick, s->in, &part, s->job)) == VV_OK)
            st = vvi_parallel_for(s->job, &work, s, n_tiles);
        vv_brick_release(&s->brick);
        k += st == VV_OK ? part.n[2] : 0;
        if (st == VV_E_LIMIT && slices > 1) {
            slices /= 2;
            st = VV_OK;
        }
    }
    for (size_t i = 0; i < n_tiles && st == VV_OK; i++)
        for (int c = 0; c < s->info->components; c++) {
            const int64_t tile[3] = {(int64_t)i % s->n[0], (int64_t)i / s->n[0], s->layer};
            const double *count = s->count + (i * (size_t)s->info->components + (size_t)c) * (BINS + 1);
            make_map(map_of(s, tile, c), count, count[BINS], s->clip);
        }
    return st;
}

static double share_below(const double *map, double at)
{
    const int bin = at < BINS ? (int)at : BINS - 1;
    return map[bin] + (map[bin + 1] - map[bin]) * (at - bin);
}

/* The maps of the eight tiles around a sample. */
static double mixed(double v, const shared *s, const int64_t before[3], const double part[3], int component)
{
    const double *range = s->tables->range + 2 * component, at = bin_at(v, range);
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
            share += weight * share_below(map_of(s, tile, component), at);
    }
    return range[0] + (range[1] - range[0]) * share;
}

static vv_status start(void **scratch_out, void *user, int worker)
{
    const shared *s = user;
    const size_t bytes = (size_t)(s->making.slabs.step[0] * s->info->components) * sizeof(double);
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
            if (isfinite(*v) && s->tables->range[2 * c] < s->tables->range[2 * c + 1])
                *v = mixed(*v, s, before, part, c);
        }
    }
}

static vv_status map_item(void *scratch, void *user, size_t index)
{
    const shared *s = user;
    const vv_box box = vvi_slabs_item(&s->making.slabs, index);
    const vv_brick brick = vvi_brick_part(&s->making.brick, &box);
    const size_t n = (size_t)(box.n[0] * s->info->components), each = vv_type_bytes(s->info->type);
    for (int64_t k = 0; k < box.n[2]; k++)
        for (int64_t j = 0; j < box.n[1]; j++) {
            const int64_t at = vvi_slabs_row(&s->making.slabs, &box, j, k) * s->info->components;
            const char *in = (const char *)brick.data + j * brick.stride[1] + k * brick.stride[2];
            vvi_samples_to_f64(scratch, in, s->info->type, n);
            map_row(scratch, s, &box, j, k);
            vvi_samples_from_f64(s->making.out + (size_t)at * each, scratch, s->info->type, n);
        }
    return vvi_job_poll(s->job);
}

static vv_status find_ranges(const shared *s)
{
    vv_statistics found;
    vv_status st = VV_OK;
    for (int c = 0; c < s->info->components && st == VV_OK; c++)
        if ((st = vv_field_statistics(&found, s->in, c, s->job)) == VV_OK) {
            const double a = (found.min - s->info->value_offset) / s->info->value_scale,
                         b = (found.max - s->info->value_offset) / s->info->value_scale;
            s->tables->range[2 * c] = fmin(a, b);
            s->tables->range[2 * c + 1] = fmax(a, b);
        }
    return st;
}

static vv_status make_tables(void **value_out, uint64_t *bytes_out, void *user, vv_job *job)
{
    shared *s = user;
    const size_t components = (size_t)s->info->components, layer = (size_t)(s->n[0] * s->n[1]);
    const size_t count_bytes = layer * components * (BINS + 1) * sizeof(double);
    size_t bytes; /* of the ranges, and of no fewer maps than there are */
    vv_status st = vvi_mul3_size(&bytes, layer * (size_t)s->n[2] + 1, (BINS + 1) * sizeof(double), components);
    if (st != VV_OK || (st = vvi_memory_plan(job, bytes + count_bytes, "equalize")) != VV_OK)
        return st;
    tables *t = s->tables = vvi_alloc(job, sizeof *t + bytes, VVI_MEM_DERIVED);
    s->count = vvi_alloc(job, count_bytes, VVI_MEM_SCRATCH);
    if (!t || !s->count)
        st = vv_fail_memory(bytes);
    if (st == VV_OK) {
        t->range = (double *)(void *)(t + 1);
        t->maps = t->range + 2 * components;
        st = find_ranges(s);
    }
    for (s->layer = 0; s->layer < s->n[2] && st == VV_OK; s->layer++)
        st = count_layer(s, count_bytes);
    vvi_free(s->count);
    if (st != VV_OK) {
        vvi_free(t);
        return st;
    }
    *value_out = t;
    *bytes_out = sizeof *t + bytes;
    return VV_OK;
}

vv_status vvi_equalize_tiles(vv_field **out, const vv_field *in, const int64_t n[3], double clip, const vv_box *box,
                             vv_job *job)
{
    static const vvi_work work = {.stage = "equalize", .start = start, .item = map_item, .finish = finish};
    vv_field_info info = *vv_field_get_info(in);
    shared s = {.making = {.in = in, .slabs = vvi_slabs_of(box, ITEM_SAMPLES)},
                .in = in,
                .info = vv_field_get_info(in),
                .n = {n[0], n[1], n[2]},
                .clip = clip,
                .job = job};
    const vvi_cache_key key = {"maps of tiles", vv_field_identity(in),
                               vvi_hash(&clip, sizeof clip, vvi_hash(n, 3 * sizeof *n, 0))};
    vvi_cached *cached;
    *out = NULL;
    info.value_unit[0] = 0;
    vv_status st = vvi_cache_get(&cached, &key, make_tables, vvi_free, &s, job);
    if (st != VV_OK)
        return st;
    s.tables = vvi_cached_value(cached);
    st = vvi_making_run(out, &s.making, &info, box, box, &work, &s, job);
    vvi_cache_release(cached);
    return st;
}
