/** @file
 * What simplifying has done to a surface.
 */
#ifndef VVI_FILTER_SIMPLIFY_H
#define VVI_FILTER_SIMPLIFY_H
#include "surface/simplify.h"
#include <volvis/measure_mesh.h>

typedef struct vvi_simplify_told {
    vvi_simplify_result result;
    vv_figure distance; /**< measured, Hausdorff: from either surface to the other; NaN: nothing is left */
} vvi_simplify_told;
#endif
