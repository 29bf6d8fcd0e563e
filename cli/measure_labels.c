/* The table of all labels. */
#include "core/units.h"
#include "grid/crc.h"
#include "measure.h"
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

/* What the file calls a label; "" where it does not. */
static const char *name_of(const cli_measuring *m, int64_t label)
{
    size_t n;
    const vv_label *names = vv_file_labels(m->input.file, &n);
    for (size_t i = 0; i < n; i++)
        if (names[i].value == label)
            return names[i].name;
    return "";
}

static void put_json(cli_json *json, const vv_label_measures *l, bool values, const char *name)
{
    cli_json_open(json, NULL, '{');
    cli_json_integer(json, "label", l->label);
    if (*name)
        cli_json_string(json, "name", name);
    cli_json_unsigned(json, "count", l->count);
    cli_json_number(json, "volume", l->volume);
    cli_json_numbers(json, "centroid", (double[]){l->centroid.x, l->centroid.y, l->centroid.z}, 3);
    cli_json_numbers(json, "box_lo", (double[]){l->bounds.lo.x, l->bounds.lo.y, l->bounds.lo.z}, 3);
    cli_json_numbers(json, "box_hi", (double[]){l->bounds.hi.x, l->bounds.hi.y, l->bounds.hi.z}, 3);
    if (values) {
        cli_json_number(json, "mean", l->mean);
        cli_json_number(json, "deviation", l->deviation);
        cli_json_number(json, "min", l->min);
        cli_json_number(json, "max", l->max);
        cli_json_number(json, "median", l->median);
        cli_json_number(json, "median_error", l->within);
    }
    cli_json_close(json, '}');
}

static void put_csv(vvi_text *out, const vv_label_measures *l, bool values)
{
    vvi_text_printf(out, "%" PRId64 ",%" PRIu64 ",%.12g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g", l->label,
                    l->count, l->volume, l->centroid.x, l->centroid.y, l->centroid.z, l->bounds.lo.x, l->bounds.lo.y,
                    l->bounds.lo.z, l->bounds.hi.x, l->bounds.hi.y, l->bounds.hi.z);
    if (values)
        vvi_text_printf(out, ",%.12g,%.12g,%.12g,%.12g,%.12g", l->mean, l->deviation, l->min, l->max, l->median);
    vvi_text_add(out, "\n");
}

static void keep_one(cli_result *result, int64_t label, const char *name, double value, const char *unit)
{
    char key[64];
    cli_figure f = {.key = key, .value = value, .error = NAN};
    snprintf(key, sizeof key, "label_%" PRId64 "_%s", label, name);
    snprintf(f.unit, sizeof f.unit, "%s", unit);
    cli_figure_keep(result, &f);
}

static void keep_vector(cli_result *result, int64_t label, const char *name, vv_vec3 v, const char *unit)
{
    const double parts[3] = {v.x, v.y, v.z};
    for (int a = 0; a < 3; a++) {
        char key[32];
        snprintf(key, sizeof key, "%s_%c", name, "xyz"[a]);
        keep_one(result, label, key, parts[a], unit);
    }
}

static void keep(cli_measuring *m, const vv_label_measures *l, const vv_field *values)
{
    char volume[32];
    const char *unit = vv_field_get_info(m->field)->grid.unit;
    cli_power_unit(volume, unit, 3);
    keep_one(m->result, l->label, "count", (double)l->count, "");
    keep_one(m->result, l->label, "volume", l->volume, volume);
    keep_vector(m->result, l->label, "centroid", l->centroid, unit);
    keep_vector(m->result, l->label, "box_lo", l->bounds.lo, unit);
    keep_vector(m->result, l->label, "box_hi", l->bounds.hi, unit);
    if (!values)
        return;
    const char *value = vv_field_get_info(values)->value_unit;
    keep_one(m->result, l->label, "mean", l->mean, value);
    keep_one(m->result, l->label, "deviation", l->deviation, value);
    keep_one(m->result, l->label, "min", l->min, value);
    keep_one(m->result, l->label, "max", l->max, value);
    keep_one(m->result, l->label, "median", l->median, value);
}

/* All figures, or of many labels their number and the checksum of the table, to digits that every processor finds. */
static void keep_all(cli_measuring *m, const vv_label_measures *l, size_t n, const vv_field *values)
{
    enum { MOST = 256 };
    uint32_t sum = 0;
    for (size_t i = 0; i < n && n <= MOST; i++)
        keep(m, &l[i], values);
    for (size_t i = 0; i < n && n > MOST; i++) {
        char row[320];
        int at = snprintf(row, sizeof row, "%" PRId64 ",%" PRIu64 ",%.6g,%.4g,%.4g,%.4g", l[i].label, l[i].count,
                          l[i].volume, l[i].centroid.x, l[i].centroid.y, l[i].centroid.z);
        if (values)
            at += snprintf(row + at, sizeof row - (size_t)at, ",%.6g,%.4g,%.6g,%.6g,%.6g", l[i].mean, l[i].deviation,
                           l[i].min, l[i].max, l[i].median);
        sum = vvi_crc32(sum, row, (size_t)at, false);
    }
    cli_figure_keep(m->result, &(cli_figure){"labels", "", (double)n, NAN, ""});
    if (n > MOST)
        cli_figure_keep(m->result, &(cli_figure){"checksum", "", sum, NAN, ""});
}

static void put_text(vvi_text *out, const vv_label_measures *l, bool values, const char *name)
{
    char centre[64];
    snprintf(centre, sizeof centre, "%.4g, %.4g, %.4g", l->centroid.x, l->centroid.y, l->centroid.z);
    vvi_text_printf(out, "%8" PRId64 " %12" PRIu64 " %12.6g  %-24s", l->label, l->count, l->volume, centre);
    if (values)
        vvi_text_printf(out, " %9.5g %9.4g %9.5g %9.5g %9.5g", l->mean, l->deviation, l->min, l->median, l->max);
    vvi_text_printf(out, "%s%s\n", *name ? "  " : "", name);
}

static void put_head(cli_measuring *m, bool values)
{
    const vv_grid *grid = &vv_field_get_info(m->field)->grid;
    char volume[32], heading[48];
    cli_power_unit(volume, grid->unit, 3);
    cli_json_string(&m->command->json, "unit", grid->unit);
    cli_json_string(&m->command->json, "volume_unit", volume);
    if (m->result->csv) {
        vvi_text_printf(&m->command->text, "label,count,volume,x,y,z,x_lo,y_lo,z_lo,x_hi,y_hi,z_hi%s\n",
                        values ? ",mean,deviation,min,max,median" : "");
        return;
    }
    snprintf(heading, sizeof heading, "centroid, %s", grid->unit);
    vvi_text_printf(&m->command->text, "%8s %12s %12s  %-24s", "label", "samples", volume, heading);
    if (values)
        vvi_text_printf(&m->command->text, " %9s %9s %9s %9s %9s", "mean", "deviation", "least", "median", "largest");
    vvi_text_add(&m->command->text, "\n");
}

static void put_table(cli_measuring *m, const vv_label_measures *l, size_t n, const vv_field *values)
{
    put_head(m, values != NULL);
    keep_all(m, l, n, values);
    cli_json_open(&m->command->json, "labels", '[');
    for (size_t i = 0; i < n; i++) {
        put_json(&m->command->json, &l[i], values != NULL, name_of(m, l[i].label));
        if (m->result->csv)
            put_csv(&m->command->text, &l[i], values != NULL);
        else
            put_text(&m->command->text, &l[i], values != NULL, name_of(m, l[i].label));
    }
    cli_json_close(&m->command->json, ']');
    if (n == 0 && !m->result->csv)
        vvi_text_add(&m->command->text, "there is no label but 0\n");
}

vv_status cli_measure_labels(cli_measuring *m)
{
    vv_label_measures *l = NULL;
    vv_field *values = NULL;
    size_t n = 0;
    vv_status st = VV_OK;
    if (vv_type_is_float(vv_field_get_info(m->field)->type))
        return vv_fail(VV_E_ARGUMENT,
                       "%s has real numbers, and labels are whole ones: convert it with --type, or measure "
                       "a threshold",
                       m->input.path);
    if (m->o->values)
        st = cli_measuring_beside(&values, m, &m->values_input, &m->values_stream, "volume of values", m->o->values);
    if (st == VV_OK)
        st = vv_measure_labels(&l, &n, m->field, values, (int)m->o->component, m->command->job);
    if (st == VV_OK)
        put_table(m, l, n, values);
    vv_label_measures_free(l);
    vv_field_release(values);
    return st;
}
