/** @file
 * Files and folders opened where the runtime may read (core/allowed_places.h).
 */
#ifndef VVI_IO_OPEN_PLACE_H
#define VVI_IO_OPEN_PLACE_H
#include <stdbool.h>
#include <volvis/runtime.h>

/** A path that was named from outside, to be read: anywhere, or where the runtime is confined, with no way out
 * (core/allowed_places.h); a file that was lent is opened anew. beside: the folder of such a file may be meant. A
 * descriptor, or -1 and errno (EXDEV: it lies outside). */
int vvi_open_place(const char *path, int flags, bool beside, const vv_job *job);
/** A name below a folder, no way out of it followed: a descriptor, or -1 and errno. */
int vvi_open_beneath(int folder, const char *name, int flags);
#endif
