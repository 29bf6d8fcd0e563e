/* The brightness of an X-ray, from lines along the axes. */
#include "scene/xray_exposure.h"
#include "grid/field.h"
#include "scene/lens.h"
#include <math.h>

enum { LINES = 24, MOST_SAMPLES = 256 };

/* Place `i` of `n` spread over an axis of `size` samples. */
static int64_t spread(int64_t i, int64_t n, int64_t size)
{
    return n < 2 ? size / 2 : i * (size - 1) / (n - 1);
}

static double line_mean(const vv_brick *b, const vv_field_info *info, int component, int axis, const int64_t at[3])
{
    const int64_t size = b->box.n[axis], n = size < MOST_SAMPLES ? size : MOST_SAMPLES;
    double sum = 0;
    int64_t count = 0;
    for (int64_t i = 0; i < n; i++) {
        const char *p = (const char *)b->data + (size_t)component * vv_type_bytes(b->type);
        double v;
        for (int a = 0; a < 3; a++)
            p += b->stride[a] * (a == axis ? spread(i, n, size) : at[a]);
        vvi_samples_to_f64(&v, p, b->type, 1);
        v = v * info->value_scale + info->value_offset;
        sum += isfinite(v) ? v : 0;
        count += isfinite(v);
    }
    return count ? sum / (double)count : 0;
}

vv_status vvi_exposure(double *out, const vv_actor *actor, bool over_longest, vv_job *job)
{
    const vv_field_info *info = vv_field_get_info(actor->field);
    const vv_box box = vv_field_box(actor->field);
    vv_brick brick = {0};
    double length[3], diagonal = 0;
    *out = 0;
    const vv_status st = vv_field_brick(&brick, actor->field, &box, job);
    if (st != VV_OK)
        return st;
    for (int a = 0; a < 3; a++) {
        length[a] = vvi_length(actor->index_to_world.axis[a]) * (double)box.n[a];
        diagonal = hypot(diagonal, length[a]);
    }
    for (int a = 0; a < 3; a++) {
        const int b = (a + 1) % 3, c = (a + 2) % 3;
        const double share = over_longest ? length[a] / diagonal : 1;
        for (int64_t i = 0; i < LINES * LINES; i++) {
            int64_t at[3] = {0};
            at[b] = spread(i % LINES, LINES, box.n[b]);
            at[c] = spread(i / LINES, LINES, box.n[c]);
            *out = fmax(*out, share * line_mean(&brick, info, actor->component, a, at));
        }
    }
    vv_brick_release(&brick);
    return VV_OK;
}
