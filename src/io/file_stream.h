/** @file
 * Files that are larger than memory, as fields that are read when they are asked for.
 */
#ifndef VVI_IO_FILE_STREAM_H
#define VVI_IO_FILE_STREAM_H
#include "grid/lazy.h"
#include "io/source.h"
#include <volvis/file.h>

/** One frame of a file, slab by slab. The file stays open as long as the field lives: close it later. Fields of one
 * file share one pool, since a file is read by one thread at a time. Packed data is unpacked once when slabs are asked
 * for in order, and again from its start when they are not. */
vv_status vvi_file_stream(vv_field **out, vv_file *file, int64_t frame, vvi_lazy_pool *pool, vv_job *job);
/** The same, by boxes of any form, of a file whose format has them (vv_format.boxes); the file is the field's from now
 * on, and is closed here where this fails. */
vv_status vvi_file_stream_boxes(vv_field **out, vv_file *file, int64_t frame, vv_job *job);
/** Whether it can be. */
bool vvi_file_has_boxes(const vv_file *file);
/** For whoever will read samples of a file more than once: what comes by a pipe is kept in a temporary file. Before the
 * first are read. */
vv_status vvi_file_make_repeatable(vv_file *file, vv_job *job);
/** From now on samples of these n values are read as NaN, and integers as floats that hold them. VV_E_ARGUMENT of
 * labels and colours, which are no amounts. */
vv_status vvi_file_leave_out(vv_file *file, const double *values, size_t n);
/** The stored numbers that it says are padding; false: it says nothing of it. */
bool vvi_file_padding(double out[2], const vv_file *file);
/** The field of its samples knows what the file says of padding: whole numbers, as they are stored. */
void vvi_file_tell_padding(const vv_file *file, vv_field *field);
/** What else of it will be read (VVI_FOLLOW_*, source.h): more and more, so that checksums are looked at where the last
 * of it is. */
void vvi_file_follow(vv_file *file, unsigned follow);
/** After all that followed was read: a warning, where that was not to the checksum of coded data. Files that the import
 * program reads are passed over. */
void vvi_file_tell_unproven(vv_file *file, vv_job *job);
/** Whether more than half of its samples are not there (vv_read_options.any_length): reading them is an error. */
bool vvi_file_lacks(const vv_file *file);
#endif
