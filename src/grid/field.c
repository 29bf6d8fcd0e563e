/* Fields: life, identity, bricks. Where the samples lie is the store's business (store.h). */
#include "grid/field.h"

#include "core/cache.h"
#include "core/job.h"
#include "core/memory.h"
#include "grid/store.h"

#include <math.h>
#include <string.h>

/* `runtime` is not retained: the memory of this very struct (or of the store it shares) came from it and keeps it
 * alive, so a field never outlives it. */
struct vv_field {
    _Atomic uint32_t refs;
    uint64_t identity;
    vv_runtime *runtime; /* whose cache holds derived data; NULL: made without a job */
    vvi_sample_store *store;
    vv_field_info info;
    bool padded;
    double padding[2]; /* ends of a range */
};

/* The one counter that all runtimes share: an identity must be no other field's of the process. */
static _Atomic uint64_t last_identity;

vv_status vvi_field_on_samples(vv_field **out, const vv_field_info *info, vvi_sample_store *store, vv_runtime *runtime,
                               vv_job *job)
{
    *out = NULL;
    vv_field *field = vvi_alloc(job, sizeof *field, VVI_MEM_MODEL);
    if (!field) {
        const vv_status st = vv_fail_memory(sizeof *field);
        vvi_sample_store_release(store);
        return st;
    }
    *field = (vv_field){
        .refs = 1,
        .identity = atomic_fetch_add_explicit(&last_identity, 1, memory_order_relaxed) + 1,
        .runtime = runtime,
        .store = store,
        .info = *info,
    };
    *out = field;
    return VV_OK;
}

vv_status vvi_field_new_watched(vv_field **out, const vv_field_info *info, const void *data, size_t guard_bytes,
                                vv_free_fn *release, bool (*damaged)(const void *user), void *user, vv_job *job)
{
    *out = NULL;
    const bool given = info && data;
    vv_status st = given ? vv_field_info_check(info)
                         : vv_fail(VV_E_ARGUMENT, "a field needs an info and samples; one of them is NULL");
    vvi_sample_store *store = NULL;
    if (!given || st != VV_OK) {
        if (release)
            release(user);
        return st;
    }
    if ((st = vvi_sample_store_linear(&store, info, data, guard_bytes, release, damaged, user, job)) != VV_OK)
        return st;
    return vvi_field_on_samples(out, info, store, job ? vv_job_runtime(job) : NULL, job);
}

vv_status vv_field_new(vv_field **out, const vv_field_info *info, const void *data, size_t guard_bytes,
                       vv_free_fn *release, void *user, vv_job *job)
{
    return vvi_field_new_watched(out, info, data, guard_bytes, release, NULL, user, job);
}

vv_status vv_field_new_empty(vv_field **out, void **data_out, const vv_field_info *info, vv_job *job)
{
    *out = NULL;
    *data_out = NULL;
    uint64_t bytes;
    vv_status st;
    if ((st = vv_field_info_check(info)) != VV_OK || (st = vv_field_info_bytes(&bytes, info)) != VV_OK ||
        (st = vvi_memory_plan(job, bytes + VVI_FIELD_GUARD, "a volume")) != VV_OK)
        return st;
    char *lent = vvi_job_take_room(job, (size_t)bytes + VVI_FIELD_GUARD);
    char *data = lent ? lent : vvi_alloc(job, (size_t)bytes + VVI_FIELD_GUARD, VVI_MEM_VOXELS);
    if (!data)
        return vv_fail_memory((size_t)bytes + VVI_FIELD_GUARD);
    memset(data + bytes, 0, VVI_FIELD_GUARD);
    if ((st = vv_field_new(out, info, data, VVI_FIELD_GUARD, lent ? NULL : vvi_free, data, job)) == VV_OK)
        *data_out = data;
    return st;
}

static bool same_samples(const vv_field_info *a, const vv_field_info *b)
{
    return a->type == b->type && a->components == b->components &&
           memcmp(a->grid.dims, b->grid.dims, sizeof a->grid.dims) == 0;
}

vv_status vvi_field_relabel(vv_field **out, const vv_field *field, const vv_field_info *info)
{
    *out = NULL;
    const vv_status st = vv_field_info_check(info);
    if (st != VV_OK)
        return st;
    if (!same_samples(&field->info, info))
        return vv_fail(VV_E_ARGUMENT, "the same samples cannot have other dims, type or channels");
    const vv_status made = vvi_field_on_samples(out, info, vvi_sample_store_retain(field->store), field->runtime, NULL);
    if (made == VV_OK && field->padded)
        vvi_field_set_padding(*out, field->padding[0], field->padding[1]);
    return made;
}

void vvi_field_set_padding(vv_field *field, double lo, double hi)
{
    field->padded = true;
    field->padding[0] = fmin(lo, hi);
    field->padding[1] = fmax(lo, hi);
}

bool vvi_field_padding(double out[2], const vv_field *field)
{
    memcpy(out, field->padding, sizeof field->padding);
    return field->padded;
}

vv_field *vv_field_retain(const vv_field *field)
{
    vv_field *f = (vv_field *)field; /* the count is no part of what is immutable */
    atomic_fetch_add_explicit(&f->refs, 1, memory_order_relaxed);
    return f;
}

void vv_field_release(vv_field *field)
{
    if (!field || atomic_fetch_sub_explicit(&field->refs, 1, memory_order_acq_rel) != 1)
        return;
    if (field->runtime)
        vvi_cache_forget(field->runtime, field->identity);
    vvi_sample_store *store = field->store;
    vvi_free(field);
    vvi_sample_store_release(store);
}

const vv_field_info *vv_field_get_info(const vv_field *field)
{
    return &field->info;
}

uint64_t vv_field_identity(const vv_field *field)
{
    return field->identity;
}

vvi_sample_store *vvi_field_store(const vv_field *field)
{
    return field->store;
}

bool vvi_field_is_lazy(const vv_field *field)
{
    return field->store->cls->lazy;
}

vv_status vvi_field_prepare(const vv_field *field, vv_job *job)
{
    const vvi_sample_store_class *cls = field->store->cls;
    return cls->prepare ? cls->prepare(field->store, job) : VV_OK;
}

bool vvi_field_is_damaged(const vv_field *field)
{
    const vvi_sample_store *store = field->store;
    return store->cls->damaged && store->cls->damaged(store);
}

vv_status vv_field_health(const vv_field *field)
{
    if (vvi_field_is_damaged(field))
        return vv_fail(VV_E_READ,
                       "the file behind the samples%s%s shrank or could no longer be read; missing samples "
                       "were taken as 0",
                       field->info.name[0] ? " of " : "", field->info.name);
    return VV_OK;
}

vv_box vv_field_box(const vv_field *field)
{
    vv_box box = {{0, 0, 0}, {0, 0, 0}};
    memcpy(box.n, field->info.grid.dims, sizeof box.n);
    return box;
}

static bool box_is_inside(const vv_box *box, const int64_t dims[3])
{
    for (int a = 0; a < 3; a++)
        if (box->lo[a] < 0 || box->n[a] < 1 || box->lo[a] >= dims[a] || box->n[a] > dims[a] - box->lo[a])
            return false;
    return true;
}

vv_status vv_field_brick(vv_brick *out, const vv_field *field, const vv_box *box, vv_job *job)
{
    *out = (vv_brick){.box = *box, .type = field->info.type, .components = field->info.components};
    const int64_t *d = field->info.grid.dims;
    if (!box_is_inside(box, d))
        return vv_fail(VV_E_ARGUMENT,
                       "the box of %lld x %lld x %lld samples at (%lld, %lld, %lld) is not inside the field of "
                       "%lld x %lld x %lld",
                       (long long)box->n[0], (long long)box->n[1], (long long)box->n[2], (long long)box->lo[0],
                       (long long)box->lo[1], (long long)box->lo[2], (long long)d[0], (long long)d[1], (long long)d[2]);
    const vv_status st = vv_field_health(field);
    return st == VV_OK ? field->store->cls->brick(out, field->store, box, job) : st;
}

void vv_brick_release(vv_brick *brick)
{
    vvi_brick_owner *owner = brick->owner;
    if (owner)
        owner->release(owner);
    *brick = (vv_brick){0};
}

vv_brick vvi_brick_part(const vv_brick *brick, const vv_box *box)
{
    vv_brick part = *brick;
    const char *data = brick->data;
    for (int a = 0; a < 3; a++)
        data += (box->lo[a] - brick->box.lo[a]) * brick->stride[a];
    part.data = data;
    part.box = *box;
    part.guard_bytes = 0;
    part.owner = NULL;
    return part;
}

static int64_t clamp_index(int64_t i, int64_t n)
{
    return i < 0 ? 0 : i >= n ? n - 1 : i;
}

double vv_field_value(const vv_field *field, int64_t i, int64_t j, int64_t k, int component)
{
    const vv_field_info *info = &field->info;
    const int64_t *d = info->grid.dims;
    const vv_box box = {{clamp_index(i, d[0]), clamp_index(j, d[1]), clamp_index(k, d[2])}, {1, 1, 1}};
    const int c = (int)clamp_index(component, info->components);
    vv_brick brick = {.box = box, .type = info->type, .components = info->components};
    double stored = NAN;
    if (field->store->cls->brick(&brick, field->store, &box, NULL) == VV_OK)
        vvi_samples_to_f64(&stored, (const char *)brick.data + (size_t)c * vv_type_bytes(info->type), info->type, 1);
    vv_brick_release(&brick);
    return stored * info->value_scale + info->value_offset;
}
