/* The public names of what operations of other programs need: volvis/sys/making.h. */
#include "grid/field.h"
#include "grid/making.h"

vv_brick vv_brick_part(const vv_brick *brick, const vv_box *box)
{
    return vvi_brick_part(brick, box);
}

void vv_samples_to_f64(double *out, const void *in, vv_type type, size_t n)
{
    vvi_samples_to_f64(out, in, type, n);
}

void vv_samples_from_f64(void *out, const double *in, vv_type type, size_t n)
{
    vvi_samples_from_f64(out, in, type, n);
}

vv_slabs vv_slabs_of(const vv_box *box, int64_t most)
{
    return vvi_slabs_of(box, most);
}

vv_box vv_slabs_item(const vv_slabs *slabs, size_t index)
{
    return vvi_slabs_item(slabs, index);
}

int64_t vv_slabs_row(const vv_slabs *slabs, const vv_box *item, int64_t j, int64_t k)
{
    return vvi_slabs_row(slabs, item, j, k);
}

vv_status vv_making_run(vv_field **out, vv_making *making, const vv_field_info *info, const vv_box *box,
                        const vv_box *needed, const vv_work *work, void *user, vv_job *job)
{
    return vvi_making_run(out, making, info, box, needed, work, user, job);
}
