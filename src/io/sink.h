/** @file
 * Output that appears whole or not at all: written beside the target, synced, renamed.
 */
#ifndef VVI_IO_SINK_H
#define VVI_IO_SINK_H
#include "core/status.h"
#include <volvis/sys/registry.h>

/** "-" is standard output. */
vv_status vvi_sink_open(vv_sink **out, const char *path, vv_job *job);
const char *vvi_sink_name(const vv_sink *sink);
vv_status vvi_sink_write(vv_sink *sink, const void *data, size_t n);
vv_status vvi_sink_printf(vv_sink *sink, const char *format, ...) VV_PRINTF(2, 3);
/** Bytes from here on are coded; VVI_CODING_NONE ends it; not one in another. level 0: the default. (vvi_coding of
 * io/source.h) */
vv_status vvi_sink_coding(vv_sink *sink, int coding, int level);
/** A second file that belongs to the first (detached data): committed before it, under `name` in its folder. */
vv_status vvi_sink_beside(vv_sink **out, vv_sink *sink, const char *name);
/** Sync, close and rename; the sink is gone afterwards in any case. */
vv_status vvi_sink_commit(vv_sink *sink);
/** Throw away. NULL is fine. */
void vvi_sink_abandon(vv_sink *sink);
#endif
