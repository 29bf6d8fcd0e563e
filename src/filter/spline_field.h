/** @file
 * Smooth fields over the box of a grid: cubic B-splines on a lattice of knots, fitted to samples of which some are
 * missing.
 */
#ifndef VVI_FILTER_SPLINE_FIELD_H
#define VVI_FILTER_SPLINE_FIELD_H
#include "core/job.h"
#include "core/status.h"

/** Where a place along an axis is among the knots: four in a row, from `first` on, count. */
typedef struct vvi_knot {
    int32_t first;
    double weight[4];
    double squares; /**< the sum of the weights' squares */
} vvi_knot;

/** Of a place from 0 to 1 along an axis with so many spans; they have spans + 3 knots. */
vvi_knot vvi_knot_at(double place, int64_t spans);

/** A field: knot x + (spans[0] + 3) (y + ...) */
typedef struct vvi_lattice {
    int64_t spans[3];
    double *c;
} vvi_lattice;

size_t vvi_lattice_size(const vvi_lattice *lattice);
/** The knots' values that count at y and z, by knot along x. */
void vvi_lattice_row(double *out, const vvi_lattice *lattice, const vvi_knot *y, const vvi_knot *z);
static inline double vvi_lattice_value(const double *row, const vvi_knot *x)
{
    const double *c = row + x->first, *w = x->weight;
    return w[0] * c[0] + w[1] * c[1] + w[2] * c[2] + w[3] * c[3];
}

/** Samples on a grid that is spread over the box: by axis, where each is. */
typedef struct vvi_spline_samples {
    int64_t n[3];
    const vvi_knot *knot[3];
    const double *v; /**< NaN: missing */
} vvi_spline_samples;

/** Knots for samples, as B-spline approximation has them: each is the mean, by squared weights, of what the samples
 * around ask of it (Lee, Wolberg & Shin 1997). Added to the lattice. The same for any number of threads. */
vv_status vvi_lattice_fit(vvi_lattice *lattice, const vvi_spline_samples *samples, vv_job *job);
#endif
