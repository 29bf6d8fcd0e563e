/** @file
 * Images on triangles: pyramids of their means, and what a pixel sees of them.
 */
#ifndef VVI_GFX_TEXTURE_H
#define VVI_GFX_TEXTURE_H
#include "core/cache.h"
#include "core/status.h"
#include "image/image_levels.h"
#include <volvis/mesh.h>

/** sRGB of 8 bits to light. */
typedef struct vvi_gfx_decode {
    float light[256];
} vvi_gfx_decode;
void vvi_gfx_decode_init(vvi_gfx_decode *out);

/** One image: texels are red, green, blue, alpha as in meshes; rows from the top. */
typedef struct vvi_gfx_texture {
    int wrap[2]; /**< vv_texture_wrap */
    int32_t n_levels, n[VVI_IMAGE_LEVELS][2];
    size_t first[VVI_IMAGE_LEVELS]; /**< texel of each level */
    uint8_t *texels;
    bool translucent; /**< one can look through some of it */
} vvi_gfx_texture;

typedef struct vvi_gfx_textures {
    vvi_gfx_texture *texture;
    size_t n;
    vvi_gfx_decode decode;
} vvi_gfx_textures;

/** Those of a mesh, made once and pinned: vvi_cache_release(); its value is vvi_gfx_textures. Errors: VV_E_MEMORY,
 * VV_E_LIMIT, VV_E_CANCELLED. */
vv_status vvi_gfx_textures_get(vvi_cached **out, const vv_mesh *mesh, vv_job *job);

/**
 * What a pixel sees of an image: its mean over the parallelogram that the pixel covers, by up to 8 places along the
 * longer side, each bilinear in two levels of the pyramid. Of a single place where nothing is covered.
 *
 * Shapes   at: u, v; across: their changes from this pixel to the one at the right, and to the one below
 * Out      linear, not premultiplied
 * Source   Williams 1983 (pyramids); places along one side as in EXT_texture_filter_anisotropic
 */
void vvi_gfx_texture_at(double rgba_out[4], const vvi_gfx_textures *textures, size_t index, const double at[2],
                        const double across[2][2]);
#endif
