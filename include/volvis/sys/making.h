/** @file
 * Making fields from others: samples as doubles, boxes cut into items for parallel loops, and what stands around such
 * a loop: room for the result, the samples of the input that are needed, and what happens when something goes wrong.
 */
#ifndef VOLVIS_SYS_MAKING_H
#define VOLVIS_SYS_MAKING_H
#include <volvis/field.h>
#include <volvis/sys/work.h>
VV_BEGIN_DECLS

/** A part of a brick: nothing is read, nothing is to be released. The box lies inside the brick's. */
VV_API vv_brick vv_brick_part(const vv_brick *brick, const vv_box *box);
/** Stored samples of n consecutive components as doubles, scale not applied. */
VV_API void vv_samples_to_f64(double *out, const void *in, vv_type type, size_t n);
/** Rounded to nearest, clamped to the type's range; NaN becomes 0 in integers. */
VV_API void vv_samples_from_f64(void *out, const double *in, vv_type type, size_t n);

/** A box of samples cut into items in x-fastest order: whole slices, else whole rows of one slice, else pieces of one
 * row, each about as large as asked for. */
typedef struct vv_slabs {
    vv_box box;
    int64_t step[3];  /**< samples of an item along x, y, z (fewer in the last of a row of items) */
    int64_t items[3]; /**< how many items along x, y, z */
    size_t n;         /**< how many in all; 0 for an empty box */
} vv_slabs;

/** `most` is how many samples an item should hold at most. Does not depend on the number of threads. */
VV_API vv_slabs vv_slabs_of(const vv_box *box, int64_t most);
VV_API vv_box vv_slabs_item(const vv_slabs *slabs, size_t index);
/** Where row (j, k) of an item begins among the samples of the whole box, packed. */
VV_API int64_t vv_slabs_row(const vv_slabs *slabs, const vv_box *item, int64_t j, int64_t k);

enum { VV_MAKING_MORE = 7 };

/** One box of a field that is made of another one, or of several. The loop's own data begin with it or hold it. */
typedef struct vv_making {
    const vv_field *in;
    const vv_field *more[VV_MAKING_MORE]; /**< the same box is needed of these; NULL: none */
    vv_slabs slabs;                       /**< the items of the loop */
    vv_brick brick; /**< all that is needed of `in`, asked for once: what is streamed is then read in order */
    vv_brick more_bricks[VV_MAKING_MORE];
    char *out; /**< the samples of the box, packed, x fastest */
} vv_making;

/** Set bricks and out, run work's items 0 to slabs.n - 1 with `user`, and make a field of what they wrote. `info` is
 * that of the whole result, of which `box` is made; `needed` is a box of the inputs. Fails when one turns out
 * damaged. */
VV_API vv_status vv_making_run(vv_field **out, vv_making *making, const vv_field_info *info, const vv_box *box,
                               const vv_box *needed, const vv_work *work, void *user, vv_job *job);

VV_END_DECLS
#endif
