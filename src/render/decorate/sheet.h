/** @file
 * What all decorations of a picture share: where they are drawn, how large letters are, which colours are seen.
 */
#ifndef VVI_RENDER_SHEET_H
#define VVI_RENDER_SHEET_H
#include "core/job.h"
#include "gfx/font.h"
#include "gfx/gfx.h"
#include "render/decorate/layout.h"
#include <volvis/sys/scene.h>

enum { VVI_MARKS = 1024, VVI_CAPTION_LINES = 12 };

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
    bool clear;           /**< the background may become anything: letters stand on plates */
    bool projects;        /**< the picture is of maxima, means or sums along rays */
    bool in_world;        /**< what is drawn now stands in the World, not on the picture */
    const char *unit;     /**< of lengths */
    vvi_layout layout;
    const vv_image *image;   /**< what is drawn over; NULL: nothing is known of it */
    vv_vec3 mark[VVI_MARKS]; /**< places on the picture that are better left free; z: how much better */
    size_t n_marks;
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

/** In pixels, on a halo of paper or a plate. anchor: vvi_gfx_anchor; level: vvi_gfx_level; quarters: as of
 * vvi_gfx_label. Without a font nothing. */
vv_status vvi_sheet_label(const vvi_sheet *sheet, double x, double y, const vvi_gfx_label *label, const char *text);
vv_status vvi_sheet_text(const vvi_sheet *sheet, double x, double y, double size, int anchor, int level,
                         const char *text);
/** Size of numbers and notes: somewhat less than an em, as long as it can be read. */
double vvi_sheet_small(const vvi_sheet *sheet);
/** Length of a text of this size; without a font, a guess. */
double vvi_sheet_length(const vvi_sheet *sheet, const char *text, double size);
/** How many bytes of a text are not longer than `room`, whole characters. */
size_t vvi_sheet_fitting(const vvi_sheet *sheet, const char *text, double size, double room);
/** Ends a text with "..." as one sign where it is longer than `room`, or `more` follows. bytes: of the array. */
void vvi_sheet_shorten(const vvi_sheet *sheet, char *text, size_t bytes, double size, double room, bool more);
/** Share of a box in which data are seen. */
double vvi_sheet_covered(const vvi_sheet *sheet, vvi_box box);
/** How much of a box would hide data or marks: vvi_wish.cost. */
double vvi_sheet_hides(const void *sheet, vvi_box box);
/** A place that is better left free. */
void vvi_sheet_mark(vvi_sheet *sheet, double x, double y, double weight);
/** Warns that there is no room for something. */
void vvi_sheet_left_out(const vvi_sheet *sheet, const char *what);
/** Whether directions are those of a body. */
bool vvi_sheet_is_anatomical(const vvi_sheet *sheet);
/** Lines from the first point to the second, the third to the fourth, ..., on an edge of paper, so that they are seen
 * on anything; broken where something has its place on the picture. */
vv_status vvi_sheet_line(const vvi_sheet *sheet, const vv_vec3 *points, size_t n, double width);

/* In the World: lines --------------------------------------------------------------------------------------------- */

vv_status vvi_sheet_box(const vvi_sheet *sheet);
vv_status vvi_sheet_cut_planes(const vvi_sheet *sheet);
vv_status vvi_sheet_cross_hair_in_world(const vvi_sheet *sheet);
/** Volumes of samples, and then meshes: how many there are; the corners of the box of one, and how far lines at it are
 * drawn before where they are, so that they are seen on a surface. */
size_t vvi_sheet_things(const vvi_sheet *sheet);
double vvi_sheet_corners(vv_vec3 out[8], const vvi_sheet *sheet, size_t thing);
/** Edges of the box of one, as ends of 12 lines: those behind it (both faces at them look away from the eye) and
 * the others. */
void vvi_sheet_edges(vv_vec3 behind[24], size_t *n_behind_out, vv_vec3 others[24], size_t *n_others_out,
                     const vvi_sheet *sheet, size_t thing);

/* On the picture: each is placed first, and drawn when all have their places ----------------------------------------
 */

/** Title and caption as lines. */
typedef struct vvi_sheet_captions {
    struct {
        char *text;
        double size, base; /**< pixels; y of the base line */
    } line[VVI_CAPTION_LINES];
    size_t n;
    vvi_box box;
} vvi_sheet_captions;
vv_status vvi_sheet_captions_place(vvi_sheet_captions *out, vvi_sheet *sheet);
vv_status vvi_sheet_captions_draw(const vvi_sheet_captions *captions, const vvi_sheet *sheet);
void vvi_sheet_captions_finish(vvi_sheet_captions *captions);

typedef struct vvi_sheet_scale_bar {
    bool there;
    vvi_box box;
    double pixels; /**< its length */
    char text[64];
    const char *note; /**< where it holds; "": everywhere */
} vvi_sheet_scale_bar;
void vvi_sheet_scale_bar_place(vvi_sheet_scale_bar *out, vvi_sheet *sheet);
vv_status vvi_sheet_scale_bar_draw(const vvi_sheet_scale_bar *bar, const vvi_sheet *sheet);

typedef struct vvi_sheet_cube {
    bool there;
    double x, y, half; /**< its middle; half of a side */
} vvi_sheet_cube;
void vvi_sheet_cube_place(vvi_sheet_cube *out, vvi_sheet *sheet);
vv_status vvi_sheet_cube_draw(const vvi_sheet_cube *cube, const vvi_sheet *sheet);

enum { VVI_AXIS_TICKS = 16 };
/** A number or a name on the picture. */
typedef struct vvi_sheet_axis_label {
    char text[64];
    double x, y; /**< its middle */
    vvi_box box;
    bool there;
} vvi_sheet_axis_label;
typedef struct vvi_sheet_axis {
    bool seen;           /**< an edge along it is long enough in the picture */
    bool there, upright; /**< upright: its name is turned by a quarter */
    vv_vec3 from, to;    /**< pixels */
    vv_vec3 away;        /**< direction of ticks, length 1 */
    struct {
        vv_vec3 at;
        vvi_sheet_axis_label number;
    } tick[VVI_AXIS_TICKS];
    int n;
    vvi_sheet_axis_label name;
} vvi_sheet_axis;
typedef struct vvi_sheet_axes {
    vvi_sheet_axis axis[3];
} vvi_sheet_axes;
/** Numbers that find no room are left out, and so are axes with fewer than two. */
void vvi_sheet_axes_place(vvi_sheet_axes *out, vvi_sheet *sheet);
vv_status vvi_sheet_axes_draw(const vvi_sheet_axes *axes, const vvi_sheet *sheet);

typedef struct vvi_sheet_legend {
    struct vvi_sheet_legend_line *line;
    size_t n;
    vvi_box box;
    bool there, plate;
    double top; /**< opacity of the upper ends of curves */
} vvi_sheet_legend;
vv_status vvi_sheet_legend_place(vvi_sheet_legend *out, vvi_sheet *sheet);
vv_status vvi_sheet_legend_draw(const vvi_sheet_legend *legend, const vvi_sheet *sheet);
void vvi_sheet_legend_finish(vvi_sheet_legend *legend);

/** Letters at the borders: left, right, top, bottom. */
typedef struct vvi_sheet_sides {
    vvi_sheet_axis_label side[4];
} vvi_sheet_sides;
enum { VVI_SIDE_TEXT = 64 };
/** "R", "LA", "−y": the axes that a direction of length 1 mostly runs along, the most first. */
void vvi_sheet_side_text(char out[VVI_SIDE_TEXT], vv_vec3 direction, bool anatomical);
void vvi_sheet_sides_place(vvi_sheet_sides *out, vvi_sheet *sheet);
vv_status vvi_sheet_sides_draw(const vvi_sheet_sides *sides, const vvi_sheet *sheet);

/** Across the picture, with a gap where it is. */
vv_status vvi_sheet_cross_hair(const vvi_sheet *sheet);

/** Measurements of the World: places and lines of those that show, and what came out of each. */
enum { VVI_SHEET_MEASUREMENTS = 64 };
typedef struct vvi_sheet_measurements {
    struct {
        const vv_measurement *of;
        vvi_sheet_axis_label label;
    } shown[VVI_SHEET_MEASUREMENTS];
    size_t n;
} vvi_sheet_measurements;
/** Whether a scene has any that show. */
bool vvi_sheet_has_measurements(const vv_scene *scene);
/** Letters that find no room are left out, lines never. */
void vvi_sheet_measurements_place(vvi_sheet_measurements *out, vvi_sheet *sheet);
vv_status vvi_sheet_measurements_draw(const vvi_sheet_measurements *measurements, const vvi_sheet *sheet);

/** All that stands on a picture. */
typedef struct vvi_sheet_plan {
    vvi_sheet_captions captions;
    vvi_sheet_scale_bar bar;
    vvi_sheet_cube cube;
    vvi_sheet_legend legend;
    vvi_sheet_axes axes;
    vvi_sheet_sides sides;
    vvi_sheet_measurements measurements;
} vvi_sheet_plan;
/** Places what is wanted, in this order: title and caption, letters at the borders, scale bar, cube, legend,
 * axes, measurements. Who comes first has the
 * first choice, and stays longest as pictures grow small. No two boxes meet, and none leaves the picture. Finish it,
 * after errors too. */
vv_status vvi_sheet_place(vvi_sheet_plan *out, vvi_sheet *sheet);
void vvi_sheet_plan_finish(vvi_sheet_plan *plan);

/** Text of a line of a legend; "" of strips of colours. NULL past the last. */
const char *vvi_sheet_legend_text(const vvi_sheet_legend *legend, size_t i);

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
