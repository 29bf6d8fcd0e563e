/* Bricks on demand. One thread brings at a time; pages are published when their samples are there. */
#include "grid/bricks.h"
#include "core/job.h"
#include "core/memory.h"
#include <pthread.h>
#include <string.h>
#include <sys/mman.h>

enum { GUARD = 64, SHARED = 16, MOST_BRICKS = 1 << 29 /* their pages are gathered by bytes */ };

typedef struct store {
    vvi_bricks head;
    vvi_brick_source source;
    int64_t dims[3];
    size_t sample_bytes, samples, bytes; /* of one brick */
    size_t n_bricks, room, used;         /* places; the first is for samples of 0 */
    size_t reserved;                     /* bytes at head.data, of which those of used places are counted */
    vv_runtime *counted_in;
    int32_t shared[SHARED]; /* pages of bricks in which all samples are the same */
    size_t n_shared;
    pthread_mutex_t lock;    /* of all above but pages */
    pthread_rwlock_t inside; /* who may read pages: many, or one that drops them */
} store;

/* What a thread is about between enter and leave. */
static _Thread_local struct {
    vv_job *job;
    vv_status status;
    bool lacking;
} visit;

static store *store_of(const vvi_bricks *bricks)
{
    return (store *)(uintptr_t)bricks; /* what is there is no part of what the samples are */
}

static size_t least(size_t a, size_t b)
{
    return a < b ? a : b;
}

static void find_sizes(store *s, const int64_t dims[3], size_t sample_bytes)
{
    s->samples = s->n_bricks = 1;
    s->sample_bytes = sample_bytes;
    for (int a = 0; a < 3; a++) {
        const int64_t cells = dims[a] < VVI_BRICK_CELLS ? dims[a] : VVI_BRICK_CELLS;
        s->dims[a] = dims[a];
        s->head.n[a] = (int32_t)((dims[a] - 1) / VVI_BRICK_CELLS + 1);
        s->head.side[a] = (int32_t)cells + VVI_BRICK_BEFORE + VVI_BRICK_BEHIND;
        s->samples *= (size_t)s->head.side[a];
        s->n_bricks *= (size_t)s->head.n[a];
    }
    s->bytes = s->samples * sample_bytes;
    s->room = least(s->n_bricks + 1, INT32_MAX / s->samples); /* pages are numbers of 32 bits */
    s->reserved = s->room * s->bytes + GUARD;
}

/* No page is left, and the place of zeros is the only one. */
static void forget_all(store *s)
{
    for (size_t i = 0; i < s->n_bricks; i++)
        __atomic_store_n(&s->head.page[i], -1, __ATOMIC_RELAXED);
    s->used = 1;
    s->n_shared = 0;
}

static void drop_all(store *s)
{
    if (s->used > 1)
        madvise(s->head.data, s->reserved, MADV_DONTNEED); /* they are zeros then */
    for (size_t i = 1; i < s->used; i++)
        vvi_memory_give_back(s->counted_in, s->bytes, VVI_MEM_DERIVED);
    forget_all(s);
}

vv_status vvi_bricks_new(vvi_bricks **out, const int64_t dims[3], size_t sample_bytes, const vvi_brick_source *source,
                         vv_job *job)
{
    pthread_rwlockattr_t fair;
    *out = NULL;
    store *s = vvi_alloc_zeroed(job, sizeof *s, VVI_MEM_DERIVED);
    if (!s) {
        source->drop(source->user);
        return vv_fail_memory(sizeof *s);
    }
    s->source = *source;
    find_sizes(s, dims, sample_bytes);
    if (s->n_bricks > MOST_BRICKS) {
        source->drop(source->user);
        vvi_free(s);
        return vv_fail(VV_E_UNSUPPORTED,
                       "%lld x %lld x %lld samples are more than bricks are numbered for; crop or resample",
                       (long long)dims[0], (long long)dims[1], (long long)dims[2]);
    }
    pthread_mutex_init(&s->lock, NULL);
    pthread_rwlockattr_init(&fair); /* who waits to be alone is not passed by others for ever */
    pthread_rwlockattr_setkind_np(&fair, PTHREAD_RWLOCK_PREFER_WRITER_NONRECURSIVE_NP);
    pthread_rwlock_init(&s->inside, &fair);
    pthread_rwlockattr_destroy(&fair);
    s->head.page = vvi_alloc(job, s->n_bricks * sizeof *s->head.page, VVI_MEM_DERIVED);
    void *data = MAP_FAILED;
    if (s->head.page && !vvi_alloc_fails()) /* address space, and no memory yet */
        data = mmap(NULL, s->reserved, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    if (data == MAP_FAILED) {
        const size_t bytes = s->head.page ? s->reserved : s->n_bricks * sizeof *s->head.page;
        vvi_bricks_free(s);
        return vv_fail_memory(bytes);
    }
    s->head.data = data;
    forget_all(s);
    *out = &s->head;
    return VV_OK;
}

void vvi_bricks_free(void *bricks)
{
    store *s = bricks;
    if (!s)
        return;
    if (s->head.data) {
        drop_all(s);
        munmap(s->head.data, s->reserved);
    }
    vvi_free(s->head.page);
    pthread_rwlock_destroy(&s->inside);
    pthread_mutex_destroy(&s->lock);
    s->source.drop(s->source.user);
    vvi_free(s);
}

void vvi_bricks_enter(vvi_bricks *const *stores, size_t n, bool alone, vv_job *job)
{
    visit.job = job;
    visit.status = VV_OK;
    visit.lacking = false;
    for (size_t i = 0; i < n; i++) {
        store *s = store_of(stores[i]);
        if (!alone) {
            pthread_rwlock_rdlock(&s->inside);
            continue;
        }
        pthread_rwlock_wrlock(&s->inside);
        drop_all(s);
    }
}

vv_status vvi_bricks_leave(bool *lacking_out, vvi_bricks *const *stores, size_t n)
{
    for (size_t i = 0; i < n; i++)
        pthread_rwlock_unlock(&store_of(stores[i])->inside);
    *lacking_out = visit.lacking;
    visit.job = NULL;
    return visit.status;
}

/* Bringing --------------------------------------------------------------------------------------------------------- */

/* The samples of a brick that are in the grid, and where the first of them is from the brick's place on. */
static size_t find_box(vv_box *out, const store *s, int32_t brick)
{
    const int32_t *n = s->head.n, *side = s->head.side;
    const int32_t at[3] = {brick % n[0], brick / n[0] % n[1], brick / n[0] / n[1]};
    size_t pitch = s->sample_bytes, offset = 0;
    for (int a = 0; a < 3; a++) {
        const int64_t first = (int64_t)at[a] * VVI_BRICK_CELLS - VVI_BRICK_BEFORE;
        const int64_t end = first + side[a] < s->dims[a] ? first + side[a] : s->dims[a];
        out->lo[a] = first < 0 ? 0 : first;
        out->n[a] = end - out->lo[a];
        offset += (size_t)(out->lo[a] - first) * pitch;
        pitch *= (size_t)side[a];
    }
    return offset;
}

/* Of the samples in the grid; then those beyond it, which nobody looks at, become the same. */
static bool is_one_value(const store *s, char *data, size_t offset, const vv_box *box)
{
    const size_t row = (size_t)s->head.side[0] * s->sample_bytes, slice = row * (size_t)s->head.side[1];
    const char *first = data + offset;
    for (int64_t k = 0; k < box->n[2]; k++)
        for (int64_t j = 0; j < box->n[1]; j++) {
            const char *p = first + (size_t)k * slice + (size_t)j * row;
            if (memcmp(p, first, s->sample_bytes) != 0 ||
                memcmp(p, p + s->sample_bytes, (size_t)(box->n[0] - 1) * s->sample_bytes) != 0)
                return false;
        }
    char value[8];
    memcpy(value, first, s->sample_bytes);
    for (size_t i = 0; i < s->samples; i++)
        memcpy(data + i * s->sample_bytes, value, s->sample_bytes);
    return true;
}

/* The page that a brick of one value has already; else its own is theirs from now on. */
static int32_t share(store *s, const char *data, int32_t page)
{
    for (size_t i = 0; i < s->n_shared; i++)
        if (memcmp(s->head.data + (size_t)s->shared[i] * s->sample_bytes, data, s->sample_bytes) == 0)
            return s->shared[i];
    if (s->n_shared < SHARED)
        s->shared[s->n_shared++] = page;
    return page;
}

/* One more place: three quarters of the limit at most, since bringing takes room too. */
static bool take_place(store *s)
{
    const vv_runtime *runtime = vv_job_runtime(visit.job);
    vv_runtime *counted_in;
    if (s->used == s->room || (runtime && s->used * s->bytes > vv_runtime_memory_limit(runtime) / 4 * 3) ||
        vvi_memory_take(&counted_in, visit.job, s->bytes, VVI_MEM_DERIVED) != VV_OK)
        return false;
    s->counted_in = counted_in;
    return true;
}

/* Under the lock. */
static int32_t bring(store *s, int32_t brick)
{
    if (!take_place(s)) {
        visit.lacking = true;
        return 0;
    }
    int32_t page = (int32_t)(s->used * s->samples);
    char *data = s->head.data + s->used * s->bytes;
    const size_t row = (size_t)s->head.side[0] * s->sample_bytes, slice = row * (size_t)s->head.side[1];
    vv_box box;
    const size_t offset = find_box(&box, s, brick);
    const vv_status st = s->source.fill(data + offset, row, slice, s->source.user, &box, visit.job);
    if (st == VV_OK && is_one_value(s, data, offset, &box))
        page = share(s, data, page);
    if (st == VV_OK && (size_t)page == s->used * s->samples) {
        s->used++;
    } else {
        memset(data, 0, s->bytes);
        vvi_memory_give_back(s->counted_in, s->bytes, VVI_MEM_DERIVED);
    }
    if (st != VV_OK) {
        visit.lacking = st == VV_E_LIMIT;
        visit.status = visit.lacking ? VV_OK : st;
        return 0;
    }
    __atomic_store_n(&s->head.page[brick], page, __ATOMIC_RELEASE);
    return page;
}

int32_t vvi_bricks_bring(const vvi_bricks *bricks, int32_t brick)
{
    store *s = store_of(bricks);
    if (visit.status != VV_OK || visit.lacking)
        return 0; /* all is void */
    pthread_mutex_lock(&s->lock);
    int32_t page = __atomic_load_n(&s->head.page[brick], __ATOMIC_RELAXED);
    if (page < 0)
        page = bring(s, brick);
    pthread_mutex_unlock(&s->lock);
    return page;
}

void vvi_bricks_count(size_t *there_out, size_t *places_out, const vvi_bricks *bricks)
{
    store *s = store_of(bricks);
    pthread_mutex_lock(&s->lock);
    *there_out = 0;
    for (size_t i = 0; i < s->n_bricks; i++)
        *there_out += s->head.page[i] >= 0;
    *places_out = s->used - 1;
    pthread_mutex_unlock(&s->lock);
}
