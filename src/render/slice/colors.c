/* Which light a value has in a slice. */
#include "core/memory.h"
#include "grid/label_id.h"
#include "render/slice/slice.h"
#include <math.h>
#include <volvis/render.h>

static vv_status make_map(vvi_slice_colors *c, const vv_slice_look *look, vv_job *job)
{
    const size_t bytes = VVI_SLICE_ROWS * sizeof *c->map;
    c->map = vvi_alloc(job, bytes, VVI_MEM_DERIVED);
    if (!c->map)
        return vv_fail_memory(bytes);
    for (int i = 0; i < VVI_SLICE_ROWS; i++) {
        vv_color color = {0};
        vv_colormap_sample(&color, look->colormap, (double)i / (VVI_SLICE_ROWS - 1));
        c->map[i][0] = (float)color.r;
        c->map[i][1] = (float)color.g;
        c->map[i][2] = (float)color.b;
    }
    c->lo = look->lo;
    c->scale = look->hi > look->lo ? (VVI_SLICE_ROWS - 1) / (look->hi - look->lo) : INFINITY;
    return VV_OK;
}

static vv_status make_transfer(vvi_slice_colors *c, const vv_actor *actor, vv_job *job)
{
    double lo, hi;
    size_t n;
    const vv_field_info *info = vv_field_get_info(actor->field);
    const vv_status st = vvi_transfer_domain(&lo, &hi, &n, &actor->classes, info, actor->statistics);
    if (st != VV_OK)
        return st;
    n = actor->nearest ? n : vvi_transfer_finer(n, lo, hi, info);
    return vvi_transfer_table_init(&c->transfer, &actor->classes, lo, hi, n, job);
}

vv_status vvi_slice_colors_init(vvi_slice_colors *out, const vv_actor *actor, vv_job *job)
{
    *out = (vvi_slice_colors){.actor = actor, .opacity = (float)actor->slices.opacity};
    if (actor->colors || actor->classes.kind == VV_SEGMENT_LABELS)
        return VV_OK;
    return actor->slices.colors == VV_SLICE_TRANSFER ? make_transfer(out, actor, job)
                                                     : make_map(out, &actor->slices, job);
}

void vvi_slice_colors_finish(vvi_slice_colors *c)
{
    vvi_free(c->map);
    vvi_transfer_table_finish(&c->transfer);
    *c = (vvi_slice_colors){0};
}

/* Between two rows; rows are `stride` floats. At NaN, which is 0 / 0 of a step, the first. */
static void between(float rgb[3], const float *rows, size_t n, size_t stride, double place)
{
    const double x = place > 0 ? (place < (double)(n - 1) ? place : (double)(n - 1)) : 0;
    const size_t i = x < (double)(n - 1) ? (size_t)x : n - 2;
    const float t = (float)(x - (double)i);
    for (size_t c = 0; c < 3; c++)
        rgb[c] = (1 - t) * rows[i * stride + c] + t * rows[(i + 1) * stride + c];
}

/* Of a label that is seen, however thin it is in a cloud. */
static void put_label(float rgba[4], const vvi_slice_colors *c, const double rgbk[4])
{
    rgba[0] = rgba[1] = rgba[2] = rgba[3] = 0;
    if (!(rgbk[3] > 0))
        return;
    for (int i = 0; i < 3; i++)
        rgba[i] = (float)rgbk[i] * c->opacity;
    rgba[3] = c->opacity;
}

bool vvi_slice_has_ids(const vv_actor *actor)
{
    const vv_field_info *info = vv_field_get_info(actor->field);
    return !actor->colors && actor->classes.kind == VV_SEGMENT_LABELS && info->value_scale == 1 &&
           info->value_offset == 0 && (info->type == VV_TYPE_I64 || info->type == VV_TYPE_U64);
}

void vvi_slice_label_color(float rgba[4], const vvi_slice_colors *c, vv_label_id label)
{
    double rgbk[4];
    const vv_type type = vv_field_get_info(c->actor->field)->type;
    vvi_transfer_label(rgbk, &c->actor->classes, label, vvi_label_is_unsigned(type));
    put_label(rgba, c, rgbk);
}

/* From nothing at the middle of the window to all at half of the way to its ends. */
static float share_of_middle(const vvi_slice_colors *c, double value)
{
    if (!c->map || !c->actor->slices.clear_middle)
        return 1;
    const double middle = (VVI_SLICE_ROWS - 1) / 2.0, away = fabs((value - c->lo) * c->scale - middle) / middle;
    return (float)fmin(2 * away, 1);
}

void vvi_slice_color(float rgba[4], const vvi_slice_colors *c, const double sample[4])
{
    rgba[0] = rgba[1] = rgba[2] = rgba[3] = 0;
    if (c->actor->colors) {
        for (int i = 0; i < 4; i++)
            rgba[i] = (float)sample[i] * c->opacity;
        return;
    }
    if (isnan(sample[0]) || (c->map && c->actor->slices.clear_below && sample[0] < c->lo))
        return;
    if (c->map)
        between(rgba, c->map[0], VVI_SLICE_ROWS, 3, (sample[0] - c->lo) * c->scale);
    else if (c->transfer.rgbk)
        between(rgba, c->transfer.rgbk, c->transfer.n, 4, sample[0] * c->transfer.scale + c->transfer.offset);
    else {
        double rgbk[4];
        vvi_transfer_evaluate(rgbk, &c->actor->classes, sample[0]);
        put_label(rgba, c, rgbk);
        return;
    }
    const float opacity = c->opacity * share_of_middle(c, sample[0]);
    for (int i = 0; i < 3; i++)
        rgba[i] *= opacity;
    rgba[3] = opacity;
}
