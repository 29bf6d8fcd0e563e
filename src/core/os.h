/** @file
 * What core asks of the operating system. One file implements it for each system: os_linux.c.
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

/** Fresh zero pages, 64-byte aligned, on huge pages where there are any; NULL when there are none. */
void *vvi_os_map(size_t bytes);
/** Same contents at perhaps another address; NULL: nothing has changed. */
void *vvi_os_remap(void *memory, size_t old_bytes, size_t bytes);
void vvi_os_unmap(void *memory, size_t bytes);
#endif
