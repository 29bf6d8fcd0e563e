/** @file
 * Colours of labels that have none of their own.
 */
#ifndef VVI_GRID_LABEL_COLOR_H
#define VVI_GRID_LABEL_COLOR_H
#include <volvis/field.h>

/** Linear: in Oklab the first 20 ids are 0.075 apart from each other, and neighbouring ones 0.15. Of 64 bits, with a
 * sign or without. */
void vvi_label_color(double rgb_out[3], vv_label_id label);

#endif
