/** @file
 * Running a row of the operation table.
 */
#ifndef VVI_FILTER_OPERATION_H
#define VVI_FILTER_OPERATION_H
#include <volvis/sys/registry.h>

/** What an operation that gives fields will make of these. */
vv_status vvi_operation_plan(vv_field_info *out, const vv_operation *operation, const vv_field *const *inputs,
                             size_t n_inputs, const vv_object *params);
/** What has run with `st`, unless the file behind an input shrank meanwhile: what was made of zeros is nobody's result,
 * so *out is released then. */
vv_status vvi_operation_check(vv_field **out, const vv_field *const *inputs, size_t n_inputs, vv_status st);
#endif
