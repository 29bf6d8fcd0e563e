#include "io/file_stream.h"
#include "core/memory.h"

typedef struct frame_of_file {
    vv_file *file;
    int64_t frame;
} frame_of_file;

static vv_status make(vv_field **out, void *user, const vv_box *box, vv_job *job)
{
    const frame_of_file *f = user;
    return vv_file_read(out, f->file, f->frame, box, job);
}

vv_status vvi_file_stream(vv_field **out, vv_file *file, int64_t frame, vvi_lazy_pool *pool, vv_job *job)
{
    vv_field_info info = *vv_file_info(file);
    *out = NULL;
    if (frame < 0 || frame >= info.n_frames)
        return vv_fail(VV_E_ARGUMENT, "the file has no time step %lld; time steps are 0 to %lld", (long long)frame,
                       (long long)(info.n_frames - 1));
    frame_of_file *f = vvi_alloc(job, sizeof *f, VVI_MEM_MODEL);
    if (!f)
        return vv_fail_memory(sizeof *f);
    *f = (frame_of_file){file, frame};
    vvi_file_follow(file, VVI_FOLLOW_SLABS);
    info.frame = frame;
    const vvi_lazy_source source = {make, vvi_free, f};
    const vv_status st = vvi_field_lazy(out, &info, &source, pool, job);
    if (st == VV_OK)
        vvi_file_tell_padding(file, *out);
    return st;
}
