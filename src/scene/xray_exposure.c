/* The brightness of an X-ray, from lines along the axes. */
#include "scene/xray_exposure.h"
#include "core/cache.h"
#include "core/job.h"
#include "core/memory.h"
#include "core/status.h"
#include "grid/field.h"
#include "scene/lens.h"
#include <math.h>

enum { LINES = 24, MORE_LINES = 160, MOST_SAMPLES = 256 };

/* Of all lines along each axis. */
typedef struct line_means {
    double mean[3]; /* the largest */
    double seen;    /* the largest sample on them */
} line_means;

/* Place `i` of `n` spread over an axis of `size` samples. */
static int64_t spread(int64_t i, int64_t n, int64_t size)
{
    return n < 2 ? size / 2 : i * (size - 1) / (n - 1);
}

static double line_mean(double *seen, const vv_brick *b, const vv_field_info *info, int component, int axis,
                        const int64_t at[3])
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
        *seen = isfinite(v) ? fmax(*seen, v) : *seen;
        sum += isfinite(v) ? v : 0;
        count += isfinite(v);
    }
    return count ? sum / (double)count : 0;
}

/* One line at a time: of what does not fit into memory. */
static vv_status read_line(double *mean, double *seen, const vv_field *field, int component, int axis,
                           const int64_t at[3], vv_job *job)
{
    const vv_box all = vv_field_box(field);
    static const int64_t first[3] = {0, 0, 0};
    vv_box line = {{all.lo[0] + at[0], all.lo[1] + at[1], all.lo[2] + at[2]}, {1, 1, 1}};
    vv_brick brick = {0};
    line.lo[axis] = all.lo[axis];
    line.n[axis] = all.n[axis];
    const vv_status st = vv_field_brick(&brick, field, &line, job);
    if (st != VV_OK)
        return st;
    *mean = line_mean(seen, &brick, vv_field_get_info(field), component, axis, first);
    vv_brick_release(&brick);
    return VV_OK;
}

/* whole: all samples; NULL: they do not fit into memory together. */
static vv_status measure(line_means *out, const vv_field *field, const vv_brick *whole, int component, int64_t n_lines,
                         vv_job *job)
{
    const vv_field_info *info = vv_field_get_info(field);
    const vv_box box = vv_field_box(field);
    *out = (line_means){.seen = -INFINITY};
    vv_status st = VV_OK;
    for (int a = 0; a < 3 && st == VV_OK; a++) {
        const int b = (a + 1) % 3, c = (a + 2) % 3;
        const int64_t n_b = box.n[b] < n_lines ? box.n[b] : n_lines, n_c = box.n[c] < n_lines ? box.n[c] : n_lines;
        for (int64_t i = 0; i < n_b * n_c && st == VV_OK; i++) {
            int64_t at[3] = {0};
            double mean = 0;
            at[b] = spread(i % n_b, n_b, box.n[b]);
            at[c] = spread(i / n_b, n_c, box.n[c]);
            if (whole)
                mean = line_mean(&out->seen, whole, info, component, a, at);
            else
                st = read_line(&mean, &out->seen, field, component, a, at, job);
            out->mean[a] = fmax(out->mean[a], mean);
            if (st == VV_OK && i % 4096 == 0)
                st = vvi_job_poll(job);
        }
    }
    return st;
}

static vv_status measure_all(line_means *out, const vv_actor *actor, vv_job *job)
{
    const vv_statistics *s = actor->statistics;
    const vv_box box = vv_field_box(actor->field);
    vv_brick brick = {0};
    vv_status st = vv_field_brick(&brick, actor->field, &box, job);
    if (st == VV_E_LIMIT || st == VV_E_MEMORY)
        return measure(out, actor->field, NULL, actor->component, LINES, job);
    if (st != VV_OK)
        return st;
    st = measure(out, actor->field, &brick, actor->component, LINES, job);
    if (st == VV_OK && s && out->seen - s->min < 0.5 * (s->max - s->min))
        st = measure(out, actor->field, &brick, actor->component, MORE_LINES, job);
    vv_brick_release(&brick);
    return st;
}

/* Few lines meet what is large; what is small and bright is looked for with many. */
static vv_status make(void **value_out, uint64_t *bytes_out, void *user, vv_job *job)
{
    line_means *m = vvi_alloc(job, sizeof *m, VVI_MEM_DERIVED);
    if (!m)
        return vv_fail_memory(sizeof *m);
    const vv_status st = measure_all(m, user, job);
    if (st != VV_OK) {
        vvi_free(m);
        return st;
    }
    *value_out = m;
    *bytes_out = sizeof *m;
    return VV_OK;
}

vv_status vvi_exposure(double *out, const vv_actor *actor, bool over_longest, vv_job *job)
{
    const vv_box box = vv_field_box(actor->field);
    const vvi_cache_key key = {"exposure", vv_field_identity(actor->field), (uint64_t)actor->component};
    vvi_cached *cached;
    double length[3], diagonal = 0;
    *out = 0;
    const vv_status st = vvi_cache_get(&cached, &key, make, vvi_free, (void *)(uintptr_t)actor, job);
    if (st != VV_OK)
        return st;
    const line_means *m = vvi_cached_value(cached);
    for (int a = 0; a < 3; a++) {
        length[a] = vvi_length(actor->index_to_world.axis[a]) * (double)box.n[a];
        diagonal = hypot(diagonal, length[a]);
    }
    for (int a = 0; a < 3; a++)
        *out = fmax(*out, m->mean[a] * (over_longest ? length[a] / diagonal : 1));
    vvi_cache_release(cached);
    return VV_OK;
}
