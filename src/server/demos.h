/** @file
 * Volumes that are made by formulas, for people who have none at hand.
 */
#ifndef VVI_SERVER_DEMOS_H
#define VVI_SERVER_DEMOS_H
#include "core/status.h"
#include <volvis/field.h>

typedef struct vvi_demo {
    const char *name, *doc;
    double (*value)(double x, double y, double z); /**< at a place of the cube from -1 to 1 */
} vvi_demo;
/** By number; NULL past the end. */
const vvi_demo *vvi_demo_nth(size_t index);
const vvi_demo *vvi_demo_find(const char *name);
/** n^3 floats over the cube. Same bytes for any thread count. */
vv_status vvi_demo_make(vv_field **out, const vvi_demo *sample, int64_t n, vv_job *job);
#endif
