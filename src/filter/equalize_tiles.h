/** @file
 * Contrast-limited adaptive equalisation (Zuiderveld 1994), in three dimensions: each tile of a grid of tiles has a map
 * of its own, and between the middles of tiles their maps are mixed linearly.
 */
#ifndef VVI_FILTER_EQUALIZE_TILES_H
#define VVI_FILTER_EQUALIZE_TILES_H
#include "core/status.h"
#include <volvis/field.h>

/** Bins of a tile's histogram, over the range of all samples. */
#define VVI_TILE_BINS 256

/** `n`: tiles along each axis, as equal as whole samples are. clip: how many times the mean a bin may hold; what is
 * above is spread over all of them. One box of the result. */
vv_status vvi_equalize_tiles(vv_field **out, const vv_field *in, const int64_t n[3], double clip, const vv_box *box,
                             vv_job *job);
#endif
