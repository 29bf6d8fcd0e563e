/** @file
 * What a reader notes beside the info: metadata and warnings.
 */
#ifndef VVI_IO_NOTES_H
#define VVI_IO_NOTES_H
#include "core/status.h"
#include <volvis/sys/registry.h>

/** Copies; past the limits on keys and bytes further metadata is dropped with one warning. */
vv_status vvi_notes_add(vv_notes *notes, const char *key, const char *value);
vv_status vvi_notes_warn(vv_notes *notes, const char *format, ...) VV_PRINTF(2, 3);
#endif
