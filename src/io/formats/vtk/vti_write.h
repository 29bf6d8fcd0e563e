/** @file
 * Writing VTK image data.
 */
#ifndef VVI_IO_VTI_WRITE_H
#define VVI_IO_VTI_WRITE_H
#include "core/text.h"
#include "io/sink.h"

vv_status vvi_vti_write(vv_sink *sink, const vv_field *const *frames, size_t n_frames, const vv_write_options *options,
                        vv_job *job);
extern const char *const vvi_vti_encodings[];

/* The tags (vti_tags.c) ---------------------------------------------------------------------------------------------
 */

#define VVI_VTI_WORD 8 /* bytes of a number in the header of an array */

/** Everything before the samples, or before the end of the grid where these are appended. */
void vvi_vti_add_head(vvi_text *text, const vv_field_info *info, const char *encoding, bool big_endian);
/** The tag of appended data, with blanks so that the samples behind the mark and one number lie well. */
void vvi_vti_add_mark(vvi_text *text);
#endif
