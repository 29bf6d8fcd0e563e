/** @file
 * Numbers of labels, vv_label_id: 64 bits, compared, written and read without a double, which takes neighbours beyond
 * 2^53 for one. is_unsigned: they are the bits of uint64_t.
 */
#ifndef VVI_CORE_LABEL_TEXT_H
#define VVI_CORE_LABEL_TEXT_H
#include "core/status.h"
#include <volvis/field.h>

/** Room for any id in decimal digits, with its sign and its end. */
#define VVI_LABEL_DIGITS 24

/** < 0, 0, > 0, by value. */
int vvi_label_compare(vv_label_id a, vv_label_id b, bool is_unsigned);
/** The nearest double. */
double vvi_label_value(vv_label_id id, bool is_unsigned);
/** All of its digits; returns `out`. */
const char *vvi_label_print(char out[VVI_LABEL_DIGITS], vv_label_id id, bool is_unsigned);
/** A whole number in decimal digits, or one below 2^53 however it is written ("1e3", "7.0"), from -2^63 to 2^63 - 1.
 * Where ids are unsigned to 2^64 - 1, and those below 0 are the same bits, as programs without such integers write
 * them. False: it is none of these. */
bool vvi_label_parse(vv_label_id *out, const char *typed, bool is_unsigned);

#endif
