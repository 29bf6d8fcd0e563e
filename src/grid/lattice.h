/** @file
 * The samples of one volume as kernels see them: scalars in x-fastest order, of one of four types.
 */
#ifndef VVI_GRID_LATTICE_H
#define VVI_GRID_LATTICE_H
#include "core/status.h"
#include <volvis/field.h>

/** Types that kernels sample as they are; others are converted once (vvi_lattice_open). */
enum { VVI_SAMPLE_U8, VVI_SAMPLE_U16, VVI_SAMPLE_I16, VVI_SAMPLE_F32, VVI_SAMPLE_TYPES };
/** One more sort of kernel: of any of these types, in lattices whose element offsets do not fit 32 bits. */
enum { VVI_SAMPLE_WIDE = VVI_SAMPLE_TYPES, VVI_SAMPLE_KERNELS };

typedef struct vvi_lattice {
    const void *data;
    int sample_type; /**< VVI_SAMPLE_* */
    int32_t n[3];
    int32_t row;   /**< elements from y to y + 1 */
    int64_t slice; /**< elements from z to z + 1 */
    bool wide;     /**< element offsets do not fit 32 bits */
} vvi_lattice;

/** Which sort of kernel samples it. */
static inline int vvi_lattice_kernel(const vvi_lattice *g)
{
    return g->wide ? VVI_SAMPLE_WIDE : g->sample_type;
}

/** Owns what a lattice points into. */
typedef struct vvi_lattice_hold {
    vvi_lattice lattice;
    vv_brick brick; /**< what the lattice shows: one component, contiguous */
    vv_field *field;
    struct vvi_cached *cached;
    double value_scale, value_offset; /**< data value = lattice number * scale + offset */
} vvi_lattice_hold;

/** The value whose lattice number is 0: floats tell values beside it apart best. Of types wider than floats it is 0, or
 * the end of the data that is nearest to it. */
double vvi_lattice_zero(const vv_field_info *info, const vv_statistics *statistics);

/** Component `component` of a field, converted and kept in the cache where its type or layout needs it. Types wider
 * than floats become floats, shares of the whole range counted from vvi_lattice_zero(): none of the range is lost, and
 * one fill far outside takes nothing from values near 0. Floats that are huge, or differ by next to nothing, are copied
 * in another unit: what is counted and added up from them then is a float as well. */
vv_status vvi_lattice_open(vvi_lattice_hold *out, const vv_field *field, int component, vv_job *job);
void vvi_lattice_close(vvi_lattice_hold *hold); /* zeroed is fine */

#endif
