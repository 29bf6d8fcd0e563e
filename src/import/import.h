/** @file
 * Files that are read by the import program (vv_runtime_options.safe and .contain):
 * docs/decisions/0009-import-program.md.
 */
#ifndef VVI_IMPORT_H
#define VVI_IMPORT_H
#include "io/notes.h"

typedef struct vvi_import vvi_import;

/** What a header says: info, format and notes, all checked as if the header itself had been read here. source: the
 * same file, of which no more than its first bytes were looked at; it outlives the import. NULL: nothing of the file is
 * touched here, and no samples are mapped. */
vv_status vvi_import_open(vvi_import **out, vv_field_info *info_out, const vv_format **format_out, const char *path,
                          vv_source *source, const vv_read_options *options, vv_notes *notes, vv_job *job);
/** Samples of a frame and box that are known to be in info, in memory that the import program can no longer change. */
vv_status vvi_import_read(vv_field **out, vvi_import *import, const vv_field_info *info, int64_t frame,
                          const vv_box *region, vv_job *job);
/** vvi_file_make_repeatable(), when the first samples are asked for. */
void vvi_import_make_repeatable(vvi_import *import);
/** vvi_file_follow(), from the next read on. */
void vvi_import_follow(vvi_import *import, unsigned follow);
/** Whether samples may come mapped. */
bool vvi_import_mappable(const vvi_import *import);
void vvi_import_close(vvi_import *import); /* NULL is fine */
/** For the import program itself: whether `data` are bytes of the file as they lie, and where. */
bool vvi_file_mapped_at(const vv_file *file, const void *data, uint64_t *offset_out);
#endif
