#include "core/memory.h"
#include "core/cache.h"
#include "core/os.h"
#include "core/runtime.h"
#include "core/status.h"
#include "core/units.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { HEADER_BYTES = 64, MAP_FROM_BYTES = 8 << 20, ASK_MACHINE_FROM_BYTES = 16 << 20 };
#define LIVE UINT64_C(0x564f4c5649532121)

/* Stands in front of each allocation. */
typedef struct header {
    uint64_t live;       /* LIVE until it is freed */
    vv_runtime *runtime; /* holds it; NULL: uncounted */
    size_t bytes;        /* that the caller asked for */
    size_t total;        /* with the header, as it is counted and mapped */
    vvi_memory_tag tag;
    bool mapped;
} header;
_Static_assert(sizeof(header) <= HEADER_BYTES, "the header fits in front of an aligned block");

/* Sanitizers watch the heap, not maps. */
#if defined(__SANITIZE_ADDRESS__)
static const bool may_map = false;
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(memory_sanitizer)
static const bool may_map = false;
#else
static const bool may_map = true;
#endif
#else
static const bool may_map = true;
#endif

/* Failing on purpose -------------------------------------------------------------------------------------------- */

/* 0: off; 1: every allocation fails; n: n - 1 more succeed. Process-wide because workers must fail too; tests only. */
static _Atomic int64_t fail_countdown;

void vvi_alloc_fail_after(int64_t n)
{
    atomic_store(&fail_countdown, n);
}

static bool fails_on_purpose(void)
{
    int64_t n = atomic_load_explicit(&fail_countdown, memory_order_relaxed);
    while (n > 1)
        if (atomic_compare_exchange_weak(&fail_countdown, &n, n - 1))
            return false;
    return n == 1;
}

void *vvi_calloc(size_t n, size_t size)
{
    return fails_on_purpose() ? NULL : calloc(n ? n : 1, size ? size : 1);
}

void *vvi_realloc_plain(void *memory, size_t bytes)
{
    return fails_on_purpose() ? NULL : realloc(memory, bytes ? bytes : 1);
}

char *vvi_strdup(const char *text)
{
    return fails_on_purpose() ? NULL : strdup(text);
}

char *vvi_asprintf(const char *format, ...)
{
    char *text = NULL;
    va_list args;
    va_start(args, format);
    const int n = fails_on_purpose() ? -1 : vasprintf(&text, format, args);
    va_end(args);
    return n < 0 ? NULL : text;
}

/* Accounting ---------------------------------------------------------------------------------------------------- */

/* Why this thread's last vvi_alloc gave nothing: what vv_fail_memory() tells. limit 0: the system had none. */
static _Thread_local struct {
    uint64_t limit, used;
    size_t bytes;
} refused;

static bool refuse(size_t bytes, uint64_t limit, uint64_t used)
{
    refused.bytes = bytes;
    refused.limit = limit;
    refused.used = used;
    return false;
}

static void raise_peak(vvi_account *account, uint64_t used)
{
    uint64_t peak = atomic_load_explicit(&account->peak, memory_order_relaxed);
    while (used > peak && !atomic_compare_exchange_weak(&account->peak, &peak, used))
        ;
}

static bool try_charge(vvi_account *account, uint64_t total)
{
    uint64_t used = atomic_load(&account->used);
    do {
        if (total > account->limit || used > account->limit - total)
            return false;
    } while (!atomic_compare_exchange_weak(&account->used, &used, used + total));
    raise_peak(account, used + total);
    return true;
}

/* Counts `total` bytes, shedding the cache when they would not fit. */
static bool charge(vv_runtime *runtime, size_t total, vvi_memory_tag tag)
{
    vvi_account *account = &runtime->account;
    bool fits = try_charge(account, total);
    while (!fits && total <= account->limit && vvi_cache_shed(runtime, total) > 0)
        fits = try_charge(account, total);
    if (!fits)
        return refuse(total - HEADER_BYTES, account->limit, atomic_load(&account->used));
    atomic_fetch_add(&account->by_tag[tag], total);
    vvi_runtime_hold(runtime);
    return true;
}

static void uncharge(vv_runtime *runtime, size_t total, vvi_memory_tag tag)
{
    atomic_fetch_sub(&runtime->account.by_tag[tag], total);
    atomic_fetch_sub(&runtime->account.used, total);
    vvi_runtime_unhold(runtime);
}

/* Without a runtime one allocation may take half of the machine; small ones need not ask what that is. */
static bool fits_machine(size_t total)
{
    if (total < ASK_MACHINE_FROM_BYTES)
        return true;
    const uint64_t limit = vvi_os_memory_bytes() / 2;
    return total <= limit || refuse(total - HEADER_BYTES, limit, 0);
}

vv_status vv_fail_memory(size_t bytes)
{
    char need[32], limit[32], used[32];
    const bool by_limit = refused.limit > 0 && refused.bytes == bytes;
    vvi_print_bytes(need, bytes);
    vvi_print_bytes(limit, refused.limit);
    vvi_print_bytes(used, refused.used);
    refused.limit = 0;
    if (!by_limit)
        return vv_fail(VV_E_MEMORY, "needs %s more memory than the system has", need);
    return vv_fail(VV_E_LIMIT, "needs %s more memory, but %s of the limit of %s are in use; give a higher --memory",
                   need, used, limit);
}

/* Allocations --------------------------------------------------------------------------------------------------- */

static header *header_of(void *memory)
{
    header *h = (header *)((char *)memory - HEADER_BYTES);
    vvi_check(h->live == LIVE);
    return h;
}

static bool total_size(size_t *total_out, size_t bytes)
{
    if (bytes > SIZE_MAX - 2 * HEADER_BYTES)
        return false;
    *total_out = (bytes + 2 * HEADER_BYTES - 1) / HEADER_BYTES * HEADER_BYTES;
    return true;
}

static void *take_block(size_t total, bool mapped, bool zeroed)
{
    if (fails_on_purpose())
        return NULL;
    if (mapped)
        return vvi_os_map(total);
    void *block = aligned_alloc(HEADER_BYTES, total);
    if (block && zeroed)
        memset(block, 0, total);
    return block;
}

static void *allocate(vv_job *job, size_t bytes, vvi_memory_tag tag, bool zeroed)
{
    vv_runtime *runtime = vv_job_runtime(job);
    size_t total;
    refuse(bytes, 0, 0);
    if (!total_size(&total, bytes) || !(runtime ? charge(runtime, total, tag) : fits_machine(total)))
        return NULL;
    const bool mapped = may_map && total >= MAP_FROM_BYTES;
    header *h = take_block(total, mapped, zeroed);
    if (!h) {
        if (runtime)
            uncharge(runtime, total, tag);
        return NULL;
    }
    *h = (header){.live = LIVE, .runtime = runtime, .bytes = bytes, .total = total, .tag = tag, .mapped = mapped};
    return (char *)h + HEADER_BYTES;
}

void *vvi_alloc(vv_job *job, size_t bytes, vvi_memory_tag tag)
{
    return allocate(job, bytes, tag, false);
}

void *vvi_alloc_zeroed(vv_job *job, size_t bytes, vvi_memory_tag tag)
{
    return allocate(job, bytes, tag, true);
}

void *vvi_realloc(vv_job *job, void *memory, size_t bytes, vvi_memory_tag tag)
{
    void *moved = vvi_alloc(job, bytes, tag);
    if (!memory || !moved)
        return moved;
    const size_t old_bytes = header_of(memory)->bytes;
    memcpy(moved, memory, old_bytes < bytes ? old_bytes : bytes);
    vvi_free(memory);
    return moved;
}

void vvi_free(void *memory)
{
    if (!memory)
        return;
    header *h = header_of(memory);
    const header was = *h;
    h->live = 0;
    if (was.mapped)
        vvi_os_unmap(h, was.total);
    else
        free(h);
    if (was.runtime)
        uncharge(was.runtime, was.total, was.tag);
}

/* Planning ------------------------------------------------------------------------------------------------------ */

/* A round number of binary units that is enough: "4G". */
static void print_enough(char out[32], uint64_t bytes)
{
    const uint64_t mib = UINT64_C(1) << 20, gib = UINT64_C(1) << 30;
    if (bytes < gib)
        snprintf(out, 32, "%lluM", (unsigned long long)((bytes + mib - 1) / mib));
    else
        snprintf(out, 32, "%lluG", (unsigned long long)((bytes / gib) + 1));
}

vv_status vvi_memory_plan(vv_job *job, uint64_t bytes, const char *what)
{
    vv_runtime *runtime = vv_job_runtime(job);
    const uint64_t limit = runtime ? runtime->account.limit : vvi_os_memory_bytes() / 2;
    uint64_t used = runtime ? atomic_load(&runtime->account.used) : 0;
    while (bytes <= limit && used > limit - bytes && runtime && vvi_cache_shed(runtime, used - (limit - bytes)) > 0)
        used = atomic_load(&runtime->account.used);
    if (bytes <= limit && used <= limit - bytes)
        return VV_OK;
    char need[32], most[32], held[32], enough[32];
    vvi_print_bytes(need, bytes);
    vvi_print_bytes(most, limit);
    vvi_print_bytes(held, used);
    print_enough(enough, bytes + used < bytes ? UINT64_MAX : bytes + used);
    if (used > 0)
        return vv_fail(VV_E_LIMIT,
                       "%s needs %s, but %s of the limit of %s are in use; give --memory %s or use less data", what,
                       need, held, most, enough);
    return vv_fail(VV_E_LIMIT, "%s needs %s, the limit is %s; give --memory %s or use less data", what, need, most,
                   enough);
}

uint64_t vvi_memory_by_tag(const vv_runtime *runtime, vvi_memory_tag tag)
{
    return atomic_load(&runtime->account.by_tag[tag]);
}

vv_status vvi_mul_size(size_t *out, size_t a, size_t b)
{
    if (__builtin_mul_overflow(a, b, out))
        return vv_fail(VV_E_LIMIT, "%zu x %zu is more than fits in memory", a, b);
    return VV_OK;
}

vv_status vvi_mul3_size(size_t *out, size_t a, size_t b, size_t c)
{
    size_t ab;
    if (__builtin_mul_overflow(a, b, &ab) || __builtin_mul_overflow(ab, c, out))
        return vv_fail(VV_E_LIMIT, "%zu x %zu x %zu is more than fits in memory", a, b, c);
    return VV_OK;
}
