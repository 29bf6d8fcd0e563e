/** @file
 * Floods: labels that spread over a volume in the order of its values.
 */
#ifndef VVI_SEGMENT_FLOOD_H
#define VVI_SEGMENT_FLOOD_H
#include "core/job.h"
#include "segment/neighbours.h"

/** Labels that are none. Those of voxels from VVI_FLOOD_OUTSIDE on are for the flood. */
enum { VVI_FLOOD_NONE = 0 };
#define VVI_FLOOD_OUTSIDE 0xfffffffdu /* never flooded */
#define VVI_FLOOD_LINE 0xfffffffeu    /* between basins */
#define VVI_FLOOD_WAITS 0xffffffffu

/** Heights of voxels, as whole numbers in their order: one of the two. */
typedef struct vvi_heights {
    const uint32_t *narrow;
    const int64_t *wide;
    int64_t lo, hi; /**< of all voxels that are flooded */
} vvi_heights;

static inline int64_t vvi_height_at(const vvi_heights *h, int64_t at)
{
    return h->narrow ? (int64_t)h->narrow[at] : h->wide[at];
}

/** Basins that are not deep become one with the next: what a flood of minima needs. */
typedef struct vvi_basins {
    uint32_t n;
    uint32_t *parent; /**< by label, 1 to n; parent[0] is 0 */
    double *bottom;   /**< by label: the value of its lowest voxel */
    double depth;
    double (*value)(const void *user, int64_t height);
    const void *user;
} vvi_basins;

/** The label that a basin has become part of. */
uint32_t vvi_basins_root(vvi_basins *basins, uint32_t label);

/**
 * Labels the connected parts of equal height that have no lower neighbour, 1 to *n_out in the order of their first
 * voxels; voxels of label 0 that are none keep it. `room`: a number for each voxel.
 */
vv_status vvi_minima_label(uint32_t *label, uint32_t *n_out, const vvi_heights *heights, const vvi_neighbours *around,
                           uint32_t *room, vv_job *job);

/**
 * Labels spread to voxels of label 0, in the order of their heights, but never below the height that the flood has
 * reached already; of one height, in the order in which they were reached. Those that have a label at first are taken
 * as if they were reached in the order of their numbers. Where `lines`, voxels that several basins reach become
 * VVI_FLOOD_LINE. basins: NULL where none become one. `next`: a number for each voxel.
 */
vv_status vvi_flood(uint32_t *label, const vvi_heights *heights, const vvi_neighbours *around, bool lines,
                    vvi_basins *basins, uint32_t *next, vv_job *job);
#endif
