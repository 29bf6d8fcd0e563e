/** @file
 * Dilation of blocks of keys (filter/sample_keys.h): the greatest key within an element around each.
 *
 * Boxes: runs of twice the length from two runs, axis by axis. Other elements: each of their chords is a run along x,
 * of which there is one table for each length (Urbach & Wilkinson 2008). Erosion is dilation of keys whose bits are
 * turned round.
 */
#ifndef VVI_FILTER_DILATION_H
#define VVI_FILTER_DILATION_H
#include "core/job.h"
#include "filter/dilate_kernel.h"
#include "filter/element.h"

typedef struct vvi_dilation {
    const vvi_element *element;
    const vvi_dilate_kernels *kernels;
    int bytes;  /**< of a key */
    char *room; /**< tables, and the result */
    int64_t table_bytes;
    vv_job *job;
} vvi_dilation;

/** What came out: the key of (i, j, k) is the i + j * stride[0] + k * stride[1]-th. */
typedef struct vvi_dilated {
    const char *keys;
    int64_t stride[2];
} vvi_dilated;

/** For blocks of at most n keys, which are 1, 2, 4 or 8 bytes large. The element outlives it. */
vv_status vvi_dilation_init(vvi_dilation *out, const vvi_element *element, const int64_t n[3], int bytes, vv_job *job);
void vvi_dilation_finish(vvi_dilation *dilation); /* zeroed is fine */
/** Keys of a block of n with the element's radius on each side of it. */
int64_t vvi_dilation_keys(const vvi_element *element, const int64_t n[3]);
/** `keys` are those of a block of n with its margin, packed, with VVI_DILATE_GUARD bytes behind them; they are
 * overwritten, and are the room that the result lies in, or that of `dilation` is. */
vv_status vvi_dilation_run(vvi_dilated *out, const vvi_dilation *dilation, void *keys, const int64_t n[3]);
#endif
