/** @file
 * Colours in mesh files: bytes of sRGB there, linear parts here; and files whose faces have colours of their own.
 */
#ifndef VVI_IO_MESH_COLORS_H
#define VVI_IO_MESH_COLORS_H
#include "io/meshes/mesh_builder.h"

/** Bytes of sRGB and alpha, both ways. */
void vvi_mesh_bytes_of(uint8_t out[4], const vv_color *color);
vv_color vvi_mesh_color_of(const uint8_t bytes[4]);
/** 0 .. 1 to a byte, rounded; what is no number is 0. */
uint8_t vvi_mesh_byte(double v);

enum { VVI_FACE_COLORS_MOST = 4096 };

/** Colours that faces had so far, each the part of its number. */
typedef struct vvi_face_colors {
    uint32_t *slot;   /**< part + 1 by colour, 0 where free */
    uint32_t *colors; /**< of each part */
    uint32_t last;    /**< the colour of the current part */
    size_t n;
    bool full; /**< there were too many: parts mean nothing */
} vvi_face_colors;

/** The triangles that come have this colour; bytes NULL: none. */
vv_status vvi_face_colors_use(vvi_face_colors *colors, vvi_mesh_builder *b, const uint8_t *bytes);
/** When all faces are there: drops what became too much, with a warning. The colours are free afterwards. */
vv_status vvi_face_colors_finish(vvi_face_colors *colors, vvi_mesh_builder *b, vv_notes *notes);
void vvi_face_colors_free(vvi_face_colors *colors);

/** The colour of a triangle for files that give faces one: the mean of its vertices' or its part's. False: it has
 * none. */
bool vvi_mesh_face_color(uint8_t out[4], const vv_mesh_info *mesh, size_t triangle, const vv_mesh_part *part);
#endif
