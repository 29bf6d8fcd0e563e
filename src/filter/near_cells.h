/** @file
 * What is within a distance of some triangles, in cells of space: never too little, sometimes too much.
 */
#ifndef VVI_FILTER_NEAR_CELLS_H
#define VVI_FILTER_NEAR_CELLS_H
#include "core/status.h"
#include <volvis/mesh.h>

typedef struct vvi_near_cells {
    double lo[3], per_length[3], distance;
    size_t n[3];
    uint8_t *marked;
} vvi_near_cells;

/** Over the bounds of a mesh. Owns: vvi_near_cells_finish(). Errors: VV_E_MEMORY. */
vv_status vvi_near_cells_init(vvi_near_cells *cells, const vv_mesh_info *mesh, double distance, vv_job *job);
void vvi_near_cells_finish(vvi_near_cells *cells);
void vvi_near_cells_clear(vvi_near_cells *cells);
/** All that is within the distance of the triangle with these corners. */
void vvi_near_cells_mark(vvi_near_cells *cells, const float *positions, const uint32_t corner[3]);
/** Whether the triangle comes into a cell that is marked. */
bool vvi_near_cells_touch(const vvi_near_cells *cells, const float *positions, const uint32_t corner[3]);
#endif
