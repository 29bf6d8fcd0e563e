/** @file
 * What the import program may still do once it reads.
 */
#ifndef IMPORT_LOCK_H
#define IMPORT_LOCK_H
#include <volvis/runtime.h>

/** Before anything is known: no more rights by execve, no core file, no debugger, nothing but the socket and standard
 * input inherited, and the end of the process that started it is its own end. */
void import_lock_early(void);
/** Limits on address space, processor time, temporary files and descriptors. */
void import_lock_limits(const vv_limits *limits, uint64_t memory_bytes, int threads);
/** From here on only the system calls that readers make. False: this build or this kernel cannot. */
bool import_lock_calls(void);
#endif
