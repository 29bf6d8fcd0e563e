/** @file
 * Numbers as text in a stretch of a source, by index: for formats whose text stands between other things.
 */
#ifndef VVI_IO_NUMBER_TEXT_H
#define VVI_IO_NUMBER_TEXT_H
#include "io/numbers.h"

typedef struct vvi_number_text vvi_number_text;

/** Bytes [begin, end) of a source; end UINT64_MAX: as far as it goes. Close it before anything else is read of the
 * source, and before that is closed. */
vv_status vvi_number_text_open(vvi_number_text **out, vv_source *source, uint64_t begin, uint64_t end, vv_type type,
                               vv_job *job);
void vvi_number_text_close(vvi_number_text *text); /* NULL is fine */
/** n numbers from the index-th on; going back reads the text again from its begin. *n_got less than n where it ends. */
vv_status vvi_number_text_read(vvi_number_text *text, void *out, uint64_t index, size_t n, size_t *n_got);
/** Passes over n numbers; *n_got as above. */
vv_status vvi_number_text_skip(vvi_number_text *text, uint64_t n, uint64_t *n_got);
/** The byte after the last number. */
uint64_t vvi_number_text_tell(const vvi_number_text *text);
#endif
