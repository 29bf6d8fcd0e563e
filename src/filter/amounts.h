/** @file
 * What several filters are told in words: values as a type stores them, and numbers of samples or lengths.
 */
#ifndef VVI_FILTER_AMOUNTS_H
#define VVI_FILTER_AMOUNTS_H
#include "core/status.h"
#include <volvis/field.h>

/** The bytes of the stored number of a value, rounded. VV_E_ARGUMENT where the type does not hold it, NaN of integers.
 * place: begins the sentence, "pad: value". */
vv_status vvi_stored_bytes(char out[8], const vv_field_info *info, double value, const char *place);
/** n times the number of so many bytes. */
void vvi_fill_numbers(char *out, const char bytes[8], size_t each, int64_t n);
/** "5" samples or a length, "10mm", as the nearest number of samples along an axis. VV_E_ARGUMENT below 0. */
vv_status vvi_parse_samples(int64_t *out, const char *text, const vv_grid *grid, int axis, const char *place);
#endif
