/** @file
 * Textures: an image or a pattern that fills space, on the colours of a volume, before light.
 *
 * A point q of the texture's space (lengths there are images, cells, rings or veins; the middle of the volume is 0,
 * unless it has a place) has a colour and a coverage a:
 *
 *   image    planar       u = 1/2 + x, v = 1/2 - z width / height (as a slide shown from -y, z up)
 *            cylindrical  u = 1/2 + atan2(x, -y) / 2 pi, v = 1/2 - z (once around, one length high)
 *            spherical    u = the same, v = acos(z / |q|) / pi (once around, pole to pole)
 *   checker  cells of side 1, the second colour where floor(x) + floor(y) + floor(z) is odd
 *   wood     rings about z: r = hypot(x, y) + n(q / 4) / 2, s = (1 + cos(2 pi r)) / 2,
 *            second colour's share = s^2 + 0.15 n(6 x, 6 y, z / 2)
 *   marble   veins across x: s = (1 + cos(2 pi (x + 1.5 sum_{i<4} 2^-i |n(2^i q)|))) / 2, share = s^3
 *   noise    share = 1/2 + 3/4 sum_{i<4} 2^-i n(2^i q)
 *
 * n is gradient noise (Perlin 2002) on a lattice of hashed integers: the same numbers on every machine. What one pixel
 * spans, w lengths at the distance of the point, takes what is finer away: images are looked up between two levels of a
 * pyramid of means, where one texel is w; the checker is the mean over a cube of side w; waves of f cycles a length
 * fade to their mean from f w = 1/4 to 1/2; f is 1 for rings, 6 for fibres, 2 for veins.
 *
 * With strength s, modulate: colour (1 - s a + s a texture); replace: colour (1 - s a) + s a texture.
 */
#ifndef VVI_RENDER_TEXTURE_H
#define VVI_RENDER_TEXTURE_H
#include "image/image_levels.h"
#include <volvis/sys/scene.h>

enum { VVI_TEXTURE_LANES = 16, VVI_TEXTURE_OCTAVES = 4 };

typedef struct vvi_texture {
    int kind, mapping, wrap;
    bool replace, parallel;
    float strength, color[2][3];
    uint32_t seed;
    float from_index[3][4];  /**< from the volume's index space */
    float pixel;             /**< lengths that a pixel spans: parallel: anywhere; else at distance 1 */
    float aspect;            /**< width / height of the image */
    vvi_image_levels levels; /**< owned */
} vvi_texture;

/** What kernels need of the texture that an actor has. VV_E_LIMIT, VV_E_MEMORY, VV_E_CANCELLED; then close it too. */
vv_status vvi_texture_open(vvi_texture *out, const vv_actor *actor, const vv_scene *scene, vv_job *job);
void vvi_texture_close(vvi_texture *t); /* zeroed is fine */

/**
 * The texture on colours of several points at once: texture_kernel.c, built once per instruction set.
 *
 * Shapes   rgb, at: [3][points]; at in the volume's index space; bits: which of the points
 * Units    distance from the eye, world lengths
 * Threads  any
 */
typedef void vvi_texture_kernel(float rgb[3][VVI_TEXTURE_LANES], const vvi_texture *t, float at[3][VVI_TEXTURE_LANES],
                                const float distance[VVI_TEXTURE_LANES], uint32_t bits);

/* The bits by which a lattice point of the noise has its gradient, one of the 12 towards the edges of a cube. From the
 * seed, one coordinate after the other: h = turned by 15 bits (h ^ coordinate * STEP) * TURN; then the last mixing of
 * MurmurHash3, by which every bit of the place changes half of the bits. */
#define VVI_HASH_STEP 0xcc9e2d51U
#define VVI_HASH_TURN 0x1b873593U
#define VVI_HASH_MIX_A 0x85ebca6bU
#define VVI_HASH_MIX_B 0xc2b2ae35U
static inline uint32_t vvi_hash_start(uint32_t seed)
{
    return seed * 0x9e3779b9U + 0x85ebca6bU;
}

#endif
