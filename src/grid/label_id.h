/** @file
 * Numbers of labels, vv_label_id, from samples: never by way of a double, which takes neighbours beyond 2^53 for one.
 */
#ifndef VVI_GRID_LABEL_ID_H
#define VVI_GRID_LABEL_ID_H
#include "core/label_text.h"
#include <volvis/field.h>

/** Whether ids are the bits of uint64_t. Of all other integers their values are the same as int64_t. */
static inline bool vvi_label_is_unsigned(vv_type type)
{
    return type == VV_TYPE_U64;
}

/** The id that one sample is. Reals are rounded; those that are no number, or are too large, are 0. */
vv_label_id vvi_label_of(const void *sample, vv_type type);
/** Those of row (j, k) of a component, box.n[0] of them. info: with its scale and offset, where these are not 1 and 0;
 * NULL: as they are stored. */
void vvi_label_read(vv_label_id *out, const vv_brick *brick, int component, const vv_field_info *info, int64_t j,
                    int64_t k);
#endif
