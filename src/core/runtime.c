#include "core/runtime.h"
#include "core/cpu_select.h"
#include "core/job.h"
#include "core/limits.h"
#include "core/os.h"
#include "core/status.h"

#include <stdlib.h>
#include <string.h>
#include <volvis/sys/registry.h>

enum { MAX_THREADS = 256, KEPT_SHARE = 32 }; /* of the machine's memory */

void vv_runtime_options_init(vv_runtime_options *options, size_t size)
{
    const vv_runtime_options defaults = {.size = size, .log_level = VV_LOG_WARNING, .contain = true};
    memset(options, 0, size);
    memcpy(options, &defaults, size < sizeof defaults ? size : sizeof defaults);
}

/* What this library knows of the caller's options; the rest have their defaults. */
static vv_status read_options(vv_runtime_options *out, const vv_runtime_options *options)
{
    vv_runtime_options_init(out, sizeof *out);
    if (!options)
        return VV_OK;
    if (options->size < offsetof(vv_runtime_options, threads))
        return vv_fail(VV_E_ARGUMENT, "runtime options: call vv_runtime_options_init() first");
    memcpy(out, options, options->size < sizeof *out ? options->size : sizeof *out);
    if (out->threads < 0 || out->threads > MAX_THREADS)
        return vv_fail(VV_E_ARGUMENT, "runtime options: threads is %d; expected 0 to %d", out->threads, MAX_THREADS);
    return VV_OK;
}

static int default_threads(void)
{
    const int n = vvi_os_cores();
    return n < MAX_THREADS ? n : MAX_THREADS;
}

static vv_status init_log(vvi_logger *log, const vv_runtime_options *options)
{
    pthread_mutexattr_t attributes;
    *log = (vvi_logger){.fn = options->log, .user = options->log_user, .level = options->log_level};
    if (pthread_mutexattr_init(&attributes) != 0)
        return vv_fail_memory(sizeof attributes);
    pthread_mutexattr_settype(&attributes, PTHREAD_MUTEX_RECURSIVE);
    const int failed = pthread_mutex_init(&log->lock, &attributes);
    pthread_mutexattr_destroy(&attributes);
    return failed ? vv_fail_memory(sizeof log->lock) : VV_OK;
}

/* On failure nothing is left to finish. */
static vv_status init_parts(vv_runtime *runtime, const vv_runtime_options *options)
{
    vv_status st = init_log(&runtime->log, options);
    if (st != VV_OK)
        return st;
    if ((st = vvi_pool_init(&runtime->pool)) != VV_OK)
        goto no_pool;
    if ((st = vvi_cache_init(&runtime->cache)) != VV_OK)
        goto no_cache;
    if ((st = vvi_places_init(&runtime->places)) != VV_OK)
        goto no_places;
    if (pthread_mutex_init(&runtime->kept.lock, NULL) == 0)
        return VV_OK;
    st = vv_fail_memory(sizeof runtime->kept.lock);
    vvi_places_finish(&runtime->places);
no_places:
    vvi_cache_finish(&runtime->cache);
no_cache:
    vvi_pool_finish(&runtime->pool);
no_pool:
    pthread_mutex_destroy(&runtime->log.lock);
    return st;
}

vv_status vv_runtime_new(vv_runtime **out, const vv_runtime_options *options)
{
    vv_runtime_options known;
    vv_limits limits;
    uint32_t cpu;
    vv_status st;
    *out = NULL;
    if ((st = read_options(&known, options)) != VV_OK || (st = vvi_limits_read(&limits, known.limits)) != VV_OK ||
        (st = vvi_cpu_select(&cpu, known.cpu)) != VV_OK)
        return st;
    vv_runtime *runtime = vvi_calloc(1, sizeof *runtime);
    if (!runtime)
        return vv_fail_memory(sizeof *runtime);
    if (known.import_program && !(runtime->import_program = vvi_strdup(known.import_program))) {
        free(runtime);
        return vv_fail_memory(strlen(known.import_program));
    }
    runtime->registry = known.registry ? known.registry : vv_registry_builtin();
    if (known.more && (st = vvi_registry_join(&runtime->joined, runtime->registry, known.more)) != VV_OK) {
        free(runtime->import_program);
        free(runtime);
        return st;
    }
    runtime->registry = runtime->joined ? runtime->joined : runtime->registry;
    if ((st = init_parts(runtime, &known)) != VV_OK) {
        free(runtime->joined);
        free(runtime->import_program);
        free(runtime);
        return st;
    }
    atomic_init(&runtime->refs, 1);
    atomic_init(&runtime->holds, 1);
    runtime->threads = known.threads ? known.threads : default_threads();
    runtime->cpu = cpu;
    runtime->allow_outside = known.allow_outside;
    runtime->safe = known.safe;
    runtime->contain = known.contain;
    runtime->limits = limits;
    runtime->keep_bytes = vvi_os_memory_bytes() / KEPT_SHARE;
    runtime->account.limit = known.memory_bytes ? known.memory_bytes : vvi_os_memory_bytes() / 2;
    *out = runtime;
    return VV_OK;
}

vv_runtime *vv_runtime_retain(vv_runtime *runtime)
{
    if (runtime)
        atomic_fetch_add(&runtime->refs, 1);
    return runtime;
}

void vv_runtime_release(vv_runtime *runtime)
{
    if (!runtime || atomic_fetch_sub(&runtime->refs, 1) != 1)
        return;
    vvi_pool_finish(&runtime->pool);
    vvi_cache_clear(runtime);
    vvi_runtime_unhold(runtime);
}

void vvi_runtime_hold(vv_runtime *runtime)
{
    atomic_fetch_add(&runtime->holds, 1);
}

void vvi_runtime_unhold(vv_runtime *runtime)
{
    if (atomic_fetch_sub(&runtime->holds, 1) != 1)
        return;
    vvi_kept_drop(&runtime->kept);
    pthread_mutex_destroy(&runtime->kept.lock);
    vvi_places_finish(&runtime->places);
    vvi_cache_finish(&runtime->cache);
    pthread_mutex_destroy(&runtime->log.lock);
    free(runtime->joined);
    free(runtime->import_program);
    free(runtime);
}

int vv_runtime_threads(const vv_runtime *runtime)
{
    return runtime->threads;
}

uint64_t vv_runtime_memory_limit(const vv_runtime *runtime)
{
    return runtime->account.limit;
}

uint64_t vv_runtime_memory_used(const vv_runtime *runtime)
{
    return atomic_load(&runtime->account.used);
}

uint64_t vv_runtime_memory_peak(const vv_runtime *runtime)
{
    return atomic_load(&runtime->account.peak);
}

const char *vv_runtime_isa(const vv_runtime *runtime)
{
    return vvi_cpu_name(runtime->cpu);
}

const struct vv_registry *vv_runtime_registry(const vv_runtime *runtime)
{
    return runtime->registry;
}
