/** @file
 * One convex piece of a triangle on the picture.
 */
#ifndef VVI_GFX_FACET_H
#define VVI_GFX_FACET_H
#include "gfx/raster.h"

enum { VVI_GFX_FACET_CORNERS = 8 };
/** Areas below are none: square pixels. */
#define VVI_GFX_FACET_AREA 1e-3

typedef struct vvi_gfx_facet {
    vvi_gfx_spot spot[VVI_GFX_FACET_CORNERS];
    double plane[3]; /**< nearness at (x, y): plane[0] x + plane[1] y + plane[2] */
    double low[2], high[2];
    vv_color color;           /**< lit, in its middle */
    const vvi_gfx_draw *draw; /**< whose it is; kept */
    uint32_t triangle;        /**< of the draw's mesh */
    uint16_t n;
    bool behind; /**< the target's image, which hides it */
    float error; /**< most difference of a colour on it from that of the middle, in 255ths as encoded */
} vvi_gfx_facet;

/** Area to the left or to the right, square pixels. */
double vvi_gfx_facet_area(const vvi_gfx_spot *spot, size_t n);
/** Of a polygon whose corners are given: plane and box. False: it has no area. */
bool vvi_gfx_facet_init(vvi_gfx_facet *facet);
/** What of a convex polygon of up to VVI_GFX_FACET_CORNERS corners lies in x0, y0, x1, y1: number of its corners, for
 * which there is room for three times as many. */
size_t vvi_gfx_facet_window(vvi_gfx_spot *spot, size_t n, const double window[4]);
/** Nearness on its plane, also beside it. */
static inline double vvi_gfx_facet_near(const vvi_gfx_facet *f, double x, double y)
{
    return f->plane[0] * x + f->plane[1] * y + f->plane[2];
}
vvi_gfx_spot vvi_gfx_facet_middle(const vvi_gfx_facet *facet);
/** Length of the longest side, pixels, and which one it is: from that corner to the next. */
double vvi_gfx_facet_longest(size_t *side_out, const vvi_gfx_facet *facet);

/** Cuts where numbers given at the corners, linear in between, are 0: *a_out has what is above and *b_out what is
 * below. False, and nothing is written, where one of them would have no area or too many corners. */
bool vvi_gfx_facet_cut(vvi_gfx_facet *a_out, vvi_gfx_facet *b_out, const vvi_gfx_facet *facet, const double *at);
/** Cuts from the middle of the longest side to the corner that is furthest from it. */
bool vvi_gfx_facet_halve(vvi_gfx_facet *a_out, vvi_gfx_facet *b_out, const vvi_gfx_facet *facet);

/** Which of two facets is before the other where both are. before: square pixels in which the first is nearer;
 * behind: in which it is further, by more than the tolerance. False: they share no area. */
bool vvi_gfx_facet_compare(double *before_out, double *behind_out, const vvi_gfx_facet *a, const vvi_gfx_facet *b,
                           double tolerance);
#endif
