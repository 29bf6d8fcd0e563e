/** @file
 * How much of the light arrives at each place of a scene: of the ambient light, and of each lamp's. In cells of a grid
 * around all that is drawn, a few voxels wide.
 *
 * Extinction is that of each cell, per world length, constant in it. Light runs from cell to cell, slice by slice
 * along the axis nearest to its way, interpolated between the four cells that it comes from: what spreads it by less
 * than a cell a slice is the method's own blur.
 *
 *   of a lamp      T = mean over the ways to its disc of exp(-integral of the extinction)
 *   ambient        A = mean over all ways of the integral of exp(-s / r) / r times the transmittance over s: what
 *                  arrives where ambient light is born again at distances that are r in the mean
 *
 * Over the sphere Lebedev's 26 points are taken, over a disc 7. Next to a half-space of extinction k the formula for A
 * gives (1 + 1 / (1 + k r)) / 2.
 *
 * Source   slice-wise propagation after Behrens and Ratering 1998; Lebedev 1976
 */
#ifndef VVI_RENDER_LIGHT_VOLUME_H
#define VVI_RENDER_LIGHT_VOLUME_H
#include "core/status.h"
#include <volvis/sys/scene.h>

/** Of the ambient light, then of each lamp's. */
enum { VVI_LIGHT_SHARES = 8, VVI_LIGHT_LAMPS = VVI_LIGHT_SHARES - 1 };

/** Cells and what they take of the light. */
typedef struct vvi_light_grid {
    int32_t n[3];
    vv_affine cell_to_world; /**< whole numbers are cells' centres */
    float *extinction;       /**< per world length, x fastest */
} vvi_light_grid;

static inline size_t vvi_light_cells(const int32_t n[3])
{
    return (size_t)n[0] * (size_t)n[1] * (size_t)n[2];
}

/** Shares of the ambient light, one a cell. radius: r, world length, above 0. */
vv_status vvi_light_ambient(float *out, const vvi_light_grid *grid, double radius, vv_job *job);
/** Of lamps: out[i] those of lamps[i]. disc: angle across a directional lamp as seen from anywhere, below pi; others
 * are points. */
vv_status vvi_light_lamps(float *const out[], const vvi_light_grid *grid, const vv_lamp *lamps, size_t n_lamps,
                          double disc, vv_job *job);

/** What kernels read: the roots of the shares in 255ths, so that dark ones keep their digits. */
typedef struct vvi_light_volume {
    const uint32_t *cells; /**< n_words side by side for each cell; byte b of word w is of share 4 w + b. NULL: all
                              light arrives everywhere */
    int32_t n[3];
    int n_words, n_shares;
    float ambient; /**< times the ambient light that is said */
    double world_to_cell[3][4];
    vv_vec3 ahead[3]; /**< edges of a box: a surface gets the light of a place ahead by the box's width along its
                         normal, beyond the cells that it fills itself */
    float scatter[VVI_LIGHT_SHARES], scatter_rest; /**< of what is not shaded: weights of the shares, 1 together with
                                                      the light that always arrives */
    const uint32_t *scattered; /**< their sum, of each cell: its root in 255ths in byte 0, in byte 1 that of the next
                                  cell along y, in bytes 2 and 3 those of both's next along z: with the word beside it,
                                  all that is around a place. NULL: everything is shaded */
} vvi_light_volume;

/** Takes the finest pattern, which is that of the cells, from shares: with 1/4, 1/2, 1/4 along each axis.
 * only_brighter: no cell gets darker, so that a shadow does not reach cells in the light. */
void vvi_light_smooth(float *cells, const int32_t n[3], bool only_brighter);
/** Packs shares, of `n` sorts (NULL: all light arrives), into cells of n_words = (n + 3) / 4 words. */
void vvi_light_pack(uint32_t *cells, const float *const shares[], int n, size_t n_cells);
/** Sums them for what is not shaded: vvi_light_volume.scattered, a word for each cell. */
void vvi_light_pack_scattered(uint32_t *out, const vvi_light_volume *volume);

/** Shares at a place in the world: cells' interpolated linearly, those beyond the stored ones 1. `normal`: of the
 * surface there, on the side that is seen; 0: none. The definition of light_volume_simd.h. */
void vvi_light_volume_at(double shares_out[VVI_LIGHT_SHARES], const vvi_light_volume *volume, vv_vec3 position,
                         vv_vec3 normal);
/** What of an unshaded colour is left at such a place. */
double vvi_light_scattered(const vvi_light_volume *volume, vv_vec3 position, vv_vec3 normal);
#endif
