/** @file
 * What operations that make labels have in common.
 */
#ifndef VVI_SEGMENT_LABEL_RESULT_H
#define VVI_SEGMENT_LABEL_RESULT_H
#include "core/status.h"
#include <volvis/field.h>

/** Labels of a type on the grid of `in`, whose values mean nothing for them. */
vv_field_info vvi_label_result(const vv_field_info *in, vv_type type);
/** VV_E_UNSUPPORTED, as `name`, where a sample has several components: they cannot be one label each. */
vv_status vvi_label_need_one_component(const vv_field_info *in, const char *name);
#endif
