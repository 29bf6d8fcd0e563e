/** @file
 * One block of deflate whose size is known, as files with chunks, strips or blocks of their own keep them.
 */
#ifndef VVI_IO_INFLATE_H
#define VVI_IO_INFLATE_H
#include <stdbool.h>
#include <stddef.h>

typedef enum vvi_inflate_wrapper {
    VVI_INFLATE_ZLIB, /* what follows its end does not matter */
    VVI_INFLATE_GZIP  /* one member and nothing behind it */
} vvi_inflate_wrapper;

/**
 * Inflates a whole block. False: it is damaged, cut short or holds more than `room` bytes; what `out` has then is not
 * to be used.
 *
 * Threads  any
 */
bool vvi_inflate_block(void *out, size_t room, size_t *n_out, const void *in, size_t n_in, vvi_inflate_wrapper wrapper);

/**
 * Whether a block of zlib gets to its end and has the checksum that stands there, however much it holds; of no memory.
 *
 * Threads  any
 */
bool vvi_inflate_is_whole(const void *in, size_t n_in);
#endif
