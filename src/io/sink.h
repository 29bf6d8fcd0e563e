/** @file
 * Output that appears whole or not at all: written beside the target, synced, renamed.
 */
#ifndef VVI_IO_SINK_H
#define VVI_IO_SINK_H
#include "core/status.h"
#include <stdarg.h>
#include <volvis/sys/registry.h>

/** "-" is standard output. */
vv_status vvi_sink_open(vv_sink **out, const char *path, vv_job *job);
/** What is written stays in memory until vvi_sink_take(), which takes the place of commit. */
vv_status vvi_sink_open_memory(vv_sink **out, const char *name, vv_job *job);
/** All that was written, for vvi_free(); the sink is gone afterwards in any case. */
vv_status vvi_sink_take(uint8_t **data_out, size_t *n_out, vv_sink *sink);
const char *vvi_sink_name(const vv_sink *sink);
vv_status vvi_sink_write(vv_sink *sink, const void *data, size_t n);
vv_status vvi_sink_printf(vv_sink *sink, const char *format, ...) VV_PRINTF(2, 3);
vv_status vvi_sink_vprintf(vv_sink *sink, const char *format, va_list args);
/** Bytes from here on are coded; VVI_CODING_NONE ends it; not one in another. level 0: the default. (vvi_coding of
 * io/source.h) */
vv_status vvi_sink_coding(vv_sink *sink, int coding, int level);
/** Bytes that have gone out, coded as they are; those that an encoder still holds are not among them. */
uint64_t vvi_sink_tell(const vv_sink *sink);
/** The file itself, open to read and write, for libraries that write by themselves; write nothing through the sink
 * then. It stays the sink's: never close it. What goes to a stream is a temporary file first. */
vv_status vvi_sink_file(int *fd_out, vv_sink *sink);
/** A folder instead of a file: vv_format.folder_file says which files may stand in one that is replaced. It is filled
 * with vvi_sink_put() alone. */
vv_status vvi_sink_open_folder(vv_sink **out, const char *path, int (*owns)(const char *name), vv_job *job);
/** How a text begins that marks a folder (vv_format.folder_file says 2) and lists names of files at its top as lines:
 * they belong to the output as well. */
#define VVI_FOLDER_LIST "VolVis wrote"
/** Bytes that are free on the disk of a folder; false where nobody knows. */
bool vvi_sink_room(const vv_sink *sink, uint64_t *out);
/** A whole file of a folder, by its name below it; folders on the way are made. Any thread. */
vv_status vvi_sink_put(vv_sink *sink, const char *name, const void *data, size_t n);
/** To the end of a file of a folder, which is made with the first bytes. Any thread, but one at a time for each file.
 */
vv_status vvi_sink_append(vv_sink *sink, const char *name, const void *data, size_t n);
/** n bytes of zeros on the disk of a folder, without a name: memory that is no burden, for what is too large for it.
 * Give it back with munmap(). */
vv_status vvi_sink_scratch(void **out, vv_sink *sink, size_t n);
/** Nothing is replaced that the job has read, nor what another header beside it names as its data, nor a second file
 * that is there without its first: VV_E_ARGUMENT instead. */
void vvi_sink_spare_inputs(vv_sink *sink);
/** A second file that belongs to the first (detached data): committed before it, under `name` in its folder. */
vv_status vvi_sink_beside(vv_sink **out, vv_sink *sink, const char *name);
/** The same for a name that stands on a line of the first: VV_E_ARGUMENT where it could not be read back from there. */
vv_status vvi_sink_beside_on_line(vv_sink **out, vv_sink *sink, const char *name);
/** Sync, close and rename; the sink is gone afterwards in any case. */
vv_status vvi_sink_commit(vv_sink *sink);
/** Throw away. NULL is fine. */
void vvi_sink_abandon(vv_sink *sink);
#endif
