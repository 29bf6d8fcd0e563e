/** @file
 * Fields of values: what a stored number times its scale means, as numbers without a scale. Files whose other readers
 * would ignore a scale are written of these.
 */
#ifndef VVI_GRID_TRUE_VALUES_H
#define VVI_GRID_TRUE_VALUES_H
#include "grid/field.h"

/** Whether values are not the stored numbers. */
bool vvi_has_scale(const vv_field_info *info);
/** The type of true values between lo and hi: the smallest one of integers that holds them where scale and offset are
 * whole; else f32, or f64 where f32 could not tell two stored steps apart. lo > hi: there are none. types: those of
 * integers that may be chosen, a bit each (1u << vv_type); 0: all. */
vv_type vvi_true_values_type(const vv_field_info *info, double lo, double hi, unsigned types);
/**
 * Fields of the same values, made slab by slab as they are asked for, all of one type. out has room for n; the time
 * steps share what vvi_has_scale() looks at.
 *
 * Errors  those of reading samples; VV_E_MEMORY. *out are NULL then.
 */
vv_status vvi_true_values(vv_field **out, const vv_field *const *fields, size_t n, unsigned types, vv_job *job);
#endif
