#include "core/job.h"
#include "core/cache.h"
#include "core/memory.h"
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
    vv_job_forget_findings(job);
    free(job->read);
    free(job->lent.path);
    vv_runtime_release(job->runtime);
    free(job);
}

/* Sorted by number, so that a folder of many files that are opened again and again costs little. */
static size_t place_of_read(const vv_job *job, uint64_t device, uint64_t number)
{
    size_t lo = 0, hi = job->n_read;
    while (lo < hi) {
        const size_t middle = lo + (hi - lo) / 2;
        const vvi_file_identity *at = &job->read[middle];
        if (at->number < number || (at->number == number && at->device < device))
            lo = middle + 1;
        else
            hi = middle;
    }
    return lo;
}

static bool is_read(const vv_job *job, size_t place, uint64_t device, uint64_t number)
{
    return place < job->n_read && job->read[place].number == number && job->read[place].device == device;
}

static bool has_room(vv_job *job)
{
    if (job->n_read < job->room_read)
        return true;
    const size_t room = job->room_read ? 2 * job->room_read : 16;
    vvi_file_identity *more = vvi_realloc_plain(job->read, room * sizeof *more);
    if (!more)
        return false;
    job->read = more;
    job->room_read = room;
    return true;
}

void vvi_job_note_read(vv_job *job, uint64_t device, uint64_t number)
{
    if (!job)
        return;
    pthread_mutex_lock(&job->lock);
    const size_t place = place_of_read(job, device, number);
    if (!is_read(job, place, device, number) && has_room(job)) {
        memmove(job->read + place + 1, job->read + place, (job->n_read - place) * sizeof *job->read);
        job->read[place] = (vvi_file_identity){device, number};
        job->n_read++;
    }
    pthread_mutex_unlock(&job->lock);
}

bool vvi_job_has_read(vv_job *job, uint64_t device, uint64_t number)
{
    if (!job)
        return false;
    pthread_mutex_lock(&job->lock);
    const bool found = is_read(job, place_of_read(job, device, number), device, number);
    pthread_mutex_unlock(&job->lock);
    return found;
}

void vvi_job_listen_reads(vv_job *job, vvi_read_listener *fn, void *user)
{
    job->on_read = fn;
    job->on_read_user = user;
}

void vvi_job_tell_read(vv_job *job, const char *path)
{
    if (!job || !job->on_read)
        return;
    pthread_mutex_lock(&job->lock);
    job->on_read(job->on_read_user, path);
    pthread_mutex_unlock(&job->lock);
}

void vvi_job_count_writes(vv_job *job, vvi_write_counter *fn, void *user)
{
    job->on_write = fn;
    job->on_write_user = user;
}

vv_status vvi_job_count_write(vv_job *job, uint64_t bytes)
{
    return job && job->on_write ? job->on_write(job->on_write_user, bytes) : VV_OK;
}

void vvi_job_listen_warnings(vv_job *job, vv_log_fn *fn, void *user)
{
    job->on_warning = fn;
    job->on_warning_user = user;
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

void vvi_job_set_urgent(vv_job *job)
{
    if (job)
        job->urgent = true;
}

void vvi_job_set_modest(vv_job *job)
{
    if (job)
        job->modest = true;
}

void vvi_job_keep_fills(vv_job *job)
{
    if (job)
        job->keeps_fills = true;
}

void vvi_job_keep_existing(vv_job *job)
{
    if (job)
        job->keeps_existing = true;
}

bool vvi_job_keeps_existing(const vv_job *job)
{
    return job && job->keeps_existing;
}

void vvi_job_has_overwrite(vv_job *job)
{
    if (job)
        job->has_overwrite = true;
}

const char *vvi_job_or_overwrite(const vv_job *job)
{
    return job && job->has_overwrite ? ", or give --overwrite" : "";
}

bool vvi_job_keeps_fills(const vv_job *job)
{
    return job && job->keeps_fills;
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

static bool is_listened_to(const vv_job *job)
{
    return job && job->progress && atomic_load_explicit(&job->hushed, memory_order_relaxed) == 0;
}

void vvi_job_hush(vv_job *job, int change)
{
    if (job)
        atomic_fetch_add(&job->hushed, change);
}

void vvi_job_begin_stage(vv_job *job, const char *stage)
{
    if (!is_listened_to(job) || !stage || pthread_mutex_trylock(&job->lock) != 0)
        return; /* nobody listens, or the listener itself has begun work in this job */
    begin_stage(job, stage, vvi_os_seconds());
    pthread_mutex_unlock(&job->lock);
}

void vvi_job_report(vv_job *job, const char *stage, const _Atomic uint64_t *done, uint64_t total)
{
    if (!is_listened_to(job) || !stage || pthread_mutex_trylock(&job->lock) != 0)
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

bool vvi_job_safe(const vv_job *job)
{
    const vv_runtime *runtime = vv_job_runtime(job);
    return runtime && runtime->safe;
}

bool vvi_job_contains(const vv_job *job)
{
    const vv_runtime *runtime = vv_job_runtime(job);
    return runtime && runtime->contain;
}

void vvi_job_lend_room(vv_job *job, void *room, size_t bytes)
{
    job->room_bytes = bytes;
    atomic_store(&job->room, room);
}

void *vvi_job_take_room(vv_job *job, size_t bytes)
{
    return job && bytes == job->room_bytes ? atomic_exchange(&job->room, NULL) : NULL;
}

bool vvi_job_has_cleared(vv_job *job, const char *folder)
{
    const uint64_t hash = vvi_hash(folder, strlen(folder), 1);
    return job && atomic_exchange(&job->cleared, hash) == hash;
}

void vvi_job_lend_file(vv_job *job, const char *path, int file, int folder)
{
    free(job->lent.path);
    job->lent.path = vvi_strdup(path); /* without memory nothing is lent, and the lock refuses */
    job->lent.file = file;
    job->lent.folder = folder;
}

static bool is_lent(const vv_job *job, const char *path)
{
    return job && job->lent.path && strcmp(job->lent.path, path) == 0;
}

int vvi_job_lent_file(const vv_job *job, const char *path)
{
    return is_lent(job, path) ? job->lent.file : -1;
}

int vvi_job_lent_folder(const vv_job *job, const char *path)
{
    return is_lent(job, path) ? job->lent.folder : -1;
}

void vvi_job_lend_spares(vv_job *job, const int spares[VVI_SPARES])
{
    memcpy(job->lent.spare, spares, sizeof job->lent.spare);
    job->lent.n_spares = VVI_SPARES;
}

int vvi_job_take_spare(vv_job *job)
{
    int spare = -1;
    if (!job || !job->lent.n_spares)
        return -1;
    pthread_mutex_lock(&job->lock);
    while (job->lent.n_spares > 0 && spare < 0)
        spare = job->lent.spare[--job->lent.n_spares];
    pthread_mutex_unlock(&job->lock);
    return spare;
}

const char *vvi_job_import_program(const vv_job *job)
{
    const vv_runtime *runtime = vv_job_runtime(job);
    return runtime ? runtime->import_program : NULL;
}

vv_log_level vvi_job_log_level(const vv_job *job)
{
    const vv_runtime *runtime = vv_job_runtime(job);
    const vv_log_level level = runtime && runtime->log.fn ? runtime->log.level : VV_LOG_ERROR;
    return job && job->on_warning && level < VV_LOG_WARNING ? VV_LOG_WARNING : level;
}

static void tell_warning(const vv_job *job, vv_log_level level, const char *component, const char *text)
{
    pthread_mutex_t *lock = (pthread_mutex_t *)(void *)&((vv_job *)(void *)job)->lock; /* what is said changes no job */
    pthread_mutex_lock(lock);
    job->on_warning(job->on_warning_user, level, component, text);
    pthread_mutex_unlock(lock);
}

/* Text of any length below 2 KiB to the runtime's log. */
static void log_text(const vv_job *job, vv_log_level level, const char *component, const char *format, va_list args)
    VV_PRINTF(4, 0);
static void log_text(const vv_job *job, vv_log_level level, const char *component, const char *format, va_list args)
{
    vv_runtime *runtime = vv_job_runtime(job);
    const bool logs = runtime && runtime->log.fn && level <= runtime->log.level;
    const bool tells = job && job->on_warning && level <= VV_LOG_WARNING;
    if (!logs && !tells)
        return;
    char text[2048];
    vsnprintf(text, sizeof text, format, args);
    vvi_text_clean(text);
    if (tells)
        tell_warning(job, level, component, text);
    if (!logs)
        return;
    pthread_mutex_lock(&runtime->log.lock);
    runtime->log.fn(runtime->log.user, level, component, text);
    pthread_mutex_unlock(&runtime->log.lock);
}

void vvi_log(const vv_job *job, vv_log_level level, const char *component, const char *format, ...)
{
    va_list args;
    va_start(args, format);
    log_text(job, level, component, format, args);
    va_end(args);
}

/* A volume that is read slab by slab is damaged in many of them. */
static bool is_news(vv_job *job, const char *text)
{
    const uint64_t hash = vvi_hash(text, strlen(text), 0);
    return !job || atomic_exchange(&job->told[hash % (sizeof job->told / sizeof *job->told)], hash) != hash;
}

static void warn_once(vv_job *job, const char *component, const char *format, va_list args) VV_PRINTF(3, 0);
static void warn_once(vv_job *job, const char *component, const char *format, va_list args)
{
    char text[2048];
    vsnprintf(text, sizeof text, format, args);
    if (is_news(job, text))
        vvi_log(job, VV_LOG_WARNING, component, "%s", text);
}

void vvi_job_warn(vv_job *job, const char *component, const char *format, ...)
{
    va_list args;
    va_start(args, format);
    warn_once(job, component, format, args);
    va_end(args);
}

void vvi_job_damage(vv_job *job, const char *component, const char *format, ...)
{
    va_list args;
    va_start(args, format);
    warn_once(job, component, format, args);
    va_end(args);
    vvi_job_mark_damaged(job);
}

void vvi_job_mark_damaged(vv_job *job)
{
    if (job)
        atomic_store(&job->damaged, true);
}

bool vv_job_damaged(const vv_job *job)
{
    return job && atomic_load(&job->damaged);
}
