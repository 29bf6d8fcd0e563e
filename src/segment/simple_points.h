/** @file
 * Whether taking a voxel away from an object changes how it hangs together.
 */
#ifndef VVI_SEGMENT_SIMPLE_POINTS_H
#define VVI_SEGMENT_SIMPLE_POINTS_H
#include <stdbool.h>
#include <stdint.h>

/** The 27 voxels around and with one, a bit each, x fastest: bit 13 is its own. */
enum { VVI_AROUND = 27, VVI_AROUND_OWN = 13 };

typedef struct vvi_around_tables {
    uint32_t corners[VVI_AROUND]; /**< of each: those that touch it at least at a corner */
    uint32_t faces[VVI_AROUND];   /**< at a face */
    uint32_t near;                /**< those that touch the middle one at an edge at least */
    uint32_t beside;              /**< at a face */
} vvi_around_tables;

vvi_around_tables vvi_around_tables_make(void);
/** Whether the object of these bits (26-connected, the background 6-connected) has the same parts, cavities and tunnels
 * without the middle one: one part of it around that voxel, and one of the background beside it (Bertrand & Malandain
 * 1994). The middle bit is not looked at. */
bool vvi_is_simple(uint32_t object, const vvi_around_tables *tables);
#endif
