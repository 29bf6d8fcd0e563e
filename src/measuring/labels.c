/* The table of all labels. */
#include "core/units.h"
#include "grid/crc.h"
#include "grid/label_id.h"
#include "grid/true_values.h"
#include "measure.h"
#include "surface/clip.h"
#include "surface/labels.h"
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <volvis/measure_mesh.h>

#define SMOOTH_AREA 0.065 /* how far smooth borders are off, by balls and turned boxes of 5 to 20 voxels */

/* Of all rows. */
typedef struct shape {
    bool is_unsigned, values;
} shape;

/* What the file calls a label; "" where it does not. */
static const char *name_of(const cli_measuring *m, vv_label_id label)
{
    size_t n;
    const vv_label *names = vv_file_labels(m->input.file, &n);
    for (size_t i = 0; i < n; i++)
        if (names[i].value == label)
            return names[i].name;
    return "";
}

static void put_json(vvi_result *json, const vv_label_measures *l, const shape *s, const char *name)
{
    vvi_result_open(json, NULL, '{');
    vvi_result_label(json, "label", l->label, s->is_unsigned);
    if (*name)
        vvi_result_string(json, "name", name);
    vvi_result_unsigned(json, "count", l->count);
    vvi_result_number(json, "volume", l->volume);
    vvi_result_number(json, "volume_error", l->volume_error);
    vvi_result_number(json, "area", l->area);
    vvi_result_number(json, "area_error", l->area_error);
    vvi_result_numbers(json, "centroid", (double[]){l->centroid.x, l->centroid.y, l->centroid.z}, 3);
    vvi_result_numbers(json, "box_lo", (double[]){l->bounds.lo.x, l->bounds.lo.y, l->bounds.lo.z}, 3);
    vvi_result_numbers(json, "box_hi", (double[]){l->bounds.hi.x, l->bounds.hi.y, l->bounds.hi.z}, 3);
    if (s->values) {
        vvi_result_number(json, "mean", l->mean);
        vvi_result_number(json, "deviation", l->deviation);
        vvi_result_number(json, "min", l->min);
        vvi_result_number(json, "max", l->max);
        vvi_result_number(json, "median", l->median);
    }
    vvi_result_close(json, '}');
}

/* In quotes, and those in it twice (RFC 4180). */
static void put_csv_name(vvi_text *out, const char *name)
{
    const char *quote;
    vvi_text clean = {0};
    vvi_text_add_clean(&clean, name);
    vvi_text_add(out, ",");
    if (clean.n) {
        vvi_text_add(out, "\"");
        for (name = clean.s; (quote = strchr(name, '"')); name = quote + 1)
            vvi_text_printf(out, "%.*s\"\"", (int)(quote - name), name);
        vvi_text_printf(out, "%s\"", name);
    }
    out->bad |= clean.bad;
    vvi_text_free(&clean);
}

/* units: of every row. */
static void put_csv(vvi_text *out, const vv_label_measures *l, const shape *s, const char *units, const char *name)
{
    char digits[VVI_LABEL_DIGITS];
    vvi_text_printf(out, "%s,%" PRIu64 ",%.17g,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g",
                    vvi_label_print(digits, l->label, s->is_unsigned), l->count, l->volume, l->centroid.x,
                    l->centroid.y, l->centroid.z, l->bounds.lo.x, l->bounds.lo.y, l->bounds.lo.z, l->bounds.hi.x,
                    l->bounds.hi.y, l->bounds.hi.z);
    if (s->values)
        vvi_text_printf(out, ",%.17g,%.17g,%.17g,%.17g,%.17g", l->mean, l->deviation, l->min, l->max, l->median);
    vvi_text_printf(out, ",%.17g,%.17g,%.17g", l->area, l->area_error, l->volume_error);
    vvi_text_add(out, units);
    put_csv_name(out, name);
    vvi_text_add(out, "\n");
}

/* Figures of one label. */
typedef struct labelled {
    cli_result *result;
    char digits[VVI_LABEL_DIGITS];
} labelled;

static void keep_one(const labelled *to, const char *name, double value, double error, const char *unit)
{
    char key[64];
    cli_figure f = {.key = key, .value = value, .error = error};
    snprintf(key, sizeof key, "label_%s_%s", to->digits, name);
    snprintf(f.unit, sizeof f.unit, "%s", unit);
    cli_figure_keep(to->result, &f);
}

static void keep_vector(const labelled *to, const char *name, vv_vec3 v, const char *unit)
{
    const double parts[3] = {v.x, v.y, v.z};
    for (int a = 0; a < 3; a++) {
        char key[32];
        snprintf(key, sizeof key, "%s_%c", name, "xyz"[a]);
        keep_one(to, key, parts[a], NAN, unit);
    }
}

static void keep(cli_measuring *m, const vv_label_measures *l, const vv_field *values)
{
    char volume[32], area[32];
    const vv_field_info *info = vv_field_get_info(m->field);
    const char *unit = info->grid.unit;
    labelled to = {.result = m->result};
    vvi_label_print(to.digits, l->label, vvi_label_is_unsigned(info->type));
    cli_power_unit(volume, unit, 3);
    cli_power_unit(area, unit, 2);
    keep_one(&to, "count", (double)l->count, NAN, "");
    keep_one(&to, "volume", l->volume, l->volume_error, volume);
    keep_one(&to, "area", l->area, l->area_error, area);
    keep_vector(&to, "centroid", l->centroid, unit);
    keep_vector(&to, "box_lo", l->bounds.lo, unit);
    keep_vector(&to, "box_hi", l->bounds.hi, unit);
    if (!values)
        return;
    const char *value = vv_field_get_info(values)->value_unit;
    keep_one(&to, "mean", l->mean, NAN, value);
    keep_one(&to, "deviation", l->deviation, NAN, value);
    keep_one(&to, "min", l->min, NAN, value);
    keep_one(&to, "max", l->max, NAN, value);
    keep_one(&to, "median", l->median, NAN, value);
}

/* All figures, or of many labels their number and the checksum of the table, to digits that every processor finds. */
static void keep_all(cli_measuring *m, const vv_label_measures *l, size_t n, const vv_field *values)
{
    enum { MOST = 256 };
    const bool is_unsigned = vvi_label_is_unsigned(vv_field_get_info(m->field)->type);
    uint32_t sum = 0;
    for (size_t i = 0; i < n && n <= MOST; i++)
        keep(m, &l[i], values);
    for (size_t i = 0; i < n && n > MOST; i++) {
        char row[320], digits[VVI_LABEL_DIGITS];
        int at = snprintf(row, sizeof row, "%s,%" PRIu64 ",%.6g,%.4g,%.4g,%.4g",
                          vvi_label_print(digits, l[i].label, is_unsigned), l[i].count, l[i].volume, l[i].centroid.x,
                          l[i].centroid.y, l[i].centroid.z);
        if (values)
            at += snprintf(row + at, sizeof row - (size_t)at, ",%.6g,%.4g,%.6g,%.6g,%.6g", l[i].mean, l[i].deviation,
                           l[i].min, l[i].max, l[i].median);
        sum = vvi_crc32(sum, row, (size_t)at, false);
    }
    cli_figure_keep(m->result, &(cli_figure){"labels", "", (double)n, NAN, ""});
    if (n > MOST)
        cli_figure_keep(m->result, &(cli_figure){"checksum", "", sum, NAN, ""});
}

/* To the digits that its error leaves, which is found as that of any counted object. */
static void print_centroid(char out[CLI_FIGURE_TEXT], const vv_label_measures *l)
{
    double error[3];
    const double share = 0.4 * l->volume_error / l->volume;
    for (int a = 0; a < 3; a++)
        error[a] = share * ((&l->bounds.hi.x)[a] - (&l->bounds.lo.x)[a]);
    cli_place_print(out, (double[]){l->centroid.x, l->centroid.y, l->centroid.z}, error);
}

static void put_text(vvi_text *out, const vv_label_measures *l, const shape *s, const char *name)
{
    char centre[CLI_FIGURE_TEXT], digits[VVI_LABEL_DIGITS], volume[2][48], area[2][48];
    cli_figure_digits(volume[0], volume[1], l->volume, l->volume_error);
    cli_figure_digits(area[0], area[1], l->area, l->area_error);
    print_centroid(centre, l);
    vvi_text_printf(out, "%8s %12" PRIu64 " %12s %9s %10s %9s  %-24s",
                    vvi_label_print(digits, l->label, s->is_unsigned), l->count, volume[0], volume[1], area[0], area[1],
                    centre);
    if (s->values)
        vvi_text_printf(out, " %9.6g %9.6g %9.6g %9.6g %9.6g", l->mean, l->deviation, l->min, l->median, l->max);
    vvi_text_add(out, *name ? "  " : "");
    vvi_text_add_clean(out, name);
    vvi_text_add(out, "\n");
}

static void put_head(cli_measuring *m, const vv_field *values)
{
    const vv_grid *grid = &vv_field_get_info(m->field)->grid;
    char volume[32], area[32], heading[48];
    cli_power_unit(volume, grid->unit, 3);
    cli_power_unit(area, grid->unit, 2);
    vvi_result_string(&m->command->json, "unit", grid->unit);
    vvi_result_string(&m->command->json, "volume_unit", volume);
    vvi_result_string(&m->command->json, "area_unit", area);
    if (values)
        vvi_result_string(&m->command->json, "value_unit", vv_field_get_info(values)->value_unit);
    vvi_result_string(&m->command->json, "method", m->choice.method == VV_MEASURE_CUBES ? "cubes" : "count");
    if (m->result->csv) {
        vvi_text_printf(
            &m->command->text,
            "label,count,volume,x,y,z,x_lo,y_lo,z_lo,x_hi,y_hi,z_hi%s,area,area_error,volume_error,unit,area_unit,"
            "volume_unit%s,name\n",
            values ? ",mean,deviation,min,max,median" : "", values ? ",value_unit" : "");
        return;
    }
    snprintf(heading, sizeof heading, "centroid, %s", grid->unit);
    vvi_text_printf(&m->command->text, "%8s %12s %12s %9s %10s %9s  %-24s", "label", "samples", volume, "error", area,
                    "error", heading);
    if (values)
        vvi_text_printf(&m->command->text, " %9s %9s %9s %9s %9s", "mean", "deviation", "least", "median", "largest");
    vvi_text_add(&m->command->text, "\n");
}

static void put_table(cli_measuring *m, const vv_label_measures *l, size_t n, const vv_field *values)
{
    char units[160], volume[32], area[32];
    const vv_field_info *info = vv_field_get_info(m->field);
    const shape s = {vvi_label_is_unsigned(info->type), values != NULL};
    const char *unit = info->grid.unit;
    cli_power_unit(volume, unit, 3);
    cli_power_unit(area, unit, 2);
    snprintf(units, sizeof units, ",%s,%s,%s%s%s", unit, area, volume, values ? "," : "",
             values ? vv_field_get_info(values)->value_unit : "");
    put_head(m, values);
    keep_all(m, l, n, values);
    vvi_result_open(&m->command->json, "labels", '[');
    for (size_t i = 0; i < n; i++) {
        put_json(&m->command->json, &l[i], &s, name_of(m, l[i].label));
        if (m->result->csv)
            put_csv(&m->command->text, &l[i], &s, units, name_of(m, l[i].label));
        else
            put_text(&m->command->text, &l[i], &s, name_of(m, l[i].label));
    }
    vvi_result_close(&m->command->json, ']');
    if (n == 0 && !m->result->csv)
        vvi_text_add(&m->command->text, "there are no labels except 0\n");
}

/* Areas of the smooth borders that isosurface makes, where --method cubes asks for them. Volumes stay counted. */
static vv_status find_smooth_areas(cli_measuring *m, vv_label_measures *l, size_t n)
{
    vv_job *job = m->command->job;
    vv_label_id *labels = calloc(n + 1, sizeof *labels);
    vv_plane planes[CLI_PLANES_MOST];
    vv_mesh *mesh = NULL, *kept = NULL;
    const vv_grid *grid = &vv_field_get_info(m->field)->grid;
    const double s[3] = {vv_grid_spacing(grid, 0), vv_grid_spacing(grid, 1), vv_grid_spacing(grid, 2)};
    const double share = SMOOTH_AREA * fmax(fmax(s[0], s[1]), s[2]) / fmin(fmin(s[0], s[1]), s[2]);
    if (!labels)
        return vv_fail_memory(n * sizeof *labels);
    for (size_t i = 0; i < n; i++)
        labels[i] = l[i].label;
    const vvi_labels_options options = {.labels = labels, .n_labels = n, .smoothing = 1};
    vv_status st = vvi_label_surfaces(&mesh, m->field, 0, &options, job);
    if (st == VV_OK)
        st = vvi_mesh_clip(&kept, mesh, planes, cli_measuring_planes(planes, m), false, job);
    for (size_t i = 0; i < n && st == VV_OK; i++) {
        vv_mesh_measure_options o;
        vv_mesh_measures found;
        vv_mesh_measure_options_init(&o, sizeof o);
        o.part = i;
        o.sampled = o.open = true;
        st = vv_mesh_measure(&found, kept, &o, job);
        l[i].area = found.area.value;
        l[i].area_error = hypot(found.area.error, share * found.area.value);
    }
    vv_mesh_release(mesh);
    vv_mesh_release(kept);
    free(labels);
    return st;
}

static vv_status measure(vv_label_measures **out, size_t *n, const cli_measuring *m, const vv_field *values)
{
    vv_label_options o;
    vv_label_options_init(&o, sizeof o);
    o.values = values;
    o.component = m->o->component ? m->choice.component : 0;
    o.box = m->choice.box;
    o.planes = m->planes;
    o.n_planes = m->n_planes;
    return vv_measure_labels(out, n, m->field, &o, m->command->job);
}

vv_status cli_measure_labels(cli_measuring *m)
{
    vv_label_measures *l = NULL;
    vv_field *values = NULL;
    size_t n = 0;
    vv_status st = VV_OK;
    cli_measuring_label_method(m);
    if (vv_type_is_float(vv_field_get_info(m->field)->type))
        return vv_fail(VV_E_ARGUMENT,
                       "%s has real numbers, and labels are whole ones: convert it with --type, or measure "
                       "a threshold",
                       m->input.path);
    if (vvi_has_scale(vv_field_get_info(m->field)))
        return vv_fail(VV_E_ARGUMENT,
                       "%s has a scale (times %g, plus %g), so that its values are amounts and no labels: write its "
                       "values by 'volvis convert --type i32' if they are labels, or measure a threshold",
                       m->input.path, vv_field_get_info(m->field)->value_scale,
                       vv_field_get_info(m->field)->value_offset);
    if (m->o->values)
        st = cli_measuring_beside(&values, m, &m->values_input, &m->values_stream, false, m->o->values);
    if (st == VV_OK)
        st = measure(&l, &n, m, values);
    if (st == VV_OK && n && m->choice.method == VV_MEASURE_CUBES)
        st = find_smooth_areas(m, l, n);
    if (st == VV_OK)
        put_table(m, l, n, values);
    vv_label_measures_free(l);
    vv_field_release(values);
    return st;
}
