/** @file
 * What other components may do with fields beyond the public interface.
 */
#ifndef VVI_GRID_FIELD_H
#define VVI_GRID_FIELD_H
#include "core/status.h"
#include <volvis/field.h>

/** Bytes after the last sample of every field that the library allocates: vector loads may touch them. */
#define VVI_FIELD_GUARD 64

/** A field whose health is asked from `damaged` (a mapped file's fault flag); otherwise as vv_field_new(). */
vv_status vvi_field_new_watched(vv_field **out, const vv_field_info *info, const void *data, size_t guard_bytes,
                                vv_free_fn *release, bool (*damaged)(const void *user), void *user, vv_job *job);
/** The same samples (shared, not copied) under another info of equal dims, type and components. */
vv_status vvi_field_relabel(vv_field **out, const vv_field *field, const vv_field_info *info);
/** Stored numbers from lo to hi are padding, as the file says; before others have the field. */
void vvi_field_set_padding(vv_field *field, double lo, double hi);
/** False: the file says nothing of it. */
bool vvi_field_padding(double out[2], const vv_field *field);
/** Slices [first, first + n) along z as a field of their own: the same samples, not copied. */
vv_status vvi_field_slices(vv_field **out, const vv_field *field, int64_t first, int64_t n, vv_job *job);
/** A part of a brick: nothing is read, nothing is to be released. The box lies inside the brick's. */
vv_brick vvi_brick_part(const vv_brick *brick, const vv_box *box);
/** Stored samples of n consecutive components as doubles, scale not applied. */
void vvi_samples_to_f64(double *out, const void *in, vv_type type, size_t n);
/** Rounded to nearest, clamped to the type's range; NaN becomes 0 in integers. */
void vvi_samples_from_f64(void *out, const double *in, vv_type type, size_t n);
/** In place. */
void vvi_swap_bytes(void *data, size_t element_bytes, size_t n);
/** Makes [lo, hi] hold the finite values of all components; INFINITY and -INFINITY where nothing is in it yet. */
vv_status vvi_field_widen_range(double *lo, double *hi, const vv_field *field, vv_job *job);
/** Ends of a type's range; of 64-bit integers the nearest doubles. */
double vvi_type_min(vv_type type);
double vvi_type_max(vv_type type);
/** World box of the index-space box [lo, hi] of a grid. */
/** Which world axis each index axis follows most, and whether forwards (1) or backwards (-1); no two the same one,
 * however oblique they are. */
void vvi_grid_main_axes(int world_axis[3], int sign[3], const vv_grid *grid);
vv_bounds vvi_grid_box_bounds(const vv_grid *grid, const double lo[3], const double hi[3]);
#endif
