/* Statistics and histogram of the values of the object, or of all samples. */
#include "histogram.h"
#include "measure.h"
#include "measure_plot.h"
#include "value.h"
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void put_count(cli_measuring *m, const char *key, const char *label, double count)
{
    cli_figure_put(m->result, &(cli_figure){.key = key, .label = label, .value = count, .error = NAN});
}

static void put_value(cli_measuring *m, const char *key, const char *label, double value, double error, double chance)
{
    cli_figure f = {.key = key, .label = label, .value = value, .error = error, .chance = chance};
    snprintf(f.unit, sizeof f.unit, "%s", vv_field_get_info(m->field)->value_unit);
    cli_figure_put(m->result, &f);
}

/* As many digits as tell neighbouring percentiles apart, and one more. */
static int percentile_digits(const vv_values *v)
{
    double least = INFINITY, largest = 0;
    for (int p = 0; p < 7; p++) {
        const double step = p ? v->percentile[p] - v->percentile[p - 1] : 0;
        least = step > 0 ? fmin(least, step) : least;
        largest = fmax(largest, fabs(v->percentile[p]));
    }
    return isfinite(least) && largest > 0 ? (int)fmin(fmax(ceil(log10(largest / least)) + 2, 6), 15) : 6;
}

static void put_statistics(cli_measuring *m, const vv_values *v)
{
    static const double percents[] = VV_VALUES_PERCENTS;
    const char *unit = vv_field_get_info(m->field)->value_unit;
    const double exact = v->count ? 0 : NAN, chance = v->count ? v->deviation / sqrt((double)v->count) : NAN;
    const int digits = percentile_digits(v);
    put_count(m, "count", "samples", (double)v->count);
    if (v->nan_count || m->result->csv)
        put_count(m, "nan_count", "not a number", (double)v->nan_count);
    if (v->infinite_count || m->result->csv)
        put_count(m, "infinite_count", "infinite", (double)v->infinite_count);
    put_value(m, "min", "least", v->min, NAN, 0);
    put_value(m, "max", "largest", v->max, NAN, 0);
    put_value(m, "mean", "mean", v->mean, NAN, chance);
    /* of chance, not of how it is found: no ± */
    put_value(m, "standard_error", "std error", chance, NAN, chance);
    put_value(m, "deviation", "deviation", v->deviation, NAN, chance / sqrt(2));
    put_value(m, "median", "median", v->median, exact, 0);
    put_value(m, "mode", "mode", v->mode, v->count ? v->within : NAN, 0);
    cli_figure_put(m->result, &(cli_figure){"entropy", "entropy", v->count ? v->entropy : NAN, NAN, "bit"});
    if (!m->result->csv && !v->count)
        cli_command_line(m->command, "percentiles", "none");
    if (!m->result->csv && v->count)
        cli_command_line(m->command, "percentiles",
                         "0.1%%: %.*g  1%%: %.*g  25%%: %.*g  75%%: %.*g  99%%: %.*g  99.9%%: %.*g%s%s", digits,
                         v->percentile[0], digits, v->percentile[1], digits, v->percentile[2], digits, v->percentile[4],
                         digits, v->percentile[5], digits, v->percentile[6], *unit ? " " : "", unit);
    vvi_result_open(&m->command->json, "percentiles", '{');
    for (int p = 0; p < 7; p++) {
        char key[32];
        cli_figure f = {.key = key, .value = v->percentile[p], .error = exact};
        snprintf(key, sizeof key, "percentile_%g", percents[p]);
        snprintf(f.unit, sizeof f.unit, "%s", unit);
        vvi_result_number(&m->command->json, key + strlen("percentile_"), v->percentile[p]);
        cli_figure_keep(m->result, &f);
        if (m->result->csv)
            cli_figure_row(&m->command->text, &f);
    }
    vvi_result_close(&m->command->json, '}');
    vvi_result_number(&m->command->json, "percentiles_error", exact);
}

static vv_status put_histogram_json(vvi_result *json, const vv_values *v)
{
    vvi_text text = {0};
    vvi_text_add(&text, "[");
    for (size_t i = 0; i < v->n_bins; i++)
        vvi_text_printf(&text, "%s%" PRIu64, i ? ", " : "", v->bins[i]);
    vvi_text_add(&text, "]");
    vvi_result_open(json, "histogram", '{');
    vvi_result_number(json, "lo", v->lo);
    vvi_result_number(json, "hi", v->hi);
    vvi_result_integer(json, "n_bins", (int64_t)v->n_bins);
    vvi_result_unsigned(json, "below", v->below);
    vvi_result_unsigned(json, "above", v->above);
    if (!text.bad)
        vvi_result_raw(json, "counts", text.s);
    vvi_result_close(json, '}');
    const bool bad = text.bad;
    vvi_text_free(&text);
    return bad ? vv_fail_memory(v->n_bins * 8) : VV_OK;
}

static void put_histogram_csv(vvi_text *out, const vv_values *v)
{
    uint64_t below = v->below;
    vvi_text_add(out, "lo,hi,count,cumulative\n");
    if (v->below)
        vvi_text_printf(out, "-inf,%.17g,%" PRIu64 ",%" PRIu64 "\n", v->lo, v->below, below);
    for (size_t i = 0; i < v->n_bins; i++) {
        const double width = (v->hi - v->lo) / (double)v->n_bins;
        below += v->bins[i];
        vvi_text_printf(out, "%.17g,%.17g,%" PRIu64 ",%" PRIu64 "\n", v->lo + (double)i * width,
                        v->lo + (double)(i + 1) * width, v->bins[i], below);
    }
    if (v->above)
        vvi_text_printf(out, "%.17g,inf,%" PRIu64 ",%" PRIu64 "\n", v->hi, v->above, below + v->above);
}

/* The bars that `info` shows, of no more bins than it has. */
static vv_status put_bars(cli_measuring *m, const vv_values *v)
{
    vv_statistics *s = calloc(1, sizeof *s);
    if (!s)
        return vv_fail_memory(sizeof *s);
    const size_t most = sizeof s->histogram / sizeof *s->histogram, each = v->n_bins / (most + 1) + 1;
    s->count = v->count;
    s->min = v->min;
    s->max = v->max;
    s->n_bins = (int)(v->n_bins / each); /* what is left over is left out: text shows sixteen bars */
    s->histogram_lo = v->lo;
    s->histogram_hi = v->lo + (v->hi - v->lo) * (double)((size_t)s->n_bins * each) / (double)v->n_bins;
    for (size_t i = 0; i < (size_t)s->n_bins * each; i++)
        s->histogram[i / each] += v->bins[i];
    cli_histogram_text(&m->command->text, s, m->o->log);
    free(s);
    return VV_OK;
}

/* Plot ------------------------------------------------------------------------------------------------------------ */

enum { BARS_MOST = 1024, MARKS = 5 };

/* Percentiles, and the threshold where one was asked for. */
static size_t make_marks(vvi_plot_mark *marks, const cli_measuring *m, const vv_values *v)
{
    size_t n = 0;
    marks[n++] = (vvi_plot_mark){v->percentile[1], "1 %", false};
    marks[n++] = (vvi_plot_mark){v->percentile[3], "median", false};
    marks[n++] = (vvi_plot_mark){v->percentile[5], "99 %", false};
    const bool given = m->o->threshold || m->o->iso;
    if (given && m->choice.lo > v->lo && m->choice.lo < v->hi)
        marks[n++] = (vvi_plot_mark){m->choice.lo, "threshold", true};
    if (given && m->choice.hi < v->hi && m->choice.hi > v->lo)
        marks[n++] = (vvi_plot_mark){m->choice.hi, "threshold", true};
    return n;
}

static vv_status plot_histogram(cli_measuring *m, const vv_values *v, bool object)
{
    const size_t each = v->n_bins / (BARS_MOST + 1) + 1, n = (v->n_bins + each - 1) / each;
    const char *unit = vv_field_get_info(m->field)->value_unit, *name = vv_field_get_info(m->field)->name;
    double *x = calloc(2 * n + 1, sizeof *x), *y = x ? x + n + 1 : NULL;
    vvi_plot_mark marks[MARKS];
    char x_label[96], title[160], subset[CLI_SUBSET_ROOM];
    if (!x)
        return vv_fail_memory((2 * n + 1) * sizeof *x);
    for (size_t i = 0; i < v->n_bins; i++)
        y[i / each] += (double)v->bins[i];
    for (size_t i = 0; i <= n; i++)
        x[i] = v->lo + (v->hi - v->lo) * fmin((double)(i * each) / (double)v->n_bins, 1);
    snprintf(x_label, sizeof x_label, "%s%s%s", *name ? name : "value", *unit ? ", " : "", unit);
    const char *slash = strrchr(m->input.path, '/');
    snprintf(title, sizeof title, "%.60s: %.9g samples, mean %.5g, deviation %.4g", slash ? slash + 1 : m->input.path,
             (double)v->count, v->mean, v->deviation);
    cli_plot_subset(subset, m, object);
    const vvi_plot plot = {.title = title,
                           .subtitle = subset,
                           .x_label = x_label,
                           .y_label = "samples",
                           .x = x,
                           .y = y,
                           .n = n,
                           .steps = true,
                           .log_y = m->o->log,
                           .marks = marks,
                           .n_marks = make_marks(marks, m, v)};
    const vv_status st = cli_plot_write(m->command, &plot);
    free(x);
    return st;
}

vv_status cli_measure_values(cli_measuring *m, bool histogram)
{
    vv_values_options o;
    vv_values *v = NULL;
    vv_status st = m->choice.seeded ? cli_measuring_choose(m) : VV_OK;
    if (st != VV_OK)
        return st;
    vv_values_options_init(&o, sizeof o);
    o.component = m->choice.component;
    o.n_bins = m->o->bins;
    if (!vv_object_is_set(&m->o->base, "bins"))
        o.n_bins = 0;
    vv_measure_options of = m->choice;
    const bool range = m->chosen && of.object == VV_OBJECT_RANGE && !of.seeded;
    if (histogram && range) { /* of all values, in which the range is marked */
        of.lo = -INFINITY;
        of.hi = INFINITY;
    }
    const bool object = m->chosen && !(histogram && range);
    if (object || m->n_planes || m->o->box)
        o.of = &of;
    st = m->o->range ? cli_range_parse(&o.lo, &o.hi, m->o->range) : VV_OK;
    if (st != VV_OK || (st = vv_measure_values(&v, m->field, &o, m->command->job)) != VV_OK)
        return st;
    if (object && v->count + v->nan_count + v->infinite_count == 0)
        cli_measuring_note_empty(m);
    vvi_result_string(&m->command->json, "value_unit", vv_field_get_info(m->field)->value_unit);
    vvi_result_string(&m->command->json, "values_of", object ? m->object : "all samples");
    cli_measuring_put_seed(m);
    if (!m->result->csv)
        cli_command_line(m->command, "values", "%s%s%s%s", object ? m->object : "of all samples",
                         m->choice.seeded ? "; the piece around the seed" : "", strcmp(m->region, "all") ? " in " : "",
                         strcmp(m->region, "all") ? m->region : "");
    if (!histogram || !m->result->csv)
        put_statistics(m, v);
    if (histogram && (st = put_histogram_json(&m->command->json, v)) == VV_OK) {
        if (m->result->csv)
            put_histogram_csv(&m->command->text, v);
        else if (v->count > v->below + v->above)
            st = put_bars(m, v);
        if (!m->result->csv && v->below + v->above)
            cli_command_line(m->command, "outside", "%" PRIu64 " %s below the range, %" PRIu64 " above", v->below,
                             cli_plural(v->below, "sample", "samples"), v->above);
        if (st == VV_OK && cli_plot_wanted(m->command))
            st = v->count > v->below + v->above
                     ? plot_histogram(m, v, object)
                     : vv_fail(VV_E_ARGUMENT, "-o %s: no sample of %s %s: there is nothing to plot",
                               m->command->common->output, m->input.path,
                               v->count ? "lies in --range" : "that is asked for is a number");
    }
    vv_values_free(v);
    return st;
}
