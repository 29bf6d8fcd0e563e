/** @file
 * Lines, points, polygons and text, brought to the picture: projected, cut, dashed; and how much of each pixel they
 * cover.
 */
#ifndef VVI_GFX_FLAT_H
#define VVI_GFX_FLAT_H
#include "gfx/backend.h"

typedef enum vvi_gfx_flat_kind {
    VVI_GFX_SEGMENTS, /**< two spots each */
    VVI_GFX_DISCS,
    VVI_GFX_OUTLINE, /**< spots around an area */
    VVI_GFX_BITMAP   /**< one spot; coverage */
} vvi_gfx_flat_kind;

/** Colours of a shape; stops are kept copies. */
typedef struct vvi_gfx_paint {
    vv_color color;
    const vvi_gfx_stop *stops;
    size_t n_stops;
    vvi_gfx_spot from, to;
} vvi_gfx_paint;

typedef struct vvi_gfx_flat {
    vvi_gfx_flat_kind kind;
    const vvi_gfx_view *view; /**< NULL: in pixels */
    bool depth;               /**< is hidden, and hides; never without a view */
    uint32_t id;
    double window[4];
    double box[4]; /**< what it may cover: x0, y0, x1, y1 */
    vvi_gfx_spot *spots;
    size_t n_spots;
    double radius; /**< of segments and discs */
    vvi_gfx_paint paint;
    const uint8_t *coverage; /**< of bitmaps; its first pixel is at (left, top) */
    int32_t left, top, width, height;
} vvi_gfx_flat;

/** Kept by gfx. *out is NULL when nothing of it is in the picture. undashed: dashes are left to the caller. */
vv_status vvi_gfx_flat_line(vvi_gfx_flat **out, vvi_gfx *gfx, const vv_vec3 *points, size_t n_points, vvi_gfx_join join,
                            const vvi_gfx_stroke *stroke, bool undashed);
vv_status vvi_gfx_flat_points(vvi_gfx_flat **out, vvi_gfx *gfx, const vv_vec3 *points, size_t n_points, double diameter,
                              vv_color color);
vv_status vvi_gfx_flat_polygon(vvi_gfx_flat **out, vvi_gfx *gfx, const vv_vec3 *points, size_t n_points,
                               const vvi_gfx_fill *fill);
/** The halo first; either may be NULL. */
vv_status vvi_gfx_flat_text(vvi_gfx_flat *out[2], vvi_gfx *gfx, vv_vec3 at, const vvi_gfx_label *label,
                            const char *utf8);
/** Where a place is on the picture; false: behind the eye or cut away. */
bool vvi_gfx_spot_at(vvi_gfx_spot *out, const vvi_gfx_state *state, vv_vec3 at);

/** What of a convex polygon is before the eye and in the state's cuts: number of its corners. Both arrays have the same
 * room, twice as many as there will ever be. */
size_t vvi_gfx_cut_convex(vv_vec3 *points, vv_vec3 *spare, size_t n, size_t room, const vvi_gfx_state *state);
/** On the way from a to b, t from 0 to 1. */
vvi_gfx_spot vvi_gfx_between(vvi_gfx_spot a, vvi_gfx_spot b, double t);
/** Pixels from a label's place down to its base line, before it is turned; and how far its halo reaches. */
double vvi_gfx_base_line(const vvi_gfx_label *label);
double vvi_gfx_halo(const vvi_gfx_label *label);
/** Of a gradient; not premultiplied. */
vv_color vvi_gfx_stop_color(const vvi_gfx_stop *stops, size_t n_stops, double at);
/** Whether something at this depth is seen before what is there, if only just: a pixel and a half of depth decide
 * nothing, so that a line on a surface is seen. */
bool vvi_gfx_is_before(const vvi_gfx_view *view, double depth, double there);

/** Pixels that are worked on at once: [x0, x1) x [y0, y1), at most VVI_GFX_TILE each way. */
enum { VVI_GFX_TILE = 64 };
typedef struct vvi_gfx_area {
    int32_t x0, y0, x1, y1;
} vvi_gfx_area;

/** Draws a shape into the pixels of an area of an image. depth: of those pixels, VVI_GFX_TILE a row. */
vv_status vvi_gfx_flat_draw(const vvi_gfx_flat *shape, const vvi_gfx_area *area, vv_image *image, float *depth,
                            vv_job *job);
#endif
