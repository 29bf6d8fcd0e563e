/** @file
 * Running integrals of a classification over the values, for pre-integrated ray casting (Roettger 2000, Engel 2001).
 */
#ifndef VVI_RENDER_TRANSFER_INTEGRAL_H
#define VVI_RENDER_TRANSFER_INTEGRAL_H
#include "scene/transfer.h"

/**
 * Extinction, and extinction times red, green and blue, integrated over the rows of a table: exact from the nodes, of
 * which those at one value make a jump inside a row. Row i holds for places (value * scale + offset of the table) from
 * i to i + 1. Integrals are whole numbers, so that the difference of two that are close is exact.
 */
typedef struct vvi_transfer_integral {
    float *mean;    /**< n rows of r, g, b, 1 times extinction per world length: the mean over the row */
    int32_t *sum;   /**< n + 1 rows: integral over places from 0, times `unit` the same */
    double unit[4]; /**< of sum; 0 where all of it is */
    size_t n;       /**< rows of the table - 1 */
} vvi_transfer_integral;

/** Not for labels and thresholds. The table's `running` becomes that of the rows here, a row to each side more: what
 * float places may touch. Errors: VV_E_MEMORY, VV_E_LIMIT. Finish it with vvi_transfer_integral_finish(). */
vv_status vvi_transfer_integral_init(vvi_transfer_integral *out, vvi_transfer_table *table,
                                     const vv_classification *classes, vv_job *job);
void vvi_transfer_integral_finish(vvi_transfer_integral *integral); /* zeroed is fine */

/** The mean of extinction times r, g, b, 1 over values from a to b, in any order: by the quadrature that the rows are
 * made with, straight from the nodes. a = b: at that value. */
void vvi_transfer_mean(double rgbk_out[4], const vv_classification *classes, double a, double b);

#endif
