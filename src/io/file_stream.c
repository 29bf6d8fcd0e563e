#include "io/file_stream.h"
#include "core/job.h"
#include "core/memory.h"

enum { SLAB_SHARE = 8 }; /* of the memory limit: two of them are kept */

typedef struct frame_of_file {
    vv_file *file;
    int64_t frame;
    bool own; /* the file goes with it */
} frame_of_file;

static vv_status make(vv_field **out, void *user, const vv_box *box, vv_job *job)
{
    const frame_of_file *f = user;
    return vv_file_read(out, f->file, f->frame, box, job);
}

static void drop(void *user)
{
    frame_of_file *f = user;
    if (f->own)
        vv_file_close(f->file);
    vvi_free(f);
}

/* Takes the file over where it is the field's own, also when it fails. */
static vv_status stream(vv_field **out, const frame_of_file *of, bool boxes, vvi_lazy_pool *pool, vv_job *job)
{
    vv_field_info info = *vv_file_info(of->file);
    vv_status st = VV_OK;
    *out = NULL;
    if (of->frame < 0 || of->frame >= info.n_frames)
        st = vv_fail(VV_E_ARGUMENT, "the file has no time step %lld; time steps are 0 to %lld", (long long)of->frame,
                     (long long)(info.n_frames - 1));
    frame_of_file *f = st == VV_OK ? vvi_alloc(job, sizeof *f, VVI_MEM_MODEL) : NULL;
    if (!f) {
        if (of->own)
            vv_file_close(of->file);
        return st == VV_OK ? vv_fail_memory(sizeof *f) : st;
    }
    *f = *of;
    vvi_file_follow(f->file, VVI_FOLLOW_SLABS);
    info.frame = f->frame;
    const vvi_lazy_source source = {make, drop, f, .boxes = boxes};
    st = vvi_field_lazy(out, &info, &source, pool, job);
    if (st == VV_OK)
        vvi_file_tell_padding(f->file, *out);
    return st;
}

vv_status vvi_file_stream(vv_field **out, vv_file *file, int64_t frame, vvi_lazy_pool *pool, vv_job *job)
{
    return stream(out, &(frame_of_file){file, frame, false}, false, pool, job);
}

vv_status vvi_file_stream_boxes(vv_field **out, vv_file *file, int64_t frame, vv_job *job)
{
    const vv_runtime *runtime = vv_job_runtime(job);
    const uint64_t slab = runtime ? vv_runtime_memory_limit(runtime) / SLAB_SHARE : (uint64_t)64 << 20;
    vvi_lazy_pool *pool;
    vv_status st = vvi_lazy_pool_new(&pool, slab, 0, job);
    if (st != VV_OK) {
        vv_file_close(file);
        return st;
    }
    st = stream(out, &(frame_of_file){file, frame, true}, true, pool, job);
    vvi_lazy_pool_release(pool);
    return st;
}
