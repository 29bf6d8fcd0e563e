#include "segment/cuts.h"
#include "core/cache.h"
#include "core/job.h"
#include "core/memory.h"
#include "grid/field.h"
#include "grid/percentile.h"
#include "grid/statistics.h"

#include <math.h>
#include <string.h>

/* Histogram ------------------------------------------------------------------------------------------------------- */

typedef vv_status visit_fn(void *user, const vv_field *field, vv_job *job);

/* All fields, which must be alike. */
static vv_status visit(vv_field_info *info, const vv_field_series *series, visit_fn *fn, void *user, vv_job *job)
{
    vv_status st = VV_OK;
    for (size_t f = 0; f < series->n && st == VV_OK; f++) {
        vv_field *field = NULL;
        if ((st = series->open(&field, series->user, f, job)) != VV_OK)
            break;
        const vv_field_info *its = vv_field_get_info(field);
        if (f == 0)
            *info = *its;
        if (its->type != info->type || its->value_scale != info->value_scale || its->value_offset != info->value_offset)
            st = vv_fail(VV_E_UNSUPPORTED, "threshold: time steps differ in type or scale; none divides all of them");
        if (st == VV_OK)
            st = fn(user, field, job);
        if (st == VV_OK)
            st = vv_field_health(field);
        vv_field_release(field);
    }
    return st;
}

static vv_status join_moments(void *user, const vv_field *field, vv_job *job)
{
    const size_t n = vvi_pass_slabs(field).n;
    vvi_moments *parts, own;
    vv_status st = vvi_moments_begin(&parts, n, job);
    if (st != VV_OK)
        return st;
    const vvi_pass pass = vvi_moments_pass(parts);
    st = vvi_pass_run(&pass, field, 0, job);
    vvi_moments_end(&own, parts, n);
    if (st == VV_OK)
        vvi_moments_join(user, &own);
    return st;
}

static vv_status count(void *user, const vv_field *field, vv_job *job)
{
    const vvi_pass pass = vvi_bin_counts_pass(user);
    return vvi_pass_run(&pass, field, 0, job);
}

static vvi_bins bins_for(const vvi_moments *m, vv_type type)
{
    const double numbers = m->max - m->min + 1;
    if (vv_type_is_float(type))
        return (vvi_bins){m->min, m->max, m->max > m->min ? VVI_BINS_MOST : 1};
    const double each = ceil(numbers / VVI_BINS_MOST), n = ceil(numbers / each);
    return (vvi_bins){m->min - 0.5, m->min - 0.5 + n * each, (int)n};
}

static void finish(vvi_histogram *h)
{
    vvi_free(h->value);
    vvi_free(h->count);
    *h = (vvi_histogram){0};
}

/* As values, rising: a negative scale turns the order round. */
static vv_status gather(vvi_histogram *out, const vvi_bin_counts *counts, const vv_field_info *info, vv_job *job)
{
    const vvi_bins *b = &counts->bins;
    const size_t bytes = (size_t)b->n * sizeof(double);
    const double width = b->hi / b->n - b->lo / b->n;
    *out = (vvi_histogram){.width = width * fabs(info->value_scale),
                           .is_exact = !vv_type_is_float(info->type) && width == 1,
                           .value = vvi_alloc(job, bytes, VVI_MEM_SCRATCH),
                           .count = vvi_alloc(job, bytes, VVI_MEM_SCRATCH)};
    if (!out->value || !out->count) {
        finish(out);
        return vv_fail_memory(bytes);
    }
    for (int i = 0; i < b->n; i++) {
        const int at = info->value_scale < 0 ? b->n - 1 - i : i;
        const uint64_t n = vvi_bin_counts_get(counts, at);
        if (n == 0)
            continue;
        out->value[out->n] = (b->lo + (at + 0.5) * width) * info->value_scale + info->value_offset;
        out->count[out->n++] = (double)n;
    }
    return VV_OK;
}

/* Otsu ------------------------------------------------------------------------------------------------------------ */

/* The best way to divide bins 0 .. j into so many classes, for all j: best[j] is the sum over classes of (sum of
 * values)^2 / count, which is largest where variance within them is least, and from[j] the first bin of the last class.
 * The first bin of the last class never falls when j rises, so the middle j halves the search of the others. */
typedef struct search {
    const double *n, *sum; /* of bins before each one */
    const double *fewer;   /* best[] of one class fewer */
    double *best;
    uint32_t *from;
    vv_job *job;
} search;

static double score(const search *s, size_t first, size_t end)
{
    const double sum = s->sum[end] - s->sum[first];
    return sum * sum / (s->n[end] - s->n[first]);
}

static void search_one(const search *s, size_t j, size_t lo, size_t hi)
{
    s->best[j] = -INFINITY;
    for (size_t i = lo; i <= hi && i <= j; i++) {
        const double all = s->fewer[i - 1] + score(s, i, j + 1);
        if (all > s->best[j]) {
            s->best[j] = all;
            s->from[j] = (uint32_t)i;
        }
    }
}

static void search_all(const search *s, size_t lo_j, size_t hi_j, size_t lo, size_t hi)
{
    if (lo_j > hi_j || vvi_job_poll(s->job) != VV_OK)
        return;
    const size_t j = lo_j + (hi_j - lo_j) / 2;
    search_one(s, j, lo, hi);
    if (j > lo_j)
        search_all(s, lo_j, j - 1, lo, s->from[j]);
    search_all(s, j + 1, hi_j, s->from[j], hi);
}

static void prefix_sums(double *n, double *sum, const vvi_histogram *h)
{
    double total = 0, mean = 0;
    for (size_t i = 0; i < h->n; i++)
        total += h->count[i];
    for (size_t i = 0; i < h->n; i++)
        mean += h->value[i] * (h->count[i] / total);
    n[0] = sum[0] = 0;
    for (size_t i = 0; i < h->n; i++) {
        n[i + 1] = n[i] + h->count[i];
        sum[i + 1] = sum[i] + (h->value[i] - mean) * h->count[i]; /* from the mean, else large ones cancel */
    }
}

vv_status vvi_otsu(size_t *last_of_class, const vvi_histogram *h, int n_classes, vv_job *job)
{
    const size_t m = h->n, doubles = 2 * (m + 1) + 2 * m;
    const size_t bytes = doubles * sizeof(double) + (size_t)n_classes * m * sizeof(uint32_t);
    double *room = vvi_alloc_zeroed(job, bytes, VVI_MEM_SCRATCH);
    if (!room)
        return vv_fail_memory(bytes);
    double *n = room, *sum = n + m + 1, *best[2] = {sum + m + 1, sum + m + 1 + m};
    uint32_t *from = (uint32_t *)(void *)(room + doubles);
    search s = {.n = n, .sum = sum, .job = job};
    prefix_sums(n, sum, h);
    for (size_t j = 0; j < m; j++)
        best[0][j] = score(&s, 0, j + 1);
    for (size_t c = 1; c < (size_t)n_classes; c++) {
        s.fewer = best[(c - 1) & 1];
        s.best = best[c & 1];
        s.from = from + c * m;
        if (c + 1 == (size_t)n_classes) /* only all bins are asked for */
            search_one(&s, m - 1, c, m - 1);
        else
            search_all(&s, c, m - 1, c, m - 1);
    }
    size_t j = m - 1;
    const vv_status st = vvi_job_poll(job);
    for (size_t c = (size_t)n_classes - 1; c > 0 && st == VV_OK; c--) {
        j = from[c * m + j] - 1;
        last_of_class[c - 1] = j;
    }
    vvi_free(room);
    return st;
}

/* Li -------------------------------------------------------------------------------------------------------------- */

static double li_step(const vvi_histogram *h, double least, double at)
{
    double n[2] = {0}, sum[2] = {0};
    for (size_t i = 0; i < h->n; i++) {
        const double v = h->value[i] - least;
        n[v > at] += h->count[i];
        sum[v > at] += h->count[i] * v;
    }
    const double back = n[0] > 0 ? sum[0] / n[0] : 0, fore = n[1] > 0 ? sum[1] / n[1] : 0;
    return back > 0 && fore > back ? (back - fore) / (log(back) - log(fore)) : at;
}

double vvi_li(const vvi_histogram *h)
{
    enum { MOST = 1000 };
    if (h->n == 0)
        return 0;
    const double least = h->value[0];
    double total = 0, sum = 0;
    for (size_t i = 0; i < h->n; i++) {
        total += h->count[i];
        sum += h->count[i] * (h->value[i] - least);
    }
    double at = sum / total;
    for (int i = 0; i < MOST; i++) {
        const double next = li_step(h, least, at), moved = fabs(next - at);
        at = next;
        if (!(moved > h->width / 2))
            break;
    }
    return at + least;
}

/* Cuts ------------------------------------------------------------------------------------------------------------ */

static void put_after_bin(vvi_cuts *out, const vvi_histogram *h, size_t bin)
{
    const double above = h->value[bin] + h->width / 2;
    out->above[out->n] = above;
    out->told[out->n++] = h->is_exact ? h->value[bin] : above;
}

static void put_value(vvi_cuts *out, double value)
{
    out->above[out->n] = nextafter(value, INFINITY);
    out->told[out->n++] = value;
}

static vv_status cut(vvi_cuts *out, vvi_cut_method method, int n_classes, const vvi_histogram *h, double mean,
                     vv_job *job)
{
    size_t last[VVI_CUTS_MOST];
    if (h->n < (size_t)n_classes)
        return vv_fail(VV_E_ARGUMENT,
                       "threshold: %d classes need as many different values, and the samples have %s%zu; give --range",
                       n_classes, h->n ? "" : "no finite one: ", h->n);
    if (method == VVI_CUT_MEAN)
        put_value(out, mean);
    else if (method == VVI_CUT_LI)
        put_value(out, vvi_li(h));
    else {
        const vv_status st = vvi_otsu(last, h, n_classes, job);
        for (int c = 0; c + 1 < n_classes && st == VV_OK; c++)
            put_after_bin(out, h, last[c]);
        return st;
    }
    return VV_OK;
}

vv_status vvi_cuts_find(vvi_cuts *out, vvi_cut_method method, int n_classes, const vv_field_series *series, vv_job *job)
{
    vv_field_info info = vv_field_info_default();
    vvi_moments moments;
    vvi_bin_counts counts = {0};
    vvi_histogram h = {0};
    *out = (vvi_cuts){0};
    vvi_moments_init(&moments);
    vv_status st = visit(&info, series, join_moments, &moments, job);
    if (st == VV_OK && moments.count > 0) {
        const vvi_bins bins = bins_for(&moments, info.type);
        if ((st = vvi_bin_counts_begin(&counts, &bins, job)) == VV_OK &&
            (st = visit(&info, series, count, &counts, job)) == VV_OK)
            st = gather(&h, &counts, &info, job);
    }
    if (st == VV_OK)
        st = cut(out, method, n_classes, &h, (double)moments.mean * info.value_scale + info.value_offset, job);
    vvi_bin_counts_end(&counts);
    finish(&h);
    return st;
}

typedef struct request {
    vvi_cut_method method;
    int n_classes;
    const vv_field *field;
} request;

static vv_status make(void **value_out, uint64_t *bytes_out, void *user, vv_job *job)
{
    const request *r = user;
    const vv_field_series alone = vvi_field_alone(r->field);
    vvi_cuts *cuts = vvi_alloc(job, sizeof *cuts, VVI_MEM_DERIVED);
    if (!cuts)
        return vv_fail_memory(sizeof *cuts);
    const vv_status st = vvi_cuts_find(cuts, r->method, r->n_classes, &alone, job);
    if (st != VV_OK) {
        vvi_free(cuts);
        return st;
    }
    *value_out = cuts;
    *bytes_out = sizeof *cuts;
    return VV_OK;
}

vv_status vvi_cuts_of_field(vvi_cuts *out, vvi_cut_method method, int n_classes, const vv_field *field, vv_job *job)
{
    request r = {method, n_classes, field};
    const vvi_cache_key key = {"cuts", vv_field_identity(field), (uint64_t)method * 64 + (uint64_t)n_classes};
    vvi_cached *cached;
    const vv_status st = vvi_cache_get(&cached, &key, make, vvi_free, &r, job);
    if (st != VV_OK)
        return st;
    memcpy(out, vvi_cached_value(cached), sizeof *out);
    vvi_cache_release(cached);
    return VV_OK;
}
