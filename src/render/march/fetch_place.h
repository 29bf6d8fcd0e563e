/** @file
 * What ways to fetch samples have in common. For kernels only.
 */
#ifndef VVI_RENDER_MARCH_FETCH_PLACE_H
#define VVI_RENDER_MARCH_FETCH_PLACE_H
#include "core/simd_vec.h"
#include "grid/lattice.h"

/** Offsets of a sample: x and y count samples; what z counts, the way to fetch says. */
typedef struct sample_place {
    vi x, y, z;
} sample_place;

/** One sample of each lane: the offset in its slice, and that of the slice. Where both count samples, either may have
 * all of it. */
typedef struct spot {
    vi at, z;
} spot;

#endif
