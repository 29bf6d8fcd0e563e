/** @file
 * Derived data: made once, kept while the memory limit allows, dropped least recently used first.
 */
#ifndef VVI_CORE_CACHE_H
#define VVI_CORE_CACHE_H
#include <volvis/runtime.h>

/** Key: what it is, of which field (vv_field_identity), with which parameters (a hash of all that matters). */
typedef struct vvi_cache_key {
    const char *what; /**< a string literal: "minmax" */
    uint64_t identity;
    uint64_t parameters;
} vvi_cache_key;

/** Makes the value; *bytes_out is what it holds. */
typedef vv_status vvi_cache_make_fn(void **value_out, uint64_t *bytes_out, void *user, vv_job *job);

typedef struct vvi_cached vvi_cached; /* a pinned entry */

/** The value for a key, made if it is not there (one maker at a time for a key; others wait). Pinned until
 * vvi_cache_release(). With job NULL nothing is kept: the value lives until it is released. */
vv_status vvi_cache_get(vvi_cached **out, const vvi_cache_key *key, vvi_cache_make_fn *make, void (*drop)(void *value),
                        void *user, vv_job *job);
void *vvi_cached_value(const vvi_cached *cached);
void vvi_cache_release(vvi_cached *cached); /* NULL is fine */
/** Forget everything about a field that is going away; called by the field. Pinned values go with their last pin. */
void vvi_cache_forget(vv_runtime *runtime, uint64_t identity);
/** Drop unpinned entries until `bytes` are freed or none are left; what was freed. */
uint64_t vvi_cache_shed(vv_runtime *runtime, uint64_t bytes);
/** FNV-1a, to hash parameters. */
uint64_t vvi_hash(const void *data, size_t bytes, uint64_t seed);

/** Counters for tests and `-v`. */
typedef struct vvi_cache_counts {
    uint64_t hits, misses, drops, entries, bytes;
} vvi_cache_counts;
void vvi_cache_get_counts(vvi_cache_counts *out, vv_runtime *runtime);
#endif
