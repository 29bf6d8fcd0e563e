#include "stream.h"
#include "filter/stream.h"
#include "io/file_stream.h"
#include <stdlib.h>

bool cli_stream_needed(const cli_command *command, uint64_t bytes)
{
    return bytes > vv_runtime_memory_limit(command->runtime) / 2;
}

void cli_stream_free(cli_stream *stream)
{
    for (size_t i = 0; i < stream->n_pools; i++)
        vvi_lazy_pool_release(stream->pools[i]);
    free(stream->pools);
    *stream = (cli_stream){0};
}

/* Each pool keeps two slabs, and making one may take a few more. */
vv_status cli_stream_init(cli_stream *out, const cli_command *command, size_t n_inputs, size_t n_steps)
{
    const size_t n = n_inputs + n_steps;
    const uint64_t slab_bytes = vv_runtime_memory_limit(command->runtime) / (8 * n);
    vv_status st = VV_OK;
    *out = (cli_stream){.n_inputs = n_inputs, .bytes = 2 * n * slab_bytes};
    out->pools = calloc(n, sizeof(vvi_lazy_pool *));
    if (!out->pools)
        return vv_fail_memory(n * sizeof(vvi_lazy_pool *));
    for (; out->n_pools < n && st == VV_OK; out->n_pools += st == VV_OK)
        st = vvi_lazy_pool_new(&out->pools[out->n_pools], slab_bytes, command->job);
    if (st != VV_OK)
        cli_stream_free(out);
    return st;
}

vv_status cli_stream_read(vv_field **out, const cli_stream *stream, const cli_input *input, size_t index, int64_t frame,
                          vv_job *job)
{
    return vvi_file_stream(out, input->file, frame, stream->pools[index], job);
}

vv_status cli_stream_step(vv_field **out, const cli_stream *stream, vv_field *const *fields, size_t n,
                          const cli_step *step, size_t index, vv_job *job)
{
    return vvi_operation_stream(out, step->operation, (const vv_field *const *)fields, n, step->params,
                                stream->pools[stream->n_inputs + index], job);
}

vv_status cli_stream_samples(vv_field **out, cli_stream *stream, cli_command *command, const cli_input *input,
                             int64_t frame)
{
    uint64_t bytes;
    *stream = (cli_stream){0};
    vv_status st = vv_field_info_bytes(&bytes, vv_file_info(input->file));
    if (st != VV_OK)
        return st;
    if (vv_file_mappable(input->file) || !cli_stream_needed(command, bytes))
        return vv_file_read(out, input->file, frame, NULL, command->job);
    if ((st = vvi_file_make_repeatable(input->file, command->job)) == VV_OK &&
        (st = cli_stream_init(stream, command, 1, 0)) == VV_OK)
        st = cli_stream_read(out, stream, input, 0, frame, command->job);
    return st;
}
