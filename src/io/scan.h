/** @file
 * Small pieces of text headers.
 */
#ifndef VVI_IO_SCAN_H
#define VVI_IO_SCAN_H
#include <volvis/base.h>
#include <volvis/field.h>

/** A whole decimal number after blanks; false, and nothing touched, when there is none or it does not fit. */
bool vvi_scan_int(int64_t *out, const char *text, const char **end);
/** The same, of 0 .. UINT64_MAX. */
bool vvi_scan_uint(uint64_t *out, const char *text, const char **end);
/** The id of a label: the same, of -2^63 .. UINT64_MAX. */
bool vvi_scan_label(vv_label_id *out, const char *text, const char **end);
/** A number after blanks, "nan" and "inf" included; Fortran's 1.5D-03 too. */
bool vvi_scan_real(double *out, const char *text, const char **end);
/** A unit as VolVis writes it: "millimeters" is "mm", "microns" is "um"; others as they are, cut to 15 bytes. */
void vvi_unit_name(char out[16], const char *text, size_t n);
/** The length of text without half a UTF-8 letter at its end when cut to `most` bytes. */
size_t vvi_utf8_cut(const char *text, size_t n, size_t most);
#endif
