/** @file
 * Numbers of labels, vv_label_id: 64 bits from the samples to what is told of them, never by way of a double, which
 * takes neighbours beyond 2^53 for one.
 */
#ifndef VVI_GRID_LABEL_ID_H
#define VVI_GRID_LABEL_ID_H
#include "core/status.h"
#include <volvis/field.h>

/** Room for any id in decimal digits, with its sign and its end. */
#define VVI_LABEL_DIGITS 24

/** Whether ids are the bits of uint64_t. Of all other integers their values are the same as int64_t. */
static inline bool vvi_label_is_unsigned(vv_type type)
{
    return type == VV_TYPE_U64;
}

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

/** The id that one sample is. Reals are rounded; those that are no number, or are too large, are 0. */
vv_label_id vvi_label_of(const void *sample, vv_type type);
/** Those of row (j, k) of a component, box.n[0] of them. info: with its scale and offset, where these are not 1 and 0;
 * NULL: as they are stored. */
void vvi_label_read(vv_label_id *out, const vv_brick *brick, int component, const vv_field_info *info, int64_t j,
                    int64_t k);
#endif
