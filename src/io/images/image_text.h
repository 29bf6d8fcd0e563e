/** @file
 * Text of image files.
 */
#ifndef VVI_IO_IMAGE_TEXT_H
#define VVI_IO_IMAGE_TEXT_H
#include <stddef.h>

/** UTF-8 of n bytes of a text, which ends at the first 0: Latin-1 is converted where it is no UTF-8. Yours to free();
 * NULL when there is no memory. */
char *vvi_text_utf8(const char *s, size_t n);
#endif
