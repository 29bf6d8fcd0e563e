#include "scene/transfer.h"
#include "core/memory.h"
#include "grid/label_color.h"
#include "grid/label_id.h"
#include "grid/lattice.h"
#include "scene/colormaps.h"
#include <math.h>
#include <string.h>

#define MAX_LABELS (1u << 20)

double vvi_transfer_kappa(double alpha, double length)
{
    const double most = 1.0 - 0x1p-24; /* else the logarithm of 0 */
    if (!(alpha > 0))
        return 0;
    return -log1p(-fmin(alpha, most)) / length;
}

/* Rows of `columns` numbers ascending in the first: the last row whose value is <= x, or -1. Of rows at one value this
 * is the last one, so a jump has its upper side at the value itself. */
static ptrdiff_t last_row_at_or_below(const double *rows, size_t n, int columns, double x)
{
    size_t lo = 0, hi = n;
    while (lo < hi) {
        const size_t mid = lo + (hi - lo) / 2;
        if (rows[mid * (size_t)columns] <= x)
            lo = mid + 1;
        else
            hi = mid;
    }
    return (ptrdiff_t)lo - 1;
}

/* Piecewise linear; out has columns - 1 numbers. */
static void interpolate(double *out, const double *rows, size_t n, int columns, double x)
{
    const ptrdiff_t at = last_row_at_or_below(rows, n, columns, x);
    const size_t below = at < 0 ? 0 : (size_t)at;
    const double *a = rows + below * (size_t)columns;
    const bool outside = at < 0 || below + 1 == n;
    const double *b = outside ? a : a + columns;
    const double t = outside ? 0 : (x - a[0]) / (b[0] - a[0]);
    for (int c = 1; c < columns; c++)
        out[c - 1] = t == 0 ? a[c] : a[c] + t * (b[c] - a[c]);
}

/* A double that is this very integer. */
static bool is_label(double row, vv_label_id label, bool is_unsigned)
{
    if (is_unsigned)
        return row >= 0 && row < 0x1p64 && (uint64_t)row == (uint64_t)label && (double)(uint64_t)row == row;
    return row >= -0x1p63 && row < 0x1p63 && (int64_t)row == label && (double)(int64_t)row == row;
}

/* Ids that are one double stand in a run of rows. */
static const double *row_of(const vv_classification *c, vv_label_id label, bool is_unsigned)
{
    const double value = vvi_label_value(label, is_unsigned);
    ptrdiff_t at = last_row_at_or_below(c->labels, c->n_labels, 5, value);
    for (; at >= 0 && c->labels[at * 5] == value; at--)
        if (c->label_ids ? c->label_ids[at] == label : is_label(value, label, is_unsigned))
            return c->labels + at * 5;
    return NULL;
}

void vvi_transfer_label(double out[4], const vv_classification *c, vv_label_id label, bool is_unsigned)
{
    const double *row = row_of(c, label, is_unsigned);
    double alpha = label == 0 ? 0 : c->label_opacity;
    vvi_label_color(out, label);
    if (row) {
        memcpy(out, row + 1, 3 * sizeof *out);
        alpha = row[4];
    }
    out[3] = vvi_transfer_kappa(alpha, c->opacity_length) * c->opacity_scale;
}

static void evaluate_label(double out[4], const vv_classification *c, double value)
{
    const double label = round(value);
    if (c->ids) {
        const double last = (double)c->n_ids - 1;
        vvi_transfer_label(out, c, c->ids[(size_t)fmin(fmax(label, 0), last)], c->ids_unsigned);
    } else if (label >= 0x1p63) {
        vvi_transfer_label(out, c, label < 0x1p64 ? (int64_t)(uint64_t)label : -1, true);
    } else {
        vvi_transfer_label(out, c, label >= -0x1p63 ? (int64_t)label : INT64_MIN, false);
    }
}

void vvi_transfer_evaluate(double out[4], const vv_classification *c, double value)
{
    double alpha = 0;
    memset(out, 0, 4 * sizeof *out);
    if (isnan(value))
        return;
    if (c->kind == VV_SEGMENT_LABELS) {
        evaluate_label(out, c, value);
        return;
    }
    if (c->n_color)
        interpolate(out, c->color, c->n_color, 4, value);
    if (c->kind == VV_SEGMENT_THRESHOLD) {
        out[3] = value >= c->lo && value <= c->hi ? VVI_KAPPA_SOLID : 0;
        return;
    }
    if (c->n_opacity)
        interpolate(&alpha, c->opacity, c->n_opacity, 2, value);
    out[3] = vvi_transfer_kappa(alpha, c->opacity_length) * c->opacity_scale;
}

/* Of numbers that stand for labels. */
static bool ids_visible(const vv_classification *c, double first, double last)
{
    bool any = false;
    for (double i = fmax(first, 0); i <= last && i < (double)c->n_ids && !any; i++) {
        double rgbk[4];
        evaluate_label(rgbk, c, i);
        any = rgbk[3] > 0;
    }
    return any;
}

/* Whole numbers in [a, b] that no clear row takes away. */
static bool labels_visible(const vv_classification *c, double a, double b)
{
    const double first = round(a), last = round(b); /* a value takes the nearest label */
    if (c->ids)
        return ids_visible(c, first, last);
    double automatic = last - first + 1;
    bool zero_has_row = false;
    for (size_t i = 0; i < c->n_labels; i++) {
        const double *row = c->labels + i * 5;
        if (row[0] < first || row[0] > last)
            continue;
        if (row[4] > 0)
            return true;
        zero_has_row |= row[0] == 0;
        automatic -= 1;
    }
    if (first <= 0 && last >= 0 && !zero_has_row)
        automatic -= 1;
    return c->label_opacity > 0 && automatic > 0;
}

static bool opacity_visible(const vv_classification *c, double a, double b)
{
    double alpha_a = 0, alpha_b = 0;
    if (!c->n_opacity)
        return false;
    interpolate(&alpha_a, c->opacity, c->n_opacity, 2, a);
    interpolate(&alpha_b, c->opacity, c->n_opacity, 2, b);
    if (alpha_a > 0 || alpha_b > 0)
        return true;
    for (size_t i = 0; i < c->n_opacity; i++) {
        const double *row = c->opacity + i * 2;
        const bool first_there = i == 0 || row[-2] < row[0];
        const bool last_there = i + 1 == c->n_opacity || row[2] > row[0];
        if (row[1] <= 0 || (!first_there && !last_there)) /* a row between two others at one value is never reached */
            continue;
        if ((last_there && row[0] >= a && row[0] <= b) || (first_there && i > 0 && row[0] > a && row[0] <= b))
            return true;
    }
    return false;
}

double vvi_transfer_most_opaque(const vv_classification *c, double a, double b)
{
    double alpha_a = 0, alpha_b = 0;
    if (!c->n_opacity)
        return 0;
    interpolate(&alpha_a, c->opacity, c->n_opacity, 2, a);
    interpolate(&alpha_b, c->opacity, c->n_opacity, 2, b);
    double most = fmax(alpha_a, alpha_b);
    for (size_t i = 0; i < c->n_opacity; i++)
        if (c->opacity[2 * i] >= a && c->opacity[2 * i] <= b)
            most = fmax(most, c->opacity[2 * i + 1]);
    return most;
}

bool vvi_transfer_visible(const vv_classification *c, double a, double b)
{
    if (c->kind == VV_SEGMENT_THRESHOLD)
        return a <= c->hi && b >= c->lo;
    if (!(c->opacity_scale > 0))
        return false;
    return c->kind == VV_SEGMENT_LABELS ? labels_visible(c, a, b) : opacity_visible(c, a, b);
}

bool vvi_transfer_nodes(double *first, double *last, const vv_classification *c)
{
    *first = INFINITY;
    *last = -INFINITY;
    if (c->kind == VV_SEGMENT_THRESHOLD) {
        *first = c->lo;
        *last = c->hi;
    } else if (c->n_opacity) {
        *first = c->opacity[0];
        *last = c->opacity[2 * (c->n_opacity - 1)];
    }
    if (c->n_color) {
        *first = fmin(*first, c->color[0]);
        *last = fmax(*last, c->color[4 * (c->n_color - 1)]);
    }
    return *first <= *last;
}

void vvi_transfer_around(double *lo, double *hi, size_t n_rows, double least_row)
{
    const double width = *hi - *lo, rows = (double)n_rows - 1;
    const double margin = fmax(2 * width / (rows - 4), (least_row * rows - width) / 2);
    *lo -= margin;
    *hi += margin;
}

double vvi_transfer_least_row(double from_zero, double range)
{
    return fmax(fabs(from_zero) * 0x1p-21, fmin(range, 1) * 0x1p-50);
}

static double least_row_at(double value, const vv_field_info *info, const vv_statistics *s)
{
    return vvi_transfer_least_row(value - vvi_lattice_zero(info, s), s->max - s->min);
}

/* Outside the first and last node nothing changes, so rows there would be wasted: an f32 field with one hot sample
 * would have none left for the rest. */
static void changing_interval(double *lo, double *hi, const vv_classification *c, const vv_field_info *info,
                              const vv_statistics *s)
{
    double first, last;
    if (!vvi_transfer_nodes(&first, &last, c))
        return;
    double a = fmin(fmax(*lo, first), *hi), b = fmax(fmin(*hi, last), *lo);
    vvi_transfer_around(&a, &b, VVI_TRANSFER_ROWS, fmax(least_row_at(a, info, s), least_row_at(b, info, s)));
    *lo = fmax(*lo, a);
    *hi = fmin(*hi, b);
}

/* The same for integers, in whole steps, at least one of them outside: *n stored values from *lo to *hi. */
static void changing_steps(double *lo, double *hi, size_t *n, const vv_classification *c, double step)
{
    const double all = round((*hi - *lo) / step), from = *lo;
    double first, last, i = 0, j = all;
    if (vvi_transfer_nodes(&first, &last, c)) {
        i = fmin(fmax(floor((first - from) / step) - 1, 0), all);
        j = fmax(fmin(ceil((last - from) / step) + 1, all), 0);
        i = j > i ? i : fmax(j - 1, 0); /* all nodes beyond the data: two rows of what lasts there */
        j = j > i ? j : fmin(i + 1, all);
    }
    *lo = from + i * step;
    *hi = j == all ? *hi : from + j * step;
    *n = (size_t)(j - i) + 1;
}

size_t vvi_transfer_finer(size_t n, double lo, double hi, const vv_field_info *info)
{
    if (n < 2 || n >= VVI_TRANSFER_ROWS)
        return n;
    const size_t each = (VVI_TRANSFER_ROWS - 1 + n - 2) / (n - 1);
    if (vv_type_is_float(info->type))
        return (n - 1) * each + 1;
    const double most = fmax(fabs(lo - info->value_offset), fabs(hi - info->value_offset)) / fabs(info->value_scale);
    const double exact = fmax(floor(0x1p22 / most), 1);
    return (n - 1) * (size_t)fmin((double)each, exact) + 1;
}

vv_status vvi_transfer_domain(double *lo_out, double *hi_out, size_t *n_out, const vv_classification *classes,
                              const vv_field_info *info, const vv_statistics *statistics)
{
    double lo = statistics->min, hi = statistics->max;
    const double step = fabs(info->value_scale);
    *n_out = VVI_TRANSFER_ROWS;
    if (classes->kind == VV_SEGMENT_LABELS) {
        lo = classes->ids ? 0 : round(lo);
        hi = classes->ids ? (double)classes->n_ids - 1 : round(hi);
        if (hi - lo + 1 > MAX_LABELS)
            return vv_fail(VV_E_LIMIT,
                           "labels lie between %.17g and %.17g; at most %u different numbers can be told apart", lo, hi,
                           MAX_LABELS);
        *n_out = (size_t)(hi - lo) + 1;
    } else if (!vv_type_is_float(info->type) && (hi - lo) / step < 65535.5) {
        changing_steps(&lo, &hi, n_out, classes, step);
    } else {
        changing_interval(&lo, &hi, classes, info, statistics);
    }
    *n_out = *n_out < 2 ? 2 : *n_out;
    *lo_out = lo;
    *hi_out = hi;
    return VV_OK;
}

static void fill_rows(vvi_transfer_table *table, const vv_classification *classes)
{
    const double step = (table->hi - table->lo) / (double)(table->n - 1);
    table->running[0] = 0;
    for (size_t i = 0; i < table->n; i++) {
        double rgbk[4];
        const double value = i + 1 == table->n ? table->hi : table->lo + (double)i * step;
        vvi_transfer_evaluate(rgbk, classes, value);
        float *row = table->rgbk + i * 4;
        for (int c = 0; c < 4; c++)
            row[c] = (float)rgbk[c];
        table->running[i + 1] = table->running[i] + (row[3] > 0);
    }
}

vv_status vvi_transfer_table_init(vvi_transfer_table *out, const vv_classification *classes, double lo, double hi,
                                  size_t n, vv_job *job)
{
    size_t bytes = 0, running_bytes = 0;
    vv_status st = VV_OK;
    *out = (vvi_transfer_table){.n = n < 2 ? 2 : n, .lo = lo, .hi = hi};
    if ((st = vvi_mul3_size(&bytes, out->n, 4, sizeof(float))) != VV_OK ||
        (st = vvi_mul_size(&running_bytes, out->n + 1, sizeof(uint32_t))) != VV_OK)
        goto fail;
    out->rgbk = vvi_alloc(job, bytes, VVI_MEM_DERIVED);
    out->running = vvi_alloc(job, running_bytes, VVI_MEM_DERIVED);
    if (!out->rgbk || !out->running) {
        st = vv_fail_memory(bytes + running_bytes);
        goto fail;
    }
    if (hi != lo)
        out->scale = (double)(out->n - 1) / (hi - lo);
    out->offset = -lo * out->scale;
    fill_rows(out, classes);
    return VV_OK;
fail:
    vvi_transfer_table_finish(out);
    return st;
}

void vvi_transfer_table_finish(vvi_transfer_table *table)
{
    vvi_free(table->rgbk);
    vvi_free(table->running);
    *table = (vvi_transfer_table){0};
}

bool vvi_transfer_occupancy(const vvi_transfer_table *table, double a, double b)
{
    const double top = (double)(table->n - 1);
    double first = a * table->scale + table->offset, last = b * table->scale + table->offset;
    if (first > last) { /* a table that runs downwards */
        const double t = first;
        first = last;
        last = t;
    }
    first = fmin(fmax(floor(first), 0), top);
    last = fmin(fmax(ceil(last), 0), top);
    return vvi_transfer_occupied(table, (int64_t)first, (int64_t)last);
}
