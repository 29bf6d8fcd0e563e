#include "grid/making.h"

static vv_status ask(vvi_making *making, const vv_box *needed, vv_job *job)
{
    vv_status st = vv_field_brick(&making->brick, making->in, needed, job);
    for (size_t i = 0; i < VVI_MAKING_MORE && st == VV_OK; i++)
        if (making->more[i])
            st = vv_field_brick(&making->more_bricks[i], making->more[i], needed, job);
    return st;
}

static vv_status give_back(vvi_making *making, vv_status st)
{
    vv_brick_release(&making->brick);
    for (size_t i = 0; i < VVI_MAKING_MORE; i++)
        vv_brick_release(&making->more_bricks[i]);
    if (st == VV_OK)
        st = vv_field_health(making->in);
    for (size_t i = 0; i < VVI_MAKING_MORE && st == VV_OK; i++)
        if (making->more[i])
            st = vv_field_health(making->more[i]);
    return st;
}

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
    if ((st = ask(making, needed, job)) == VV_OK)
        st = vvi_parallel_for(job, work, user, making->slabs.n);
    if ((st = give_back(making, st)) == VV_OK)
        *out = field;
    else
        vv_field_release(field);
    return st;
}
