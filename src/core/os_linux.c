#include "core/os.h"

#include <math.h>
#include <pthread.h>
#include <sched.h>
#include <stdio.h>
#include <sys/mman.h>
#include <time.h>
#include <unistd.h>

double vvi_os_seconds(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

void vvi_os_name_thread(const char *name)
{
    pthread_setname_np(pthread_self(), name);
}

static vvi_cgroup_limits own_cgroup(void)
{
    return vvi_cgroup_read("/proc/self/cgroup", "/sys/fs/cgroup");
}

int vvi_os_cores(void)
{
    cpu_set_t set;
    CPU_ZERO(&set);
    /* More cores than fit in a cpu_set_t is the error here; then all that are online count. */
    const bool known = sched_getaffinity(0, sizeof set, &set) == 0;
    const double cores = known ? CPU_COUNT(&set) : (double)sysconf(_SC_NPROCESSORS_ONLN);
    return (int)fmax(1, fmin(cores, ceil(own_cgroup().cores)));
}

uint64_t vvi_os_memory_bytes(void)
{
    const uint64_t machine = (uint64_t)sysconf(_SC_PHYS_PAGES) * (uint64_t)sysconf(_SC_PAGESIZE);
    const uint64_t group = own_cgroup().memory_bytes;
    return group < machine ? group : machine;
}

/* The addresses begin where a huge page may, so that a system whose policy is to use them can: take more, give back
 * what is around. They are not asked for: see docs/decisions/0005-huge-pages.md. */
void *vvi_os_map(size_t bytes)
{
    const size_t huge = (size_t)2 << 20;
    const size_t page = (size_t)sysconf(_SC_PAGESIZE);
    const size_t kept = (bytes + page - 1) / page * page;
    char *around = mmap(NULL, kept + huge, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (around == MAP_FAILED)
        return NULL;
    const size_t before = (huge - (uintptr_t)around % huge) % huge;
    if (before > 0)
        munmap(around, before);
    munmap(around + before + kept, huge - before);
    return around + before;
}

void *vvi_os_remap(void *memory, size_t old_bytes, size_t bytes)
{
    void *moved = mremap(memory, old_bytes, bytes, MREMAP_MAYMOVE);
    return moved == MAP_FAILED ? NULL : moved;
}

void vvi_os_unmap(void *memory, size_t bytes)
{
    munmap(memory, bytes);
}
