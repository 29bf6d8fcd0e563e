/** @file
 * Local illumination of one point, in double precision: the definition that shading kernels are tested against.
 */
#ifndef VVI_RENDER_SHADE_REF_H
#define VVI_RENDER_SHADE_REF_H
#include "gfx/lamp.h"
#include "render/common/light_volume.h"

/** How far the values go that an actor's colours and opacity tell apart: from the first node that lies in the data to
 * the last, or from 0 to these, at most the range of all; what lies far outside does not count. That range without such
 * nodes, of labels, and of cubic interpolation, whose weights carry the rounding of large values. */
double vvi_shade_range(const vv_actor *actor);

/** Gradient length (value per world length) below which there is no surface: 1e-6 of that range per voxel. */
double vvi_shade_flat(const vv_actor *actor);

/**
 * Light that a point of an actor sends to the eye.
 *
 * As vvi_light_ref() with n = -gradient / |gradient|. Where |gradient| < flat: n = v and no highlight. Model none: out
 * = color, times what of it is left in the light that arrives (light_volume.h; NULL: all of it).
 *
 * Shapes   to_eye has length 1; gradient of the value in world space
 */
void vvi_shade_ref(double out[3], const vv_scene *scene, const vv_actor *actor, const double color[3], vv_vec3 position,
                   vv_vec3 gradient, vv_vec3 to_eye, double flat, const vvi_light_volume *volume);

#endif
