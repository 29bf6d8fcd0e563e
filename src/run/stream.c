#include "run/stream.h"
#include "core/memory.h"
#include "core/status.h"
#include "filter/stream.h"
#include "io/file_stream.h"
#include <stdlib.h>

bool vvi_stream_needed(uint64_t bytes, const vv_job *job)
{
    const vv_runtime *runtime = job ? vv_job_runtime(job) : NULL;
    return runtime && bytes > vv_runtime_memory_limit(runtime) / 2;
}

void vvi_stream_free(vvi_stream *stream)
{
    for (size_t i = 0; i < stream->n_pools; i++)
        vvi_lazy_pool_release(stream->pools[i]);
    free(stream->pools);
    *stream = (vvi_stream){0};
}

/* Each pool keeps two slabs, and making one may take a few more. Those of the result are as thick as can be, as what
 * steps look at around a slab is made and read over and over; where there is no room for them they get thinner, and
 * those on the way to them a little. */
static vv_status add_pool(vvi_stream *stream, uint64_t slab_bytes, bool is_result, vv_job *job)
{
    const uint64_t most = is_result ? vv_runtime_memory_limit(vv_job_runtime(job)) / 4 : slab_bytes;
    const vv_status st = vvi_lazy_pool_new(&stream->pools[stream->n_pools], most, is_result ? 0 : slab_bytes / 4, job);
    stream->n_pools += st == VV_OK;
    return st;
}

vv_status vvi_stream_init(vvi_stream *out, size_t n_inputs, size_t n_steps, vv_job *job)
{
    const size_t n = n_inputs + n_steps;
    const uint64_t slab_bytes = vv_runtime_memory_limit(vv_job_runtime(job)) / (8 * n);
    vv_status st = VV_OK;
    *out = (vvi_stream){.n_inputs = n_inputs, .bytes = 2 * n * slab_bytes};
    out->pools = vvi_calloc(n, sizeof(vvi_lazy_pool *));
    if (!out->pools)
        return vv_fail_memory(n * sizeof(vvi_lazy_pool *));
    while (out->n_pools < n && st == VV_OK)
        st = add_pool(out, slab_bytes, n_steps > 0 && out->n_pools + 1 == n, job);
    if (st != VV_OK)
        vvi_stream_free(out);
    return st;
}

vv_status vvi_stream_read(vv_field **out, const vvi_stream *stream, vv_file *file, size_t index, int64_t frame,
                          vv_job *job)
{
    return vvi_file_stream(out, file, frame, stream->pools[index], job);
}

vv_status vvi_stream_step(vv_field **out, const vvi_stream *stream, vv_field *const *fields, size_t n,
                          const vv_step *step, size_t index, vv_job *job)
{
    return vvi_operation_stream(out, step->operation, (const vv_field *const *)fields, n, step->params,
                                stream->pools[stream->n_inputs + index], job);
}

vv_status vvi_stream_samples(vv_field **out, vvi_stream *stream, vv_file *file, int64_t frame, vv_job *job)
{
    uint64_t bytes;
    *stream = (vvi_stream){0};
    vv_status st = vv_field_info_bytes(&bytes, vv_file_info(file));
    if (st != VV_OK)
        return st;
    if (vv_file_mappable(file) || !vvi_stream_needed(bytes, job))
        return vv_file_read(out, file, frame, NULL, job);
    if ((st = vvi_file_make_repeatable(file, job)) == VV_OK && (st = vvi_stream_init(stream, 1, 0, job)) == VV_OK)
        st = vvi_stream_read(out, stream, file, 0, frame, job);
    return st;
}
