/** @file
 * Different labels, each with a number from 0 on.
 */
#ifndef VVI_GRID_LABEL_SET_H
#define VVI_GRID_LABEL_SET_H
#include "grid/label_id.h"

#define VVI_NO_LABEL UINT32_MAX

/** A hash table with open places, of `room`, a power of 2. Zeroed is empty. */
typedef struct vvi_label_set {
    vv_label_id *key;
    uint32_t *number; /**< 1 + that of the key; 0: the place is free */
    size_t n, room;
} vvi_label_set;

/** Its number: that which it has, or the next. number_out NULL: nobody asks. Errors: VV_E_MEMORY, VV_E_LIMIT (2^31). */
vv_status vvi_label_set_add(uint32_t *number_out, vvi_label_set *set, vv_label_id id, vv_job *job);
/** All of another one. */
vv_status vvi_label_set_join(vvi_label_set *set, const vvi_label_set *other, vv_job *job);
/** VVI_NO_LABEL: it is not there. */
uint32_t vvi_label_set_find(const vvi_label_set *set, vv_label_id id);
/** Numbers by ascending id. *ids_out has the ids in this order, n of them and room for one more: vvi_free(). */
vv_status vvi_label_set_sort(vv_label_id **ids_out, vvi_label_set *set, bool is_unsigned, vv_job *job);
void vvi_label_set_finish(vvi_label_set *set); /* zeroed is fine */
#endif
