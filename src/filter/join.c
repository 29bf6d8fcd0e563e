/* Join: volumes of one grid, and series of them, as the time steps of one series. */
#include "grid/field.h"
#include "grid/field_copy.h"
#include "grid/same_grid.h"
#include "io/header_keys.h"
#include "registry.h"

#include <stdio.h>
#include <string.h>

enum { INPUTS_MOST = 64, NAME_ROOM = 64 };

typedef struct join_params {
    vv_object object;
    char *names, *period_unit;
    double period;
} join_params;

static const vv_property properties[] = {
    {VV_PROP(join_params, period), .kind = VV_KIND_F64, .unit = "time", .limited = true, .min = 1e-12, .max = 1e12,
     .automatic = "as the first volume says", .doc = "time from one step to the next, in --period-unit"},
    {VV_PROP(join_params, period_unit), .kind = VV_KIND_STRING, .automatic = "as the first volume says",
     .doc = "what the period is measured in: s, ms, us, min, h"},
    {VV_PROP(join_params, names), .kind = VV_KIND_STRING, .automatic = "none",
     .doc = "what the volumes are called where they do not fit: pre,post; NAME=FILE says it on the command line"},
    {0},
};

static const vv_class join_class = {
    .name = "join",
    .doc = "parameters of join",
    .size = sizeof(join_params),
    .properties = properties,
};

/* "volume 'post'", "volume number 2". */
static void name_input(char out[NAME_ROOM], const char *names, size_t index)
{
    for (size_t i = 0; i < index && names; i++) {
        names = strchr(names, ',');
        names = names ? names + 1 : NULL;
    }
    if (names && *names)
        snprintf(out, NAME_ROOM, "volume '%.*s'", (int)(strcspn(names, ",") < 40 ? strcspn(names, ",") : 40), names);
    else
        snprintf(out, NAME_ROOM, "volume number %zu", index + 1);
}

static vv_status fail(const char *name, const char *what, const char *expected, const char *found, const char *advice)
{
    return vv_fail(VV_E_ARGUMENT, "join: the %s: expected %s %s, as the first has, found %s%s", name, what, expected,
                   found, advice);
}

static vv_status check_samples(const vv_field_info *a, const vv_field_info *b, const char *name)
{
    static const char as_values[] = "; 'volvis convert IT -o OUT --type f32' makes values of both";
    char expected[80], found[80];
    if (a->components != b->components) {
        snprintf(expected, sizeof expected, "%d", a->components);
        snprintf(found, sizeof found, "%d", b->components);
        return fail(name, "channels:", expected, found, "");
    }
    if (a->type != b->type)
        return fail(name, "type", vv_type_name(a->type), vv_type_name(b->type), as_values);
    if (a->value_scale != b->value_scale || a->value_offset != b->value_offset) {
        snprintf(expected, sizeof expected, "%.9g * stored + %.9g", a->value_scale, a->value_offset);
        snprintf(found, sizeof found, "%.9g * stored + %.9g", b->value_scale, b->value_offset);
        return fail(name, "values of", expected, found, as_values);
    }
    if (strcmp(a->value_unit, b->value_unit) != 0)
        return fail(name, "values in", a->value_unit[0] ? a->value_unit : "no unit",
                    b->value_unit[0] ? b->value_unit : "no unit", "");
    if (a->meaning != b->meaning)
        return fail(name, "samples that are", vvi_meaning_name(a->meaning), vvi_meaning_name(b->meaning), "");
    return VV_OK;
}

static void set_period(vv_field_info *out, const vv_object *params)
{
    const join_params *p = (const join_params *)params;
    if (vv_object_is_set(params, "period"))
        out->frame_step = p->period;
    if (p->period_unit && *p->period_unit)
        snprintf(out->frame_unit, sizeof out->frame_unit, "%s", p->period_unit);
}

static vv_status check_period(const vv_field_info *info, const vv_object *params)
{
    const join_params *p = (const join_params *)params;
    if (p->period_unit && strlen(p->period_unit) >= sizeof info->frame_unit)
        return vv_fail(VV_E_ARGUMENT, "join: period_unit: '%.40s' is no unit of time; expected s, ms, us, min or h",
                       p->period_unit);
    if (p->period_unit && *p->period_unit && !vv_object_is_set(params, "period") && !(info->frame_step != 0))
        return vv_fail(VV_E_ARGUMENT, "join: period_unit: the first volume says no period; give it with period");
    return VV_OK;
}

/* Of all that are joined, or of one that is under way. */
static vv_status plan(vv_field_info *out, const vv_field_info *inputs, size_t n_inputs, const vv_object *params)
{
    vv_status st = check_period(&inputs[0], params);
    *out = inputs[0];
    for (size_t i = 1; i < n_inputs && st == VV_OK; i++) {
        char name[NAME_ROOM];
        name_input(name, ((const join_params *)params)->names, i);
        if ((st = vvi_grid_alike(&inputs[0].grid, &inputs[i].grid, name)) != VV_OK)
            st = vv_fail_in(st, "join");
        else
            st = check_samples(&inputs[0], &inputs[i], name);
        out->n_frames += inputs[i].n_frames;
    }
    set_period(out, params);
    return st;
}

/* The samples are what they were; only the time is another. */
static vv_status retell(vv_field **out, const vv_field *field, const vv_object *params)
{
    vv_field_info info = *vv_field_get_info(field);
    set_period(&info, params);
    return vvi_field_relabel(out, field, &info);
}

static vv_status run(vv_field **out, const vv_field *const *inputs, size_t n_inputs, const vv_object *params,
                     vv_job *job)
{
    return retell(out, inputs[0], params);
}

static vv_status run_box(vv_field **out, const vv_field *const *inputs, size_t n_inputs, const vv_object *params,
                         const vv_box *box, vv_job *job)
{
    vv_field *copy;
    *out = NULL;
    vv_status st = vvi_field_copy_box(&copy, inputs[0], box, job);
    if (st != VV_OK)
        return st;
    st = retell(out, copy, params);
    vv_field_release(copy);
    return st;
}

static const vv_operand inputs_taken[] = {
    {"volume", VV_IS_FIELD, 2, INPUTS_MOST, "volumes and series whose time steps follow each other", .names = "names"},
    {0},
};

const vv_operation vvi_operation_join = {
    .api = VV_OPERATION_API,
    .name = "join",
    .component = "filter",
    .doc = "volumes on one grid, or series of them, as the time steps of one series, in their order",
    .example = "volvis join pre.nrrd post.nrrd -o series.nrrd --period 2.5 --period-unit s",
    .params = &join_class,
    .inputs = inputs_taken,
    .run = run,
    .run_box = run_box,
    .plan = plan,
    .carry = vv_carry_values,
    .in_order = true,
    .joins = true,
    .group = "channels",
};
