#include "filter/smoothed_samples.h"
#include "filter/real_samples.h"
#include "filter/window.h"
#include "grid/making.h"
#include "registry.h"

#include <math.h>
#include <stdio.h>

#define SIGMA_MOST 1024.0 /* voxels: gaussian's */
#define CUT 4.0           /* sigmas that its kernel reaches */

typedef struct shared {
    vvi_making making;
    vv_type type;
} shared;

static vv_status item(void *scratch, void *user, size_t index)
{
    const shared *s = user;
    const vv_box box = vvi_slabs_item(&s->making.slabs, index);
    const vv_brick in = vvi_brick_part(&s->making.brick, &box);
    const bool wide = vvi_reals_wide(s->type);
    const int64_t step = in.components * (int64_t)vvi_reals_bytes(wide), n = box.n[0] * in.components;
    for (int64_t k = 0; k < box.n[2]; k++)
        for (int64_t j = 0; j < box.n[1]; j++) {
            const char *from = (const char *)in.data + j * in.stride[1] + k * in.stride[2];
            vvi_reals_of_samples(s->making.out + vvi_slabs_row(&s->making.slabs, &box, j, k) * step, wide, from,
                                 (int64_t)vv_type_bytes(s->type), s->type, n);
        }
    return VV_OK;
}

static vv_status to_floats(vv_field **out, const vv_field *in, const vv_box *box, vv_job *job)
{
    static const vvi_work work = {.stage = "smooth", .item = item};
    vv_field_info info = *vv_field_get_info(in);
    shared s = {.making = {.in = in, .slabs = vvi_slabs_of(box, 1 << 16)}, .type = info.type};
    info.type = vvi_reals_wide(info.type) ? VV_TYPE_F64 : VV_TYPE_F32;
    info.meaning = VV_MEANING_SCALAR;
    return vvi_making_run(out, &s.making, &info, box, box, &work, &s, job);
}

static vv_status gaussian(vv_field **out, const vv_field *in, const vv_box *box, const double sigma[3], vv_job *job)
{
    char text[128];
    vv_object *params = NULL;
    snprintf(text, sizeof text, "[%.17g,%.17g,%.17g]", sigma[0], sigma[1], sigma[2]);
    vv_status st = vv_object_new(&params, vvi_operation_gaussian.params, NULL);
    if (st == VV_OK)
        st = vv_path_set(&params, "sigma_voxels", text, NULL);
    if (st == VV_OK)
        st = vvi_operation_gaussian.run_box(out, &in, 1, params, box, job);
    vv_object_release(params);
    return st;
}

vv_status vvi_smoothed_check(const vv_grid *grid, double sigma, const char *name)
{
    for (int a = 0; a < 3; a++)
        if (grid->dims[a] > 1 && !(sigma / vv_grid_spacing(grid, a) <= SIGMA_MOST))
            return vv_fail(VV_E_ARGUMENT, "%s: sigma is %g voxels along %c; it may be %g", name,
                           sigma / vv_grid_spacing(grid, a), "xyz"[a], SIGMA_MOST);
    return VV_OK;
}

vv_status vvi_smoothed(vv_field **out, const vv_field *in, const vv_box *box, double sigma, vv_job *job)
{
    const vv_grid *grid = &vv_field_get_info(in)->grid;
    int64_t reach[3];
    double voxels[3];
    vv_field *floats = NULL;
    *out = NULL;
    for (int a = 0; a < 3; a++) {
        voxels[a] = grid->dims[a] > 1 ? sigma / vv_grid_spacing(grid, a) : 0;
        reach[a] = (int64_t)floor(CUT * voxels[a] + 0.5);
    }
    if (vv_type_is_float(vv_field_get_info(in)->type) && vv_field_get_info(in)->meaning != VV_MEANING_LABEL)
        return gaussian(out, in, box, voxels, job);
    const vv_box needed = vvi_window_reach(box, reach, grid->dims);
    vv_box there = *box;
    for (int a = 0; a < 3; a++)
        there.lo[a] -= needed.lo[a];
    vv_status st = to_floats(&floats, in, &needed, job);
    if (st == VV_OK)
        st = gaussian(out, floats, &there, voxels, job);
    vv_field_release(floats);
    return st;
}
