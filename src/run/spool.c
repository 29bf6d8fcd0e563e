#include "run/spool.h"
#include "core/job.h"
#include "core/memory.h"
#include "grid/store.h"
#include "io/scratch_file.h"
#include <pthread.h>
#include <string.h>

struct vvi_spool {
    _Atomic uint32_t refs;
    pthread_mutex_t lock; /* of what follows */
    vvi_scratch_file *file;
    uint64_t n_bytes; /* of the file */
    uint64_t key;     /* whose samples it holds */
    bool filled;
    _Atomic uint64_t read;
};

typedef struct spooled {
    vvi_sample_store head;
    vv_field_info info;
    vvi_spool *spool;
    vvi_spool_of of;
} spooled;

vv_status vvi_spool_new(vvi_spool **out, vv_job *job)
{
    vvi_spool *spool = vvi_alloc_zeroed(job, sizeof *spool, VVI_MEM_MODEL);
    *out = NULL;
    if (!spool || pthread_mutex_init(&spool->lock, NULL) != 0) {
        vvi_free(spool);
        return vv_fail_memory(sizeof *spool);
    }
    spool->refs = 1;
    *out = spool;
    return VV_OK;
}

vvi_spool *vvi_spool_retain(vvi_spool *spool)
{
    atomic_fetch_add_explicit(&spool->refs, 1, memory_order_relaxed);
    return spool;
}

void vvi_spool_release(vvi_spool *spool)
{
    if (!spool || atomic_fetch_sub_explicit(&spool->refs, 1, memory_order_acq_rel) != 1)
        return;
    vvi_scratch_file_free(spool->file);
    pthread_mutex_destroy(&spool->lock);
    vvi_free(spool);
}

vv_status vvi_spool_reserve(vvi_spool *spool, uint64_t bytes, const char *name, vv_job *job)
{
    vv_status st = VV_OK;
    pthread_mutex_lock(&spool->lock);
    if (!spool->file || spool->n_bytes < bytes) {
        vvi_scratch_file_free(spool->file);
        spool->filled = false;
        spool->n_bytes = bytes;
        st = vvi_scratch_file_new(&spool->file, bytes, name, job);
    }
    pthread_mutex_unlock(&spool->lock);
    return st;
}

uint64_t vvi_spool_read(const vvi_spool *spool)
{
    return atomic_load(&spool->read);
}

/* Filling ---------------------------------------------------------------------------------------------------------- */

static uint64_t row_bytes(const spooled *s)
{
    return (uint64_t)s->info.grid.dims[0] * vv_type_bytes(s->info.type) * (uint64_t)s->info.components;
}

static bool is_filled(const spooled *s)
{
    return s->spool->filled && s->spool->key == s->of.key;
}

static vv_status put_slice(const spooled *s, int64_t k, vv_job *job)
{
    const int64_t *n = s->info.grid.dims;
    const vv_box slice = {{0, 0, k}, {n[0], n[1], 1}};
    const uint64_t row = row_bytes(s), at = (uint64_t)(k * n[1]) * row;
    vv_brick brick;
    vv_status st = vv_field_brick(&brick, s->of.field, &slice, job);
    if (st != VV_OK)
        return st;
    const bool dense = n[1] == 1 || (uint64_t)brick.stride[1] == row;
    const int64_t rows = dense ? n[1] : 1;
    for (int64_t j = 0; j < n[1] && st == VV_OK && !s->of.rehearses; j += rows)
        st =
            vvi_scratch_file_write(s->spool->file, at + (uint64_t)j * row,
                                   (const char *)brick.data + j * brick.stride[1], (size_t)((uint64_t)rows * row), job);
    vv_brick_release(&brick);
    return st;
}

/* Under the lock, once all that the field is made of is there. */
static vv_status fill(const spooled *s, vv_job *job)
{
    const int64_t n = s->info.grid.dims[2], last = s->of.rehearses ? 1 : n;
    vv_status st = VV_OK;
    s->spool->filled = false;
    for (int64_t k = 0; k < last && st == VV_OK; k++)
        if ((st = put_slice(s, k, job)) == VV_OK)
            st = vvi_job_progress(job, s->of.name, (uint64_t)(k + 1), (uint64_t)n);
    vvi_lazy_pool_empty(s->of.pool);
    if (st == VV_OK)
        st = vv_field_health(s->of.field);
    s->spool->filled = st == VV_OK;
    s->spool->key = s->of.key;
    return st;
}

/* Files that take turns in a chain are locked in its order, the later one last. */
static vv_status prepare(vvi_sample_store *store, vv_job *job)
{
    const spooled *s = (const spooled *)store;
    const uint64_t bytes = row_bytes(s) * (uint64_t)(s->info.grid.dims[1] * s->info.grid.dims[2]);
    pthread_mutex_lock(&s->spool->lock);
    const bool filled = is_filled(s);
    pthread_mutex_unlock(&s->spool->lock);
    vv_status st = filled ? VV_OK : vvi_field_prepare(s->of.field, job);
    if (st == VV_OK && !s->of.rehearses)
        st = vvi_spool_reserve(s->spool, bytes, s->of.name, job);
    if (filled || st != VV_OK)
        return st;
    pthread_mutex_lock(&s->spool->lock);
    if (!is_filled(s))
        st = fill(s, job);
    pthread_mutex_unlock(&s->spool->lock);
    return st;
}

/* Reading ---------------------------------------------------------------------------------------------------------- */

/* Rows that lie behind each other in the file as well as in the box are read at once. */
static vv_status get_box(char *to, const spooled *s, const vv_box *box, vv_job *job)
{
    const int64_t *n = s->info.grid.dims, *b = box->n;
    const uint64_t each = vv_type_bytes(s->info.type) * (uint64_t)s->info.components;
    const bool rows = b[0] == n[0], slices = rows && b[1] == n[1];
    const int64_t at_once[2] = {rows ? b[1] : 1, slices ? b[2] : 1};
    const size_t bytes = (size_t)((uint64_t)(b[0] * at_once[0] * at_once[1]) * each);
    vv_status st = VV_OK;
    for (int64_t k = 0; k < b[2]; k += at_once[1])
        for (int64_t j = 0; j < b[1] && st == VV_OK; j += at_once[0], to += bytes) {
            const int64_t first = ((box->lo[2] + k) * n[1] + box->lo[1] + j) * n[0] + box->lo[0];
            st = vvi_scratch_file_read(s->spool->file, (uint64_t)first * each, to, bytes, job);
            atomic_fetch_add(&s->spool->read, bytes);
        }
    return st;
}

static vv_status get_filled(char *to, const spooled *s, const vv_box *box, vv_job *job)
{
    vv_status st = VV_OK;
    pthread_mutex_lock(&s->spool->lock);
    if (!is_filled(s))
        st = fill(s, job);
    if (st == VV_OK && !s->of.rehearses)
        st = get_box(to, s, box, job);
    pthread_mutex_unlock(&s->spool->lock);
    return st;
}

static vv_status spooled_brick(vv_brick *out, const vvi_sample_store *store, const vv_box *box, vv_job *job)
{
    const spooled *s = (const spooled *)store;
    vv_field_info info = s->info;
    vv_field *field = NULL;
    void *data;
    info.grid = vv_grid_crop(&info.grid, box);
    vv_status st = prepare((vvi_sample_store *)(uintptr_t)store, job);
    if (st == VV_OK && (st = vv_field_new_empty(&field, &data, &info, job)) == VV_OK &&
        (st = get_filled(data, s, box, job)) == VV_OK)
        return vvi_field_lend(out, field, &(vv_box){{0, 0, 0}, {box->n[0], box->n[1], box->n[2]}}, NULL, job);
    vv_field_release(field);
    return st;
}

/* The field ------------------------------------------------------------------------------------------------------- */

static bool damaged(const vvi_sample_store *store)
{
    return vvi_field_is_damaged(((const spooled *)store)->of.field);
}

static void drop(vvi_sample_store *store)
{
    spooled *s = (spooled *)store;
    vv_field_release(s->of.field);
    vvi_lazy_pool_release(s->of.pool);
    vvi_spool_release(s->spool);
    vvi_free(s);
}

static const vvi_sample_store_class spooled_class = {
    .name = "spooled",
    .lazy = true,
    .brick = spooled_brick,
    .prepare = prepare,
    .damaged = damaged,
    .drop = drop,
};

vv_status vvi_spool_field(vv_field **out, vvi_spool *spool, const vvi_spool_of *of, vv_job *job)
{
    spooled *s = vvi_alloc(job, sizeof *s, VVI_MEM_MODEL);
    *out = NULL;
    if (!s)
        return vv_fail_memory(sizeof *s);
    *s = (spooled){.head = {.cls = &spooled_class, .refs = 1},
                   .info = *vv_field_get_info(of->field),
                   .spool = vvi_spool_retain(spool),
                   .of = *of};
    s->of.field = vv_field_retain(of->field);
    s->of.pool = vvi_lazy_pool_retain(of->pool);
    return vvi_field_on_samples(out, &s->info, &s->head, job ? vv_job_runtime(job) : NULL, job);
}
