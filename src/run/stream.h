/** @file
 * Samples that are larger than the memory limit: read, worked on and written slab by slab.
 */
#ifndef VVI_RUN_STREAM_H
#define VVI_RUN_STREAM_H
#include "grid/lazy.h"
#include "run/spool.h"
#include <volvis/run.h>

/** How what a step makes comes to those that take it: slab by slab as they ask for it, or by a temporary file. */
typedef struct vvi_stream_way {
    bool spooled;
    size_t file;    /**< number of it: those with the same take turns, each when the one before is needed no more */
    uint64_t bytes; /**< that it needs */
} vvi_stream_way;

/** Slabs of the files and of each step on the way. Zeroed is valid to free. */
typedef struct vvi_stream {
    vvi_lazy_pool **pools; /**< of each input, then of each step */
    vvi_spool **spools;    /**< of each step, counted; NULL: it is not spooled */
    size_t n_pools, n_inputs, n_steps;
    uint64_t bytes; /**< that its slabs may take together */
    bool rehearses; /**< nothing is read, and no passes over all samples run: slabs of zeros stand for these, and take
                         as much memory */
} vvi_stream;

/** Whether so much is too much to hold at once. */
bool vvi_stream_needed(uint64_t bytes, const vv_job *job);
/** ways: of each step, none of them spooled where NULL. */
vv_status vvi_stream_init(vvi_stream *out, size_t n_inputs, const vvi_stream_way *ways, size_t n_steps, vv_job *job);
void vvi_stream_free(vvi_stream *stream);
/** One time step of one input. */
vv_status vvi_stream_read(vv_field **out, const vvi_stream *stream, vv_file *file, size_t index, int64_t frame,
                          vv_job *job);
/** One step on fields that come so, of one time step. */
vv_status vvi_stream_step(vv_field **out, const vvi_stream *stream, vv_field *const *fields, size_t n,
                          const vv_step *step, size_t index, int64_t frame, vv_job *job);
/** Before any work: room for temporary files. */
vv_status vvi_stream_reserve(const vvi_stream *stream, const vvi_stream_way *ways, const char *name, vv_job *job);

/** The samples of a time step, for looks at all of them: in memory where they fit, else slab by slab, and as often as
 * it takes. Free the stream after the field. */
vv_status vvi_stream_samples(vv_field **out, vvi_stream *stream, vv_file *file, int64_t frame, vv_job *job);
#endif
