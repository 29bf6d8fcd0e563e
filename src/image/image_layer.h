/** @file
 * The layers of an image by number, for what treats them alike.
 */
#ifndef VVI_IMAGE_IMAGE_LAYER_H
#define VVI_IMAGE_IMAGE_LAYER_H
#include <volvis/image.h>

enum { VVI_IMAGE_SIDE_MOST = 65536 };

/** All layers are arrays of 32-bit numbers. */
typedef struct vvi_layer {
    const char *name;
    size_t channels; /**< numbers a pixel */
    bool whole;      /**< uint32_t, else float */
    float empty;     /**< where nothing is */
    size_t offset;   /**< of its pointer in vv_image */
} vvi_layer;

/** By number, 0 .. VV_LAYER_COUNT - 1. */
const vvi_layer *vvi_layer_nth(size_t index);
/** Its numbers in an image; NULL where the image does not have it. */
void *vvi_image_layer(const vv_image *image, size_t index);
/** Whether any pixel lets something through. */
/** Of an image with these layers. */
size_t vvi_image_pixel_bytes(unsigned layers);
bool vvi_image_transparent(const vv_image *image);
#endif
