/** @file
 * Making meshes.
 */
#ifndef VVI_GRID_MESH_H
#define VVI_GRID_MESH_H
#include "core/status.h"
#include <volvis/mesh.h>

/** Images of meshes: their copies share them. */
typedef struct vvi_mesh_textures vvi_mesh_textures;
/** One more, behind those of *inout, which is new where it is NULL and nobody else's; not looked at: pixels, which are
 * vvi_alloc()'s and the textures' from then on. On error they are still the caller's. */
vv_status vvi_mesh_textures_add(vvi_mesh_textures **inout, const vv_mesh_texture *texture, vv_job *job);
/** Those of `mesh` with pixels of their own; release *out in any case. */
vv_status vvi_mesh_textures_copy(vvi_mesh_textures **out, const vv_mesh_info *mesh, vv_job *job);
/** How many, and where; NULL is none. */
const vv_mesh_texture *vvi_mesh_textures_get(size_t *n_out, const vvi_mesh_textures *textures);
vvi_mesh_textures *vvi_mesh_textures_retain(vvi_mesh_textures *textures); /* NULL is fine */
void vvi_mesh_textures_release(vvi_mesh_textures *textures);              /* NULL is fine */

/** Arrays to fill before the mesh is shared. */
typedef struct vvi_mesh_arrays {
    float *positions, *normals, *values; /**< NULL where not asked for */
    uint8_t *colors;
    uint32_t *triangles;
    vv_mesh_part *parts; /**< zeroed, their colours not given */
    float *coordinates;
    uint32_t *coordinate_of;
    vvi_mesh_textures *textures;
} vvi_mesh_arrays;

/** CORNERS: coordinates of triangles' corners and not of vertices. */
enum {
    VVI_MESH_NORMALS = 1,
    VVI_MESH_VALUES = 2,
    VVI_MESH_COLORS = 4,
    VVI_MESH_COORDINATES = 8,
    VVI_MESH_CORNERS = 16,
    VVI_MESH_ALL = 31
};

/** An uninitialised mesh with the counts (n_parts too), origin, space, unit and names of `info`, whose arrays are not
 * looked at, and without textures. `with`: which optional arrays it has. Errors: VV_E_LIMIT (counts of 2^32 and more),
 * VV_E_MEMORY. */
vv_status vvi_mesh_new(vv_mesh **out, vvi_mesh_arrays *arrays_out, const vv_mesh_info *info, unsigned with,
                       vv_job *job);
/** A mesh of arrays that are there already, taken by vvi_alloc(): it frees them. On error they stay the caller's. */
vv_status vvi_mesh_adopt(vv_mesh **out, const vvi_mesh_arrays *arrays, const vv_mesh_info *info, vv_job *job);
/** A copy with the arrays of `with` and the same textures, to change before it is shared; those that the mesh does not
 * have are not initialised. */
vv_status vvi_mesh_copy(vv_mesh **out, vvi_mesh_arrays *arrays_out, const vv_mesh *mesh, unsigned with, vv_job *job);
/** A mesh that is not shared yet and has no textures gets those of another, whose parts its parts are. */
void vvi_mesh_take_textures(vv_mesh *mesh, const vv_mesh *from);
/** Its parts name none: they come from a mesh that has some. */
void vvi_mesh_leave_textures(vv_mesh *mesh);
/** A copy whose lengths are all multiplied by a factor above 0, in another unit. */
vv_status vvi_mesh_scaled(vv_mesh **out, const vv_mesh *mesh, double factor, const char *unit, vv_job *job);
/** One of its parts by itself, `index` below n_parts, with the vertices that it uses. Errors: VV_E_MEMORY. */
vv_status vvi_mesh_part(vv_mesh **out, const vv_mesh *mesh, size_t index, vv_job *job);
/** The same with coordinates of vertices in the place of those of corners: a vertex that had several is as many; others
 * that no triangle has go. Another reference where corners have none. Errors: VV_E_MEMORY, VV_E_CANCELLED. */
vv_status vvi_mesh_split_corners(vv_mesh **out, const vv_mesh *mesh, vv_job *job);
/** Its triangles and normals face the other way, of a mesh that is not shared yet. */
void vvi_mesh_turn(vv_mesh *mesh);
/** Another name for the unit of its lengths, of a mesh that is not shared yet. */
void vvi_mesh_set_unit(vv_mesh *mesh, const char *unit);
/** Which of the arrays that may lack it has. */
unsigned vvi_mesh_with(const vv_mesh *mesh);
unsigned vvi_mesh_arrays_of(const vv_mesh_info *mesh);
/** Textures of a mesh that is not shared yet and has none; they are the mesh's from then on. */
void vvi_mesh_set_textures(vv_mesh *mesh, vvi_mesh_textures *textures);
/** Whether these are arrays of a mesh, as vv_mesh_new() wants them: VV_E_ARGUMENT says what is wrong. */
vv_status vvi_mesh_check(const vv_mesh_info *info);
/** Bytes that its arrays take. */
uint64_t vvi_mesh_bytes(const vv_mesh *mesh);
/** For each vertex the first vertex of its piece: what triangles join by vertices that they share. *out: vvi_free().
 * On this thread. Errors: VV_E_MEMORY, VV_E_CANCELLED; *out is NULL then. */
vv_status vvi_mesh_number_pieces(uint32_t **out, const vv_mesh *mesh, vv_job *job);
/** The same where place[v], at most v, stands for vertex v; NULL: itself. */
vv_status vvi_mesh_number_placed_pieces(uint32_t **out, const vv_mesh_info *mesh, const uint32_t *place, vv_job *job);
/** How the runs of triangles along edges pair up. */
typedef struct vvi_mesh_edges {
    size_t n, open, crowded, turned; /**< as in vv_mesh_topology */
    size_t uneven;                   /**< of those: more runs one way than the other, so that there is no inside */
    uint32_t first[2];               /**< vertices of the first uneven one */
} vvi_mesh_edges;

/** Edges of the mesh's triangles. place: of each vertex the one that stands for it; NULL: itself. On this thread.
 * Errors: VV_E_MEMORY, VV_E_CANCELLED. */
vv_status vvi_mesh_count_edges(vvi_mesh_edges *out, const vv_mesh_info *mesh, const uint32_t *place, vv_job *job);
/** A value at each vertex, to fill before the mesh is shared, in place of those that it had. `name` and `unit` as in
 * vv_mesh_info. On error the mesh is as it was. */
vv_status vvi_mesh_add_values(float **out, vv_mesh *mesh, const char *name, const char *unit, vv_job *job);
/** The same for parts: zeroed, their colours not given. */
vv_status vvi_mesh_add_parts(vv_mesh_part **out, vv_mesh *mesh, size_t n, vv_job *job);
/** What a field has at each vertex, whose place is to_index of the vertex's: linear between samples, or the nearest; up
 * to half a sample beyond the outermost their value, farther out NaN. out: n_vertices. */
vv_status vvi_mesh_values_of(float *out, const vv_mesh_info *mesh, const vv_affine *to_index, const vv_field *field,
                             int component, bool nearest, vv_job *job);
#endif
