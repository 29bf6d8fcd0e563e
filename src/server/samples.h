/** @file
 * Volumes that are made by formulas, for people who have none at hand.
 */
#ifndef VVI_SERVER_SAMPLES_H
#define VVI_SERVER_SAMPLES_H
#include "core/status.h"
#include <volvis/field.h>

typedef struct vvi_sample {
    const char *name, *doc;
    double (*value)(double x, double y, double z); /**< at a place of the cube from -1 to 1 */
} vvi_sample;
/** By number; NULL past the end. */
const vvi_sample *vvi_sample_nth(size_t index);
const vvi_sample *vvi_sample_find(const char *name);
/** n^3 floats over the cube. Same bytes for any thread count. */
vv_status vvi_sample_make(vv_field **out, const vvi_sample *sample, int64_t n, vv_job *job);
#endif
