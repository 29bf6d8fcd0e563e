/** @file
 * Numbers with units, read and written without the locale.
 */
#ifndef VVI_CORE_UNITS_H
#define VVI_CORE_UNITS_H
#include <volvis/property.h>

/** strtod of the C locale; true when all of the text is one finite or infinite number. */
bool vvi_parse_number(double *out, const char *text);
/** A number at the start, white space before it skipped; *end is what follows, or text where there is no number. */
bool vvi_scan_number(double *out, const char *text, const char **end);
/** A short decimal form that reads back to the same double: "-0.0", "1e-300", "0.1"; the shortest but for a few powers
 * of two, which get a digit more. What is not finite becomes "null", as in JSON. */
void vvi_print_number(char out[32], double value);
/** The same for headers and people, to whom -0 is 0. */
void vvi_print_unsigned_zero(char out[32], double value);
/** "1.5mm", "3vox", "30deg", "0.5rad", "2s", "8G", "50%" to what the property stores. Error: VV_E_ARGUMENT that names
 * the known units. `place` goes in front of the text of the error. */
vv_status vvi_parse_quantity(double *out, const char *text, vv_quantity quantity, const vv_property_context *context,
                             const char *place);
/** Metres in one of a unit ("mm": 1e-3); 0 for units that are no length of the real world. */
double vvi_length_unit_metres(const char *unit);
/** "512 bytes", "16.8 MiB", "2.0 GiB" for people. */
void vvi_print_bytes(char out[32], uint64_t bytes);
#endif
