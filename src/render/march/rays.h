/** @file
 * Rays, wherever they come from, in batches; and what has been found along them.
 *
 * Rays are followed in groups of neighbours, as many at once as an instruction set has lanes, so those that stand
 * beside each other here should lie close together in space. What comes out does not depend on the groups.
 */
#ifndef VVI_RENDER_MARCH_RAYS_H
#define VVI_RENDER_MARCH_RAYS_H
#include <math.h>
#include <volvis/sys/scene.h>

/** A group is as large as any instruction set's; a batch is small enough to stay in the nearest cache. */
enum { VVI_RAY_GROUP = 16, VVI_RAY_BATCH = 256 };

typedef struct vvi_rays {
    size_t n;                                                     /**< a multiple of VVI_RAY_GROUP */
    double origin[3][VVI_RAY_BATCH], direction[3][VVI_RAY_BATCH]; /**< world; directions have length 1 */
    double near[VVI_RAY_BATCH], far[VVI_RAY_BATCH]; /**< world distance from the origin; far may be INFINITY */
    float phase[VVI_RAY_BATCH];                     /**< where in its step each sample lies, 0 to 1 */
    int32_t cell[VVI_RAY_BATCH];  /**< of PARC's buffer (parc.h) that a ray of the eye passes; -1: none */
    int32_t pixel[VVI_RAY_BATCH]; /**< the caller's number; -1: nobody's, there to fill the group */
} vvi_rays;

/** What rays of a batch meet where their depths are, of a volume. */
typedef struct vvi_hits {
    int32_t volume[VVI_RAY_BATCH]; /**< vvi_march_volume.number; of several, of the one with most opacity there; -1: of
                                        none, and all else here is void */
    float value[VVI_RAY_BATCH];    /**< the stored number; of labels, that of the label */
    float gradient[3][VVI_RAY_BATCH]; /**< world, as the volume's light has it (vvi_sampler.gradient_to_world) */
    float normal[3][VVI_RAY_BATCH];   /**< world, length 1, on the ray's side: against the gradient, or of the face by
                                           which the ray enters; 0: there is none */
} vvi_hits;

/** What has been found along the rays of a batch. */
typedef struct vvi_sink {
    vvi_hits *hits;               /**< the caller's room for them; NULL: they are not asked for */
    float rgb[3][VVI_RAY_BATCH];  /**< light that arrives at the origin */
    float through[VVI_RAY_BATCH]; /**< share of the light from behind that does */
    float depth[VVI_RAY_BATCH]; /**< world distance of the surface, of the extreme value, or of where half of the light
                                     is gone; INFINITY: nowhere */
} vvi_sink;

/** The rays of one pass of a picture: pixel (X, Y) of its image looks through (X * stride + x, top + Y * stride + y) of
 * the scene's. */
typedef struct vvi_eye {
    vv_lens lens;
    int32_t width, height; /**< of the scene: what the lens spans */
    double x, y, stride;
    int32_t top;   /**< rows of the scene above those that are made now */
    int32_t rows;  /**< how many these are: PARC's buffer has no others */
    int32_t row;   /**< pixels from one row of the image to the next: pixel numbers are Y * row + X */
    bool jitter;   /**< phases differ from ray to ray; same seed, same phases */
    uint64_t seed; /**< of this pass */
} vvi_eye;

/** Where in its steps the samples of a ray lie, 0 to 1: spread evenly over neighbouring pixels (Jimenez 2014), and over
 * the passes of a picture by the golden ratio. */
static inline float vvi_ray_phase(int32_t x, int32_t y, uint64_t seed)
{
    const double a = 0.06711056 * x + 0.00583715 * y, b = 52.9829189 * (a - floor(a));
    const double c = b + 0.6180339887498949 * (double)(seed & 0xffff);
    return (float)(c - floor(c));
}

/** Rays of the pixels of a tile, of at most VVI_RAY_BATCH with those that fill its edges to blocks of 4 x 4. */
typedef void vvi_eye_kernel(vvi_rays *out, const vvi_eye *eye, const vv_tile *tile);

#endif
