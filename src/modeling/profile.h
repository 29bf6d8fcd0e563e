/** @file
 * Density from signed distance: 1 far inside, 0 far outside, 0.5 at distance 0.
 */
#ifndef VVI_MODELING_PROFILE_H
#define VVI_MODELING_PROFILE_H
#include <stddef.h>

typedef enum vvi_profile_kind {
    VVI_PROFILE_LINEAR,     /**< a ramp: trilinear interpolation meets planes exactly from sqrt(3) voxels on */
    VVI_PROFILE_HYPERCONE,  /**< of a plane seen through a ball with a weight that falls as a cone: the paper's */
    VVI_PROFILE_GAUSSIAN,   /**< the same of a normal distribution, cut at 3 sigma and stretched to end at 0 and 1 */
    VVI_PROFILE_SMOOTHSTEP, /**< without a kink at its ends */
    VVI_PROFILES
} vvi_profile_kind;

enum { VVI_PROFILE_STEPS = 1024 };

typedef struct vvi_profile {
    double width;                       /**< densities are 1 at -width and below, 0 at width and above */
    float table[VVI_PROFILE_STEPS + 2]; /**< the last twice */
} vvi_profile;

/** The formula, from -1 to 1 of the width; what lies beyond is as its ends. */
double vvi_profile_at(vvi_profile_kind kind, double s);
/** `width` is above 0. */
void vvi_profile_init(vvi_profile *out, vvi_profile_kind kind, double width);
/** What surfaces come out best with, in voxels. */
double vvi_profile_voxels(vvi_profile_kind kind);
/** Read from the table; NaN is 0. */
void vvi_profile_densities(float *out, const double *distances, size_t n, const vvi_profile *profile);
#endif
