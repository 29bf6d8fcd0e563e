/** @file
 * Medians of windows of any size, by a histogram that goes along each row with the window.
 */
#ifndef VVI_FILTER_MEDIAN_RANK_H
#define VVI_FILTER_MEDIAN_RANK_H
#include "core/job.h"
#include <volvis/field.h>

/** Samples of a tile with its margin. */
#define VVI_MEDIAN_TILE_MOST 65535

/** What a worker keeps from tile to tile. */
typedef struct vvi_median_ranks vvi_median_ranks;

vv_status vvi_median_ranks_new(vvi_median_ranks **out, vv_type type, vv_job *job);
void vvi_median_ranks_free(vvi_median_ranks *ranks); /* NULL is fine */

/** Each sample of a tile replaced by its rank among them, in the least bits that its type needs: of types of at most
 * two bytes it is the key itself. NaN have none. */
void vvi_median_ranks_of(vvi_median_ranks *ranks, const void *keys, int64_t n);

/**
 * n medians of one row, as samples, `step` bytes from one to the next. What is NaN stays so; in other windows NaN do
 * not count, and of an even number the median is the mean of the middle two.
 *
 * at      index of the first sample of the first window in the tile
 * stride  samples between rows and slices of the tile
 * size    samples of the window along x, y, z
 */
void vvi_median_ranks_row(void *out, int64_t step, vvi_median_ranks *ranks, int64_t at, const int64_t stride[2],
                          const int64_t size[3], int64_t n);
#endif
