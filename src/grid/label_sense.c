/* Two looks at some rows: which values there are and how long they last, then which lie beside each other. */
#include "grid/label_sense.h"
#include "core/cache.h"
#include "core/job.h"
#include "core/memory.h"
#include "grid/label_id.h"
#include <math.h>
#include <stdlib.h>

enum { ROWS_ALONG = 64, LEAST_LABELS = 7, LEAST_PAIRS = 256, MOST_VALUES = 1 << 18 };
#define EQUAL_SHARE 0.8
#define LONE_SHARE 0.05
#define REGION_SHARE 0.75
#define NEXT_SHARE 0.5
/* Ids: two at least so far from 0, with no step that goes into them fewer times than this. */
#define ID_LEAST (UINT64_C(1) << 24)
#define ID_STEPS (UINT64_C(1) << 16)

typedef struct value_row {
    int64_t value;
    uint64_t samples, runs;
} value_row;

typedef struct look {
    const vv_field *field;
    vv_brick brick; /* the slice that is looked at */
    int component;
    int64_t *row;
    const vv_field_info *info;
    value_row *values; /* a hash table with open places: those without runs are free */
    size_t n, room;
    int64_t background;
    uint64_t seen, runs;
    uint64_t pairs, equal, lone, samples; /* without the background */
    uint64_t steps, next;                 /* from one value to another, and to the next one there is */
    bool ids;                             /* few, and nothing else than ids is so far from 0 */
    vv_job *job;
} look;

static value_row *place_of(const look *l, int64_t value)
{
    uint64_t h = (uint64_t)value;
    h = (h ^ h >> 32) * 0x9e3779b97f4a7c15u;
    size_t i = (size_t)(h >> 24) & (l->room - 1);
    while (l->values[i].runs && l->values[i].value != value)
        i = (i + 1) & (l->room - 1);
    return &l->values[i];
}

static vv_status grow(look *l)
{
    look grown = *l;
    grown.room = l->room ? 2 * l->room : 1024;
    grown.values = vvi_alloc_zeroed(l->job, grown.room * sizeof *grown.values, VVI_MEM_SCRATCH);
    if (!grown.values)
        return vv_fail_memory(grown.room * sizeof *grown.values);
    for (size_t i = 0; i < l->room; i++)
        if (l->values[i].runs)
            *place_of(&grown, l->values[i].value) = l->values[i];
    vvi_free(l->values);
    *l = grown;
    return VV_OK;
}

static vv_status add_run(look *l, int64_t value, uint64_t samples)
{
    const vv_status st = 2 * l->n >= l->room ? grow(l) : VV_OK;
    if (st != VV_OK)
        return st;
    value_row *at = place_of(l, value);
    l->n += !at->runs;
    at->value = value;
    at->samples += samples;
    at->runs++;
    return VV_OK;
}

/* Noise is told early, or millions of values would be looked for. */
static bool is_noise(const look *l)
{
    return l->n > MOST_VALUES || (l->seen > 1 << 16 && 2 * l->runs > l->seen);
}

static vv_status count_runs(look *l)
{
    vv_status st = VV_OK;
    for (int64_t i = 0, end; i < l->info->grid.dims[0] && st == VV_OK; i = end) {
        for (end = i + 1; end < l->info->grid.dims[0] && l->row[end] == l->row[i];)
            end++;
        st = add_run(l, l->row[i], (uint64_t)(end - i));
        l->runs++;
    }
    l->seen += (uint64_t)l->info->grid.dims[0];
    return st;
}

static int by_value(const void *a, const void *b)
{
    const int64_t x = ((const value_row *)a)->value, y = ((const value_row *)b)->value;
    return (x > y) - (x < y);
}

/* The values, ascending, take the table's place. */
static void sort_values(look *l)
{
    size_t n = 0;
    uint64_t most = 0;
    for (size_t i = 0; i < l->room; i++)
        if (l->values[i].runs)
            l->values[n++] = l->values[i];
    qsort(l->values, n, sizeof *l->values, by_value);
    for (size_t i = 0; i < n; i++)
        if (l->values[i].samples > most) {
            most = l->values[i].samples;
            l->background = l->values[i].value;
        }
}

static size_t number_of(const look *l, int64_t value)
{
    const value_row key = {.value = value};
    const value_row *at = bsearch(&key, l->values, l->n, sizeof key, by_value);
    return at ? (size_t)(at - l->values) : 0;
}

static vv_status count_pairs(look *l)
{
    const int64_t n = l->info->grid.dims[0];
    for (int64_t i = 0; i < n; i++) {
        const int64_t v = l->row[i];
        if (v == l->background)
            continue;
        l->samples++;
        l->lone += (i == 0 || l->row[i - 1] != v) && (i + 1 == n || l->row[i + 1] != v);
        if (i == 0 || l->row[i - 1] == l->background)
            continue;
        l->pairs++;
        l->equal += l->row[i - 1] == v;
        if (l->row[i - 1] != v) {
            const size_t a = number_of(l, l->row[i - 1]), b = number_of(l, v);
            l->steps++;
            l->next += a + 1 == b || b + 1 == a;
        }
    }
    return VV_OK;
}

int64_t vvi_label_sense_step(int64_t n)
{
    return (n + ROWS_ALONG - 1) / ROWS_ALONG;
}

/* Of samples that are not in memory no more are made. */
static vv_status open_slice(look *l, int64_t k)
{
    vv_box box = vv_field_box(l->field);
    vv_brick_release(&l->brick);
    l->brick = (vv_brick){0};
    box.lo[2] = k;
    box.n[2] = 1;
    return vv_field_brick(&l->brick, l->field, &box, l->job);
}

static vv_status for_rows(look *l, vv_status (*visit)(look *))
{
    const int64_t *n = l->info->grid.dims;
    const int64_t dj = vvi_label_sense_step(n[1]), dk = vvi_label_sense_step(n[2]);
    vv_status st = VV_OK;
    for (int64_t k = 0; k < n[2] && st == VV_OK; k += dk) {
        st = open_slice(l, k);
        for (int64_t j = 0; j < n[1] && st == VV_OK; j += dj) {
            if (is_noise(l))
                return VV_OK;
            vvi_label_read(l->row, &l->brick, l->component, l->info, j, 0);
            st = visit(l);
        }
        st = st == VV_OK ? vvi_job_poll(l->job) : st;
    }
    return st;
}

static uint64_t common_step(uint64_t a, uint64_t b)
{
    while (b) {
        const uint64_t rest = a % b;
        a = b;
        b = rest;
    }
    return a;
}

static uint64_t size_of(int64_t value, vv_type type)
{
    return value < 0 && !vvi_label_is_unsigned(type) ? 0 - (uint64_t)value : (uint64_t)value;
}

/* The ends of a type, with a sign or without, are marks: nothing measured, too much. */
static bool is_end(int64_t value, vv_type type)
{
    const int unused = 64 - 8 * (int)vv_type_bytes(type);
    return value == INT64_MIN >> unused || value == INT64_MAX >> unused || (uint64_t)value == UINT64_MAX >> unused;
}

/* Whether few values are ids by the size of some alone. */
static bool are_ids(const look *l)
{
    uint64_t step = 0, least = UINT64_MAX;
    size_t n = 0, n_far = 0;
    for (size_t i = 0; i < l->room; i++) {
        const int64_t value = l->values[i].value;
        const uint64_t size = size_of(value, l->info->type);
        if (!l->values[i].runs || size == 0)
            continue;
        n++;
        step = common_step(size, step);
        if (size < ID_LEAST || is_end(value, l->info->type))
            continue;
        n_far++;
        least = size < least ? size : least;
    }
    return n < LEAST_LABELS && n_far >= 2 && step < least / ID_STEPS;
}

/* Most amounts are told here, before their values are sorted. */
static bool may_be_labels(look *l)
{
    l->ids = are_ids(l);
    size_t regions = 0;
    for (size_t i = 0; i < l->room; i++)
        regions += l->values[i].runs && l->values[i].samples >= 2 * l->values[i].runs;
    return (l->n >= LEAST_LABELS || l->ids) && !is_noise(l) && (double)regions >= REGION_SHARE * (double)l->n;
}

static bool are_labels(const look *l)
{
    return l->pairs >= LEAST_PAIRS && (double)l->equal >= EQUAL_SHARE * (double)l->pairs &&
           (double)l->lone <= LONE_SHARE * (double)l->samples &&
           (l->ids || (double)l->next <= NEXT_SHARE * (double)l->steps);
}

static vv_status sense(size_t *n_out, look *l)
{
    vv_status st = for_rows(l, count_runs);
    if (st != VV_OK || !may_be_labels(l))
        return st;
    sort_values(l);
    if ((st = for_rows(l, count_pairs)) == VV_OK && are_labels(l))
        *n_out = l->n;
    return st;
}

typedef struct question {
    const vv_field *field;
    int component;
} question;

static vv_status make(void **value_out, uint64_t *bytes_out, void *user, vv_job *job)
{
    const question *q = user;
    const vv_box all = vv_field_box(q->field);
    vv_field_info stored = *vv_field_get_info(q->field);
    stored.value_scale = 1; /* whatever a step of the stored numbers stands for */
    stored.value_offset = 0;
    look l = {.field = q->field, .component = q->component, .info = &stored, .job = job};
    size_t *n = vvi_alloc_zeroed(job, sizeof *n, VVI_MEM_DERIVED);
    if (!n)
        return vv_fail_memory(sizeof *n);
    vv_status st = VV_OK;
    if (!(l.row = vvi_alloc(job, (size_t)all.n[0] * sizeof *l.row, VVI_MEM_SCRATCH)))
        st = vv_fail_memory((size_t)all.n[0] * sizeof *l.row);
    if (st == VV_OK)
        st = sense(n, &l);
    vv_brick_release(&l.brick);
    vvi_free(l.row);
    vvi_free(l.values);
    if (st != VV_OK) {
        vvi_free(n);
        return st;
    }
    *bytes_out = sizeof *n;
    *value_out = n;
    return VV_OK;
}

bool vvi_label_sense_may(const vv_field_info *info)
{
    const int64_t *n = info->grid.dims;
    return !vv_type_is_float(info->type) && fabs(info->value_scale) >= 1 && !info->value_unit[0] && n[0] > 1 &&
           n[1] > 1 && n[2] > 1;
}

vv_status vvi_label_sense(size_t *n_out, const vv_field *field, int component, vv_job *job)
{
    const vvi_cache_key key = {"label sense", vv_field_identity(field), (uint64_t)component};
    question q = {field, component};
    vvi_cached *cached = NULL;
    *n_out = 0;
    if (!vvi_label_sense_may(vv_field_get_info(field)))
        return VV_OK;
    const vv_status st = vvi_cache_get(&cached, &key, make, vvi_free, &q, job);
    if (st != VV_OK)
        return st;
    *n_out = *(const size_t *)vvi_cached_value(cached);
    vvi_cache_release(cached);
    return VV_OK;
}
