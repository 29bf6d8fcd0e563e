/** @file
 * Local illumination of one point, in double precision: the definition that shading kernels are tested against.
 */
#ifndef VVI_RENDER_SHADE_REF_H
#define VVI_RENDER_SHADE_REF_H
#include <volvis/sys/scene.h>

/** Gradient length (value per world length) below which there is no surface: 1e-6 of the value range per voxel. */
double vvi_shade_flat(const vv_actor *actor);

/**
 * Light that a point of an actor sends to the eye.
 *
 *   out = color (ambient A + diffuse sum L_i |n.l_i|) + specular sum L_i s_i
 *
 * n = -gradient / |gradient|; A is the scene's ambient light, L_i a lamp's colour where the point is (falloff, cone),
 * l_i the way to it, v = `to_eye`. Blinn: s = max(n'.h, 0)^shininess, h = (l + v) / |l + v|, n' being n on the lamp's
 * side; Phong: s = max(r.v, 0)^shininess, r = 2 (n.l) n - l. One-sided: max(n.l, 0) for |n.l|, and no highlight where
 * that is 0. Where |gradient| < flat: n = v and no highlight. Model none: out = color.
 *
 * Shapes   to_eye has length 1; gradient of the value in world space
 * Source   Phong 1975; Blinn 1977
 */
void vvi_shade_ref(double out[3], const vv_scene *scene, const vv_actor *actor, const double color[3], vv_vec3 position,
                   vv_vec3 gradient, vv_vec3 to_eye, double flat);

/** The way to a lamp (length 1) and its colour at a position. */
void vvi_lamp_at(vv_vec3 *to_lamp_out, double light_out[3], const vv_lamp *lamp, vv_vec3 position);

#endif
