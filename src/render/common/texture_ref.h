/** @file
 * Textures in double precision, straight from the formulas of texture.h: the definition that the ray caster is tested
 * against.
 */
#ifndef VVI_RENDER_TEXTURE_REF_H
#define VVI_RENDER_TEXTURE_REF_H
#include "render/common/texture.h"

/**
 * The texture on a colour.
 *
 * Shapes   world: the point, in the World; distance: of it from the eye, in world lengths; height: of the image, pixels
 * Note     levels of an image are those of `t`, which have tests of their own
 */
void vvi_texture_ref(double rgb[3], const vvi_texture *t, const vv_texture *texture, const vv_lens *lens,
                     int32_t height, vv_vec3 world, double distance);

/** Gradient noise at a point, about -1 to 1. */
double vvi_texture_noise_ref(double x, double y, double z, uint32_t seed);

#endif
