/** @file
 * One picture on its way: what its parts share. picture.c is the object; picture_stages.c says which stages there are,
 * picture_tiles.c runs their loops; preview.c and adaptive.c make a picture from fewer rays than pixels, pixel_rays.c
 * from more; picture_look.c shows it; checkpoint.c keeps what it has gathered.
 */
#ifndef VVI_RENDER_PICTURE_H
#define VVI_RENDER_PICTURE_H
#include <volvis/render.h>
#include <volvis/sys/scene.h>

/** Pixels along the side of a tile: large enough for packets of rays and one item of 0.1 to 10 ms, small enough that
 * the last worker is not waited for. */
enum { VVI_TILE = 32 };

/** What is done next. A stage is one loop over tiles, which may be broken off between any two of them; or work that
 * leaves nothing behind until it is done: DRAW, SQUARES, JUDGE. Their numbers stand in checkpoints. */
typedef enum vvi_stage {
    VVI_STAGE_GRID,    /**< coarse rays: grids 0 .. VVI_GRIDS - 1 of the canvas */
    VVI_STAGE_SQUARES, /**< adaptive: all rays where coarse ones differ, on the canvas */
    VVI_STAGE_FIRST,   /**< a ray for each pixel */
    VVI_STAGE_DRAW,    /**< by a renderer that makes a picture at once */
    VVI_STAGE_RAYS,    /**< of a further pass */
    VVI_STAGE_ADD,     /**< them to the mean */
    VVI_STAGE_JUDGE,   /**< whether that is enough */
    VVI_STAGE_WEIGH,   /**< the second of two passes more than the first */
    VVI_STAGE_END
} vvi_stage;

enum { VVI_COARSE = 4 }; /**< pixels from one ray to the next at first */
enum { VVI_GRIDS = 7 };  /**< one, and three more each time that VVI_COARSE is halved */
enum { VVI_BLOCK = 4 };  /**< pixels along the side of what gets more rays or does not; divides VVI_TILE */

/** What a picture has gathered so far: all that a checkpoint holds. */
typedef struct vvi_gathered {
    vvi_stage stage;
    int32_t grid; /**< of VVI_STAGE_GRID: the next one; how many there are, later */
    int64_t passes;
    vv_render_end ended_by;
    vv_render_counts counts; /**< of all tiles that are done */
    double spent_s;          /**< in steps that are over */
    double pass_began_s;     /**< on the same clock */
    vv_image *image;         /**< mean light of all passes, before decorations and background; layers of the first */
    vv_image *canvas;        /**< of coarse rays, from VVI_STAGE_GRID to SQUARES; vvi_preview_size() */
    vv_image *shifted;       /**< rays of the pass on its way, a column and a row larger than the image */
    float *half;             /**< mean light of odd passes alone, to tell the error by; NULL: nobody asks */
    uint8_t *active;         /**< by block: gets more rays; n_across x n_down */
    int32_t n_across, n_down;
    uint8_t *done; /**< by tile of the stage: 0 or 1; n_tiles */
    size_t n_tiles;
} vvi_gathered;

struct vv_picture {
    vv_scene *scene;
    void *state;     /**< the renderer's */
    bool scattered;  /**< tiles of a stage come from all over it */
    bool coarse;     /**< coarse pictures are wanted first */
    vv_job *job;     /**< of the call that runs */
    const char *isa; /**< of that job, and its threads */
    int threads;
    double load_s, prepare_s;
    double began_s, deadline_s; /**< of the step that runs, on vvi_render_clock(); 0: no deadline */
    uint64_t n_done, n_ahead;   /**< tiles, for the progress */
    vvi_gathered got;
};

/** A loop over the tiles of a rectangle of `width` x `height`. */
typedef struct vvi_tiles {
    int32_t width, height;
    /** Any worker; scratch is an image of VVI_TILE x VVI_TILE with the picture's layers, or NULL. */
    vv_status (*tile)(vv_picture *picture, void *user, const vv_tile *tile, vv_image *scratch,
                      vv_render_counts *counts);
    void *user;
    bool scratch; /**< wanted */
    bool quiet;   /**< short work: does not count in the progress, and no deadline breaks it off */
} vvi_tiles;

/** Counts are added to the picture's. */
vv_status vvi_picture_loop(vv_picture *picture, const vvi_tiles *tiles);
/** The same of a stage; *whole_out: all of its tiles are done, and the marks are cleared for the next one. */
vv_status vvi_picture_go_on(bool *whole_out, vv_picture *picture, const vvi_tiles *tiles);
/** The tile's part of the image as a new image has it, and then what the renderer makes of it. */
vv_status vvi_picture_render(vv_picture *picture, const vv_pass *pass, const vv_tile *tile, vv_image *image,
                             vv_render_counts *counts);
/** The pass with this number; one ray for `stride` pixels, through (x, y) of them. */
vv_pass vvi_picture_pass(const vv_picture *picture, double x, double y, int32_t stride, uint64_t number);
/** Tiles of the largest loop of a picture of this size. */
size_t vvi_picture_tiles_most(int32_t width, int32_t height);
/** Seconds that rendering has taken until now. */
double vvi_picture_spent(const vv_picture *picture);
/** Takes what another picture that depends on the same things has gathered, in the place of its own. */
void vvi_picture_adopt(vv_picture *picture, vvi_gathered *got);

/** Of a picture in which so many pixels show something. */
void vvi_warn_of_nothing(const vv_scene *scene, uint64_t covered, vv_job *job);
/** Whether it can be made part by part: VV_OK, or VV_E_UNSUPPORTED and why not. */
vv_status vvi_has_parts(const vv_scene *scene);
/** vv_picture_new() of the rows [top, top + rows) of a picture, top being a multiple of VVI_TILE: the pixels that they
 * have in the whole one, to the bit; every one has its own rays, even where the view is adaptive. */
vv_status vvi_picture_new_rows(vv_picture **out, vv_world *world, const char *view, int32_t top, int32_t rows,
                               vv_job *job);
/** Whether the scene's renderer can draw it: VV_OK, or why not. */
vv_status vvi_accepts(const vv_scene *scene);
/** vv_field_health() of all that is shown: samples that went while they were drawn were drawn as 0. */
vv_status vvi_scene_health(const vv_scene *scene);

/** Buffers of a picture of that scene in a stage of its first pass, or of any; and those of further passes beside them.
 * On failure, too, vvi_gathered_finish(). */
vv_status vvi_gathered_begin(vvi_gathered *got, const vv_scene *scene, vvi_stage stage, vv_job *job);
vv_status vvi_gathered_begin_passes(vvi_gathered *got, const vv_scene *scene, vv_job *job);
/** What only further passes need. */
void vvi_gathered_finish_passes(vvi_gathered *got);
void vvi_gathered_finish(vvi_gathered *got);
/** Goes on with its stage, until that is done or the deadline has come; the next one is set then. */
vv_status vvi_picture_do_stage(vv_picture *picture);

/* Looking (picture_look.c) ---------------------------------------------------------------------------------------- */

/** The picture's image itself becomes what vv_picture_look() gives, and the caller's. Nothing can be done with the
 * picture then but to free it. figure_out, not NULL: *figure_out becomes the picture as an SVG document, yours to
 * free(), and the image has neither decorations nor background. */
vv_status vvi_picture_take(vv_image **out, char **figure_out, vv_picture *picture, vv_job *job);
/** The picture, whose image is `image`, as an SVG document: *out is yours to free(). */
vv_status vvi_picture_figure(char **out, const vv_picture *picture, const vv_image *image);

/* One ray a pixel or fewer --------------------------------------------------------------------------------------- */

/** The size of a canvas for a picture of that size: as many columns and rows more as make the last one of the grid, so
 * that every pixel lies between four rays. */
int32_t vvi_preview_size(int32_t n);
/** Goes on with grid got.grid, the first of which has rays through every VVI_COARSE-th pixel. */
vv_status vvi_preview_go_on(bool *whole_out, vv_picture *picture);
/** Pixels from one ray of a canvas to the next once that many grids are whole. */
int32_t vvi_preview_stride(int32_t grids);
/** Colours and depth of an image (stride 1: all layers) from the canvas that is known at every stride-th pixel: linear
 * between them. */
vv_status vvi_preview_show(vv_picture *picture, vv_image *image, int32_t stride);
/** Every pixel of a tile of the canvas, no larger than VVI_TILE; scratch as in vvi_tiles. */
vv_status vvi_preview_render(vv_picture *picture, const vv_tile *tile, vv_image *scratch, vv_render_counts *counts);
/** Colour and depth at n pixels (x, y), (x + 1, y) ... of a canvas that is known at every stride-th pixel. */
void vvi_preview_row(float *rgba_out, float *depth_out, const vv_image *canvas, int32_t stride, int32_t x, int32_t y,
                     int32_t n);
/** All rays of the pixels between rays of a grid of VVI_COARSE that differ; the others stay linear between them. */
vv_status vvi_adaptive_finish(vv_picture *picture);

/* More rays a pixel (pixel_rays.c, noise.c) ----------------------------------------------------------------------- */

/** Where pass 0, 1, 2, ... lies, each in [0, 1): to the left of the centres, and above. */
void vvi_sample_shift(double *x_out, double *y_out, int64_t pass);
/** Goes on with the rays of pass got.passes; and with their addition to the mean. */
vv_status vvi_pass_cast(bool *whole_out, vv_picture *picture);
vv_status vvi_pass_add(bool *whole_out, vv_picture *picture);
/** Goes on with the last pass's weight, where two passes are all. */
vv_status vvi_pass_weigh(bool *whole_out, vv_picture *picture);
/** Blocks that get more rays. */
int64_t vvi_blocks_active(const vvi_gathered *got);
/** Blocks that are known well enough get no more rays; those that were are for good. */
vv_status vvi_noise_check(vv_picture *picture);
/** Whether every pixel is known as well as that; false before the third pass. */
vv_status vvi_noise_is_below(bool *out, vv_picture *picture, double bound);

#endif
