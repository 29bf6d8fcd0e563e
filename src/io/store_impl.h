/** @file
 * What the files of stores share.
 */
#ifndef VVI_IO_STORE_IMPL_H
#define VVI_IO_STORE_IMPL_H
#include "io/open_place.h"
#include "io/store.h"

/** Takes the descriptor (-1: none), also when it fails. */
vv_status vvi_store_new(vvi_store **out, int fd, const char *path, const char *name, vv_job *job);
/** The next n bytes of a stream, behind what is kept of it. */
void vvi_store_keep_head(vvi_store *store, const void *bytes, size_t n, vv_job *job);
#endif
