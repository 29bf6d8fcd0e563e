/** @file
 * Work in a job: parallel loops, progress, cancel, memory that is counted, what is said beside the result. Everywhere
 * job may be NULL: this thread alone.
 */
#ifndef VOLVIS_SYS_WORK_H
#define VOLVIS_SYS_WORK_H
#include <volvis/runtime.h>
#include <volvis/sys/fail.h>
VV_BEGIN_DECLS

/** Items of a parallel loop take 0.1 to 10 ms. start / item / finish give each worker its own state: no locks. */
typedef struct vv_work {
    const char *stage; /**< of the progress; NULL: no progress is reported */
    vv_status (*start)(void **scratch_out, void *shared, int worker); /**< NULL: scratch is NULL */
    vv_status (*item)(void *scratch, void *shared, size_t index);
    void (*finish)(void *scratch, void *shared);
    uint64_t n_before, n_after; /**< items of other loops that make one stage with this one: only for the progress */
    bool yields; /**< helpers may leave between items for a loop of an urgent job and begin anew: start() comes cheap,
                      and nothing is summed by worker */
} vv_work;

/** Runs items 0 .. n-1, this thread included, in any order and on any worker. The first failure by item number becomes
 * this thread's error; cancel gives VV_E_CANCELLED. Reductions belong per item, summed in item order by the caller.
 * Nested loops run on the calling worker alone. */
VV_API vv_status vv_parallel_for(vv_job *job, const vv_work *work, void *shared, size_t n_items);
/** Workers that a loop may use: scratch arrays by worker have this many. */
VV_API int vv_job_threads(const vv_job *job);
/** VV_OK, or VV_E_CANCELLED with its text. Poll at least every 20 ms. Cheap. */
VV_API vv_status vv_job_poll(const vv_job *job);
/** Serial work: how far it is. VV_E_CANCELLED when it should stop. */
VV_API vv_status vv_job_progress(vv_job *job, const char *stage, uint64_t done, uint64_t total);
/** A warning in the log, told once of the same job, however often it comes. component: "io", "filter", ... */
VV_API void vv_job_warn(vv_job *job, const char *component, const char *format, ...) VV_PRINTF(3, 4);

/** Memory that counts against the runtime's limit: 64-byte aligned, not cleared. NULL when refused; then
 * vv_fail_memory() tells why. It may outlive the job, and keeps the runtime. */
VV_API void *vv_alloc(vv_job *job, size_t bytes);
VV_API void vv_free(void *memory); /* NULL is fine */
/** Whether `bytes` more would fit; else VV_E_LIMIT with a sentence that says what `what` needs, what the limit is and
 * how to raise it. Ask before long work, not before each allocation. */
VV_API vv_status vv_memory_plan(vv_job *job, uint64_t bytes, const char *what);

/** What work has found beside its result (vv_job_finding()), told by the thread that runs it: a figure for programs; a
 * phrase about the result, "3 pieces became 2"; a note on the input. */
VV_API void vv_job_find_number(vv_job *job, const char *name, double value);
VV_API void vv_job_find_phrase(vv_job *job, const char *format, ...) VV_PRINTF(2, 3);
VV_API void vv_job_find_note(vv_job *job, const char *format, ...) VV_PRINTF(2, 3);

VV_END_DECLS
#endif
