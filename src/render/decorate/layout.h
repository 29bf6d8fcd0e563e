/** @file
 * Where things stand on a picture: boxes that keep apart, all within it. What is asked for first has the first choice;
 * who finds no room is told so. Pixels, y down.
 */
#ifndef VVI_RENDER_LAYOUT_H
#define VVI_RENDER_LAYOUT_H
#include <volvis/base.h>

typedef struct vvi_box {
    double x0, y0, x1, y1;
} vvi_box;

enum { VVI_LAYOUT_MOST = 256 };

typedef struct vvi_layout {
    double width, height; /**< of the picture */
    double margin;        /**< between its borders and what vvi_layout_place() places */
    double gap;           /**< between boxes, at least */
    vvi_box box[VVI_LAYOUT_MOST];
    size_t n;
} vvi_layout;

/** Whether a box is within the picture and stands free of all that were taken. */
bool vvi_layout_is_free(const vvi_layout *layout, vvi_box box);
/** Takes it if so. False too after VVI_LAYOUT_MOST boxes, and for boxes that are not finite. */
bool vvi_layout_take(vvi_layout *layout, vvi_box box);

/** What an item of this size would like: a corner; and how bad it is to stand somewhere, from 0 to about 1. */
typedef struct vvi_wish {
    double width, height;
    bool right, bottom;
    double (*cost)(const void *user, vvi_box box); /**< NULL: no place is bad */
    const void *user;
} vvi_wish;

/** Takes the best free place at the left or the right margin: what it covers counts most, then the side, then how
 * far it is from a corner. False: there is none. */
bool vvi_layout_place(vvi_box *out, vvi_layout *layout, const vvi_wish *wish);
#endif
