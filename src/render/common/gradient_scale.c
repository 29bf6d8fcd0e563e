#include "render/common/gradient_scale.h"
#include "core/job.h"
#include "core/memory.h"
#include "grid/field.h"
#include "render/common/lens.h"
#include <math.h>
#include <stdlib.h>

enum { ALONG_AXIS = 67 }; /* at most, so that all are about 300000 */

typedef struct walk {
    const vv_brick *brick;
    const vv_actor *actor;
    vv_affine inverse;
    double value_scale;
} walk;

static double stored_at(const walk *w, const int64_t p[3])
{
    const vv_brick *b = w->brick;
    double v = 0;
    const char *at = (const char *)b->data + p[0] * b->stride[0] + p[1] * b->stride[1] + p[2] * b->stride[2];
    vvi_samples_to_f64(&v, at + (size_t)w->actor->component * vv_type_bytes(b->type), b->type, 1);
    return v;
}

/* |gradient| in the World at a sample: central differences, one-sided at the border. */
static double length_at(const walk *w, const int64_t p[3])
{
    double g[3];
    for (int a = 0; a < 3; a++) {
        int64_t lo[3] = {p[0], p[1], p[2]}, hi[3] = {p[0], p[1], p[2]};
        lo[a] -= lo[a] > 0;
        hi[a] += hi[a] < w->brick->box.n[a] - 1;
        g[a] = hi[a] > lo[a] ? (stored_at(w, hi) - stored_at(w, lo)) / (double)(hi[a] - lo[a]) : 0;
    }
    const vv_affine *m = &w->inverse; /* inverse transpose of index -> world */
    const vv_vec3 world = {m->axis[0].x * g[0] + m->axis[0].y * g[1] + m->axis[0].z * g[2],
                           m->axis[1].x * g[0] + m->axis[1].y * g[1] + m->axis[1].z * g[2],
                           m->axis[2].x * g[0] + m->axis[2].y * g[1] + m->axis[2].z * g[2]};
    return vvi_length(world) * fabs(w->value_scale);
}

static int compare(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double high_quantile(double *length, size_t n)
{
    if (!n)
        return 0;
    qsort(length, n, sizeof *length, compare);
    const double least = length[n - 1] / 100;
    size_t first = 0;
    while (first < n && length[first] <= least)
        first++;
    return first < n ? length[first + (n - 1 - first) * 99 / 100] : 0;
}

static vv_status collect(double *length, size_t *n_out, const walk *w, vv_job *job)
{
    const int64_t *n = w->brick->box.n;
    int64_t step[3], p[3];
    for (int a = 0; a < 3; a++)
        step[a] = (n[a] + ALONG_AXIS - 1) / ALONG_AXIS;
    for (p[2] = 0; p[2] < n[2]; p[2] += step[2]) {
        const vv_status st = vvi_job_poll(job);
        if (st != VV_OK)
            return st;
        for (p[1] = 0; p[1] < n[1]; p[1] += step[1])
            for (p[0] = 0; p[0] < n[0]; p[0] += step[0]) {
                const double g = length_at(w, p);
                if (isfinite(g))
                    length[(*n_out)++] = g;
            }
    }
    return VV_OK;
}

vv_status vvi_gradient_scale(double *out, const vv_actor *actor, vv_job *job)
{
    walk w = {.actor = actor, .value_scale = vv_field_get_info(actor->field)->value_scale};
    const size_t bytes = (size_t)ALONG_AXIS * ALONG_AXIS * ALONG_AXIS * sizeof(double);
    const vv_box box = vv_field_box(actor->field);
    vv_brick brick = {0};
    size_t n = 0;
    *out = 0;
    if (!vv_affine_invert(&w.inverse, actor->index_to_world))
        return VV_OK; /* place() says so */
    double *length = vvi_alloc(job, bytes, VVI_MEM_SCRATCH);
    if (!length)
        return vv_fail_memory(bytes);
    vv_status st = vv_field_brick(&brick, actor->field, &box, job);
    w.brick = &brick;
    if (st == VV_OK)
        st = collect(length, &n, &w, job);
    if (st == VV_OK)
        *out = high_quantile(length, n);
    vv_brick_release(&brick);
    vvi_free(length);
    return st;
}
