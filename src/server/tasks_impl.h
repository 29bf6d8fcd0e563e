/** @file
 * Inside a queue of tasks, between its files: the threads (tasks.c) and whose turn it is (tasks_turns.c).
 */
#ifndef VVI_SERVER_TASKS_IMPL_H
#define VVI_SERVER_TASKS_IMPL_H
#include "server/tasks.h"

#include <pthread.h>

enum {
    VVI_TASKS_WAITING = 1024 /* of all who ask */,
    VVI_TASKS_THREADS = VVI_TASKS_MOST + 1 /* one looks after turns */
};

/* One of the threads, and what it does now. */
typedef struct vvi_worker {
    vvi_tasks *tasks;
    pthread_t thread;
    vvi_task *running; /* NULL: it waits */
    vv_job *job;
    int64_t began;  /* nanoseconds */
    int64_t left;   /* when its owner left; 0: it is there */
    bool gives_way; /* to somebody who is there */
    vvi_task_state state;
} vvi_worker;

struct vvi_tasks {
    vv_runtime *runtime;
    vvi_tasks_options options;
    pthread_mutex_t lock; /* of all that follows */
    pthread_cond_t changed;
    bool ends;
    vvi_task *first; /* waiting */
    vvi_task *ended, **last_ended;
    int64_t numbers;
    uint64_t turn;    /* the last one that somebody had */
    size_t n_workers; /* threads that were started, as tasks needed them */
    vvi_worker workers[VVI_TASKS_THREADS];
};

/* All of these while the lock is held. */

/** Takes out the next in turn of those that may run; NULL: there is none. */
vvi_task *vvi_tasks_next(vvi_tasks *tasks, int64_t now);
/** Where somebody who is there waits for a place, what runs for one who left long ago is cancelled. */
void vvi_tasks_make_way(vvi_tasks *tasks, int64_t now);

/** Frees a task, its warnings too. */
void vvi_task_drop(vvi_task *task);
/** The same for a list of them, and their errors. */
void vvi_task_drop_all(vvi_task *task);
#endif
