/** @file
 * Temporary files that hold what comes by a stream or out of a decoder: no larger than the limits and the disk allow.
 */
#ifndef VVI_IO_SPOOL_H
#define VVI_IO_SPOOL_H
#include "io/store.h"

typedef struct vvi_spool {
    vvi_store *store; /* the temporary file */
    const char *name; /* of what it holds; stands in errors */
    uint64_t total, most, room;
} vvi_spool;

/** An empty one. Whoever began releases the store or keeps it. */
vv_status vvi_spool_begin(vvi_spool *out, const char *name, vv_job *job);
vv_status vvi_spool_put(vvi_spool *spool, const void *data, size_t n);

/** The next bytes of what goes into a spool, up to `room`; *n_out 0 at the end. */
typedef vv_status vvi_spool_next(void *user, void *out, size_t room, size_t *n_out, vv_job *job);
/** All that is left of it. */
vv_status vvi_spool_fill(vvi_spool *spool, vvi_spool_next *next, void *user, vv_job *job);
#endif
