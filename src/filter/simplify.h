/** @file
 * The operation simplify, for who runs it: what it has done.
 */
#ifndef VVI_FILTER_SIMPLIFY_H
#define VVI_FILTER_SIMPLIFY_H
#include "surface/simplify.h"
#include <volvis/measure_mesh.h>
#include <volvis/property.h>

typedef struct vvi_simplify_told {
    vvi_simplify_result result;
    vv_figure distance; /**< measured, Hausdorff: from either surface to the other; NaN: nothing is left */
} vvi_simplify_told;

/** The operation writes there when it runs with these parameters; NULL: it does not. */
void vvi_simplify_tell(vv_object *params, vvi_simplify_told *told);
#endif
