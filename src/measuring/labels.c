/* The table of all labels. */
#include "surface/labels.h"
#include "grid/crc.h"
#include "grid/label_id.h"
#include "grid/true_values.h"
#include "measuring/measuring.h"
#include "surface/clip.h"
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <volvis/measure_mesh.h>

#define SMOOTH_AREA 0.065 /* how far smooth borders are off, by balls and turned boxes of 5 to 20 voxels */

/* What the file calls a label; "" where it does not. */
static const char *name_of(const vvi_measuring *m, vv_label_id label)
{
    for (size_t i = 0; i < m->input->n_labels; i++)
        if (m->input->labels[i].value == label)
            return m->input->labels[i].name;
    return "";
}

/* Figures of one row: those of a place one by one. units: of lengths, areas, volumes, values. */
static void keep_row(vv_answer *a, const vv_label_measures *l, const char *digits, const char *const units[4],
                     bool values)
{
    const struct {
        const char *name;
        double value, error;
        int unit; /* 4: none */
    } figures[] = {{"count", (double)l->count, NAN, 4},
                   {"volume", l->volume, l->volume_error, 2},
                   {"area", l->area, l->area_error, 1},
                   {"centroid_x", l->centroid.x, NAN, 0},
                   {"centroid_y", l->centroid.y, NAN, 0},
                   {"centroid_z", l->centroid.z, NAN, 0},
                   {"box_lo_x", l->bounds.lo.x, NAN, 0},
                   {"box_lo_y", l->bounds.lo.y, NAN, 0},
                   {"box_lo_z", l->bounds.lo.z, NAN, 0},
                   {"box_hi_x", l->bounds.hi.x, NAN, 0},
                   {"box_hi_y", l->bounds.hi.y, NAN, 0},
                   {"box_hi_z", l->bounds.hi.z, NAN, 0},
                   {"mean", l->mean, NAN, 3},
                   {"deviation", l->deviation, NAN, 3},
                   {"min", l->min, NAN, 3},
                   {"max", l->max, NAN, 3},
                   {"median", l->median, NAN, 3}};
    for (size_t i = 0; i < sizeof figures / sizeof *figures; i++) {
        char key[64];
        vvi_figure f = {.key = key, .value = figures[i].value, .error = figures[i].error};
        if (figures[i].unit == 3 && !values)
            continue;
        snprintf(key, sizeof key, "label_%s_%s", digits, figures[i].name);
        snprintf(f.unit, sizeof f.unit, "%s", figures[i].unit < 4 ? units[figures[i].unit] : "");
        vvi_tell_figure_for(a, &f, VV_FOR_SCENES);
    }
}

/* All figures, or of many labels their number and the checksum of the table, to digits that every processor finds. */
static void keep_all(vvi_measuring *m, const vv_label_measures *l, size_t n, const char *const units[4], bool values)
{
    enum { MOST = 256 };
    const bool is_unsigned = vvi_label_is_unsigned(vv_field_get_info(m->field)->type);
    uint32_t sum = 0;
    for (size_t i = 0; i < n; i++) {
        char row[320], digits[VVI_LABEL_DIGITS];
        vvi_label_print(digits, l[i].label, is_unsigned);
        if (n <= MOST) {
            keep_row(m->answer, &l[i], digits, units, values);
            continue;
        }
        int at = snprintf(row, sizeof row, "%s,%" PRIu64 ",%.6g,%.4g,%.4g,%.4g", digits, l[i].count, l[i].volume,
                          l[i].centroid.x, l[i].centroid.y, l[i].centroid.z);
        if (values)
            at += snprintf(row + at, sizeof row - (size_t)at, ",%.6g,%.4g,%.6g,%.6g,%.6g", l[i].mean, l[i].deviation,
                           l[i].min, l[i].max, l[i].median);
        sum = vvi_crc32(sum, row, (size_t)at, false);
    }
    vvi_tell_figure_for(m->answer, &(vvi_figure){"labels", "", (double)n, NAN, ""}, VV_FOR_SCENES);
    if (n > MOST)
        vvi_tell_figure_for(m->answer, &(vvi_figure){"checksum", "", sum, NAN, ""}, VV_FOR_SCENES);
}

/* To the digits that its error leaves, which is found as that of any counted object. */
static void print_centroid(char out[VVI_FIGURE_TEXT], const vv_label_measures *l)
{
    double error[3];
    const double share = 0.4 * l->volume_error / l->volume;
    for (int a = 0; a < 3; a++)
        error[a] = share * ((&l->bounds.hi.x)[a] - (&l->bounds.lo.x)[a]);
    vvi_place_print(out, (double[]){l->centroid.x, l->centroid.y, l->centroid.z}, error);
}

static void put_text(vvi_text *out, const vv_label_measures *l, bool is_unsigned, bool values, const char *name)
{
    char centre[VVI_FIGURE_TEXT], digits[VVI_LABEL_DIGITS], volume[2][48], area[2][48];
    vvi_figure_digits(volume[0], volume[1], l->volume, l->volume_error);
    vvi_figure_digits(area[0], area[1], l->area, l->area_error);
    print_centroid(centre, l);
    vvi_text_printf(out, "%8s %12" PRIu64 " %12s %9s %10s %9s  %-24s", vvi_label_print(digits, l->label, is_unsigned),
                    l->count, volume[0], volume[1], area[0], area[1], centre);
    if (values)
        vvi_text_printf(out, " %9.6g %9.6g %9.6g %9.6g %9.6g", l->mean, l->deviation, l->min, l->median, l->max);
    vvi_text_add(out, *name ? "  " : "");
    vvi_text_add_clean(out, name);
    vvi_text_add(out, "\n");
}

static void put_head(vvi_text *out, const vvi_measuring *m, const char *volume, const char *area, bool values)
{
    char heading[48];
    snprintf(heading, sizeof heading, "centroid, %s", vv_field_get_info(m->field)->grid.unit);
    vvi_text_printf(out, "%8s %12s %12s %9s %10s %9s  %-24s", "label", "samples", volume, "error", area, "error",
                    heading);
    if (values)
        vvi_text_printf(out, " %9s %9s %9s %9s %9s", "mean", "deviation", "least", "median", "largest");
    vvi_text_add(out, "\n");
}

/* Columns as tables have them, and between them what only programs are told; those of values are the last but so many.
 */
static const vv_answer_column columns[] = {{"label", "label", VV_CELL_LABEL},
                                           {NULL, "name", VV_CELL_NAME},
                                           {"count", "count", VV_CELL_COUNT},
                                           {"volume", "volume", VV_CELL_NUMBER},
                                           {NULL, "volume_error", VV_CELL_NUMBER},
                                           {NULL, "area", VV_CELL_NUMBER},
                                           {NULL, "area_error", VV_CELL_NUMBER},
                                           {"x", "centroid", VV_CELL_NUMBER},
                                           {"y", "centroid", VV_CELL_NUMBER},
                                           {"z", "centroid", VV_CELL_NUMBER},
                                           {"x_lo", "box_lo", VV_CELL_NUMBER},
                                           {"y_lo", "box_lo", VV_CELL_NUMBER},
                                           {"z_lo", "box_lo", VV_CELL_NUMBER},
                                           {"x_hi", "box_hi", VV_CELL_NUMBER},
                                           {"y_hi", "box_hi", VV_CELL_NUMBER},
                                           {"z_hi", "box_hi", VV_CELL_NUMBER},
                                           {"mean", "mean", VV_CELL_NUMBER},
                                           {"deviation", "deviation", VV_CELL_NUMBER},
                                           {"min", "min", VV_CELL_NUMBER},
                                           {"max", "max", VV_CELL_NUMBER},
                                           {"median", "median", VV_CELL_NUMBER},
                                           {"area", NULL, VV_CELL_NUMBER},
                                           {"area_error", NULL, VV_CELL_NUMBER},
                                           {"volume_error", NULL, VV_CELL_NUMBER},
                                           {"unit", NULL, VV_CELL_TEXT},
                                           {"area_unit", NULL, VV_CELL_TEXT},
                                           {"volume_unit", NULL, VV_CELL_TEXT},
                                           {"value_unit", NULL, VV_CELL_TEXT},
                                           {"name", NULL, VV_CELL_NAME}};
enum { COLUMNS = sizeof columns / sizeof *columns, FIRST_OF_VALUES = 16, N_OF_VALUES = 5, VALUE_UNIT = 27 };

static bool is_of_values(size_t column)
{
    return (column >= FIRST_OF_VALUES && column < FIRST_OF_VALUES + N_OF_VALUES) || column == VALUE_UNIT;
}

/* Without values their columns are left out. How many there are. */
static size_t choose_columns(vv_answer_column *out, bool is_unsigned, bool values)
{
    size_t n = 0;
    for (size_t c = 0; out && c < COLUMNS; c++)
        if (values || !is_of_values(c))
            out[n++] = columns[c];
    if (out && is_unsigned)
        out[0].kind = VV_CELL_UNSIGNED_LABEL;
    return n;
}

/* units: of lengths, areas, volumes, values. */
static vv_cell *fill_row(vv_cell *cell, const vv_label_measures *l, const char *name, const char *const units[4],
                         bool values)
{
    const vv_cell row[COLUMNS] = {
        {.label = l->label}, {.text = name},     {.count = l->count}, {l->volume},       {l->volume_error},
        {l->area},           {l->area_error},    {l->centroid.x},     {l->centroid.y},   {l->centroid.z},
        {l->bounds.lo.x},    {l->bounds.lo.y},   {l->bounds.lo.z},    {l->bounds.hi.x},  {l->bounds.hi.y},
        {l->bounds.hi.z},    {l->mean},          {l->deviation},      {l->min},          {l->max},
        {l->median},         {l->area},          {l->area_error},     {l->volume_error}, {.text = units[0]},
        {.text = units[1]},  {.text = units[2]}, {.text = units[3]},  {.text = name}};
    for (size_t c = 0; c < COLUMNS; c++)
        if (values || !is_of_values(c))
            *cell++ = row[c];
    return cell;
}

static void put_table(vvi_measuring *m, const vv_label_measures *l, size_t n, const char *const units[4], bool values)
{
    vv_answer *a = m->answer;
    const bool is_unsigned = vvi_label_is_unsigned(vv_field_get_info(m->field)->type);
    vv_answer_column *chosen = vvi_answer_room(a, COLUMNS, sizeof *chosen);
    const size_t n_columns = choose_columns(chosen, is_unsigned, values);
    vv_cell *cells = vvi_answer_room(a, n * n_columns, sizeof *cells), *cell = cells;
    for (size_t i = 0; chosen && cells && i < n; i++)
        cell = fill_row(cell, &l[i], vvi_answer_copy(a, name_of(m, l[i].label)), units, values);
    vvi_tell_table(a, "labels", chosen, n_columns, cells, cells ? n : 0);
}

static void put_labels(vvi_measuring *m, const vv_label_measures *l, size_t n, const vv_field *values)
{
    vv_answer *a = m->answer;
    const vv_field_info *info = vv_field_get_info(m->field);
    char volume[32], area[32];
    vvi_text text = {0};
    vvi_power_unit(volume, info->grid.unit, 3);
    vvi_power_unit(area, info->grid.unit, 2);
    const char *const units[4] = {vvi_answer_copy(a, info->grid.unit), vvi_answer_copy(a, area),
                                  vvi_answer_copy(a, volume),
                                  values ? vvi_answer_copy(a, vv_field_get_info(values)->value_unit) : ""};
    vvi_tell_text(a, "unit", units[0]);
    vvi_tell_text(a, "volume_unit", volume);
    vvi_tell_text(a, "area_unit", area);
    if (values)
        vvi_tell_text(a, "value_unit", units[3]);
    vvi_tell_text(a, "method", m->choice.method == VV_MEASURE_CUBES ? "cubes" : "count");
    keep_all(m, l, n, units, values != NULL);
    put_head(&text, m, volume, area, values != NULL);
    for (size_t i = 0; i < n; i++)
        put_text(&text, &l[i], vvi_label_is_unsigned(info->type), values != NULL, name_of(m, l[i].label));
    if (n == 0)
        vvi_text_add(&text, "there are no labels except 0\n");
    vvi_tell_block(a, &text);
    put_table(m, l, n, units, values != NULL);
}

/* Areas of the smooth borders that isosurface makes, where --method cubes asks for them. Volumes stay counted. */
static vv_status find_smooth_areas(vvi_measuring *m, vv_label_measures *l, size_t n)
{
    vv_job *job = m->job;
    vv_label_id *labels = calloc(n + 1, sizeof *labels);
    vv_plane planes[VVI_PLANES_MOST];
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
        st = vvi_mesh_clip(&kept, mesh, planes, vvi_measuring_planes(planes, m), false, job);
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

static vv_status measure(vv_label_measures **out, size_t *n, const vvi_measuring *m, const vv_field *values)
{
    vv_label_options o;
    vv_label_options_init(&o, sizeof o);
    o.values = values;
    o.component = vvi_asks(m, "component") ? m->choice.component : 0;
    o.box = m->choice.box;
    o.planes = m->planes;
    o.n_planes = m->n_planes;
    return vv_measure_labels(out, n, m->field, &o, m->job);
}

vv_status vvi_measure_label_table(vvi_measuring *m)
{
    vv_label_measures *l = NULL;
    vv_field *values = NULL;
    size_t n = 0;
    vv_status st = VV_OK;
    vvi_measuring_label_method(m);
    if (vv_type_is_float(vv_field_get_info(m->field)->type))
        return vv_fail(VV_E_ARGUMENT,
                       "%s has real numbers, and labels are whole ones: convert it with --type, or measure "
                       "a threshold",
                       m->input->name);
    if (vvi_has_scale(vv_field_get_info(m->field)))
        return vv_fail(VV_E_ARGUMENT,
                       "%s has a scale (times %g, plus %g), so that its values are amounts and no labels: write its "
                       "values by 'volvis convert --type i32' if they are labels, or measure a threshold",
                       m->input->name, vv_field_get_info(m->field)->value_scale,
                       vv_field_get_info(m->field)->value_offset);
    if (m->asked->values)
        st = vvi_measuring_beside(&values, m, m->inputs->values, false);
    if (st == VV_OK)
        st = measure(&l, &n, m, values);
    if (st == VV_OK && n && m->choice.method == VV_MEASURE_CUBES)
        st = find_smooth_areas(m, l, n);
    if (st == VV_OK)
        put_labels(m, l, n, values);
    vv_label_measures_free(l);
    vv_field_release(values);
    return st;
}
