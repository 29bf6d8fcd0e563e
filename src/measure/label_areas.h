/** @file
 * The 2 x 2 x 2 patterns of all labels at once: what counted areas are made of.
 */
#ifndef VVI_MEASURE_LABEL_AREAS_H
#define VVI_MEASURE_LABEL_AREAS_H
#include "measure/sums.h"
#include <stdatomic.h>

/** Which labels there are: a number below n of each, or VVI_NO_LABEL. */
typedef struct vvi_label_numbers {
    uint32_t (*number_of)(const void *table, double label);
    const void *table;
    size_t n;
} vvi_label_numbers;
#define VVI_NO_LABEL UINT32_MAX

/** VVI_CONFIGURATIONS counts for each number, but of the cells that a label has all to itself or no part in; cells are
 * those of vvi_count_object() that is not closed. *out NULL: there is no memory, which is no error. Errors:
 * VV_E_MEMORY, VV_E_READ, VV_E_CANCELLED. Owns: vvi_free(). */
vv_status vvi_label_patterns(_Atomic uint64_t **out, const vv_field *labels, const vvi_region *region,
                             const vvi_label_numbers *numbers, vv_job *job);
#endif
