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

/** A data set that can be chosen by vv_read_options.part; the one that is read is `chosen`. */
vv_status vvi_notes_part(vv_notes *notes, const char *name, const char *about, bool chosen);
/** Those that were told so far are none that can be chosen: the file is one of many. */
void vvi_notes_forget_parts(vv_notes *notes);
/** Of several parts one was taken for want of a name: a warning, with the others. kind: "arrays". */
vv_status vvi_notes_warn_unnamed(vv_notes *notes, const char *file, const char *kind);
/** There is no part that is called so: those that were told of are. kind: "array". */
vv_status vvi_notes_fail_part(const vv_notes *notes, vv_status status, const char *file, const char *kind,
                              const char *typed);
/** What a component is called and shown as: once for each, in order, or not at all. */
vv_status vvi_notes_channel(vv_notes *notes, const vv_channel *channel);
/** What a label names; in any order, values at most once. Its codes are copied. */
vv_status vvi_notes_label(vv_notes *notes, const vv_label *label);

/** Bytes of the header that only a writer of the same format can use, as they lie, with a code of the format's own;
 * nothing for people. A 0 stands behind them. Past the limits they are dropped, with one warning. */
vv_status vvi_notes_keep(vv_notes *notes, int32_t code, const void *bytes, size_t n);
/** By number; NULL past the end. */
const void *vvi_notes_kept(const vv_notes *notes, size_t index, int32_t *code_out, size_t *n_out);
/** Those of an open file. */
const vv_notes *vvi_file_notes(const vv_file *file);

vv_status vvi_notes_new(vv_notes **out, vv_job *job);
/** They are of one file of many: what reading it would log is left to whoever reads all of them. */
void vvi_notes_hush(vv_notes *notes);
bool vvi_notes_are_hushed(const vv_notes *notes);
void vvi_notes_free(vv_notes *notes); /* NULL is fine */
/** By number; false, or NULL, past the end. */
bool vvi_notes_get(const vv_notes *notes, size_t index, const char **key_out, const char **value_out);
const char *vvi_notes_warning(const vv_notes *notes, size_t index);
bool vvi_notes_get_part(const vv_notes *notes, size_t index, vv_part *out);
const vv_channel *vvi_notes_channels(const vv_notes *notes, size_t *n_out);
const vv_label *vvi_notes_labels(const vv_notes *notes, size_t *n_out);
#endif
