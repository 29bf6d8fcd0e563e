/* Distances and angles between places, the value at one, and values along a line. */
#include "core/vec.h"
#include "grid/probe.h"
#include "measuring/measuring.h"
#include <math.h>
#include <stdio.h>

double vvi_place_error(const vvi_measuring *m)
{
    const vv_grid *grid = &vv_field_get_info(m->field)->grid;
    double sum = 0;
    for (int a = 0; a < 3; a++)
        sum += vv_grid_spacing(grid, a) * vv_grid_spacing(grid, a) / 12;
    return sqrt(sum / 3); /* along one direction */
}

/* Of lengths between places. */
static const char *unit_of(const vvi_measuring *m)
{
    return m->field          ? vv_field_get_info(m->field)->grid.unit
           : m->input->shown ? m->input->unit
                             : vv_mesh_get_info(m->input->mesh)->unit;
}

/* Places beside a mesh are as they are given: how well they are known nobody says. */
static double error_of(const vvi_measuring *m)
{
    return m->field ? vvi_place_error(m) : NAN;
}

/* The places, of which p has as many as are needed, in the world and told. */
static vv_status find_places(vv_vec3 *p, size_t n, vvi_measuring *m, const char *what)
{
    const vv_status st = vvi_measuring_points(p, n, m, what);
    for (size_t i = 0; i < n && st == VV_OK; i++) {
        if (m->field)
            p[i] = vv_affine_point(vv_field_get_info(m->field)->grid.index_to_world, p[i]);
        vvi_tell_line(m->answer, i ? "" : "places", "%.6g, %.6g, %.6g", p[i].x, p[i].y, p[i].z);
    }
    if (st == VV_OK)
        vvi_tell_rows(m->answer, "points", &p[0].x, n, 3);
    return st;
}

/* How far the sum of the lengths may be off: at each place by what moving it changes in those on both of its sides. */
static double length_error(const vv_vec3 *p, size_t n, double place_error)
{
    double squares = 0;
    for (size_t i = 0; i < n; i++) {
        vv_vec3 pull = {0, 0, 0};
        for (int side = 0; side < 2; side++) {
            if (side ? i + 1 == n : i == 0)
                continue;
            vv_vec3 way = vvi_sub(p[i], p[side ? i + 1 : i - 1]);
            if (vvi_length(way) > 0)
                pull = vvi_add(pull, vvi_scaled(way, 1 / vvi_length(way)));
            else
                pull = vvi_add(pull, vvi_vec(side ? -1 : 1, 0, 0));
        }
        squares += vvi_dot(pull, pull);
    }
    return sqrt(squares) * place_error;
}

/* Between two places, or from each of several to the next. */
vv_status vvi_measure_distance(vvi_measuring *m)
{
    const size_t given = m->asked->points ? m->asked->points->n / 3 : 0, n = given > 2 ? given : 2;
    vv_vec3 *p = vvi_answer_room(m->answer, n, sizeof *p);
    if (!p)
        return vv_fail_memory(n * sizeof *p);
    const vv_status st = find_places(p, n, m, "distance");
    if (st != VV_OK)
        return st;
    double length = 0;
    for (size_t i = 0; i + 1 < n; i++)
        length += vvi_length(vvi_sub(p[i + 1], p[i]));
    vvi_tell_text(m->answer, "unit", unit_of(m));
    vvi_tell(m->answer, "distance", n > 2 ? "length" : "distance", length, length_error(p, n, error_of(m)), unit_of(m));
    return VV_OK;
}

vv_status vvi_measure_mesh_distance(vvi_measuring *m)
{
    const size_t given = m->asked->points ? m->asked->points->n / 3 : 0;
    return given < 2 ? vvi_measure_point_to_surface(m) : vvi_measure_distance(m);
}

/* At the second of three points. */
vv_status vvi_measure_angle(vvi_measuring *m)
{
    vv_vec3 p[3];
    const vv_status st = find_places(p, 3, m, "angle");
    if (st != VV_OK)
        return st;
    const vv_vec3 a = vvi_sub(p[0], p[1]), b = vvi_sub(p[2], p[1]);
    const double la = vvi_length(a), lb = vvi_length(b), degrees = 57.29577951308232;
    if (!(la > 0) || !(lb > 0))
        return vv_fail(VV_E_ARGUMENT, "an angle needs three places, the middle one beside the others");
    const double error = sqrt(1 / (la * la) + 1 / (lb * lb)) * sqrt(2) * error_of(m) * degrees;
    vvi_tell(m->answer, "angle", "angle", atan2(vvi_length(vvi_cross(a, b)), vvi_dot(a, b)) * degrees, error, "deg");
    return VV_OK;
}

static bool in_grid(const vv_grid *grid, vv_vec3 p)
{
    const double at[3] = {p.x, p.y, p.z};
    for (int a = 0; a < 3; a++)
        if (!(at[a] >= -0.5 && at[a] <= (double)grid->dims[a] - 0.5))
            return false;
    return true;
}

/* What a place has: of labels the one of the nearest sample, else interpolated as in profiles. */
vv_status vvi_measure_point(vvi_measuring *m)
{
    const vv_field_info *info = vv_field_get_info(m->field);
    bool sensed, untold;
    vv_vec3 p, world;
    vvi_probe probe;
    vv_status st = find_places(&world, 1, m, "point");
    if (st != VV_OK || (st = vvi_measuring_of_labels(&m->labels, &sensed, &untold, m)) != VV_OK ||
        (st = vvi_measuring_points(&p, 1, m, "point")) != VV_OK)
        return st;
    const double index[3] = {p.x, p.y, p.z};
    const bool inside = in_grid(&info->grid, p);
    vvi_tell_numbers(m->answer, "index", index, 3);
    if ((st = vvi_probe_open(&probe, m->field, m->choice.component, m->labels, m->job)) != VV_OK)
        return st;
    vvi_tell(m->answer, "value", "value", inside ? vvi_probe_value(&probe, index) : NAN,
             inside ? vvi_probe_error(&probe, index) : NAN, info->value_unit);
    if (!inside)
        vvi_tell_note(m->answer, "the place lies outside the volume, and has no value");
    vvi_probe_close(&probe);
    return VV_OK;
}

/* Profile -----------------------------------------------------------------------------------------------------------
 */

/* Values along a line; of places outside the volume they are NaN. */
typedef struct line {
    int64_t n;
    double *distance, *value, *error;
} line;

static const vv_answer_column columns[] = {{"distance", NULL, VV_CELL_NUMBER}, {"x", NULL, VV_CELL_NUMBER},
                                           {"y", NULL, VV_CELL_NUMBER},        {"z", NULL, VV_CELL_NUMBER},
                                           {"value", NULL, VV_CELL_NUMBER},    {"error", NULL, VV_CELL_NUMBER}};
enum { COLUMNS = sizeof columns / sizeof *columns };

static void put_row(vvi_text *out, double distance, double value, double error)
{
    char text[48], digits[48];
    vvi_figure_digits(text, digits, value, error);
    vvi_text_printf(out, "%12.6g  %12s  %12s\n", distance, text, digits);
}

static void find_samples(const vvi_measuring *m, const vvi_probe *probe, const vv_vec3 p[2], line *l, vv_cell *cell)
{
    const vv_grid *grid = &vv_field_get_info(m->field)->grid;
    const vv_vec3 from = vv_affine_point(grid->index_to_world, p[0]);
    for (int64_t i = 0; i < l->n; i++) {
        const vv_vec3 at = vvi_add(p[0], vvi_scaled(vvi_sub(p[1], p[0]), (double)i / (double)(l->n - 1)));
        const vv_vec3 world = vv_affine_point(grid->index_to_world, at);
        const double index[3] = {at.x, at.y, at.z};
        l->distance[i] = vvi_length(vvi_sub(world, from));
        l->value[i] = in_grid(grid, at) ? vvi_probe_value(probe, index) : NAN;
        l->error[i] = isnan(l->value[i]) ? NAN : vvi_probe_error(probe, index);
        const double row[COLUMNS] = {l->distance[i], world.x, world.y, world.z, l->value[i], l->error[i]};
        for (int c = 0; c < COLUMNS; c++)
            (cell++)->number = row[c];
    }
}

static void put_samples(vv_answer *a, const line *l, const vv_cell *cells)
{
    const int64_t each = (l->n + 19) / 20; /* as text about twenty of them are enough */
    vvi_text text = {0};
    vvi_text_printf(&text, "%12s  %12s  %12s\n", "distance", "value", "error");
    for (int64_t i = 0; i < l->n; i++)
        if (i % each == 0 || i == l->n - 1)
            put_row(&text, l->distance[i], l->value[i], l->error[i]);
    vvi_tell_block(a, &text);
    double *pairs = vvi_answer_room(a, (size_t)(2 * l->n), sizeof *pairs);
    for (int64_t i = 0; pairs && i < l->n; i++) {
        pairs[2 * i] = l->distance[i];
        pairs[2 * i + 1] = l->value[i];
    }
    if (pairs)
        vvi_tell_rows(a, "profile", pairs, (size_t)l->n, 2);
    vvi_tell_rows(a, "profile_error", l->error, (size_t)l->n, 1);
    vvi_tell_table(a, NULL, columns, COLUMNS, cells, (size_t)l->n);
}

/* Length, least, mean and largest value: what a scene keeps of a profile, and programs read. No least or largest value
 * is off by more than the most that one is, no mean by more than they are on average. */
static void keep_profile(vvi_measuring *m, const line *l)
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
    const double error[] = {sqrt(2) * vvi_place_error(m), most, errors / n_values, most};
    static const char *const names[] = {"length", "min", "mean", "max"};
    for (int i = 0; i < 4; i++) {
        if (i == 2 && m->labels) /* their numbers have no mean */
            continue;
        vvi_figure f = {.key = names[i], .value = v[i], .error = error[i]};
        snprintf(f.unit, sizeof f.unit, "%s", i ? info->value_unit : info->grid.unit);
        vvi_tell_figure_for(m->answer, &f, VV_FOR_SCENES | VV_FOR_PROGRAMS);
    }
}

static void note_outside(const vvi_measuring *m, const line *l)
{
    const int64_t n = l->n;
    int64_t none = 0;
    for (int64_t i = 0; i < n; i++)
        none += isnan(l->value[i]);
    if (none)
        vvi_tell_note(m->answer, "%lld of %lld places of the profile lie outside the volume or have no value",
                      (long long)none, (long long)n);
}

static void plot_profile(vvi_measuring *m, const line *l)
{
    const vv_field_info *info = vv_field_get_info(m->field);
    vv_answer *a = m->answer;
    const double *at = m->asked->points->v;
    char x_label[64], y_label[96], title[288], from[VVI_POINT_TEXT], to[VVI_POINT_TEXT];
    vvi_plot *plot = vvi_answer_room(a, 1, sizeof *plot);
    if (!plot)
        return;
    snprintf(x_label, sizeof x_label, "distance, %s", info->grid.unit);
    snprintf(y_label, sizeof y_label, "%s%s%s", *info->name ? info->name : "value", *info->value_unit ? ", " : "",
             info->value_unit);
    snprintf(title, sizeof title, "%.60s: %s to %s", vvi_measuring_title(m),
             vvi_point_print(from, vvi_vec(at[0], at[1], at[2])), vvi_point_print(to, vvi_vec(at[3], at[4], at[5])));
    *plot = (vvi_plot){.title = vvi_answer_copy(a, title),
                       .x_label = vvi_answer_copy(a, x_label),
                       .y_label = vvi_answer_copy(a, y_label),
                       .x = l->distance,
                       .y = l->value,
                       .n = (size_t)l->n};
    a->plot = plot;
}

static void put_profile(vvi_measuring *m, const vvi_probe *probe, const vv_vec3 p[2], int64_t n)
{
    double *x = vvi_answer_room(m->answer, (size_t)(3 * n), sizeof *x);
    vv_cell *cells = vvi_answer_room(m->answer, (size_t)n * COLUMNS, sizeof *cells);
    if (!x || !cells)
        return;
    line l = {n, x, x + n, x + 2 * n};
    find_samples(m, probe, p, &l, cells);
    put_samples(m->answer, &l, cells);
    keep_profile(m, &l);
    note_outside(m, &l);
    plot_profile(m, &l);
}

vv_status vvi_measure_profile(vvi_measuring *m)
{
    const vv_field_info *info = vv_field_get_info(m->field);
    bool sensed, untold;
    vv_vec3 p[2];
    vvi_probe probe;
    vv_status st = vvi_measuring_points(p, 2, m, "profile");
    if (st != VV_OK || (st = vvi_measuring_of_labels(&m->labels, &sensed, &untold, m)) != VV_OK)
        return st;
    const double steps = vvi_length(vvi_sub(p[1], p[0]));
    if (steps == 0)
        vvi_tell_note(m->answer, "both places of the profile are the same: it has no length, and one value");
    const int64_t n = vvi_asks(m, "samples") ? m->asked->samples : (int64_t)fmin(2 * steps + 2, 1e6);
    if ((st = vvi_probe_open(&probe, m->field, m->choice.component, m->labels, m->job)) != VV_OK)
        return st;
    vvi_tell_text(m->answer, "unit", info->grid.unit);
    vvi_tell_text(m->answer, "value_unit", info->value_unit);
    vvi_tell_line(m->answer, "profile", "%lld values%s%s, %s, along %g steps", (long long)n,
                  *info->value_unit ? " in " : "", info->value_unit,
                  m->labels ? "of the nearest sample" : "interpolated", steps);
    put_profile(m, &probe, p, n);
    vvi_probe_close(&probe);
    return VV_OK;
}
