/* Vesselness (Frangi, Niessen, Vincken & Viergever 1998): how much the second derivatives around a sample look like
 * those of a tube, at the scale where they do most. */
#include "core/findings.h"
#include "core/memory.h"
#include "filter/hessian.h"
#include "filter/smoothed_samples.h"
#include "registry.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { SCALES_MOST = 32 };

typedef struct vesselness_params {
    vv_object object;
    double sigma, sigma_most;
    int64_t scales;
    bool dark;
    double alpha, beta, c;
    int output;
    bool settled; /* no property: see settle() */
    double found; /* c, of all samples */
} vesselness_params;

enum { VESSELNESS, SCALE, EIGENVALUES };
enum { ROW_SIGMA, ROW_SIGMA_MOST, ROW_SCALES, ROW_DARK, ROW_ALPHA, ROW_BETA, ROW_C, ROW_OUTPUT };

static const char *const output_names[] = {"vesselness", "scale", "eigenvalues", NULL};

#define OF_VESSELS .when = "output=vesselness|scale"

static const vv_property properties[] = {
    [ROW_SIGMA] = {VV_PROP(vesselness_params, sigma), .kind = VV_KIND_F64, .quantity = VV_Q_LENGTH, .limited = true,
                   .min = 0, .max = 1e12, .automatic = "the smallest spacing",
                   .doc = "standard deviation of the least smoothing, a length: 0.5mm, 1vox; a tube shows best with "
                          "0.7 times its radius"},
    [ROW_SIGMA_MOST] = {VV_PROP(vesselness_params, sigma_most), .kind = VV_KIND_F64, .quantity = VV_Q_LENGTH,
                        .limited = true, .min = 0, .max = 1e12, .automatic = "four times sigma", OF_VESSELS,
                        .doc = "standard deviation of the greatest smoothing, for the widest vessels"},
    [ROW_SCALES] = {VV_PROP(vesselness_params, scales), .kind = VV_KIND_I64, .limited = true, .min = 1,
                    .max = SCALES_MOST, .def = 4, OF_VESSELS,
                    .doc = "number of scales from the least to the greatest, each the same number of times the one "
                           "before; 1: sigma alone"},
    [ROW_DARK] = {VV_PROP(vesselness_params, dark), .kind = VV_KIND_BOOL, OF_VESSELS,
                  .doc = "vessels are darker than what is around them, not brighter"},
    [ROW_ALPHA] = {VV_PROP(vesselness_params, alpha), .kind = VV_KIND_F64, .limited = true, .min = 1e-6, .max = 1e6,
                   .def = 0.5, OF_VESSELS, .doc = "how round a vessel must be: greater values suppress plates"},
    [ROW_BETA] = {VV_PROP(vesselness_params, beta), .kind = VV_KIND_F64, .limited = true, .min = 1e-6, .max = 1e6,
                  .def = 0.5, OF_VESSELS, .doc = "how long a vessel must be: smaller values suppress blobs"},
    [ROW_C] = {VV_PROP(vesselness_params, c), .kind = VV_KIND_F64, .limited = true, .min = 1e-300, .max = 1e300,
               .unit = "value", .automatic = "half of the largest norm of all samples, scales and time steps",
               OF_VESSELS,
               .doc = "how strong a vessel must be: norm of the second derivatives, times sigma squared, above which "
                      "it stands out from the noise"},
    [ROW_OUTPUT] = {VV_PROP(vesselness_params, output), .kind = VV_KIND_ENUM, .names = output_names,
                    .doc = "vesselness, 0 to 1; the sigma where it is greatest (0: nowhere); or, of one channel at "
                           "sigma, the three eigenvalues, times sigma squared, the smallest size first"},
    {0},
};

static const vv_class vesselness_class = {
    .name = "vesselness",
    .doc = "parameters of vesselness",
    .size = sizeof(vesselness_params),
    .properties = properties,
};

static bool is_set(const vv_object *object, int row)
{
    return object->set >> row & 1;
}

/* Scales ---------------------------------------------------------------------------------------------------------- */

typedef struct scales {
    double sigma[SCALES_MOST];
    int n;
} scales;

static vv_status find_scales(scales *out, const vv_grid *grid, const vv_object *params)
{
    const vesselness_params *p = (const vesselness_params *)params;
    const double least = is_set(params, ROW_SIGMA) ? p->sigma : vv_grid_voxel(grid);
    const double most = is_set(params, ROW_SIGMA_MOST) ? p->sigma_most : 4 * least;
    vv_status st = VV_OK;
    out->n = p->output == EIGENVALUES ? 1 : (int)p->scales;
    if (!(least > 0))
        return vv_fail(VV_E_ARGUMENT, "vesselness: sigma is 0: second derivatives need some smoothing, as 1vox");
    if (out->n > 1 && most < least)
        return vv_fail(VV_E_ARGUMENT, "vesselness: sigma_most is %g and less than sigma, %g", most, least);
    for (int i = 0; i < out->n && st == VV_OK; i++) {
        out->sigma[i] = out->n > 1 ? least * pow(most / least, (double)i / (out->n - 1)) : least;
        st = vvi_smoothed_check(grid, out->sigma[i], "vesselness");
    }
    return st;
}

static int axes_of(const vv_grid *grid)
{
    return (grid->dims[0] > 1) + (grid->dims[1] > 1) + (grid->dims[2] > 1);
}

static vv_status plan(vv_field_info *out, const vv_field_info *inputs, size_t n_inputs, const vv_object *params)
{
    const vesselness_params *p = (const vesselness_params *)params;
    const vv_field_info *in = &inputs[0];
    scales s;
    *out = *in;
    if (in->meaning == VV_MEANING_LABEL)
        return vv_fail(VV_E_UNSUPPORTED, "vesselness: labels are names, not amounts, and have no derivatives");
    if (axes_of(&in->grid) < 2)
        return vv_fail(VV_E_UNSUPPORTED, "vesselness: %lldx%lldx%lld samples are a line, and vessels need two axes",
                       (long long)in->grid.dims[0], (long long)in->grid.dims[1], (long long)in->grid.dims[2]);
    if (p->output == EIGENVALUES && in->components != 1)
        return vv_fail(VV_E_UNSUPPORTED,
                       "vesselness: eigenvalues are of one channel, and there are %d; pick one with "
                       "`volvis channel`",
                       in->components);
    out->type = VV_TYPE_F32;
    out->meaning = VV_MEANING_SCALAR;
    out->value_scale = 1;
    out->value_offset = 0;
    if (p->output == EIGENVALUES)
        out->components = 3;
    else
        snprintf(out->value_unit, sizeof out->value_unit, "%s", p->output == SCALE ? in->grid.unit : "");
    return find_scales(&s, &in->grid, params);
}

/* What comes out of a sample's matrix ----------------------------------------------------------------------------- */

typedef struct shared {
    const vesselness_params *p;
    bool flat;                      /* two axes: the third eigenvalue is 0, and a vessel is a line in a plane */
    double plates, blobs, strength; /* 1 / (2 alpha^2) and so on */
    int components;
    double sigma;
    float *out, *best; /* best: of the scales before, where `out` holds which scale it is */
    double *norm;      /* by item */
} shared;

/* The smallest size first. */
static void values_by_size(double v[3], const double m[VVI_SYMMETRIC])
{
    vvi_symmetric_values(v, m);
    for (int a = 0; a < 2; a++)
        for (int b = 0; b < 2 - a; b++)
            if (fabs(v[b]) > fabs(v[b + 1])) {
                const double t = v[b];
                v[b] = v[b + 1];
                v[b + 1] = t;
            }
}

static double vessel(const shared *s, const double m[VVI_SYMMETRIC])
{
    const double trace = m[VVI_XX] + m[VVI_YY] + m[VVI_ZZ];
    double v[3];
    if (isnan(trace))
        return NAN;
    if (!(s->p->dark ? trace > 0 : trace < 0)) /* as the two largest ones are of one sign, so is the sum of all */
        return 0;
    values_by_size(v, m);
    const bool curved = s->p->dark ? v[2] > 0 && (s->flat || v[1] > 0) : v[2] < 0 && (s->flat || v[1] < 0);
    if (!curved)
        return 0;
    const double norm = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
    const double stands_out = -expm1(-norm * s->strength);
    if (s->flat)
        return exp(-(v[1] / v[2]) * (v[1] / v[2]) * s->blobs) * stands_out;
    const double plate = v[1] / v[2], blob = v[0] / v[1] * (v[0] / v[2]); /* squared: it is over sqrt(v1 v2) */
    return -expm1(-plate * plate * s->plates) * exp(-blob * s->blobs) * stands_out;
}

static void take_matrix(double m[VVI_SYMMETRIC], const vvi_hessian_row *row, int64_t i)
{
    for (int e = 0; e < VVI_SYMMETRIC; e++)
        m[e] = row->entry[e][i];
}

static void take_vessels(void *user, const vvi_hessian_row *row)
{
    const shared *s = user;
    double m[VVI_SYMMETRIC];
    for (int64_t i = 0; i < row->n; i++) {
        const int64_t at = (row->at + i) * s->components + row->component;
        float *most = s->best ? &s->best[at] : &s->out[at];
        take_matrix(m, row, i);
        const float v = (float)vessel(s, m);
        if (!(v > *most) && !isnan(v))
            continue;
        *most = v;
        if (s->best)
            s->out[at] = isnan(v) ? NAN : (float)s->sigma;
    }
}

static void take_eigenvalues(void *user, const vvi_hessian_row *row)
{
    const shared *s = user;
    double m[VVI_SYMMETRIC], v[3];
    for (int64_t i = 0; i < row->n; i++) {
        take_matrix(m, row, i);
        values_by_size(v, m);
        for (int a = 0; a < 3; a++)
            s->out[3 * (row->at + i) + a] = (float)v[a];
    }
}

static void take_norm(void *user, const vvi_hessian_row *row)
{
    const shared *s = user;
    double m[VVI_SYMMETRIC], most = s->norm[row->item];
    for (int64_t i = 0; i < row->n; i++) {
        take_matrix(m, row, i);
        const double norm = m[VVI_XX] * m[VVI_XX] + m[VVI_YY] * m[VVI_YY] + m[VVI_ZZ] * m[VVI_ZZ] +
                            2 * (m[VVI_XY] * m[VVI_XY] + m[VVI_XZ] * m[VVI_XZ] + m[VVI_YZ] * m[VVI_YZ]);
        most = norm > most ? norm : most;
    }
    s->norm[row->item] = most;
}

/* c, from all samples --------------------------------------------------------------------------------------------- */

/* Slices that are looked at together, for the memory that they take to be a quarter of what there is. */
static int64_t slices_at_once(const vv_field_info *info, double sigma, vv_job *job)
{
    const double room = job ? (double)vv_runtime_memory_limit(vv_job_runtime(job)) / 4 : INFINITY;
    vv_box box = {{0, 0, 0}, {info->grid.dims[0], info->grid.dims[1], info->grid.dims[2]}};
    while (box.n[2] > 1 && vvi_hessian_bytes(info, &box, sigma) > room)
        box.n[2] = (box.n[2] + 1) / 2;
    return box.n[2];
}

static vv_status widen_norm_box(double *most, const vv_field *in, const vv_box *box, double sigma, vv_job *job)
{
    const size_t n = vvi_hessian_items(box);
    shared s = {.norm = vvi_alloc_zeroed(job, n * sizeof(double), VVI_MEM_SCRATCH)};
    if (!s.norm)
        return vv_fail_memory(n * sizeof(double));
    const vv_status st = vvi_hessian_each(in, box, sigma, take_norm, &s, job);
    for (size_t i = 0; i < n && st == VV_OK; i++)
        *most = fmax(*most, s.norm[i]);
    vvi_free(s.norm);
    return st;
}

/* The greatest squared norm of all scales. */
static vv_status widen_norm(double *most, const vv_field *in, const vv_object *params, vv_job *job)
{
    const vv_field_info *info = vv_field_get_info(in);
    const vv_box all = vv_field_box(in);
    scales s;
    vv_status st = find_scales(&s, &info->grid, params);
    for (int i = 0; i < s.n && st == VV_OK; i++) {
        const int64_t step = slices_at_once(info, s.sigma[i], job);
        for (int64_t k = 0; k < all.n[2] && st == VV_OK; k += step) {
            vv_box box = all;
            box.lo[2] = k;
            box.n[2] = all.n[2] - k < step ? all.n[2] - k : step;
            st = widen_norm_box(most, in, &box, s.sigma[i], job);
        }
    }
    return st;
}

static void tell(double c, vv_job *job)
{
    vvi_find_number(job, "c", c);
    vvi_find_phrase(job, "c %.4g", c);
}

static bool looks(const vv_object *params)
{
    return ((const vesselness_params *)params)->output != EIGENVALUES && !is_set(params, ROW_C);
}

/* One c for all time steps, and for all channels: they keep their proportions. */
static vv_status settle(vv_object *params, const vv_field_series *fields, vv_job *job)
{
    vesselness_params *p = (vesselness_params *)params;
    double most = 0;
    vv_status st = VV_OK;
    for (size_t f = 0; f < fields->n && st == VV_OK; f++) {
        vv_field_info planned;
        vv_field *field = NULL;
        if ((st = fields->open(&field, fields->user, f, job)) == VV_OK &&
            (st = plan(&planned, vv_field_get_info(field), 1, params)) == VV_OK)
            st = widen_norm(&most, field, params, job);
        vv_field_release(field);
    }
    p->settled = st == VV_OK;
    p->found = 0.5 * sqrt(most);
    if (p->settled)
        tell(p->found, job);
    return st;
}

static vv_status find_c(double *out, const vesselness_params *p, const vv_field *in, const vv_box *box, vv_job *job)
{
    double most = 0;
    *out = p->settled ? p->found : p->c;
    if (p->settled || !looks(&p->object))
        return VV_OK;
    const vv_status st = widen_norm(&most, in, &p->object, job);
    *out = 0.5 * sqrt(most);
    if (st == VV_OK && box->lo[0] == 0 && box->lo[1] == 0 && box->lo[2] == 0)
        tell(*out, job);
    return st;
}

/* The result ------------------------------------------------------------------------------------------------------ */

static vv_status fill(shared *s, const vv_field *in, const vv_box *box, const scales *all, vv_job *job)
{
    const vesselness_params *p = s->p;
    double c;
    vv_status st = find_c(&c, p, in, box, job);
    s->plates = 0.5 / (p->alpha * p->alpha);
    s->blobs = 0.5 / (p->beta * p->beta);
    s->strength = c > 0 ? fmin(0.5 / c / c, 1e300) : 0; /* no c: there is no vessel in what is the same everywhere */
    for (int i = 0; i < all->n && st == VV_OK; i++) {
        s->sigma = all->sigma[i];
        st = vvi_hessian_each(in, box, s->sigma, p->output == EIGENVALUES ? take_eigenvalues : take_vessels, s, job);
    }
    return st == VV_OK ? vv_field_health(in) : st;
}

static vv_status run_box(vv_field **out, const vv_field *const *inputs, size_t n_inputs, const vv_object *params,
                         const vv_box *box, vv_job *job)
{
    const vv_field_info *from = vv_field_get_info(inputs[0]);
    shared s = {
        .p = (const vesselness_params *)params, .flat = axes_of(&from->grid) == 2, .components = from->components};
    vv_field_info info;
    scales all;
    uint64_t bytes;
    vv_field *field = NULL;
    void *data;
    *out = NULL;
    vv_status st = plan(&info, from, n_inputs, params);
    if (st != VV_OK || (st = find_scales(&all, &from->grid, params)) != VV_OK)
        return st;
    info.grid = vv_grid_crop(&info.grid, box);
    if ((st = vv_field_info_bytes(&bytes, &info)) != VV_OK)
        return st;
    const double halo = vvi_hessian_bytes(from, box, all.sigma[all.n - 1]);
    const uint64_t more = s.p->output == SCALE ? bytes : 0;
    if ((st = vvi_memory_plan(job, bytes + more + (uint64_t)fmin(halo, 1e18), "vesselness")) != VV_OK ||
        (st = vv_field_new_empty(&field, &data, &info, job)) != VV_OK)
        return st;
    memset(data, 0, (size_t)bytes);
    s.out = data;
    if (more && !(s.best = vvi_alloc_zeroed(job, (size_t)more, VVI_MEM_SCRATCH)))
        st = vv_fail_memory((size_t)more);
    if (st == VV_OK && (st = fill(&s, inputs[0], box, &all, job)) == VV_OK)
        *out = vv_field_retain(field);
    vvi_free(s.best);
    vv_field_release(field);
    return st;
}

const vv_operation vvi_operation_vesselness = {
    .api = VV_OPERATION_API,
    .name = "vesselness",
    .component = "filter",
    .group = "edges",
    .doc = "how much of a tube is at each sample, from the second derivatives at several scales (Frangi et al. 1998); "
           "each channel "
           "separately",
    .example = "volvis vesselness head.nrrd -o vessels.nrrd --sigma 1mm --sigma-most 3mm",
    .params = &vesselness_class,
    .inputs = VV_ONE_VOLUME,
    .run_box = run_box,
    .plan = plan,
    .looks = looks,
    .settle = settle,
};
