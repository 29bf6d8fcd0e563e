/** @file
 * What a histogram says of an object before anybody has said anything: where the background ends, where the object's
 * values lie, and which value splits the two.
 */
#ifndef VVI_GRID_VALUE_FIT_H
#define VVI_GRID_VALUE_FIT_H
#include <volvis/field.h>

/** Values and shares, read off a histogram. */
typedef struct vvi_value_fit {
    bool empty;    /**< no finite sample */
    bool constant; /**< one value only */
    double lo, hi; /**< from the end of the background to where the object's values thin out (99.5 %) */
    double share;  /**< of the samples that lie above lo, in (0, 1] */
    double median; /**< of the samples that lie above lo */
    double split;  /**< between the two classes of values that differ most (Otsu 1979) */
} vvi_value_fit;

/**
 * The background is the highest peak of the histogram, if it lies in the lower half of the values (up to 99.9 %, so
 * that one hot sample does not count): air, or what was masked out. It ends where the peak has sunk to a fiftieth.
 * Where there is no such peak every value is the object.
 */
void vvi_fit_values(vvi_value_fit *out, const vv_statistics *statistics);
/**
 * Whether values of both signs are about zero (vorticity, wave functions, statistical maps, wind, seismic amplitudes).
 * Either
 *
 *   - both sides are alike: the tails (0.5 % at either end) about as long, the middle value near zero compared with
 * them, and the quartiles about it; the fullest bin says nothing then, as it may lie anywhere in what is flat or noisy;
 * or
 *   - zero is the background: the highest peak lies at it, or the middle value does and no tail is four times as long
 * as the other; values go far to both sides, and fewer of them farther out, so that no second peak (air in CT) is taken
 * for a tail.
 *
 * Then *out is the fit of their magnitudes.
 */
bool vvi_fit_two_sided(vvi_value_fit *out, const vv_statistics *statistics);
/** The largest value worth a bin: up to 99.9 %. Where nearly everything is one value the rest is the object, however
 * little it is. */
double vvi_fit_top(const vv_statistics *statistics);
#endif
