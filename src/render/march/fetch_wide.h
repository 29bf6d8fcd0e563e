/** @file
 * Samples in one array whose offsets do not fit 32 bits: places count slices along z. For kernels only.
 *
 * Loads of single lanes with 64-bit addresses, out of line: large volumes wait for memory anyway.
 */
#ifndef VVI_RENDER_MARCH_FETCH_WIDE_H
#define VVI_RENDER_MARCH_FETCH_WIDE_H
#include "render/march/fetch_place.h"

enum { wide_near = false };

VV_INLINE void wide_place(sample_place *out, const vvi_lattice *g, vi i, vi j, vi k, vm m)
{
    (void)m;
    out->x = i;
    out->y = j * vi_set1(g->row);
    out->z = k;
}

VV_INLINE int32_t wide_slice(const vvi_lattice *g)
{
    (void)g;
    return 1;
}

static __attribute__((noinline)) void load_lanes(vi out[2], const vvi_lattice *g, int bytes, const spot *s, vm m)
{
    int32_t at[VV_WIDTH], z[VV_WIDTH], low[VV_WIDTH] = {0}, high[VV_WIDTH] = {0};
    const uint32_t live = vm_bits(m);
    vi_store(at, s->at);
    vi_store(z, s->z);
    for (int l = 0; l < VV_WIDTH; l++) {
        if (!(live >> l & 1))
            continue;
        const char *from = (const char *)g->data + (z[l] * g->slice + at[l]) * bytes;
        memcpy(&low[l], from, 4);
        memcpy(&high[l], from + 4, 4);
    }
    out[0] = vi_load(low);
    out[1] = vi_load(high);
}

VV_INLINE void wide_words(vi *low, vi *high, const vvi_lattice *g, int type, const spot *s, vm m)
{
    vi words[2];
    load_lanes(words, g, type == VVI_SAMPLE_U8 ? 1 : type == VVI_SAMPLE_F32 ? 4 : 2, s, m);
    *low = words[0];
    if (high)
        *high = words[1];
}

#endif
