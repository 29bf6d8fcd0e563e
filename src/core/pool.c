#include "core/pool.h"
#include "core/memory.h"
#include "core/os.h"
#include "core/status.h"

#include <signal.h>
#include <stdlib.h>
#include <time.h>

#define SECOND INT64_C(1000000000)
#define CALM (SECOND / 10)

static int64_t now_ns(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return t.tv_sec * SECOND + t.tv_nsec;
}

void vvi_pool_note_urgent(vvi_pool *pool)
{
    atomic_store_explicit(&pool->calm_at, now_ns() + CALM, memory_order_relaxed);
}

bool vvi_pool_is_calm(const vvi_pool *pool)
{
    const int64_t at = atomic_load_explicit(&pool->calm_at, memory_order_relaxed);
    return at == 0 || at <= now_ns();
}

/* Urgent ones first, then those with fewer helpers, so that jobs share the threads evenly. */
static bool is_needier(const vvi_call *call, const vvi_call *than)
{
    return call->urgent != than->urgent ? call->urgent : call->inside < than->inside;
}

/* The call to help among those that want any; NULL: none. */
static vvi_call *neediest_call(const vvi_pool *pool)
{
    vvi_call *best = NULL;
    for (vvi_call *call = pool->calls; call; call = call->below)
        if ((!best || is_needier(call, best)) && (!call->modest || vvi_pool_is_calm(pool)) && call->wanted(call))
            best = call;
    return best;
}

static bool has_modest_call(const vvi_pool *pool)
{
    for (const vvi_call *call = pool->calls; call; call = call->below)
        if (call->modest)
            return true;
    return false;
}

/* For work; where a modest call waits, until it is calm. */
static void wait_for_work(vvi_pool *pool)
{
    if (!has_modest_call(pool)) {
        pthread_cond_wait(&pool->work, &pool->lock);
        return;
    }
    const int64_t calm_at = atomic_load(&pool->calm_at), now = now_ns(), until = calm_at > now ? calm_at : now + CALM;
    const struct timespec at = {.tv_sec = until / SECOND, .tv_nsec = until % SECOND};
    pthread_cond_timedwait(&pool->work, &pool->lock, &at);
}

bool vvi_pool_is_pressed(vvi_pool *pool)
{
    if (atomic_load_explicit(&pool->n_urgent, memory_order_relaxed) == 0)
        return false;
    pthread_mutex_lock(&pool->lock);
    const vvi_call *call = neediest_call(pool);
    const bool pressed = call && call->urgent;
    pthread_mutex_unlock(&pool->lock);
    return pressed;
}

static void help(vvi_pool *pool, vvi_call *call, int worker)
{
    call->inside++;
    pthread_mutex_unlock(&pool->lock);
    call->help(call, worker);
    pthread_mutex_lock(&pool->lock);
    if (--call->inside == 0)
        pthread_cond_broadcast(&pool->left);
}

static void *run_thread(void *user)
{
    vvi_pool *pool = user;
    vvi_os_name_thread("volvis");
    pthread_mutex_lock(&pool->lock);
    const int number = ++pool->n_numbered;
    while (!pool->stopping) {
        vvi_call *call = neediest_call(pool);
        if (call)
            help(pool, call, number);
        else
            wait_for_work(pool);
    }
    pthread_mutex_unlock(&pool->lock);
    return NULL;
}

/* Signals are for the program's own threads, but for faults: those come to the thread that made them, and blocked they
 * end the process without asking the handler that answers for mapped files (io/mapping.c). */
static void block_signals(sigset_t *before)
{
    static const int faults[] = {SIGBUS, SIGSEGV, SIGFPE, SIGILL, SIGTRAP, SIGSYS};
    sigset_t blocked;
    sigfillset(&blocked);
    for (size_t i = 0; i < sizeof faults / sizeof *faults; i++)
        sigdelset(&blocked, faults[i]);
    pthread_sigmask(SIG_SETMASK, &blocked, before);
}

/* Under the lock. What the system refuses now is asked for again at the next call. */
static void start_threads(vvi_pool *pool, int n)
{
    sigset_t before;
    if (!pool->threads)
        pool->threads = vvi_calloc((size_t)n, sizeof *pool->threads);
    if (!pool->threads)
        return;
    block_signals(&before);
    while (pool->n_threads < n && pthread_create(&pool->threads[pool->n_threads], NULL, run_thread, pool) == 0)
        pool->n_threads++;
    pthread_sigmask(SIG_SETMASK, &before, NULL);
}

vv_status vvi_pool_init(vvi_pool *pool)
{
    *pool = (vvi_pool){0};
    if (pthread_mutex_init(&pool->lock, NULL) != 0)
        return vv_fail_memory(sizeof pool->lock);
    pthread_condattr_t monotonic;
    pthread_condattr_init(&monotonic);
    pthread_condattr_setclock(&monotonic, CLOCK_MONOTONIC); /* setting the date must not stretch a wait */
    pthread_cond_init(&pool->work, &monotonic);
    pthread_condattr_destroy(&monotonic);
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

void vvi_pool_offer(vvi_pool *pool, vvi_call *call, int n_threads, size_t n_useful)
{
    pthread_mutex_lock(&pool->lock);
    if (pool->n_threads < n_threads)
        start_threads(pool, n_threads);
    call->below = pool->calls;
    pool->calls = call;
    atomic_fetch_add(&pool->n_urgent, call->urgent);
    if (n_useful >= (size_t)pool->n_threads)
        pthread_cond_broadcast(&pool->work);
    else
        for (size_t i = 0; i < n_useful; i++)
            pthread_cond_signal(&pool->work);
    pthread_mutex_unlock(&pool->lock);
}

void vvi_pool_withdraw(vvi_pool *pool, vvi_call *call)
{
    pthread_mutex_lock(&pool->lock);
    vvi_call **at = &pool->calls;
    while (*at != call)
        at = &(*at)->below;
    *at = call->below;
    atomic_fetch_sub(&pool->n_urgent, call->urgent);
    while (call->inside > 0)
        pthread_cond_wait(&pool->left, &pool->lock);
    pthread_mutex_unlock(&pool->lock);
}
