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
/** The label there, of integers as they are stored: never by way of a double where scale and offset leave them so.
 * False: it does not fit. */
bool vvi_probe_label(vv_label_id *out, const vvi_probe *probe, const double p[3]);
/** Value change for a step along each index axis: central differences at the samples, one-sided at the border,
 * interpolated as values are. */
vv_vec3 vvi_probe_gradient(const vvi_probe *probe, const double p[3]);
/**
 * How far vvi_probe_value() may be from a smooth field that has these samples.
 *
 * Linear interpolation leaves out, to leading order, the sum over the axes of f (1 - f) / 2 times the second
 * derivative, f being the place between two samples (Davis 1963, section 3.1); mixed derivatives are reproduced. The
 * derivative is taken to be the largest second difference at the samples around, at the border that of the next ones,
 * times 5/4: of a wave of P voxels second differences find a share of (sin(pi / P) / (pi / P))^2 of it, 4/5 where P
 * is 4. Up to half a voxel outside the samples, at a distance d, where the outermost is taken, it is d times the
 * difference of the last two, and d (1 + d) / 2 times the second one besides. Places that are samples have 0: they are
 * taken as they are, with their noise and rounding.
 *
 * Holds    at 95 of 100 places of fields whose waves are 4 voxels or longer; not at a bend or a jump between two
 * samples, which second differences do not tell Returns  in values, not negative; NaN: not known (labels, the nearest
 * sample, an axis of less than three samples, a sample around that is no number)
 */
double vvi_probe_error(const vvi_probe *probe, const double p[3]);
#endif
