/** @file
 * One picture on its way: what its parts share. render.c says in which order they come; preview.c and adaptive.c make a
 * picture from fewer rays than pixels, pixel_rays.c from more.
 */
#ifndef VVI_RENDER_PICTURE_H
#define VVI_RENDER_PICTURE_H
#include <volvis/render.h>
#include <volvis/sys/scene.h>

/** Pixels along the side of a tile: large enough for packets of rays and one item of 0.1 to 10 ms, small enough that
 * the last worker is not waited for. */
enum { VVI_TILE = 32 };

typedef struct vvi_picture {
    const vv_scene *scene;
    void *state; /**< the renderer's */
    vv_job *job;
    const vv_render_options *options;
    bool bare;                /**< the image is to have neither decorations nor background */
    vv_image *image;          /**< the result; its light stands before no background until vvi_picture_show() */
    vv_render_counts counts;  /**< of all passes so far */
    uint64_t n_done, n_ahead; /**< tiles, for the progress */
    int64_t passes;
    vv_render_end ended_by;
} vvi_picture;

/** A loop over the tiles of a rectangle of `width` x `height`. */
typedef struct vvi_tiles {
    int32_t width, height;
    /** Any worker; scratch is an image of VVI_TILE x VVI_TILE with the picture's layers, or NULL. */
    vv_status (*tile)(vvi_picture *picture, void *user, const vv_tile *tile, vv_image *scratch,
                      vv_render_counts *counts);
    void *user;
    bool scratch; /**< wanted */
    bool quiet;   /**< short work: does not count in the progress */
} vvi_tiles;

/** The picture's picture, which is bare, as an SVG document: *out is yours to free(). */
vv_status vvi_picture_figure(char **out, const vvi_picture *picture);
/** Whether the scene's renderer can draw it: VV_OK, or why not. */
vv_status vvi_accepts(const vv_scene *scene);

/** Counts are added to the picture's, tile by tile in their order. */
vv_status vvi_picture_loop(vvi_picture *picture, const vvi_tiles *tiles);
/** The tile's part of the image as a new image has it, and then what the renderer makes of it. */
vv_status vvi_picture_render(vvi_picture *picture, const vv_pass *pass, const vv_tile *tile, vv_image *image,
                             vv_render_counts *counts);
/** The pass with this number; one ray for `stride` pixels, through (x, y) of them. */
vv_pass vvi_picture_pass(const vvi_picture *picture, double x, double y, int32_t stride, uint64_t number);
/** `light` (rgba of every pixel; NULL: what stands in the image) under the view's decorations and over the background.
 */
vv_status vvi_picture_show(vvi_picture *picture, const float *light);
/** Tell who waits for it that the image is better now. */
void vvi_picture_tell(vvi_picture *picture, int level, bool final);

/** vv_field_health() of all that is shown: samples that went while they were drawn were drawn as 0. */
vv_status vvi_scene_health(const vv_scene *scene);

/* One ray a pixel or fewer --------------------------------------------------------------------------------------- */

enum { VVI_COARSE = 4 }; /**< pixels from one ray to the next at first */

/** Rays through every VVI_COARSE-th pixel of a canvas: an image, before the background, of the scene's size and as many
 * columns and rows more as make the last one of the grid, so that every pixel lies between four rays. On failure, too,
 * *canvas_out is yours where it is not NULL. */
vv_status vvi_preview_begin(vv_image **canvas_out, vvi_picture *picture);
/** The rays that make a grid of `stride` pixels one of half as many. */
vv_status vvi_preview_refine(vvi_picture *picture, vv_image *canvas, int32_t stride);
/** The image from a canvas that is known at every stride-th pixel: linear between them, before the background. */
vv_status vvi_preview_show(vvi_picture *picture, const vv_image *canvas, int32_t stride);
/** Every pixel of a tile of a canvas, no larger than VVI_TILE; scratch as in vvi_tiles. */
vv_status vvi_preview_render(vvi_picture *picture, vv_image *canvas, const vv_tile *tile, vv_image *scratch,
                             vv_render_counts *counts);
/** Colour and depth at n pixels (x, y), (x + 1, y) ... of a canvas that is known at every stride-th pixel. */
void vvi_preview_row(float *rgba_out, float *depth_out, const vv_image *canvas, int32_t stride, int32_t x, int32_t y,
                     int32_t n);
/** All rays of the pixels between rays of a grid of VVI_COARSE that differ; the others stay linear between them. */
vv_status vvi_adaptive_finish(vvi_picture *picture, vv_image *canvas);

/* More rays a pixel ---------------------------------------------------------------------------------------------- */

/** Passes after the first one, which stands in the image: until the scene's number, noise or time is reached. Leaves
 * the image before the background. */
vv_status vvi_samples_add(vvi_picture *picture, double start_s);

#endif
