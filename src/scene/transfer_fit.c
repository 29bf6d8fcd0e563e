#include "scene/transfer_fit.h"
#include <math.h>

#define NO_BACKGROUND 0.95 /* share of the samples above lo: a field that fills its box */
#define ALL_TAIL 0.2       /* middle value, from lo = 0 to hi = 1, at which the values thin out from lo on */
#define NO_TAIL 0.28       /* the same, where they gather about a value of their own */

/* How opacity rises with u, from lo = 0 to hi = 1. */
typedef struct ramp {
    double depth; /* optical depth of a ray through the object, were it all at hi */
    double power; /* of u */
} ramp;

/*
 * Objects with a value of their own (tissue, metal) are seen by their skin, so opacity rises early. Where values thin
 * out from the background on (a cloud, an orbital, vessels filled unevenly) or there is no background, the faint ones
 * are everywhere, and would hide all that is higher.
 */
static ramp ramp_for(const vvi_value_fit *fit)
{
    static const ramp skin = {60, 1.5}, tail = {40, 2.5}, fog = {15, 3};
    if (fit->share >= NO_BACKGROUND && !fit->constant)
        return fog;
    const double middle = (fit->falls ? fit->hi - fit->median : fit->median - fit->lo) / (fit->hi - fit->lo);
    const double t = fmin(fmax((NO_TAIL - middle) / (NO_TAIL - ALL_TAIL), 0), 1);
    return (ramp){skin.depth + t * (tail.depth - skin.depth), skin.power + t * (tail.power - skin.power)};
}

size_t vvi_fit_opacity(double rows[2 * VVI_FIT_NODES], const vvi_value_fit *fit, double lo, double hi, double extent,
                       double length)
{
    if (fit->empty) {
        rows[0] = rows[1] = 0;
        return 1;
    }
    if (fit->constant && !(hi > lo)) { /* a block of fog that one can look into */
        rows[0] = lo;
        rows[1] = -expm1(-1.5 * length / extent);
        return 1;
    }
    const ramp rise = ramp_for(fit);
    const double depth = rise.depth / (extent * cbrt(fit->share));
    for (int i = 0; i < VVI_FIT_NODES; i++) {
        const double u = (double)i / (VVI_FIT_NODES - 1);
        rows[2 * i] = i + 1 == VVI_FIT_NODES ? hi : lo + u * (hi - lo);
        rows[2 * i + 1] = -expm1(-depth * length * pow(fit->falls ? 1 - u : u, rise.power));
    }
    return VVI_FIT_NODES;
}
