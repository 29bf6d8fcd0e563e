/* Statistics and histogram of the values of the object, or of all samples. */
#include "measuring/measuring.h"
#include <inttypes.h>
#include <math.h>
#include <stdio.h>

static void put_value(vvi_measuring *m, const char *key, const char *label, double value, double error, double chance)
{
    vvi_figure f = {.key = key, .label = label, .value = value, .error = error, .chance = chance};
    snprintf(f.unit, sizeof f.unit, "%s", vv_field_get_info(m->field)->value_unit);
    vvi_tell_figure(m->answer, &f);
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

/* Of labels: which there are, and how they share the samples. Their numbers are names, and have no mean. */
static void put_label_values(vvi_measuring *m, const vv_values *v)
{
    vvi_tell_figure(m->answer, &(vvi_figure){"count", "samples", (double)v->count, NAN, ""});
    put_value(m, "min", "least label", v->min, NAN, 0);
    put_value(m, "max", "largest label", v->max, NAN, 0);
    if (v->exact)
        put_value(m, "mode", "most frequent", v->mode, v->count ? 0 : NAN, 0);
    vvi_tell_figure(m->answer, &(vvi_figure){"entropy", "entropy", v->count ? v->entropy : NAN, NAN, "bit"});
}

static void put_statistics(vvi_measuring *m, const vv_values *v)
{
    static const double percents[] = VV_VALUES_PERCENTS;
    const char *unit = vv_field_get_info(m->field)->value_unit;
    const double exact = v->count ? 0 : NAN, chance = v->count ? v->deviation / sqrt((double)v->count) : NAN;
    const int digits = percentile_digits(v);
    vvi_tell_figure(m->answer, &(vvi_figure){"count", "samples", (double)v->count, NAN, ""});
    vvi_tell_rare(m->answer, "nan_count", "not a number", v->nan_count);
    vvi_tell_rare(m->answer, "infinite_count", "infinite", v->infinite_count);
    put_value(m, "min", "least", v->min, NAN, 0);
    put_value(m, "max", "largest", v->max, NAN, 0);
    put_value(m, "mean", "mean", v->mean, NAN, chance);
    /* of chance, not of how it is found: no ± */
    put_value(m, "standard_error", "std error", chance, NAN, chance);
    put_value(m, "deviation", "deviation", v->deviation, NAN, chance / sqrt(2));
    put_value(m, "median", "median", v->median, exact, 0);
    put_value(m, "mode", "mode", v->mode, v->count ? v->within : NAN, 0);
    vvi_tell_figure(m->answer, &(vvi_figure){"entropy", "entropy", v->count ? v->entropy : NAN, NAN, "bit"});
    if (!v->count)
        vvi_tell_line(m->answer, "percentiles", "none");
    else
        vvi_tell_line(m->answer, "percentiles",
                      "0.1%%: %.*g  1%%: %.*g  25%%: %.*g  75%%: %.*g  99%%: %.*g  99.9%%: %.*g%s%s", digits,
                      v->percentile[0], digits, v->percentile[1], digits, v->percentile[2], digits, v->percentile[4],
                      digits, v->percentile[5], digits, v->percentile[6], *unit ? " " : "", unit);
    vvi_tell_open(m->answer, "percentiles", "{");
    for (int p = 0; p < 7; p++) {
        char key[32];
        snprintf(key, sizeof key, "%g", percents[p]);
        vvi_tell_number(m->answer, key, v->percentile[p]);
    }
    vvi_tell_close(m->answer, "}");
    for (int p = 0; p < 7; p++) {
        char key[32];
        vvi_figure f = {.key = key, .value = v->percentile[p], .error = exact};
        snprintf(key, sizeof key, "percentile_%g", percents[p]);
        snprintf(f.unit, sizeof f.unit, "%s", unit);
        vvi_tell_figure_for(m->answer, &f, VV_FOR_TABLES | VV_FOR_SCENES);
    }
    vvi_tell_number(m->answer, "percentiles_error", exact);
}

static void put_histogram(vv_answer *a, const vv_values *v)
{
    vvi_tell_open(a, "histogram", "{");
    vvi_tell_number(a, "lo", v->lo);
    vvi_tell_number(a, "hi", v->hi);
    vvi_tell_count(a, "n_bins", v->n_bins);
    vvi_tell_count(a, "below", v->below);
    vvi_tell_count(a, "above", v->above);
    vvi_tell_counts(a, "counts", v->bins, v->n_bins);
    vvi_tell_close(a, "}");
}

/* What lies beyond the bins stands in rows of its own. */
static void put_table(vv_answer *a, const vv_values *v)
{
    static const vv_answer_column columns[] = {{"lo", NULL, VV_CELL_NUMBER},
                                               {"hi", NULL, VV_CELL_NUMBER},
                                               {"count", NULL, VV_CELL_COUNT},
                                               {"cumulative", NULL, VV_CELL_COUNT}};
    enum { COLUMNS = sizeof columns / sizeof *columns };
    const double width = (v->hi - v->lo) / (double)v->n_bins;
    vv_cell *cells = vvi_answer_room(a, (v->n_bins + 2) * COLUMNS, sizeof *cells);
    uint64_t so_far = 0;
    size_t n = 0;
    for (size_t i = 0; cells && i < v->n_bins + 2; i++) {
        const bool below = i == 0, above = i == v->n_bins + 1;
        const uint64_t count = below ? v->below : above ? v->above : v->bins[i - 1];
        vv_cell *row = cells + n * COLUMNS;
        so_far += count;
        if ((below || above) && !count)
            continue;
        row[0].number = below ? -INFINITY : above ? v->hi : v->lo + (double)(i - 1) * width;
        row[1].number = below ? v->lo : above ? INFINITY : v->lo + (double)i * width;
        row[2].count = count;
        row[3].count = so_far;
        n++;
    }
    vvi_tell_table(a, NULL, columns, COLUMNS, cells, n);
}

/* The bars that `info` shows, of no more bins than it has. */
static void put_bars(vv_answer *a, const vv_values *v)
{
    vv_statistics *s = vvi_answer_room(a, 1, sizeof *s);
    if (!s)
        return;
    const size_t most = sizeof s->histogram / sizeof *s->histogram, each = v->n_bins / (most + 1) + 1;
    s->count = v->count;
    s->min = v->min;
    s->max = v->max;
    s->n_bins = (int)(v->n_bins / each); /* what is left over is left out: text shows sixteen bars */
    s->histogram_lo = v->lo;
    s->histogram_hi = v->lo + (v->hi - v->lo) * (double)((size_t)s->n_bins * each) / (double)v->n_bins;
    for (size_t i = 0; i < (size_t)s->n_bins * each; i++)
        s->histogram[i / each] += v->bins[i];
    vvi_tell_bars(a, s);
}

/* Plot ------------------------------------------------------------------------------------------------------------ */

enum { BARS_MOST = 1024, MARKS = 5 };

/* Percentiles, which labels do not have, and the threshold where one was asked for. */
static size_t make_marks(vvi_plot_mark *marks, const vvi_measuring *m, const vv_values *v)
{
    size_t n = 0;
    if (!m->labels) {
        marks[n++] = (vvi_plot_mark){v->percentile[1], "1 %", false};
        marks[n++] = (vvi_plot_mark){v->percentile[3], "median", false};
        marks[n++] = (vvi_plot_mark){v->percentile[5], "99 %", false};
    }
    const bool given = vvi_asks(m, "threshold_lo") || vvi_asks(m, "threshold_hi") || vvi_asks(m, "iso");
    if (given && m->choice.lo > v->lo && m->choice.lo < v->hi)
        marks[n++] = (vvi_plot_mark){m->choice.lo, "threshold", true};
    if (given && m->choice.hi < v->hi && m->choice.hi > v->lo)
        marks[n++] = (vvi_plot_mark){m->choice.hi, "threshold", true};
    return n;
}

static void plot_histogram(vvi_measuring *m, const vv_values *v, bool object)
{
    const size_t each = v->n_bins / (BARS_MOST + 1) + 1, n = (v->n_bins + each - 1) / each;
    const char *unit = vv_field_get_info(m->field)->value_unit, *name = vv_field_get_info(m->field)->name;
    vv_answer *a = m->answer;
    double *x = vvi_answer_room(a, 2 * n + 1, sizeof *x), *y = x ? x + n + 1 : NULL;
    vvi_plot_mark *marks = vvi_answer_room(a, MARKS, sizeof *marks);
    vvi_plot *plot = vvi_answer_room(a, 1, sizeof *plot);
    char x_label[96], title[160];
    if (!x || !marks || !plot)
        return;
    for (size_t i = 0; i < v->n_bins; i++)
        y[i / each] += (double)v->bins[i];
    for (size_t i = 0; i <= n; i++)
        x[i] = v->lo + (v->hi - v->lo) * fmin((double)(i * each) / (double)v->n_bins, 1);
    snprintf(x_label, sizeof x_label, "%s%s%s", *name ? name : "value", *unit ? ", " : "", unit);
    const int n_title = snprintf(title, sizeof title, "%.60s: %.9g samples", vvi_measuring_title(m), (double)v->count);
    if (!m->labels)
        snprintf(title + n_title, sizeof title - (size_t)n_title, ", mean %.5g, deviation %.4g", v->mean, v->deviation);
    *plot = (vvi_plot){.title = vvi_answer_copy(a, title),
                       .subtitle = vvi_measuring_subset(m, object),
                       .x_label = vvi_answer_copy(a, x_label),
                       .y_label = "samples",
                       .x = x,
                       .y = y,
                       .n = n,
                       .steps = true,
                       .marks = marks,
                       .n_marks = make_marks(marks, m, v)};
    a->plot = plot;
}

/* *object: they are of one, and not of all samples. */
static vv_status find_values(vv_values **out, bool *object, vvi_measuring *m, bool histogram)
{
    vv_values_options o;
    vv_status st = m->choice.seeded ? vvi_measuring_choose(m) : VV_OK;
    if (st != VV_OK)
        return st;
    vv_values_options_init(&o, sizeof o);
    o.component = m->choice.component;
    o.n_bins = vvi_asks(m, "bins") ? m->asked->bins : 0;
    vv_measure_options of = m->choice;
    const bool range = m->chosen && of.object == VV_OBJECT_RANGE && !of.seeded;
    if (histogram && range) { /* of all values, in which the range is marked */
        of.lo = -INFINITY;
        of.hi = INFINITY;
    }
    *object = m->chosen && !(histogram && range);
    if (*object || vvi_measuring_is_part(m))
        o.of = &of;
    if (m->asked->range && m->asked->range->n == 2) {
        o.lo = m->asked->range->v[0];
        o.hi = m->asked->range->v[1];
    }
    return vv_measure_values(out, m->field, &o, m->job);
}

/* As the scene or the file says, or as pictures show them. */
static vv_status put_figures(vvi_measuring *m, const vv_values *v)
{
    bool sensed = false, untold = false;
    const vv_status st = vvi_measuring_of_labels(&m->labels, &sensed, &untold, m);
    if (st != VV_OK)
        return st;
    if (!m->labels) {
        put_statistics(m, v);
        return VV_OK;
    }
    put_label_values(m, v);
    vvi_tell_note(m->answer,
                  "%s, whose numbers have no mean, deviation or percentiles: 'labels' measures each of them%s",
                  sensed ? "values look like labels" : "these are labels",
                  sensed ? "; a scene whose segmentation.kind is transfer says that they are amounts" : "");
    return VV_OK;
}

static vv_status put_values(vvi_measuring *m, const vv_values *v, bool object)
{
    const char *region, *in = vvi_measuring_in(m, &region);
    if (object && v->count + v->nan_count + v->infinite_count == 0)
        vvi_measuring_note_empty(m);
    vvi_tell_text(m->answer, "value_unit", vv_field_get_info(m->field)->value_unit);
    vvi_tell_text(m->answer, "values_of", object ? m->object : "all samples");
    vvi_measuring_put_seed(m);
    vvi_tell_line(m->answer, "values", "%s%s%s%s", object ? m->object : "of all samples",
                  m->choice.seeded ? "; the piece around the seed" : "", in, region);
    return put_figures(m, v);
}

vv_status vvi_measure_statistics(vvi_measuring *m)
{
    vv_values *v = NULL;
    bool object;
    vv_status st = find_values(&v, &object, m, false);
    if (st == VV_OK)
        st = put_values(m, v, object);
    vv_values_free(v);
    return st;
}

vv_status vvi_measure_histogram(vvi_measuring *m)
{
    vv_values *v = NULL;
    bool object;
    vv_status st = find_values(&v, &object, m, true);
    if (st != VV_OK || (st = put_values(m, v, object)) != VV_OK) {
        vv_values_free(v);
        return st;
    }
    const bool some = v->count > v->below + v->above;
    put_histogram(m->answer, v);
    put_table(m->answer, v);
    if (some)
        put_bars(m->answer, v);
    if (v->below + v->above)
        vvi_tell_line(m->answer, "outside", "%" PRIu64 " %s below the range, %" PRIu64 " above", v->below,
                      vvi_plural(v->below, "sample", "samples"), v->above);
    if (some)
        plot_histogram(m, v, object);
    else
        m->answer->no_plot = v->count ? "lies in --range" : "that is asked for is a number";
    vv_values_free(v);
    return VV_OK;
}
