/** @file
 * Samples that are larger than the memory limit: read, worked on and written slab by slab.
 */
#ifndef CLI_STREAM_H
#define CLI_STREAM_H
#include "grid/lazy.h"
#include "pipeline.h"

/** Slabs of the files and of each step on the way. Zeroed is valid to free. */
typedef struct cli_stream {
    vvi_lazy_pool **pools; /**< of each input, then of each step */
    size_t n_pools, n_inputs;
    uint64_t bytes; /**< that its slabs may take together */
} cli_stream;

/** Whether so much is too much to hold at once. */
bool cli_stream_needed(const cli_command *command, uint64_t bytes);
vv_status cli_stream_init(cli_stream *out, const cli_command *command, size_t n_inputs, size_t n_steps);
void cli_stream_free(cli_stream *stream);
/** One time step of one input. */
vv_status cli_stream_read(vv_field **out, const cli_stream *stream, const cli_input *input, size_t index, int64_t frame,
                          vv_job *job);
/** One step on fields that come so. */
vv_status cli_stream_step(vv_field **out, const cli_stream *stream, vv_field *const *fields, size_t n,
                          const cli_step *step, size_t index, vv_job *job);

/** The samples of a time step, for looks at all of them: in memory where they fit, else slab by slab, and as often as
 * it takes. Free the stream after the field. */
vv_status cli_stream_samples(vv_field **out, cli_stream *stream, cli_command *command, const cli_input *input,
                             int64_t frame);
#endif
