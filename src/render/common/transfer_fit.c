#include "render/common/transfer_fit.h"
#include <math.h>

#define DEPTH 60.0 /* optical depth at the largest opacity along a ray through the object */

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
    const double depth = DEPTH / (extent * cbrt(fit->share));
    for (int i = 0; i < VVI_FIT_NODES; i++) {
        const double u = (double)i / (VVI_FIT_NODES - 1);
        rows[2 * i] = i + 1 == VVI_FIT_NODES ? hi : lo + u * (hi - lo);
        rows[2 * i + 1] = -expm1(-depth * length * u * sqrt(u));
    }
    return VVI_FIT_NODES;
}
