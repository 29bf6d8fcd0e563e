/** @file
 * Operations on fields that are larger than memory: their results as fields that are made when they are asked for.
 */
#ifndef VVI_FILTER_STREAM_H
#define VVI_FILTER_STREAM_H
#include "grid/lazy.h"
#include <volvis/sys/registry.h>

/** The result of an operation, made box by box through its run_box, or by its passes, which run at once; of an
 * operation that has neither, all of it when the first brick is asked for. The inputs are retained; params are, too.
 * `pool` is another than those of the inputs. */
vv_status vvi_operation_stream(vv_field **out, const vv_operation *operation, const vv_field *const *inputs,
                               size_t n_inputs, const vv_object *params, vvi_lazy_pool *pool, vv_job *job);
#endif
