/** @file
 * What readers and writers of formats see of files: bounded sources, sinks that appear whole or not at all, and notes.
 */
#ifndef VOLVIS_SYS_IO_H
#define VOLVIS_SYS_IO_H
#include <volvis/file.h>
#include <volvis/sys/fail.h>
VV_BEGIN_DECLS

typedef struct vv_source vv_source; /**< bounded input */
typedef struct vv_sink vv_sink;     /**< output that appears whole or not at all */
typedef struct vv_notes vv_notes;   /**< collects metadata and warnings */

/* Sources --------------------------------------------------------------------------------------------------------
 * No read past the end; .gz, .bz2 and .zst are read through. Compare sizes with vv_source_left() before you take
 * memory. */

VV_API const char *vv_source_name(const vv_source *source); /* for errors */
/** Bytes from here to the end: exact when *exact, else an upper bound from the coding's largest expansion. */
VV_API uint64_t vv_source_left(vv_source *source, bool *exact);
VV_API uint64_t vv_source_tell(const vv_source *source);
/** Exactly n bytes, or VV_E_FORMAT "<name>: ends after N bytes; M were expected ..."; what: "samples". */
VV_API vv_status vv_source_read(vv_source *source, void *out, size_t n, const char *what);
/** Up to n bytes; *n_read less than n only at the end. */
VV_API vv_status vv_source_read_some(vv_source *source, void *out, size_t n, size_t *n_read);
/** Absolute position; VV_E_UNSUPPORTED backwards in a stream. */
VV_API vv_status vv_source_seek(vv_source *source, uint64_t offset);
/** The first n bytes without moving (n at most 4096). */
VV_API const uint8_t *vv_source_peek(vv_source *source, size_t n, size_t *n_there);
/** One line without its end, at most `most` bytes, valid until the next call; *end at the end of the file. */
VV_API vv_status vv_source_line(vv_source *source, const char **line_out, size_t most, bool *end);
/** A data file that a header names: relative, below the header's folder, a regular file; else VV_E_READ with what to
 * do. Its bytes come as they lie. */
VV_API vv_status vv_source_open_beside(vv_source **out, const vv_source *header, const char *name, vv_job *job);
VV_API void vv_source_close(vv_source *source); /* of what was opened beside; NULL is fine */

/* Sinks ---------------------------------------------------------------------------------------------------------- */

VV_API const char *vv_sink_name(const vv_sink *sink);
VV_API vv_status vv_sink_write(vv_sink *sink, const void *data, size_t n);
VV_API vv_status vv_sink_printf(vv_sink *sink, const char *format, ...) VV_PRINTF(2, 3);
/** Bytes that have gone out. */
VV_API uint64_t vv_sink_tell(const vv_sink *sink);
/** A second file that belongs to the first (detached data), under `name` in its folder; it appears with the first. */
VV_API vv_status vv_sink_beside(vv_sink **out, vv_sink *sink, const char *name);

/* Notes ---------------------------------------------------------------------------------------------------------- */

/** What the header says beyond the info. Past the limits further metadata is dropped with one warning. */
VV_API vv_status vv_notes_add(vv_notes *notes, const char *key, const char *value);
VV_API vv_status vv_notes_warn(vv_notes *notes, const char *format, ...) VV_PRINTF(2, 3);
/** What a component is called and shown as: once for each, in order, or not at all. */
VV_API vv_status vv_notes_channel(vv_notes *notes, const vv_channel *channel);
/** What a label names; in any order, values at most once. Its codes are copied. */
VV_API vv_status vv_notes_label(vv_notes *notes, const vv_label *label);

/* Numbers in text, without the locale ---------------------------------------------------------------------------- */

/** A number at the start, white space before it skipped; *end is what follows, or text where there is no number. */
VV_API bool vv_number_scan(double *out, const char *text, const char **end);
/** A short decimal form that reads back to the same double: "0.1", "1e-300"; what is not finite becomes "null". */
VV_API void vv_number_print(char out[32], double value);

VV_END_DECLS
#endif
