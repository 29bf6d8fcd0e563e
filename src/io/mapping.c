/* A file that shrinks while it is mapped raises SIGBUS at the first touch of a page that is gone, in whatever thread
 * and library reads it. Nothing but a signal handler can answer that, and a handler belongs to the process: hence the
 * only mutable state of the library that is not owned by a runtime.
 *
 *   - A mapping installs the handler (a program that maps nothing never gets it) and remembers the one that was there
 *     before; so does a later mapping, when another handler has taken its place meanwhile.
 *   - Every mapping has a slot in a list that only grows; slots are used again and never freed, so that the handler may
 *     walk the list at any moment with plain atomic loads: it takes no lock and allocates nothing.
 *   - At a fault inside a slot's range the handler lays an anonymous page of zeros over the page that is gone, marks
 *     the mapping damaged, and returns: the read is repeated and finds zeros. vv_field_health() then tells the user.
 *   - A fault anywhere else goes to the previous handler, or to the default action when there was none.
 *
 * After the file's pages lies one anonymous page, so that vector loads may read past the last sample of a file that
 * ends at a page boundary. */
#include "io/mapping.h"
#include "core/memory.h"
#include "io/store.h"
#include <errno.h>
#include <pthread.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

struct vvi_mapping {
    atomic_uintptr_t begin, end; /* 0, 0: free. The handler reads begin last, so it never sees half a range */
    atomic_bool damaged;
    atomic_bool taken;
    struct vvi_mapping *next;
};

static _Atomic(struct vvi_mapping *) all_mappings;
#define ACTIONS_MOST 64
static struct sigaction previous_actions[ACTIONS_MOST]; /* written before n_actions counts them, never changed after */
static atomic_int n_actions;
static atomic_uint n_faults;
static atomic_uintptr_t page_bytes;
static pthread_mutex_t installing = PTHREAD_MUTEX_INITIALIZER;
static _Thread_local volatile sig_atomic_t passing_on;

static void end_by_default(void)
{
    /* The process ends as it would have without us: the faulting read is repeated without a handler. */
    const struct sigaction plain = {.sa_handler = SIG_DFL};
    sigaction(SIGBUS, &plain, NULL);
}

static void pass_on(int number, siginfo_t *info, void *context)
{
    const int n = atomic_load(&n_actions);
    const struct sigaction *previous = n > 0 ? &previous_actions[n - 1] : NULL;
    const bool plain = !previous || (!(previous->sa_flags & SA_SIGINFO) &&
                                     (previous->sa_handler == SIG_DFL || previous->sa_handler == SIG_IGN));
    if (plain || passing_on) { /* a handler that knows us may hand the fault back */
        end_by_default();
        return;
    }
    passing_on = 1;
    if (previous->sa_flags & SA_SIGINFO)
        previous->sa_sigaction(number, info, context);
    else
        previous->sa_handler(number);
    passing_on = 0;
}

static void on_bus_error(int number, siginfo_t *info, void *context)
{
    const int saved = errno;
    const uintptr_t address = (uintptr_t)info->si_addr;
    for (struct vvi_mapping *m = atomic_load(&all_mappings); m; m = m->next) {
        const uintptr_t end = atomic_load(&m->end), begin = atomic_load(&m->begin);
        if (begin == 0 || address < begin || address >= end)
            continue;
        const uintptr_t size = atomic_load(&page_bytes);
        void *page = (void *)(address & ~(size - 1));
        if (mmap(page, size, PROT_READ, MAP_PRIVATE | MAP_ANONYMOUS | MAP_FIXED, -1, 0) == MAP_FAILED)
            break;
        atomic_store(&m->damaged, true);
        atomic_fetch_add(&n_faults, 1);
        errno = saved;
        return;
    }
    errno = saved;
    pass_on(number, info, context);
}

/* At every mapping, because others may have put theirs in front of ours or in its place. */
static void install_handler(void)
{
    struct sigaction action = {.sa_sigaction = on_bus_error, .sa_flags = SA_SIGINFO | SA_ONSTACK}, now;
    sigemptyset(&action.sa_mask);
    pthread_mutex_lock(&installing);
    atomic_store(&page_bytes, (uintptr_t)sysconf(_SC_PAGESIZE));
    const int n = atomic_load(&n_actions);
    const bool ours =
        sigaction(SIGBUS, NULL, &now) == 0 && (now.sa_flags & SA_SIGINFO) && now.sa_sigaction == on_bus_error;
    if (!ours && n < ACTIONS_MOST) {
        previous_actions[n] = now;
        atomic_store(&n_actions, n + 1);
        sigaction(SIGBUS, &action, NULL);
    }
    pthread_mutex_unlock(&installing);
}

static struct vvi_mapping *take_slot(void)
{
    for (struct vvi_mapping *m = atomic_load(&all_mappings); m; m = m->next) {
        bool was_taken = false;
        if (atomic_compare_exchange_strong(&m->taken, &was_taken, true))
            return m;
    }
    /* Outlives every runtime, hence not counted in one. */
    struct vvi_mapping *m = calloc(1, sizeof *m);
    if (!m)
        return NULL;
    atomic_store(&m->taken, true);
    m->next = atomic_load(&all_mappings);
    while (!atomic_compare_exchange_weak(&all_mappings, &m->next, m)) {
    }
    return m;
}

/* Address space for the file and one page more, which stays anonymous zeros; then the file over its front. */
static void *map_with_guard(int fd, uint64_t offset, size_t n_file, size_t *n_all)
{
    const size_t page = atomic_load(&page_bytes), pages = (n_file + page - 1) / page * page;
    *n_all = pages + page;
    char *base = mmap(NULL, *n_all, PROT_READ, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    if (base == MAP_FAILED)
        return NULL;
    if (mmap(base, pages, PROT_READ, MAP_SHARED | MAP_FIXED, fd, (off_t)offset) != MAP_FAILED)
        return base;
    const int saved = errno;
    munmap(base, *n_all);
    errno = saved;
    return NULL;
}

vv_status vvi_mapping_new(vvi_mapping **out, const void **data_out, size_t *guard_out, int fd, uint64_t offset,
                          uint64_t n, const char *name, vv_job *job)
{
    *out = NULL;
    install_handler();
    const uint64_t skew = offset % atomic_load(&page_bytes);
    if (n == 0 || n > SIZE_MAX / 2)
        return vv_fail_at(VV_E_LIMIT, name, NULL, "%llu bytes cannot be mapped", (unsigned long long)n);
    struct vvi_mapping *m = take_slot();
    if (!m)
        return vv_fail_memory(sizeof *m);
    size_t n_all;
    char *base = map_with_guard(fd, offset - skew, (size_t)(n + skew), &n_all);
    if (!base) {
        const int error = errno;
        atomic_store(&m->taken, false);
        return vv_fail_at(VV_E_READ, name, NULL, "cannot be mapped: %s", strerror(error));
    }
    atomic_store(&m->damaged, false);
    atomic_store(&m->end, (uintptr_t)base + n_all);
    atomic_store(&m->begin, (uintptr_t)base);
    *out = m;
    *data_out = base + skew;
    *guard_out = n_all - (size_t)skew - (size_t)n;
    return VV_OK;
}

unsigned vvi_mapping_faults(void)
{
    return atomic_load(&n_faults);
}

vv_status vvi_mapping_check_since(unsigned faults)
{
    return vvi_mapping_faults() == faults
               ? VV_OK
               : vv_fail(VV_E_READ, "a file shrank or could no longer be read while it was in use; missing samples "
                                    "were taken as 0, so no result is given");
}

bool vvi_mapping_damaged(const vvi_mapping *mapping)
{
    return atomic_load(&((vvi_mapping *)(uintptr_t)mapping)->damaged);
}

void vvi_mapping_free(void *mapping)
{
    struct vvi_mapping *m = mapping;
    if (!m)
        return;
    const uintptr_t begin = atomic_load(&m->begin), end = atomic_load(&m->end);
    atomic_store(&m->begin, 0);
    atomic_store(&m->end, 0);
    munmap((void *)begin, end - begin);
    atomic_store(&m->taken, false);
}
