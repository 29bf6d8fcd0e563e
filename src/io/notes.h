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

vv_status vvi_notes_new(vv_notes **out, vv_job *job);
void vvi_notes_free(vv_notes *notes); /* NULL is fine */
/** By number; false, or NULL, past the end. */
bool vvi_notes_get(const vv_notes *notes, size_t index, const char **key_out, const char **value_out);
const char *vvi_notes_warning(const vv_notes *notes, size_t index);
#endif
