/* Joint histogram of values and lengths of gradients: figures, counts, plot. */
#include "grid/crc.h"
#include "measuring/measuring.h"
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

static void put_figures(vvi_measuring *m, const vv_joint *j)
{
    char unit[32];
    gradient_unit(unit, vv_field_get_info(m->field));
    vvi_tell(m->answer, "count", "samples", (double)j->count, NAN, "");
    vvi_tell_rare(m->answer, "unknown", "no gradient", j->unknown);
    vvi_tell(m->answer, "gradient_mean", "mean gradient", j->gradient_mean, NAN, unit);
    vvi_tell(m->answer, "gradient_max", "longest", j->gradient_max, NAN, unit);
}

/* The counts as one number: a scene keeps no table. */
static void keep_table(vvi_measuring *m, const vv_joint *j)
{
    const uint32_t sum = vvi_crc32(0, j->bins, j->n_values * j->n_gradients * sizeof *j->bins, false);
    const vvi_figure kept[] = {{"value_lo", "", j->value_lo, NAN, ""},
                               {"value_hi", "", j->value_hi, NAN, ""},
                               {"gradient_hi", "", j->gradient_hi, NAN, ""},
                               {"beyond", "", (double)j->beyond, NAN, ""},
                               {"checksum", "", sum, NAN, ""}};
    for (size_t i = 0; i < sizeof kept / sizeof *kept; i++)
        vvi_tell_figure_for(m->answer, &kept[i], VV_FOR_SCENES);
}

static void put_counts(vvi_measuring *m, const vv_joint *j)
{
    vv_answer *a = m->answer;
    const vv_field_info *info = vv_field_get_info(m->field);
    char unit[32];
    gradient_unit(unit, info);
    vvi_tell_open(a, "joint", "{");
    vvi_tell_numbers(a, "values", (double[]){j->value_lo, j->value_hi}, 2);
    vvi_tell_numbers(a, "gradients", (double[]){0, j->gradient_hi}, 2);
    vvi_tell_text(a, "value_unit", info->value_unit);
    vvi_tell_text(a, "gradient_unit", unit);
    vvi_tell_count(a, "n_values", j->n_values);
    vvi_tell_count(a, "n_gradients", j->n_gradients);
    vvi_tell_count(a, "beyond", j->beyond);
    vvi_tell_open(a, "counts", "[");
    for (size_t g = 0; g < j->n_gradients; g++)
        vvi_tell_counts(a, NULL, j->bins + g * j->n_values, j->n_values);
    vvi_tell_close(a, "]");
    vvi_tell_close(a, "}");
}

/* Bins that hold something. */
static void put_table(vv_answer *a, const vv_joint *j)
{
    static const vv_answer_column columns[] = {{"value_lo", NULL, VV_CELL_NUMBER},
                                               {"value_hi", NULL, VV_CELL_NUMBER},
                                               {"gradient_lo", NULL, VV_CELL_NUMBER},
                                               {"gradient_hi", NULL, VV_CELL_NUMBER},
                                               {"count", NULL, VV_CELL_COUNT}};
    enum { COLUMNS = sizeof columns / sizeof *columns };
    const double dv = (j->value_hi - j->value_lo) / (double)j->n_values, dg = j->gradient_hi / (double)j->n_gradients;
    const size_t n_bins = j->n_values * j->n_gradients;
    size_t n = 0;
    for (size_t i = 0; i < n_bins; i++)
        n += j->bins[i] > 0;
    vv_cell *cells = vvi_answer_room(a, n * COLUMNS, sizeof *cells), *cell = cells;
    for (size_t i = 0; cells && i < n_bins; i++) {
        const size_t row = i / j->n_values;
        const double v = (double)(i % j->n_values), g = (double)row;
        if (!j->bins[i])
            continue;
        cell[0].number = j->value_lo + v * dv;
        cell[1].number = j->value_lo + (v + 1) * dv;
        cell[2].number = g * dg;
        cell[3].number = (g + 1) * dg;
        cell[4].count = j->bins[i];
        cell += COLUMNS;
    }
    vvi_tell_table(a, NULL, columns, COLUMNS, cells, n);
}

/* Where a line holds it: gradients downwards, values to the right. */
static void put_small(vvi_text *out, const vv_joint *j)
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

static void plot_joint(vvi_measuring *m, const vv_joint *j, bool object)
{
    const vv_field_info *info = vv_field_get_info(m->field);
    vv_answer *a = m->answer;
    char unit[32], x_label[96], y_label[96], title[160];
    const size_t n = j->n_values * j->n_gradients;
    uint64_t *counts = vvi_answer_room(a, n, sizeof *counts);
    vvi_plot_density *density = vvi_answer_room(a, 1, sizeof *density);
    vvi_plot_mark *mark = vvi_answer_room(a, 1, sizeof *mark);
    vvi_plot *plot = vvi_answer_room(a, 1, sizeof *plot);
    if (!counts || !density || !mark || !plot)
        return;
    memcpy(counts, j->bins, n * sizeof *counts);
    gradient_unit(unit, info);
    const bool named = *info->name && strlen(info->name) <= 40; /* some names are a whole history */
    snprintf(x_label, sizeof x_label, "%s%s%s", named ? info->name : "value", *info->value_unit ? ", " : "",
             info->value_unit);
    snprintf(y_label, sizeof y_label, "length of the gradient, %s", unit);
    snprintf(title, sizeof title, "%.60s: %.9g samples, values and gradients", vvi_measuring_title(m),
             (double)j->count);
    *density = (vvi_plot_density){.counts = counts,
                                  .n_x = j->n_values,
                                  .n_y = j->n_gradients,
                                  .x_lo = j->value_lo,
                                  .x_hi = j->value_hi,
                                  .y_hi = j->gradient_hi,
                                  .label = "samples in a bin"};
    *mark = (vvi_plot_mark){m->choice.lo, "threshold", true};
    *plot = (vvi_plot){.title = vvi_answer_copy(a, title),
                       .subtitle = vvi_measuring_subset(m, object),
                       .x_label = vvi_answer_copy(a, x_label),
                       .y_label = vvi_answer_copy(a, y_label),
                       .density = density,
                       .marks = mark,
                       .n_marks = vvi_asks(m, "iso") && mark->x > j->value_lo && mark->x < j->value_hi};
    a->plot = plot;
}

static void take_options(vv_joint_options *out, const vvi_measuring *m)
{
    const vv_numbers *range = m->asked->range;
    vv_joint_options_init(out, sizeof *out);
    out->component = m->choice.component;
    if (vvi_asks(m, "bins"))
        out->n_values = out->n_gradients = m->asked->bins;
    if (range && range->n == 2) {
        out->value_lo = range->v[0];
        out->value_hi = range->v[1];
    }
}

vv_status vvi_measure_joint_histogram(vvi_measuring *m)
{
    vv_joint_options o;
    vv_joint *j = NULL;
    vvi_text small = {0};
    vv_measure_options of = m->choice;
    bool sensed, untold;
    vv_status st = VV_OK;
    if ((st = vvi_measuring_of_labels(&m->labels, &sensed, &untold, m)) != VV_OK)
        return st;
    if (m->labels && !sensed)
        return vv_fail(VV_E_ARGUMENT, "%s is of labels, whose numbers have no gradient: 'labels' measures each of them",
                       m->input->name);
    take_options(&o, m);
    if (of.seeded && (st = vvi_measuring_choose(m)) == VV_OK)
        of = m->choice;
    const bool marked = vvi_asks(m, "iso") && !of.seeded; /* in the plot */
    if (marked)
        of.lo = -INFINITY;
    const bool object = m->chosen && !marked;
    if (object || vvi_measuring_is_part(m))
        o.of = &of;
    if (st != VV_OK || (st = vv_measure_joint(&j, m->field, &o, m->job)) != VV_OK)
        return st;
    const char *region, *in = vvi_measuring_in(m, &region);
    keep_table(m, j);
    vvi_tell_text(m->answer, "values_of", object ? m->object : "all samples");
    vvi_tell_line(m->answer, "values", "%s%s%s", object ? m->object : "of all samples", in, region);
    put_figures(m, j);
    vvi_tell_line(m->answer, "bins", "%zu of values from %.6g to %.6g, %zu of gradients from 0 to %.6g", j->n_values,
                  j->value_lo, j->value_hi, j->n_gradients, j->gradient_hi);
    put_small(&small, j);
    vvi_tell_block(m->answer, &small);
    put_table(m->answer, j);
    put_counts(m, j);
    plot_joint(m, j, object);
    vv_joint_free(j);
    return VV_OK;
}
