/** @file
 * Which words of a row of samples a surface can pass, by the field's min-max blocks.
 */
#ifndef VVI_SURFACE_MARCHING_BLOCKS_H
#define VVI_SURFACE_MARCHING_BLOCKS_H
#include "grid/minmax.h"
#include "surface/marching_plan.h"

/** What a word of bits is before its samples are read. */
enum { VVI_MARCH_OUTSIDE, VVI_MARCH_INSIDE, VVI_MARCH_MIXED };

/** The words of rows of samples, for each row of blocks of `minmax`, whose grid is that of m->brick: m->blocks, which
 * vvi_free() frees. Samples that are no numbers count as their block does: no cell around them is crossed. */
vv_status vvi_march_blocks(vvi_march *m, const vvi_minmax *minmax);
/** Whether row j of a slice touches other rows of blocks than the one before. */
static inline bool vvi_march_touches_others(const vvi_march *m, int64_t j)
{
    return (j & (((int64_t)1 << m->block_shift) - 1)) <= 1;
}
/** Of the words of row j of slice k, which at most four rows of blocks touch. False: all are one way. */
bool vvi_march_words(uint8_t *out, const vvi_march *m, int64_t j, int64_t k);
#endif
