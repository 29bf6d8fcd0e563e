/* Which value is at a place: as the volume is interpolated. */
#include "core/cache.h"
#include "core/memory.h"
#include "render/slice/slice.h"
#include "scene/colors.h"
#include <math.h>

#define SLACK 1e-6 /* samples: places on the outermost ones are computed to less than that */

static vv_status open_colors(vvi_slice_samples *s, const vv_actor *actor, vv_job *job)
{
    vv_status st = vvi_colors_open(&s->colors, actor->colors, actor->colors_encoded, job);
    for (; st == VV_OK && s->n_probes < 4; s->n_probes += st == VV_OK)
        st = vvi_probe_open(&s->probe[s->n_probes], vvi_cached_value(s->colors), s->n_probes, actor->nearest, job);
    return st;
}

static vv_status open_values(vvi_slice_samples *s, const vv_actor *actor, vv_job *job)
{
    const vv_status st = vvi_probe_open(&s->probe[0], actor->field, actor->component, actor->nearest, job);
    s->n_probes = st == VV_OK;
    s->probe[0].labels = actor->classes.kind == VV_SEGMENT_LABELS;
    if (st != VV_OK || !actor->cubic || s->probe[0].labels)
        return st;
    s->has_cubic = true;
    return vvi_lattice_open_cubic(&s->cubic, actor->field, actor->component, job);
}

vv_status vvi_slice_samples_open(vvi_slice_samples *out, const vv_actor *actor, vv_job *job)
{
    const int64_t *dims = vv_field_get_info(actor->field)->grid.dims;
    const double reach = (actor->nearest ? 0.5 : 0) + SLACK;
    *out = (vvi_slice_samples){0};
    for (int a = 0; a < 3; a++) {
        out->lo[a] = -reach;
        out->hi[a] = (double)(dims[a] - 1) + reach;
    }
    return actor->colors ? open_colors(out, actor, job) : open_values(out, actor, job);
}

void vvi_slice_samples_close(vvi_slice_samples *s)
{
    for (int i = 0; i < s->n_probes; i++)
        vvi_probe_close(&s->probe[i]);
    vvi_cache_release(s->colors);
    vvi_lattice_close(&s->cubic);
    *s = (vvi_slice_samples){0};
}

static bool is_inside(const vvi_slice_samples *s, const double p[3])
{
    for (int a = 0; a < 3; a++)
        if (!(p[a] >= s->lo[a] && p[a] <= s->hi[a]))
            return false;
    return true;
}

bool vvi_slice_label(vv_label_id *out, const vvi_slice_samples *s, const double p[3])
{
    return is_inside(s, p) && vvi_probe_label(out, &s->probe[0], p);
}

bool vvi_slice_sample(double out[4], const vvi_slice_samples *s, const double p[3])
{
    if (!is_inside(s, p))
        return false;
    if (s->has_cubic) {
        out[0] = vvi_cubic_at(&s->cubic.lattice, p, -1) * s->cubic.value_scale + s->cubic.value_offset;
        return true;
    }
    for (int i = 0; i < s->n_probes; i++)
        out[i] = vvi_probe_value(&s->probe[i], p);
    return true;
}
