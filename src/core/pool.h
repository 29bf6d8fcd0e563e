/** @file
 * Threads that help with work which others have begun. What the work is, the pool does not know.
 */
#ifndef VVI_CORE_POOL_H
#define VVI_CORE_POOL_H
#include <pthread.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <volvis/status.h>

/** A call for help, on the stack of the thread whose work it is. The two functions are set by the caller. */
typedef struct vvi_call {
    bool (*wanted)(struct vvi_call *call);           /**< is there something left to do? Under the pool's lock: quick */
    void (*help)(struct vvi_call *call, int worker); /**< does some of it; worker is the thread's number: 1, 2, ... */
    bool urgent;                                     /**< helped before all that is not */
    bool modest;                                     /**< helped when nothing urgent has been under way for a while */
    int inside;                                      /**< helpers that are here; under the pool's lock */
    struct vvi_call *below;
} vvi_call;

/** All fields are under the lock. */
typedef struct vvi_pool {
    pthread_mutex_t lock;
    pthread_cond_t work, left; /**< help is wanted, or it is time to stop; a helper has left a call */
    pthread_t *threads;
    int n_threads, n_numbered;
    bool stopping;
    vvi_call *calls;
    atomic_int n_urgent; /**< of the calls; without the lock, so that it costs nothing where there are none */
    _Atomic int64_t
        calm_at; /**< nanoseconds of the monotonic clock: from when on nothing urgent will have been of late */
} vvi_pool;

vv_status vvi_pool_init(vvi_pool *pool);
/** Ends the threads; nobody may be inside a call. */
void vvi_pool_finish(vvi_pool *pool);

/** Calls n_useful of the pool's threads to help. The first call starts them: n_threads, the same in each call. Each
 * thread comes at most once if wanted() stays false once help() has returned; one that left for an urgent call comes
 * again. Where the system gives fewer threads
 * fewer come, so the caller does the work too. */
void vvi_pool_offer(vvi_pool *pool, vvi_call *call, int n_threads, size_t n_useful);
/** Whether an urgent call has something left to do: time for helpers of others to leave. */
bool vvi_pool_is_pressed(vvi_pool *pool);
/** Something urgent is under way, with or without calls for help. */
void vvi_pool_note_urgent(vvi_pool *pool);
/** Whether nothing urgent has been under way for a tenth of a second: frames that follow one another leave gaps, in
 * which work that can wait must not begin. */
bool vvi_pool_is_calm(const vvi_pool *pool);
/** Waits until all helpers have left; after this the pool does not know the call. */
void vvi_pool_withdraw(vvi_pool *pool, vvi_call *call);
#endif
