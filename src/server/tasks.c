#include "server/tasks.h"
#include "core/memory.h"
#include "core/os.h"

#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>

enum { WAITING_MOST = 1024 }; /* of all who ask */

/* One of the threads, and what it does now. */
typedef struct worker {
    vvi_tasks *tasks;
    pthread_t thread;
    vvi_task *running; /* NULL: it waits */
    vv_job *job;
    vvi_task_state state;
} worker;

struct vvi_tasks {
    vv_runtime *runtime;
    const char *name;
    void (*wake)(void *user);
    void *user;
    pthread_mutex_t lock; /* of all that follows */
    pthread_cond_t changed;
    bool ends;
    vvi_task *first, **last; /* waiting */
    vvi_task *ended, **last_ended;
    int64_t numbers;
    uint64_t turn; /* the last one that somebody had */
    size_t n_workers;
    worker workers[VVI_TASKS_AT_ONCE];
};

static bool note_progress(void *user, const vv_progress *progress)
{
    worker *w = user;
    vvi_tasks *tasks = w->tasks;
    pthread_mutex_lock(&tasks->lock);
    snprintf(w->state.stage, sizeof w->state.stage, "%s", progress->stage ? progress->stage : "");
    w->state.done = progress->done;
    w->state.total = progress->total;
    w->state.eta_s = progress->eta_s;
    const bool goes_on = !tasks->ends;
    pthread_mutex_unlock(&tasks->lock);
    tasks->wake(tasks->user);
    return goes_on;
}

static void run_task(const worker *w, vvi_task *task)
{
    task->status = w->job ? task->run(task, w->job) : vv_fail(VV_E_MEMORY, "there is not enough memory for a job");
    if (task->status != VV_OK)
        vvi_error_take(&task->error);
}

/* Whether it may run beside what runs. */
static bool may_run(const vvi_tasks *tasks, const vvi_task *task)
{
    for (size_t i = 0; i < tasks->n_workers; i++) {
        const vvi_task *other = tasks->workers[i].running;
        if (other && (other->owner == task->owner || (other->alone && task->alone)))
            return false;
    }
    return true;
}

/* The next in turn of those that may run; NULL: there is none. */
static vvi_task **next_in_turn(vvi_tasks *tasks)
{
    for (vvi_task **at = &tasks->first; *at; at = &(*at)->next)
        if (may_run(tasks, *at))
            return at;
    return NULL;
}

static vvi_task *take_out(vvi_tasks *tasks, vvi_task **at)
{
    vvi_task *task = *at;
    *at = task->next;
    if (tasks->last == &task->next)
        tasks->last = at;
    task->next = NULL;
    return task;
}

/* Waits for a task; NULL at the end. */
static vvi_task *take(worker *w)
{
    vvi_tasks *tasks = w->tasks;
    vvi_task **at = NULL, *task = NULL;
    pthread_mutex_lock(&tasks->lock);
    while (!tasks->ends && (at = next_in_turn(tasks)) == NULL)
        pthread_cond_wait(&tasks->changed, &tasks->lock);
    if (!tasks->ends) {
        task = take_out(tasks, at);
        tasks->turn = task->turn > tasks->turn ? task->turn : tasks->turn;
        w->running = task;
        w->state = (vvi_task_state){.number = task->number, .name = task->name, .eta_s = -1};
        if (vv_job_new(&w->job, tasks->runtime, note_progress, w) != VV_OK)
            w->job = NULL;
        vvi_warnings_gather(&task->warnings, w->job);
    }
    pthread_mutex_unlock(&tasks->lock);
    return task;
}

static void put_ended(worker *w, vvi_task *task)
{
    vvi_tasks *tasks = w->tasks;
    pthread_mutex_lock(&tasks->lock);
    vv_job *job = w->job;
    w->job = NULL;
    w->running = NULL;
    w->state = (vvi_task_state){.number = 0};
    *tasks->last_ended = task;
    tasks->last_ended = &task->next;
    pthread_cond_broadcast(&tasks->changed); /* what could not run beside it may run now */
    pthread_mutex_unlock(&tasks->lock);
    vv_job_release(job);
    tasks->wake(tasks->user);
}

static void *run(void *user)
{
    worker *w = user;
    vvi_os_name_thread(w->tasks->name);
    for (vvi_task *task; (task = take(w)) != NULL;) {
        run_task(w, task);
        put_ended(w, task);
    }
    return NULL;
}

/* Ends the first n threads. */
static void end_threads(vvi_tasks *tasks, size_t n)
{
    pthread_mutex_lock(&tasks->lock);
    tasks->ends = true;
    for (size_t i = 0; i < n; i++)
        if (tasks->workers[i].job)
            vv_job_cancel(tasks->workers[i].job);
    pthread_cond_broadcast(&tasks->changed);
    pthread_mutex_unlock(&tasks->lock);
    for (size_t i = 0; i < n; i++)
        pthread_join(tasks->workers[i].thread, NULL);
}

static void destroy(vvi_tasks *tasks)
{
    pthread_mutex_destroy(&tasks->lock);
    pthread_cond_destroy(&tasks->changed);
    vv_runtime_release(tasks->runtime);
    free(tasks);
}

vv_status vvi_tasks_new(vvi_tasks **out, vv_runtime *runtime, const char *name, size_t at_once,
                        void (*wake)(void *user), void *user)
{
    vvi_tasks *tasks = vvi_calloc(1, sizeof *tasks);
    *out = NULL;
    if (!tasks)
        return vv_fail_memory(sizeof *tasks);
    tasks->runtime = vv_runtime_retain(runtime);
    tasks->name = name;
    tasks->wake = wake;
    tasks->user = user;
    tasks->last = &tasks->first;
    tasks->last_ended = &tasks->ended;
    tasks->n_workers = at_once < VVI_TASKS_AT_ONCE ? at_once : VVI_TASKS_AT_ONCE;
    pthread_mutex_init(&tasks->lock, NULL);
    pthread_cond_init(&tasks->changed, NULL);
    for (size_t i = 0; i < tasks->n_workers; i++)
        tasks->workers[i].tasks = tasks;
    for (size_t i = 0; i < tasks->n_workers; i++) {
        if (pthread_create(&tasks->workers[i].thread, NULL, run, &tasks->workers[i]) == 0)
            continue;
        end_threads(tasks, i);
        destroy(tasks);
        return vv_fail(VV_E_MEMORY, "the system cannot start a thread to work with");
    }
    *out = tasks;
    return VV_OK;
}

static void drop(vvi_task *task)
{
    free(task->warnings);
    task->drop(task);
}

static void drop_all(vvi_task *task)
{
    while (task) {
        vvi_task *next = task->next;
        vvi_error_copy_free(&task->error);
        drop(task);
        task = next;
    }
}

void vvi_tasks_free(vvi_tasks *tasks)
{
    if (!tasks)
        return;
    end_threads(tasks, tasks->n_workers);
    drop_all(tasks->first);
    drop_all(tasks->ended);
    destroy(tasks);
}

static size_t n_waiting(const vvi_tasks *tasks)
{
    size_t n = 0;
    for (const vvi_task *t = tasks->first; t; t = t->next)
        n++;
    return n;
}

static size_t n_waiting_of(const vvi_tasks *tasks, uint64_t owner)
{
    size_t n = 0;
    for (const vvi_task *t = tasks->first; t; t = t->next)
        n += t->owner == owner;
    return n;
}

/* The turn after the last one that its owner has: who has none waiting comes with those who are next. (Start-time fair
 * queueing, Goyal, Vin & Cheng 1996, every task as long as another.) */
static uint64_t next_turn(const vvi_tasks *tasks, uint64_t owner)
{
    uint64_t turn = tasks->turn;
    for (size_t i = 0; i < tasks->n_workers; i++)
        if (tasks->workers[i].running && tasks->workers[i].running->owner == owner)
            turn = tasks->turn + 1;
    for (const vvi_task *t = tasks->first; t; t = t->next)
        if (t->owner == owner)
            turn = t->turn + 1; /* they are in order */
    return turn;
}

/* Behind all that have their turn before or with it. */
static void put_in_turn(vvi_tasks *tasks, vvi_task *task)
{
    vvi_task **at = &tasks->first;
    while (*at && (*at)->turn <= task->turn)
        at = &(*at)->next;
    task->next = *at;
    *at = task;
    if (!task->next)
        tasks->last = &task->next;
}

vv_status vvi_tasks_add(int64_t *number_out, vvi_tasks *tasks, vvi_task *task, size_t share)
{
    pthread_mutex_lock(&tasks->lock);
    const bool fits = n_waiting_of(tasks, task->owner) < share, all_fit = n_waiting(tasks) < WAITING_MOST;
    if (fits && all_fit) {
        task->number = *number_out = ++tasks->numbers;
        task->turn = next_turn(tasks, task->owner);
        put_in_turn(tasks, task);
        pthread_cond_broadcast(&tasks->changed);
    }
    pthread_mutex_unlock(&tasks->lock);
    if (fits && all_fit)
        return VV_OK;
    task->drop(task);
    return fits ? vv_fail(VV_E_LIMIT, "%d jobs are already waiting; try again when some have ended", WAITING_MOST)
                : vv_fail(VV_E_LIMIT, "%zu jobs of yours are already waiting; let some end, or cancel them", share);
}

/* It ends as cancelled. */
static void end_cancelled(vvi_tasks *tasks, vvi_task *task)
{
    task->status = vv_fail(VV_E_CANCELLED, "cancelled");
    vvi_error_take(&task->error);
    *tasks->last_ended = task;
    tasks->last_ended = &task->next;
}

/* A task that waits is taken out and ends as cancelled. */
static bool cancel_waiting(vvi_tasks *tasks, int64_t number, uint64_t owner)
{
    for (vvi_task **at = &tasks->first; *at; at = &(*at)->next) {
        if ((*at)->number != number || (owner && (*at)->owner != owner))
            continue;
        end_cancelled(tasks, take_out(tasks, at));
        return true;
    }
    return false;
}

/* false: none of that number runs, or it is another's. */
static bool cancel_running(const vvi_tasks *tasks, int64_t number, uint64_t owner)
{
    for (size_t i = 0; i < tasks->n_workers; i++) {
        const worker *w = &tasks->workers[i];
        if (!w->running || w->running->number != number || (owner && w->running->owner != owner))
            continue;
        if (w->job)
            vv_job_cancel(w->job);
        return true;
    }
    return false;
}

bool vvi_tasks_cancel(vvi_tasks *tasks, int64_t number, uint64_t owner)
{
    pthread_mutex_lock(&tasks->lock);
    const bool runs = cancel_running(tasks, number, owner);
    const bool waited = !runs && cancel_waiting(tasks, number, owner);
    pthread_mutex_unlock(&tasks->lock);
    if (waited)
        tasks->wake(tasks->user);
    return runs || waited;
}

/* What waits of an owner who leaves: those that nobody else wants are put into a list, which it gives. */
static vvi_task *let_go(vvi_tasks *tasks, uint64_t owner)
{
    vvi_task *gone = NULL;
    for (vvi_task **at = &tasks->first; *at;) {
        vvi_task *task = *at;
        if (task->owner == owner && !task->stays) {
            take_out(tasks, at);
            task->next = gone;
            gone = task;
            continue;
        }
        if (task->owner == owner)
            task->owner = 0;
        at = &task->next;
    }
    return gone;
}

static bool cancel_orphans(vvi_tasks *tasks, size_t share)
{
    size_t n = 0;
    bool any = false;
    for (vvi_task **at = &tasks->first; *at;) {
        if ((*at)->owner == 0 && ++n > share) {
            end_cancelled(tasks, take_out(tasks, at));
            any = true;
        } else {
            at = &(*at)->next;
        }
    }
    return any;
}

/* What runs of an owner who leaves is cancelled, where nobody else wants it. */
static void let_run(vvi_tasks *tasks, uint64_t owner)
{
    for (size_t i = 0; i < tasks->n_workers; i++) {
        worker *w = &tasks->workers[i];
        if (!w->running || w->running->owner != owner)
            continue;
        w->running->owner = 0;
        if (!w->running->stays && w->job)
            vv_job_cancel(w->job);
    }
}

void vvi_tasks_leave(vvi_tasks *tasks, uint64_t owner, size_t share)
{
    pthread_mutex_lock(&tasks->lock);
    let_run(tasks, owner);
    vvi_task *gone = let_go(tasks, owner);
    const bool ended = cancel_orphans(tasks, share);
    pthread_cond_broadcast(&tasks->changed); /* what was theirs may run beside what was not */
    pthread_mutex_unlock(&tasks->lock);
    drop_all(gone);
    if (ended)
        tasks->wake(tasks->user);
}

/* Those that have ended and may be served, in the order in which they have. */
static vvi_task *take_ended(vvi_tasks *tasks, bool (*may)(const void *user, const vvi_task *task), const void *user)
{
    vvi_task *taken = NULL, **last = &taken;
    pthread_mutex_lock(&tasks->lock);
    tasks->last_ended = &tasks->ended;
    while (*tasks->last_ended) {
        vvi_task *task = *tasks->last_ended;
        if (may && !may(user, task)) {
            tasks->last_ended = &task->next;
            continue;
        }
        *tasks->last_ended = task->next;
        task->next = NULL;
        *last = task;
        last = &task->next;
    }
    pthread_mutex_unlock(&tasks->lock);
    return taken;
}

void vvi_tasks_serve(vvi_tasks *tasks, bool (*may)(const void *user, const vvi_task *task), const void *user)
{
    vvi_task *task = take_ended(tasks, may, user);
    while (task) {
        vvi_task *next = task->next;
        const vv_status st = task->status;
        if (st != VV_OK)
            vvi_error_put(&task->error);
        task->done(task, st);
        drop(task);
        task = next;
    }
}

void vvi_tasks_state(vvi_task_state *out, vvi_tasks *tasks, int64_t after)
{
    const vvi_task_state *next = NULL, *least = NULL;
    pthread_mutex_lock(&tasks->lock);
    for (size_t i = 0; i < tasks->n_workers; i++) {
        const vvi_task_state *state = &tasks->workers[i].state;
        if (state->number && (!least || state->number < least->number))
            least = state;
        if (state->number > after && (!next || state->number < next->number))
            next = state;
    }
    next = next ? next : least;
    *out = next ? *next : (vvi_task_state){.number = 0};
    out->n_waiting = n_waiting(tasks);
    pthread_mutex_unlock(&tasks->lock);
}

bool vvi_tasks_are_idle(vvi_tasks *tasks)
{
    pthread_mutex_lock(&tasks->lock);
    bool idle = !tasks->first;
    for (size_t i = 0; i < tasks->n_workers; i++)
        idle &= !tasks->workers[i].running;
    pthread_mutex_unlock(&tasks->lock);
    return idle;
}
