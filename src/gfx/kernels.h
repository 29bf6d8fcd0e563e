/** @file
 * The inner loops of the software back end, built once per instruction set.
 */
#ifndef VVI_GFX_KERNELS_H
#define VVI_GFX_KERNELS_H
#include "gfx/lamp.h"
#include "gfx/raster.h"

/** From positions of a mesh to the picture. */
typedef struct vvi_gfx_projection {
    float row[3][4];           /**< right, up, forward of a position */
    float scale[2], middle[2]; /**< as of vvi_gfx_view, in steps */
    float nearest;             /**< forward */
    bool parallel;
    const float (*cuts)[4]; /**< half-spaces of positions: a x + b y + c z >= d */
    size_t n_cuts;
} vvi_gfx_projection;

/** Triangles of one mesh to be sorted into tiles. */
typedef struct vvi_gfx_sorting {
    const uint32_t *triangles; /**< three vertices each */
    const vvi_gfx_vertex *vertices;
    vvi_gfx_area window;                    /**< pixels */
    int32_t across;                         /**< tiles */
    int samples;                            /**< a pixel */
    bool no_clockwise, no_counterclockwise; /**< on the picture, y down */
} vvi_gfx_sorting;

/** What falls out: numbers of triangles that lie in one tile, with it; and of those for which the kernel is too simple.
 * Each has room for all, and VVI_GFX_SPARE more. */
typedef struct vvi_gfx_sorted {
    int32_t *single, *tile, *other;
    size_t n_single, n_other;
} vvi_gfx_sorted;
enum { VVI_GFX_SPARE = 16 };

/** Entries of a bin that are to be drawn into the samples of a tile. */
typedef struct vvi_gfx_rastering {
    const uint32_t *entry;
    size_t n;
    const uint32_t *triangles; /**< of the bin: its first */
    const vvi_gfx_vertex *vertices;
    const vvi_gfx_triangle *pieces;
    uint32_t first;      /**< id of its first triangle */
    vvi_gfx_area window; /**< pixels of the tile that are drawn in */
    bool partly;         /**< the window leaves out pixels of the picture's in this tile */
} vvi_gfx_rastering;

/** Fragments of one mesh, as arrays; what is seen of them is filled in. Arrays have VVI_GFX_SPARE more. */
typedef struct vvi_gfx_fragments {
    size_t n;
    uint32_t *triangle; /**< of the mesh */
    float *x, *y;       /**< pixels */
    float *rgba[4];     /**< in: colour, where vertices have none; out: light sent to the eye, not times alpha */
    float *depth, *normal[3];
} vvi_gfx_fragments;

enum { VVI_GFX_RAMP = 4096 };

/** What all fragments of a mesh share. */
typedef struct vvi_gfx_lighting {
    const float *positions, *normals; /**< normals NULL: the triangles' */
    const uint8_t *colors;            /**< NULL: as in rgba */
    const uint32_t *triangles;
    const float *values; /**< NULL: no colours by value; else each is row (value - ramp_lo) * ramp_scale of `ramp` */
    const float *ramp;   /**< VVI_GFX_RAMP rows and one more of r, g, b */
    float ramp_lo, ramp_scale;
    const float *decode; /**< sRGB of bytes */
    float opacity;       /**< times that of colors */
    float nearest;       /**< forward: no depth is below it */
    float to_eye[3][4];  /**< from positions to the world, from the eye */
    float normal_to_world[3][3];
    float side;                        /**< -1 where the place mirrors, else 1 */
    float right[3], up[3], forward[3]; /**< right and up: of a pixel */
    float middle[2];
    bool parallel;
    int model, sides;
    vvi_gloss gloss;
    const vvi_lamp *lamps; /**< from the eye */
    size_t n_lamps;
} vvi_gfx_lighting;

typedef struct vvi_gfx_kernels {
    uint32_t needs; /**< VVI_CPU_* */
    const char *isa;
    void (*project)(vvi_gfx_vertex *out, const float *positions, size_t n, const vvi_gfx_projection *projection);
    /** Triangles 0 .. n - 1; those that cover no sample may be left out, those that nobody can see are. */
    void (*sort)(vvi_gfx_sorted *out, const vvi_gfx_sorting *sorting, size_t n);
    /** As vvi_gfx_raster_ref() for each entry in turn. */
    void (*raster)(vvi_gfx_samples *samples, const vvi_gfx_rastering *rastering);
    void (*shade)(vvi_gfx_fragments *fragments, const vvi_gfx_lighting *lighting);
} vvi_gfx_kernels;

/** The fastest that a machine with these VVI_CPU_* bits runs. */
const vvi_gfx_kernels *vvi_gfx_kernels_for(uint32_t cpu);
/** All builds that this program has, best first; NULL past the last. */
const vvi_gfx_kernels *vvi_gfx_kernels_nth(size_t index);
#endif
