/** @file
 * Whether the values of a field are shown about zero: in clouds, slices and previews alike.
 */
#ifndef VVI_SCENE_TWO_SIDED_H
#define VVI_SCENE_TWO_SIDED_H
#include "grid/value_sides.h"

/** The map of values about zero. */
#define VVI_TWO_SIDED_MAP "coolwarm"

/**
 * vvi_fit_two_sided(), but not where zero is a mark on a scale and no middle: Hounsfield units, said or recognized
 * (whole numbers without a unit that begin where those of a scanner do), and temperatures. *out is set where it is
 * true.
 */
bool vvi_two_sided(vvi_value_fit *out, const vv_field_info *info, const vv_statistics *statistics);
/** How far from zero the window of slices goes, on both sides. */
double vvi_two_sided_end(const vvi_value_fit *fit, const vv_statistics *statistics);
/** Whether a colour map has a middle that stands for zero. */
bool vvi_two_sided_map(const char *name);
/** Whether zero is the middle of a range, but for what rounding does. */
bool vvi_about_zero(double lo, double hi);
#endif
