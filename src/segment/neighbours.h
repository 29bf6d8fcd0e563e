/** @file
 * The voxels around each one, by number.
 */
#ifndef VVI_SEGMENT_NEIGHBOURS_H
#define VVI_SEGMENT_NEIGHBOURS_H
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum { VVI_NEIGHBOURS_MOST = 26 };

/** Faces first, then edges, then corners; of each, x fastest. */
typedef struct vvi_neighbours {
    int64_t n[3];
    int count;
    int step[VVI_NEIGHBOURS_MOST][3];
    int64_t offset[VVI_NEIGHBOURS_MOST];
} vvi_neighbours;

/** Of a volume of n samples; `axes`: how many of them neighbours differ by at most. */
static inline vvi_neighbours vvi_neighbours_of(const int64_t n[3], int axes)
{
    vvi_neighbours out = {.n = {n[0], n[1], n[2]}};
    for (int differ = 1; differ <= axes; differ++)
        for (int code = 0; code < 27; code++) {
            const int x = code % 3 - 1, y = code / 3 % 3 - 1, z = code / 9 - 1;
            if ((x != 0) + (y != 0) + (z != 0) != differ)
                continue;
            out.step[out.count][0] = x;
            out.step[out.count][1] = y;
            out.step[out.count][2] = z;
            out.offset[out.count++] = x + n[0] * (y + n[1] * (int64_t)z);
        }
    return out;
}

/** Numbers of those of a voxel that are in the volume; how many there are. */
static inline int vvi_neighbours_at(int64_t out[VVI_NEIGHBOURS_MOST], const vvi_neighbours *b, int64_t at)
{
    const int64_t row = at / b->n[0], p[3] = {at - row * b->n[0], row % b->n[1], row / b->n[1]};
    int count = 0;
    if (p[0] > 0 && p[0] < b->n[0] - 1 && p[1] > 0 && p[1] < b->n[1] - 1 && p[2] > 0 && p[2] < b->n[2] - 1) {
        for (; count < b->count; count++)
            out[count] = at + b->offset[count];
        return count;
    }
    for (int i = 0; i < b->count; i++) {
        bool inside = true;
        for (int a = 0; a < 3; a++)
            inside &= p[a] + b->step[i][a] >= 0 && p[a] + b->step[i][a] < b->n[a];
        if (inside)
            out[count++] = at + b->offset[i];
    }
    return count;
}
#endif
