/* Asking before long work; declared in memory.h. */
#include "core/cache.h"
#include "core/os.h"
#include "core/runtime.h"
#include "core/status.h"
#include "core/units.h"
#include <string.h>

#include <inttypes.h>
#include <stdio.h>

/* A round size that is enough, as one types it: "700M", "4G". */
static void print_enough(char out[32], uint64_t bytes)
{
    const uint64_t mib = UINT64_C(1) << 20, gib = UINT64_C(1) << 30;
    if (bytes < gib)
        snprintf(out, 32, "%" PRIu64 "M", bytes / mib + 1);
    else
        snprintf(out, 32, "%" PRIu64 "G", bytes / gib + 1);
}

/* What would need less: of a picture its size is to blame. */
static const char *advice(const char *what)
{
    return strcmp(what, "the picture") == 0 || strcmp(what, "an image") == 0 ? "make it smaller" : "use less data";
}

static vv_status fail_plan(const char *what, uint64_t bytes, uint64_t limit, uint64_t used)
{
    char need[32], most[32], held[32], enough[32];
    vvi_print_bytes(need, bytes);
    vvi_print_bytes(most, limit);
    vvi_print_bytes(held, used);
    print_enough(enough, bytes > UINT64_MAX - used ? UINT64_MAX : bytes + used);
    if (bytes > limit)
        return vv_fail(VV_E_LIMIT, "%s needs %s, the limit is %s; give --memory %s or %s", what, need, most, enough,
                       advice(what));
    return vv_fail(VV_E_LIMIT, "%s needs %s, but %s of the limit of %s are in use; give --memory %s or %s", what, need,
                   held, most, enough, advice(what));
}

static bool fits(uint64_t bytes, uint64_t limit, uint64_t used)
{
    return bytes <= limit && used <= limit - bytes;
}

vv_status vvi_memory_plan(vv_job *job, uint64_t bytes, const char *what)
{
    vv_runtime *runtime = vv_job_runtime(job);
    if (!runtime && bytes < VVI_ASK_MACHINE_FROM_BYTES)
        return VV_OK;
    const uint64_t limit = runtime ? runtime->account.limit : vvi_os_memory_bytes() / 2;
    uint64_t used = runtime ? vv_runtime_memory_used(runtime) : 0;
    while (runtime && bytes <= limit && used > limit - bytes && vvi_cache_shed(runtime, used - (limit - bytes)) > 0)
        used = vv_runtime_memory_used(runtime);
    return fits(bytes, limit, used) ? VV_OK : fail_plan(what, bytes, limit, used);
}

vv_status vvi_mul_size(size_t *out, size_t a, size_t b)
{
    if (__builtin_mul_overflow(a, b, out))
        return vv_fail(VV_E_LIMIT, "%zu x %zu is more than any memory holds", a, b);
    return VV_OK;
}

vv_status vvi_mul3_size(size_t *out, size_t a, size_t b, size_t c)
{
    size_t ab;
    if (__builtin_mul_overflow(a, b, &ab) || __builtin_mul_overflow(ab, c, out))
        return vv_fail(VV_E_LIMIT, "%zu x %zu x %zu is more than any memory holds", a, b, c);
    return VV_OK;
}
