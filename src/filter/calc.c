/* Calc: a formula of the values of several volumes at each sample. */
#include "core/cpu.h"
#include "core/expression.h"
#include "core/memory.h"
#include "filter/calc_kernel.h"
#include "filter/calc_table.h"
#include "grid/making.h"
#include "grid/same_grid.h"
#include "registry.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define ITEM_SAMPLES ((int64_t)1 << 16)

enum { INPUTS_MOST = 8, NAME_MOST = 63, ROW = VVI_EXPRESSION_ROW };

typedef struct calc_params {
    vv_object object;
    char *formula, *names;
    int type; /* vv_type */
    char *unit;
} calc_params;

static const char *const type_names[] = {"u8", "i8", "u16", "i16", "u32", "i32", "u64", "i64", "f32", "f64", NULL};

static const vv_property properties[] = {
    {VV_PROP(calc_params, formula), .kind = VV_KIND_STRING, .positional = true, .limited = true,
     .max = VVI_EXPRESSION_BYTES,
     .doc = "what each sample becomes, as in 'a - 0.5*b': volumes by their names, + - * / % ^, comparisons, && || !, "
            "?:, min max abs sqrt exp log sin where isnan ... (docs/filters.md lists them), pi, nan, inf; x y z is the "
            "place in the world, i j k the number of the sample"},
    {VV_PROP(calc_params, names), .kind = VV_KIND_STRING, .automatic = "a,b,c,...",
     .doc = "what the formula calls the volumes, in their order: ct,mask; NAME=FILE says it on the command line"},
    {VV_PROP(calc_params, type), .kind = VV_KIND_ENUM, .names = type_names, .def = VV_TYPE_F32,
     .doc = "sample type of the result; integers are rounded, and missing values become 0"},
    {VV_PROP(calc_params, unit), .kind = VV_KIND_STRING, .automatic = "unknown", .limited = true, .max = 15,
     .doc = "unit of the result's values"},
    {0},
};

static const vv_class calc_class = {
    .name = "calc",
    .doc = "parameters of calc",
    .size = sizeof(calc_params),
    .properties = properties,
};

/* What a formula may name: the volumes, then the place. */
static const char *const places[] = {"x", "y", "z", "i", "j", "k"};
enum { PLACES = sizeof places / sizeof places[0] };

typedef struct name_list {
    char own[INPUTS_MOST][NAME_MOST + 1];
    const char *all[INPUTS_MOST + PLACES];
} name_list;

static vv_status check_name(const name_list *l, size_t index)
{
    const char *name = l->own[index];
    for (size_t i = 0; i < PLACES; i++)
        if (strcmp(name, places[i]) == 0)
            return vv_fail(VV_E_ARGUMENT, "'%s' is the place of a sample in formulas; choose another name", name);
    for (size_t i = 0; i < index; i++)
        if (strcmp(name, l->own[i]) == 0)
            return vv_fail(VV_E_ARGUMENT, "two volumes are called '%s'; choose another name for one", name);
    return vvi_expression_check_name(name);
}

static vv_status read_names(name_list *l, const char *text, size_t n_inputs)
{
    vv_status st = VV_OK;
    size_t n = 0;
    for (const char *at = text ? text : ""; *at && n <= n_inputs; n++) {
        const size_t length = strcspn(at, ",");
        if (length > NAME_MOST)
            return vv_fail(VV_E_ARGUMENT, "a name has at most %d characters, found %zu", NAME_MOST, length);
        if (n < n_inputs) {
            memcpy(l->own[n], at, length);
            l->own[n][length] = 0;
            if ((st = check_name(l, n)) != VV_OK)
                return st;
        }
        at += length + (at[length] == ',');
    }
    if (text && *text && n != n_inputs)
        return vv_fail(VV_E_ARGUMENT, "names: expected %zu, one for each volume, found %s", n_inputs, text);
    for (size_t i = n; i < n_inputs; i++) {
        l->own[i][0] = (char)('a' + i);
        l->own[i][1] = 0;
    }
    return VV_OK;
}

static vv_status compile(vvi_expression **out, const calc_params *p, size_t n_inputs)
{
    name_list l;
    vv_status st;
    *out = NULL;
    if (n_inputs > INPUTS_MOST)
        return vv_fail(VV_E_ARGUMENT, "calc: takes at most %d volumes, found %zu", INPUTS_MOST, n_inputs);
    if ((st = read_names(&l, p->names, n_inputs)) != VV_OK)
        return vv_fail_in(st, "calc");
    for (size_t i = 0; i < n_inputs; i++)
        l.all[i] = l.own[i];
    memcpy(l.all + n_inputs, places, sizeof places);
    if ((st = vvi_expression_new(out, p->formula, l.all, n_inputs + PLACES)) != VV_OK)
        return vv_fail_in(st, "calc");
    for (size_t i = 1; i < n_inputs; i++) /* the first says where the result lies, too */
        if (!vvi_expression_uses(*out, i)) {
            vvi_expression_free(*out);
            *out = NULL;
            return vv_fail(VV_E_ARGUMENT, "calc: the formula does not use '%s'; leave that volume out", l.own[i]);
        }
    return VV_OK;
}

/* One of several components goes with each of them. */
static vv_status plan_components(vv_field_info *out, const vv_field_info *inputs, size_t n_inputs)
{
    size_t widest = 0;
    for (size_t i = 1; i < n_inputs; i++)
        widest = inputs[i].components > inputs[widest].components ? i : widest;
    out->components = inputs[widest].components;
    out->meaning = inputs[widest].meaning == VV_MEANING_VECTOR ? VV_MEANING_VECTOR : VV_MEANING_SCALAR;
    for (size_t i = 0; i < n_inputs; i++)
        if (inputs[i].components != 1 && inputs[i].components != out->components)
            return vv_fail(VV_E_ARGUMENT,
                           "calc: expected volumes of %d channels or of one, found one of %d; pick "
                           "some with 'volvis channel'",
                           out->components, inputs[i].components);
    return VV_OK;
}

static vv_status plan(vv_field_info *out, const vv_field_info *inputs, size_t n_inputs, const vv_object *params)
{
    const calc_params *p = (const calc_params *)params;
    vvi_expression *expression;
    vv_status st = compile(&expression, p, n_inputs);
    vvi_expression_free(expression);
    if (st != VV_OK)
        return st;
    *out = inputs[0];
    for (size_t i = 1; i < n_inputs; i++) {
        char name[32];
        snprintf(name, sizeof name, "volume number %zu", i + 1);
        if ((st = vvi_grid_alike(&inputs[0].grid, &inputs[i].grid, name)) != VV_OK)
            return vv_fail_in(st, "calc");
    }
    out->type = (vv_type)p->type;
    out->value_scale = 1;
    out->value_offset = 0;
    snprintf(out->value_unit, sizeof out->value_unit, "%s", p->unit ? p->unit : "");
    out->name[0] = 0;
    return plan_components(out, inputs, n_inputs);
}

typedef struct shared {
    vvi_making making;
    const vv_field_info *info;
    const vvi_expression *expression;
    const vvi_calc_table *table; /* NULL: samples are worked out one by one */
    const vvi_calc_kernels *kernels;
    const vv_field *const *inputs;
    size_t n_inputs;
    vv_job *job;
} shared;

/* Numbers `first` to `first` + n - 1 of row (j, k) of an item: samples one after the other, channels fastest. */
typedef struct piece {
    const vv_box *item;
    int64_t j, k;
    size_t first, n;
} piece;

static vv_status start(void **scratch_out, void *user, int worker)
{
    const shared *s = user;
    vvi_expression_rows *rows;
    const vv_status st = vvi_expression_rows_new(&rows, s->expression, s->job);
    *scratch_out = rows;
    return st;
}

static void finish(void *scratch, void *user)
{
    vvi_expression_rows_free(scratch);
}

/* Of an input. */
static const char *row_of(const shared *s, size_t input, const piece *p)
{
    const vv_brick *b = input ? &s->making.more_bricks[input - 1] : &s->making.brick;
    const int64_t *lo = p->item->lo;
    return (const char *)b->data + (lo[0] - b->box.lo[0]) * b->stride[0] +
           (lo[1] + p->j - b->box.lo[1]) * b->stride[1] + (lo[2] + p->k - b->box.lo[2]) * b->stride[2];
}

static void fill_values(double *row, const shared *s, size_t input, const piece *p)
{
    const vv_field_info *info = vv_field_get_info(s->inputs[input]);
    const char *in = row_of(s, input, p);
    const size_t each = vv_type_bytes(info->type), channels = (size_t)s->info->components;
    if (info->components == s->info->components) {
        s->kernels->load[info->type](row, in + p->first * each, p->n);
    } else {
        double single[ROW];
        const size_t sample = p->first / channels, last = (p->first + p->n - 1) / channels;
        vvi_samples_to_f64(single, in + sample * each, info->type, last - sample + 1);
        for (size_t i = 0; i < p->n; i++)
            row[i] = single[(p->first + i) / channels - sample];
    }
    if (info->value_scale != 1 || info->value_offset != 0)
        for (size_t i = 0; i < p->n; i++)
            row[i] = row[i] * info->value_scale + info->value_offset;
}

static void fill_place(double *row, const shared *s, size_t place, const piece *p)
{
    const vv_affine *m = &s->info->grid.index_to_world;
    const size_t channels = (size_t)s->info->components;
    const double j = (double)(p->item->lo[1] + p->j), k = (double)(p->item->lo[2] + p->k);
    const int a = (int)(place % 3);
    const double step = place < 3 ? (&m->axis[0].x)[a] : a == 0;
    const double begin =
        place < 3 ? (&m->origin.x)[a] + (&m->axis[1].x)[a] * j + (&m->axis[2].x)[a] * k : (a == 1) * j + (a == 2) * k;
    for (size_t i = 0; i < p->n; i++)
        row[i] = begin + step * (double)(p->item->lo[0] + (int64_t)((p->first + i) / channels));
}

static vv_status check_range(const double *values, const shared *s, const piece *p)
{
    const double lo = vvi_type_min(s->info->type), hi = vvi_type_max(s->info->type);
    for (size_t i = 0; i < p->n; i++)
        if (nearbyint(values[i]) < lo || nearbyint(values[i]) > hi)
            return vv_fail(VV_E_ARGUMENT,
                           "calc: the formula gives %.9g at sample %lld, %lld, %lld, but %s holds %.20g to %.20g: "
                           "choose another --type, or write clamp(..., lo, hi)",
                           values[i], (long long)(p->item->lo[0] + (int64_t)(p->first + i) / s->info->components),
                           (long long)(p->item->lo[1] + p->j), (long long)(p->item->lo[2] + p->k),
                           vv_type_name(s->info->type), lo, hi);
    return VV_OK;
}

static vv_status write_piece(char *out, vvi_expression_rows *rows, const shared *s, const piece *p)
{
    for (size_t n = 0; n < s->n_inputs + PLACES; n++) {
        double *row = vvi_expression_row(rows, n);
        if (row && n < s->n_inputs)
            fill_values(row, s, n, p);
        else if (row)
            fill_place(row, s, n - s->n_inputs, p);
    }
    const double *values = vvi_expression_run(rows, p->n);
    const vv_status st = vv_type_is_float(s->info->type) ? VV_OK : check_range(values, s, p);
    if (s->info->type != VV_TYPE_F32 || !s->kernels->store_f32(out, values, p->n)) /* that rounds, and no more */
        vvi_samples_from_f64(out, values, s->info->type, p->n);
    return st;
}

static vv_status item(void *scratch, void *user, size_t index)
{
    const shared *s = user;
    const vv_box box = vvi_slabs_item(&s->making.slabs, index);
    const size_t each = vv_type_bytes(s->info->type), n = (size_t)(box.n[0] * s->info->components);
    vv_status st = VV_OK;
    for (int64_t k = 0; k < box.n[2]; k++)
        for (int64_t j = 0; j < box.n[1]; j++) {
            const int64_t row = vvi_slabs_row(&s->making.slabs, &box, j, k) * s->info->components;
            const piece all = {.item = &box, .j = j, .k = k, .n = n};
            if (s->table)
                vvi_calc_table_row(s->making.out + (size_t)row * each, s->table, row_of(s, 0, &all), n);
            for (size_t at = 0; at < n && st == VV_OK && !s->table; at += ROW) {
                const piece p = {.item = &box, .j = j, .k = k, .first = at, .n = n - at < ROW ? n - at : ROW};
                st = write_piece(s->making.out + ((size_t)row + at) * each, scratch, s, &p);
            }
        }
    return st;
}

static vv_status run_box(vv_field **out, const vv_field *const *inputs, size_t n_inputs, const vv_object *params,
                         const vv_box *box, vv_job *job)
{
    static const vvi_work work = {.stage = "calc", .start = start, .item = item, .finish = finish};
    vv_field_info info, infos[INPUTS_MOST] = {0};
    vvi_expression *expression;
    vvi_calc_table *table;
    *out = NULL;
    for (size_t i = 0; i < n_inputs; i++)
        infos[i] = *vv_field_get_info(inputs[i]);
    vv_status st = plan(&info, infos, n_inputs, params);
    if (st != VV_OK || (st = compile(&expression, (const calc_params *)params, n_inputs)) != VV_OK)
        return st;
    shared s = {.making = {.in = inputs[0], .slabs = vvi_slabs_of(box, ITEM_SAMPLES)},
                .info = &info,
                .expression = expression,
                .kernels = vvi_calc_kernels_for(vvi_job_cpu(job)),
                .inputs = inputs,
                .n_inputs = n_inputs,
                .job = job};
    for (size_t i = 1; i < n_inputs; i++)
        s.making.more[i - 1] = inputs[i];
    st = vvi_calc_table_new(&table, expression, &infos[0], info.type, box->n[0] * box->n[1] * box->n[2], job);
    s.table = table;
    if (st == VV_OK)
        st = vvi_making_run(out, &s.making, &info, box, box, &work, &s, job);
    vvi_calc_table_free(table);
    vvi_expression_free(expression);
    return st;
}

static const vv_operand inputs_taken[] = {
    {"volume", VV_IS_FIELD, 1, INPUTS_MOST, "volumes that the formula names", .names = "names"},
    {0},
};

const vv_operation vvi_operation_calc = {
    .api = VV_OPERATION_API,
    .name = "calc",
    .component = "filter",
    .group = "values",
    .doc = "a formula of the values of one to eight volumes on one grid, at each sample; each channel separately",
    .example = "volvis calc 'a - 0.5*b' a=pre.nrrd b=post.nrrd -o change.nrrd",
    .params = &calc_class,
    .inputs = inputs_taken,
    .run_box = run_box,
    .plan = plan,
    .in_order = true,
};
