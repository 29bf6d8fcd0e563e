/** @file
 * Which step holds where along the rays of a packet through several volumes. For kernels only.
 *
 * A step is that of the finest volume that a ray is in; in a gap between volumes that of the volume before. A stretch
 * goes as far as one step holds, and its steps are counted from where it begins. Volumes of one step make one stretch.
 */
#ifndef VVI_RENDER_MARCH_STRETCH_H
#define VVI_RENDER_MARCH_STRETCH_H
#include "render/march/packet.h"

/** A step changes only where a volume is entered or left. */
enum { MOST_STRETCHES = 2 * VVI_BLEND_VOLUMES };

typedef struct stretch {
    double from, to, step; /* world distances and length */
} stretch;

typedef struct stretches {
    int n[VV_WIDTH]; /* of each ray */
    int most;        /* of any; 0: all miss */
    stretch of[VV_WIDTH][MOST_STRETCHES];
} stretches;

/** A volume along one ray: world distances. */
typedef struct passage {
    double from, to, step;
} passage;

/* The finest step at t (INFINITY: no volume is there), and up to where nothing changes. */
VV_INLINE double step_at(const passage *p, size_t n, double t, double *until)
{
    double step = INFINITY;
    *until = INFINITY;
    for (size_t i = 0; i < n; i++) {
        const bool inside = p[i].from <= t && t < p[i].to;
        const double change = inside ? p[i].to : p[i].from > t ? p[i].from : INFINITY;
        *until = change < *until ? change : *until;
        step = inside && p[i].step < step ? p[i].step : step;
    }
    return step;
}

/** Those of one ray through n volumes, in order; how many. */
VV_INLINE int find_stretches(stretch out[MOST_STRETCHES], const passage *p, size_t n)
{
    int count = 0;
    double t = INFINITY, until;
    for (size_t i = 0; i < n; i++)
        t = p[i].from < t ? p[i].from : t;
    while (t < INFINITY) {
        const double step = step_at(p, n, t, &until);
        if (step < INFINITY) {
            if (!count || out[count - 1].step != step)
                out[count++] = (stretch){.from = t, .step = step};
            out[count - 1].to = until;
        }
        t = until;
    }
    if (count)
        out[count - 1].to = INFINITY; /* nothing lies behind */
    return count;
}

#endif
