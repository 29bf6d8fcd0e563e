/** @file
 * The samples of one volume as kernels see them: scalars in x-fastest order, of one of four types.
 */
#ifndef VVI_GRID_LATTICE_H
#define VVI_GRID_LATTICE_H
#include "core/status.h"
#include <volvis/field.h>

/** Types that kernels sample as they are; others are converted once (vvi_lattice_open). */
enum { VVI_SAMPLE_U8, VVI_SAMPLE_U16, VVI_SAMPLE_I16, VVI_SAMPLE_F32, VVI_SAMPLE_TYPES };
/** One more sort of kernel: of any of these types, however they are fetched. */
enum { VVI_SAMPLE_ANY = VVI_SAMPLE_TYPES, VVI_SAMPLE_KERNELS };

/** How samples are fetched, by where they are; kernels know each by a row of render/march/fetch.h. */
enum {
    VVI_FETCH_LINEAR, /**< one array */
    VVI_FETCH_WIDE,   /**< one whose element offsets do not fit 32 bits */
    VVI_FETCH_BRICKS, /**< bricks.h */
    VVI_FETCHES
};

typedef struct vvi_lattice {
    const void *data;
    int sample_type; /**< VVI_SAMPLE_* */
    int fetch;       /**< VVI_FETCH_* */
    int32_t n[3];
    int32_t row;   /**< elements from y to y + 1, within a brick where there are bricks */
    int64_t slice; /**< elements from z to z + 1, the same */
    const struct vvi_bricks *bricks;
} vvi_lattice;

/** Which sort of kernel samples it: its type is known to the program where that is what is met every day. */
static inline int vvi_lattice_kernel(const vvi_lattice *g)
{
    return g->fetch == VVI_FETCH_LINEAR ? g->sample_type : VVI_SAMPLE_ANY;
}

/** How the stored numbers of one component become a lattice's. */
typedef struct vvi_lattice_numbers {
    vv_type from, to;
    int component;
    double factor, shift; /**< lattice number = stored * factor + shift */
} vvi_lattice_numbers;

/** Owns what a lattice points into. */
typedef struct vvi_lattice_hold {
    vvi_lattice lattice;
    vv_brick brick; /**< what the lattice shows: one component, contiguous; none of a lattice in bricks */
    vv_field *field;
    struct vvi_cached *cached;
    vvi_lattice_numbers numbers;
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

/** The same numbers in bricks, which are brought when kernels ask for them (bricks.h): what is never seen is never
 * read. The hold's brick is empty; the bricks stay in the cache. */
vv_status vvi_lattice_open_bricks(vvi_lattice_hold *out, const vv_field *field, int component, vv_job *job);

/** The one or the other: in bricks where samples are made when they are asked for (lazy.h). */
vv_status vvi_lattice_open_somehow(vvi_lattice_hold *out, const vv_field *field, int component, vv_job *job);

/** The part of opening that both share: field, numbers, scale and offset. Errors: those of vv_field_statistics();
 * VV_E_UNSUPPORTED (an axis that is too long). Then close it too. */
vv_status vvi_lattice_hold_begin(vvi_lattice_hold *out, const vv_field *field, int component, vv_job *job);
/** n samples, `stride` bytes apart, of which `in` is the first one's first component. */
void vvi_lattice_convert_row(void *out, const vvi_lattice_numbers *numbers, const void *in, int64_t stride, size_t n);
/** VVI_SAMPLE_*; -1: kernels do not sample it. */
int vvi_lattice_type(vv_type type);
/** One sample, wherever it lies: for references and tests. */
double vvi_lattice_number(const vvi_lattice *g, int64_t i, int64_t j, int64_t k);

#endif
