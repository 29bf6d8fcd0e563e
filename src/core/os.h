/** @file
 * What core asks of the operating system: os_linux.c, os_cgroup.c.
 */
#ifndef VVI_CORE_OS_H
#define VVI_CORE_OS_H
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/** Cores that this process may use (affinity and cgroup quota), at least 1. */
int vvi_os_cores(void);
/** Bytes of memory that this process may use: the machine's or its cgroup's (v1 or v2), whichever is less. */
uint64_t vvi_os_memory_bytes(void);
/** Seconds on a clock that never goes back. */
double vvi_os_seconds(void);
/** What debuggers and top call this thread; at most 15 bytes. */
void vvi_os_name_thread(const char *name);

/** Fresh zero pages, aligned to 2 MiB; NULL when there are none. */
void *vvi_os_map(size_t bytes);
/** The same contents, perhaps at another address; NULL: nothing has changed. */
void *vvi_os_remap(void *memory, size_t old_bytes, size_t bytes);
void vvi_os_unmap(void *memory, size_t bytes);

/** Limits of the cgroup that a process is in and of all above it. */
typedef struct vvi_cgroup_limits {
    uint64_t memory_bytes; /**< UINT64_MAX: none */
    double cores;          /**< infinity: none */
} vvi_cgroup_limits;
/** membership: a file as /proc/self/cgroup; root: a folder as /sys/fs/cgroup. What cannot be read limits nothing. */
vvi_cgroup_limits vvi_cgroup_read(const char *membership, const char *root);
#endif
