/** @file
 * What the parts of reading glTF share: a mesh that grows while the nodes of a file are walked.
 */
#ifndef VVI_IO_GLTF_READER_H
#define VVI_IO_GLTF_READER_H
#include "io/meshes/gltf.h"
#include "io/meshes/mesh_texture.h"

/** What the vertices of a primitive are; the same for the next one of many files' parts. */
typedef struct vvi_gltf_attributes {
    size_t position, normal, color, value, coordinate;
    bool has_position, has_normal, has_color, has_value, has_coordinate;
    double factor[4];        /**< of colours */
    vvi_texture_alpha alpha; /**< what that of colours means */
    double cutoff;
    double to_image[2][3]; /**< coordinates there to those here: rows */
} vvi_gltf_attributes;

/** What a primitive's triangles look like. */
typedef struct vvi_gltf_material {
    double factor[4], color[4];
    vvi_texture_alpha alpha;
    double cutoff; /**< of MASK */
    bool colored;  /**< color is there: the factor, or what our own writer noted of a part beside colours of vertices */
    int64_t coordinates; /**< number of the attribute */
    double to_image[2][3];
    size_t texture; /**< as in vv_mesh_part */
} vvi_gltf_material;

/** An image of the file that was read with an alpha and in a way of going on. */
typedef struct vvi_gltf_image {
    const json_t *image;
    vvi_texture_use use;
    size_t texture;
} vvi_gltf_image;

typedef struct vvi_gltf_reader {
    vvi_gltf g;
    vvi_mesh_builder b;
    vv_affine from_scene; /**< to the mesh's axes and unit */
    bool *seen;           /**< nodes */
    vvi_gltf_attributes last;
    vv_affine last_map;
    size_t first_vertex; /**< of the last ones */
    size_t n_other;      /**< primitives of points and lines */
    bool counting;       /**< the first of two walks: nothing is made yet */
    bool any_colors;     /**< some vertices have colours: all others have their material's */
    vvi_gltf_image *images;
    size_t n_images;
    uint64_t n_vertices, n_triangles, n_objects; /**< counted */
    vv_notes *notes;
} vvi_gltf_reader;

/** What is seen of an alpha. */
double vvi_gltf_opacity(double alpha, vvi_texture_alpha means, double cutoff);
/** That of a primitive, and its image, which is read while the reader does not count. */
vv_status vvi_gltf_find_material(vvi_gltf_material *out, vvi_gltf_reader *r, const json_t *primitive);

vv_status vvi_gltf_find_attributes(vvi_gltf_attributes *out, const vvi_gltf_reader *r, const json_t *primitive,
                                   const vvi_gltf_material *m);
/** Whether they are those of the last primitive, placed as it was: its vertices do for both. */
bool vvi_gltf_same_attributes(const vvi_gltf_reader *r, const vvi_gltf_attributes *a, const vv_affine *map);
/** Adds vertices where they are not the last ones. */
vv_status vvi_gltf_put_vertices(vvi_gltf_reader *r, const vvi_gltf_attributes *a, const vv_affine *map);
#endif
