/** @file
 * Whether taking a voxel away from an object changes how it hangs together.
 */
#ifndef VVI_SEGMENT_SIMPLE_POINTS_H
#define VVI_SEGMENT_SIMPLE_POINTS_H
#include <stdbool.h>
#include <stdint.h>

/** The 27 voxels around and with one, a bit each, x fastest: bit 13 is its own. */
enum { VVI_AROUND = 27, VVI_AROUND_OWN = 13 };
/** Those that touch the middle one at a face. */
#define VVI_AROUND_BESIDE (1u << 4 | 1u << 10 | 1u << 12 | 1u << 14 | 1u << 16 | 1u << 22)

/** Whether the object of these bits (26-connected, the background 6-connected) has the same parts, cavities and tunnels
 * without the middle one: one part of it around that voxel, and one of the background beside it (Bertrand & Malandain
 * 1994). The middle bit is not looked at. */
bool vvi_is_simple(uint32_t object);
#endif
