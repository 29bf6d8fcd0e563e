/** @file
 * For formats that have steps along x, y and z but no directions: samples are written along the axes of the world,
 * backwards and in another order as it takes, so that each stays where it was.
 */
#ifndef VVI_IO_WORLD_ORDER_H
#define VVI_IO_WORLD_ORDER_H
#include <volvis/field.h>

typedef struct vvi_turn {
    int axis[3];   /* of the field, for x, y, z of the file */
    bool back[3];  /* the file's axis runs against it */
    vv_grid grid;  /* of the file */
    bool straight; /* its axes run along those of the world, none strays by more than a part of its length */
    bool mirrored; /* taken for such it would be a mirror image; oblique axes alone, and seldom */
} vvi_turn;

/** To the nearest axes of the world; `stray`: the part of a step's length that may lie along other axes. */
vvi_turn vvi_turn_to_world(const vv_grid *grid, double stray);
/** The same for formats of pictures: one slice is a picture in whatever plane it lies, and stays one; axial slices
 * whose rows run to the left and columns to the back, as scanners and radiologists have them, stay so as well. */
vvi_turn vvi_turn_pages(const vv_grid *grid, double stray);
/** The same, but of anatomical space always as radiologists have them. */
vvi_turn vvi_turn_upright(const vv_grid *grid, double stray);

/** A brick of the field as the file's axes see it: its first sample, and bytes from one to the next. */
const uint8_t *vvi_turn_brick(int64_t step_out[3], const vvi_turn *turn, const vv_brick *brick);
/** Slices [first, first + n) of the file as a box of the field. */
vv_box vvi_turn_slices(const vvi_turn *turn, int64_t first, int64_t n);
#endif
