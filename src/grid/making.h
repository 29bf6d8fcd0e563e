/** @file
 * What makers of fields from others have around their own loops: room for the result, the samples of the input that
 * are needed, the items that are shared out among threads, and what happens when something goes wrong.
 */
#ifndef VVI_GRID_MAKING_H
#define VVI_GRID_MAKING_H
#include "core/job.h"
#include "grid/field.h"
#include "grid/slabs.h"

enum { VVI_MAKING_MORE = VV_MAKING_MORE };
typedef vv_making vvi_making;

/** Set bricks and out, run work's items 0 to slabs.n - 1 with `user`, and make a field of what they wrote. `info` is
 * that of the whole result, of which `box` is made; `needed` is a box of the inputs. Fails when one turns out
 * damaged. */
vv_status vvi_making_run(vv_field **out, vvi_making *making, const vv_field_info *info, const vv_box *box,
                         const vv_box *needed, const vvi_work *work, void *user, vv_job *job);
#endif
