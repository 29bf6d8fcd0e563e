/** @file
 * What of a mesh lies in an ellipsoid.
 */
#ifndef VVI_MEASURE_MESH_ELLIPSOID_H
#define VVI_MEASURE_MESH_ELLIPSOID_H
#include "core/status.h"
#include <volvis/measure.h>
#include <volvis/mesh.h>

typedef struct vvi_mesh_inside {
    size_t n_triangles; /**< of which a part is inside */
    double area;        /**< of these parts */
    double volume;      /**< that a closed mesh has in common with the ellipsoid; below 0 where it faces inwards */
} vvi_mesh_inside;

/**
 * Area of the surface, and volume of what it encloses, within an ellipsoid, in closed form.
 *
 * The ellipsoid becomes the unit ball. The volume between its middle and a triangle is a cone: of the part within the
 * ball height times area / 3, of the rest its solid angle / 3, as the ball ends there. A triangle and the circle that
 * its plane cuts out of the ball have in common what triangles and sectors between the circle's middle and the sides
 * add up to.
 *
 * Units    of to_world's world
 * Errors   VV_E_MEMORY, VV_E_CANCELLED
 * Threads  any; same bytes for any thread count
 * Source   van Oosterom & Strackee 1983 (solid angles)
 */
vv_status vvi_mesh_in_ellipsoid(vvi_mesh_inside *out, const vv_mesh *mesh, const vv_affine *to_world,
                                const vv_region_shape *ellipsoid, vv_job *job);
#endif
