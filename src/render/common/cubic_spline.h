/** @file
 * Coefficients of the cubic B-spline that goes through the samples of a volume.
 */
#ifndef VVI_RENDER_CUBIC_SPLINE_H
#define VVI_RENDER_CUBIC_SPLINE_H
#include "grid/lattice.h"

/**
 * Like vvi_lattice_open(), but the lattice's numbers are coefficients: the spline with these weights at the samples is
 * the stored number there. Past the border the samples are mirrored about the last one.
 *
 * Shapes   out: VVI_SAMPLE_F32, as many as there are samples; made once and kept in the cache
 * Errors   those of vvi_lattice_open(); VV_E_UNSUPPORTED (NaN or infinity among the samples: there would be no others;
 *          more than 2^31 samples)
 * Threads  same bytes for any thread count
 * Source   Unser, Aldroubi and Eden 1991
 */
vv_status vvi_lattice_open_cubic(vvi_lattice_hold *out, const vv_field *field, int component, vv_job *job);

/** The spline of such a lattice at index coordinates, clamped to the samples; axis 0, 1, 2: its derivative along that
 * axis, by sample; -1: itself. In double precision, slow and obvious: the definition that kernels are tested against.
 */
double vvi_cubic_at(const vvi_lattice *coefficients, const double p[3], int axis);

#endif
