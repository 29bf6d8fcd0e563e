#include "core/job.h"
#include "core/os.h"
#include "core/runtime.h"
#include "core/text.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <volvis/sys/registry.h>

_Static_assert(ATOMIC_BOOL_LOCK_FREE == 2, "a signal handler may cancel a job");

static const double report_every_s = 0.05; /* at most 20 a second */

vv_status vv_job_new(vv_job **out, vv_runtime *runtime, vv_progress_fn *progress, void *user)
{
    *out = NULL;
    vv_job *job = vvi_calloc(1, sizeof *job);
    if (!job || pthread_mutex_init(&job->lock, NULL) != 0) {
        free(job);
        return vv_fail_memory(sizeof *job);
    }
    job->runtime = vv_runtime_retain(runtime);
    job->progress = progress;
    job->user = user;
    *out = job;
    return VV_OK;
}

void vv_job_release(vv_job *job)
{
    if (!job)
        return;
    pthread_mutex_destroy(&job->lock);
    vv_runtime_release(job->runtime);
    free(job);
}

void vv_job_cancel(vv_job *job)
{
    if (job)
        atomic_store(&job->cancelled, true);
}

bool vv_job_cancelled(const vv_job *job)
{
    return job && atomic_load_explicit(&job->cancelled, memory_order_relaxed);
}

vv_runtime *vv_job_runtime(const vv_job *job)
{
    return job ? job->runtime : NULL;
}

int vvi_job_threads(const vv_job *job)
{
    const vv_runtime *runtime = vv_job_runtime(job);
    return runtime ? runtime->threads : 1;
}

vv_status vvi_job_poll(const vv_job *job)
{
    return vv_job_cancelled(job) ? vv_fail(VV_E_CANCELLED, "cancelled") : VV_OK;
}

/* The functions below are under the job's lock. */
static void begin_stage(vv_job *job, const char *stage, double now_s)
{
    job->stage = stage;
    job->stage_start_s = now_s;
    job->done = 0;
}

static double eta_s(double elapsed_s, uint64_t done, uint64_t total)
{
    return done > 0 && done <= total ? elapsed_s * (double)(total - done) / (double)done : -1;
}

static void tell(vv_job *job, uint64_t done, uint64_t total, double now_s)
{
    const double elapsed_s = now_s - job->stage_start_s;
    const vv_progress progress = {
        .stage = job->stage,
        .done = done,
        .total = total,
        .elapsed_s = elapsed_s,
        .eta_s = eta_s(elapsed_s, done, total),
    };
    job->done = done;
    if (!job->progress(job->user, &progress))
        vv_job_cancel(job);
    job->next_report_s =
        vvi_os_seconds() + report_every_s; /* from its end: a slow listener is not called all the time */
}

static void tell_when_due(vv_job *job, const char *stage, uint64_t done, uint64_t total)
{
    const double now_s = vvi_os_seconds();
    if (!job->stage || strcmp(job->stage, stage) != 0 || done < job->done)
        begin_stage(job, stage, now_s);
    if (now_s >= job->next_report_s)
        tell(job, done, total, now_s);
}

void vvi_job_begin_stage(vv_job *job, const char *stage)
{
    if (!job || !job->progress || !stage || pthread_mutex_trylock(&job->lock) != 0)
        return; /* nobody listens, or the listener itself has begun work in this job */
    begin_stage(job, stage, vvi_os_seconds());
    pthread_mutex_unlock(&job->lock);
}

void vvi_job_report(vv_job *job, const char *stage, const _Atomic uint64_t *done, uint64_t total)
{
    if (!job || !job->progress || !stage || pthread_mutex_trylock(&job->lock) != 0)
        return; /* nobody listens, or somebody else is telling */
    tell_when_due(job, stage, atomic_load(done), total);
    pthread_mutex_unlock(&job->lock);
}

vv_status vvi_job_progress(vv_job *job, const char *stage, uint64_t done, uint64_t total)
{
    const _Atomic uint64_t now_done = done;
    vvi_job_report(job, stage, &now_done, total);
    return vvi_job_poll(job);
}

const struct vv_registry *vvi_job_registry(const vv_job *job)
{
    const vv_runtime *runtime = vv_job_runtime(job);
    return runtime ? runtime->registry : vv_registry_builtin();
}

bool vvi_job_allow_outside(const vv_job *job)
{
    const vv_runtime *runtime = vv_job_runtime(job);
    return runtime && runtime->allow_outside;
}

void vvi_log(const vv_job *job, vv_log_level level, const char *component, const char *format, ...)
{
    vv_runtime *runtime = vv_job_runtime(job);
    if (!runtime || !runtime->log.fn || level > runtime->log.level)
        return;
    char text[2048];
    va_list args;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    vvi_text_clean(text);
    pthread_mutex_lock(&runtime->log.lock);
    runtime->log.fn(runtime->log.user, level, component, text);
    pthread_mutex_unlock(&runtime->log.lock);
}
