/* Parallel loops: a pool of threads that help with whichever loops are running. */
#include "core/job.h"
#include "core/runtime.h"

#include <signal.h>
#include <stdlib.h>

/* One running loop; lives on the stack of the thread that called vvi_parallel_for(). */
typedef struct vvi_loop {
    const vvi_work *work;
    void *shared;
    vv_job *job;
    size_t n_items;
    atomic_size_t next; /* the first item that nobody has taken */
    atomic_bool stop;   /* something failed: take no more */
    _Atomic uint64_t done;

    pthread_mutex_t lock; /* of the two below */
    size_t failed_item;   /* n_items: none */
    vvi_error_copy error;

    /* under the pool's lock */
    int helpers_joined, helpers_inside;
    struct vvi_loop *below;
} vvi_loop;

/* Loops that this thread is inside of: a loop in a loop runs on its worker alone. */
static _Thread_local int depth;

/* The lowest item wins. Items are taken in order, so every item below a failing one is finished too: which failure is
 * reported does not depend on the threads. */
static void record_failure(vvi_loop *loop, size_t item)
{
    pthread_mutex_lock(&loop->lock);
    if (loop->error.status == VV_OK || item < loop->failed_item) {
        vvi_error_copy_free(&loop->error);
        vvi_error_take(&loop->error);
        loop->failed_item = item;
    }
    pthread_mutex_unlock(&loop->lock);
    atomic_store(&loop->stop, true);
}

static bool take_item(vvi_loop *loop, size_t *item_out)
{
    if (atomic_load(&loop->stop) || vv_job_cancelled(loop->job))
        return false;
    *item_out = atomic_fetch_add(&loop->next, 1);
    return *item_out < loop->n_items;
}

static void do_items(vvi_loop *loop, void *scratch)
{
    size_t item;
    while (take_item(loop, &item)) {
        if (loop->work->item(scratch, loop->shared, item) != VV_OK) {
            record_failure(loop, item);
            return;
        }
        atomic_fetch_add(&loop->done, 1);
        if (depth <= 1)
            vvi_job_report(loop->job, loop->work->stage, &loop->done, loop->n_items);
    }
}

static void take_part(vvi_loop *loop, int worker)
{
    const vvi_work *work = loop->work;
    void *scratch = NULL;
    depth++;
    if (work->start && work->start(&scratch, loop->shared, worker) != VV_OK) {
        record_failure(loop, loop->n_items);
    } else {
        do_items(loop, scratch);
        if (work->finish)
            work->finish(scratch, loop->shared);
    }
    depth--;
}

/* The pool ------------------------------------------------------------------------------------------------------ */

/* The loop with the fewest helpers among those that have work left; NULL: none. */
static vvi_loop *neediest_loop(const vvi_pool *pool)
{
    vvi_loop *best = NULL;
    for (vvi_loop *l = pool->loops; l; l = l->below) {
        const bool wants = !atomic_load(&l->stop) && atomic_load(&l->next) < l->n_items;
        if (wants && (!best || l->helpers_inside < best->helpers_inside))
            best = l;
    }
    return best;
}

static void help(vvi_pool *pool, vvi_loop *loop)
{
    const int worker = ++loop->helpers_joined;
    loop->helpers_inside++;
    pthread_mutex_unlock(&pool->lock);
    take_part(loop, worker);
    pthread_mutex_lock(&pool->lock);
    loop->helpers_inside--;
    pthread_cond_broadcast(&pool->left);
}

static void *run_thread(void *user)
{
    vvi_pool *pool = user;
    pthread_mutex_lock(&pool->lock);
    while (!pool->stopping) {
        vvi_loop *loop = neediest_loop(pool);
        if (loop)
            help(pool, loop);
        else
            pthread_cond_wait(&pool->work, &pool->lock);
    }
    pthread_mutex_unlock(&pool->lock);
    return NULL;
}

/* Under the lock, once. Where the system gives fewer threads, or none, the loops run on fewer. */
static void start_threads(vvi_pool *pool, int n)
{
    sigset_t all, before;
    pool->started = true;
    pool->threads = vvi_calloc((size_t)n, sizeof *pool->threads);
    if (!pool->threads)
        return;
    sigfillset(&all); /* signals are for the threads of the program */
    pthread_sigmask(SIG_SETMASK, &all, &before);
    while (pool->n_threads < n && pthread_create(&pool->threads[pool->n_threads], NULL, run_thread, pool) == 0)
        pool->n_threads++;
    pthread_sigmask(SIG_SETMASK, &before, NULL);
}

vv_status vvi_pool_init(vvi_pool *pool)
{
    if (pthread_mutex_init(&pool->lock, NULL) != 0)
        return vv_fail_memory(sizeof pool->lock);
    pthread_cond_init(&pool->work, NULL);
    pthread_cond_init(&pool->left, NULL);
    return VV_OK;
}

void vvi_pool_finish(vvi_pool *pool)
{
    pthread_mutex_lock(&pool->lock);
    pool->stopping = true;
    pthread_cond_broadcast(&pool->work);
    pthread_mutex_unlock(&pool->lock);
    for (int i = 0; i < pool->n_threads; i++)
        pthread_join(pool->threads[i], NULL);
    free(pool->threads);
    pthread_cond_destroy(&pool->left);
    pthread_cond_destroy(&pool->work);
    pthread_mutex_destroy(&pool->lock);
}

static void offer(vvi_pool *pool, vvi_loop *loop, int threads)
{
    pthread_mutex_lock(&pool->lock);
    if (!pool->started)
        start_threads(pool, threads - 1);
    loop->below = pool->loops;
    pool->loops = loop;
    pthread_cond_broadcast(&pool->work);
    pthread_mutex_unlock(&pool->lock);
}

/* After this nobody knows the loop but its caller. */
static void withdraw(vvi_pool *pool, vvi_loop *loop)
{
    pthread_mutex_lock(&pool->lock);
    vvi_loop **at = &pool->loops;
    while (*at != loop)
        at = &(*at)->below;
    *at = loop->below;
    while (loop->helpers_inside > 0)
        pthread_cond_wait(&pool->left, &pool->lock);
    pthread_mutex_unlock(&pool->lock);
}

/* The loop ------------------------------------------------------------------------------------------------------ */

static void run(vvi_loop *loop)
{
    vv_runtime *runtime = vv_job_runtime(loop->job);
    const bool alone = !runtime || runtime->threads == 1 || loop->n_items == 1 || depth > 0;
    if (!alone)
        offer(&runtime->pool, loop, runtime->threads);
    take_part(loop, 0);
    if (!alone)
        withdraw(&runtime->pool, loop);
}

vv_status vvi_parallel_for(vv_job *job, const vvi_work *work, void *shared, size_t n_items)
{
    if (n_items == 0)
        return vvi_job_poll(job);
    vvi_loop loop = {.work = work, .shared = shared, .job = job, .n_items = n_items, .failed_item = n_items};
    if (pthread_mutex_init(&loop.lock, NULL) != 0)
        return vv_fail_memory(sizeof loop.lock);
    run(&loop);
    pthread_mutex_destroy(&loop.lock);
    if (loop.error.status != VV_OK)
        return vvi_error_put(&loop.error);
    if (atomic_load(&loop.done) < n_items)
        return vvi_job_poll(job);
    return VV_OK;
}
