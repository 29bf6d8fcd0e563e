/* Rescale: values from one range to another, and from one type to another. */
#include "core/memory.h"
#include "grid/fill_value.h"
#include "grid/percentile.h"
#include "grid/rounding.h"
#include "grid/sample_map.h"
#include "registry.h"

#include <math.h>
#include <string.h>

typedef struct rescale_params {
    vv_object object;
    int type; /* 0: as it is; else vv_type + 1 */
    vv_numbers *from, *percentile, *to;
    bool clamp, keep_values;
    bool settled; /* no properties: see settle() */
    double window[2];
    vvi_fills fills;
} rescale_params;

static const char *const type_names[] = {"same", "u8",  "i8",  "u16", "i16", "u32",
                                         "i32",  "u64", "i64", "f32", "f64", NULL};

static const vv_property properties[] = {
    {VV_PROP(rescale_params, type), .kind = VV_KIND_ENUM, .names = type_names, .doc = "sample type of the result"},
    {VV_PROP(rescale_params, from), .kind = VV_KIND_NUMBERS, .columns = 1, .unit = "value",
     .automatic = "smallest and largest value",
     .doc = "two values that are mapped to the ends of the range `to`: 0..1500"},
    {VV_PROP(rescale_params, percentile), .kind = VV_KIND_NUMBERS, .columns = 1, .unit = "%", .automatic = "0..100",
     .doc = "`from` as percentiles of the samples of all time steps: 1..99.8 leaves 1 % below and 0.2 % above"},
    {VV_PROP(rescale_params, to), .kind = VV_KIND_NUMBERS, .columns = 1,
     .automatic = "the whole range of an integer type, 0..1 of a floating-point type",
     .doc = "two stored numbers: 0..255"},
    {VV_PROP(rescale_params, clamp), .kind = VV_KIND_BOOL, .def = 1,
     .doc = "values outside `from` become the nearer end of `to`; else they continue beyond it, and the type must "
            "hold them"},
    {VV_PROP(rescale_params, keep_values), .kind = VV_KIND_BOOL,
     .doc = "store the map in the file as scale and offset, so that values stay the same up to rounding"},
    {0},
};

static vv_status check_pair(const vv_numbers *pair, const char *name, const char *path)
{
    if (!pair || pair->n == 0)
        return VV_OK;
    if (pair->n != 2 || !isfinite(pair->v[0]) || !isfinite(pair->v[1]))
        return vv_fail(VV_E_ARGUMENT, "%s%s%s: two finite numbers are needed, as in 0,255; there are %zu",
                       path ? path : "", path && *path ? "." : "", name, pair->n);
    return VV_OK;
}

static bool given(const vv_numbers *pair)
{
    return pair && pair->n == 2;
}

static vv_status check(const vv_object *object, const char *path)
{
    const rescale_params *p = (const rescale_params *)object;
    vv_status st;
    if ((st = check_pair(p->from, "from", path)) != VV_OK ||
        (st = check_pair(p->percentile, "percentile", path)) != VV_OK || (st = check_pair(p->to, "to", path)) != VV_OK)
        return st;
    if (given(p->from) && given(p->percentile))
        return vv_fail(VV_E_ARGUMENT, "rescale: `from` and `percentile` set the same thing; give one of them");
    if (given(p->from) && p->from->v[0] == p->from->v[1])
        return vv_fail(VV_E_ARGUMENT, "rescale: the range `from` %g,%g is empty", p->from->v[0], p->from->v[1]);
    if (given(p->percentile) &&
        !(p->percentile->v[0] >= 0 && p->percentile->v[0] < p->percentile->v[1] && p->percentile->v[1] <= 100))
        return vv_fail(VV_E_ARGUMENT, "rescale: percentiles must be between 0 and 100 and ascending; they are %g,%g",
                       p->percentile->v[0], p->percentile->v[1]);
    if (p->keep_values && given(p->to) && p->to->v[0] == p->to->v[1])
        return vv_fail(VV_E_ARGUMENT, "rescale: values cannot be kept in the empty range `to` %g,%g", p->to->v[0],
                       p->to->v[1]);
    return VV_OK;
}

static const vv_class rescale_class = {
    .name = "rescale",
    .doc = "parameters of rescale",
    .size = sizeof(rescale_params),
    .properties = properties,
    .check = check,
};

typedef struct map {
    double from[2], to[2]; /* values, and stored numbers of the result */
    vvi_fills fills;       /* that the window leaves out */
    vvi_sample_map samples;
} map;

static void target_range(double to[2], const rescale_params *p, vv_type type)
{
    if (given(p->to)) {
        to[0] = p->to->v[0];
        to[1] = p->to->v[1];
    } else {
        to[0] = vv_type_is_float(type) ? 0 : vvi_type_min(type);
        to[1] = vv_type_is_float(type) ? 1 : vvi_type_max(type);
    }
}

/* One range for all components, so that colours and vectors keep their proportions. A component without a finite sample
 * has none. */
static void widen(double window[2], double lo, double hi, bool *any)
{
    if (isnan(lo))
        return;
    window[0] = *any ? fmin(window[0], lo) : lo;
    window[1] = *any ? fmax(window[1], hi) : hi;
    *any = true;
}

static vv_status whole_range(double window[2], const vv_field *field, bool *any, vv_job *job)
{
    double lo = INFINITY, hi = -INFINITY;
    const vv_status st = vvi_field_widen_range(&lo, &hi, field, job);
    if (lo <= hi)
        widen(window, lo, hi, any);
    return st;
}

/* Both percentiles are one value (most samples are the background): all would become one number. The other end is that
 * of all samples then. */
static void open_window(double window[2], const double whole[2], const rescale_params *p, vv_job *job)
{
    const double both = window[0];
    if (!(whole[0] < whole[1]))
        return;
    window[0] = both < whole[1] ? both : whole[0];
    window[1] = whole[1];
    vvi_log(job, VV_LOG_WARNING, "filter", "percentiles %g and %g are both %g; the window is %g to %g",
            p->percentile->v[0], p->percentile->v[1], both, window[0], window[1]);
}

/* A window that nobody gives is that of values: a fill is none, unless memory is too short to tell the others. */
static vv_status find_fill(vvi_fills *out, const vv_field *field, vv_job *job)
{
    vv_field *rest = NULL;
    char text[VVI_FILL_TEXT];
    *out = (vvi_fills){0};
    vv_status st = vv_field_get_info(field)->components == 1 ? vvi_fills_of(out, field, 0, job) : VV_OK;
    if (st != VV_OK || out->n == 0)
        return st;
    st = vvi_field_without_fills(&rest, field, 0, out, job);
    vv_field_release(rest);
    if (st != VV_E_MEMORY && st != VV_E_LIMIT)
        return st;
    vvi_fills_print(text, out);
    vvi_log(job, VV_LOG_WARNING, "rescale", "%s: no memory to leave them out of the window", text);
    out->n = 0;
    return VV_OK;
}

static void tell_fill(const vvi_fills *fills, vv_job *job)
{
    char text[VVI_FILL_TEXT];
    vvi_fills_print(text, fills);
    if (fills->n)
        vvi_log(job, VV_LOG_WARNING, "rescale", "%s: left out of the window, and missing in the result", text);
}

/* Puts the field without a fill in the place of one of yours. */
static vv_status leave_out(vv_field **field, const vvi_fills *fills, vv_job *job)
{
    vv_field *rest = NULL;
    const vv_status st = fills->n ? vvi_field_without_fills(&rest, *field, 0, fills, job) : VV_OK;
    if (rest) {
        vv_field_release(*field);
        *field = rest;
    }
    return st;
}

typedef struct others {
    const vv_field_series *all;
    const vvi_fills *fills;
} others;

static vv_status open_others(vv_field **out, void *user, size_t index, vv_job *job)
{
    const others *o = user;
    vv_status st = o->all->open(out, o->all->user, index, job);
    if (st != VV_OK || (st = leave_out(out, o->fills, job)) == VV_OK)
        return st;
    vv_field_release(*out);
    *out = NULL;
    return st;
}

static vv_status own_range(double from[2], const rescale_params *p, const vv_field *field, vv_job *job)
{
    bool any = false;
    double ends[2];
    vv_status st = VV_OK;
    if (!given(p->percentile))
        return whole_range(from, field, &any, job);
    for (int c = 0; c < vv_field_get_info(field)->components; c++) {
        if ((st = vvi_field_percentiles(ends, p->percentile->v, field, c, job)) != VV_OK)
            return st;
        widen(from, ends[0], ends[1], &any);
    }
    if (from[0] < from[1])
        return VV_OK;
    any = false;
    if ((st = whole_range(ends, field, &any, job)) == VV_OK && any)
        open_window(from, ends, p, job);
    return st;
}

static vv_status source_range(map *m, const rescale_params *p, const vv_field *field, vv_job *job)
{
    m->from[0] = m->from[1] = 0;
    if (given(p->from) || p->settled) {
        memcpy(m->from, p->settled ? p->window : p->from->v, sizeof m->from);
        m->fills = p->fills;
        return VV_OK;
    }
    vv_status st = find_fill(&m->fills, field, job);
    if (st != VV_OK)
        return st;
    tell_fill(&m->fills, job);
    vv_field *rest = vv_field_retain((vv_field *)(uintptr_t)field);
    if ((st = leave_out(&rest, &m->fills, job)) == VV_OK)
        st = own_range(m->from, p, rest, job);
    vv_field_release(rest);
    return st;
}

static bool looks(const vv_object *params)
{
    return !given(((const rescale_params *)params)->from);
}

/* A window that goes to itself: every value to the same number, in another type at most. */
static bool is_itself(const rescale_params *p)
{
    return given(p->from) && given(p->to) && p->from->v[0] == p->to->v[0] && p->from->v[1] == p->to->v[1] && !p->clamp;
}

static vv_status carry(vv_carry *carried, const vv_object *params)
{
    const rescale_params *p = (const rescale_params *)params;
    carried->new_values |= !p->keep_values && !is_itself(p);
    return VV_OK;
}

static vv_status settle_range(double window[2], const vv_field_series *fields, vv_job *job)
{
    bool any = false;
    vv_status st = VV_OK;
    for (size_t f = 0; f < fields->n && st == VV_OK; f++) {
        vv_field *field = NULL;
        if ((st = fields->open(&field, fields->user, f, job)) == VV_OK)
            st = whole_range(window, field, &any, job);
        vv_field_release(field);
    }
    return st;
}

static vv_status settle_percentiles(rescale_params *p, const vv_field_series *fields, vv_job *job)
{
    bool any = false;
    double ends[2];
    vv_field *first = NULL;
    vv_status st = fields->open(&first, fields->user, 0, job);
    if (st != VV_OK)
        return st;
    const int components = vv_field_get_info(first)->components;
    vv_field_release(first);
    for (int c = 0; c < components; c++) {
        if ((st = vvi_percentiles(ends, p->percentile->v, 2, fields, c, job)) != VV_OK)
            return st;
        widen(p->window, ends[0], ends[1], &any);
    }
    if (p->window[0] < p->window[1])
        return VV_OK;
    ends[0] = ends[1] = 0;
    if ((st = settle_range(ends, fields, job)) == VV_OK)
        open_window(p->window, ends, p, job);
    return st;
}

/* The first that has one says it for all. */
static vv_status settle_fill(vvi_fills *out, const vv_field_series *fields, vv_job *job)
{
    vv_status st = VV_OK;
    *out = (vvi_fills){0};
    for (size_t f = 0; f < fields->n && st == VV_OK && out->n == 0; f++) {
        vv_field *field = NULL;
        if ((st = fields->open(&field, fields->user, f, job)) == VV_OK)
            st = find_fill(out, field, job);
        vv_field_release(field);
    }
    if (st == VV_OK)
        tell_fill(out, job);
    return st;
}

/* From now on the window is that of all samples of the fields, whichever is rescaled. */
static vv_status settle(vv_object *params, const vv_field_series *fields, vv_job *job)
{
    rescale_params *p = (rescale_params *)params;
    vv_status st = check(params, "");
    p->window[0] = p->window[1] = 0;
    if (st == VV_OK)
        st = settle_fill(&p->fills, fields, job);
    others rest = {fields, &p->fills};
    const vv_field_series values = {open_others, &rest, fields->n};
    if (st == VV_OK)
        st = given(p->percentile) ? settle_percentiles(p, &values, job) : settle_range(p->window, &values, job);
    p->settled = st == VV_OK;
    return st;
}

/* A range of one value (a constant field) maps to the low end. */
static void complete(map *m, const rescale_params *p, const vv_field_info *info, vv_type type)
{
    target_range(m->to, p, type);
    const double width = m->from[1] - m->from[0];
    const double slope = width != 0 ? (m->to[1] - m->to[0]) / width : 0;
    m->samples = (vvi_sample_map){.gain = info->value_scale * slope,
                                  .shift = m->to[0] + (info->value_offset - m->from[0]) * slope,
                                  .lo = p->clamp ? fmin(m->to[0], m->to[1]) : -INFINITY,
                                  .hi = p->clamp ? fmax(m->to[0], m->to[1]) : INFINITY,
                                  .skipped = m->fills.n ? &m->fills : NULL,
                                  .holds = !p->clamp};
}

static vv_type result_type(const rescale_params *p, const vv_field_info *info)
{
    return p->type ? (vv_type)(p->type - 1) : info->type;
}

static void result_info(vv_field_info *out, const rescale_params *p, const vv_field_info *info, const map *m)
{
    *out = *info;
    out->type = result_type(p, info);
    out->value_scale = 1;
    out->value_offset = 0;
    if (p->keep_values) {
        const double scale = (m->from[1] - m->from[0]) / (m->to[1] - m->to[0]);
        out->value_scale = scale != 0 && isfinite(scale) ? scale : 1;
        out->value_offset = m->from[0] - m->to[0] * out->value_scale;
    } else if (m->from[0] != m->to[0] || m->from[1] != m->to[1]) {
        out->value_unit[0] = 0; /* the numbers no longer measure it */
    }
}

static vv_status refuse_labels(const vv_field_info *info, const rescale_params *p)
{
    const vv_type type = result_type(p, info);
    if (info->meaning != VV_MEANING_LABEL)
        return VV_OK;
    if (vv_type_is_float(type))
        return vv_fail(VV_E_ARGUMENT,
                       "type %s: labels are names, and whole numbers: give a type of integers, as in u16",
                       vv_type_name(type));
    if (is_itself(p))
        return VV_OK;
    return vv_fail(VV_E_UNSUPPORTED, "rescale: labels are names, not amounts, and a new range would rename them; "
                                     "`volvis convert --type` keeps them");
}

/* Numbers beyond the type would all become its end. */
static vv_status check_target(const rescale_params *p, vv_type type)
{
    if (!given(p->to) || vv_type_is_float(type) ||
        (fmin(p->to->v[0], p->to->v[1]) >= vvi_type_min(type) && fmax(p->to->v[0], p->to->v[1]) <= vvi_type_max(type)))
        return VV_OK;
    return vv_fail(VV_E_ARGUMENT, "rescale: the range `to` %g,%g is more than %s holds, %.20g to %.20g: choose another",
                   p->to->v[0], p->to->v[1], vv_type_name(type), vvi_type_min(type), vvi_type_max(type));
}

/* Without `from` the range is known only once the samples are read: then the source's own scale stands in the plan. */
static vv_status plan(vv_field_info *out, const vv_field_info *inputs, size_t n_inputs, const vv_object *params)
{
    (void)n_inputs;
    const rescale_params *p = (const rescale_params *)params;
    vv_status st;
    if ((st = refuse_labels(&inputs[0], p)) != VV_OK || (st = check(params, "")) != VV_OK ||
        (st = check_target(p, result_type(p, &inputs[0]))) != VV_OK)
        return st;
    map m = {.from = {inputs[0].value_offset, inputs[0].value_offset + inputs[0].value_scale}, .to = {0, 1}};
    if (given(p->from)) {
        memcpy(m.from, p->from->v, sizeof m.from);
        complete(&m, p, &inputs[0], result_type(p, &inputs[0]));
    }
    result_info(out, p, &inputs[0], &m);
    return VV_OK;
}

static bool is_whole(const vv_box *box, const vv_field *field)
{
    const vv_box all = vv_field_box(field);
    return memcmp(box->n, all.n, sizeof all.n) == 0;
}

/* The range is that of all samples, whatever the box: statistics are kept with the field. */
static vv_status run_box(vv_field **out, const vv_field *const *inputs, size_t n_inputs, const vv_object *params,
                         const vv_box *box, vv_job *job)
{
    (void)n_inputs;
    const rescale_params *p = (const rescale_params *)params;
    const vv_field_info *from = vv_field_get_info(inputs[0]);
    vv_field_info info;
    map m;
    vv_status st;
    *out = NULL;
    if ((st = refuse_labels(from, p)) != VV_OK || (st = check(params, "")) != VV_OK ||
        (st = check_target(p, result_type(p, from))) != VV_OK || (st = source_range(&m, p, inputs[0], job)) != VV_OK)
        return st;
    complete(&m, p, from, result_type(p, from));
    result_info(&info, p, from, &m);
    st = vvi_sample_map_run(out, inputs[0], &info, box, &m.samples, "rescale", job);
    if (st != VV_OK || !is_whole(box, inputs[0]) || (st = vvi_tell_rounded(*out, inputs[0], &m.samples, job)) == VV_OK)
        return st;
    vv_field_release(*out);
    *out = NULL;
    return st;
}

const vv_operation vvi_operation_rescale = {
    .api = VV_OPERATION_API,
    .name = "rescale",
    .component = "filter",
    .group = "values",
    .doc = "map a range of values, a window, to another range and type; for integer types, values are rounded and NaN "
           "becomes 0",
    .example = "volvis rescale head.nrrd -o head8.nrrd --type u8 --percentile 1..99.8",
    .params = &rescale_class,
    .inputs = VV_ONE_VOLUME,
    .run_box = run_box,
    .plan = plan,
    .carry = carry,
    .looks = looks,
    .settle = settle,
    .in_order = true,
};
