/** @file
 * What is inside: the samples of an object as rows of bits, slice by slice, of every type and kind of choice.
 */
#ifndef VVI_MEASURE_OBJECT_H
#define VVI_MEASURE_OBJECT_H
#include "measure/region_samples.h"
#include "surface/marching_kernel.h"
#include <volvis/measure.h>

/** A choice, ready to be asked. Every step-th sample counts: 2 for the coarse look that tells errors. */
typedef struct vvi_object {
    const vv_field *field;
    const vv_field *samples; /**< what is compared: the field, or the mask */
    int component;
    bool label, mask;
    vv_label_id id;
    double lo, hi; /**< stored, of the samples; lo is -infinity and hi infinity where nothing limits */
    int64_t step;
    int64_t n[3];
    size_t words; /**< of a row of bits: one more than it needs, which is 0 */
    const vvi_march_kernels *kernels;
    vvi_march_type type;       /**< as which rows are classified at once; VVI_MARCH_TYPES: one by one */
    bool any, below_all;       /**< any: some sample may be inside; below_all: nothing is above hi */
    char least[8], above[8];   /**< thresholds of the type: inside from least on, but not from above on */
    uint64_t *section;         /**< bits of all rows of the piece around the seed; NULL: everything */
    double scale, offset;      /**< value = stored * scale + offset */
    double value_lo, value_hi; /**< the range in values */
    bool shaped;               /**< only what is in `shape` is inside */
    vvi_region_samples shape;
    vv_job *job;
} vvi_object;

/** Checks the choice. Close it also when it fails. Errors: VV_E_ARGUMENT. */
vv_status vvi_object_open(vvi_object *out, const vv_field *field, const vv_measure_options *options, int64_t step,
                          vv_job *job);
/** Keeps only the piece around a sample of the object, or around the nearest one within two samples. */
vv_status vvi_object_track(vvi_object *object, const int64_t seed[3]);
/** The same object where every second sample counts. Close it also when it fails. */
vv_status vvi_object_coarse(vvi_object *out, const vvi_object *fine, const vv_measure_options *options);
/** Whether values bound it from below and from above: two surfaces, which may pass between the same two samples. Not of
 * a piece around a seed, which samples alone decide. */
bool vvi_object_is_band(const vvi_object *object);
/** What VV_MEASURE_AUTO stands for. */
vv_measure_method vvi_object_method(vv_object_kind object, vv_measure_method method);
/** Of a band: what is in it or above it; above: what is above it. */
vvi_object vvi_object_upper(const vvi_object *band, bool above);
void vvi_object_close(vvi_object *object);

/** Bits of slice k, n[1] rows of `words`. */
vv_status vvi_object_slice(uint64_t *bits, const vvi_object *object, int64_t k);
/** Samples of slices [k, k + n) as an item reads them: (i, j, k') lies at strides from `data`. */
vv_status vvi_object_brick(vv_brick *out, const vvi_object *object, int64_t k, int64_t n);
/** How far a sample is inside: not negative where its bit is set; 0 is the surface. Of labels and masks 0.5 or -0.5. A
 * sample of another piece than the tracked one is outside all the same: ask the bits. */
double vvi_object_depth(const vvi_object *object, const vv_brick *brick, int64_t i, int64_t j, int64_t k);
#endif
