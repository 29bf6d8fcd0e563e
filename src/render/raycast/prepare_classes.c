/* What the values of a volume are seen as: tables for the kernels. */
#include "core/memory.h"
#include "render/raycast/prepare.h"
#include <math.h>
#include <string.h>

enum { GUARD_FLOATS = 16 };

/* Stored numbers are looked up where they are: entry = stored * scale + shift is the table's place for their value. */
vv_status vvi_raycast_classify(vvi_raycast_volume *v, vvi_transfer_table *table, vv_job *job)
{
    const vv_actor *actor = v->actor;
    vvi_ray_frame *f = &v->blend.ray;
    const vv_field_info *info = vv_field_get_info(actor->field);
    double lo, hi;
    size_t n;
    vv_status st = vvi_transfer_domain(&lo, &hi, &n, &actor->classes, info, actor->statistics);
    if (st != VV_OK)
        return st;
    if (!actor->nearest && n > 1 && n < VVI_TRANSFER_ROWS) /* between stored values as well, each of them on a row */
        n = (n - 1) * ((VVI_TRANSFER_ROWS - 1 + n - 2) / (n - 1)) + 1;
    if ((st = vvi_transfer_table_init(table, &actor->classes, lo, hi, n, job)) != VV_OK)
        return st;
    const size_t rows = table->n;
    v->alpha = vvi_alloc(job, (rows + GUARD_FLOATS) * sizeof *v->alpha, VVI_MEM_SCRATCH);
    v->color = vvi_alloc(job, (rows * 4 + GUARD_FLOATS) * sizeof *v->color, VVI_MEM_SCRATCH);
    if (!v->alpha || !v->color)
        return vv_fail_memory(rows * 5 * sizeof(float));
    for (size_t i = 0; i < rows; i++) {
        v->alpha[i] = (float)-expm1(-(double)table->rgbk[4 * i + 3] * f->step);
        memcpy(v->color + 4 * i, table->rgbk + 4 * i, 3 * sizeof *v->color);
        v->color[4 * i + 3] = (float)((double)table->rgbk[4 * i + 3] * f->step);
    }
    f->alpha = v->alpha;
    f->color = v->color;
    f->n_entries = (int32_t)rows;
    f->entry_scale = (float)(v->hold.value_scale * table->scale);
    f->entry_shift = (float)(v->hold.value_offset * table->scale + table->offset + 0.5);
    return VV_OK;
}

void vvi_raycast_find_solid(vvi_raycast_volume *v, const vvi_raycast_params *p)
{
    const vv_actor *actor = v->actor;
    vvi_ray_frame *f = &v->blend.ray;
    const bool iso = p->mode == VVI_RAYCAST_ISOSURFACE;
    const double from = !iso ? actor->classes.lo : vv_object_is_set(&p->base, "iso") ? p->iso : actor->iso;
    const double to = iso ? INFINITY : actor->classes.hi;
    const double a = (from - v->hold.value_offset) / v->hold.value_scale;
    const double b = (to - v->hold.value_offset) / v->hold.value_scale;
    f->solid_lo = (float)fmin(a, b);
    f->solid_hi = (float)fmax(a, b);
    memcpy(f->surface_color, actor->color, sizeof f->surface_color);
}
