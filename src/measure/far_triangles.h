/** @file
 * Which triangles of a surface have places farther from another surface than some length.
 *
 * To know that is far less work than to know how far they are: where something is near enough nobody looks for what is
 * nearest.
 */
#ifndef VVI_MEASURE_FAR_TRIANGLES_H
#define VVI_MEASURE_FAR_TRIANGLES_H
#include "measure/bvh.h"

#define VVI_NOT_BEYOND UINT32_MAX

typedef struct vvi_beyond {
    uint32_t *of; /**< of each triangle of a's mesh, set: VVI_NOT_BEYOND, or the triangle of b's mesh that is nearest to
                     a place of it which lies too far from b */
    const uint8_t *skip; /**< of each triangle of a: not 0: it counts as not beyond; NULL: of none */
    size_t step;         /**< every so many triangles are looked at; the others count as not beyond */
    size_t n;            /**< set: triangles that have such places */
    double largest; /**< set: of the distances that were looked at; 0 where all are less than half of what is asked */
} vvi_beyond;

/** Triangles that are not beyond lie within `distance` (at least 0) of b with all their places: that is certain. Those
 * where something is within the rounding of positions of the distance, or could not be decided in 32768 places, may
 * count as beyond. Same result for any thread count. Errors: VV_E_MEMORY, VV_E_CANCELLED. */
vv_status vvi_mesh_beyond(vvi_beyond *out, const vv_mesh_tree *a, const vv_mesh_tree *b, double distance, vv_job *job);
#endif
