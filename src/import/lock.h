/** @file
 * What the import program may still do once it reads.
 */
#ifndef IMPORT_LOCK_H
#define IMPORT_LOCK_H
#include <volvis/runtime.h>
#include <volvis/sys/registry.h>

/** Before anything is known: no more rights by execve, no core file, no debugger, nothing but the socket and standard
 * input inherited, and the end of the process that started it is its own end. */
void import_lock_early(void);
/** Limits on address space, processor time, temporary files and descriptors. */
void import_lock_limits(const vv_limits *limits, uint64_t memory_bytes, int threads);
/** What is to be read. */
typedef struct import_file {
    const char *path, *format; /**< format: that was asked for; NULL: none */
    int descriptor;            /**< of the file or folder, as whoever asks has opened it; -1: it is opened here */
    bool confined;             /**< whoever asks reads in some places alone: links that came since lead nowhere */
} import_file;

/** Loads the libraries that the readers of this file may load by themselves, which they cannot once system calls are
 * locked. fd: of the file or folder; -1: none. */
void import_load_modules(const import_file *file, int fd, const vv_registry *registry);
/** From here on no file is opened but this one, if it is a folder those below it, what its format may name beside it,
 * and temporary files, which are open already; all are lent to the job. On the calling thread and those that it starts.
 * False: this kernel cannot (before 5.13, or turned off). */
bool import_lock_files(const import_file *file, vv_job *job, uint64_t files_most);
/** This build's sanitizers cannot live with locks. */
bool import_locks_nothing(void);
/** From here on only the system calls that readers make. False: this build or this kernel cannot. */
bool import_lock_calls(void);
#endif
