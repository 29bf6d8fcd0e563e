#include "grid/lazy.h"
#include "core/job.h"
#include "core/memory.h"
#include "grid/store.h"
#include <pthread.h>
#include <string.h>

enum { SLABS_KEPT = 2 };

typedef struct slab {
    const vvi_sample_store *of; /* NULL: empty */
    vv_box box;
    vv_field *field;
    uint64_t used; /* the larger, the later */
} slab;

struct vvi_lazy_pool {
    _Atomic uint32_t refs;
    pthread_mutex_t lock; /* also held while a slab is made: neighbours that wait then find it */
    uint64_t most_bytes, least_bytes, clock;
    uint64_t slab_bytes; /* now, between the two */
    bool alone;          /* there is room for one slab at a time */
    uint64_t made;       /* samples */
    slab slabs[SLABS_KEPT];
};

typedef struct lazy {
    vvi_sample_store head;
    vv_field_info info;
    vvi_lazy_source source;
    vvi_lazy_pool *pool;
    atomic_bool damaged; /* a slab was, when a brick of it went */
} lazy;

vv_status vvi_lazy_pool_new(vvi_lazy_pool **out, uint64_t slab_bytes, uint64_t least_bytes, vv_job *job)
{
    vvi_lazy_pool *pool = vvi_alloc_zeroed(job, sizeof *pool, VVI_MEM_MODEL);
    *out = NULL;
    if (!pool || pthread_mutex_init(&pool->lock, NULL) != 0) {
        vvi_free(pool);
        return vv_fail_memory(sizeof *pool);
    }
    pool->refs = 1;
    pool->most_bytes = pool->slab_bytes = slab_bytes;
    pool->least_bytes = least_bytes;
    *out = pool;
    return VV_OK;
}

vvi_lazy_pool *vvi_lazy_pool_retain(vvi_lazy_pool *pool)
{
    atomic_fetch_add_explicit(&pool->refs, 1, memory_order_relaxed);
    return pool;
}

void vvi_lazy_pool_release(vvi_lazy_pool *pool)
{
    if (!pool || atomic_fetch_sub_explicit(&pool->refs, 1, memory_order_acq_rel) != 1)
        return;
    for (int i = 0; i < SLABS_KEPT; i++)
        vv_field_release(pool->slabs[i].field);
    pthread_mutex_destroy(&pool->lock);
    vvi_free(pool);
}

static void empty(slab *kept)
{
    vv_field_release(kept->field);
    *kept = (slab){0};
}

void vvi_lazy_pool_empty(vvi_lazy_pool *pool)
{
    pthread_mutex_lock(&pool->lock);
    for (int i = 0; i < SLABS_KEPT; i++)
        empty(&pool->slabs[i]);
    pthread_mutex_unlock(&pool->lock);
}

uint64_t vvi_lazy_pool_made(vvi_lazy_pool *pool)
{
    pthread_mutex_lock(&pool->lock);
    const uint64_t made = pool->made;
    pthread_mutex_unlock(&pool->lock);
    return made;
}

static uint64_t slice_bytes(const lazy *s)
{
    const int64_t *d = s->info.grid.dims;
    return (uint64_t)d[0] * (uint64_t)d[1] * vv_type_bytes(s->info.type) * (uint64_t)s->info.components;
}

/* How many whole slices a slab has; a multiple of 64 where so many fit: readers by blocks then meet whole blocks. */
static int64_t slab_slices(const lazy *s)
{
    const int64_t *d = s->info.grid.dims;
    const uint64_t n = s->pool->slab_bytes / slice_bytes(s);
    if (n >= (uint64_t)d[2])
        return d[2];
    return n > 64 ? (int64_t)(n - n % 64) : n > 0 ? (int64_t)n : 1;
}

/* The slab that has slice k. Slabs never overlap, so that a packed file is read forwards. */
static vv_box slab_box(const lazy *s, int64_t k)
{
    const int64_t *d = s->info.grid.dims, n = slab_slices(s), lo = k - k % n;
    return (vv_box){{0, 0, lo}, {d[0], d[1], d[2] - lo < n ? d[2] - lo : n}};
}

static slab *find(vvi_lazy_pool *pool, const lazy *s, int64_t k)
{
    for (int i = 0; i < SLABS_KEPT; i++) {
        const vv_box *box = &pool->slabs[i].box;
        if (pool->slabs[i].of == &s->head && box->lo[2] <= k && k < box->lo[2] + box->n[2])
            return &pool->slabs[i];
    }
    return NULL;
}

/* Nothing is kept, or half as many slices are made; false: there are as few as may be, and it is for others to have
 * less. */
static bool shrink(const lazy *s)
{
    vvi_lazy_pool *pool = s->pool;
    const uint64_t half = (uint64_t)slab_slices(s) / 2 * slice_bytes(s);
    bool kept = false;
    for (int i = 0; i < SLABS_KEPT; i++) {
        kept = kept || pool->slabs[i].field;
        empty(&pool->slabs[i]);
    }
    if (kept && pool->least_bytes == 0)
        return pool->alone = true;
    const bool thinner = half > 0 && half >= pool->least_bytes;
    pool->slab_bytes = thinner ? half : pool->most_bytes;
    return thinner;
}

/* Under the lock. */
static vv_status make(vv_field **out, const lazy *s, const vv_box *box, vv_job *job)
{
    vvi_job_hush(job, 1);
    const vv_status st = s->source.make(out, s->source.user, box, job);
    vvi_job_hush(job, -1);
    if (st == VV_OK)
        s->pool->made += (uint64_t)(box->n[0] * box->n[1] * box->n[2]);
    return st;
}

/* Under the lock. The oldest slab goes before the new one is made, so that no more than two are ever held. */
static vv_status make_slab(slab **out, const lazy *s, int64_t k, vv_job *job)
{
    slab *oldest = &s->pool->slabs[0];
    for (int i = 1; i < SLABS_KEPT; i++)
        if (s->pool->slabs[i].used < oldest->used)
            oldest = &s->pool->slabs[i];
    for (int i = 0; i < SLABS_KEPT; i++)
        if (s->pool->alone || &s->pool->slabs[i] == oldest)
            empty(&s->pool->slabs[i]);
    vv_status st;
    vv_box box;
    do {
        box = slab_box(s, k);
        st = make(&oldest->field, s, &box, job);
    } while (st == VV_E_LIMIT && shrink(s));
    if (st != VV_OK)
        return st;
    oldest->of = &s->head;
    oldest->box = box;
    *out = oldest;
    return VV_OK;
}

/* The slab that has slice k, to be released. */
static vv_status get_slab(vv_field **out, vv_box *box_out, const lazy *s, int64_t k, vv_job *job)
{
    vvi_lazy_pool *pool = s->pool;
    vv_status st = VV_OK;
    pthread_mutex_lock(&pool->lock);
    slab *found = find(pool, s, k);
    if (!found)
        st = make_slab(&found, s, k, job);
    if (st == VV_OK) {
        found->used = ++pool->clock;
        *box_out = found->box;
        *out = vv_field_retain(found->field);
    }
    pthread_mutex_unlock(&pool->lock);
    return st;
}

/* Of the box's slices from k on those that are in one slab, *n_out of them: its own samples. */
static vv_status brick_of_slab(vv_brick *out, int64_t *n_out, lazy *s, const vv_box *box, int64_t k, vv_job *job)
{
    vv_box covers, part = *box;
    vv_field *field;
    const vv_status st = get_slab(&field, &covers, s, k, job);
    if (st != VV_OK)
        return st;
    const int64_t left = box->lo[2] + box->n[2] - k, there = covers.lo[2] + covers.n[2] - k;
    *n_out = part.n[2] = left < there ? left : there;
    part.lo[2] = k - covers.lo[2];
    return vvi_field_lend(out, field, &part, &s->damaged, job);
}

/* Slices of the box from `first` on that are in one slab, to where they belong. */
static vv_status copy_part(char *to, int64_t *n_out, lazy *s, const vv_box *box, int64_t first, vv_job *job)
{
    vv_brick brick = {.box = *box, .type = s->info.type, .components = s->info.components};
    const vv_status st = brick_of_slab(&brick, n_out, s, box, first, job);
    if (st != VV_OK)
        return st;
    const size_t row = (size_t)box->n[0] * vv_type_bytes(s->info.type) * (size_t)s->info.components;
    for (int64_t k = 0; k < *n_out; k++)
        for (int64_t j = 0; j < box->n[1]; j++, to += row)
            memcpy(to, (const char *)brick.data + j * brick.stride[1] + k * brick.stride[2], row);
    vv_brick_release(&brick);
    return VV_OK;
}

/* Across slabs: gathered, one slab after the other. */
static vv_status brick_of_slabs(vv_brick *out, lazy *s, const vv_box *box, vv_job *job)
{
    vv_field_info info = s->info;
    vv_field *field = NULL;
    void *data;
    info.grid = vv_grid_crop(&s->info.grid, box);
    vv_status st = vv_field_new_empty(&field, &data, &info, job);
    const int64_t end = box->lo[2] + box->n[2];
    const size_t slice = (size_t)(box->n[0] * box->n[1]) * vv_type_bytes(info.type) * (size_t)info.components;
    for (int64_t k = box->lo[2], n = 0; k < end && st == VV_OK; k += n)
        st = copy_part((char *)data + (size_t)(k - box->lo[2]) * slice, &n, s, box, k, job);
    if (st == VV_OK)
        return vvi_field_lend(out, field, &(vv_box){{0, 0, 0}, {box->n[0], box->n[1], box->n[2]}}, NULL, job);
    vv_field_release(field);
    return st;
}

static bool is_in_a_slab(lazy *s, const vv_box *box)
{
    pthread_mutex_lock(&s->pool->lock);
    const slab *kept = find(s->pool, s, box->lo[2]);
    const vv_box covers = kept ? kept->box : slab_box(s, box->lo[2]);
    pthread_mutex_unlock(&s->pool->lock);
    return box->lo[2] + box->n[2] <= covers.lo[2] + covers.n[2];
}

/* Made for whoever asks, and not kept. */
static vv_status brick_of_box(vv_brick *out, lazy *s, const vv_box *box, vv_job *job)
{
    vv_field *field;
    pthread_mutex_lock(&s->pool->lock);
    const vv_status st = make(&field, s, box, job);
    pthread_mutex_unlock(&s->pool->lock);
    if (st != VV_OK)
        return st;
    return vvi_field_lend(out, field, &(vv_box){{0, 0, 0}, {box->n[0], box->n[1], box->n[2]}}, &s->damaged, job);
}

static bool is_small(const lazy *s, const vv_box *box)
{
    const int64_t *d = s->info.grid.dims;
    return s->source.boxes && (box->n[0] < d[0] || box->n[1] < d[1]);
}

static vv_status lazy_brick(vv_brick *out, const vvi_sample_store *store, const vv_box *box, vv_job *job)
{
    lazy *s = (lazy *)(uintptr_t)store; /* its pool and what it knows of damage are no part of what is immutable */
    const vv_brick asked = *out;
    int64_t n;
    if (is_small(s, box))
        return brick_of_box(out, s, box, job);
    if (!is_in_a_slab(s, box))
        return brick_of_slabs(out, s, box, job);
    const vv_status st = brick_of_slab(out, &n, s, box, box->lo[2], job);
    if (st != VV_OK || n == box->n[2])
        return st;
    vv_brick_release(out); /* it had to be a thinner one */
    *out = asked;
    return brick_of_slabs(out, s, box, job);
}

static vv_status lazy_prepare(vvi_sample_store *store, vv_job *job)
{
    const vvi_lazy_source *source = &((lazy *)store)->source;
    return source->prepare ? source->prepare(source->user, job) : VV_OK;
}

static bool lazy_damaged(const vvi_sample_store *store)
{
    return atomic_load(&((lazy *)(uintptr_t)store)->damaged);
}

static void lazy_drop(vvi_sample_store *store)
{
    lazy *s = (lazy *)store;
    vvi_lazy_pool *pool = s->pool;
    pthread_mutex_lock(&pool->lock);
    for (int i = 0; i < SLABS_KEPT; i++)
        if (pool->slabs[i].of == store)
            empty(&pool->slabs[i]);
    pthread_mutex_unlock(&pool->lock);
    if (s->source.drop)
        s->source.drop(s->source.user);
    vvi_free(s);
    vvi_lazy_pool_release(pool);
}

static const vvi_sample_store_class lazy_class = {
    .name = "lazy",
    .lazy = true,
    .brick = lazy_brick,
    .prepare = lazy_prepare,
    .damaged = lazy_damaged,
    .drop = lazy_drop,
};

vv_status vvi_field_lazy(vv_field **out, const vv_field_info *info, const vvi_lazy_source *source, vvi_lazy_pool *pool,
                         vv_job *job)
{
    *out = NULL;
    vv_status st = vv_field_info_check(info);
    lazy *s = st == VV_OK ? vvi_alloc(job, sizeof *s, VVI_MEM_MODEL) : NULL;
    if (!s) {
        if (st == VV_OK)
            st = vv_fail_memory(sizeof *s);
        if (source->drop)
            source->drop(source->user);
        return st;
    }
    *s = (lazy){
        .head = {.cls = &lazy_class, .refs = 1}, .info = *info, .source = *source, .pool = vvi_lazy_pool_retain(pool)};
    return vvi_field_on_samples(out, info, &s->head, job ? vv_job_runtime(job) : NULL, job);
}
