/* Several volumes along one ray, in double precision. Never removed and never made fast. */
#include "render/common/transfer_integral.h"
#include "render/raycast/raycast_ref.h"
#include <math.h>
#include <string.h>

/* The nearest surface, and where it stands. */
static void find_behind(double rgba[4], double *depth, const vvi_raycast_state *state, const vvi_ref_ray *rays)
{
    for (size_t i = 0; i < state->n_volumes; i++) {
        vvi_ref_ray r = rays[i];
        double surface[4] = {0}, at = INFINITY;
        if (!r.volume->solid || !vvi_ref_clip(&r))
            continue;
        vvi_ref_surface(surface, &at, &r);
        if (at < *depth) {
            *depth = at;
            memcpy(rgba, surface, sizeof surface);
        }
    }
}

/* Extinction and colour by the value in the middle: a row of the frame's table, which has tests of its own. */
static double by_table(double rgb[3], const vvi_ref_ray *r, double t)
{
    const vvi_march_volume *f = &r->volume->ray;
    const double value = vvi_ref_value(r, t);
    if (!isfinite(value))
        return 0;
    const float *row = f->classifier.color + 4 * vvi_ref_row(f, value);
    for (int c = 0; c < 3; c++)
        rgb[c] = (double)row[c];
    return (double)row[3] / f->step;
}

/* Their means over all values between the ends, straight from the nodes. */
static double by_integral(double rgb[3], const vvi_ref_ray *r, double from, double to)
{
    const vvi_lattice_hold *h = &r->volume->hold;
    const double a = vvi_ref_value(r, from) * h->value_scale + h->value_offset;
    const double b = vvi_ref_value(r, to) * h->value_scale + h->value_offset;
    double mean[4];
    if (!isfinite(a) || !isfinite(b))
        return 0;
    vvi_transfer_mean(mean, &r->volume->actor->classes, a, b);
    for (int c = 0; c < 3; c++)
        rgb[c] = mean[3] > 0 ? mean[c] / mean[3] : 0;
    return mean[3];
}

/* By value and length of the gradient: four numbers of the frame's own plane, which has tests of its own. */
static double by_plane(double rgb[3], const vvi_ref_ray *r, double t)
{
    const vvi_march_volume *f = &r->volume->ray;
    const double value = vvi_ref_value(r, t), length = vvi_length(vvi_ref_gradient(r, t));
    const double unit = fabs(r->volume->gradient_unit), last = VVI_PLANE_SIDE - 1;
    if (!isfinite(value))
        return 0;
    const double x = fmin(fmax(value * (double)f->classifier.plane_scale + (double)f->classifier.plane_shift, 0), last);
    const double y = fmin(length * unit * (double)f->classifier.plane_gradient, last);
    const size_t i = (size_t)fmin(x, last - 1), j = (size_t)fmin(y, last - 1);
    const double fx = x - (double)i, fy = y - (double)j;
    double sum[4];
    for (size_t c = 0; c < 4; c++) {
        const float *at = f->classifier.plane + 4 * (j * VVI_PLANE_SIDE + i) + c, *above = at + 4 * VVI_PLANE_SIDE;
        const double below = (double)at[0] + fx * ((double)at[4] - (double)at[0]);
        sum[c] = below + fy * ((double)above[0] + fx * ((double)above[4] - (double)above[0]) - below);
    }
    for (int c = 0; c < 3; c++)
        rgb[c] = sum[3] > 0 ? sum[c] / sum[3] : 0;
    return sum[3] / f->step;
}

/* What a gradient leaves of the extinction (after Levoy 1988). */
static double modulation(const vvi_ref_ray *r, double t)
{
    const vv_classification *c = &r->volume->actor->classes;
    const double length = vvi_length(vvi_ref_gradient(r, t)) * fabs(r->volume->hold.value_scale);
    const double share = length / c->gradient_reference;
    return length > 0 ? pow(fmin(share, 1), c->gradient_power) : 0;
}

/* Optical depth and colour of one volume over [from, to]. */
static double sample(double rgb[3], const vvi_ref_ray *r, double from, double to)
{
    const vvi_march_volume *f = &r->volume->ray;
    const double t = (from + to) / 2;
    double kappa = f->classifier.kind == VVI_CLASSIFY_INTEGRATED ? by_integral(rgb, r, from, to)
                   : f->classifier.kind == VVI_CLASSIFY_PLANE    ? by_plane(rgb, r, t)
                                                                 : by_table(rgb, r, t);
    vvi_ref_paint(rgb, r, t);
    vvi_ref_texture(rgb, r, t);
    if (kappa > 0 && f->classifier.modulate_power > 0)
        kappa *= modulation(r, t);
    const double color[3] = {rgb[0], rgb[1], rgb[2]};
    if (kappa > 0 && f->light.shaded)
        vvi_ref_shade(rgb, r, t, color, false);
    return kappa * (to - from);
}

/* The sums of one step; how far it is filled. */
typedef struct step_sum {
    double depth, rgb[3], from, to;
} step_sum;

static void add_volume(step_sum *sum, const vvi_ref_ray *r, double from, double to, double step)
{
    double rgb[3] = {0};
    from = fmax(from, r->t0);
    to = fmin(to, r->t1);
    if (to - from <= 1e-6 * step)
        return;
    const double depth = sample(rgb, r, from, to);
    sum->depth += depth;
    for (int c = 0; c < 3; c++)
        sum->rgb[c] += depth * rgb[c];
    sum->from = fmin(sum->from, from);
    sum->to = fmax(sum->to, to);
}

/* The rays' parts inside clouds that they meet. */
typedef struct clouds {
    vvi_ref_ray part[VVI_BLEND_VOLUMES];
    size_t n;
} clouds;

static void add_cloud(clouds *all, const vvi_ref_ray *ray, double limit)
{
    vvi_ref_ray r = *ray;
    if (r.volume->solid || vvi_raycast_projects(r.volume->params->mode) || !vvi_ref_clip(&r))
        return;
    r.t1 = fmin(r.t1, limit);
    if (r.t1 > r.t0)
        all->part[all->n++] = r;
}

static double first_of(const clouds *all)
{
    double first = INFINITY;
    for (size_t i = 0; i < all->n; i++)
        first = fmin(first, all->part[i].t0);
    return first;
}

static double last_of(const clouds *all)
{
    double last = -INFINITY;
    for (size_t i = 0; i < all->n; i++)
        last = fmax(last, all->part[i].t1);
    return last;
}

/* The step of the finest volume that a ray is in right behind t; 0: it is in none. */
static double finest_at(const clouds *all, double t)
{
    double step = INFINITY;
    for (size_t i = 0; i < all->n; i++)
        if (all->part[i].t0 <= t && t < all->part[i].t1)
            step = fmin(step, all->part[i].volume->ray.step);
    return isfinite(step) ? step : 0;
}

/* The step from `start` on, and until where it is the same: steps are counted from there then. Where the ray is in no
 * volume, it stays as it was. INFINITY: to the end. */
static double step_from(double *until, const clouds *all, double start)
{
    const double step = finest_at(all, start);
    double at = start;
    *until = INFINITY;
    for (bool more = true; more && isinf(*until);) {
        double next = INFINITY;
        for (size_t i = 0; i < all->n; i++) {
            const double ends[2] = {all->part[i].t0, all->part[i].t1};
            for (int e = 0; e < 2; e++)
                next = ends[e] > at ? fmin(next, ends[e]) : next;
        }
        more = isfinite(next);
        at = next;
        const double then = more ? finest_at(all, at) : 0;
        if (then > 0 && then != step)
            *until = at;
    }
    return step;
}

void vvi_ref_blend(double rgba[4], double *depth, const vv_scene *scene, const vvi_raycast_state *state,
                   const vvi_ref_ray *rays)
{
    const double opaque = (double)state->volume[0].ray.opaque;
    clouds all = {0};
    double behind[4] = {0}, limit = INFINITY, clear = 1, until, step;
    (void)scene;
    find_behind(behind, &limit, state, rays);
    for (size_t i = 0; i < state->n_volumes; i++)
        add_cloud(&all, &rays[i], limit);
    for (double start = first_of(&all); isfinite(start); start = until) {
        step = step_from(&until, &all, start);
        const double end = fmin(until, last_of(&all));
        for (int64_t k = 0; start + (double)k * step < end && clear > opaque; k++) {
            const double from = start + (double)k * step, to = fmin(from + step, until);
            step_sum sum = {.from = to, .to = from};
            for (size_t i = 0; i < all.n; i++)
                add_volume(&sum, &all.part[i], from, to, step);
            if (sum.depth <= 0)
                continue;
            const double alpha = -expm1(-sum.depth);
            for (int c = 0; c < 3; c++)
                rgba[c] += clear * alpha * sum.rgb[c] / sum.depth;
            if (clear >= 0.5 && clear * (1 - alpha) < 0.5)
                *depth = vvi_ref_half(sum.from, sum.to, clear, alpha);
            clear *= 1 - alpha;
        }
    }
    for (int c = 0; c < 3; c++)
        rgba[c] += clear * behind[c];
    rgba[3] = 1 - clear * (1 - behind[3]);
    if (isinf(*depth))
        *depth = limit;
}
