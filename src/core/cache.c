#include "core/cache.h"
#include "core/job.h"
#include "core/runtime.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

/* Listed entries (in a bucket) are found by their key; forgotten ones live until their last pin. Ready, listed entries
 * are also in the list by use. */
struct vvi_cached {
    vv_runtime *runtime; /* holds it; NULL: made without a job */
    vvi_cache_key key;
    void *value;
    void (*drop)(void *value);
    uint64_t bytes;
    int pins;
    bool ready, listed;
    pthread_t maker;
    vvi_cached *next;          /* in the bucket, or in a list of victims */
    vvi_cached *newer, *older; /* by use */
};

uint64_t vvi_hash(const void *data, size_t bytes, uint64_t seed)
{
    const unsigned char *u = data;
    uint64_t hash = UINT64_C(0xcbf29ce484222325) ^ seed;
    for (size_t i = 0; i < bytes; i++)
        hash = (hash ^ u[i]) * UINT64_C(0x100000001b3);
    return hash;
}

static vvi_cached **bucket_of(vvi_cache *cache, const vvi_cache_key *key)
{
    uint64_t hash = vvi_hash(key->what, strlen(key->what), key->identity);
    hash = vvi_hash(&key->parameters, sizeof key->parameters, hash);
    return &cache->buckets[(hash ^ hash >> 32) % VVI_CACHE_BUCKETS];
}

static bool same_key(const vvi_cache_key *a, const vvi_cache_key *b)
{
    return a->identity == b->identity && a->parameters == b->parameters && strcmp(a->what, b->what) == 0;
}

static vvi_cached *find(vvi_cache *cache, const vvi_cache_key *key)
{
    vvi_cached *entry = *bucket_of(cache, key);
    while (entry && !same_key(&entry->key, key))
        entry = entry->next;
    return entry;
}

/* The list by use ----------------------------------------------------------------------------------------------- */

static void link_newest(vvi_cache *cache, vvi_cached *entry)
{
    entry->newer = NULL;
    entry->older = cache->newest;
    if (cache->newest)
        cache->newest->newer = entry;
    else
        cache->oldest = entry;
    cache->newest = entry;
}

static void unlink_by_use(vvi_cache *cache, vvi_cached *entry)
{
    if (entry->newer)
        entry->newer->older = entry->older;
    else
        cache->newest = entry->older;
    if (entry->older)
        entry->older->newer = entry->newer;
    else
        cache->oldest = entry->newer;
}

/* Out of the table; whoever holds it may still use it. Under the lock. */
static void unlist(vvi_cache *cache, vvi_cached *entry)
{
    vvi_cached **at = bucket_of(cache, &entry->key);
    while (*at != entry)
        at = &(*at)->next;
    *at = entry->next;
    entry->listed = false;
    if (!entry->ready)
        return;
    unlink_by_use(cache, entry);
    cache->entries--;
    cache->bytes -= entry->bytes;
}

static void list(vvi_cache *cache, vvi_cached *entry)
{
    vvi_cached **bucket = bucket_of(cache, &entry->key);
    entry->next = *bucket;
    *bucket = entry;
    entry->listed = true;
}

/* Outside the lock: drop() may free memory, and with it fields, which call vvi_cache_forget(). */
static void destroy(vvi_cached *entry)
{
    vv_runtime *runtime = entry->runtime;
    if (entry->ready && entry->drop)
        entry->drop(entry->value);
    free(entry);
    if (runtime)
        vvi_runtime_unhold(runtime);
}

static uint64_t destroy_all(vvi_cached *victims)
{
    uint64_t bytes = 0;
    while (victims) {
        vvi_cached *next = victims->next;
        bytes += victims->bytes;
        destroy(victims);
        victims = next;
    }
    return bytes;
}

/* Getting ------------------------------------------------------------------------------------------------------- */

static vvi_cached *new_entry(vv_runtime *runtime, const vvi_cache_key *key, void (*drop)(void *value))
{
    vvi_cached *entry = vvi_calloc(1, sizeof *entry);
    if (!entry)
        return NULL;
    *entry = (vvi_cached){.runtime = runtime, .key = *key, .drop = drop, .pins = 1, .maker = pthread_self()};
    if (runtime)
        vvi_runtime_hold(runtime);
    return entry;
}

/* Waits until something has been made, but not so long that a cancel is missed. */
static vv_status wait_for_maker(vvi_cache *cache, const vvi_cached *entry, vv_job *job)
{
    if (pthread_equal(entry->maker, pthread_self()))
        return vv_fail(VV_E_INTERNAL, "the derived data '%s' asks for itself while it is being made", entry->key.what);
    struct timespec until;
    clock_gettime(CLOCK_MONOTONIC, &until);
    until.tv_nsec += 20000000;
    if (until.tv_nsec >= 1000000000) {
        until.tv_nsec -= 1000000000;
        until.tv_sec++;
    }
    pthread_cond_timedwait(&cache->made, &cache->lock, &until);
    return vvi_job_poll(job);
}

static vvi_cached *pin(vvi_cache *cache, vvi_cached *entry)
{
    entry->pins++;
    unlink_by_use(cache, entry);
    link_newest(cache, entry);
    cache->hits++;
    return entry;
}

/* Under the lock: a ready entry with one pin more, or a new one that the caller must make, so that others wait for it.
 */
static vv_status pin_or_reserve(vvi_cached **out, vv_runtime *runtime, const vvi_cache_key *key,
                                void (*drop)(void *value), vv_job *job)
{
    vvi_cache *cache = &runtime->cache;
    vvi_cached *entry;
    while ((entry = find(cache, key)) && !entry->ready) {
        const vv_status st = wait_for_maker(cache, entry, job);
        if (st != VV_OK)
            return st;
    }
    if (entry) {
        *out = pin(cache, entry);
        return VV_OK;
    }
    if (!(*out = new_entry(runtime, key, drop)))
        return vv_fail_memory(sizeof **out);
    list(cache, *out);
    cache->misses++;
    return VV_OK;
}

/* The maker is done: publishes a value, or takes away what failed. */
static void settle(vvi_cache *cache, vvi_cached *entry, vv_status st)
{
    pthread_mutex_lock(&cache->lock);
    if (st == VV_OK && entry->listed) {
        link_newest(cache, entry);
        cache->entries++;
        cache->bytes += entry->bytes;
    } else if (entry->listed) {
        unlist(cache, entry);
    }
    entry->ready = st == VV_OK;
    pthread_cond_broadcast(&cache->made);
    pthread_mutex_unlock(&cache->lock);
}

/* Makes the value of a reserved entry; on failure nothing is left of it. */
static vv_status fill(vvi_cached **entry, vvi_cache_make_fn *make, void *user, vv_job *job)
{
    vv_runtime *runtime = (*entry)->runtime; /* NOLINT(clang-analyzer-core.NullDereference): reserved is there */
    const vv_status st = make(&(*entry)->value, &(*entry)->bytes, user, job);
    if (runtime)
        settle(&runtime->cache, *entry, st);
    else
        (*entry)->ready = st == VV_OK;
    if (st != VV_OK) {
        destroy(*entry);
        *entry = NULL;
    }
    return st;
}

vv_status vvi_cache_get(vvi_cached **out, const vvi_cache_key *key, vvi_cache_make_fn *make, void (*drop)(void *value),
                        void *user, vv_job *job)
{
    vv_runtime *runtime = vv_job_runtime(job);
    *out = NULL;
    if (!runtime) {
        *out = new_entry(NULL, key, drop);
        return *out ? fill(out, make, user, job) : vv_fail_memory(sizeof **out);
    }
    pthread_mutex_lock(&runtime->cache.lock);
    const vv_status st = pin_or_reserve(out, runtime, key, drop, job);
    const bool found = *out && (*out)->ready;
    pthread_mutex_unlock(&runtime->cache.lock);
    return st != VV_OK || found ? st : fill(out, make, user, job);
}

void *vvi_cached_value(const vvi_cached *cached)
{
    return cached->value;
}

void vvi_cache_release(vvi_cached *cached)
{
    if (!cached)
        return;
    if (!cached->runtime) {
        destroy(cached);
        return;
    }
    vvi_cache *cache = &cached->runtime->cache;
    pthread_mutex_lock(&cache->lock);
    const bool last = --cached->pins == 0 && !cached->listed;
    pthread_mutex_unlock(&cache->lock);
    if (last)
        destroy(cached);
}

/* Dropping ------------------------------------------------------------------------------------------------------ */

/* Under the lock: unlists all entries of a field, or of all fields, and puts the unpinned ones on *victims. */
static void unlist_all(vvi_cache *cache, vvi_cached **victims, const uint64_t *identity)
{
    for (size_t b = 0; b < VVI_CACHE_BUCKETS; b++) {
        for (vvi_cached *entry = cache->buckets[b], *next; entry; entry = next) {
            next = entry->next;
            if (identity && entry->key.identity != *identity)
                continue;
            unlist(cache, entry);
            if (entry->pins > 0)
                continue;
            cache->drops++;
            entry->next = *victims;
            *victims = entry;
        }
    }
}

static void forget(vv_runtime *runtime, const uint64_t *identity)
{
    vvi_cached *victims = NULL;
    pthread_mutex_lock(&runtime->cache.lock);
    unlist_all(&runtime->cache, &victims, identity);
    pthread_mutex_unlock(&runtime->cache.lock);
    destroy_all(victims);
}

void vvi_cache_forget(vv_runtime *runtime, uint64_t identity)
{
    if (runtime)
        forget(runtime, &identity);
}

uint64_t vvi_cache_shed(vv_runtime *runtime, uint64_t bytes)
{
    vvi_cache *cache = &runtime->cache;
    vvi_cached *victims = NULL;
    uint64_t chosen = 0;
    pthread_mutex_lock(&cache->lock);
    for (vvi_cached *entry = cache->oldest, *newer; entry && chosen < bytes; entry = newer) {
        newer = entry->newer;
        if (entry->pins > 0)
            continue;
        unlist(cache, entry);
        cache->drops++;
        chosen += entry->bytes;
        entry->next = victims;
        victims = entry;
    }
    pthread_mutex_unlock(&cache->lock);
    return destroy_all(victims);
}

void vvi_cache_get_counts(vvi_cache_counts *out, vv_runtime *runtime)
{
    vvi_cache *cache = &runtime->cache;
    pthread_mutex_lock(&cache->lock);
    *out = (vvi_cache_counts){cache->hits, cache->misses, cache->drops, cache->entries, cache->bytes};
    pthread_mutex_unlock(&cache->lock);
}

/* Life ---------------------------------------------------------------------------------------------------------- */

vv_status vvi_cache_init(vvi_cache *cache)
{
    if (pthread_mutex_init(&cache->lock, NULL) != 0)
        return vv_fail_memory(sizeof cache->lock);
    pthread_condattr_t attributes;
    pthread_condattr_init(&attributes);
    pthread_condattr_setclock(&attributes, CLOCK_MONOTONIC); /* setting the date must not stretch a wait */
    pthread_cond_init(&cache->made, &attributes);
    pthread_condattr_destroy(&attributes);
    return VV_OK;
}

void vvi_cache_clear(vv_runtime *runtime)
{
    forget(runtime, NULL);
}

void vvi_cache_finish(vvi_cache *cache)
{
    pthread_cond_destroy(&cache->made);
    pthread_mutex_destroy(&cache->lock);
}
