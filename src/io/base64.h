/** @file
 * Base64, as writers need it.
 */
#ifndef VVI_IO_BASE64_H
#define VVI_IO_BASE64_H
#include "io/sink.h"
#include <stddef.h>
#include <stdint.h>

/** One to three bytes to four letters. */
void vvi_base64_group(char out[4], const uint8_t *in, size_t n);

/** Bytes on their way into a sink as base64; begin with zeros. */
typedef struct vvi_base64 {
    uint8_t rest[3]; /**< bytes that make no group yet */
    size_t n_rest;
} vvi_base64;

/** n bytes more. */
vv_status vvi_base64_write(vvi_base64 *coder, vv_sink *sink, const void *data, size_t n);
/** What waits for a group to be whole; afterwards new text begins. */
vv_status vvi_base64_end(vvi_base64 *coder, vv_sink *sink);
#endif
