#include "scene/value_profile.h"
#include "grid/value_fit.h"
#include "scene/lens.h"
#include "scene/value_walk.h"
#include <math.h>

void vvi_profile_counts(vvi_value_profile *out, const vv_statistics *s)
{
    *out = (vvi_value_profile){.n = 1, .lo = s->histogram_lo, .width = 1};
    if (!s->count || !(s->histogram_hi > s->histogram_lo))
        return;
    const double fine = vvi_bin_width(s);
    out->lo = vvi_fit_bottom(s);
    const int first = (int)llround((out->lo - s->histogram_lo) / fine);
    const double bins = fmax(floor((vvi_fit_top(s) - out->lo) / fine + 0.5), 1);
    const double each = ceil(bins / VVI_PROFILE_BINS); /* whole fine bins: no beat between the two */
    out->n = (int)ceil(bins / each);
    out->width = each * fine;
    for (int b = first; b < s->n_bins; b++) {
        const double at = (b - first) / each;
        if (at < out->n)
            out->count[(int)at] += (double)s->histogram[b];
    }
}

static void add(void *user, const vvi_walk *walk, const int64_t at[3])
{
    vvi_value_profile *p = user;
    const double bin = floor((vvi_walk_value(walk, at) - p->lo) / p->width);
    if (!(bin >= 0 && bin < p->n))
        return;
    const double slope = vvi_length(vvi_walk_gradient(walk, at));
    if (!isfinite(slope))
        return;
    p->seen[(int)bin]++;
    p->slope[(int)bin] += slope;
}

static vv_status find(void *out, const vv_actor *actor, vv_job *job)
{
    vvi_profile_counts(out, actor->statistics);
    return vvi_walk_samples(actor, add, out, job);
}

vv_status vvi_profile_get(vvi_value_profile *out, const vv_actor *actor, vv_job *job)
{
    return vvi_walk_once(out, sizeof *out, "value profile", find, actor, job);
}
