/* The linear store: one array, x fastest, components interleaved; owned, borrowed or a mapped file. */
#include "grid/store.h"

#include "core/memory.h"

typedef struct linear {
    vvi_sample_store head;
    const char *data;
    int64_t stride[3]; /* bytes */
    size_t bytes, guard_bytes;
    vv_free_fn *release;
    bool (*damaged)(const void *user);
    void *user;
} linear;

static vv_status linear_brick(vv_brick *out, const vvi_sample_store *store, const vv_box *box, vv_job *job)
{
    (void)job;
    const linear *s = (const linear *)store;
    size_t first = 0, last = 0;
    for (int a = 0; a < 3; a++) {
        first += (size_t)(box->lo[a] * s->stride[a]);
        last += (size_t)((box->lo[a] + box->n[a] - 1) * s->stride[a]);
        out->stride[a] = s->stride[a];
    }
    out->data = s->data + first;
    out->guard_bytes = s->bytes - (last + (size_t)s->stride[0]) + s->guard_bytes;
    out->owner = NULL;
    return VV_OK;
}

static bool linear_damaged(const vvi_sample_store *store)
{
    const linear *s = (const linear *)store;
    return s->damaged && s->damaged(s->user);
}

static void linear_drop(vvi_sample_store *store)
{
    linear *s = (linear *)store;
    if (s->release)
        s->release(s->user);
    vvi_free(s);
}

static const vvi_sample_store_class linear_class = {
    .name = "linear",
    .brick = linear_brick,
    .damaged = linear_damaged,
    .drop = linear_drop,
};

vv_status vvi_sample_store_linear(vvi_sample_store **out, const vv_field_info *info, const void *data,
                                  size_t guard_bytes, vv_free_fn *release, bool (*damaged)(const void *user),
                                  void *user, vv_job *job)
{
    *out = NULL;
    uint64_t bytes = 0;
    vv_status st = vv_field_info_bytes(&bytes, info);
    linear *s = st == VV_OK ? vvi_alloc(job, sizeof *s, VVI_MEM_MODEL) : NULL;
    if (!s) {
        if (st == VV_OK)
            st = vv_fail_memory(sizeof *s);
        if (release)
            release(user);
        return st;
    }
    const int64_t sample = (int64_t)vv_type_bytes(info->type) * info->components;
    *s = (linear){
        .head = {.cls = &linear_class, .refs = 1},
        .data = data,
        .stride = {sample, sample * info->grid.dims[0], sample * info->grid.dims[0] * info->grid.dims[1]},
        .bytes = (size_t)bytes,
        .guard_bytes = guard_bytes,
        .release = release,
        .damaged = damaged,
        .user = user,
    };
    *out = &s->head;
    return VV_OK;
}

vvi_sample_store *vvi_sample_store_retain(vvi_sample_store *store)
{
    atomic_fetch_add_explicit(&store->refs, 1, memory_order_relaxed);
    return store;
}

void vvi_sample_store_release(vvi_sample_store *store)
{
    if (store && atomic_fetch_sub_explicit(&store->refs, 1, memory_order_acq_rel) == 1)
        store->cls->drop(store);
}
