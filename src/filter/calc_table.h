/** @file
 * Formulas of one volume whose samples have so few values that each is worked out once.
 */
#ifndef VVI_FILTER_CALC_TABLE_H
#define VVI_FILTER_CALC_TABLE_H
#include "core/expression.h"
#include <volvis/field.h>

typedef struct vvi_calc_table vvi_calc_table;

/** What the expression's name 0 comes to, for all samples of up to 16 bits, as samples of another type: the same bytes
 * as one by one. *out NULL: where there are not many more samples than values, other names are used, or some value is
 * beyond the type. */
vv_status vvi_calc_table_new(vvi_calc_table **out, const vvi_expression *expression, const vv_field_info *info,
                             vv_type type, int64_t n_samples, vv_job *job);
void vvi_calc_table_free(vvi_calc_table *table); /* NULL is fine */
/** n samples that lie behind each other. */
void vvi_calc_table_row(void *out, const vvi_calc_table *table, const void *in, size_t n);
#endif
