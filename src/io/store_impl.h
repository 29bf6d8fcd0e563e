/** @file
 * What the files of stores share.
 */
#ifndef VVI_IO_STORE_IMPL_H
#define VVI_IO_STORE_IMPL_H
#include "io/store.h"

/** Takes the descriptor (-1: none), also when it fails. */
vv_status vvi_store_new(vvi_store **out, int fd, const char *path, const char *name, vv_job *job);
/** The next n bytes of a stream, behind what is kept of it. */
void vvi_store_keep_head(vvi_store *store, const void *bytes, size_t n, vv_job *job);
/** A path that was named from outside, to be read: anywhere, or where the runtime is confined, with no way out
 * (core/places.h); a file that was lent is opened anew. beside: the folder of such a file may be meant. A descriptor,
 * or -1 and errno (EXDEV: it lies outside). */
int vvi_open_place(const char *path, int flags, bool beside, const vv_job *job);
/** A name below a folder, no way out of it followed: a descriptor, or -1 and errno. */
int vvi_open_beneath(int folder, const char *name, int flags);
#endif
