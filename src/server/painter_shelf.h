/** @file
 * What pictures at rest have gathered, kept for the next one that depends on the same things: the camera has come back,
 * somebody else has edited what this view does not show, a page has connected again. For one thread.
 */
#ifndef VVI_SERVER_PAINTER_SHELF_H
#define VVI_SERVER_PAINTER_SHELF_H
#include "render/picture.h"

enum { VVI_SHELF_MOST = 8 };

/** Zeros: nothing is kept. */
typedef struct vvi_shelf {
    struct vvi_shelf_place {
        uint64_t depends, bytes, number; /* vvi_picture_depends(); bytes 0: free; the newest has the largest number */
        vvi_gathered got;
    } place[VVI_SHELF_MOST];
    uint64_t number;
} vvi_shelf;

/** Keeps what the picture has gathered, which is gone from it; it can only be freed then. The oldest ones make room so
 * that all take `most` bytes; one that takes more is not kept. */
void vvi_shelf_put(vvi_shelf *shelf, uint64_t depends, vv_picture *picture, uint64_t most);
/** Gives the picture what one like it had gathered; false: there was none. */
bool vvi_shelf_take(vvi_shelf *shelf, uint64_t depends, vv_picture *picture);
void vvi_shelf_clear(vvi_shelf *shelf);
#endif
