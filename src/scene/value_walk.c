#include "scene/value_walk.h"
#include "core/cache.h"
#include "core/job.h"
#include "core/memory.h"
#include "grid/field.h"
#include "scene/lens.h"
#include <string.h>

static double stored_at(const vvi_walk *w, const int64_t p[3])
{
    const vv_brick *b = &w->brick;
    double v = 0;
    const char *at =
        (const char *)b->data + p[0] * b->stride[0] + p[1] * b->stride[1] + (p[2] - b->box.lo[2]) * b->stride[2];
    vvi_samples_to_f64(&v, at + (size_t)w->component * vv_type_bytes(b->type), b->type, 1);
    return v;
}

double vvi_walk_value(const vvi_walk *w, const int64_t at[3])
{
    return stored_at(w, at) * w->value_scale + w->value_offset;
}

vv_vec3 vvi_walk_gradient(const vvi_walk *w, const int64_t p[3])
{
    double g[3];
    for (int a = 0; a < 3; a++) {
        int64_t lo[3] = {p[0], p[1], p[2]}, hi[3] = {p[0], p[1], p[2]};
        lo[a] -= lo[a] > 0;
        hi[a] += hi[a] < w->n[a] - 1;
        g[a] = hi[a] > lo[a] ? (stored_at(w, hi) - stored_at(w, lo)) / (double)(hi[a] - lo[a]) : 0;
    }
    const vv_affine *m = &w->inverse; /* inverse transpose of index -> world */
    const vv_vec3 world = {m->axis[0].x * g[0] + m->axis[0].y * g[1] + m->axis[0].z * g[2],
                           m->axis[1].x * g[0] + m->axis[1].y * g[1] + m->axis[1].z * g[2],
                           m->axis[2].x * g[0] + m->axis[2].y * g[1] + m->axis[2].z * g[2]};
    return vvi_scaled(world, w->value_scale);
}

/* The slices that a place in slice k looks at: of samples that are not in memory no more are made. */
static vv_status open_slices(vvi_walk *w, const vv_actor *actor, int64_t k, vv_job *job)
{
    vv_box box = vv_field_box(actor->field);
    const int64_t end = k + 2 < w->n[2] ? k + 2 : w->n[2];
    vv_brick_release(&w->brick);
    w->brick = (vv_brick){0};
    box.lo[2] = k > 0 ? k - 1 : 0;
    box.n[2] = end - box.lo[2];
    return vv_field_brick(&w->brick, actor->field, &box, job);
}

static vv_status visit_all(vvi_walk *w, const vv_actor *actor, vvi_walk_fn *visit, void *user, vv_job *job)
{
    const int64_t *n = w->n;
    int64_t step[3], p[3];
    for (int a = 0; a < 3; a++)
        step[a] = (n[a] + VVI_WALK_ALONG - 1) / VVI_WALK_ALONG;
    for (p[2] = 0; p[2] < n[2]; p[2] += step[2]) {
        vv_status st = vvi_job_poll(job);
        if (st != VV_OK || (st = open_slices(w, actor, p[2], job)) != VV_OK)
            return st;
        for (p[1] = 0; p[1] < n[1]; p[1] += step[1])
            for (p[0] = 0; p[0] < n[0]; p[0] += step[0])
                visit(user, w, p);
    }
    return VV_OK;
}

vv_status vvi_walk_samples(const vv_actor *actor, vvi_walk_fn *visit, void *user, vv_job *job)
{
    const vv_field_info *info = vv_field_get_info(actor->field);
    const int64_t *n = info->grid.dims;
    vvi_walk w = {.n = {n[0], n[1], n[2]},
                  .component = actor->component,
                  .value_scale = info->value_scale,
                  .value_offset = info->value_offset};
    if (!vv_affine_invert(&w.inverse, actor->index_to_world))
        return VV_OK; /* place() says so */
    const vv_status st = visit_all(&w, actor, visit, user, job);
    vv_brick_release(&w.brick);
    return st;
}

typedef struct request {
    vvi_walk_find_fn *find;
    const vv_actor *actor;
    size_t bytes;
} request;

static vv_status make(void **value_out, uint64_t *bytes_out, void *user, vv_job *job)
{
    const request *r = user;
    void *value = vvi_alloc(job, r->bytes, VVI_MEM_DERIVED);
    if (!value)
        return vv_fail_memory(r->bytes);
    const vv_status st = r->find(value, r->actor, job);
    *value_out = value;
    *bytes_out = r->bytes;
    if (st != VV_OK)
        vvi_free(value);
    return st;
}

vv_status vvi_walk_once(void *out, size_t bytes, const char *what, vvi_walk_find_fn *find, const vv_actor *actor,
                        vv_job *job)
{
    const struct {
        vv_affine place;
        int64_t component;
    } of = {actor->index_to_world, actor->component};
    const vvi_cache_key key = {what, vv_field_identity(actor->field), vvi_hash(&of, sizeof of, 0)};
    request r = {find, actor, bytes};
    vvi_cached *cached = NULL;
    const vv_status st = vvi_cache_get(&cached, &key, make, vvi_free, &r, job);
    if (st != VV_OK)
        return st;
    memcpy(out, vvi_cached_value(cached), bytes);
    vvi_cache_release(cached);
    return VV_OK;
}
