/** @file
 * The samples that values are taken of: all of a field, or those of an object in a region. Passes go over both alike.
 */
#ifndef VVI_MEASURE_VALUE_SAMPLES_H
#define VVI_MEASURE_VALUE_SAMPLES_H
#include "grid/value_pass.h"
#include "measure/object.h"
#include "measure/region.h"

typedef struct vvi_value_samples {
    const vv_field *field;
    int component;
    const vvi_object *object; /**< NULL: all samples */
    const vvi_region *region; /**< with an object */
    vv_job *job;
} vvi_value_samples;

/** Items that passes have. */
size_t vvi_value_samples_items(const vvi_value_samples *samples);
/** n passes at once. */
vv_status vvi_value_samples_run(const vvi_value_samples *samples, const vvi_pass *passes, int n);
#endif
