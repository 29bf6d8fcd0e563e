#include "core/memory.h"
#include "grid/store.h"

typedef struct slices {
    vv_field *field;
    vv_brick brick;
} slices;

static void release(void *user)
{
    slices *s = user;
    vv_brick_release(&s->brick);
    vv_field_release(s->field);
    vvi_free(s);
}

static bool is_damaged(const void *user)
{
    return vvi_field_is_damaged(((const slices *)user)->field);
}

/* Bricks of whole slices are one run of samples, whatever the store: its rows follow one another. */
vv_status vvi_field_slices(vv_field **out, const vv_field *field, int64_t first, int64_t n, vv_job *job)
{
    vv_field_info info = *vv_field_get_info(field);
    const vv_box box = {{0, 0, first}, {info.grid.dims[0], info.grid.dims[1], n}};
    *out = NULL;
    slices *s = vvi_alloc_zeroed(job, sizeof *s, VVI_MEM_SCRATCH);
    if (!s)
        return vv_fail_memory(sizeof *s);
    s->field = vv_field_retain(field);
    const vv_status st = vv_field_brick(&s->brick, field, &box, job);
    if (st != VV_OK) {
        release(s);
        return st;
    }
    info.grid = vv_grid_crop(&info.grid, &box);
    return vvi_field_new_watched(out, &info, s->brick.data, s->brick.guard_bytes, release, is_damaged, s, job);
}
