/** @file
 * The reference in double precision: one ray through one volume, as its parts see it.
 */
#ifndef VVI_RENDER_RAYCAST_REF_H
#define VVI_RENDER_RAYCAST_REF_H
#include "render/raycast/raycast.h"
#include "scene/lens.h"

typedef struct vvi_ref_ray {
    const vv_scene *scene;
    const vvi_raycast_volume *volume;
    vv_vec3 origin, direction; /* world */
    double t0, t1;
    bool by_cut;     /* whether it enters by a cut plane */
    vv_vec3 inwards; /* normal of the face or plane that it enters by; along the ray where it starts inside */
} vvi_ref_ray;

/** Where the ray lies in the volume; false: it misses. */
bool vvi_ref_clip(vvi_ref_ray *r);
/** Stored number at distance t; of labels with smooth borders the one that wins. */
double vvi_ref_value(const vvi_ref_ray *r, double t);
/** Where half of all light is gone in a step that takes `alpha` of what still passes. */
double vvi_ref_half(double from, double to, double clear, double alpha);
/** Its gradient, stored numbers per world length. */
vv_vec3 vvi_ref_gradient(const vvi_ref_ray *r, double t);
/** The colours that a volume has from elsewhere, over those that it has by its classification. */
void vvi_ref_paint(double rgb[3], const vvi_ref_ray *r, double t);
/** The texture on a colour at distance t, where the volume has one. */
void vvi_ref_texture(double rgb[3], const vvi_ref_ray *r, double t);
/** Light on a colour at distance t; facing: of a surface. */
void vvi_ref_shade(double out[3], const vvi_ref_ray *r, double t, const double color[3], bool facing);
/** Row of the frame's table for a stored number. */
int64_t vvi_ref_row(const vvi_march_volume *f, double value);
/** First surface; *depth stays INFINITY where there is none. */
void vvi_ref_surface(double rgba[4], double *depth, const vvi_ref_ray *r);

/** Any number of volumes, straight from section 2.2; depth where half of the light is gone. */
void vvi_ref_blend(double rgba[4], double *depth, const vv_scene *scene, const vvi_raycast_state *state,
                   const vvi_ref_ray *rays);
#endif
