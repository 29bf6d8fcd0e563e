#include "run/stream.h"
#include "core/memory.h"
#include "core/status.h"
#include "filter/operation.h"
#include "filter/stream.h"
#include "io/file_stream.h"
#include <stdlib.h>
#include <string.h>

bool vvi_stream_needed(uint64_t bytes, const vv_job *job)
{
    const vv_runtime *runtime = job ? vv_job_runtime(job) : NULL;
    return runtime && bytes > vv_runtime_memory_limit(runtime) / 2;
}

void vvi_stream_free(vvi_stream *stream)
{
    for (size_t i = 0; i < stream->n_pools; i++)
        vvi_lazy_pool_release(stream->pools[i]);
    for (size_t i = 0; stream->spools && i < stream->n_steps; i++)
        vvi_spool_release(stream->spools[i]);
    free(stream->pools);
    free(stream->spools);
    *stream = (vvi_stream){0};
}

/* Each pool keeps two slabs, and making one may take a few more. Those of the result, and of what goes into a file, are
 * as thick as can be, as what steps look at around a slab is made and read over and over; where there is no room for
 * them they get thinner, and those on the way to them a little. */
static vv_status add_pool(vvi_stream *stream, uint64_t slab_bytes, bool is_result, vv_job *job)
{
    const uint64_t most = is_result ? vv_runtime_memory_limit(vv_job_runtime(job)) / 4 : slab_bytes;
    const vv_status st = vvi_lazy_pool_new(&stream->pools[stream->n_pools], most, is_result ? 0 : slab_bytes / 4, job);
    stream->n_pools += st == VV_OK;
    return st;
}

/* Of a step that is spooled: the file that one before it has, or its own. */
static vv_status add_spool(vvi_stream *stream, const vvi_stream_way *ways, size_t step, vv_job *job)
{
    for (size_t s = 0; s < step; s++)
        if (ways[s].spooled && ways[s].file == ways[step].file) {
            stream->spools[step] = vvi_spool_retain(stream->spools[s]);
            return VV_OK;
        }
    return vvi_spool_new(&stream->spools[step], job);
}

static vv_status add_steps(vvi_stream *stream, const vvi_stream_way *ways, uint64_t slab_bytes, vv_job *job)
{
    vv_status st = VV_OK;
    for (size_t s = 0; s < stream->n_steps && st == VV_OK; s++) {
        const bool spooled = ways && ways[s].spooled;
        st = add_pool(stream, slab_bytes, spooled || s + 1 == stream->n_steps, job);
        if (spooled && st == VV_OK)
            st = add_spool(stream, ways, s, job);
    }
    return st;
}

vv_status vvi_stream_init(vvi_stream *out, size_t n_inputs, const vvi_stream_way *ways, size_t n_steps, vv_job *job)
{
    size_t n = n_inputs + n_steps; /* that have slabs at once: those that are spooled have them one after the other */
    for (size_t s = 0; ways && s < n_steps; s++)
        n -= ways[s].spooled;
    const uint64_t slab_bytes = vv_runtime_memory_limit(vv_job_runtime(job)) / (8 * n);
    vv_status st = VV_OK;
    *out = (vvi_stream){.n_inputs = n_inputs, .n_steps = n_steps, .bytes = 2 * n * slab_bytes};
    out->pools = vvi_calloc(n_inputs + n_steps, sizeof(vvi_lazy_pool *));
    out->spools = vvi_calloc(n_steps + 1, sizeof(vvi_spool *));
    if (!out->pools || !out->spools)
        st = vv_fail_memory((n_inputs + n_steps) * sizeof(vvi_lazy_pool *));
    for (size_t i = 0; i < n_inputs && st == VV_OK; i++)
        st = add_pool(out, slab_bytes, false, job);
    if (st == VV_OK)
        st = add_steps(out, ways, slab_bytes, job);
    if (st != VV_OK)
        vvi_stream_free(out);
    return st;
}

vv_status vvi_stream_reserve(const vvi_stream *stream, const vvi_stream_way *ways, const char *name, vv_job *job)
{
    vv_status st = VV_OK;
    for (size_t s = 0; s < stream->n_steps && st == VV_OK && !stream->rehearses; s++) {
        uint64_t most = 0;
        for (size_t i = 0; i < stream->n_steps; i++)
            if (stream->spools[s] && stream->spools[i] == stream->spools[s] && ways[i].bytes > most)
                most = ways[i].bytes;
        if (stream->spools[s])
            st = vvi_spool_reserve(stream->spools[s], most, name, job);
    }
    return st;
}

/* Zeros, where samples would be read or made in passes. */
static vv_status make_blank(vv_field **out, void *user, const vv_box *box, vv_job *job)
{
    vv_field_info part = *(const vv_field_info *)user;
    void *data;
    part.grid = vv_grid_crop(&part.grid, box);
    return vv_field_new_empty(out, &data, &part, job);
}

static vv_status blank_field(vv_field **out, const vv_field_info *info, vvi_lazy_pool *pool, vv_job *job)
{
    const vvi_lazy_source blank = {make_blank, vvi_free, vvi_alloc(job, sizeof *info, VVI_MEM_MODEL)};
    *out = NULL;
    if (!blank.user)
        return vv_fail_memory(sizeof *info);
    memcpy(blank.user, info, sizeof *info);
    return vvi_field_lazy(out, info, &blank, pool, job);
}

/* A slice of what it works on: the memory that this takes is taken while passes run. */
static vv_status touch(const vv_field *field, vv_job *job)
{
    const int64_t *n = vv_field_get_info(field)->grid.dims;
    const vv_box slice = {{0, 0, 0}, {n[0], n[1], 1}};
    vv_brick brick;
    const vv_status st = vv_field_brick(&brick, field, &slice, job);
    if (st == VV_OK)
        vv_brick_release(&brick);
    return st;
}

static vv_status rehearse_passes(vv_field **out, vv_field *const *fields, size_t n, const vv_step *step,
                                 vvi_lazy_pool *pool, vv_job *job)
{
    vv_field_info info;
    vv_status st = vvi_operation_plan(&info, step->operation, (const vv_field *const *)fields, n, step->params);
    for (size_t i = 0; i < n && st == VV_OK; i++)
        if (fields[i] && !vv_operation_operand(step->operation, i)->grid_only)
            st = touch(fields[i], job);
    return st == VV_OK ? blank_field(out, &info, pool, job) : st;
}

vv_status vvi_stream_read(vv_field **out, const vvi_stream *stream, vv_file *file, size_t index, int64_t frame,
                          vv_job *job)
{
    if (stream->rehearses)
        return blank_field(out, vv_file_info(file), stream->pools[index], job);
    return vvi_file_stream(out, file, frame, stream->pools[index], job);
}

static vv_status make_step(vv_field **out, const vvi_stream *stream, vv_field *const *fields, size_t n,
                           const vv_step *step, vvi_lazy_pool *pool, vv_job *job)
{
    const vv_operation *o = step->operation;
    if (stream->rehearses && (o->passes || (o->looks && o->looks(step->params))))
        return rehearse_passes(out, fields, n, step, pool, job);
    return vvi_operation_stream(out, o, (const vv_field *const *)fields, n, step->params, pool, job);
}

vv_status vvi_stream_step(vv_field **out, const vvi_stream *stream, vv_field *const *fields, size_t n,
                          const vv_step *step, size_t index, int64_t frame, vv_job *job)
{
    vvi_lazy_pool *pool = stream->pools[stream->n_inputs + index];
    vvi_spool *spool = stream->spools[index];
    vv_field *made = NULL;
    vv_status st = make_step(&made, stream, fields, n, step, pool, job);
    *out = made;
    if (st != VV_OK || !spool)
        return st;
    const vvi_spool_of of = {made, pool, step->operation->name, (uint64_t)frame * stream->n_steps + index,
                             stream->rehearses};
    st = vvi_spool_field(out, spool, &of, job);
    vv_field_release(made);
    return st;
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
    if ((st = vvi_file_make_repeatable(file, job)) == VV_OK && (st = vvi_stream_init(stream, 1, NULL, 0, job)) == VV_OK)
        st = vvi_stream_read(out, stream, file, 0, frame, job);
    return st;
}
