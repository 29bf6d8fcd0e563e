#include "grid/making.h"

vv_status vvi_making_run(vv_field **out, vvi_making *making, const vv_field_info *info, const vv_box *box,
                         const vv_box *needed, const vvi_work *work, void *user, vv_job *job)
{
    vv_field_info part = *info;
    vv_field *field;
    void *data;
    *out = NULL;
    part.grid = vv_grid_crop(&info->grid, box);
    vv_status st = vv_field_new_empty(&field, &data, &part, job);
    if (st != VV_OK)
        return st;
    making->out = data;
    if ((st = vv_field_brick(&making->brick, making->in, needed, job)) == VV_OK)
        st = vvi_parallel_for(job, work, user, making->slabs.n);
    vv_brick_release(&making->brick);
    if (st == VV_OK)
        st = vv_field_health(making->in);
    if (st == VV_OK)
        *out = field;
    else
        vv_field_release(field);
    return st;
}
