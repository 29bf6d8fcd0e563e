/** @file
 * Local illumination of one point, in double precision: the definition that shading kernels are tested against.
 */
#ifndef VVI_RENDER_SHADE_REF_H
#define VVI_RENDER_SHADE_REF_H
#include "gfx/lamp.h"

/** Gradient length (value per world length) below which there is no surface: 1e-6 of the value range per voxel. */
double vvi_shade_flat(const vv_actor *actor);

/**
 * Light that a point of an actor sends to the eye.
 *
 * As vvi_light_ref() with n = -gradient / |gradient|. Where |gradient| < flat: n = v and no highlight. Model none: out
 * = color.
 *
 * Shapes   to_eye has length 1; gradient of the value in world space
 */
void vvi_shade_ref(double out[3], const vv_scene *scene, const vv_actor *actor, const double color[3], vv_vec3 position,
                   vv_vec3 gradient, vv_vec3 to_eye, double flat);

#endif
