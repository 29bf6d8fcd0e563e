/* Joint histogram of values and lengths of gradients: figures, counts, plot. */
#include "core/units.h"
#include "grid/crc.h"
#include "measure.h"
#include "measure_plot.h"
#include "value.h"
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

/* "HU/mm"; of values without a unit "1/mm"; of lengths without one "1/voxel". */
static void gradient_unit(char out[32], const vv_field_info *info)
{
    const char *unit = info->grid.unit;
    const bool none = strcmp(unit, "voxels") == 0 || strcmp(unit, "units") == 0;
    snprintf(out, 32, "%.14s/%.*s", *info->value_unit ? info->value_unit : "1", (int)(strlen(unit) - none), unit);
}

static void put_figures(cli_measuring *m, const vv_joint *j)
{
    cli_figure f = {.key = "count", .label = "samples", .value = (double)j->count, .error = NAN};
    cli_figure_put(m->result, &f);
    if (j->unknown || m->result->csv)
        cli_figure_put(m->result, &(cli_figure){"unknown", "no gradient", (double)j->unknown, NAN, ""});
    gradient_unit(f.unit, vv_field_get_info(m->field));
    f.key = "gradient_mean";
    f.label = "mean gradient";
    f.value = j->gradient_mean;
    cli_figure_put(m->result, &f);
    f.key = "gradient_max";
    f.label = "longest";
    f.value = j->gradient_max;
    cli_figure_put(m->result, &f);
}

/* The counts as one number: a scene keeps no table. */
static void keep_table(cli_measuring *m, const vv_joint *j)
{
    const uint32_t sum = vvi_crc32(0, j->bins, j->n_values * j->n_gradients * sizeof *j->bins, false);
    const cli_figure kept[] = {{"value_lo", "", j->value_lo, NAN, ""},
                               {"value_hi", "", j->value_hi, NAN, ""},
                               {"gradient_hi", "", j->gradient_hi, NAN, ""},
                               {"beyond", "", (double)j->beyond, NAN, ""},
                               {"checksum", "", sum, NAN, ""}};
    for (size_t i = 0; i < sizeof kept / sizeof *kept; i++)
        cli_figure_keep(m->result, &kept[i]);
}

static vv_status put_json(cli_measuring *m, const vv_joint *j)
{
    vvi_result *json = &m->command->json;
    const vv_field_info *info = vv_field_get_info(m->field);
    char unit[32];
    gradient_unit(unit, info);
    vvi_result_open(json, "joint", '{');
    vvi_result_numbers(json, "values", (double[]){j->value_lo, j->value_hi}, 2);
    vvi_result_numbers(json, "gradients", (double[]){0, j->gradient_hi}, 2);
    vvi_result_string(json, "value_unit", info->value_unit);
    vvi_result_string(json, "gradient_unit", unit);
    vvi_result_integer(json, "n_values", (int64_t)j->n_values);
    vvi_result_integer(json, "n_gradients", (int64_t)j->n_gradients);
    vvi_result_unsigned(json, "beyond", j->beyond);
    vvi_result_open(json, "counts", '[');
    bool bad = false;
    for (size_t g = 0; g < j->n_gradients; g++) {
        vvi_text row = {0};
        for (size_t v = 0; v < j->n_values; v++)
            vvi_text_printf(&row, "%s%" PRIu64, v ? ", " : "[", j->bins[g * j->n_values + v]);
        vvi_text_add(&row, "]");
        bad |= row.bad;
        if (!row.bad)
            vvi_result_raw(json, NULL, row.s);
        vvi_text_free(&row);
    }
    vvi_result_close(json, ']');
    vvi_result_close(json, '}');
    return bad ? vv_fail_memory(j->n_values * j->n_gradients * 8) : VV_OK;
}

/* Bins that hold something. */
static void put_csv(vvi_text *out, const vv_joint *j)
{
    const double dv = (j->value_hi - j->value_lo) / (double)j->n_values, dg = j->gradient_hi / (double)j->n_gradients;
    for (size_t g = 0; g < j->n_gradients; g++)
        for (size_t v = 0; v < j->n_values; v++)
            if (j->bins[g * j->n_values + v])
                vvi_text_printf(out, "%.17g,%.17g,%.17g,%.17g,%" PRIu64 "\n", j->value_lo + (double)v * dv,
                                j->value_lo + (double)(v + 1) * dv, (double)g * dg, (double)(g + 1) * dg,
                                j->bins[g * j->n_values + v]);
}

/* Where a line holds it: gradients downwards, values to the right. */
static void put_table(vvi_text *out, const vv_joint *j)
{
    enum { MOST = 8 };
    const double dv = (j->value_hi - j->value_lo) / (double)j->n_values, dg = j->gradient_hi / (double)j->n_gradients;
    if (j->n_values > MOST || j->n_gradients > MOST)
        return;
    vvi_text_printf(out, "%14s", "from");
    for (size_t v = 0; v < j->n_values; v++)
        vvi_text_printf(out, " %11.5g", j->value_lo + (double)v * dv);
    vvi_text_add(out, "\n");
    for (size_t g = 0; g < j->n_gradients; g++) {
        vvi_text_printf(out, "%14.5g", (double)g * dg);
        for (size_t v = 0; v < j->n_values; v++)
            vvi_text_printf(out, " %11" PRIu64, j->bins[g * j->n_values + v]);
        vvi_text_add(out, "\n");
    }
}

static vv_status plot_joint(cli_measuring *m, const vv_joint *j, bool object)
{
    const vv_field_info *info = vv_field_get_info(m->field);
    const char *slash = strrchr(m->input.path, '/');
    char unit[32], x_label[96], y_label[96], title[160], subset[CLI_SUBSET_ROOM];
    gradient_unit(unit, info);
    const bool named = *info->name && strlen(info->name) <= 40; /* some names are a whole history */
    snprintf(x_label, sizeof x_label, "%s%s%s", named ? info->name : "value", *info->value_unit ? ", " : "",
             info->value_unit);
    snprintf(y_label, sizeof y_label, "length of the gradient, %s", unit);
    snprintf(title, sizeof title, "%.60s: %.9g samples, values and gradients", slash ? slash + 1 : m->input.path,
             (double)j->count);
    cli_plot_subset(subset, m, object);
    const vvi_plot_density density = {.counts = j->bins,
                                      .n_x = j->n_values,
                                      .n_y = j->n_gradients,
                                      .x_lo = j->value_lo,
                                      .x_hi = j->value_hi,
                                      .y_hi = j->gradient_hi,
                                      .label = "samples in a bin"};
    const vvi_plot_mark mark = {m->choice.lo, "threshold", true};
    const bool marked = m->o->iso && mark.x > j->value_lo && mark.x < j->value_hi;
    return cli_plot_write(m->command, &(vvi_plot){.title = title,
                                                  .subtitle = subset,
                                                  .x_label = x_label,
                                                  .y_label = y_label,
                                                  .density = &density,
                                                  .marks = &mark,
                                                  .n_marks = marked});
}

static vv_status parse_options(vv_joint_options *out, const cli_measuring *m)
{
    vv_joint_options_init(out, sizeof *out);
    out->component = m->choice.component;
    if (vv_object_is_set(&m->o->base, "bins"))
        out->n_values = out->n_gradients = m->o->bins;
    return m->o->range ? cli_range_parse(&out->value_lo, &out->value_hi, m->o->range) : VV_OK;
}

vv_status cli_measure_joint(cli_measuring *m)
{
    vv_joint_options o;
    vv_joint *j = NULL;
    vv_measure_options of = m->choice;
    vv_status st = parse_options(&o, m);
    if (st == VV_OK && of.seeded && (st = cli_measuring_choose(m)) == VV_OK)
        of = m->choice;
    if (m->o->iso && !of.seeded) /* a mark in the plot */
        of.lo = -INFINITY;
    const bool object = m->chosen && !(m->o->iso && !of.seeded);
    if (object || m->n_planes || m->o->box)
        o.of = &of;
    if (st != VV_OK || (st = vv_measure_joint(&j, m->field, &o, m->command->job)) != VV_OK)
        return st;
    keep_table(m, j);
    vvi_result_string(&m->command->json, "values_of", object ? m->object : "all samples");
    if (m->result->csv) {
        vvi_text_add(&m->command->text, "value_lo,value_hi,gradient_lo,gradient_hi,count\n");
        put_csv(&m->command->text, j);
    } else {
        cli_command_line(m->command, "values", "%s%s%s", object ? m->object : "of all samples",
                         strcmp(m->region, "all") ? " in " : "", strcmp(m->region, "all") ? m->region : "");
        put_figures(m, j);
        cli_command_line(m->command, "bins", "%zu of values from %.6g to %.6g, %zu of gradients from 0 to %.6g",
                         j->n_values, j->value_lo, j->value_hi, j->n_gradients, j->gradient_hi);
        put_table(&m->command->text, j);
    }
    st = put_json(m, j);
    if (st == VV_OK && cli_plot_wanted(m->command))
        st = plot_joint(m, j, object);
    vv_joint_free(j);
    return st;
}
