/** @file
 * The 2 x 2 x 2 patterns of all labels at once: what counted areas are made of.
 */
#ifndef VVI_MEASURE_LABEL_AREAS_H
#define VVI_MEASURE_LABEL_AREAS_H
#include "grid/label_set.h"
#include "measure/sums.h"
#include <stdatomic.h>

/** VVI_CONFIGURATIONS counts for each label of the set, by its number, but of the cells that a label has all to itself
 * or no part in; cells are those of vvi_count_object() that is not closed. *out NULL: there is no memory, which is no
 * error. Errors: VV_E_MEMORY, VV_E_READ, VV_E_CANCELLED. Owns: vvi_free(). */
vv_status vvi_label_patterns(_Atomic uint64_t **out, const vv_field *labels, const vvi_region *region,
                             const vvi_label_set *set, vv_job *job);
#endif
