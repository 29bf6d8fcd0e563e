/* Any percentile, read off the histogram that a field's statistics keep. */
#include "grid/field.h"
#include <math.h>

double vvi_statistics_percentile(const vv_statistics *s, double percent)
{
    if (percent <= 0)
        return s->min;
    if (percent >= 100)
        return s->max;
    const double rank = percent / 100 * (double)s->count;
    double below = 0;
    for (int b = 0; b < s->n_bins; b++) {
        const double here = (double)s->histogram[b];
        if (here > 0 && below + here >= rank) {
            const double at = (b + (rank - below) / here) / s->n_bins;
            return fmin(fmax(s->histogram_lo + (s->histogram_hi - s->histogram_lo) * at, s->min), s->max);
        }
        below += here;
    }
    return s->max;
}
