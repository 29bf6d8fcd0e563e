/** @file
 * Images: linear float RGBA, premultiplied, with optional layers (depth, normal, ...); and image files.
 */
#ifndef VOLVIS_IMAGE_H
#define VOLVIS_IMAGE_H
#include <volvis/runtime.h>
VV_BEGIN_DECLS

/** What an image may hold beside its colours; bits of a set. */
typedef enum vv_layer {
    VV_LAYER_DEPTH = 1,
    VV_LAYER_NORMAL = 2,
    VV_LAYER_ID = 4,
    VV_LAYER_SAMPLES = 8,
    VV_LAYER_VALUE = 16
} vv_layer;
#define VV_LAYER_COUNT 5

/** Reference-counted. Row 0 is the top. Layers are NULL where the image does not have them. */
typedef struct vv_image {
    uint32_t refs; /**< atomic */
    int32_t width, height;
    float *rgba;   /**< width * height * 4, linear, premultiplied */
    float *depth;  /**< distance from the eye along the pixel's ray, world units, INFINITY where nothing is */
    float *normal; /**< width * height * 3: what is seen at that depth faces this way; world space, length 1; 0 where
                      nothing is, or where the values do not change */
    uint32_t *id;  /**< 1 + number of the object among the view's visible volumes, those that show meshes
                      after all others; 0 where nothing is */
    uint32_t *samples; /**< rays that were spent on the pixel */
    float *value;      /**< of the data at that depth; NaN where nothing is */
} vv_image;

/** Layers: any of vv_layer. Depth is INFINITY, value NaN, all else 0. */
VV_API vv_status vv_image_new(vv_image **out, int32_t width, int32_t height, unsigned layers, vv_job *job);
/** The layers that an image has. */
VV_API unsigned vv_image_layers(const vv_image *image);
/** "depth", "normal", "id", "samples", "value" by number 0 .. VV_LAYER_COUNT - 1 (the layer is 1 << number); else NULL.
 */
VV_API const char *vv_layer_name(size_t index);
VV_API vv_image *vv_image_retain(vv_image *image);
VV_API void vv_image_release(vv_image *image); /* NULL is fine */

/** One line of text kept inside an image file. */
typedef struct vv_text {
    char *key, *value;
} vv_text;

/** Options of vv_image_write(). Fill with vv_image_options_init(), then change what you need. */
typedef struct vv_image_options {
    size_t size; /**< set by init */
    int bits;    /**< a channel: 8, 16 or 32 (floats), as the format has them; default 0: the format's first */
    bool alpha;  /**< keep transparency; false: the image is opaque already. Default: kept where any pixel has it */
    const vv_text *text; /**< what the file is to say of itself; a format without room for text (PFM) says nothing */
    size_t n_text;
    int quality;     /**< of JPEG and WebP, 1 to 100; default 0: 90 in JPEG, and WebP loses nothing */
    unsigned layers; /**< to be written too, in the file or beside it (vv_image_layer_path()); default none */
    bool fast;  /**< JPEG: half of the colours' resolution and a tenth larger, in half the time; for moving frames */
    double dpi; /**< pixels an inch on paper; default 0: not said, and 300 in PDF, whose pages have a size */
} vv_image_options;

VV_API void vv_image_options_init(vv_image_options *options, size_t size);
/** By suffix; "-" writes PNG to standard output. Floats (EXR, PFM, TIFF of 32 bits) are linear and premultiplied, all
 * else is sRGB encoded.
 * Never half a file: several files appear after all of them are whole. A format without transparency shows the image
 * over black, with a warning in the log. */
VV_API vv_status vv_image_write(const char *path, const vv_image *image, const vv_image_options *options, vv_job *job);
/** An image that is never whole in memory. */
typedef struct vv_image_rows {
    int32_t width, height;
    bool transparent; /**< its alpha may be below 1 */
    /** The next rows from the top, one or more, as an image of them; until the next call. */
    vv_status (*next)(void *user, const vv_image **out, vv_job *job);
    void *user;
} vv_image_rows;
/** vv_image_write() of one without layers; VV_E_UNSUPPORTED where a format needs all of it at once: PNG does not. */
VV_API vv_status vv_image_write_rows(const char *path, const vv_image_rows *rows, const vv_image_options *options,
                                     vv_job *job);
/** Whether it could be, to ask before a long render, as vv_image_check(). */
VV_API vv_status vv_image_check_rows(const char *path, int32_t width, int32_t height, const vv_image_options *options,
                                     vv_job *job);
/** The same in memory: the bytes of a file of the format that this suffix has (".png"), yours to free with
 * vv_image_bytes_free(). Layers have no place there. */
VV_API vv_status vv_image_encode(uint8_t **out, size_t *n_out, const char *suffix, const vv_image *image,
                                 const vv_image_options *options, vv_job *job);
VV_API void vv_image_bytes_free(uint8_t *bytes); /* NULL is fine */
/** Whether an image could be written there with these options (NULL: defaults), to ask before a long render:
 * VV_E_ARGUMENT, VV_E_UNSUPPORTED. Says nothing of disks and folders. */
VV_API vv_status vv_image_check(const char *path, const vv_image_options *options, vv_job *job);
/** The same of an image of this size: some formats have a largest one. */
VV_API vv_status vv_image_check_size(const char *path, int32_t width, int32_t height, vv_job *job);
/** The file in which vv_image_write() puts a layer, by number as in vv_layer_name(): `path` itself where the format
 * holds layers, else "a.depth.pfm" beside "a.png". Yours to free(); NULL without memory. */
VV_API char *vv_image_layer_path(const char *path, size_t index, vv_job *job);
/** text_out, n_text_out may be NULL; else free with vv_text_free(). */
VV_API vv_status vv_image_read(vv_image **out, vv_text **text_out, size_t *n_text_out, const char *path, vv_job *job);
VV_API void vv_text_free(vv_text *text, size_t n);
/** Only the text of an image file, without decoding pixels. */
VV_API vv_status vv_image_read_text(vv_text **text_out, size_t *n_text_out, const char *path, vv_job *job);

/** How two images of one size differ, measured on 8-bit sRGB values over black unless said otherwise. */
typedef struct vv_image_difference {
    double psnr;           /**< dB over R, G, B; INFINITY when equal */
    double ssim;           /**< mean structural similarity of luma, 11 x 11 Gaussian window (Wang 2004) */
    double flip_mean;      /**< mean FLIP error (Andersson 2020) at 67 pixels a degree */
    double max_difference; /**< largest channel difference, 0..1 */
    uint64_t n_different;  /**< pixels that differ at all */
} vv_image_difference;

VV_API vv_status vv_image_compare(vv_image_difference *out, const vv_image *a, const vv_image *b, vv_job *job);

/** How a terminal shows pictures. */
typedef enum vv_letters {
    VV_LETTERS_SIXEL,   /**< pixels */
    VV_LETTERS_BLOCKS,  /**< two pixels a letter, one above the other, in 16 million colours */
    VV_LETTERS_BLOCKS8, /**< the same in the 256 colours of xterm */
    VV_LETTERS_SHADES   /**< one pixel a letter, light or dark */
} vv_letters;

/**
 * An image, over black, as text for a terminal: lines that end, with escape sequences but in shades. What a terminal
 * can show, and how many letters fit, is for whoever has it to know.
 *
 * Errors   VV_E_MEMORY
 * Owns     *text_out is yours to free()
 * Threads  any
 */
VV_API vv_status vv_image_letters(char **text_out, const vv_image *image, vv_letters kind);

/** The sRGB curve, both ways, for values 0..1. */
VV_API double vv_srgb_encode(double linear);
VV_API double vv_srgb_decode(double encoded);

VV_END_DECLS
#endif
