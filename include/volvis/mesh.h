/** @file
 * Triangle meshes: immutable, reference-counted vertices and triangles.
 */
#ifndef VOLVIS_MESH_H
#define VOLVIS_MESH_H
#include <volvis/field.h>
VV_BEGIN_DECLS

typedef struct vv_mesh vv_mesh;

/** How an image goes on beyond its borders. */
typedef enum vv_texture_wrap { VV_WRAP_REPEAT, VV_WRAP_MIRROR, VV_WRAP_CLAMP } vv_texture_wrap;

/** An image on triangles. */
typedef struct vv_mesh_texture {
    char name[64];         /**< of its file; "" when it has none */
    int32_t width, height; /**< at least 1 */
    int wrap[2];           /**< vv_texture_wrap along u and along v */
    const uint8_t *pixels; /**< red, green, blue, alpha of each, sRGB, as `colors` below; rows from the top */
} vv_mesh_texture;

/** A run of triangles that is one object. */
typedef struct vv_mesh_part {
    char name[64];  /**< "" when it has none */
    vv_color color; /**< linear, of triangles whose vertices have no colours of their own; a < 0: none is given */
    size_t first_triangle, n_triangles;
    /** 1 + number of the texture by which the colours of its triangles are multiplied (those of vertices, else its own,
     * else white); 0: none. */
    size_t texture;
} vv_mesh_part;

/** What a mesh is, and its arrays, which live as long as the mesh. Place of a vertex = origin + position. */
typedef struct vv_mesh_info {
    size_t n_vertices, n_triangles; /**< each below 2^32 */
    vv_vec3 origin;                 /**< in double precision, so that positions far from zero lose nothing */
    const float *positions;         /**< x y z for each vertex */
    const float *normals;           /**< the same, of length 1, or 0 where there is none; NULL: no normals */
    const float *values;            /**< one for each vertex; NULL: none */
    const uint8_t *colors;          /**< red, green, blue, alpha of each vertex, sRGB; NULL: none */
    const uint32_t *triangles;      /**< three vertices each, counter-clockwise as seen from outside */
    size_t n_parts;
    const vv_mesh_part
        *parts; /**< in the order of their triangles, all of which they have; NULL: one object without name */
    vv_space space;
    vv_up up;
    char unit[16];       /**< of lengths, as in vv_grid */
    char value_name[64]; /**< what `values` are; "" when not known */
    char value_unit[16];
    size_t n_coordinates;
    const float *coordinates; /**< u v each, on textures: (0, 0) is the lower left corner of an image, (1, 1) the upper
                                 right one; NULL: none */
    const uint32_t *coordinate_of; /**< which of them the three corners of each triangle have; NULL: each vertex has the
                                      one of its number */
    size_t n_textures;
    const vv_mesh_texture *textures; /**< NULL: none */
} vv_mesh_info;

/**
 * A mesh of arrays that you have: those of `info`, with its counts and texts, which may all be 0 beside positions,
 * triangles and their numbers. Normals are made of length 1; unit "" becomes "units"; values may be NaN where there is
 * none.
 *
 * Errors   VV_E_ARGUMENT (a position or normal that is not finite, a triangle of a vertex that there is not, parts that
 *          do not follow each other or leave out triangles, coordinates and textures that there are not, texts without
 *          an end), VV_E_LIMIT (2^32 vertices or triangles and more), VV_E_MEMORY
 * Owns     *out is new and yours; on error it is NULL. Arrays and texts are copied before this returns
 */
VV_API vv_status vv_mesh_new(vv_mesh **out, const vv_mesh_info *info, vv_job *job);
VV_API vv_mesh *vv_mesh_retain(const vv_mesh *mesh);
VV_API void vv_mesh_release(vv_mesh *mesh); /* NULL is fine */
VV_API const vv_mesh_info *vv_mesh_get_info(const vv_mesh *mesh);
/** CRC-32 of all arrays and names, as of the samples of a field: tells one mesh from another. */
VV_API uint32_t vv_mesh_checksum(const vv_mesh *mesh);
/** Box of all vertices; empty for none. */
VV_API vv_bounds vv_mesh_bounds(const vv_mesh *mesh);
/** How the triangles of a mesh hang together. Those that use one vertex twice are degenerate and have no edges. */
typedef struct vv_mesh_topology {
    size_t n_edges;
    size_t n_open_edges;    /**< of one triangle only: where the mesh ends */
    size_t n_crowded_edges; /**< of more than two triangles: the mesh is not manifold there */
    size_t n_turned_edges;  /**< of two triangles that run along it in the same direction: one of them faces the wrong
                               way */
    size_t n_degenerate;    /**< triangles without area */
    size_t n_unused;        /**< vertices of no triangle */
    size_t n_pieces;        /**< that share no vertex with each other */
} vv_mesh_topology;

/** Time by triangles; about 12 bytes a triangle and 24 a vertex of memory. A mesh is closed when it has no open and no
 * crowded edges, and faces one way when it has no turned ones. Errors: VV_E_MEMORY, VV_E_LIMIT, VV_E_CANCELLED. */
VV_API vv_status vv_mesh_count_topology(vv_mesh_topology *out, const vv_mesh *mesh, vv_job *job);

VV_END_DECLS
#endif
