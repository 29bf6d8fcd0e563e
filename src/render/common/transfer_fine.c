#include "render/common/transfer_fine.h"
#include "core/memory.h"
#include <math.h>
#include <string.h>

#define TOLERANCE 3e-4
#define ROUGH 1e-3      /* what the rows of the table may be off before one of them is split */
#define MOST_PARTS 2187 /* powers of 3: a ramp from 0 to 1 within a row is within 3e-4 */
#define JUMP_PARTS 243  /* enough where only a jump is left */
#define MOST_ROWS (1u << 18)

/* What a row is, and those parts of it that are asked for. */
typedef struct splitter {
    const vv_classification *classes;
    double lo, width; /* value of row 0; from a row to the next */
    double step;
    double tolerance;
} splitter;

/* Colour, and opacity of a step. */
static void seen(double out[4], const splitter *s, double value)
{
    vvi_transfer_evaluate(out, s->classes, value);
    out[3] = -expm1(-out[3] * s->step);
}

static double unlike(const double a[4], const double b[4])
{
    double most = 0;
    for (int c = 0; c < 4; c++)
        most = fmax(most, fabs(a[c] - b[c]));
    return most;
}

/* How far the parts of a row are off at their ends. */
static double error_at_ends(const splitter *s, double from, uint32_t parts)
{
    double left[4], right[4], middle[4], most = 0;
    seen(left, s, from);
    for (uint32_t i = 0; i < parts; i++) {
        seen(middle, s, from + s->width * (i + 0.5) / parts);
        seen(right, s, nextafter(from + s->width * (i + 1) / parts, -INFINITY)); /* a jump there is the next one's */
        most = fmax(most, fmax(unlike(left, middle), unlike(right, middle)));
        seen(left, s, from + s->width * (i + 1) / parts);
    }
    return most;
}

/* The same at the nodes (columns: values first) within the row, on both sides of each. Jumps that few values lie beside
 * are left out. */
static double error_at_nodes(const splitter *s, double from, uint32_t parts, const double *nodes, size_t n, int columns)
{
    double most = 0;
    size_t lo = 0, hi = n;
    while (lo < hi) { /* the first at `from` or above */
        const size_t mid = lo + (hi - lo) / 2;
        if (nodes[mid * (size_t)columns] < from)
            lo = mid + 1;
        else
            hi = mid;
    }
    for (; lo < n && nodes[lo * (size_t)columns] < from + s->width; lo++) {
        const double value = nodes[lo * (size_t)columns];
        const double part = fmin(floor((value - from) / s->width * parts), parts - 1.0);
        double at[4], below[4], middle[4];
        seen(at, s, value);
        seen(below, s, nextafter(value, -INFINITY));
        seen(middle, s, from + s->width * (part + 0.5) / parts);
        if (parts < JUMP_PARTS || unlike(at, below) < s->tolerance)
            most = fmax(most, fmax(unlike(at, middle), value > from ? unlike(below, middle) : 0));
    }
    return most;
}

/* Between nodes all is monotone, so that nothing is further off than at nodes and ends. */
static double error_of(const splitter *s, double from, uint32_t parts)
{
    const vv_classification *c = s->classes;
    const double nodes = fmax(error_at_nodes(s, from, parts, c->opacity, c->n_opacity, 2),
                              error_at_nodes(s, from, parts, c->color, c->n_color, 4));
    return nodes > s->tolerance ? nodes : fmax(nodes, error_at_ends(s, from, parts));
}

/* Into how many the row must be split; 0: it need not. */
static uint32_t parts_of(const splitter *s, size_t row)
{
    const double from = s->lo + ((double)row - 0.5) * s->width;
    if (error_of(s, from, 1) <= fmax(ROUGH, s->tolerance))
        return 0;
    uint32_t parts = 3;
    while (parts < MOST_PARTS && error_of(s, from, parts) > s->tolerance)
        parts *= 3;
    return parts;
}

static void mark_nodes(uint32_t *marks, const vvi_transfer_table *t, const double *nodes, size_t n, int columns)
{
    for (size_t i = 0; i < n; i++) {
        const double place = nodes[i * (size_t)columns] * t->scale + t->offset;
        if (place > -1 && place < (double)t->n)
            marks[(size_t)fmin(fmax(floor(place + 0.5), 0), (double)t->n - 1)] = 1;
    }
}

/* Rows that may have to be split: those that a node lies in, and where rows beside each other differ. */
static void mark_rows(uint32_t *marks, const vvi_transfer_table *t, const splitter *s)
{
    const vv_classification *c = s->classes;
    double before[4] = {0};
    mark_nodes(marks, t, c->opacity, c->n_opacity, 2);
    mark_nodes(marks, t, c->color, c->n_color, 4);
    for (size_t i = 0; i < t->n; i++) {
        const float *row = t->rgbk + 4 * i;
        const double here[4] = {(double)row[0], (double)row[1], (double)row[2], -expm1(-(double)row[3] * s->step)};
        if (i > 0 && unlike(here, before) > ROUGH)
            marks[i - 1] = marks[i] = 1;
        memcpy(before, here, sizeof before);
    }
}

/* parts and first of all rows that are marked. */
static size_t split_rows(vvi_transfer_fine *out, const vvi_transfer_table *t, splitter *s)
{
    size_t n = 0;
    for (size_t i = 0; i < t->n; i++) {
        if (!out->first[i])
            continue;
        out->parts[i] = parts_of(s, i);
        n += out->parts[i];
    }
    return n;
}

static void fill(vvi_transfer_fine *out, vvi_transfer_table *t, const splitter *s)
{
    size_t at = 0;
    for (size_t i = 0; i < t->n; i++) {
        bool any = t->rgbk[4 * i + 3] > 0;
        out->first[i] = (uint32_t)(t->n + at);
        for (uint32_t p = 0; p < out->parts[i]; p++, at++) {
            double rgbk[4];
            vvi_transfer_evaluate(rgbk, s->classes, s->lo + s->width * ((double)i + (p + 0.5) / out->parts[i] - 0.5));
            for (size_t c = 0; c < 4; c++)
                out->rgbk[4 * at + c] = (float)rgbk[c];
            any |= rgbk[3] > 0;
        }
        t->running[i + 1] = t->running[i] + any;
    }
}

vv_status vvi_transfer_fine_init(vvi_transfer_fine *out, vvi_transfer_table *table, const vv_classification *classes,
                                 double step, vv_job *job)
{
    const size_t rows = table->n * sizeof *out->first;
    splitter s = {classes, table->lo, (table->hi - table->lo) / (double)(table->n - 1), step, TOLERANCE};
    *out = (vvi_transfer_fine){0};
    out->first = vvi_alloc_zeroed(job, rows, VVI_MEM_DERIVED);
    out->parts = vvi_alloc_zeroed(job, rows, VVI_MEM_DERIVED);
    if (!out->first || !out->parts) {
        vvi_transfer_fine_finish(out);
        return vv_fail_memory(2 * rows);
    }
    if (!(s.width > 0))
        return VV_OK;
    mark_rows(out->first, table, &s);
    while ((out->n_rows = split_rows(out, table, &s)) > MOST_ROWS)
        s.tolerance *= 3;
    if (!out->n_rows)
        return VV_OK;
    const size_t bytes = out->n_rows * 4 * sizeof *out->rgbk;
    out->rgbk = vvi_alloc(job, bytes, VVI_MEM_DERIVED);
    if (!out->rgbk) {
        vvi_transfer_fine_finish(out);
        return vv_fail_memory(bytes);
    }
    fill(out, table, &s);
    return VV_OK;
}

void vvi_transfer_fine_finish(vvi_transfer_fine *fine)
{
    vvi_free(fine->first);
    vvi_free(fine->parts);
    vvi_free(fine->rgbk);
    *fine = (vvi_transfer_fine){0};
}
