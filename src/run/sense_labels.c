#include "run/sense_labels.h"
#include "grid/field.h"
#include "grid/label_sense.h"
#include <string.h>

/* Whether the samples decide: nothing is said of them, nor of what is wanted of them. */
static bool is_open(const vv_object *params, const vv_field_info *info)
{
    static const char *const said[] = {"iso", "label", "seed", "component"};
    if (info->meaning != VV_MEANING_SCALAR || info->components > 1 || !vv_class_find(params->cls, "label"))
        return false;
    for (size_t i = 0; i < sizeof said / sizeof said[0]; i++)
        if (vv_class_find(params->cls, said[i]) && vv_object_is_set(params, said[i]))
            return false;
    return true;
}

static vv_status sense(bool *sensed_out, vv_object **params, const vv_field *field, vv_job *job)
{
    size_t n = 0;
    *sensed_out = false;
    if (!is_open(*params, vv_field_get_info(field)))
        return VV_OK;
    const vv_status st = vvi_label_sense(&n, field, 0, job);
    if (st == VV_E_LIMIT || st == VV_E_MEMORY) /* what goes through in parts is not looked at whole */
        return VV_OK;
    if (st != VV_OK || n == 0)
        return st;
    *sensed_out = true;
    return vv_path_set(params, "label", "[]", NULL);
}

static vv_status add_slice(char *to, const vv_field *slice, vv_job *job)
{
    const vv_box box = vv_field_box(slice);
    vv_brick brick;
    const vv_status st = vv_field_brick(&brick, slice, &box, job);
    if (st != VV_OK)
        return st;
    const size_t bytes = vv_type_bytes(brick.type);
    for (int64_t j = 0; j < box.n[1]; j++)
        for (int64_t i = 0; i < box.n[0]; i++, to += bytes)
            memcpy(to, (const char *)brick.data + j * brick.stride[1] + i * brick.stride[0], bytes);
    vv_brick_release(&brick);
    return VV_OK;
}

/* The slices that are looked at of a whole field, as one of their own. */
static vv_status read_slices(vv_field **out, vv_file *file, int64_t frame, vv_job *job)
{
    vv_field_info info = *vv_file_info(file);
    const int64_t *dims = vv_file_info(file)->grid.dims, step = vvi_label_sense_step(dims[2]);
    const size_t bytes = vv_type_bytes(info.type) * (size_t)(dims[0] * dims[1]);
    void *samples;
    info.grid.dims[2] = (dims[2] + step - 1) / step;
    vv_status st = vv_field_new_empty(out, &samples, &info, job);
    for (int64_t k = 0; k < info.grid.dims[2] && st == VV_OK; k++) {
        const vv_box box = {{0, 0, k * step}, {dims[0], dims[1], 1}};
        vv_field *slice = NULL;
        if ((st = vv_file_read(&slice, file, frame, &box, job)) == VV_OK)
            st = add_slice((char *)samples + (size_t)k * bytes, slice, job);
        vv_field_release(slice);
    }
    return st;
}

vv_status vvi_sense_labels_of_file(bool *sensed_out, vv_object **params, vv_file *file, int64_t frame, vv_job *job)
{
    vv_field *slices = NULL;
    *sensed_out = false;
    if (!is_open(*params, vv_file_info(file)) || !vvi_label_sense_may(vv_file_info(file)))
        return VV_OK;
    vv_status st = read_slices(&slices, file, frame, job);
    if (st == VV_OK)
        st = sense(sensed_out, params, slices, job);
    vv_field_release(slices);
    return st;
}
