/** @file
 * The boxes that hold a surface, as triangles: the coarser of the Navigator's two reduced representations. They are the
 * boxes of PARC (Avila, Sobierajski and Kaufman 1992): blocks of cells whose range of values has the surface's in it.
 */
#ifndef VVI_SURFACE_BOXES_H
#define VVI_SURFACE_BOXES_H
#include "grid/boxes.h"
#include <volvis/mesh.h>

typedef struct vvi_surface_boxes_options {
    double value; /**< of the surface, in the field's values */
    int component;
    int shift;            /**< boxes of 2^shift cells a side, 2 to 16; 0: the smallest that the budget allows, from 4 */
    size_t max_triangles; /**< 0: no limit. Larger boxes are taken until there are no more; not if shift is given */
    bool merged; /**< faces beside each other in one plane become rectangles: a third to a tenth of the triangles. Their
                    corners may lie on the sides of others */
} vvi_surface_boxes_options;

/**
 * The outer faces of the boxes that the surface passes through. Every place of the surface is in or on a box.
 *
 * Result   a closed mesh; four vertices and two triangles a face, with the face's normal at all four
 * Errors   VV_E_ARGUMENT, VV_E_LIMIT, VV_E_MEMORY, VV_E_READ, VV_E_CANCELLED
 * Owns     *out is the caller's
 * Threads  same bytes for any thread count
 */
vv_status vvi_surface_boxes(vv_mesh **out, const vv_field *field, const vvi_surface_boxes_options *options,
                            vv_job *job);

/** The same, and a field with a sample in the middle of each box: 0 where all of it is below the value, 1 where the
 * surface passes through, 2 where all is above. Also the caller's; NULL: not asked for. */
vv_status vvi_surface_boxes_solid(vv_mesh **out, vv_field **solid_out, const vv_field *field,
                                  const vvi_surface_boxes_options *options, vv_job *job);

/** The outer faces of any list of boxes on a grid. */
vv_status vvi_boxes_mesh(vv_mesh **out, const vvi_boxes *boxes, const vv_grid *grid, bool merged, vv_job *job);
#endif
