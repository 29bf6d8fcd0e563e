/** @file
 * A volume as rays meet it, in parts by what they mean: where its samples are, which of it can be jumped, what values
 * are seen as, and in which light. Worked out once a frame; kernels only read it.
 */
#ifndef VVI_RENDER_MARCH_VOLUME_H
#define VVI_RENDER_MARCH_VOLUME_H
#include "gfx/lamp.h"
#include "grid/lattice.h"
#include "render/common/light_volume.h"
#include "render/march/parc.h"
#include "render/march/skip.h"

enum { VVI_RAY_PLANES = 32, VVI_RAY_LAMPS = 16 };

/** No opacity is as large. */
enum { VVI_ENTRY_SPLIT = 2 };

/** Where the samples are, and how a value between them is found. */
typedef struct vvi_sampler {
    vvi_lattice lattice;
    bool nearest;       /**< the value of the nearest sample, not interpolated */
    bool cubic;         /**< by a spline whose coefficients the lattice has (cubic_spline.h) */
    bool cell_gradient; /**< gradients are those of cells, not central differences */
    double world_to_index[3][4];
    float index_to_world[3][4];
    float gradient_to_world[3][3]; /**< inverse transpose of the linear part, times voxel / range of stored values */
    double lo[3], hi[3];           /**< the domain in index space */
    size_t n_planes;
    double planes[VVI_RAY_PLANES][4]; /**< kept side n . p >= c: n, c; world space */
} vvi_sampler;

/** How kernels take samples: VVI_SAMPLE_* of the lattice (vvi_lattice_kernel), or by splines. */
enum { VVI_RAY_CUBIC = VVI_SAMPLE_KERNELS, VVI_RAY_SAMPLERS };
static inline int vvi_march_sampler(const vvi_sampler *s)
{
    return s->cubic ? VVI_RAY_CUBIC : vvi_lattice_kernel(&s->lattice);
}

/** What can be jumped. */
typedef struct vvi_skipper {
    const uint8_t *reach; /**< of each block (skip.h); NULL: none. For means and sums, blocks of one value are empty */
    const float
        *block_bound; /**< most that a block can add to a projection: its largest stored value, or smallest. For
                         means and sums the one value of blocks that are empty; no finite number: they have none */
    int32_t blocks[3];
    int shift;
    const vvi_parc *parc; /**< where rays of the eye meet boxes in which something is visible; NULL: not known */
} vvi_skipper;

/** How values become colour and optical depth. */
typedef enum vvi_classify {
    VVI_CLASSIFY_TABLE,      /**< the table's row of the value in the middle of a step */
    VVI_CLASSIFY_INTEGRATED, /**< the mean over all values from the front to the back of a step */
    VVI_CLASSIFY_PLANE,      /**< by value and length of the gradient */
    VVI_CLASSIFY_LABELS      /**< the table's row of the label that has most weight */
} vvi_classify;

/** What a value is seen as: entry = trunc(stored * entry_scale + entry_shift), clamped to [0, last_place]. An entry
 * that is split has entries of its own, evenly spaced over the places from it to the next. */
typedef struct vvi_classifier {
    int kind;
    const float *alpha; /**< opacity of one step, by entry; split: the first of its own + VVI_ENTRY_SPLIT */
    const float *seen;  /**< r, g, b, that opacity, by entry; split: how many, -, -, as above */
    const float *color; /**< r, g, b, optical depth of one step, by entry; split: how many, -, -, -alpha */
    bool has_split;     /**< whether there are such */
    float entry_scale, entry_shift;
    float last_place; /**< a hair below the number of entries that are not of others */
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
    const float *plane, *plane_any; /**< by column: whether it or the next has any */
    float plane_scale, plane_shift, plane_gradient;
    float label_range; /**< labels: the gradient of one of them is made this much longer, as if it were a value */
} vvi_classifier;

/** What a projection makes one value of each ray by, in stored numbers. */
typedef struct vvi_projection {
    float sign;        /**< of extrema: 1 the largest, -1 the smallest */
    float threshold;   /**< of local maxima */
    float stored_zero; /**< the stored number that means 0 */
    bool over_longest; /**< the sum over the longest ray's length, not over the ray's own */
    float longest;     /**< steps from corner to corner */
    float opacity;     /**< of what is found */
    bool by_value;     /**< times that of the table's row */
} vvi_projection;

/** A solid is where the stored value is in [lo, hi]. */
typedef struct vvi_solid {
    float lo, hi;
    float unit; /**< 1 / range of the stored values: products of differences stay in the range of floats */
    float color[3];
} vvi_solid;

/** Where colours come from, if not from the classification. */
typedef enum vvi_paint_kind {
    VVI_PAINT_NONE,
    VVI_PAINT_COLORS, /**< the volume's own: four numbers of 16 bits a sample (colors.h) */
    VVI_PAINT_MAP     /**< another volume's values, through a table */
} vvi_paint_kind;

#define VVI_PAINT_LEAVES 1.0f

typedef struct vvi_paint {
    int kind;
    bool nearest;
    vvi_lattice lattice; /**< colours: offsets count samples, of 8 bytes */
    /* map: from the volume's index space to its own, where it has samples in [lo, hi]; rows of r, g, b and
     * VVI_PAINT_LEAVES where the colours that were there stay, else 0 */
    float from_index[3][4], lo[3], hi[3];
    const float *color;
    float entry_scale, entry_shift;
    int32_t n_entries;
} vvi_paint;

typedef struct vvi_light {
    bool shaded;           /**< colours are changed by light: by lamps, or by how much of it arrives */
    bool unlit, two_sided; /**< unlit: only by how much arrives */
    bool capped;           /**< what lies on the face of a cut plane is lit as that face */
    float cap_depth;       /**< to this many steps behind it: a voxel, whatever the step, but at least one */
    vvi_gloss gloss;
    float flat_gradient; /**< a gradient shorter than this, in ranges a voxel, has no direction */
    size_t n_lamps;
    vvi_lamp lamps[VVI_RAY_LAMPS];
    vvi_light_volume volume;
    float cell_from_index[3][4]; /**< to the light volume's cells */
    float cell_from_world[3][3]; /**< the same of ways in the world */
    float ahead[3][3];           /**< the box ahead of surfaces, world */
} vvi_light;

typedef struct vvi_march_volume {
    int32_t number; /**< that hits are told by */
    vvi_sampler sampler;
    vvi_skipper skipper;
    vvi_classifier classifier;
    vvi_projection projection;
    vvi_solid solid;
    vvi_light light;
    vvi_paint paint;
    const struct vvi_texture *texture; /**< on colours, before light (texture.h); NULL: none */
    double step;                       /**< world length between samples */
    float steps;                       /**< about how many the longest ray has */
    float opaque;                      /**< a ray ends when less transmittance than this is left */
} vvi_march_volume;

/** Several volumes along one ray. */
enum { VVI_BLEND_VOLUMES = 8 };
typedef struct vvi_blend_setup {
    vvi_march_volume volume[VVI_BLEND_VOLUMES];
    size_t n_volumes; /**< at least 1; all have the same view and `opaque` */
    float opaque;     /**< a ray ends when less transmittance than this is left */
} vvi_blend_setup;

#endif
