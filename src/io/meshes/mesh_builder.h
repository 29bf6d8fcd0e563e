/** @file
 * Meshes that grow while a file is read: what all readers of mesh files share. Every check of what came is made here,
 * in vvi_mesh_builder_finish().
 */
#ifndef VVI_IO_MESH_BUILDER_H
#define VVI_IO_MESH_BUILDER_H
#include "grid/mesh.h"
#include "io/notes.h"
#include "io/source.h"

/** A polygon of more than three corners that stands as a fan of n - 2 triangles. */
typedef struct vvi_mesh_fan {
    uint32_t first_triangle, n;
} vvi_mesh_fan;

typedef struct vvi_mesh_builder {
    vv_job *job;
    vv_source *source;      /**< is told what is taken of memory */
    const char *file;       /**< stands in errors */
    vv_mesh_info info;      /**< counts, and what the reader sets: space, unit, names, and the origin */
    vvi_mesh_arrays arrays; /**< to be filled between the calls that make room */
    double *places;         /**< x y z in double precision, instead of arrays.positions */
    uint32_t *part_of;      /**< of each triangle; NULL while there is no second part */
    uint32_t part;          /**< of the triangles that come */
    bool precise;           /**< places are there */
    unsigned with;          /**< VVI_MESH_NORMALS, ... */
    bool unit_given;        /**< info.unit is the file's */
    vvi_mesh_fan *fans;     /**< to be looked at: they may be concave */
    size_t n_fans, room_fans, room_vertices, room_triangles, room_parts, room_coordinates;
    size_t n_cut; /**< names of parts that were too long */
} vvi_mesh_builder;

/** precise: places come in more than single precision. unit: where the file says none. */
void vvi_mesh_builder_begin(vvi_mesh_builder *out, vv_source *source, const vv_mesh_read_options *options, bool precise,
                            vv_job *job);
/** Room for exactly so many more, for who knows; else it doubles by itself. */
vv_status vvi_mesh_builder_reserve(vvi_mesh_builder *b, uint64_t n_vertices, uint64_t n_triangles);
/** From now on vertices have these: those that are there get none (0), no value (NaN), white, coordinates 0, 0. With
 * VVI_MESH_CORNERS triangles have coordinates, by number: 0, which is 0, 0, until vvi_mesh_builder_corners(). */
vv_status vvi_mesh_builder_with(vvi_mesh_builder *b, unsigned with);
/** n more vertices, uninitialised but for what `with` gives by default. */
vv_status vvi_mesh_builder_vertices(vvi_mesh_builder *b, size_t n);
/** n more triangles of the current part, uninitialised. */
vv_status vvi_mesh_builder_triangles(vvi_mesh_builder *b, size_t n);
/** One more. */
vv_status vvi_mesh_builder_triangle(vvi_mesh_builder *b, const uint32_t corner[3]);
/** Triangles of a polygon; n at least 3. Concave ones are cut right when all is there. */
vv_status vvi_mesh_builder_polygon(vvi_mesh_builder *b, const uint32_t *corner, size_t n);
/** Triangles of a strip, every second one turned; those that use a vertex twice only tie pieces and are left out. */
vv_status vvi_mesh_builder_strip(vvi_mesh_builder *b, const uint32_t *corner, size_t n);
/** Triangles that come belong to this part from now on; one more where none has this name, colour and texture. color
 * NULL: none is given; texture: as in vv_mesh_part. Parts past VVI_MESH_PARTS_MOST go to the last. */
vv_status vvi_mesh_builder_part(vvi_mesh_builder *b, const char *name, size_t n_name, const vv_color *color,
                                size_t texture);
enum { VVI_MESH_PARTS_MOST = 65536 };
/** Takes what a comment says of the whole mesh, as VolVis writes it (unit, space, up), and which axis programs mean by
 * their signature alone. False: it is (also) for people. */
bool vvi_mesh_builder_comment(vvi_mesh_builder *b, const char *text);
/** A part without a look at those that are there; its number is n_parts - 1 afterwards. */
vv_status vvi_mesh_builder_new_part(vvi_mesh_builder *b, const char *name, size_t n_name, const vv_color *color,
                                    size_t texture);
/** One more place on textures, with VVI_MESH_CORNERS; its number is info.n_coordinates - 1 afterwards. */
vv_status vvi_mesh_builder_coordinate(vvi_mesh_builder *b, float u, float v);
/** Which coordinates the corners of the polygon have that came last; it has n of them. */
void vvi_mesh_builder_corners(vvi_mesh_builder *b, const uint32_t *coordinate, size_t n);
/** Checks, cuts concave polygons, brings triangles into the order of parts. Errors: VV_E_FORMAT (a vertex that is not
 * there, a place that is no number, no triangles but vertices), VV_E_MEMORY. The builder is empty afterwards. */
vv_status vvi_mesh_builder_finish(vv_mesh **out, vvi_mesh_builder *b, vv_notes *notes);
/** Throws away; a zeroed one is fine. */
void vvi_mesh_builder_free(vvi_mesh_builder *b);

/** Whether single precision is too little for places in these bounds: they are far from zero for their size. */
bool vvi_mesh_is_far(const vv_bounds *bounds);
/** Cuts fans of concave polygons in another way, by ears (Meisters 1975). How many it could not cut without
 * triangles that turn back. */
vv_status vvi_mesh_cut_fans(size_t *n_bad_out, vvi_mesh_builder *b);
#endif
