/** @file
 * What a runtime and a job are made of. For core alone; others use job.h, memory.h, cache.h and cpu.h.
 *
 * Life: `refs` counts users and jobs. When it falls to 0 the pool's threads end and the cache is emptied. `holds`
 * counts allocations and cache entries, and one more for all refs together; when it falls to 0 the struct itself goes.
 * So an allocation, wherever it has wandered, can always be given back to its runtime, and the cache, whose values hold
 * allocations of the same runtime, does not keep it alive.
 *
 * Locks: pool, cache, kept maps, log and a job's report are independent: none is taken while another is held, except
 * that a log or progress function may call the library. No function of others runs under the pool's or the cache's
 * lock.
 */
#ifndef VVI_CORE_RUNTIME_H
#define VVI_CORE_RUNTIME_H
#include "core/allowed_places.h"
#include "core/job.h"
#include "core/kept_maps.h"
#include "core/memory.h"
#include "core/pool.h"
#include <pthread.h>
#include <stdatomic.h>
#include <volvis/runtime.h>

struct vvi_cached;

/** All counters are atomic: an allocation takes no lock. used <= limit always. */
typedef struct vvi_account {
    uint64_t limit;
    _Atomic uint64_t used, peak, by_tag[VVI_MEM_TAGS];
} vvi_account;

enum { VVI_CACHE_BUCKETS = 256 };

/** All fields are under the lock. newest .. oldest: by last use, ready entries only. */
typedef struct vvi_cache {
    pthread_mutex_t lock;
    pthread_cond_t made; /**< a maker is done, well or badly */
    struct vvi_cached *buckets[VVI_CACHE_BUCKETS];
    struct vvi_cached *newest, *oldest;
    uint64_t hits, misses, drops, entries, bytes;
} vvi_cache;

typedef struct vvi_logger {
    pthread_mutex_t lock; /**< recursive: a log function may call the library */
    vv_log_fn *fn;
    void *user;
    vv_log_level level;
} vvi_logger;

struct vv_runtime {
    atomic_size_t refs, holds;
    int threads;
    uint32_t cpu; /**< VVI_CPU_* bits in use */
    const struct vv_registry *registry;
    struct vv_registry *joined; /**< that one, where it was made of two; else NULL */
    bool allow_outside;
    bool safe, contain;
    char *import_program; /**< NULL: the usual one */
    vv_limits limits;
    vvi_account account;
    vvi_kept_maps kept;  /**< not in the account */
    uint64_t keep_bytes; /**< how much of that there may be */
    vvi_pool pool;
    vvi_cache cache;
    vvi_logger log;
    vvi_places places;
};

/** The part under the lock is about the stage that was reported last. */
typedef struct vvi_file_identity {
    uint64_t device, number;
} vvi_file_identity;

/** Files that are opened already: -1 where there is none. */
typedef struct vvi_lent {
    char *path;       /**< of `file`, as it is asked for; NULL: nothing is lent */
    int file, folder; /**< folder: in which it lies */
    int spare[VVI_SPARES], n_spares;
} vvi_lent;

struct vv_job {
    vv_runtime *runtime; /**< NULL: this thread alone */
    vv_progress_fn *progress;
    void *user;
    atomic_bool cancelled; /**< lock-free, so that a signal handler may set it */
    atomic_bool damaged;
    bool urgent, modest;
    bool keeps_fills;         /**< vvi_job_keep_fills() */
    bool keeps_existing;      /**< vvi_job_keep_existing() */
    bool has_overwrite;       /**< vvi_job_has_overwrite() */
    _Atomic uint64_t told[8]; /**< what was said of damage, hashed: each at its remainder */
    _Atomic uint64_t cleared; /**< the folder that was cleared of temporary files last, hashed */
    atomic_int hushed;
    _Atomic(void *) room; /**< for samples, of room_bytes; NULL: none is lent */
    size_t room_bytes;
    vvi_lent lent;
    pthread_mutex_t lock;
    vvi_file_identity *read; /**< files that were opened to be read; under the lock */
    size_t n_read, room_read;
    void (*on_read)(void *user, const char *path); /**< vvi_read_listener; called under the lock */
    void *on_read_user;
    vv_status (*on_write)(void *user, uint64_t bytes); /**< vvi_write_counter; NULL: nobody counts */
    void *on_write_user;
    vv_log_fn *on_warning; /**< vvi_job_listen_warnings(); called under the lock */
    void *on_warning_user;
    vv_finding *findings; /**< n_findings; of the thread that runs the job's work */
    size_t n_findings;
    const char *stage;
    double stage_start_s, next_report_s;
    uint64_t done;
};

/** The tables of `base` with the rows of `more` behind theirs, of which any table may be NULL; free() gives it back.
 * VV_E_ARGUMENT (a name that is there), VV_E_UNSUPPORTED (a row for another version of its table), VV_E_MEMORY. */
vv_status vvi_registry_join(struct vv_registry **out, const struct vv_registry *base, const struct vv_registry *more);

void vvi_runtime_hold(vv_runtime *runtime);
void vvi_runtime_unhold(vv_runtime *runtime);

vv_status vvi_cache_init(vvi_cache *cache);
void vvi_cache_clear(vv_runtime *runtime); /* forgets everything; pinned values go with their last pin */
void vvi_cache_finish(vvi_cache *cache);

/** Warnings and errors of this job are told to fn too, from any thread, one call at a time, whatever the runtime's log
 * is. Set it while no work runs; it logs nothing itself. */
void vvi_job_listen_warnings(vv_job *job, vv_log_fn *fn, void *user);

/** What is reported from now on is about a new stage, even if it has the same name. NULL: nothing changes. */
void vvi_job_begin_stage(vv_job *job, const char *stage);
/** Tells how far `stage` is when it is time to; `done` is read late so that it never falls. */
void vvi_job_report(vv_job *job, const char *stage, const _Atomic uint64_t *done, uint64_t total);
#endif
