/** @file
 * PLY: what its header says, for reading and writing. Turk, The PLY Polygon File Format (1994).
 */
#ifndef VVI_IO_PLY_H
#define VVI_IO_PLY_H
#include "io/meshes/mesh_builder.h"
#include "io/meshes/mesh_words.h"

/** What a property means. */
typedef enum vvi_ply_role {
    VVI_PLY_X,
    VVI_PLY_Y,
    VVI_PLY_Z,
    VVI_PLY_NX,
    VVI_PLY_NY,
    VVI_PLY_NZ,
    VVI_PLY_RED,
    VVI_PLY_GREEN,
    VVI_PLY_BLUE,
    VVI_PLY_ALPHA,
    VVI_PLY_VALUE,
    VVI_PLY_U,
    VVI_PLY_V,
    VVI_PLY_TEXTURE, /* of a face: which image */
    VVI_PLY_PART,
    VVI_PLY_CORNERS,
    VVI_PLY_COORDINATES, /* of the corners of a face: u v of each */
    VVI_PLY_ROLES,
    VVI_PLY_NOTHING = VVI_PLY_ROLES
} vvi_ply_role;

typedef struct vvi_ply_property {
    vvi_ply_role role;
    bool list;
    vv_type type, count_type; /**< of its numbers, and of how many a list has */
    size_t offset;            /**< in the record, while no list came before */
} vvi_ply_property;

typedef enum vvi_ply_kind { VVI_PLY_VERTEX, VVI_PLY_FACE, VVI_PLY_STRIPS, VVI_PLY_OTHER } vvi_ply_kind;

enum { VVI_PLY_ELEMENTS_MOST = 32, VVI_PLY_PROPERTIES_MOST = 128, VVI_PLY_TEXTURES_MOST = 256 };

typedef struct vvi_ply_element {
    char name[64];
    vvi_ply_kind kind;
    uint64_t n;
    vvi_ply_property property[VVI_PLY_PROPERTIES_MOST];
    size_t n_properties;
    size_t bytes; /**< of a record, lists by their counts alone */
    bool fixed;   /**< there are no lists */
} vvi_ply_element;

typedef struct vvi_ply {
    bool ascii, swapped;
    vvi_ply_element element[VVI_PLY_ELEMENTS_MOST];
    size_t n_elements;
    size_t n_part_names;
    char *texture[VVI_PLY_TEXTURES_MOST]; /**< files of images; for free() */
    size_t n_textures;
} vvi_ply;

/** Everything up to the data; unit, space, names and parts go to the builder. */
vv_status vvi_ply_read_header(vvi_ply *out, vvi_words *words, vvi_mesh_builder *b, vv_notes *notes);
/** The property of a role; NULL where there is none. */
const vvi_ply_property *vvi_ply_find(const vvi_ply_element *element, vvi_ply_role role);
vv_status vvi_ply_read(vv_mesh **out, vv_source *source, const vv_mesh_read_options *options, vv_notes *notes,
                       vv_job *job);
vv_status vvi_ply_write(vv_sink *sink, const vv_mesh *mesh, const vv_mesh_write_options *options, vv_job *job);
#endif
