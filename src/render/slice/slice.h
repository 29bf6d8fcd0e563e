/** @file
 * A plane through the volumes: what is in it, exactly, pixel by pixel. slice.c is the row; sample.c says which value
 * is at a place, colors.c which light that value has.
 */
#ifndef VVI_RENDER_SLICE_H
#define VVI_RENDER_SLICE_H
#include "grid/probe.h"
#include "render/common/cubic_spline.h"
#include "scene/transfer.h"

/** Which plane. */
typedef enum vvi_slice_way {
    VVI_SLICE_AXIAL, /**< the first VVI_SLICE_WAYS: rows of vvi_slice_axes_of() */
    VVI_SLICE_CORONAL,
    VVI_SLICE_SAGITTAL,
    VVI_SLICE_CAMERA /**< at right angles to the line of sight */
} vvi_slice_way;
/** Whose axes. */
typedef enum vvi_slice_plane { VVI_SLICE_OF_WORLD, VVI_SLICE_OF_SAMPLES } vvi_slice_plane;

/** views.<view>.render.slice */
typedef struct vvi_slice_params {
    vv_object base;
    int orientation; /**< vvi_slice_way */
    int axes;        /**< vvi_slice_plane */
} vvi_slice_params;

/* Values ---------------------------------------------------------------------------------------------------------- */

/** One volume, ready to be asked for what is at a place. */
typedef struct vvi_slice_samples {
    vvi_probe probe[4]; /**< the values; of colours: red, green and blue times alpha, alpha */
    int n_probes;
    struct vvi_cached *colors;
    vvi_lattice_hold cubic; /**< spline coefficients, where has_cubic */
    bool has_cubic;
    double lo[3], hi[3]; /**< where there are values, index space */
} vvi_slice_samples;

/** On failure, too, close it. The actor outlives it. */
vv_status vvi_slice_samples_open(vvi_slice_samples *out, const vv_actor *actor, vv_job *job);
void vvi_slice_samples_close(vvi_slice_samples *samples); /* zeroed is fine */
/** n_probes numbers at index coordinates; false: outside. Values of which a sample around is none are NaN. */
bool vvi_slice_sample(double out[4], const vvi_slice_samples *samples, const double p[3]);
/** The label there; false: outside. */
bool vvi_slice_label(vv_label_id *out, const vvi_slice_samples *samples, const double p[3]);

/* Light ----------------------------------------------------------------------------------------------------------- */

enum { VVI_SLICE_ROWS = 4096 };

/** From values to light, of one volume. */
typedef struct vvi_slice_colors {
    const vv_actor *actor;
    float (*map)[3]; /**< VVI_SLICE_ROWS linear colours over the window */
    double lo, scale;
    vvi_transfer_table transfer;
    float opacity;
} vvi_slice_colors;

/** On failure, too, finish it. */
vv_status vvi_slice_colors_init(vvi_slice_colors *out, const vv_actor *actor, vv_job *job);
void vvi_slice_colors_finish(vvi_slice_colors *colors); /* zeroed is fine */
/** Linear, premultiplied light of what vvi_slice_sample() gave: rgba_out. */
void vvi_slice_color(float rgba_out[4], const vvi_slice_colors *colors, const double sample[4]);
/** The same of a label, where vvi_slice_has_ids(). */
void vvi_slice_label_color(float rgba_out[4], const vvi_slice_colors *colors, vv_label_id label);
/** Whether the volume shows labels of 64 bits, which doubles may take for one another. */
bool vvi_slice_has_ids(const vv_actor *actor);

#endif
