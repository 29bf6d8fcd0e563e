/* The ray caster as its definition: one pixel, double precision, every sample, straight from the formulas. Kernels are
 * tested against it. Never removed and never made fast. */
#include "render/raycast/raycast_ref.h"
#include "render/common/shade_ref.h"
#include <math.h>

static void enter(vvi_ref_ray *r, double t, vv_vec3 inwards, bool by_cut)
{
    if (t >= r->t0) {
        r->t0 = t;
        r->by_cut = by_cut;
        r->inwards = inwards;
        vvi_unit(&r->inwards);
    }
}

bool vvi_ref_clip(vvi_ref_ray *r)
{
    const vvi_march_volume *f = &r->volume->ray;
    r->t0 = 0;
    r->by_cut = false;
    r->t1 = INFINITY;
    r->inwards = r->direction;
    for (int a = 0; a < 3; a++) {
        const double *m = f->sampler.world_to_index[a];
        const double d = m[0] * r->direction.x + m[1] * r->direction.y + m[2] * r->direction.z;
        const double o = m[0] * r->origin.x + m[1] * r->origin.y + m[2] * r->origin.z + m[3];
        if (d == 0) {
            if (o < f->sampler.lo[a] || o > f->sampler.hi[a])
                return false;
            continue;
        }
        const double x = (f->sampler.lo[a] - o) / d, y = (f->sampler.hi[a] - o) / d;
        enter(r, fmin(x, y), vvi_scaled(vvi_vec(m[0], m[1], m[2]), d > 0 ? 1 : -1), false);
        r->t1 = fmin(r->t1, fmax(x, y));
    }
    for (size_t i = 0; i < r->volume->actor->n_planes; i++) {
        const vv_plane *p = &r->volume->actor->planes[i];
        const double d = vvi_dot(p->normal, r->direction), o = p->offset - vvi_dot(p->normal, r->origin);
        if (d > 0)
            enter(r, o / d, p->normal, true);
        else if (d < 0)
            r->t1 = fmin(r->t1, o / d);
        else if (o > 0)
            return false;
    }
    return r->t1 > r->t0;
}

void vvi_ref_shade(double out[3], const vvi_ref_ray *r, double t, const double color[3], bool facing)
{
    const double scale = r->volume->hold.value_scale;
    vv_vec3 g = vvi_scaled(vvi_ref_gradient(r, t), scale);
    if (facing && t == r->t0) /* a cut through the solid: a flat face, with a gradient that is long enough to count */
        g = vvi_scaled(r->inwards, 1 + 2 * vvi_shade_flat(r->volume->actor));
    const vvi_march_volume *f = &r->volume->ray;
    if (!facing && f->light.capped && r->by_cut && t - r->t0 < (double)f->light.cap_depth * f->step)
        g = vvi_scaled(r->inwards, 1 + 2 * vvi_shade_flat(r->volume->actor));
    if (!facing && f->light.unlit) /* what arrives right there */
        g = vvi_vec(0, 0, 0);
    vv_actor actor = *r->volume->actor;
    if (facing) {
        if (vvi_dot(g, r->direction) < 0)
            g = vvi_scaled(g, -1);
        actor.two_sided = false;
    }
    vvi_shade_ref(out, r->scene, &actor, color, vvi_add(r->origin, vvi_scaled(r->direction, t)), g,
                  vvi_scaled(r->direction, -1), vvi_shade_flat(r->volume->actor),
                  f->light.volume.cells ? &f->light.volume : NULL);
}

/* Rows of the frame's own table, so that only sampling, shading and compositing are compared; the table has its own
 * tests against the nodes. */
int64_t vvi_ref_row(const vvi_march_volume *f, double value)
{
    const double row = value * (double)f->classifier.entry_scale + (double)f->classifier.entry_shift;
    const double place = fmin(fmax(row, 0), (double)f->classifier.last_place);
    const int64_t entry = (int64_t)place;
    if (f->classifier.alpha[entry] < VVI_ENTRY_SPLIT)
        return entry;
    const double within = (place - (double)entry) * (double)f->classifier.color[4 * entry];
    return (int64_t)f->classifier.alpha[entry] - VVI_ENTRY_SPLIT + (int64_t)within;
}

double vvi_ref_half(double from, double to, double clear, double alpha)
{
    return alpha > 0.75 ? (from + to) / 2 : from + (to - from) * log(2 * clear) / -log1p(-alpha);
}

static void composite(double rgba[4], double *depth, const vvi_ref_ray *r)
{
    const vvi_march_volume *f = &r->volume->ray;
    double clear = 1;
    for (int64_t k = 0; clear > f->opaque; k++) {
        const double from = r->t0 + (double)k * f->step, to = fmin(from + f->step, r->t1);
        if (to - from <= 1e-6 * f->step)
            break;
        const double t = (from + to) / 2, v = vvi_ref_value(r, t);
        if (!isfinite(v))
            continue;
        const int64_t e = vvi_ref_row(f, v);
        double alpha = (double)f->classifier.alpha[e];
        if (to < from + f->step)
            alpha = -expm1(-(double)f->classifier.color[4 * e + 3] * (to - from) / f->step);
        if (alpha <= 0)
            continue;
        double color[3] = {(double)f->classifier.color[4 * e], (double)f->classifier.color[4 * e + 1],
                           (double)f->classifier.color[4 * e + 2]};
        vvi_ref_paint(color, r, t);
        vvi_ref_texture(color, r, t);
        if (f->light.shaded)
            vvi_ref_shade(color, r, t, color, false);
        for (int c = 0; c < 3; c++)
            rgba[c] += clear * alpha * color[c];
        if (clear >= 0.5 && clear * (1 - alpha) < 0.5)
            *depth = vvi_ref_half(from, to, clear, alpha);
        clear *= 1 - alpha;
    }
    rgba[3] = 1 - clear;
}

static void store_value(double rgba[4], const vvi_march_volume *f, double stored)
{
    const int64_t e = vvi_ref_row(f, stored);
    rgba[3] = (double)f->projection.opacity * (f->projection.by_value ? (double)f->classifier.alpha[e] : 1);
    for (int c = 0; c < 3; c++)
        rgba[c] = (double)f->classifier.color[4 * e + c] * rgba[3];
}

/* The extreme data value; or, with a threshold, the first that is above it and followed by a smaller one. */
static void extremum(double rgba[4], double *depth, const vvi_ref_ray *r, double sign, double threshold)
{
    const vvi_march_volume *f = &r->volume->ray;
    const double order = sign * (r->volume->hold.value_scale < 0 ? -1 : 1);
    double best = -INFINITY;
    const int64_t n = (int64_t)floor((r->t1 - r->t0) / f->step);
    for (int64_t k = 0; k <= n + 1; k++) {
        const double t = k <= n ? r->t0 + (double)k * f->step : r->t1, v = vvi_ref_value(r, t) * order;
        if (v < best && best >= threshold)
            break;
        if (v > best) {
            best = v;
            *depth = t;
        }
    }
    if (best > -INFINITY)
        store_value(rgba, f, best * order);
}

/* The integral of the data value, over the ray's own length or that of the longest, by the midpoint rule. */
static void average(double rgba[4], const vvi_ref_ray *r, bool over_longest)
{
    const vvi_march_volume *f = &r->volume->ray;
    const double scale = r->volume->hold.value_scale, offset = r->volume->hold.value_offset;
    double sum = 0, length = 0;
    for (int64_t k = 0;; k++) {
        const double from = r->t0 + (double)k * f->step, to = fmin(from + f->step, r->t1);
        if (to - from <= 1e-6 * f->step)
            break;
        const double v = vvi_ref_value(r, (from + to) / 2) * scale + offset;
        if (!isfinite(v))
            continue;
        sum += v * (to - from);
        length += to - from;
    }
    if (length > 0)
        store_value(rgba, f,
                    (sum / (over_longest ? (double)f->projection.longest * f->step : length) - offset) / scale);
}

static void project(double rgba[4], double *depth, const vvi_ref_ray *r, int mode)
{
    const vvi_march_volume *f = &r->volume->ray;
    if (mode == VV_RAY_MEAN || mode == VV_RAY_SUM)
        average(rgba, r, mode == VV_RAY_SUM);
    else if (mode == VV_RAY_LOCAL_MAXIMUM)
        extremum(rgba, depth, r, 1, (double)f->projection.threshold);
    else
        extremum(rgba, depth, r, mode == VV_RAY_MINIMUM ? -1 : 1, INFINITY);
}

/* The first place where the value is in the solid's range, by steps of a 24th of the frame's and bisection. */
void vvi_ref_surface(double rgba[4], double *depth, const vvi_ref_ray *r)
{
    const vvi_march_volume *f = &r->volume->ray;
    const double fine = f->step / 24;
    double before = r->t0, t = r->t0;
    for (;; t += fine) {
        t = fmin(t, r->t1);
        const double v = vvi_ref_value(r, t);
        if (v >= (double)f->solid.lo && v <= (double)f->solid.hi)
            break;
        if (t >= r->t1)
            return;
        before = t;
    }
    for (int i = 0; i < 60; i++) {
        const double mid = (before + t) / 2, v = vvi_ref_value(r, mid);
        if (v >= (double)f->solid.lo && v <= (double)f->solid.hi)
            t = mid;
        else
            before = mid;
    }
    double color[3];
    for (int c = 0; c < 3; c++)
        color[c] = (double)f->solid.color[c];
    vvi_ref_paint(color, r, t);
    vvi_ref_texture(color, r, t);
    if (f->light.shaded)
        vvi_ref_shade(color, r, t, color, true);
    for (int c = 0; c < 3; c++)
        rgba[c] = color[c];
    rgba[3] = 1;
    *depth = t;
}

static void one_volume(double rgba[4], double *depth, vvi_ref_ray *r)
{
    if (!vvi_ref_clip(r))
        return;
    if (r->volume->solid)
        vvi_ref_surface(rgba, depth, r);
    else
        composite(rgba, depth, r);
}

/* One value of the ray, over what lies below. */
static void add_layer(double rgba[4], double *depth, vvi_ref_ray *r)
{
    double layer[4] = {0}, at = INFINITY;
    if (!vvi_ref_clip(r))
        return;
    project(layer, &at, r, r->volume->params->mode);
    const double through = r->volume->actor->layer.blend == VV_SLICE_ADD ? 1 : 1 - layer[3];
    for (int c = 0; c < 3; c++)
        rgba[c] = layer[c] + through * rgba[c];
    rgba[3] = 1 - (1 - layer[3]) * (1 - rgba[3]);
    if (isfinite(at) && through <= 0.5)
        *depth = at;
}

void vvi_raycast_ref(double rgba[4], double *depth, const vv_scene *scene, const vvi_raycast_state *state, int32_t x,
                     int32_t y)
{
    vvi_ref_ray rays[VVI_BLEND_VOLUMES];
    for (int c = 0; c < 4; c++)
        rgba[c] = 0;
    *depth = INFINITY;
    for (size_t i = 0; i < state->n_volumes; i++) {
        rays[i] = (vvi_ref_ray){.scene = scene, .volume = &state->volume[i]};
        vvi_lens_ray(&rays[i].origin, &rays[i].direction, &scene->lens, scene->width, scene->height, x + 0.5, y + 0.5);
    }
    if (vvi_raycast_is_plain(state))
        one_volume(rgba, depth, &rays[0]);
    else
        vvi_ref_blend(rgba, depth, scene, state, rays);
    for (size_t i = 0; i < state->n_volumes; i++)
        if (state->volume[i].layer)
            add_layer(rgba, depth, &rays[i]);
}
