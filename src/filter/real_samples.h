/** @file
 * Samples of one component as packed floats or doubles, and back: what filters reckon with.
 */
#ifndef VVI_FILTER_REAL_SAMPLES_H
#define VVI_FILTER_REAL_SAMPLES_H
#include <volvis/field.h>

/** Whether samples of a type need doubles (8 bytes) and not floats (4). */
bool vvi_reals_wide(vv_type type);
static inline size_t vvi_reals_bytes(bool wide)
{
    return wide ? sizeof(double) : sizeof(float);
}

/** n samples, `step` bytes from one to the next. */
void vvi_reals_of_samples(void *reals, bool wide, const void *samples, int64_t step, vv_type type, int64_t n);
/** Rounded to nearest, clamped to the type's range; NaN becomes 0 in integers. */
void vvi_samples_of_reals(void *samples, int64_t step, vv_type type, const void *reals, bool wide, int64_t n);

/** The samples of a box and `margin` to each side of one component, x fastest. Where the margin leaves the brick the
 * samples of its border are repeated. */
void vvi_reals_of_box(void *reals, bool wide, const vv_brick *brick, const vv_box *box, const int64_t margin[3],
                      int64_t component);
#endif
