/** @file
 * Pictures: a World snapshot, one of its views, the renderer that the view names. vv_render() makes one at a call; a
 * vv_picture is made step by step, looked at on the way, saved, and gone on with by another process.
 */
#ifndef VOLVIS_RENDER_H
#define VOLVIS_RENDER_H
#include <volvis/image.h>
#include <volvis/model.h>
VV_BEGIN_DECLS

/** What ended a frame. */
typedef enum vv_render_end {
    VV_END_NONE,    /**< nothing yet */
    VV_END_SAMPLES, /**< the view's number of rays a pixel */
    VV_END_NOISE,   /**< every pixel is known as well as the view asks */
    VV_END_BUDGET,  /**< the view's time is used */
    VV_END_STOPPED  /**< `enough` said so */
} vv_render_end;

/** What a frame took. */
typedef struct vv_render_report {
    const char *method;
    const char *isa;
    int threads;
    double load_s;    /**< opening and reading data */
    double prepare_s; /**< working out what was left open, derived data */
    double render_s;  /**< tiles */
    uint64_t rays, samples;
    int64_t passes; /**< rays through each pixel, of those with most; the mean is rays / (width * height) */
    vv_render_end ended_by;
} vv_render_report;

/** "samples", "noise", "budget", "stop"; "" for VV_END_NONE. */
VV_API const char *vv_render_end_name(vv_render_end end);

/** How far a picture is. */
typedef struct vv_refinement {
    const vv_image *image; /**< all of it, over the background; until the call returns. Below level 2 colours and depth
                              only, linear between rays */
    int level;             /**< 0: a ray for 4 x 4 pixels; 1: for 2 x 2; 2: for every pixel that needs one, or more */
    int64_t passes;        /**< rays through each pixel, of those with most; 0 below level 2 */
    bool final;            /**< the image that vv_render() returns */
} vv_refinement;

/** Options of vv_render(). Fill with vv_render_options_init(), then change what you need. */
typedef struct vv_render_options {
    size_t size; /**< set by init: how much of this struct the caller knows */
    /** Called by the thread that called vv_render(), first with a coarse picture, then with each better one, the last
     * one too; rendering goes on when it returns, unless the job was cancelled. NULL: nobody looks, and no coarse
     * picture is made. The last image is the same with and without. */
    void (*on_refined)(void *user, const vv_refinement *refinement);
    void *user;
    /** Not NULL: *figure_out becomes the picture as an SVG document, yours to free(). Methods of triangles make areas,
     * of at most 100000 triangles that are seen (VV_E_LIMIT); the pictures of others are put under the decorations. The
     * image that vv_render() returns has then neither decorations nor background. */
    char **figure_out;
    /** Asked between passes, once a whole picture is there: true ends the frame with the passes that it has. By the
     * thread that called vv_render(). NULL: never. */
    bool (*enough)(void *user);
} vv_render_options;

VV_API void vv_render_options_init(vv_render_options *options, size_t size);

/**
 * Render one view over the World's background.
 *
 * How many rays a pixel gets, and when that is enough, are properties of the view: render.samples, noise, budget and
 * adaptive.
 *
 * view     id in world.views; NULL: the first
 * options  NULL: all defaults
 * Errors   VV_E_NOT_FOUND, VV_E_ARGUMENT, VV_E_UNSUPPORTED, VV_E_LIMIT, VV_E_CANCELLED, and those of reading
 * Owns     *out is new and yours; report may be NULL
 * Threads  any; same bytes for any thread count, but where a budget of time ended the frame: then the same bytes for
 *          the same number of passes
 */
VV_API vv_status vv_render(vv_image **out, vv_render_report *report, vv_world *world, const char *view,
                           const vv_render_options *options, vv_job *job);

/**
 * What a picture of this view takes in memory while it is made, beside data and what is made of them. Where
 * *at_once_out is false, that is more than the memory limit leaves now, and vv_render_to_file() makes it part by part.
 *
 * Errors   VV_E_NOT_FOUND
 */
VV_API vv_status vv_render_memory(uint64_t *bytes_out, bool *at_once_out, const vv_world *world, const char *view,
                                  vv_job *job);
/**
 * Render one view into an image file from the top down, as many rows at once as the memory limit allows: the pixels of
 * vv_render(). For pictures of any size.
 *
 * options  NULL: all defaults; no layers
 * Errors   those of vv_render() and vv_image_write_rows(); VV_E_UNSUPPORTED: what looks at a whole picture
 * (decorations, noise, budgets of time, methods that draw at once) Owns     report may be NULL; its times are sums over
 * the parts
 */
VV_API vv_status vv_render_to_file(vv_render_report *report, const char *path, vv_world *world, const char *view,
                                   const vv_image_options *options, vv_job *job);

/** A picture on its way. For one thread at a time. */
typedef struct vv_picture vv_picture;

/** How far vv_picture_step() goes: to what is reached first. Fill with vv_picture_until_init(), then change what you
 * need; as it is, to the end. */
typedef struct vv_picture_until {
    size_t size;    /**< set by init: how much of this struct the caller knows */
    double seconds; /**< no work is begun later, and what was begun (one tile, of some milliseconds) is done; a method
                       that draws at once (triangles) and adaptive sampling are not broken off. 0: no limit */
    int64_t passes; /**< rays through each pixel that there are to be; 0: no limit */
    double noise;   /**< every pixel known as well as that, in units of render.noise, after at least three passes; for
                       views that have a render.noise, which may be smaller. 0: no limit */
    bool better;    /**< to the next picture that shows more: a finer level, or one pass more */
} vv_picture_until;

VV_API void vv_picture_until_init(vv_picture_until *until, size_t size);

/**
 * A picture of one view, without a ray yet: its data are read, and what the renderer needs is worked out.
 *
 * view     id in world.views; NULL: the first
 * coarse   coarse pictures come first, for who looks while it is made; the last one is the same
 * Errors   as of vv_render()
 * Owns     *out is new and yours: vv_picture_free(). It keeps the World
 * Threads  of the job; other calls for the picture take jobs of the same runtime
 */
VV_API vv_status vv_picture_new(vv_picture **out, vv_world *world, const char *view, bool coarse, vv_job *job);

/**
 * Go on with it. In which steps a picture is made, and on how many threads, changes nothing in it, unless a budget of
 * time ends it.
 *
 * until    NULL: to the end
 * Errors   VV_E_CANCELLED within 50 ms; VV_E_ARGUMENT (noise of a view without); VV_E_MEMORY, those of reading. What
 *          was gathered stays, and another step goes on
 */
VV_API vv_status vv_picture_step(vv_picture *picture, const vv_picture_until *until, vv_job *job);
/**
 * About how many seconds all of it takes on this machine: at least the first tiles, half a second's worth of them from
 * all over the picture, and a few passes where those are quick. An estimate; where noise may end it, the most.
 *
 * Errors   VV_E_ARGUMENT after the first step; those of vv_picture_step()
 */
VV_API vv_status vv_picture_estimate(double *seconds_out, vv_picture *picture, vv_job *job);
/** Whether it is done: further steps do nothing. */
VV_API bool vv_picture_is_whole(const vv_picture *picture);
/** How much of it is done, 0 to 1, of what it may need at most: noise and time may end it before. */
VV_API double vv_picture_done(const vv_picture *picture);
/** What there is to look at: -1 at most parts; 0, 1 and 2 as vv_refinement.level. */
VV_API int vv_picture_level(const vv_picture *picture);

/**
 * What it looks like now, over the background and with decorations: the image that vv_render() returns, once it is
 * whole. Pixels that have no ray yet show the background.
 *
 * Owns     *out is new and yours
 * Cost     a copy of the image
 */
VV_API vv_status vv_picture_look(vv_image **out, vv_picture *picture, vv_job *job);
/** What it took until now. What came from a checkpoint is counted with it. */
VV_API void vv_picture_report(vv_render_report *out, const vv_picture *picture);

/**
 * Write what it has gathered to a file, which appears whole or not at all.
 *
 * Errors   VV_E_WRITE, VV_E_CANCELLED, VV_E_MEMORY, those of reading data, whose checksums are worked out once
 * Cost     16 to 60 bytes a pixel on the disk
 */
VV_API vv_status vv_picture_save(const vv_picture *picture, const char *path, vv_job *job);

/**
 * Take up what was saved: the picture goes on from there, and ends with the same bytes as without the break.
 *
 * Errors   VV_E_NOT_FOUND: there is no such file; VV_E_ARGUMENT: it was saved of a picture that depends on something
 *          else (its data, its view, what is seen, the kernels, the version of VolVis); VV_E_FORMAT: it is none, cut or
 *          damaged. The picture is as it was then
 */
VV_API vv_status vv_picture_resume(vv_picture *picture, const char *path, vv_job *job);
VV_API void vv_picture_free(vv_picture *picture); /* NULL is fine */

/** A named transfer function or colour map. */
typedef struct vv_preset {
    const char *name, *doc;
    const char *kind;       /**< "transfer"; "proposal": a transfer function worked out from the data; "colormap" */
    const char *value_unit; /**< "HU": nodes are such values; NULL: nodes are over 0..1 and stretched to the range */
    const char *alias;      /**< another spelling of the name, which is read and never listed; NULL: none */
} vv_preset;
/** By number; NULL past the end. */
VV_API const vv_preset *vv_preset_nth(size_t index);
/** Colour of a colour map at 0..1, linear; false when there is no map of that name. "#rrggbb" is the map from black to
 * that colour. */
VV_API bool vv_colormap_sample(vv_color *out, const char *name, double at);

VV_END_DECLS
#endif
