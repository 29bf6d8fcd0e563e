/** @file
 * A linear map of samples, from one type to another.
 */
#ifndef VVI_GRID_SAMPLE_MAP_H
#define VVI_GRID_SAMPLE_MAP_H
#include "core/job.h"
#include "grid/field.h"
#include "grid/fill_value.h"

/** Stored of the result = stored of the source * gain + shift, no less than lo, no more than hi; rounded to nearest and
 * clamped to the type where that is one of integers. NaN stays, or becomes 0. In double precision. */
typedef struct vvi_sample_map {
    double gain, shift, lo, hi; /**< lo -INFINITY, hi INFINITY: no limits */
    const vvi_fills *skipped;   /**< stored samples of the source that are among these are as NaN; NULL: none */
    bool holds;                 /**< a finite number that the type cannot hold is VV_E_ARGUMENT, not the type's end */
} vvi_sample_map;

/** One box of the result, as a field of its own. `info` is that of the whole result: its type is the one mapped to, its
 * dims and components are those of `in`. stage: of the progress, NULL: none is told. Fails when `in` turns out damaged.
 */
vv_status vvi_sample_map_run(vv_field **out, const vv_field *in, const vv_field_info *info, const vv_box *box,
                             const vvi_sample_map *map, const char *stage, vv_job *job);
#endif
