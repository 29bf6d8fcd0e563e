/** @file
 * Min-max cells: the smallest and largest stored value in each block of 2^shift cubed voxel cells. Derived data that
 * the ray caster skips space with, and later Marching Cubes and measurement.
 *
 * A voxel cell is the cube between eight samples; neighbouring blocks share the samples between them, so a block's
 * range bounds every trilinear value inside it, its faces included. NaN samples are left out; a block of nothing else
 * has lo = +inf > hi = -inf.
 */
#ifndef VVI_GRID_MINMAX_H
#define VVI_GRID_MINMAX_H
#include "core/cache.h"
#include "core/status.h"
#include "grid/lattice.h"
#include <volvis/field.h>

typedef struct vvi_minmax {
    int32_t n[3]; /**< blocks */
    int shift;
    float *lo, *hi; /**< stored values, x fastest */
} vvi_minmax;

/** Whether any stored value in [lo, hi] is visible. */
typedef bool vvi_visible_fn(const void *user, float lo, float hi);

/** Room for the blocks of a grid of that many samples. Free with vvi_minmax_free(). */
vv_status vvi_minmax_new(vvi_minmax **out, const int64_t dims[3], int shift, vv_job *job);
/** Samples of one component in one brick, all axes of the grid; type as in the brick. Free with vvi_minmax_free(). */
vv_status vvi_minmax_build(vvi_minmax **out, const vv_brick *brick, int component, int shift, vv_job *job);
void vvi_minmax_free(void *minmax); /* NULL is fine */
/** The same from the job's cache under a key; vvi_cached_value() is a vvi_minmax. */
vv_status vvi_minmax_get(vvi_cached **out, const vvi_cache_key *key, const vv_brick *brick, int component, int shift,
                         vv_job *job);
/** The same of a lattice's numbers, however it is fetched: of bricks, layer by layer from the field. */
vv_status vvi_minmax_get_lattice(vvi_cached **out, const vvi_cache_key *key, const vvi_lattice_hold *hold, int shift,
                                 vv_job *job);
/** A key for a component of a field. `what`: "minmax" for samples of 8 or 16 bits and floats as they are stored, else
 * a name for what is made of them. */
vvi_cache_key vvi_minmax_key(const char *what, const vv_field *field, int component, int shift);

#endif
