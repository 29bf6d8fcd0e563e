/** @file
 * Outputs that are folders: made beside the target under another name, renamed when they are whole. For sink.c alone.
 */
#ifndef VVI_IO_SINK_FOLDER_H
#define VVI_IO_SINK_FOLDER_H
#include "io/sink.h"

typedef struct vvi_sink_folder vvi_sink_folder;

/** owns: vv_format.folder_file. A folder that is there already is replaced when it is empty, or when all that is in it
 * belongs to an older output of the same kind; else it is an error, and nothing is touched. */
vv_status vvi_sink_folder_new(vvi_sink_folder **out, const char *path, int (*owns)(const char *name), vv_job *job);
/** A whole file by its name below the folder. Any thread. */
vv_status vvi_sink_folder_put(vvi_sink_folder *folder, const char *name, const void *data, size_t n);
/** Bytes that are free on its disk; false where nobody knows. */
bool vvi_sink_folder_room(const vvi_sink_folder *folder, uint64_t *out);
/** To the end of a file. One thread at a time for each. */
vv_status vvi_sink_folder_append(vvi_sink_folder *folder, const char *name, const void *data, size_t n);
/** n bytes of zeros in a file without a name, mapped: munmap() gives them back. */
vv_status vvi_sink_folder_scratch(void **out, vvi_sink_folder *folder, size_t n);
/** Sync and rename. Free it afterwards in any case. */
vv_status vvi_sink_folder_commit(vvi_sink_folder *folder);
/** What was not committed is removed. NULL is fine. */
void vvi_sink_folder_free(vvi_sink_folder *folder);
/** With all that is in it; links are not followed. */
void vvi_sink_remove_folder(const char *path);
/** In the names of folders that are being written, which nobody else gives: ".NAME.volvis.PROCESS-N.part". */
#define VVI_SINK_OURS ".volvis"
/** Temporary files and folders that programs which were killed left in the folder of an output, of whatever name: those
 * of processes that are no more, and that nobody has locked (where that cannot be known: older than an hour). Once for
 * each folder of a job. */
void vvi_sink_clear_leftovers(const char *path, vv_job *job);
/** The folder that a path lies in: a rename lasts only when that is on the disk too. Some file systems cannot sync
 * folders: then there is nothing to be done, and the file is whole. */
void vvi_sink_sync_parent(const char *path);
#endif
