#include "core/job.h"
#include "core/os.h"
#include "core/runtime.h"

#include <fenv.h>
#include <math.h>
#include <time.h>

/* One running loop; lives on the stack of the thread that called vvi_parallel_for(). */
typedef struct loop {
    vvi_call call; /* first: the pool knows no more of it */
    const vvi_work *work;
    void *shared;
    vv_job *job;
    bool yields; /* to urgent loops, between two items */
    size_t n_items;
    atomic_size_t next;    /* the first item that nobody has taken */
    atomic_bool stop;      /* something failed: take no more */
    atomic_bool crowded;   /* the limit had no room for another thread */
    _Atomic uint64_t done; /* with those of the stage's loops before */

    pthread_mutex_t lock; /* of the two below */
    size_t failed_item;   /* n_items: a start function */
    vvi_error_copy error;
} loop;

/* Loops of more than one item that this thread is inside of: a loop in one of them runs on its worker alone. */
static _Thread_local int depth;

/* The lowest item wins. Items are taken in order, so every item below a failing one is finished too: which failure is
 * reported does not depend on the threads. */
static void record_failure(loop *l, size_t item)
{
    pthread_mutex_lock(&l->lock);
    if (l->error.status == VV_OK || item < l->failed_item) {
        vvi_error_copy_free(&l->error);
        vvi_error_take(&l->error);
        l->failed_item = item;
    }
    pthread_mutex_unlock(&l->lock);
    atomic_store(&l->stop, true);
}

static bool has_ended(const loop *l)
{
    return atomic_load_explicit(&l->stop, memory_order_relaxed) || vv_job_cancelled(l->job);
}

enum { WAITS = 3, MODEST_WAITS = 15 }; /* times what an item took, for the thread that cannot leave */
#define LONGEST_WAIT_S 0.05            /* cancelling is not kept waiting */

/* In naps, as long as there is a reason to. */
static void wait_beside(const loop *l, vvi_pool *pool, double wait_s)
{
    const double until_s = vvi_os_seconds() + wait_s;
    bool goes_on = true;
    while (goes_on) {
        const double nap_s = fmin(until_s - vvi_os_seconds(), LONGEST_WAIT_S);
        if (nap_s > 0)
            nanosleep(&(struct timespec){.tv_nsec = (long)(1e9 * nap_s)}, NULL);
        goes_on = nap_s > 0 && !has_ended(l) && !vvi_pool_is_calm(pool);
    }
}

/* Between two items, while an urgent loop has work to do: helpers leave for it, true, and the thread whose loop it is
 * leaves the processor to it for a while. Of a modest job also in the gaps between urgent ones. */
static bool steps_aside(const loop *l, int worker, double since_s)
{
    vv_runtime *runtime = vv_job_runtime(l->job);
    if (!l->yields || !runtime || l->job->urgent)
        return false;
    vvi_pool *pool = &runtime->pool;
    if (l->call.modest ? vvi_pool_is_calm(pool) : !vvi_pool_is_pressed(pool))
        return false;
    if (worker > 0)
        return true;
    const double took_s = vvi_os_seconds() - since_s;
    wait_beside(l, pool, l->call.modest ? MODEST_WAITS * took_s : fmin(WAITS * took_s, LONGEST_WAIT_S));
    return false;
}

static void do_items(loop *l, void *scratch, int worker, bool tells)
{
    double since_s = l->yields ? vvi_os_seconds() : 0;
    while (!has_ended(l)) {
        if (l->yields && steps_aside(l, worker, since_s))
            return;
        since_s = l->yields ? vvi_os_seconds() : 0;
        const size_t item = atomic_fetch_add_explicit(&l->next, 1, memory_order_relaxed);
        if (item >= l->n_items)
            return;
        if (l->work->item(scratch, l->shared, item) != VV_OK) {
            record_failure(l, item);
            return;
        }
        atomic_fetch_add(&l->done, 1);
        if (tells)
            vvi_job_report(l->job, l->work->stage, &l->done, l->work->n_before + l->n_items + l->work->n_after);
    }
}

/* Helpers for whom the limit leaves no room stay away: the thread whose loop it is does their part. */
static bool begin_part(void **scratch, loop *l, int worker)
{
    *scratch = NULL;
    const vv_status st = l->work->start ? l->work->start(scratch, l->shared, worker) : VV_OK;
    if (st == VV_E_LIMIT && worker > 0)
        atomic_store(&l->crowded, true);
    else if (st != VV_OK)
        record_failure(l, l->n_items);
    return st == VV_OK;
}

static void offer(loop *l)
{
    vv_runtime *runtime = vv_job_runtime(l->job);
    vvi_pool_offer(&runtime->pool, &l->call, runtime->threads - 1, l->n_items - 1);
}

/* Helpers are asked for once the thread whose loop it is has its scratch: it cannot do without. */
static void take_part(loop *l, int worker, bool offers)
{
    const int outside = depth;
    void *scratch;
    depth += l->n_items > 1;
    if (begin_part(&scratch, l, worker)) {
        if (offers)
            offer(l);
        do_items(l, scratch, worker, outside == 0);
        if (l->work->finish)
            l->work->finish(scratch, l->shared);
        if (offers)
            vvi_pool_withdraw(&vv_job_runtime(l->job)->pool, &l->call);
    }
    depth = outside;
}

/* With one rounding mode and no flushing of denormals, whatever the thread had before: the threads of a loop come from
 * different places, and the results must not tell which. */
static void take_part_in_default_arithmetic(loop *l, int worker, bool offers)
{
    fenv_t before;
    fegetenv(&before);
    fesetenv(FE_DFL_ENV);
    take_part(l, worker, offers);
    fesetenv(&before);
}

static bool wants_help(vvi_call *call)
{
    const loop *l = (const loop *)call;
    return !has_ended(l) && !atomic_load(&l->crowded) && atomic_load(&l->next) < l->n_items;
}

static void help(vvi_call *call, int worker)
{
    take_part_in_default_arithmetic((loop *)call, worker, false);
}

static void run(loop *l)
{
    vv_runtime *runtime = vv_job_runtime(l->job);
    const bool alone = !runtime || runtime->threads == 1 || l->n_items == 1 || depth > 0;
    const bool urgent = runtime && l->call.urgent;
    if (urgent)
        vvi_pool_note_urgent(&runtime->pool);
    take_part_in_default_arithmetic(l, 0, !alone);
    if (urgent)
        vvi_pool_note_urgent(&runtime->pool);
}

vv_status vvi_parallel_for(vv_job *job, const vvi_work *work, void *shared, size_t n_items)
{
    loop l = {.call = {.wanted = wants_help, .help = help, .urgent = job && job->urgent, .modest = job && job->modest},
              .work = work,
              .shared = shared,
              .job = job,
              .yields = work->yields || (job && job->modest),
              .n_items = n_items,
              .done = work->n_before};
    if (n_items == 0)
        return vvi_job_poll(job);
    if (pthread_mutex_init(&l.lock, NULL) != 0)
        return vv_fail_memory(sizeof l.lock);
    if (depth == 0 && work->n_before == 0)
        vvi_job_begin_stage(job, work->stage);
    run(&l);
    pthread_mutex_destroy(&l.lock);
    if (l.error.status != VV_OK)
        return vvi_error_put(&l.error);
    return atomic_load(&l.done) < work->n_before + n_items ? vvi_job_poll(job) : VV_OK;
}
