/** @file
 * Values and gradients of a field at single places, in double precision, of any type: for picking and layers, which ask
 * at few places. Renderers' kernels have ways of their own; both follow the same definition.
 */
#ifndef VVI_GRID_PROBE_H
#define VVI_GRID_PROBE_H
#include "core/status.h"
#include <volvis/field.h>

typedef struct vvi_probe {
    vv_brick brick; /**< all samples */
    int64_t dims[3];
    int component;
    double scale, offset; /**< value = stored * scale + offset */
    bool nearest;         /**< the nearest sample's, else linear between samples */
    bool labels;  /**< not nearest: the label that most of the samples around have, by their weights; its gradient
                       is that of 1 where it is and 0 elsewhere. To be set after opening */
    double label; /**< NAN; private */
} vvi_probe;

/** Of a field that outlives it; close it with vvi_probe_close(). Reading is of any thread. */
vv_status vvi_probe_open(vvi_probe *out, const vv_field *field, int component, bool nearest, vv_job *job);
void vvi_probe_close(vvi_probe *probe); /* zeroed is fine */

/** Value at index coordinates p, clamped to the samples. */
double vvi_probe_value(const vvi_probe *probe, const double p[3]);
/** Value change for a step along each index axis: central differences at the samples, one-sided at the border,
 * interpolated as values are. */
vv_vec3 vvi_probe_gradient(const vvi_probe *probe, const double p[3]);
#endif
