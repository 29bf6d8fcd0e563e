/* Whose turn it is: what waits, in order, and what may run beside what runs. */
#include "server/tasks_impl.h"

#include "server/session.h"

#include <string.h>

/* Turns ----------------------------------------------------------------------------------------------------------- */

/* What runs, as a task that waits sees it. */
typedef struct beside {
    size_t n, fresh, neighbours; /* tasks: all; of less than a second; of the same address */
    bool excludes;               /* one that it must not run beside */
} beside;

static beside look_beside(const vvi_tasks *tasks, const vvi_task *task, int64_t now)
{
    beside b = {0};
    for (size_t i = 0; i < tasks->n_workers; i++) {
        const vvi_worker *w = &tasks->workers[i];
        if (!w->running)
            continue;
        b.n++;
        b.fresh += now - w->began < tasks->options.fresh;
        b.neighbours += strcmp(w->running->address, task->address) == 0;
        b.excludes |= w->running->owner == task->owner || (w->running->alone && task->alone);
    }
    return b;
}

/* A few run at once. What has run for a while takes up none of their places, as nobody knows when it will end: others
 * begin beside it, until there are very many, or half as many of one address. */
static bool has_place(const vvi_tasks *tasks, const beside *b)
{
    const vvi_tasks_options *o = &tasks->options;
    return b->n < o->at_once || (b->n < o->most && b->fresh < o->at_once && b->neighbours < (o->most + 1) / 2);
}

static vvi_task *take_out(vvi_task **at)
{
    vvi_task *task = *at;
    *at = task->next;
    task->next = NULL;
    return task;
}

/* Of an address where nothing runs first: many pages of one are no way to more. */
vvi_task *vvi_tasks_next(vvi_tasks *tasks, int64_t now)
{
    vvi_task **found = NULL;
    for (vvi_task **at = &tasks->first; *at; at = &(*at)->next) {
        const beside b = look_beside(tasks, *at, now);
        if (b.excludes || !has_place(tasks, &b))
            continue;
        if (b.neighbours == 0)
            return take_out(at);
        found = found ? found : at;
    }
    return found ? take_out(found) : NULL;
}

/* What runs for nobody, and for the longest time. */
static vvi_worker *oldest_orphan(vvi_tasks *tasks, const char *address)
{
    vvi_worker *oldest = NULL;
    for (size_t i = 0; i < tasks->n_workers; i++) {
        vvi_worker *w = &tasks->workers[i];
        if (w->running && w->left && (!address || strcmp(w->running->address, address) == 0) &&
            (!oldest || w->left < oldest->left))
            oldest = w;
    }
    return oldest;
}

static bool any_gives_way(const vvi_tasks *tasks)
{
    bool any = false;
    for (size_t i = 0; i < tasks->n_workers; i++)
        any |= tasks->workers[i].running && tasks->workers[i].gives_way;
    return any;
}

void vvi_tasks_make_way(vvi_tasks *tasks, int64_t now)
{
    if (any_gives_way(tasks))
        return; /* its end is near */
    for (const vvi_task *t = tasks->first; t; t = t->next) {
        const beside b = look_beside(tasks, t, now);
        if (!t->owner || b.excludes || has_place(tasks, &b))
            continue;
        vvi_worker *w = oldest_orphan(tasks, b.n < tasks->options.most ? t->address : NULL);
        if (!w || now - w->left < tasks->options.kept || !w->job)
            continue;
        w->gives_way = true;
        vv_job_cancel(w->job);
        return;
    }
}

/* What waits ------------------------------------------------------------------------------------------------------ */

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
}

vv_status vvi_tasks_add(int64_t *number_out, vvi_tasks *tasks, vvi_task *task, size_t share)
{
    pthread_mutex_lock(&tasks->lock);
    const bool fits = n_waiting_of(tasks, task->owner) < share, all_fit = n_waiting(tasks) < VVI_TASKS_WAITING;
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
    return fits ? vv_fail(VV_E_LIMIT, "%d jobs are already waiting; try again when some have ended", VVI_TASKS_WAITING)
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
        end_cancelled(tasks, take_out(at));
        return true;
    }
    return false;
}

/* false: none of that number runs, or it is another's. */
static bool cancel_running(const vvi_tasks *tasks, int64_t number, uint64_t owner)
{
    for (size_t i = 0; i < tasks->n_workers; i++) {
        const vvi_worker *w = &tasks->workers[i];
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
        tasks->options.wake(tasks->options.user);
    return runs || waited;
}

/* What waits of an owner who leaves: those that nobody else wants are put into a list, which it gives. */
static vvi_task *let_go(vvi_tasks *tasks, uint64_t owner)
{
    vvi_task *gone = NULL;
    for (vvi_task **at = &tasks->first; *at;) {
        vvi_task *task = *at;
        if (task->owner == owner && !task->stays) {
            take_out(at);
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
            end_cancelled(tasks, take_out(at));
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
        vvi_worker *w = &tasks->workers[i];
        if (!w->running || w->running->owner != owner)
            continue;
        w->running->owner = 0;
        w->left = vvi_now();
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
    vvi_task_drop_all(gone);
    if (ended)
        tasks->options.wake(tasks->options.user);
}

/* Those that have ended and may be served, in the order in which they have. */
