/** @file
 * Triangles of a picture: vertices on it, samples of a tile, which triangle each sample sees, and its light.
 *
 * The samples of a tile know the nearest triangle and nothing else; light is worked out last, once for each pixel and
 * triangle that is seen there.
 */
#ifndef VVI_GFX_RASTER_H
#define VVI_GFX_RASTER_H
#include "gfx/backend.h"
#include "gfx/flat.h"
#include "gfx/texture.h"

/** Steps of vertex places in a pixel; what lies further out than VVI_GFX_REACH pixels is cut off first. */
enum { VVI_GFX_STEPS = 256, VVI_GFX_REACH = 24576 };

/** Why a vertex cannot be used as it is; bits. From VVI_GFX_OUT_CUTS on: the state's cuts, the last bit all the rest of
 * them. */
enum {
    VVI_GFX_OUT_NAN = 1,
    VVI_GFX_OUT_NEAR = 2,
    VVI_GFX_OUT_SIDES = 4, /**< four bits: left, right, above, below VVI_GFX_REACH */
    VVI_GFX_OUT_CUTS = 64
};

/** A vertex on the picture, in steps from its upper left corner. */
typedef struct vvi_gfx_vertex {
    int32_t x, y;
    float near;
    uint32_t out;
} vvi_gfx_vertex;

/** Vertices that no reason keeps out. id: not 0. */
typedef struct vvi_gfx_triangle {
    int32_t x[3], y[3];
    float near[3];
    uint32_t id;
} vvi_gfx_triangle;

/** Samples of a block of pixels, 16 in all; sample l belongs to pixel l / samples of the block, row by row. Places are
 * in units of 1 << shift steps from the block's corner. */
typedef struct vvi_gfx_pattern {
    int samples; /**< a pixel */
    int32_t width, height;
    int shift;
    int32_t x[16], y[16];
} vvi_gfx_pattern;

/** For 1, 4 and 8 samples a pixel. */
const vvi_gfx_pattern *vvi_gfx_pattern_for(int samples);
/** That of 8 with its rows moved down by `turn` eighths of a pixel, round about: the turns 0 .. 7 of it together look
 * at all 8 x 8 parts of a pixel. Others are as they are. */
vvi_gfx_pattern vvi_gfx_pattern_turned(int samples, int turn);

/** Of one tile: 16 for each block, blocks row by row, VVI_GFX_TILE / pattern->width a row. */
typedef struct vvi_gfx_samples {
    const vvi_gfx_pattern *pattern;
    int32_t x0, y0; /**< first pixel */
    float *near;    /**< nearest so far */
    uint32_t *id;   /**< whose; 0: nobody's */
    float *far;     /**< of each block, none of its samples is further; kernels keep it */
} vvi_gfx_samples;
enum { VVI_GFX_SAMPLES_MOST = VVI_GFX_TILE * VVI_GFX_TILE * 8 };

/**
 * The samples that a triangle covers and is nearest in become its own. A sample on an edge belongs to the triangle
 * whose left or upper edge it is, so that of all triangles around an edge or a vertex exactly one has it; nearness is
 * linear between the vertices and never beyond theirs. The definition: exact in whole numbers but for nearness.
 */
void vvi_gfx_raster_ref(vvi_gfx_samples *samples, const vvi_gfx_area *window, const vvi_gfx_triangle *triangle);

/** A mesh that is drawn. */
typedef struct vvi_gfx_draw {
    vvi_gfx_state state;
    vvi_gfx_surface surface;
    bool translucent;
    bool mirrored;
    uint32_t first;   /**< id of its first triangle */
    vv_affine to_eye; /**< from positions to world directions from the eye */
    double reach;     /**< from the eye to the furthest corner of the mesh's box; world */
    vvi_gfx_vertex *vertices;
    const struct vvi_gfx_prepared *prepared;
} vvi_gfx_draw;

/** What a pixel sees of a triangle. */
typedef struct vvi_gfx_fragment {
    uint32_t triangle; /**< of the draw */
    float x, y;        /**< middle of the samples that see it; pixels */
    float rgba[4];     /**< light sent to the eye, not times alpha */
    float depth;
    float normal[3];
} vvi_gfx_fragment;

/** The colour of a triangle where the ray through a place on the picture meets it, before light; decode NULL: in double
 * precision. */
void vvi_gfx_color_ref(double rgba_out[4], const vvi_gfx_draw *draw, const vvi_gfx_decode *decode, uint32_t triangle,
                       double x, double y);
/** Fills in rgba, depth and normal. In double precision, one at a time: the definition. */
void vvi_gfx_shade_ref(vvi_gfx_fragment *fragment, const vvi_gfx_draw *draw);
#endif
