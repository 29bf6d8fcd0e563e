/* Blocks of a volume in which nothing is visible. */
#include "core/cache.h"
#include "core/job.h"
#include "render/common/skip.h"
#include "render/raycast/prepare.h"
#include <math.h>
#include <string.h>

enum { SHIFT_SMALL = 2, SHIFT_LARGE = 3 };

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

typedef struct minmax_request {
    const vv_brick *brick;
    int shift;
} minmax_request;

static vv_status make_minmax(void **value_out, uint64_t *bytes_out, void *user, vv_job *job)
{
    const minmax_request *r = user;
    vvi_minmax *m = NULL;
    const vv_status st = vvi_minmax_build(&m, r->brick, 0, r->shift, job);
    if (st == VV_OK)
        *bytes_out = (uint64_t)m->n[0] * (uint64_t)m->n[1] * (uint64_t)m->n[2] * 2 * sizeof(float);
    *value_out = m;
    return st;
}

typedef struct skip_request {
    const vvi_minmax *minmax;
    const visibility *visibility;
} skip_request;

static vv_status make_skip(void **value_out, uint64_t *bytes_out, void *user, vv_job *job)
{
    const skip_request *r = user;
    vvi_skip *skip = NULL;
    const vv_status st = vvi_skip_build(&skip, r->minmax, visible, r->visibility, job);
    *bytes_out = (uint64_t)r->minmax->n[0] * (uint64_t)r->minmax->n[1] * (uint64_t)r->minmax->n[2];
    *value_out = skip;
    return st;
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

vv_status vvi_raycast_find_blocks(vvi_raycast_volume *volume, const vvi_transfer_table *table, int mode, vv_job *job)
{
    vvi_ray_frame *f = &volume->blend.ray;
    const visibility v = {table, volume->hold.value_scale, volume->hold.value_offset, f->solid_lo, f->solid_hi};
    const vv_actor *actor = volume->actor;
    const int64_t *n = volume->hold.brick.box.n;
    minmax_request mr = {.brick = &volume->hold.brick};
    /* small blocks fit a surface closer; beyond some millions of them they would no longer fit a cache */
    mr.shift = n[0] * n[1] * n[2] <= (int64_t)1 << 25 ? SHIFT_SMALL : SHIFT_LARGE;
    const uint64_t identity = vv_field_identity(actor->field);
    const vvi_cache_key key = {"minmax", identity, (uint64_t)mr.shift << 32 | (uint32_t)actor->component};
    vv_status st = vvi_cache_get(&volume->minmax, &key, make_minmax, vvi_minmax_free, &mr, job);
    if (st != VV_OK)
        return st;
    const vvi_minmax *m = vvi_cached_value(volume->minmax);
    memcpy(f->blocks, m->n, sizeof f->blocks);
    f->shift = m->shift;
    if (mode == VVI_RAYCAST_MAXIMUM) {
        f->block_hi = m->hi;
        return VV_OK;
    }
    skip_request sr = {m, &v};
    const vvi_cache_key skip_key = {"skip", identity, hash_visibility(&v) ^ key.parameters};
    if ((st = vvi_cache_get(&volume->skip, &skip_key, make_skip, vvi_skip_free, &sr, job)) != VV_OK)
        return st;
    const vvi_skip *skip = vvi_cached_value(volume->skip);
    f->distance = skip->distance;
    volume->visible = skip->n_occupied > 0;
    return VV_OK;
}
