/* What the values of a volume are seen as: tables for the kernels. */
#include "core/memory.h"
#include "render/common/transfer_fine.h"
#include "render/raycast/prepare.h"
#include "scene/resolve.h"
#include <math.h>
#include <string.h>

enum { GUARD_FLOATS = 16 };

static void put_row(vvi_raycast_volume *v, size_t i, const float rgbk[4], double length)
{
    const double depth = (double)rgbk[3] * length;
    v->alpha[i] = (float)-expm1(-depth);
    memcpy(v->color + 4 * i, rgbk, 3 * sizeof *v->color);
    memcpy(v->seen + 4 * i, rgbk, 3 * sizeof *v->seen);
    v->seen[4 * i + 3] = v->alpha[i];
    v->color[4 * i + 3] = (float)depth;
}

/* Where the rows begin that stand for this one, in place of its opacity and depth; how many, in place of its colour. */
static void put_split(vvi_raycast_volume *v, size_t i, uint32_t first, uint32_t parts)
{
    v->alpha[i] = (float)(first + VVI_ENTRY_SPLIT);
    v->color[4 * i] = v->seen[4 * i] = (float)parts;
    v->seen[4 * i + 3] = v->alpha[i];
    v->color[4 * i + 3] = -v->alpha[i];
}

/* Rows of the table for the kernels of one value a sample, each for a length, and behind them those of rows that are
 * split. Stored numbers
 * are looked up where they are: entry = stored * scale + shift is the table's place for their value. */
static vv_status copy_table(vvi_raycast_volume *v, const vvi_transfer_table *table, const vvi_transfer_fine *fine,
                            double length, vv_job *job)
{
    vvi_march_volume *f = &v->ray;
    const size_t rows = table->n + fine->n_rows;
    v->alpha = vvi_alloc(job, (rows + GUARD_FLOATS) * sizeof *v->alpha, VVI_MEM_SCRATCH);
    v->seen = vvi_alloc(job, rows * 4 * sizeof *v->seen, VVI_MEM_SCRATCH);
    v->color = vvi_alloc(job, (rows * 4 + GUARD_FLOATS) * sizeof *v->color, VVI_MEM_SCRATCH);
    if (!v->alpha || !v->seen || !v->color)
        return vv_fail_memory(rows * 9 * sizeof(float));
    for (size_t i = 0; i < rows; i++)
        put_row(v, i, i < table->n ? table->rgbk + 4 * i : fine->rgbk + 4 * (i - table->n), length);
    for (size_t i = 0; i < table->n && fine->n_rows; i++)
        if (fine->parts[i])
            put_split(v, i, fine->first[i], fine->parts[i]);
    v->n_rows = rows;
    f->classifier.has_split = fine->n_rows > 0;
    f->classifier.alpha = v->alpha;
    f->classifier.seen = v->seen;
    f->classifier.color = v->color;
    f->classifier.last_place = nextafterf((float)table->n, 0);
    f->classifier.entry_scale = (float)(v->hold.value_scale * table->scale);
    f->classifier.entry_shift = (float)(v->hold.value_offset * table->scale + table->offset + 0.5);
    return VV_OK;
}

/* The same for steps from one value to another. */
static vv_status copy_integral(vvi_raycast_volume *v, vvi_transfer_table *table, vv_job *job)
{
    vvi_classifier *c = &v->ray.classifier;
    v->integral = vvi_alloc_zeroed(job, sizeof *v->integral, VVI_MEM_SCRATCH);
    if (!v->integral)
        return vv_fail_memory(sizeof *v->integral);
    const vv_status st = vvi_transfer_integral_init(v->integral, table, &v->actor->classes, job);
    if (st != VV_OK)
        return st;
    for (size_t i = 0; i < 4 * v->integral->n; i++)
        v->integral->mean[i] = (float)((double)v->integral->mean[i] * v->ray.step);
    for (int i = 0; i < 4; i++)
        c->sum_unit[i] = (float)(v->integral->unit[i] * v->ray.step);
    c->kind = VVI_CLASSIFY_INTEGRATED;
    c->mean = v->integral->mean;
    c->sum = v->integral->sum;
    c->n_rows = (int32_t)v->integral->n;
    c->row_scale = (float)(v->hold.value_scale * table->scale);
    c->row_shift = (float)(v->hold.value_offset * table->scale + table->offset);
    return VV_OK;
}

/* The same by value and gradient. */
static vv_status copy_plane(vvi_raycast_volume *v, vvi_transfer_table *columns, vv_job *job)
{
    vvi_classifier *c = &v->ray.classifier;
    const vv_status st = vvi_transfer_plane_init(&v->plane, columns, &v->actor->classes, job);
    if (st != VV_OK)
        return st;
    const double unit = fabs(v->gradient_unit / v->hold.value_scale), top = v->plane.top * unit;
    for (size_t i = 0; i < (size_t)VVI_PLANE_SIDE * VVI_PLANE_SIDE * 4; i++)
        v->plane.rgbk[i] = (float)((double)v->plane.rgbk[i] * v->ray.step);
    c->kind = VVI_CLASSIFY_PLANE;
    c->plane = v->plane.rgbk;
    c->plane_any = v->plane.any;
    c->plane_scale = (float)(v->hold.value_scale * columns->scale);
    c->plane_shift = (float)(v->hold.value_offset * columns->scale + columns->offset);
    c->plane_gradient = top > 0 ? (float)fmin((VVI_PLANE_SIDE - 1) / top, 1e30) : 1e30f;
    return VV_OK;
}

/* How far it is from node i to where opacity has fallen to half of the node's; INFINITY: nowhere within `most`. */
static double half_width(const vv_classification *c, size_t i, int way, double most)
{
    const double *node = c->opacity, half = node[2 * i + 1] / 2;
    for (size_t j = i; way < 0 ? j > 0 : j + 1 < c->n_opacity; j += (size_t)way) {
        const double *a = node + 2 * j, *b = node + 2 * (j + (size_t)way);
        if (b[1] <= half) {
            const double share = a[1] > b[1] ? (a[1] - half) / (a[1] - b[1]) : 0;
            return fabs(a[0] + share * (b[0] - a[0]) - node[2 * i]);
        }
        if (fabs(b[0] - node[2 * i]) > most)
            break;
    }
    return INFINITY;
}

/* Whether opacity has a peak that steps from one value to another often miss, so that more rays alone do not help: at
 * half of its height narrower than a ninth of the values. Measured in docs/decisions/0030-narrow-peaks.md. */
static bool has_narrow_peak(const vv_actor *actor)
{
    const vv_classification *c = &actor->classes;
    const double narrow = (actor->statistics->max - actor->statistics->min) / 9;
    for (size_t i = 0; i < c->n_opacity; i++)
        if (c->opacity[2 * i + 1] > 0 && half_width(c, i, -1, narrow) + half_width(c, i, 1, narrow) < narrow)
            return true;
    return false;
}

static bool wants_integral(const vvi_raycast_volume *v, const vv_scene *scene)
{
    const vv_actor *actor = v->actor;
    const vvi_raycast_params *p = v->params;
    if (p->mode != VV_RAY_COMPOSITE || actor->classes.kind != VV_SEGMENT_TRANSFER || actor->nearest)
        return false;
    return vv_object_is_set(&p->base, "preintegrated")
               ? p->preintegrated
               : scene->quality == VV_QUALITY_REFERENCE ||
                     (scene->quality > VV_QUALITY_DRAFT && has_narrow_peak(actor));
}

/* Opacity that fades with the gradient. */
static void find_modulation(vvi_raycast_volume *v)
{
    const vv_classification *c = &v->actor->classes;
    if (!(c->gradient_power > 0))
        return;
    const double reference = c->gradient_reference * fabs(v->gradient_unit / v->hold.value_scale);
    v->ray.classifier.modulate_scale = reference > 0 ? (float)fmin(1 / reference, 1e30) : 1e30f;
    v->ray.classifier.modulate_power = (float)c->gradient_power;
}

vv_status vvi_raycast_classify(vvi_raycast_volume *v, vvi_transfer_table *table, const vv_scene *scene, vv_job *job)
{
    const vv_actor *actor = v->actor;
    const vv_field_info *info = vv_field_get_info(actor->field);
    const bool composite = v->params->mode == VV_RAY_COMPOSITE;
    const bool labels = actor->classes.kind == VV_SEGMENT_LABELS;
    const double length = v->layer ? actor->classes.opacity_length : v->ray.step; /* a layer is seen once */
    double lo, hi;
    size_t n;
    if (composite)
        find_modulation(v);
    if (composite && actor->classes.n_regions)
        return copy_plane(v, table, job);
    vvi_transfer_fine fine = {0};
    vv_status st = vvi_transfer_domain(&lo, &hi, &n, &actor->classes, info, actor->statistics);
    if (st != VV_OK)
        return st;
    n = actor->nearest || labels ? n : vvi_transfer_finer(n, lo, hi, info);
    if ((st = vvi_transfer_table_init(table, &actor->classes, lo, hi, n, job)) == VV_OK &&
        actor->classes.kind == VV_SEGMENT_TRANSFER)
        st = vvi_transfer_fine_init(&fine, table, &actor->classes, length, job);
    if (st == VV_OK)
        st = copy_table(v, table, &fine, length, job);
    vvi_transfer_fine_finish(&fine);
    if (st != VV_OK)
        return st;
    if (composite && labels && !actor->nearest) {
        v->ray.classifier.kind = VVI_CLASSIFY_LABELS;
        v->ray.classifier.label_range = (float)(vvi_actor_voxel(actor) / v->gradient_unit);
    }
    return wants_integral(v, scene) ? copy_integral(v, table, job) : VV_OK;
}

bool vvi_raycast_needs_more(const vvi_raycast_volume *v)
{
    const vvi_march_volume *f = &v->ray;
    return f->classifier.kind != VVI_CLASSIFY_TABLE || f->classifier.modulate_power > 0 || f->sampler.cubic;
}

void vvi_raycast_find_projection(vvi_raycast_volume *v, const vvi_raycast_params *p)
{
    const vv_actor *actor = v->actor;
    const int64_t *n = vv_field_get_info(actor->field)->grid.dims;
    vvi_march_volume *f = &v->ray;
    const double scale = v->hold.value_scale, offset = v->hold.value_offset;
    const double threshold = vv_object_is_set(&p->base, "threshold") ? p->threshold : actor->iso;
    vv_vec3 corner = {0, 0, 0}; /* the longest of the four diagonals */
    double longest = 0;
    for (int c = 0; c < 4; c++) {
        for (int a = 0; a < 3; a++) {
            const double side = (double)(n[a] > 1 ? n[a] - 1 : 1) * (c >> a & 1 ? -1 : 1);
            const vv_vec3 edge = vvi_scaled(actor->index_to_world.axis[a], side);
            corner = a ? vvi_add(corner, edge) : edge;
        }
        longest = fmax(longest, vvi_length(corner));
    }
    /* a negative scale turns the order of stored numbers round */
    f->projection.sign = (p->mode == VV_RAY_MINIMUM) == (scale < 0) ? 1 : -1;
    f->projection.threshold = (float)((threshold - offset) / scale) * f->projection.sign;
    f->projection.stored_zero = p->mode == VV_RAY_SUM ? (float)(-offset / scale) : 0;
    f->projection.over_longest = p->mode == VV_RAY_SUM;
    f->projection.longest = (float)(longest / f->step);
    f->projection.opacity = (float)actor->layer.opacity;
}

void vvi_raycast_find_solid(vvi_raycast_volume *v, const vvi_raycast_params *p)
{
    const vv_actor *actor = v->actor;
    vvi_march_volume *f = &v->ray;
    double from, to;
    vvi_raycast_solid(&from, &to, p, actor);
    const double a = (from - v->hold.value_offset) / v->hold.value_scale;
    const double b = (to - v->hold.value_offset) / v->hold.value_scale;
    f->solid.lo = (float)fmin(a, b);
    f->solid.hi = (float)fmax(a, b);
    memcpy(f->solid.color, actor->color, sizeof f->solid.color);
}
