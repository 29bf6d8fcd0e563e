/* Blocks and boxes of a volume in which nothing is visible. */
#include "core/cache.h"
#include "core/job.h"
#include "render/common/cubic_range.h"
#include "render/common/minmax_spread.h"
#include "render/march/skip.h"
#include "render/raycast/prepare.h"
#include <math.h>
#include <string.h>

enum { SHIFT_SMALL = 2, SHIFT_LARGE = 3, SHIFT_BOX = 3, MOST_BOXES = 64 };

typedef struct visibility {
    const vvi_transfer_table *table; /* NULL: a solid */
    double scale, offset;
    float solid_lo, solid_hi;
} visibility;

static bool visible(const void *user, float lo, float hi)
{
    const visibility *v = user;
    if (!v->table)
        return lo <= v->solid_hi && hi >= v->solid_lo;
    const double a = lo * v->scale + v->offset, b = hi * v->scale + v->offset;
    return vvi_transfer_occupancy(v->table, fmin(a, b), fmax(a, b));
}

typedef struct skip_request {
    const vvi_minmax *minmax;
    const visibility *visibility;
    int reach; /* blocks */
} skip_request;

typedef struct even_request {
    const vvi_minmax *minmax;
    const vv_statistics *statistics;
} even_request;

/* Blocks whose values are those of all within reach; NULL where the blocks' own are. */
static vv_status spread_blocks(vvi_minmax **out, const skip_request *r, vv_job *job)
{
    *out = NULL;
    return r->reach ? vvi_minmax_spread(out, r->minmax, r->reach, job) : VV_OK;
}

static vv_status make_skip(void **value_out, uint64_t *bytes_out, void *user, vv_job *job)
{
    const skip_request *r = user;
    vvi_minmax *wide = NULL;
    vvi_skip *skip = NULL;
    vv_status st = spread_blocks(&wide, r, job);
    if (st == VV_OK)
        st = vvi_skip_build(&skip, wide ? wide : r->minmax, visible, r->visibility, job);
    vvi_minmax_free(wide);
    *bytes_out = (uint64_t)r->minmax->n[0] * (uint64_t)r->minmax->n[1] * (uint64_t)r->minmax->n[2];
    *value_out = skip;
    return st;
}

/* How many blocks beyond its own a sample may read. An integrated step that lies in empty blocks as a whole sees none
 * of the values between its ends: what is interpolated has no gaps, but for samples that are no numbers. */
static int find_reach(const vvi_raycast_volume *v, int shift)
{
    const vvi_march_volume *f = &v->ray;
    double most = 0;
    if (f->classifier.kind != VVI_CLASSIFY_INTEGRATED ||
        !(v->actor->statistics->nan_count + v->actor->statistics->infinite_count))
        return 0;
    for (int a = 0; a < 3; a++) {
        const double *m = f->sampler.world_to_index[a];
        most = fmax(most, f->step * sqrt(m[0] * m[0] + m[1] * m[1] + m[2] * m[2]));
    }
    return (int)fmin(ceil((most + 0.01) / (1 << shift)), 1 << 20); /* a hundredth: places are floats */
}

static uint64_t hash_visibility(const visibility *v)
{
    const float range[2] = {v->solid_lo, v->solid_hi};
    uint64_t h = vvi_hash(range, sizeof range, 0);
    if (v->table) {
        const double place[4] = {v->table->lo, v->table->hi, v->scale, v->offset};
        h = vvi_hash(place, sizeof place, h);
        h = vvi_hash(v->table->running, (v->table->n + 1) * sizeof *v->table->running, h);
    }
    return h;
}

static visibility find_visibility(const vvi_raycast_volume *v, const vvi_transfer_table *table)
{
    const vvi_march_volume *f = &v->ray;
    return (visibility){table, v->hold.value_scale, v->hold.value_offset, f->solid.lo, f->solid.hi};
}

/* The value range of each block of a volume, and the key by which more is derived from it. */
static vv_status get_minmax(vvi_raycast_volume *v, vvi_cache_key *key_out, vv_job *job)
{
    const int32_t *n = v->hold.lattice.n;
    const bool cubic = v->ray.sampler.cubic;
    /* small blocks fit a surface closer; beyond some millions of them they would no longer fit a cache */
    const int shift = (int64_t)n[0] * n[1] * n[2] <= (int64_t)1 << 25 ? SHIFT_SMALL : SHIFT_LARGE;
    *key_out = vvi_minmax_key(cubic ? "range cubic" : "minmax", v->actor->field, v->actor->component, shift);
    if (v->minmax)
        return VV_OK;
    return cubic ? vvi_cubic_range_get(&v->minmax, key_out, &v->hold.lattice, shift, job)
                 : vvi_minmax_get_lattice(&v->minmax, key_out, &v->hold, shift, job);
}

/* Of means and sums: what has more than one value, as far as the least and the largest tell, which leave out what is no
 * number. */
static bool is_varied(const void *user, float lo, float hi)
{
    const vv_statistics *s = user;
    return s->nan_count ? lo <= hi : lo < hi;
}

static vv_status make_even(void **value_out, uint64_t *bytes_out, void *user, vv_job *job)
{
    const even_request *r = user;
    vvi_skip *skip = NULL;
    const vv_status st = vvi_skip_build(&skip, r->minmax, is_varied, r->statistics, job);
    *bytes_out = (uint64_t)r->minmax->n[0] * (uint64_t)r->minmax->n[1] * (uint64_t)r->minmax->n[2];
    *value_out = skip;
    return st;
}

/* Blocks that are taken at once. To look for a few of them costs more than it saves. */
static vv_status find_even(vvi_raycast_volume *v, const vvi_minmax *m, const vvi_cache_key *of_minmax, vv_job *job)
{
    even_request r = {m, v->actor->statistics};
    const vvi_cache_key key = {"skip even", of_minmax->identity, of_minmax->parameters};
    const vv_status st = vvi_cache_get(&v->skip, &key, make_even, vvi_skip_free, &r, job);
    if (st != VV_OK)
        return st;
    const vvi_skip *skip = vvi_cached_value(v->skip);
    const uint64_t n = (uint64_t)m->n[0] * (uint64_t)m->n[1] * (uint64_t)m->n[2];
    if (skip->n_occupied <= n - n / 8) {
        v->ray.skipper.reach = skip->reach;
        v->ray.skipper.block_bound = m->lo;
    }
    return VV_OK;
}

vv_status vvi_raycast_find_blocks(vvi_raycast_volume *volume, const vvi_transfer_table *table, vv_job *job)
{
    vvi_march_volume *f = &volume->ray;
    const visibility v = find_visibility(volume, table);
    vvi_cache_key key;
    vv_status st = get_minmax(volume, &key, job);
    if (st != VV_OK)
        return st;
    const vvi_minmax *m = vvi_cached_value(volume->minmax);
    memcpy(f->skipper.blocks, m->n, sizeof f->skipper.blocks);
    f->skipper.shift = m->shift;
    if (volume->layer && (volume->params->mode == VV_RAY_MEAN || volume->params->mode == VV_RAY_SUM))
        return find_even(volume, m, &key, job);
    if (volume->layer) {
        f->skipper.block_bound = f->projection.sign < 0 ? m->lo : m->hi;
        return VV_OK;
    }
    skip_request sr = {m, &v, find_reach(volume, m->shift)};
    const uint64_t reach = vvi_hash(&sr.reach, sizeof sr.reach, hash_visibility(&v));
    const vvi_cache_key skip_key = {volume->ray.sampler.cubic ? "skip cubic" : "skip", key.identity,
                                    reach ^ key.parameters};
    if ((st = vvi_cache_get(&volume->skip, &skip_key, make_skip, vvi_skip_free, &sr, job)) != VV_OK)
        return st;
    const vvi_skip *skip = vvi_cached_value(volume->skip);
    f->skipper.reach = skip->reach;
    volume->visible = volume->visible && skip->n_occupied > 0;
    return VV_OK;
}

/* PARC ---------------------------------------------------------------------------------------------------------- */

static vv_status make_boxes(void **value_out, uint64_t *bytes_out, void *user, vv_job *job)
{
    const skip_request *r = user;
    const vvi_minmax *m = r->minmax;
    vvi_minmax *wide;
    const int32_t most = m->n[0] > m->n[1] ? m->n[0] : m->n[1], n = most > m->n[2] ? most : m->n[2];
    vvi_boxes *boxes = NULL;
    int shift = SHIFT_BOX;
    while (n >> (shift - m->shift) > MOST_BOXES) /* to find where more of them are takes longer than it saves */
        shift++;
    vv_status st = spread_blocks(&wide, r, job);
    if (st == VV_OK)
        st = vvi_boxes_build(&boxes, wide ? wide : m, shift, visible, r->visibility, job);
    vvi_minmax_free(wide);
    if (st == VV_OK)
        *bytes_out = vvi_boxes_bytes(boxes);
    *value_out = boxes;
    return st;
}

vv_status vvi_raycast_bound_rays(vvi_raycast_volume *volume, const vv_scene *scene, const vvi_transfer_table *table,
                                 vv_job *job)
{
    vvi_march_volume *f = &volume->ray;
    const visibility v = find_visibility(volume, table);
    vvi_cache_key key;
    vv_status st = get_minmax(volume, &key, job);
    if (st != VV_OK)
        return st;
    const vvi_minmax *m = vvi_cached_value(volume->minmax);
    skip_request r = {m, &v, find_reach(volume, m->shift)};
    const uint64_t reach = vvi_hash(&r.reach, sizeof r.reach, hash_visibility(&v));
    const vvi_cache_key boxes_key = {volume->ray.sampler.cubic ? "boxes cubic" : "boxes", key.identity,
                                     reach ^ key.parameters};
    if ((st = vvi_cache_get(&volume->boxes, &boxes_key, make_boxes, vvi_boxes_free, &r, job)) != VV_OK)
        return st;
    const vvi_boxes *boxes = vvi_cached_value(volume->boxes);
    if (!boxes->n_kept) {
        volume->visible = false;
        return VV_OK;
    }
    const vvi_parc_view view = {
        .lens = &scene->lens,
        .width = scene->width,
        .height = scene->height,
        .top = scene->top,
        .rows = scene->rows,
        .index_to_world = volume->actor->index_to_world,
        .lo = {f->sampler.lo[0], f->sampler.lo[1], f->sampler.lo[2]},
        .hi = {f->sampler.hi[0], f->sampler.hi[1], f->sampler.hi[2]},
        .before = volume->ray.sampler.nearest ? 0.5 : 0,
    };
    if ((st = vvi_parc_init(&volume->parc, boxes, &view, job)) == VV_OK)
        f->skipper.parc = &volume->parc;
    return st;
}
