/** @file
 * What the general kernel of the ray caster gets: several volumes, each classified in its own way, blended along one
 * ray.
 */
#ifndef VVI_RENDER_MARCH_BLEND_KERNEL_H
#define VVI_RENDER_MARCH_BLEND_KERNEL_H
#include "render/common/transfer_plane.h"
#include "render/march/kernels.h"

enum { VVI_BLEND_VOLUMES = 8 };

/** How values become colour and optical depth. */
typedef enum vvi_classify {
    VVI_CLASSIFY_TABLE,      /**< the table's row of the value in the middle of a step */
    VVI_CLASSIFY_INTEGRATED, /**< the mean over all values from the front to the back of a step */
    VVI_CLASSIFY_PLANE,      /**< by value and length of the gradient */
    VVI_CLASSIFY_LABELS      /**< the table's row of the label that has most weight */
} vvi_classify;

/** One volume of a blend. */
typedef struct vvi_blend_volume {
    vvi_march_volume ray; /**< place, samples, blocks, table, light; `step` is the same in all volumes of a frame */
    bool nearest, cubic;  /**< cubic: the lattice has coefficients (cubic_spline.h) */
    int classify;
    /* integrated: place = stored * row_scale + row_shift; row i holds for places from i to i + 1, the first and the
     * last beyond them too. Optical depth of a full step times red, green, blue, and alone. */
    float row_scale, row_shift;
    int32_t n_rows;
    const int32_t *sum; /**< n_rows + 1 rows of 4: integrals from place 0, in units of sum_unit */
    const float *mean;  /**< n_rows rows of 4 */
    float sum_unit[4];
    /* optical depth times min(gradient * modulate_scale, 1) ^ modulate_power; power 0: as it is */
    float modulate_scale, modulate_power;
    /* plane: column = stored * plane_scale + plane_shift, row = gradient * plane_gradient */
    const float *plane;
    float plane_scale, plane_shift, plane_gradient;
    float label_range; /**< labels: the gradient of one of them is made this much longer, as if it were a value */
} vvi_blend_volume;

typedef struct vvi_blend_setup {
    vvi_blend_volume volume[VVI_BLEND_VOLUMES];
    size_t n_volumes; /**< at least 1; all have the same view, step and `opaque` */
    double step;
    float opaque; /**< a ray ends when less transmittance than this is left */
} vvi_blend_setup;

#endif
