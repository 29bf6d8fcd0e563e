#include "server/tasks.h"
#include "core/memory.h"
#include "core/os.h"

#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>

enum { WAITING_MOST = 1024 }; /* of all who ask */

struct vvi_tasks {
    vv_runtime *runtime;
    const char *name;
    void (*wake)(void *user);
    void *user;
    pthread_t thread;
    pthread_mutex_t lock; /* of all that follows */
    pthread_cond_t changed;
    bool ends;
    vvi_task *first, **last; /* waiting */
    vvi_task *ended, **last_ended;
    vvi_task *running;
    vv_job *job;
    int64_t numbers;
    uint64_t turn; /* of the task that was taken last */
    vvi_task_state state;
};

static bool note_progress(void *user, const vv_progress *progress)
{
    vvi_tasks *tasks = user;
    pthread_mutex_lock(&tasks->lock);
    snprintf(tasks->state.stage, sizeof tasks->state.stage, "%s", progress->stage ? progress->stage : "");
    tasks->state.done = progress->done;
    tasks->state.total = progress->total;
    tasks->state.eta_s = progress->eta_s;
    const bool goes_on = !tasks->ends;
    pthread_mutex_unlock(&tasks->lock);
    tasks->wake(tasks->user);
    return goes_on;
}

static void run_task(vvi_tasks *tasks, vvi_task *task)
{
    task->status =
        tasks->job ? task->run(task, tasks->job) : vv_fail(VV_E_MEMORY, "there is not enough memory for a job");
    if (task->status != VV_OK)
        vvi_error_take(&task->error);
}

/* Waits for a task; NULL at the end. */
static vvi_task *take(vvi_tasks *tasks)
{
    pthread_mutex_lock(&tasks->lock);
    while (!tasks->first && !tasks->ends)
        pthread_cond_wait(&tasks->changed, &tasks->lock);
    vvi_task *task = tasks->ends ? NULL : tasks->first;
    if (task) {
        tasks->first = task->next;
        if (!tasks->first)
            tasks->last = &tasks->first;
        task->next = NULL;
        tasks->turn = task->turn;
        tasks->running = task;
        tasks->state = (vvi_task_state){.number = task->number, .name = task->name, .eta_s = -1};
        if (vv_job_new(&tasks->job, tasks->runtime, note_progress, tasks) != VV_OK)
            tasks->job = NULL;
    }
    pthread_mutex_unlock(&tasks->lock);
    return task;
}

static void put_ended(vvi_tasks *tasks, vvi_task *task)
{
    pthread_mutex_lock(&tasks->lock);
    vv_job *job = tasks->job;
    tasks->job = NULL;
    tasks->running = NULL;
    tasks->state = (vvi_task_state){.number = 0};
    *tasks->last_ended = task;
    tasks->last_ended = &task->next;
    pthread_mutex_unlock(&tasks->lock);
    vv_job_release(job);
    tasks->wake(tasks->user);
}

static void *run(void *user)
{
    vvi_tasks *tasks = user;
    vvi_os_name_thread(tasks->name);
    for (vvi_task *task; (task = take(tasks)) != NULL;) {
        run_task(tasks, task);
        put_ended(tasks, task);
    }
    return NULL;
}

vv_status vvi_tasks_new(vvi_tasks **out, vv_runtime *runtime, const char *name, void (*wake)(void *user), void *user)
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
    pthread_mutex_init(&tasks->lock, NULL);
    pthread_cond_init(&tasks->changed, NULL);
    if (pthread_create(&tasks->thread, NULL, run, tasks) != 0) {
        vv_runtime_release(runtime);
        free(tasks);
        return vv_fail(VV_E_MEMORY, "the system cannot start a thread to work with");
    }
    *out = tasks;
    return VV_OK;
}

static void drop_all(vvi_task *task)
{
    while (task) {
        vvi_task *next = task->next;
        vvi_error_copy_free(&task->error);
        task->drop(task);
        task = next;
    }
}

void vvi_tasks_free(vvi_tasks *tasks)
{
    if (!tasks)
        return;
    pthread_mutex_lock(&tasks->lock);
    tasks->ends = true;
    if (tasks->job)
        vv_job_cancel(tasks->job);
    pthread_cond_signal(&tasks->changed);
    pthread_mutex_unlock(&tasks->lock);
    pthread_join(tasks->thread, NULL);
    drop_all(tasks->first);
    drop_all(tasks->ended);
    pthread_mutex_destroy(&tasks->lock);
    pthread_cond_destroy(&tasks->changed);
    vv_runtime_release(tasks->runtime);
    free(tasks);
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
    if (tasks->running && tasks->running->owner == owner)
        turn++;
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
        pthread_cond_signal(&tasks->changed);
    }
    pthread_mutex_unlock(&tasks->lock);
    if (fits && all_fit)
        return VV_OK;
    task->drop(task);
    return fits ? vv_fail(VV_E_LIMIT, "%d jobs are already waiting; try again when some have ended", WAITING_MOST)
                : vv_fail(VV_E_LIMIT, "%zu jobs of yours are already waiting; let some end, or cancel them", share);
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

bool vvi_tasks_cancel(vvi_tasks *tasks, int64_t number, uint64_t owner)
{
    pthread_mutex_lock(&tasks->lock);
    const bool runs = tasks->running && tasks->running->number == number && (!owner || tasks->running->owner == owner);
    if (runs && tasks->job)
        vv_job_cancel(tasks->job);
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

void vvi_tasks_leave(vvi_tasks *tasks, uint64_t owner, size_t share)
{
    pthread_mutex_lock(&tasks->lock);
    vvi_task *running = tasks->running;
    if (running && running->owner == owner) {
        running->owner = 0;
        if (!running->stays && tasks->job)
            vv_job_cancel(tasks->job);
    }
    vvi_task *gone = let_go(tasks, owner);
    const bool ended = cancel_orphans(tasks, share);
    pthread_mutex_unlock(&tasks->lock);
    drop_all(gone);
    if (ended)
        tasks->wake(tasks->user);
}

void vvi_tasks_serve(vvi_tasks *tasks)
{
    pthread_mutex_lock(&tasks->lock);
    vvi_task *task = tasks->ended;
    tasks->ended = NULL;
    tasks->last_ended = &tasks->ended;
    pthread_mutex_unlock(&tasks->lock);
    while (task) {
        vvi_task *next = task->next;
        const vv_status st = task->status;
        if (st != VV_OK)
            vvi_error_put(&task->error);
        task->done(task, st);
        task->drop(task);
        task = next;
    }
}

void vvi_tasks_state(vvi_task_state *out, vvi_tasks *tasks)
{
    pthread_mutex_lock(&tasks->lock);
    *out = tasks->state;
    out->n_waiting = n_waiting(tasks);
    pthread_mutex_unlock(&tasks->lock);
}

bool vvi_tasks_are_idle(vvi_tasks *tasks)
{
    pthread_mutex_lock(&tasks->lock);
    const bool idle = !tasks->first && !tasks->running && !tasks->ended;
    pthread_mutex_unlock(&tasks->lock);
    return idle;
}
