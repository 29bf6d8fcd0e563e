/* Distances and angles between places, and values along a line. */
#include "core/units.h"
#include "core/vec.h"
#include "grid/probe.h"
#include "measure.h"
#include "measure_plot.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

double cli_place_error(const cli_measuring *m)
{
    const vv_grid *grid = &vv_field_get_info(m->field)->grid;
    double sum = 0;
    for (int a = 0; a < 3; a++)
        sum += vv_grid_spacing(grid, a) * vv_grid_spacing(grid, a) / 12;
    return sqrt(sum / 3); /* along one direction */
}

static vv_status distance(cli_measuring *m, const vv_vec3 p[2])
{
    const vv_grid *grid = &vv_field_get_info(m->field)->grid;
    cli_figure f = {.key = "distance", .label = "distance", .error = sqrt(2) * cli_place_error(m)};
    f.value = vvi_length(vvi_sub(p[1], p[0]));
    cli_power_unit(f.unit, grid->unit, 1);
    vvi_result_string(&m->command->json, "unit", grid->unit);
    cli_figure_put(m->result, &f);
    return VV_OK;
}

/* At the second of three points. */
static vv_status angle(cli_measuring *m, const vv_vec3 p[3])
{
    const vv_vec3 a = vvi_sub(p[0], p[1]), b = vvi_sub(p[2], p[1]);
    const double la = vvi_length(a), lb = vvi_length(b), degrees = 57.29577951308232;
    if (!(la > 0) || !(lb > 0))
        return vv_fail(VV_E_ARGUMENT, "an angle needs three places, the middle one beside the others");
    const double e = cli_place_error(m);
    const cli_figure f = {.key = "angle",
                          .label = "angle",
                          .unit = "deg",
                          .value = atan2(vvi_length(vvi_cross(a, b)), vvi_dot(a, b)) * degrees,
                          .error = sqrt(1 / (la * la) + 1 / (lb * lb)) * sqrt(2) * e * degrees};
    cli_figure_put(m->result, &f);
    return VV_OK;
}

vv_status cli_measure_points(cli_measuring *m, bool is_angle)
{
    vv_vec3 p[3];
    const size_t n = is_angle ? 3 : 2;
    const vv_status st = cli_measuring_points(p, n, m, is_angle ? "angle" : "distance");
    if (st != VV_OK)
        return st;
    vvi_result_open(&m->command->json, "points", '[');
    for (size_t i = 0; i < n; i++) {
        p[i] = vv_affine_point(vv_field_get_info(m->field)->grid.index_to_world, p[i]);
        vvi_result_numbers(&m->command->json, NULL, (double[]){p[i].x, p[i].y, p[i].z}, 3);
        if (!m->result->csv)
            cli_command_line(m->command, i ? "" : "places", "%.6g, %.6g, %.6g", p[i].x, p[i].y, p[i].z);
    }
    vvi_result_close(&m->command->json, ']');
    return is_angle ? angle(m, p) : distance(m, p);
}

/* Profile -----------------------------------------------------------------------------------------------------------
 */

/* Values along a line; of places outside the volume they are NaN. */
typedef struct line {
    int64_t n;
    double *distance, *value, *error;
} line;

static bool in_grid(const vv_grid *grid, vv_vec3 p)
{
    const double at[3] = {p.x, p.y, p.z};
    for (int a = 0; a < 3; a++)
        if (!(at[a] >= -0.5 && at[a] <= (double)grid->dims[a] - 0.5))
            return false;
    return true;
}

static void put_numbers(vvi_result *json, const char *key, const double *v, int64_t n)
{
    vvi_result_open(json, key, '[');
    for (int64_t i = 0; i < n; i++)
        vvi_result_number(json, NULL, v[i]);
    vvi_result_close(json, ']');
}

static void put_row(vvi_text *out, double distance, double value, double error)
{
    char text[48], digits[48];
    cli_figure_digits(text, digits, value, error);
    vvi_text_printf(out, "%12.6g  %12s  %12s\n", distance, text, digits);
}

static void put_samples(cli_measuring *m, const vvi_probe *probe, const vv_vec3 p[2], line *l)
{
    const int64_t n = l->n;
    const vv_grid *grid = &vv_field_get_info(m->field)->grid;
    const vv_vec3 from = vv_affine_point(grid->index_to_world, p[0]);
    vvi_result *json = &m->command->json;
    const int64_t each = m->result->csv ? 1 : (n + 19) / 20; /* as text about twenty of them are enough */
    if (m->result->csv)
        vvi_text_add(&m->command->text, "distance,x,y,z,value,error\n");
    else
        vvi_text_printf(&m->command->text, "%12s  %12s  %12s\n", "distance", "value", "error");
    vvi_result_open(json, "profile", '[');
    for (int64_t i = 0; i < n; i++) {
        const vv_vec3 at = vvi_add(p[0], vvi_scaled(vvi_sub(p[1], p[0]), (double)i / (double)(n - 1)));
        const vv_vec3 world = vv_affine_point(grid->index_to_world, at);
        const double d = vvi_length(vvi_sub(world, from));
        const double index[3] = {at.x, at.y, at.z};
        const double v = in_grid(grid, at) ? vvi_probe_value(probe, index) : NAN;
        const double error = isnan(v) ? NAN : vvi_probe_error(probe, index);
        l->distance[i] = d;
        l->value[i] = v;
        l->error[i] = error;
        vvi_result_numbers(json, NULL, (double[]){d, v}, 2);
        if (m->result->csv)
            vvi_text_printf(&m->command->text, "%.17g,%.17g,%.17g,%.17g,%.17g,%.17g\n", d, world.x, world.y, world.z, v,
                            error);
        else if (i % each == 0 || i == n - 1)
            put_row(&m->command->text, d, v, error);
    }
    vvi_result_close(json, ']');
    put_numbers(json, "profile_error", l->error, n);
}

/* Length, least, mean and largest value: what a scene keeps of a profile. No least or largest value is off by more than
 * the most that one is, no mean by more than they are on average. */
static void keep_profile(cli_measuring *m, const line *l)
{
    const vv_field_info *info = vv_field_get_info(m->field);
    double least = NAN, largest = NAN, sum = 0, n_values = 0, most = 0, errors = 0;
    for (int64_t i = 0; i < l->n; i++) {
        const double y = l->value[i], error = l->error[i];
        least = fmin(least, y); /* of a number and NaN it is the number */
        largest = fmax(largest, y);
        if (isnan(y))
            continue;
        sum += y;
        n_values++;
        most = error > most || isnan(error) ? error : most; /* one that is not known makes these unknown */
        errors += error;
    }
    const double v[] = {l->distance[l->n - 1], least, sum / n_values, largest};
    const double error[] = {sqrt(2) * cli_place_error(m), most, errors / n_values, most};
    static const char *const names[] = {"length", "min", "mean", "max"};
    for (int i = 0; i < 4; i++) {
        cli_figure f = {.key = names[i], .value = v[i], .error = error[i]};
        snprintf(f.unit, sizeof f.unit, "%s", i ? info->value_unit : info->grid.unit);
        cli_figure_keep(m->result, &f);
    }
}

static void note_outside(const cli_measuring *m, const line *l)
{
    const int64_t n = l->n;
    int64_t none = 0;
    for (int64_t i = 0; i < n; i++)
        none += isnan(l->value[i]);
    if (none)
        cli_command_note(m->command, "%lld of %lld places of the profile lie outside the volume or have no value",
                         (long long)none, (long long)n);
}

static vv_status plot_profile(cli_measuring *m, const line *l)
{
    const vv_field_info *info = vv_field_get_info(m->field);
    char x_label[64], y_label[96], title[160];
    const char *slash = strrchr(m->input.path, '/');
    snprintf(x_label, sizeof x_label, "distance, %s", info->grid.unit);
    snprintf(y_label, sizeof y_label, "%s%s%s", *info->name ? info->name : "value", *info->value_unit ? ", " : "",
             info->value_unit);
    snprintf(title, sizeof title, "%.60s: %s to %s", slash ? slash + 1 : m->input.path, cli_word_nth(m->o->point, 0),
             cli_word_nth(m->o->point, 1));
    return cli_plot_write(m->command, &(vvi_plot){.title = title,
                                                  .x_label = x_label,
                                                  .y_label = y_label,
                                                  .x = l->distance,
                                                  .y = l->value,
                                                  .n = (size_t)l->n});
}

vv_status cli_measure_profile(cli_measuring *m)
{
    const vv_field_info *info = vv_field_get_info(m->field);
    vv_vec3 p[2];
    vvi_probe probe;
    vv_status st = cli_measuring_points(p, 2, m, "profile");
    if (st != VV_OK)
        return st;
    const double steps = vvi_length(vvi_sub(p[1], p[0]));
    if (steps == 0)
        cli_command_note(m->command, "both places of the profile are the same: it has no length, and one value");
    const int64_t n = vv_object_is_set(&m->o->base, "samples") ? m->o->samples : (int64_t)fmin(2 * steps + 2, 1e6);
    st = vvi_probe_open(&probe, m->field, m->choice.component, info->meaning == VV_MEANING_LABEL, m->command->job);
    if (st != VV_OK)
        return st;
    vvi_result_string(&m->command->json, "unit", info->grid.unit);
    vvi_result_string(&m->command->json, "value_unit", info->value_unit);
    if (!m->result->csv)
        cli_command_line(m->command, "profile", "%lld values%s%s, %s, along %g steps", (long long)n,
                         *info->value_unit ? " in " : "", info->value_unit,
                         info->meaning == VV_MEANING_LABEL ? "of the nearest sample" : "interpolated", steps);
    double *x = calloc((size_t)(3 * n), sizeof *x);
    line l = {n, x, x ? x + n : NULL, x ? x + 2 * n : NULL};
    if (x) {
        put_samples(m, &probe, p, &l);
        keep_profile(m, &l);
        note_outside(m, &l);
    } else {
        st = vv_fail_memory((size_t)(3 * n) * sizeof *x);
    }
    vvi_probe_close(&probe);
    if (st == VV_OK && cli_plot_wanted(m->command))
        st = plot_profile(m, &l);
    free(x);
    return st;
}
