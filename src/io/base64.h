/** @file
 * Base64, as writers need it.
 */
#ifndef VVI_IO_BASE64_H
#define VVI_IO_BASE64_H
#include <stddef.h>
#include <stdint.h>

/** One to three bytes to four letters. */
void vvi_base64_group(char out[4], const uint8_t *in, size_t n);
#endif
