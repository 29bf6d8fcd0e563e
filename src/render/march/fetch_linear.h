/** @file
 * Samples in one array, x fastest, whose offsets fit 32 bits. For kernels only.
 *
 * A 32-bit gather at an 8- or 16-bit sample fetches its right neighbour as well, so that a trilinear value takes 4
 * gathers, and an 8-bit value with its central-difference gradient 12: that is why lattices need guard bytes after the
 * last sample (vv_field_new).
 */
#ifndef VVI_RENDER_MARCH_FETCH_LINEAR_H
#define VVI_RENDER_MARCH_FETCH_LINEAR_H
#include "render/march/fetch_place.h"

enum { linear_near = true };

VV_INLINE void linear_place(sample_place *out, const vvi_lattice *g, vi i, vi j, vi k, vm m)
{
    (void)m;
    out->x = i;
    out->y = j * vi_set1(g->row);
    out->z = k * vi_set1((int32_t)g->slice);
}

VV_INLINE int32_t linear_slice(const vvi_lattice *g)
{
    return (int32_t)g->slice;
}

VV_INLINE void linear_words(vi *low, vi *high, const vvi_lattice *g, int type, const spot *s, vm m)
{
    const vi at = s->at + s->z;
    if (type == VVI_SAMPLE_U8)
        *low = vi_gather(g->data, at, m);
    else if (type == VVI_SAMPLE_F32)
        vi_gather_pair4(g->data, at, m, low, high);
    else if (high)
        vi_gather_pair2(g->data, at, m, low, high);
    else
        *low = vi_gather2(g->data, at, m);
}

#endif
