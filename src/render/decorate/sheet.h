/** @file
 * What all decorations of a picture share: where they are drawn, how large letters are, which colours are seen.
 */
#ifndef VVI_RENDER_SHEET_H
#define VVI_RENDER_SHEET_H
#include "core/job.h"
#include "gfx/font.h"
#include "gfx/gfx.h"
#include <volvis/sys/scene.h>

typedef struct vvi_sheet {
    const vv_scene *scene;
    const vv_decorations *wanted;
    vvi_gfx *gfx;
    vvi_font *font; /**< NULL: no letters */
    vv_job *job;
    double width, height; /**< pixels */
    double em;            /**< of letters, pixels */
    double line;          /**< width of lines */
    double margin;        /**< to the picture's borders */
    vv_color ink, paper;  /**< of lines and letters; of what must stand out from them */
    const char *unit;     /**< of lengths */
    double top;           /**< where nothing stands yet at the left, below the title and the caption */
} vvi_sheet;

/** Sizes and colours of a scene's decorations; no font and no gfx yet. */
vvi_sheet vvi_sheet_new(const vv_scene *scene, vv_job *job);

/** Pixel of a point and its distance along the line of sight; false for points that are not before the eye. */
bool vvi_sheet_project(double *x_out, double *y_out, double *depth_out, const vvi_sheet *sheet, vv_vec3 world);
/** World length of a pixel at a point; 0 where it is not before the eye. */
double vvi_sheet_pixel(const vvi_sheet *sheet, vv_vec3 world);
/** Box of everything visible, in the World; empty without volumes. */
vv_bounds vvi_sheet_bounds(const vvi_sheet *sheet);

/** A colour with its opacity times `opacity`. */
static inline vv_color vvi_faded(vv_color color, double opacity)
{
    color.a *= opacity;
    return color;
}

/** In pixels, with a halo of paper. anchor: vvi_gfx_anchor; level: vvi_gfx_level. Without a font nothing. */
vv_status vvi_sheet_text(const vvi_sheet *sheet, double x, double y, double size, int anchor, int level,
                         const char *text);
/** Length of a text of this size; without a font, a guess. */
double vvi_sheet_length(const vvi_sheet *sheet, const char *text, double size);
/** A line in pixels on an edge of paper, so that it is seen on anything. */
vv_status vvi_sheet_line(const vvi_sheet *sheet, const vv_vec3 *points, size_t n, int join, double width);

/* The decorations, each drawn when it is wanted ------------------------------------------------------------------ */

vv_status vvi_sheet_box(const vvi_sheet *sheet);        /* in the World */
vv_status vvi_sheet_cut_planes(const vvi_sheet *sheet); /* in the World */
vv_status vvi_sheet_axes(const vvi_sheet *sheet);       /* in both */
vv_status vvi_sheet_cube(const vvi_sheet *sheet);
vv_status vvi_sheet_scale_bar(const vvi_sheet *sheet);
vv_status vvi_sheet_legend(const vvi_sheet *sheet);
vv_status vvi_sheet_captions(vvi_sheet *sheet);

/* What they are made of, for tests -------------------------------------------------------------------------------- */

/** A round length that takes up to `share` of `pixels` at `per_pixel` world lengths a pixel; 0: there is none. */
double vvi_scale_bar_length(double per_pixel, double pixels, double share);

enum { VVI_CUT_CORNERS = 64 };
/** Corners, in order, of the convex polygon that a plane cuts out of a box (8 corners as vvi_actor_corners() gives
 * them) after `n_others` other half-spaces; how many, at most VVI_CUT_CORNERS. */
size_t vvi_cut_outline(vv_vec3 out[VVI_CUT_CORNERS], const vv_vec3 corners[8], const vv_plane *plane,
                       const vv_plane *others, size_t n_others);

/** `text` with its placeholders filled in, yours to free(). Error: VV_E_ARGUMENT names a placeholder that there is not,
 * the nearest one, and `property`. */
vv_status vvi_caption_fill(char **out, const char *text, const vv_scene *scene, const char *property);
#endif
