/** @file
 * The undecoded bytes behind sources: a regular file, a stream that is read once, or memory.
 */
#ifndef VVI_IO_STORE_H
#define VVI_IO_STORE_H
#include "io/source.h"

typedef struct vvi_store {
    int users; /* sources on it; all of one thread at a time */
    int fd;    /* -1: memory */
    bool seekable;
    uint64_t size;         /* UINT64_MAX for a stream */
    uint64_t stream_at;    /* of a stream: how many bytes were taken */
    const uint8_t *memory; /* or NULL */
    char *path;            /* NULL for memory and standard input */
    char *name;            /* stands in errors */
} vvi_store;

vv_status vvi_store_open(vvi_store **out, const char *path, vv_job *job);
vv_status vvi_store_memory(vvi_store **out, const void *data, size_t n, const char *name, vv_job *job);
vv_status vvi_store_beside(vvi_store **out, const vvi_store *header, const char *name, vv_job *job);
vvi_store *vvi_store_retain(vvi_store *store);
void vvi_store_release(vvi_store *store);
/** Up to n bytes at an offset; *n_read less only at the end. A stream can only go on where it stands. */
vv_status vvi_store_read(vvi_store *store, uint64_t offset, void *out, size_t n, size_t *n_read, const vv_job *job);
#endif
