#include "server/tasks.h"
#include "core/memory.h"
#include "core/os.h"

#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>

enum { WAITING_MOST = 64 };

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

vv_status vvi_tasks_add(int64_t *number_out, vvi_tasks *tasks, vvi_task *task)
{
    pthread_mutex_lock(&tasks->lock);
    const bool fits = n_waiting(tasks) < WAITING_MOST;
    if (fits) {
        task->number = *number_out = ++tasks->numbers;
        task->next = NULL;
        *tasks->last = task;
        tasks->last = &task->next;
        pthread_cond_signal(&tasks->changed);
    }
    pthread_mutex_unlock(&tasks->lock);
    if (fits)
        return VV_OK;
    task->drop(task);
    return vv_fail(VV_E_LIMIT, "%d jobs are already waiting; let some end, or cancel them", WAITING_MOST);
}

/* A task that waits is taken out and ends as cancelled. */
static bool cancel_waiting(vvi_tasks *tasks, int64_t number)
{
    for (vvi_task **at = &tasks->first; *at; at = &(*at)->next) {
        vvi_task *task = *at;
        if (task->number != number)
            continue;
        *at = task->next;
        if (tasks->last == &task->next)
            tasks->last = at;
        task->next = NULL;
        task->status = vv_fail(VV_E_CANCELLED, "cancelled");
        vvi_error_take(&task->error);
        *tasks->last_ended = task;
        tasks->last_ended = &task->next;
        return true;
    }
    return false;
}

bool vvi_tasks_cancel(vvi_tasks *tasks, int64_t number)
{
    pthread_mutex_lock(&tasks->lock);
    const bool runs = tasks->running && tasks->running->number == number;
    if (runs && tasks->job)
        vv_job_cancel(tasks->job);
    const bool waited = !runs && cancel_waiting(tasks, number);
    pthread_mutex_unlock(&tasks->lock);
    if (waited)
        tasks->wake(tasks->user);
    return runs || waited;
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
