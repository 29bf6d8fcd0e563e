/** @file
 * Distances and angles: between points, from points to surfaces, between surfaces.
 */
#ifndef VOLVIS_MEASURE_DISTANCE_H
#define VOLVIS_MEASURE_DISTANCE_H
#include <volvis/measure_mesh.h>
VV_BEGIN_DECLS

VV_API double vv_distance(vv_vec3 a, vv_vec3 b);
/** Sum of the lengths between neighbours; 0 for less than two points. */
VV_API double vv_polyline_length(const vv_vec3 *points, size_t n);
/** Between two directions, 0 .. pi, however small; NaN when one has no length. Source: Kahan 2006. */
VV_API double vv_angle_between(vv_vec3 a, vv_vec3 b);
/** At `apex`, between the directions to a and b, as above. */
VV_API double vv_angle_at(vv_vec3 a, vv_vec3 apex, vv_vec3 b);

/** A mesh made ready to be asked for what lies nearest. Immutable and reference-counted; share it freely between
 * threads. */
typedef struct vv_mesh_tree vv_mesh_tree;

/**
 * Units    to_world (NULL: identity) is applied to every vertex; places and distances are after that
 * Errors   VV_E_ARGUMENT (a mesh without triangles, a vertex that is not finite), VV_E_MEMORY, VV_E_CANCELLED
 * Owns     keeps the mesh
 * Threads  any; same bytes for any thread count
 * Memory   about 50 bytes a triangle
 * Source   boxes of 8 over triangles along a Hilbert curve: Kamel & Faloutsos 1993; the curve: Skilling 2004
 */
VV_API vv_status vv_mesh_tree_new(vv_mesh_tree **out, const vv_mesh *mesh, const vv_affine *to_world, vv_job *job);
VV_API vv_mesh_tree *vv_mesh_tree_retain(const vv_mesh_tree *tree);
VV_API void vv_mesh_tree_release(vv_mesh_tree *tree); /* NULL is fine */
/** Every edge has as many triangles on one side as on the other: there is an inside. */
VV_API bool vv_mesh_tree_closed(const vv_mesh_tree *tree);

/** The nearest place of a surface. */
typedef struct vv_mesh_foot {
    vv_vec3 at;
    double distance;        /**< not negative */
    double signed_distance; /**< negative inside; NaN when the mesh is open */
    uint32_t triangle;      /**< of the mesh */
    double weights[3];      /**< of its corners in `at`; not negative, their sum is 1 */
} vv_mesh_foot;

/** Of several places that are equally near, one. Inside is what the normal at the foot says: at edges and corners the
 * mean of those around by their angles (Baerentzen & Aanaes 2005). Any thread. */
VV_API void vv_mesh_tree_nearest(vv_mesh_foot *out, const vv_mesh_tree *tree, vv_vec3 point);

/** The least distance of two surfaces, 0 where they cross, and where that is. Errors: VV_E_MEMORY, VV_E_CANCELLED. */
VV_API vv_status vv_mesh_least_distance(vv_mesh_foot *on_a_out, vv_mesh_foot *on_b_out, const vv_mesh_tree *a,
                                        const vv_mesh_tree *b, vv_job *job);

/** Options of vv_mesh_distance(). Fill with vv_mesh_distance_options_init(), then change what you need. */
typedef struct vv_mesh_distance_options {
    size_t size;    /**< set by init */
    double density; /**< samples by area; default 0: 200 000 on each surface */
    uint64_t seed;  /**< of the samples; default 1 */
    char unit[16];  /**< of lengths; default "": that of the first mesh */
} vv_mesh_distance_options;

/** Distances from the places of one surface to the nearest of another. */
typedef struct vv_mesh_deviation {
    vv_figure mean; /**< by area. error: twice the standard error of the sample mean */
    vv_figure rms;  /**< the same */
    vv_figure max;  /**< one-sided Hausdorff distance: the largest that was found. It is never too large; error: by how
                         much it may be too small, a strict bound but for rounding */
    vv_vec3 worst, worst_foot; /**< where that is: on this surface, and on the other */
    size_t n_samples;          /**< besides the vertices, which count for max alone */
} vv_mesh_deviation;

typedef struct vv_mesh_distances {
    vv_mesh_deviation a_to_b, b_to_a;
    vv_figure hausdorff; /**< the larger of both max */
} vv_mesh_distances;

VV_API void vv_mesh_distance_options_init(vv_mesh_distance_options *options, size_t size);

/**
 * Mean, root mean square and Hausdorff distance of two surfaces, both ways.
 *
 * Samples are spread evenly by area at random; all vertices are looked at besides. The distance to one triangle is a
 * convex function: over a triangle it is nowhere larger than at its corners. So, of the triangles that are nearest to
 * the corners, the one whose largest distance to the three is least bounds what samples may have missed. Triangles
 * are divided, those with the largest bound first, until none is a thousandth above the largest distance, or as many
 * places have been looked at as there are triangles, and 2^18 more.
 *
 * Errors   VV_E_ARGUMENT (density negative or no number, more than 2^40 samples), VV_E_MEMORY, VV_E_CANCELLED
 * Threads  any; same bytes for any thread count
 * Source   Cignoni, Rocchini & Scopigno 1998 (sampling); Guthe, Borodin & Klein 2005 (bounds)
 */
VV_API vv_status vv_mesh_distance(vv_mesh_distances *out, const vv_mesh_tree *a, const vv_mesh_tree *b,
                                  const vv_mesh_distance_options *options, vv_job *job);

VV_END_DECLS
#endif
