/** @file
 * Boxes around the triangles of a mesh, in boxes.
 *
 * Triangles lie along a Hilbert curve, VVI_BVH_LEAF to a leaf; leaf i is child i % 8 of node i / 8 of level 0, node i
 * of a level is child i % 8 of node i / 8 of the next, and the last level has one node. Nothing points to anything.
 */
#ifndef VVI_MEASURE_BVH_H
#define VVI_MEASURE_BVH_H
#include "core/status.h"
#include "measure/triangle.h"
#include <stdatomic.h>
#include <volvis/measure_distance.h>

enum { VVI_BVH_LEAF = 4, VVI_BVH_LEVELS = 12 };

/** Boxes of eight children; those that there are not are empty: lo infinity, hi -infinity. */
typedef struct vvi_bvh_node {
    float lo[3][8], hi[3][8];
} vvi_bvh_node;

struct vv_mesh_tree {
    atomic_int references;
    vv_mesh *mesh;
    vv_affine map;  /**< of the mesh's positions to the world, which is `origin` + what is stored here */
    vv_vec3 origin; /**< the middle of the bounding box, so that floats are good enough for boxes */
    vv_bounds box;  /**< from the origin */
    double radius;  /**< of the box */
    double area;
    bool closed;
    bool inside_out;  /**< its triangles face inwards */
    bool kept_places; /**< the mesh's positions could be taken as they are */
    size_t n;         /**< triangles */
    float *corners;   /**< 9 a triangle, in the order of the tree, from `origin` */
    uint32_t *order;  /**< number of each in the mesh */
    int n_levels;
    vvi_bvh_node *level[VVI_BVH_LEVELS];
    size_t n_nodes[VVI_BVH_LEVELS];
};

/** vv_mesh_tree_new() of a mesh that nobody asks on which side of it something lies: as if it were open, which is found
 * sooner. */
vv_status vvi_bvh_new(vv_mesh_tree **out, const vv_mesh *mesh, vv_job *job);
/** Triangle `index` in the order of the tree, from the tree's origin. */
vvi_triangle vvi_bvh_triangle(const vv_mesh_tree *tree, size_t index);
/** The triangle nearest to p (from the origin), by index in the order of the tree; its squared distance. `hint`: one
 * that may be near. */
size_t vvi_bvh_nearest(double *square_out, const vv_mesh_tree *tree, vv_vec3 p, size_t hint);
/** The same, or any triangle whose squared distance is at most `enough`, which is found sooner. */
size_t vvi_bvh_within(double *square_out, const vv_mesh_tree *tree, vv_vec3 p, double enough, size_t hint);
/** Box of child c of a node, as doubles. */
vv_bounds vvi_bvh_child(const vvi_bvh_node *node, int c);
/** What the tree stores for vertex v of the mesh: its place from the origin. */
vv_vec3 vvi_bvh_vertex(const vv_mesh_tree *tree, size_t v);
#endif
