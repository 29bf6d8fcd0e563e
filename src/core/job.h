/** @file
 * Work in a job: parallel loops, progress, cancel, log.
 */
#ifndef VVI_CORE_JOB_H
#define VVI_CORE_JOB_H
#include "core/status.h"
#include <volvis/runtime.h>
#include <volvis/sys/work.h>

typedef vv_work vvi_work; /* items of a parallel loop */

/** Runs items 0 .. n-1, this thread included, in any order and on any worker. The first failure by item number becomes
 * this thread's error; cancel gives VV_E_CANCELLED. Reductions belong per item, summed in item order by the caller.
 * Nested loops run on the calling worker alone. */
vv_status vvi_parallel_for(vv_job *job, const vvi_work *work, void *shared, size_t n_items);
/** Loops of this job have the helpers before those of others, which leave loops that yield; the thread that runs such a
 * loop goes on with a quarter of its time. Before the work begins. */
void vvi_job_set_urgent(vv_job *job);
/** All loops of this job yield, and for a tenth of a second after anything urgent have no helpers and a sixteenth of
 * the time. Before the work begins. */
void vvi_job_set_modest(vv_job *job);
/** Workers that a loop may use: scratch arrays by worker have this many. */
int vvi_job_threads(const vv_job *job);

/** VV_OK, or VV_E_CANCELLED with its text. Poll at least every 20 ms. Cheap. */
vv_status vvi_job_poll(const vv_job *job);
/** Until the same with -1 no progress is told, by nobody: work inside other work that is told already. */
void vvi_job_hush(vv_job *job, int change);
/** Serial work: how far it is. VV_E_CANCELLED when it should stop. */
vv_status vvi_job_progress(vv_job *job, const char *stage, uint64_t done, uint64_t total);

void vvi_log(const vv_job *job, vv_log_level level, const char *component, const char *format, ...) VV_PRINTF(4, 5);

/** A warning that is told once of the same job, however often it comes. */
void vvi_job_warn(vv_job *job, const char *component, const char *format, ...) VV_PRINTF(3, 4);
/** A part of what was read is missing: warns, and vv_job_damaged() from then on. `text`: place and what is missing. */
void vvi_job_damage(vv_job *job, const char *component, const char *format, ...) VV_PRINTF(3, 4);

/** Remembers that a file was read, by what the system calls it. Without memory for it nothing is remembered. */
void vvi_job_note_read(vv_job *job, uint64_t device, uint64_t number);
bool vvi_job_has_read(vv_job *job, uint64_t device, uint64_t number);

/** Whether this was asked of the same folder before, of all that were asked of the last. Without a job: never. */
bool vvi_job_has_cleared(vv_job *job, const char *folder);

/** Called with the path of a file or folder before it is opened to be read, whether it is there or not: from any
 * thread, one call at a time. What the import program opens by itself is not among them. */
typedef void vvi_read_listener(void *user, const char *path);
/** NULL: nobody listens any more. Set it while no work runs. */
void vvi_job_listen_reads(vv_job *job, vvi_read_listener *fn, void *user);
void vvi_job_tell_read(vv_job *job, const char *path);

/** Which values stand for none has been said, or that none does: no fill is looked for (grid/fill_value.h). */
void vvi_job_keep_fills(vv_job *job);
bool vvi_job_keeps_fills(const vv_job *job);

/** Counts what is written to files, before it is: so many bytes more, of a file VVI_FILE_LEAST at once. What it
 * refuses, with a sentence, is not written, and its target stays as it is. From any thread. */
typedef vv_status vvi_write_counter(void *user, uint64_t bytes);
/** A file takes no less of a disk, however few bytes it has: an entry, an inode, and many have a folder of their own.
 */
enum { VVI_FILE_LEAST = 8192 };
/** NULL: nobody counts. Set it while no work runs. */
void vvi_job_count_writes(vv_job *job, vvi_write_counter *fn, void *user);
vv_status vvi_job_count_write(vv_job *job, uint64_t bytes);

/** What it writes takes the place of nothing that is there, not even of what appears meanwhile: VV_E_WRITE instead. */
void vvi_job_keep_existing(vv_job *job);
bool vvi_job_keeps_existing(const vv_job *job);

/** Who asked has the word --overwrite: refusals to replace a file name it. */
void vvi_job_has_overwrite(vv_job *job);
/** ", or give --overwrite", or nothing: the end of such a sentence. */
const char *vvi_job_or_overwrite(const vv_job *job);

/** The registry of the job's runtime; the built-in one for NULL. */
const struct vv_registry *vvi_job_registry(const vv_job *job);
bool vvi_job_allow_outside(const vv_job *job);
/** Whether volume files are read by the import program, and which one when it is not the usual. */
bool vvi_job_safe(const vv_job *job);
/** Whether formats that are `contained` are. */
bool vvi_job_contains(const vv_job *job);
const char *vvi_job_import_program(const vv_job *job);
/** The most talkative level that anybody listens to. */
vv_log_level vvi_job_log_level(const vv_job *job);
/** The next field of this many bytes, guard included, takes its samples' memory from here; whoever lends it outlives
 * the field. NULL: no more. */
void vvi_job_lend_room(vv_job *job, void *room, size_t bytes);
/** The memory that was lent, once, when it is that large; else NULL. */
void *vvi_job_take_room(vv_job *job, size_t bytes);
/** A file that is opened already, and the folder that it lies in (-1: none), for whoever opens `path` or what lies
 * beside it; borrowed. */
void vvi_job_lend_file(vv_job *job, const char *path, int file, int folder);
/** The descriptor that was lent for a path; -1: none. */
int vvi_job_lent_file(const vv_job *job, const char *path);
/** That of the folder in which it lies; -1: none. */
int vvi_job_lent_folder(const vv_job *job, const char *path);
/** Nameless files that are open already, for whoever needs a temporary one; -1: none. */
enum { VVI_SPARES = 12 };
void vvi_job_lend_spares(vv_job *job, const int spares[VVI_SPARES]);
/** One of them, which is the caller's then; -1: there is none. */
int vvi_job_take_spare(vv_job *job);
/** vv_job_damaged() from now on; what is missing has been said. */
void vvi_job_mark_damaged(vv_job *job);
#endif
