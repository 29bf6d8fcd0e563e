/** @file
 * Which row of the format table a file belongs to: by content first, suffix second.
 */
#ifndef VVI_IO_FORMAT_H
#define VVI_IO_FORMAT_H
#include "io/source.h"

/** The coding that a path's suffix names (".gz", ".bz2", ".zst"); *n_out is the length of the path without it. */
vvi_coding vvi_path_coding(const char *path, size_t *n_out);
/** Whether the first n letters of a path end in one of a row's suffixes, letter case apart. */
bool vvi_format_has_suffix(const vv_format *format, const char *path, size_t n);
/** The last suffix of a path's first n letters, ".nrd", to be told; "": it has none, or a long one. */
void vvi_path_suffix(char typed[32], const char *path, size_t n);
/** By name; VV_E_ARGUMENT with the nearest real name. */
vv_status vvi_format_named(const vv_format **out, const char *name, const vv_registry *registry);
/** For a file with these first bytes. VV_E_FORMAT says what was tried and what is near. */
vv_status vvi_format_of_file(const vv_format **out, const uint8_t *head, size_t n, const char *path,
                             const vv_registry *registry);
/** For an output; VV_E_ARGUMENT says which suffixes there are. */
vv_status vvi_format_of_output(const vv_format **out, const char *path, const vv_registry *registry);
/** Whether what is written are values, not the stored numbers of `info` with their scale. */
bool vvi_format_writes_values(const vv_format *format, const vv_field_info *info, bool stored);
/** Whether a row writes with this encoding; NULL is its default. VV_E_ARGUMENT with the nearest real name. */
vv_status vvi_format_check_encoding(const vv_format *format, const char *encoding);
/** What a caller's options say over the defaults that `known` holds, `room` bytes. Both begin with their size: those of
 * a caller that was built with an older library end earlier. NULL: nothing. */
void vvi_options_over(void *known, size_t room, const void *options);
#endif
