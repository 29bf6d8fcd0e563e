/** @file
 * A box of samples cut into items for parallel loops, in x-fastest order: whole slices, else whole rows of one slice,
 * else pieces of one row, each about as large as asked for.
 */
#ifndef VVI_GRID_SLABS_H
#define VVI_GRID_SLABS_H
#include <volvis/sys/making.h>

typedef vv_slabs vvi_slabs;

/** `most` is how many samples an item should hold at most. Does not depend on the number of threads. */
vvi_slabs vvi_slabs_of(const vv_box *box, int64_t most);
vv_box vvi_slabs_item(const vvi_slabs *slabs, size_t index);
/** Where row (j, k) of an item begins among the samples of the whole box, packed. */
int64_t vvi_slabs_row(const vvi_slabs *slabs, const vv_box *item, int64_t j, int64_t k);
#endif
