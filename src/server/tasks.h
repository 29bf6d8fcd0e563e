/** @file
 * Work that takes longer than a message may: opening, operations, pictures, picks. Tasks of one queue run on its
 * threads, a few at once; what comes of them is taken by the server's thread. Of each who asks one runs at a time, in
 * the order of asking, so that who has none running need not wait for the end of another's. Those who ask take turns:
 * of each, however many wait, one runs before another has its second. A task that has run for a while takes up no place
 * any more: as many as may run at once begin beside it.
 */
#ifndef VVI_SERVER_TASKS_H
#define VVI_SERVER_TASKS_H
#include "core/status.h"
#include "server/warnings.h"
#include <volvis/runtime.h>

typedef struct vvi_tasks vvi_tasks;

enum { VVI_TASKS_MOST = 16, VVI_TASKS_ADDRESS = 48 };

typedef struct vvi_tasks_options {
    const char *name; /**< of the threads */
    size_t at_once;   /**< of those that have begun of late */
    size_t most;      /**< of all that run, up to VVI_TASKS_MOST; of one address half as many, where those are more */
    int64_t fresh;    /**< nanoseconds: how long it has begun of late */
    int64_t kept;     /**< how long a task goes on for one who has left, though others wait for its place */
    void (*wake)(void *user);
    void *user;
} vvi_tasks_options;

/** A task; begins with this, and what it needs and makes follows. */
typedef struct vvi_task {
    const char *name;                                      /**< "open", for people */
    vv_status (*run)(struct vvi_task *task, vv_job *job);  /**< on a thread of the queue */
    void (*done)(struct vvi_task *task, vv_status status); /**< on the server's; the thread's error is the task's */
    void (*drop)(struct vvi_task *task);                   /**< frees it; after done, or without run */
    uint64_t owner;                                        /**< who asked; 0: nobody */
    char address[VVI_TASKS_ADDRESS];                       /**< where that is */
    bool stays;                                            /**< it goes on when its owner leaves: others want it too */
    bool alone;                                            /**< no other such task runs beside it: each needs much */
    /* of the queue: */
    struct vvi_task *next;
    uint64_t turn;
    int64_t number;
    vv_status status;
    vvi_error_copy error;
    vvi_warnings warnings; /**< of files that were read; freed by the queue */
} vvi_task;

/** How far a task that runs is. */
typedef struct vvi_task_state {
    int64_t number; /**< 0: none runs */
    const char *name;
    char stage[32];
    uint64_t done, total;
    double eta_s;
    size_t n_waiting;
} vvi_task_state;

vv_status vvi_tasks_new(vvi_tasks **out, vv_runtime *runtime, const vvi_tasks_options *options);
/** Cancels what runs, and drops all. */
void vvi_tasks_free(vvi_tasks *tasks); /* NULL is fine */
/** Takes the task in any case; its number, above 0. VV_E_LIMIT: of its owner as many wait as may (share), or of all
 * together; it is dropped then. */
vv_status vvi_tasks_add(int64_t *number_out, vvi_tasks *tasks, vvi_task *task, size_t share);
/** false: there is none of that number any more, or (owner not 0) it is another's. */
bool vvi_tasks_cancel(vvi_tasks *tasks, int64_t number, uint64_t owner);
/** What its owner alone wanted is cancelled, or dropped where it waits; what stays is nobody's, and gives way after a
 * while (kept) to those who are there. Of those that are
 * nobody's, as many wait as one may have (share): the rest are cancelled. */
void vvi_tasks_leave(vvi_tasks *tasks, uint64_t owner, size_t share);
/** Calls done() and drop() of what has ended, in that order. may (NULL: all): false for what is to wait longer. */
void vvi_tasks_serve(vvi_tasks *tasks, bool (*may)(const void *user, const vvi_task *task), const void *user);
/** Of those that run the one with the next number behind `after`, else the first one. */
void vvi_tasks_state(vvi_task_state *out, vvi_tasks *tasks, int64_t after);
/** Whether none runs or waits; some may have ended and wait to be served. */
bool vvi_tasks_are_idle(vvi_tasks *tasks);
#endif
