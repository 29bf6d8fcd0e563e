/** @file
 * Ranges of values, as samples are compared with them: by keys (filter/sample_keys.h), exactly, in every type.
 */
#ifndef VVI_SEGMENT_VALUE_RANGE_H
#define VVI_SEGMENT_VALUE_RANGE_H
#include "core/status.h"
#include <volvis/field.h>

/** Both ends are in it; -INFINITY and INFINITY where it is open. */
typedef struct vvi_value_range {
    double lo, hi;
} vvi_value_range;

/** The keys of the samples that have these values; none where lo > hi. NaN has none of them. */
typedef struct vvi_key_range {
    int64_t lo, hi;
} vvi_key_range;

/** "100..200", "100..", "..200", or one number. `place` begins the error: "threshold: range". */
vv_status vvi_value_range_parse(vvi_value_range *out, const char *text, const char *place);
/** As people mean it who see rounded values: integers with a scale belong to it within 1e-9 of a step. */
vvi_value_range vvi_value_range_as_typed(const vvi_value_range *range, const vv_field_info *info);
vvi_key_range vvi_key_range_of(const vvi_value_range *range, const vv_field_info *info);
/** Of n samples, `step` bytes apart: 1 where one is inside, else 0. */
void vvi_key_range_row(uint8_t *inside, const void *samples, int64_t step, vv_type type, const vvi_key_range *range,
                       int64_t n);
#endif
