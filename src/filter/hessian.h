/** @file
 * Second derivatives of smoothed samples, in the world.
 */
#ifndef VVI_FILTER_HESSIAN_H
#define VVI_FILTER_HESSIAN_H
#include "core/job.h"
#include "core/symmetric.h"
#include "grid/field.h"

/** Some samples of a row of a box. */
typedef struct vvi_hessian_row {
    const double *entry[VVI_SYMMETRIC]; /**< of each sample's matrix; NaN where the sample is missing */
    int64_t at, n;                      /**< the first of them among those of the box, x fastest; how many */
    int component;
    size_t item;
} vvi_hessian_row;

/** Called on any thread, for each row once; rows of one item follow each other. */
typedef void vvi_hessian_take(void *user, const vvi_hessian_row *row);

/**
 * Matrices of second derivatives of a box of a field that is smoothed with `sigma`, a length, by differences of
 * neighbours, times sigma squared: in the field's unit of values, and alike at all scales for what is alike but larger.
 * Samples are repeated beyond the border; a sample beside one that is missing (not finite) goes on into it.
 */
vv_status vvi_hessian_each(const vv_field *in, const vv_box *box, double sigma, vvi_hessian_take *take, void *user,
                           vv_job *job);
size_t vvi_hessian_items(const vv_box *box);
/** Bytes that it takes. */
double vvi_hessian_bytes(const vv_field_info *info, const vv_box *box, double sigma);
#endif
