/* What stands on the faces of a field. Only data whose background is in doubt are read for it. */
#include "core/cache.h"
#include "core/job.h"
#include "core/memory.h"
#include "grid/field.h"
#include "grid/value_fit.h"
#include <math.h>

#define ALONG 256 /* samples of a face in each direction, at most */

typedef struct request {
    const vv_field *field;
    int component;
    const vv_statistics *statistics;
} request;

static void count_sample(vvi_border *out, const request *r, const vv_brick *b, const int64_t at[3])
{
    const vv_field_info *info = vv_field_get_info(r->field);
    const vv_statistics *s = r->statistics;
    double v;
    const char *sample = (const char *)b->data + at[0] * b->stride[0] + at[1] * b->stride[1] + at[2] * b->stride[2];
    vvi_samples_to_f64(&v, sample + (size_t)r->component * vv_type_bytes(b->type), b->type, 1);
    const double bin = (v * info->value_scale + info->value_offset - s->histogram_lo) / vvi_bin_width(s);
    out->n++;
    if (isfinite(bin))
        out->count[(int)fmin(fmax(bin, 0), s->n_bins - 1)]++;
}

/* The face across `axis`, at its lower or upper end. */
static vv_status count_face(vvi_border *out, const request *r, int axis, bool upper, vv_job *job)
{
    vv_box box = vv_field_box(r->field);
    vv_brick brick;
    int64_t step[3], p[3];
    box.lo[axis] += upper ? box.n[axis] - 1 : 0;
    box.n[axis] = 1;
    vv_status st = vvi_job_poll(job);
    if (st != VV_OK || (st = vv_field_brick(&brick, r->field, &box, job)) != VV_OK)
        return st;
    for (int a = 0; a < 3; a++)
        step[a] = (box.n[a] + ALONG - 1) / ALONG;
    for (p[2] = 0; p[2] < box.n[2]; p[2] += step[2])
        for (p[1] = 0; p[1] < box.n[1]; p[1] += step[1])
            for (p[0] = 0; p[0] < box.n[0]; p[0] += step[0])
                count_sample(out, r, &brick, p);
    vv_brick_release(&brick);
    return VV_OK;
}

static vv_status make(void **value_out, uint64_t *bytes_out, void *user, vv_job *job)
{
    vvi_border *border = vvi_alloc_zeroed(job, sizeof *border, VVI_MEM_DERIVED);
    vv_status st = border ? VV_OK : vv_fail_memory(sizeof *border);
    for (int face = 0; face < 6 && st == VV_OK; face++)
        st = count_face(border, user, face / 2, face % 2, job);
    if (st != VV_OK) {
        vvi_free(border);
        return st;
    }
    *value_out = border;
    *bytes_out = sizeof *border;
    return VV_OK;
}

vv_status vvi_fit_field(vvi_value_fit *out, const vv_field *field, int component, const vv_statistics *s, vv_job *job)
{
    const vv_box box = vv_field_box(field);
    request r = {field, component, s};
    const struct {
        double lo, hi;
        int64_t n_bins, component;
    } of = {s->histogram_lo, s->histogram_hi, s->n_bins, component};
    const vvi_cache_key key = {"border", vv_field_identity(field), vvi_hash(&of, sizeof of, 0)};
    vvi_cached *cached;
    vvi_fit_values(out, s, NULL);
    if (!out->high_peak || box.n[0] < 3 || box.n[1] < 3 || box.n[2] < 3) /* a slice is no more than its border */
        return VV_OK;
    const vv_status st = vvi_cache_get(&cached, &key, make, vvi_free, &r, job);
    if (st != VV_OK)
        return st;
    vvi_fit_values(out, s, vvi_cached_value(cached));
    vvi_cache_release(cached);
    return VV_OK;
}
