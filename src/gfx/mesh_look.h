/** @file
 * What a mesh of a scene looks like: its colours and normals at a place of a triangle, for all that draw it.
 */
#ifndef VVI_GFX_MESH_LOOK_H
#define VVI_GFX_MESH_LOOK_H
#include "gfx/backend.h"
#include "gfx/texture.h"

/** The surface that a mesh of a scene is drawn as. Its mesh is *shown, which gets the colours that it is shown in. */
vvi_gfx_surface vvi_gfx_surface_of(vv_mesh_info *shown, const vv_mesh_actor *actor);

/** The shares of a triangle's corners where the ray start + t way meets its plane, none below 0 (Moeller & Trumbore
 * 1997). */
void vvi_gfx_shares(double out[3], vv_vec3 start, vv_vec3 way, const vv_vec3 corner[3]);
/** How they change from a pixel to the one at its right, and to the one below. */
void vvi_gfx_share_slopes(double out[2][3], const vvi_gfx_view *view, vv_vec3 start, vv_vec3 way,
                          const vv_vec3 corner[3]);

/** Linear colour and opacity, not premultiplied, at a place of a triangle that is given by the shares of its corners.
 * decode NULL: in double precision. slope: of the shares, of a pixel; NULL: of textures the finest level is seen. */
void vvi_gfx_color_at(double rgba_out[4], const vvi_gfx_surface *surface, const vvi_gfx_decode *decode,
                      uint32_t triangle, const double share[3], const double slope[2][3]);

/** The colour of a value by the surface's ramp, whose ends hold beyond it; of two rows at one value the later. */
void vvi_gfx_ramp_color(double rgb_out[3], const vvi_gfx_surface *surface, double value);

/** The normal of the front there where the mesh is placed, length 1: that of the vertices, flat: of the triangle, as
 * where these have none; false: it has no area, and none is known. */
bool vvi_gfx_normal_at(vv_vec3 *out, const vv_mesh_info *mesh, const vv_affine *place, uint32_t triangle,
                       const double share[3], bool flat);
#endif
