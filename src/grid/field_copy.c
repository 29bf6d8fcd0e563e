#include "grid/field_copy.h"
#include "core/job.h"
#include <string.h>

/* Rows of one slice of a brick to where samples lie one after the other. */
static void copy_rows(char *out, const vv_brick *brick, size_t sample)
{
    const size_t row = sample * (size_t)brick->box.n[0];
    for (int64_t j = 0; j < brick->box.n[1]; j++) {
        const char *from = (const char *)brick->data + j * brick->stride[1];
        char *to = out + (size_t)j * row;
        if (brick->stride[0] == (int64_t)sample) {
            memcpy(to, from, row);
            continue;
        }
        for (int64_t i = 0; i < brick->box.n[0]; i++)
            memcpy(to + (size_t)i * sample, from + i * brick->stride[0], sample);
    }
}

vv_status vvi_field_copy_box(vv_field **out, const vv_field *field, const vv_box *box, vv_job *job)
{
    vv_field_info info = *vv_field_get_info(field);
    const size_t sample = vv_type_bytes(info.type) * (size_t)info.components;
    vv_box slice = *box;
    vv_field *copy = NULL;
    void *data = NULL;
    *out = NULL;
    info.grid = vv_grid_crop(&info.grid, box);
    vv_status st = vv_field_new_empty(&copy, &data, &info, job);
    slice.n[2] = 1;
    for (int64_t k = 0; k < box->n[2] && st == VV_OK; k++) {
        vv_brick brick;
        slice.lo[2] = box->lo[2] + k;
        if ((st = vvi_job_poll(job)) != VV_OK || (st = vv_field_brick(&brick, field, &slice, job)) != VV_OK)
            break;
        copy_rows((char *)data + (size_t)k * sample * (size_t)(box->n[0] * box->n[1]), &brick, sample);
        vv_brick_release(&brick);
    }
    if (st == VV_OK)
        *out = copy;
    else
        vv_field_release(copy);
    return st;
}
