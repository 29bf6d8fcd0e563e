/** @file
 * Whether there is one label alone.
 */
#ifndef VVI_FILTER_ONE_LABEL_H
#define VVI_FILTER_ONE_LABEL_H
#include "core/job.h"
#include "grid/field.h"

/** Whether all samples of a box, whole numbers of one component, are 0 or one other number: *id_out, 0 if there is
 * none. u64: that as bits. */
vv_status vvi_one_label(bool *out, vv_label_id *id_out, const vv_field *field, const vv_box *box, vv_job *job);
#endif
