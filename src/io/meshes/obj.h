/** @file
 * Wavefront OBJ: text of vertices and polygons that name them by number. Wavefront, Advanced Visualizer, Appendix B
 * (1995). Colours of parts stand in a .mtl file beside it.
 */
#ifndef VVI_IO_OBJ_H
#define VVI_IO_OBJ_H
#include "io/meshes/mesh_builder.h"
#include "io/meshes/mesh_words.h"

/** A material of a library. */
typedef struct vvi_obj_material {
    char name[64];
    vv_color color;      /**< a < 0: it says none */
    char *map, *opacity; /**< files of images: map_Kd and map_d; NULL: none. Yours to free() */
    bool clamp;          /**< the image does not repeat */
    bool moved;          /**< it is scaled or shifted */
    bool looked_for;     /**< the image, with this result: */
    size_t texture;      /**< as in vv_mesh_part */
} vvi_obj_material;

typedef struct vvi_obj_library {
    vvi_obj_material *material;
    size_t n, room;
    const char *folder; /**< of the file that is read, up to and with the last slash */
    size_t n_folder;
} vvi_obj_library;

/** Materials of a file beside `source`; one that is not there, or may not be read, is a warning. */
vv_status vvi_obj_read_library(vvi_obj_library *library, vv_source *source, const char *name, vv_notes *notes,
                               vv_job *job);
/** By name; NULL when there is none. */
vvi_obj_material *vvi_obj_material_find(const vvi_obj_library *library, const char *name);
/** The texture of a material, read when it is asked for the first time; one image of several materials is read once. */
vv_status vvi_obj_material_texture(size_t *texture_out, vvi_obj_library *library, vvi_obj_material *material,
                                   vvi_mesh_builder *b, vv_notes *notes);
void vvi_obj_library_free(vvi_obj_library *library);

vv_status vvi_obj_write(vv_sink *sink, const vv_mesh *mesh, const vv_mesh_write_options *options, vv_job *job);
#endif
