/** @file
 * Light at one point, for all that draws: meshes (gfx) and volumes (render). What a lamp sends there, and how much of
 * it a surface returns to the eye. lamp_simd.h is the same with vectors.
 *
 *   out = color (ambient A + diffuse sum L_i |n.l_i|) + specular sum L_i s_i
 *
 * n is the surface's normal, A the ambient light, L_i a lamp's colour where the point is (falloff, cone), l_i the way
 * to it, v the way to the eye; all ways have length 1. Blinn: s = max(n'.h, 0)^shininess, h = (l + v) / |l + v|, n'
 * being n on the lamp's side; Phong: s = max(r.v, 0)^shininess, r = 2 (n.l) n - l. One-sided: max(n.l, 0) for |n.l|,
 * and no highlight where that is 0.
 *
 * Source   Phong 1975; Blinn 1977
 */
#ifndef VVI_GFX_LAMP_H
#define VVI_GFX_LAMP_H
#include "core/vec.h"
#include <volvis/sys/scene.h>

/** A lamp as kernels see it. */
typedef struct vvi_lamp {
    int kind;                       /**< vv_light_kind, never ambient */
    float to_light[3], position[3]; /**< against the light's travel, length 1; from the origin asked for */
    float color[3];
    float cos_outer, inverse_fade; /**< of spots: 1 / (cos_inner - cos_outer) */
    float falloff[3];
} vvi_lamp;

/** How a surface returns light. */
typedef struct vvi_gloss {
    bool phong;                                     /**< else Blinn's highlights */
    float ambient[3], diffuse, specular, shininess; /**< ambient: times the ambient light */
    int32_t whole_shininess;                        /**< the same where it is a small whole number, else 0 */
    float least_shine;                              /**< and the number whose power by it is 2^-60 */
} vvi_gloss;

vvi_lamp vvi_lamp_from(const vv_lamp *lamp, vv_vec3 origin);
/** model: vv_shading_model; ambient_light: A. */
vvi_gloss vvi_gloss_of(int model, float ambient, float diffuse, float specular, float shininess,
                       const float ambient_light[3]);

/** The way to a lamp (length 1) and its colour at a position; the definition. */
void vvi_lamp_at(vv_vec3 *to_lamp_out, double light_out[3], const vv_lamp *lamp, vv_vec3 position);

/** A lit point. */
typedef struct vvi_lit_point {
    vv_vec3 position, normal, to_eye;
    bool surface;          /**< else `normal` is not the one of a surface: no highlight */
    bool two_sided;        /**< |n.l| */
    const double *arrives; /**< shares of A, then of each L_i, that arrive there; NULL, and beyond n_arrive: all */
    size_t n_arrive;
} vvi_lit_point;

/** Changes its colour to the light that it sends to the eye; the definition. */
void vvi_light_ref(double rgb[3], const vvi_lit_point *point, const vvi_gloss *gloss, const vv_lamp *lamps,
                   size_t n_lamps);
#endif
