/** @file
 * Whether the values of a histogram lie about zero.
 */
#ifndef VVI_GRID_VALUE_SIDES_H
#define VVI_GRID_VALUE_SIDES_H
#include "grid/value_fit.h"

/**
 * Whether values of both signs are about zero (vorticity, wave functions, statistical maps, wind, seismic amplitudes).
 * Either
 *
 *   - both sides are alike: the tails (0.5 % at either end) about as long, the middle value near zero compared with
 * them, and the quartiles about it; the fullest bin says nothing then, as it may lie anywhere in what is flat or noisy;
 *   - zero is the background: the highest peak lies at it, or the middle value does and no tail is four times as long
 * as the other; values go far to both sides, and fewer of them farther out, so that no second peak (air in CT) is taken
 * for a tail;
 *   - nearly all is zero (half of the samples are in its bin): the same, but the tails are those of the other samples,
 * and may begin anywhere, as in maps of which only what is strong was kept; or
 *   - none lies above zero, and zero is the highest peak: the lower half of such values.
 *
 * Then *out is the fit of their magnitudes.
 */
bool vvi_fit_two_sided(vvi_value_fit *out, const vv_statistics *statistics);
/** The fit of the magnitudes, whatever they are: where somebody says that zero is the middle, and, if above 0, which is
 * the `most` that is shown. False where there is nothing to fit. */
bool vvi_fit_magnitudes(vvi_value_fit *out, const vv_statistics *statistics, double most);
#endif
