/* Values, gradients and colours of one volume along a ray, in double precision. Never removed and never made fast. */
#include "render/common/cubic_spline.h"
#include "render/common/texture_ref.h"
#include "render/raycast/raycast_ref.h"
#include <math.h>

static int64_t clamped(double x, int64_t hi)
{
    return x < 0 ? 0 : x > (double)hi ? hi : (int64_t)x;
}

/* The cell of a place, and the weights of its corners. */
typedef struct cell {
    int64_t corner[8][3];
    double weight[8];
} cell;

static void find_cell(cell *out, const vvi_lattice *g, bool nearest, const double p[3])
{
    int64_t c[3];
    double f[3];
    for (int a = 0; a < 3; a++) {
        const double x = fmin(fmax(p[a], 0), g->n[a] - 1);
        c[a] = nearest ? clamped(floor(p[a] + 0.5), g->n[a] - 1) : clamped(x, g->n[a] > 1 ? g->n[a] - 2 : 0);
        f[a] = nearest ? 0 : x - (double)c[a];
    }
    for (int b = 0; b < 8; b++) {
        out->weight[b] = 1;
        for (int a = 0; a < 3; a++) {
            out->weight[b] *= b >> a & 1 ? f[a] : 1 - f[a];
            out->corner[b][a] = c[a] + (b >> a & 1);
        }
    }
}

/* What is interpolated: stored numbers, or where `label` is one, 1 for that and 0 for others. */
typedef struct samples {
    const vvi_lattice *g;
    double label; /* NAN: stored numbers */
} samples;

static double sample_at(const samples *s, const int64_t p[3])
{
    const double v = vvi_lattice_number(s->g, p[0], p[1], p[2]);
    return isnan(s->label) ? v : v == s->label;
}

/* Central difference at a sample, one-sided at the border; axis -1: the sample itself. */
static double difference_at(const samples *s, const int64_t p[3], int axis)
{
    if (axis < 0)
        return sample_at(s, p);
    int64_t lo[3] = {p[0], p[1], p[2]}, hi[3] = {p[0], p[1], p[2]};
    lo[axis] -= lo[axis] > 0;
    hi[axis] += hi[axis] < s->g->n[axis] - 1;
    const int64_t width = hi[axis] - lo[axis];
    return width ? (sample_at(s, hi) - sample_at(s, lo)) / (double)width : 0;
}

static double interpolate(const samples *s, bool nearest, const double p[3], int axis)
{
    cell c;
    double sum = 0;
    find_cell(&c, s->g, nearest, p);
    for (int b = 0; b < 8; b++)
        if (c.weight[b] != 0)
            sum += c.weight[b] * difference_at(s, c.corner[b], axis);
    return sum;
}

/* The derivative of the trilinear value in the cell of a place; of nearest samples, at the sample. */
static double cell_difference(const vvi_lattice *g, bool nearest, const double p[3], int axis)
{
    double q[3], sum = 0;
    cell c;
    for (int a = 0; a < 3; a++)
        q[a] = nearest ? floor(p[a] + 0.5) : p[a];
    find_cell(&c, g, false, q);
    if (g->n[axis] < 2)
        return 0;
    for (int b = 0; b < 8; b++) {
        const int up = b | 1 << axis;
        const double weight = c.weight[b] + c.weight[up]; /* of the other two axes */
        if (b != up && weight != 0)
            sum += weight * (vvi_lattice_number(g, c.corner[up][0], c.corner[up][1], c.corner[up][2]) -
                             vvi_lattice_number(g, c.corner[b][0], c.corner[b][1], c.corner[b][2]));
    }
    return sum;
}

/* The label with the largest weight; of two the smaller. */
static double winning_label(const vvi_lattice *g, const double p[3])
{
    cell c;
    double best = -1, label = 0, v[8];
    find_cell(&c, g, false, p);
    for (int b = 0; b < 8; b++) /* a corner of no weight may lie beyond a flat axis */
        v[b] = c.weight[b] > 0 ? vvi_lattice_number(g, c.corner[b][0], c.corner[b][1], c.corner[b][2]) : NAN;
    for (int b = 0; b < 8; b++) {
        double sum = 0;
        for (int o = 0; o < 8; o++)
            sum += v[o] == v[b] ? c.weight[o] : 0;
        if (!isnan(v[b]) && (sum > best || (sum == best && v[b] < label))) {
            best = sum;
            label = v[b];
        }
    }
    return label;
}

static vv_vec3 world_point(const vvi_ref_ray *r, double t)
{
    return vvi_add(r->origin, vvi_scaled(r->direction, t));
}

static void index_point(double p[3], const vvi_ref_ray *r, double t)
{
    const vv_vec3 w = world_point(r, t);
    for (int a = 0; a < 3; a++) {
        const double *m = r->volume->ray.sampler.world_to_index[a];
        p[a] = m[0] * w.x + m[1] * w.y + m[2] * w.z + m[3];
    }
}

double vvi_ref_value(const vvi_ref_ray *r, double t)
{
    const vvi_march_volume *f = &r->volume->ray;
    double p[3];
    index_point(p, r, t);
    if (f->classifier.kind == VVI_CLASSIFY_LABELS)
        return winning_label(&f->sampler.lattice, p);
    return f->sampler.cubic ? vvi_cubic_at(&f->sampler.lattice, p, -1)
                            : interpolate(&(samples){&f->sampler.lattice, NAN}, f->sampler.nearest, p, -1);
}

vv_vec3 vvi_ref_gradient(const vvi_ref_ray *r, double t)
{
    const vvi_march_volume *f = &r->volume->ray;
    const vv_statistics *range = r->volume->actor->statistics;
    samples s = {&f->sampler.lattice, NAN};
    double p[3], g[3], w[3], scale = 1;
    index_point(p, r, t);
    if (f->classifier.kind ==
        VVI_CLASSIFY_LABELS) { /* as long as if the label were the largest value, and all else the least */
        s.label = winning_label(s.g, p);
        scale = (range->max - range->min) / r->volume->hold.value_scale;
    }
    for (int a = 0; a < 3; a++)
        g[a] = scale * (f->sampler.cubic ? vvi_cubic_at(s.g, p, a)
                        : f->sampler.cell_gradient && f->classifier.kind != VVI_CLASSIFY_LABELS
                            ? cell_difference(s.g, f->sampler.nearest, p, a)
                            : interpolate(&s, f->sampler.nearest, p, a));
    for (int a = 0; a < 3; a++) /* inverse transpose of index -> world */
        w[a] = f->sampler.world_to_index[0][a] * g[0] + f->sampler.world_to_index[1][a] * g[1] +
               f->sampler.world_to_index[2][a] * g[2];
    return vvi_vec(w[0], w[1], w[2]);
}

static void own_colors(double rgb[3], const vvi_paint *paint, const double p[3])
{
    const vvi_lattice *g = &paint->lattice;
    double sum[4] = {0};
    cell c;
    find_cell(&c, g, paint->nearest, p);
    for (int b = 0; b < 8; b++) {
        if (c.weight[b] <= 0)
            continue;
        const int64_t at = c.corner[b][2] * g->slice + c.corner[b][1] * g->row + c.corner[b][0];
        for (int i = 0; i < 4; i++)
            sum[i] += c.weight[b] * ((const uint16_t *)g->data)[4 * at + i];
    }
    for (int i = 0; i < 3; i++)
        rgb[i] = sum[3] > 0 ? sum[i] / sum[3] : 0;
}

static void mapped_colors(double rgb[3], const vvi_paint *paint, const vv_paint *from, vv_vec3 world)
{
    vv_affine inverse;
    vv_affine_invert(&inverse, from->index_to_world);
    const vv_vec3 index = vv_affine_point(inverse, world);
    const double p[3] = {index.x, index.y, index.z};
    for (int a = 0; a < 3; a++)
        if (p[a] < (double)paint->lo[a] || p[a] > (double)paint->hi[a])
            return;
    const double v = interpolate(&(samples){&paint->lattice, NAN}, paint->nearest, p, -1);
    if (isnan(v))
        return;
    const double row = v * (double)paint->entry_scale + (double)paint->entry_shift;
    const float *entry = paint->color + 4 * (size_t)fmin(fmax(row, 0), paint->n_entries - 1);
    for (int i = 0; i < 3 && entry[3] < VVI_PAINT_LEAVES; i++)
        rgb[i] = (double)entry[i];
}

void vvi_ref_paint(double rgb[3], const vvi_ref_ray *r, double t)
{
    const vvi_paint *paint = &r->volume->ray.paint;
    double p[3];
    index_point(p, r, t);
    if (paint->kind == VVI_PAINT_COLORS)
        own_colors(rgb, paint, p);
    else if (paint->kind == VVI_PAINT_MAP)
        mapped_colors(rgb, paint, &r->volume->actor->paint, world_point(r, t));
}

void vvi_ref_texture(double rgb[3], const vvi_ref_ray *r, double t)
{
    if (r->volume->ray.texture)
        vvi_texture_ref(rgb, &r->volume->texture, &r->volume->actor->texture, &r->scene->lens, r->scene->height,
                        world_point(r, t), t);
}
