/** @file
 * Round numbers: 1, 2 and 5 times powers of ten, for ticks and scale bars, and how they are written.
 */
#ifndef VVI_RENDER_DECORATE_ROUND_NUMBERS_H
#define VVI_RENDER_DECORATE_ROUND_NUMBERS_H
#include <volvis/base.h>

/** The largest 1, 2 or 5 times a power of ten that is not above x; 0 where x is not above 0 or not finite. */
double vvi_nice_below(double x);
/** The smallest that is not below x. */
double vvi_nice_above(double x);

/** Multiples of `step` from first to first + (n - 1) step, all within [lo, hi]. */
typedef struct vvi_ticks {
    double first, step;
    int n;
} vvi_ticks;

/** The finest round step with at most `most` intervals between lo and hi; n 0 where there is no room between them. */
vvi_ticks vvi_nice_ticks(double lo, double hi, int most);
/** Number i: a multiple of the step as near as doubles are, 0 itself where it is 0. */
double vvi_tick_at(const vvi_ticks *ticks, int i);

/** A multiple of `step` with as many decimals as the step has and a true minus sign; powers of ten where digits would
 * not fit: "2.5", "−0.04", "1200000", "3e−07". */
void vvi_print_tick(char out[40], double value, double step);

/** A value by itself: four digits, and no zeros behind them. */
void vvi_print_value(char out[40], double value);

/** A length in the unit that gives the fewest digits, of which three are written: 0.05 mm is "50 µm", 2000 um is "2
 * mm". Units that are no length of the real world stay: "1 voxel", "5 voxels". */
void vvi_print_length(char out[64], double length, const char *unit);
/** "µm" for "um", "Å" for "angstrom"; others as they are. */
const char *vvi_unit_sign(const char *unit);
#endif
