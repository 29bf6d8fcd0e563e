#define VVI_MAKES_FAILURES /* vv_fail_memory() is here */
#include "core/memory.h"
#include "core/cache.h"
#include "core/os.h"
#include "core/runtime.h"
#include "core/status.h"
#include "core/units.h"

#include <stdlib.h>
#include <string.h>

enum { HEADER_BYTES = 64, MAP_FROM_BYTES = 8 << 20 };
#define LIVE UINT64_C(0x564f4c5649532121)

/* Stands in front of each allocation. */
typedef struct header {
    uint64_t live;       /* LIVE until it is freed */
    vv_runtime *runtime; /* holds it; NULL: uncounted */
    size_t bytes;        /* that the caller asked for */
    size_t total;        /* with the header: what is counted, and what is mapped */
    vvi_memory_tag tag;
    bool mapped;
} header;
_Static_assert(sizeof(header) <= HEADER_BYTES, "the header fits in front of an aligned block");

/* Sanitizers watch the heap, not maps. */
#ifndef __has_feature
#define __has_feature(x) 0
#endif
#if defined(__SANITIZE_ADDRESS__) || __has_feature(address_sanitizer) || __has_feature(memory_sanitizer)
static const bool may_map = false;
#else
static const bool may_map = true;
#endif

/* Why this thread's last vvi_alloc that gave nothing did so; limit 0: the system had none. For vv_fail_memory(), whose
 * callers may have asked for several blocks before they look at what they got. */
static _Thread_local struct {
    size_t bytes;
    uint64_t limit, used;
} refused;

static bool refuse(size_t bytes, uint64_t limit, uint64_t used)
{
    refused.bytes = bytes;
    refused.limit = limit;
    refused.used = used;
    return false;
}

vv_status vv_fail_memory(size_t bytes)
{
    char need[32], limit[32], used[32];
    const bool by_limit = refused.limit > 0;
    vvi_print_bytes(need, by_limit && refused.bytes > bytes ? refused.bytes : bytes);
    vvi_print_bytes(limit, refused.limit);
    vvi_print_bytes(used, refused.used);
    refused.limit = 0;
    if (!by_limit)
        return vv_fail(VV_E_MEMORY, "needs %s of memory, which the system cannot provide", need);
    if (refused.used == 0)
        return vv_fail(VV_E_LIMIT, "needs %s of memory, and the limit is %s; give more with --memory", need, limit);
    return vv_fail(VV_E_LIMIT, "needs %s of memory, but %s of the limit of %s are in use; give more with --memory",
                   need, used, limit);
}

/* Accounting ---------------------------------------------------------------------------------------------------- */

static void raise_peak(vvi_account *account, uint64_t used)
{
    uint64_t peak = atomic_load_explicit(&account->peak, memory_order_relaxed);
    while (used > peak && !atomic_compare_exchange_weak(&account->peak, &peak, used))
        ;
}

static bool try_count(vvi_account *account, uint64_t total)
{
    uint64_t used = atomic_load(&account->used);
    do {
        if (total > account->limit || used > account->limit - total)
            return false;
    } while (!atomic_compare_exchange_weak(&account->used, &used, used + total));
    raise_peak(account, used + total);
    return true;
}

/* Counts `total` bytes, shedding the cache as long as they do not fit and it has something to give. */
static bool count(vv_runtime *runtime, size_t total, vvi_memory_tag tag)
{
    vvi_account *account = &runtime->account;
    while (!try_count(account, total)) {
        if (total > account->limit)
            return false;
        const uint64_t used = atomic_load(&account->used), room = account->limit - total;
        if (used > room && vvi_cache_shed(runtime, used - room) == 0)
            return false;
    }
    atomic_fetch_add(&account->by_tag[tag], total);
    return true;
}

static void uncount(vv_runtime *runtime, size_t total, vvi_memory_tag tag)
{
    atomic_fetch_sub(&runtime->account.by_tag[tag], total);
    atomic_fetch_sub(&runtime->account.used, total);
}

uint64_t vvi_memory_by_tag(const vv_runtime *runtime, vvi_memory_tag tag)
{
    return atomic_load(&runtime->account.by_tag[tag]);
}

/* Whether `total` bytes may be taken; they are counted then. Without a runtime one allocation may take half of the
 * machine; small ones need not ask how much that is. */
static bool admit(vv_runtime *runtime, size_t bytes, size_t total, vvi_memory_tag tag)
{
    if (runtime) {
        const vvi_account *account = &runtime->account;
        return count(runtime, total, tag) || refuse(bytes, account->limit, atomic_load(&account->used));
    }
    if (total < VVI_ASK_MACHINE_FROM_BYTES)
        return true;
    const uint64_t limit = vvi_os_memory_bytes() / 2;
    return total <= limit || refuse(bytes, limit, 0);
}

vv_status vvi_memory_take(vv_runtime **counted_in, vv_job *job, size_t bytes, vvi_memory_tag tag)
{
    vv_runtime *runtime = vv_job_runtime(job);
    *counted_in = NULL;
    if (!admit(runtime, bytes, bytes, tag))
        return vv_fail_memory(bytes);
    if (runtime)
        vvi_runtime_hold(runtime);
    *counted_in = runtime;
    return VV_OK;
}

void vvi_memory_give_back(vv_runtime *counted_in, size_t bytes, vvi_memory_tag tag)
{
    if (!counted_in)
        return;
    uncount(counted_in, bytes, tag);
    vvi_runtime_unhold(counted_in);
}

/* Allocations --------------------------------------------------------------------------------------------------- */

static header *header_of(void *memory)
{
    header *h = (header *)((char *)memory - HEADER_BYTES);
    vvi_check(h->live == LIVE);
    return h;
}

/* With the header, rounded up; 0 when there is no such number. */
static size_t total_bytes(size_t bytes)
{
    return bytes > SIZE_MAX - 2 * HEADER_BYTES ? 0 : (bytes + 2 * HEADER_BYTES - 1) / HEADER_BYTES * HEADER_BYTES;
}

static bool is_mapped(size_t total)
{
    return may_map && total >= MAP_FROM_BYTES;
}

/* Bytes that may be kept beside what is counted. */
static uint64_t room_to_keep(const vv_runtime *runtime)
{
    const vvi_account *account = &runtime->account;
    const uint64_t room = account->limit - atomic_load(&account->used);
    return room < runtime->keep_bytes ? room : runtime->keep_bytes;
}

static void *take_map(vv_runtime *runtime, size_t total, bool zeroed)
{
    void *kept = runtime ? vvi_kept_take(&runtime->kept, total, room_to_keep(runtime)) : NULL;
    if (kept && zeroed)
        memset(kept, 0, total);             /* a fraction of what a fault for each page would take */
    return kept ? kept : vvi_os_map(total); /* zero pages; nothing is touched */
}

static void free_map(vv_runtime *runtime, void *memory, size_t total)
{
    if (runtime)
        vvi_kept_give(&runtime->kept, memory, total, room_to_keep(runtime));
    else
        vvi_os_unmap(memory, total);
}

static void *take_block(vv_runtime *runtime, size_t total, bool zeroed)
{
    if (vvi_alloc_fails())
        return NULL;
    if (is_mapped(total))
        return take_map(runtime, total, zeroed);
    void *block = aligned_alloc(HEADER_BYTES, total);
    if (block && zeroed)
        memset(block, 0, total);
    return block;
}

static void *allocate(vv_job *job, size_t bytes, vvi_memory_tag tag, bool zeroed)
{
    vv_runtime *runtime = vv_job_runtime(job);
    const size_t total = total_bytes(bytes);
    if (total == 0)
        refuse(bytes, 0, 0);
    if (total == 0 || !admit(runtime, bytes, total, tag))
        return NULL;
    header *h = take_block(runtime, total, zeroed);
    if (!h) {
        refuse(bytes, 0, 0);
        if (runtime)
            uncount(runtime, total, tag);
        return NULL;
    }
    if (bytes >= refused.bytes)
        refused.limit = 0; /* there is room again */
    if (runtime)
        vvi_runtime_hold(runtime);
    *h = (header){LIVE, runtime, bytes, total, tag, is_mapped(total)};
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

void vvi_free(void *memory)
{
    if (!memory)
        return;
    header *h = header_of(memory);
    const header was = *h;
    h->live = 0;
    if (was.runtime)
        uncount(was.runtime, was.total, was.tag);
    if (was.mapped)
        free_map(was.runtime, h, was.total);
    else
        free(h);
    if (was.runtime)
        vvi_runtime_unhold(was.runtime);
}

/* Resizing ------------------------------------------------------------------------------------------------------ */

/* Pages are moved, not copied, and what grows is counted only once. NULL: nothing has changed. */
static void *resize_map(header *h, size_t bytes, size_t total)
{
    const size_t old_total = h->total;
    const vvi_memory_tag tag = h->tag;
    vv_runtime *runtime = h->runtime;
    if (total > old_total && !admit(runtime, bytes, total - old_total, tag))
        return NULL;
    header *moved = vvi_alloc_fails() ? NULL : vvi_os_remap(h, old_total, total);
    if (moved) {
        moved->bytes = bytes;
        moved->total = total;
    } else
        refuse(bytes, 0, 0);
    const size_t least = old_total < total ? old_total : total, most = old_total < total ? total : old_total;
    const bool grew_in_vain = !moved && total > old_total, shrank = moved && total < old_total;
    if (runtime && (grew_in_vain || shrank))
        uncount(runtime, most - least, tag);
    return moved ? (char *)moved + HEADER_BYTES : NULL;
}

void *vvi_realloc(vv_job *job, void *memory, size_t bytes, vvi_memory_tag tag)
{
    if (!memory)
        return vvi_alloc(job, bytes, tag);
    header *h = header_of(memory);
    const size_t total = total_bytes(bytes), old_bytes = h->bytes;
    void *moved = NULL;
    if (h->mapped && is_mapped(total) && h->runtime == vv_job_runtime(job) && h->tag == tag)
        moved = resize_map(h, bytes, total);
    else if ((moved = vvi_alloc(job, bytes, tag))) {
        memcpy(moved, memory, old_bytes < bytes ? old_bytes : bytes);
        vvi_free(memory);
    }
    return moved;
}

vv_status vvi_memory_is_there(size_t bytes)
{
    void *room = vvi_realloc_plain(NULL, bytes); /* not touched: it costs nothing */
    free(room);
    return room ? VV_OK : vv_fail_memory(bytes);
}
