/** @file
 * The filter that smoothes meshes: a polynomial in the mean over neighbours.
 */
#ifndef VVI_SURFACE_SMOOTH_FILTER_H
#define VVI_SURFACE_SMOOTH_FILTER_H
#include "core/status.h"
#include <volvis/runtime.h>

/** Taking the mean of its neighbours for each vertex multiplies a wave of frequency k (0: constant, 2: neighbours of
 * opposite sign) by x = 1 - k. The filter is the sum of c[i] T_i(x), Chebyshev polynomials. */
typedef struct vvi_smooth_filter {
    double *c;
    int n; /**< numbers in c: no more than steps + 1; what would add less than rounding is left out */
} vvi_smooth_filter;

/** What is left of a wave of the frequency that is the pass band. */
#define VVI_SMOOTH_KEPT .95

/**
 * The maximally flat filter of this many steps: with t = k / 2 the probability of at most m successes in `steps` trials
 * of probability t, m being such (between whole numbers, a mean of two) that VVI_SMOOTH_KEPT is left at the pass band,
 * and at least 1. So it is 1 at k = 0, with a slope of 0 there, falls all the way to 2, and is never above 1 or below
 * 0.
 *
 * Range    steps >= 1, 0 < pass_band < 2
 * Owns     out->c: vvi_free()
 * Source   Herrmann 1971, "On the approximation problem in nonrecursive digital filter design"
 */
vv_status vvi_smooth_filter_make(vvi_smooth_filter *out, int steps, double pass_band, vv_job *job);
/** The same by that definition. m: as the filter has it. */
double vvi_smooth_gain(int steps, double m, double t);
/** The m of a filter. */
double vvi_smooth_order(int steps, double pass_band);
#endif
