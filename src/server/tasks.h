/** @file
 * Work that takes longer than a message may: opening, operations, pictures, picks. Tasks of one queue run one after the
 * other on its thread; what comes of them is taken by the server's thread. Those who ask take turns: of each, however
 * many wait, one runs before another has its second.
 */
#ifndef VVI_SERVER_TASKS_H
#define VVI_SERVER_TASKS_H
#include "core/status.h"
#include <volvis/runtime.h>

typedef struct vvi_tasks vvi_tasks;

/** A task; begins with this, and what it needs and makes follows. */
typedef struct vvi_task {
    const char *name;                                      /**< "open", for people */
    vv_status (*run)(struct vvi_task *task, vv_job *job);  /**< on the queue's thread */
    void (*done)(struct vvi_task *task, vv_status status); /**< on the server's; the thread's error is the task's */
    void (*drop)(struct vvi_task *task);                   /**< frees it; after done, or without run */
    uint64_t owner;                                        /**< who asked; 0: nobody */
    bool stays;                                            /**< it goes on when its owner leaves: others want it too */
    /* of the queue: */
    struct vvi_task *next;
    uint64_t turn;
    int64_t number;
    vv_status status;
    vvi_error_copy error;
} vvi_task;

/** How far the task that runs is. */
typedef struct vvi_task_state {
    int64_t number; /**< 0: none runs */
    const char *name;
    char stage[32];
    uint64_t done, total;
    double eta_s;
    size_t n_waiting;
} vvi_task_state;

vv_status vvi_tasks_new(vvi_tasks **out, vv_runtime *runtime, const char *name, void (*wake)(void *user), void *user);
/** Cancels what runs, and drops all. */
void vvi_tasks_free(vvi_tasks *tasks); /* NULL is fine */
/** Takes the task in any case; its number, above 0. VV_E_LIMIT: of its owner as many wait as may (share), or of all
 * together; it is dropped then. */
vv_status vvi_tasks_add(int64_t *number_out, vvi_tasks *tasks, vvi_task *task, size_t share);
/** false: there is none of that number any more, or (owner not 0) it is another's. */
bool vvi_tasks_cancel(vvi_tasks *tasks, int64_t number, uint64_t owner);
/** What its owner alone wanted is cancelled, or dropped where it waits; what stays is nobody's. Of those that are
 * nobody's, as many wait as one may have (share): the rest are cancelled. */
void vvi_tasks_leave(vvi_tasks *tasks, uint64_t owner, size_t share);
/** Calls done() and drop() of what has ended. */
void vvi_tasks_serve(vvi_tasks *tasks);
void vvi_tasks_state(vvi_task_state *out, vvi_tasks *tasks);
/** Whether none runs, waits or has ended without having been served. */
bool vvi_tasks_are_idle(vvi_tasks *tasks);
#endif
