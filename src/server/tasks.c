#include "server/tasks_impl.h"

#include "core/memory.h"
#include "core/os.h"
#include "io/source.h"
#include "server/session.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#define SECOND 1000000000L
#define MOMENT (SECOND / 10)

static bool note_progress(void *user, const vv_progress *progress)
{
    vvi_worker *w = user;
    vvi_tasks *tasks = w->tasks;
    pthread_mutex_lock(&tasks->lock);
    snprintf(w->state.stage, sizeof w->state.stage, "%s", progress->stage ? progress->stage : "");
    w->state.done = progress->done;
    w->state.total = progress->total;
    w->state.eta_s = progress->eta_s;
    const bool goes_on = !tasks->ends;
    pthread_mutex_unlock(&tasks->lock);
    tasks->options.wake(tasks->options.user);
    return goes_on;
}

static void run_task(const vvi_worker *w, vvi_task *task)
{
    const unsigned faults = vvi_mapping_faults();
    task->status = w->job ? task->run(task, w->job) : vv_fail(VV_E_MEMORY, "there is not enough memory for a job");
    if (task->status == VV_OK && !task->stays) /* what changes the World or the disk asks its own samples */
        task->status = vvi_mapping_check_since(faults);
    if (task->status != VV_OK)
        vvi_error_take(&task->error);
}

static void *run(void *user);

/* Another thread, where none is left that waits; without it those that are there go on. */
static void start_another(vvi_tasks *tasks)
{
    const size_t n = tasks->n_workers;
    for (size_t i = 0; i < n; i++)
        if (!tasks->workers[i].running)
            return;
    if (n == VVI_TASKS_THREADS || n > tasks->options.most)
        return;
    tasks->workers[n] = (vvi_worker){.tasks = tasks};
    if (pthread_create(&tasks->workers[n].thread, NULL, run, &tasks->workers[n]) == 0)
        tasks->n_workers++;
}

/* Until something changes; where tasks wait a moment at most, since time changes what may run. */
static void wait_for_change(vvi_tasks *tasks)
{
    struct timespec until;
    if (!tasks->first) {
        pthread_cond_wait(&tasks->changed, &tasks->lock);
        return;
    }
    clock_gettime(CLOCK_MONOTONIC, &until);
    until.tv_nsec += MOMENT;
    until.tv_sec += until.tv_nsec / SECOND;
    until.tv_nsec %= SECOND;
    pthread_cond_timedwait(&tasks->changed, &tasks->lock, &until);
}

static void begin(vvi_worker *w, vvi_task *task)
{
    vvi_tasks *tasks = w->tasks;
    tasks->turn = task->turn > tasks->turn ? task->turn : tasks->turn;
    w->running = task;
    w->began = vvi_now();
    w->left = task->owner ? 0 : w->began;
    w->gives_way = false;
    w->state = (vvi_task_state){.number = task->number, .name = task->name, .eta_s = -1};
    if (vv_job_new(&w->job, tasks->runtime, note_progress, w) != VV_OK)
        w->job = NULL;
    vvi_warnings_gather(&task->warnings, w->job);
    start_another(tasks);
}

/* Waits for a task; NULL at the end. */
static vvi_task *take(vvi_worker *w)
{
    vvi_tasks *tasks = w->tasks;
    vvi_task *task = NULL;
    pthread_mutex_lock(&tasks->lock);
    while (!tasks->ends && !(task = vvi_tasks_next(tasks, vvi_now()))) {
        vvi_tasks_make_way(tasks, vvi_now());
        wait_for_change(tasks);
    }
    if (task)
        begin(w, task);
    pthread_mutex_unlock(&tasks->lock);
    return task;
}

static void put_ended(vvi_worker *w, vvi_task *task)
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
    tasks->options.wake(tasks->options.user);
}

static void *run(void *user)
{
    vvi_worker *w = user;
    vvi_os_name_thread(w->tasks->options.name);
    for (vvi_task *task; (task = take(w)) != NULL;) {
        run_task(w, task);
        put_ended(w, task);
    }
    return NULL;
}

static void end_threads(vvi_tasks *tasks)
{
    pthread_mutex_lock(&tasks->lock);
    tasks->ends = true;
    const size_t n = tasks->n_workers; /* none is started from here on */
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

vv_status vvi_tasks_new(vvi_tasks **out, vv_runtime *runtime, const vvi_tasks_options *options)
{
    vvi_tasks *tasks = vvi_calloc(1, sizeof *tasks);
    pthread_condattr_t monotonic;
    *out = NULL;
    if (!tasks)
        return vv_fail_memory(sizeof *tasks);
    tasks->runtime = vv_runtime_retain(runtime);
    tasks->options = *options;
    tasks->last_ended = &tasks->ended;
    pthread_mutex_init(&tasks->lock, NULL);
    pthread_condattr_init(&monotonic);
    pthread_condattr_setclock(&monotonic, CLOCK_MONOTONIC); /* setting the date must not stretch a wait */
    pthread_cond_init(&tasks->changed, &monotonic);
    pthread_condattr_destroy(&monotonic);
    pthread_mutex_lock(&tasks->lock);
    start_another(tasks);
    const bool started = tasks->n_workers > 0;
    pthread_mutex_unlock(&tasks->lock);
    if (started) {
        *out = tasks;
        return VV_OK;
    }
    destroy(tasks);
    return vv_fail(VV_E_MEMORY, "the system cannot start a thread to work with");
}

void vvi_task_drop(vvi_task *task)
{
    free(task->warnings);
    task->drop(task);
}

void vvi_task_drop_all(vvi_task *task)
{
    while (task) {
        vvi_task *next = task->next;
        vvi_error_copy_free(&task->error);
        vvi_task_drop(task);
        task = next;
    }
}

void vvi_tasks_free(vvi_tasks *tasks)
{
    if (!tasks)
        return;
    end_threads(tasks);
    vvi_task_drop_all(tasks->first);
    vvi_task_drop_all(tasks->ended);
    destroy(tasks);
}

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
        vvi_task_drop(task);
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
    out->n_waiting = 0;
    for (const vvi_task *t = tasks->first; t; t = t->next)
        out->n_waiting++;
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
