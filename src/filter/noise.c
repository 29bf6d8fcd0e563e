#include "filter/noise.h"
#include "core/cache.h"
#include "core/job.h"
#include "core/memory.h"
#include "filter/real_samples.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { SAMPLES_MOST = 1 << 20, SLICES_MOST = 16 };
enum { DIGIT = 16, DIGITS = 1 << DIGIT, LISTED = 1 << 15 };
#define NORMAL 1.482602218505602 /* of a normal distribution: standard deviation over median size */

typedef struct request {
    const vv_field *field;
    int component;
} request;

/* The median is found digit by digit, the highest first: as numbers of 64 bits positive doubles have their own order.
 * One look at the samples counts the digits of those that begin as the median does; once these are few, they are
 * listed. So it takes little memory, and looks twice or three times. */
typedef struct looker {
    const vv_field *field;
    const vv_field_info *info;
    int component;
    bool along[3]; /* axes with neighbours to both sides */
    int64_t stride[3];
    uint64_t begins; /* the digits that are known, above `shift` */
    int shift;       /* bits that are not known; 64: none are */
    size_t n;        /* sizes that begin so */
    uint64_t least, largest;
    uint32_t *count; /* of each next digit; NULL: they are listed */
    uint64_t *list;
    double *reals; /* a row and those around it */
} looker;

static int in_order(const void *a, const void *b)
{
    const uint64_t x = *(const uint64_t *)a, y = *(const uint64_t *)b;
    return (x > y) - (x < y);
}

static void note(looker *l, double size)
{
    uint64_t bits;
    memcpy(&bits, &size, sizeof bits);
    if (l->shift < 64 && bits >> l->shift != l->begins)
        return;
    l->least = bits < l->least ? bits : l->least;
    l->largest = bits > l->largest ? bits : l->largest;
    if (l->count)
        l->count[bits >> (l->shift - DIGIT) & (DIGITS - 1)]++;
    else
        l->list[l->n] = bits;
    l->n++;
}

static void look_at_row(looker *l, const double *row, int64_t n)
{
    const int64_t margin = l->along[0];
    for (int64_t i = margin; i < n - margin; i++) {
        double sum = 0;
        int axes = 0;
        for (int a = 0; a < 3; a++)
            if (l->along[a]) {
                sum += 0.5 * row[i - l->stride[a]] + 0.5 * row[i + l->stride[a]];
                axes++;
            }
        const double size = fabs(row[i] - sum / axes);
        if (size > 0 && isfinite(size))
            note(l, size);
    }
}

/* The rows of one slice, or every so many of them. */
static vv_status look_at_slice(looker *l, int64_t k, int64_t rows_apart, vv_job *job)
{
    const int64_t *d = l->info->grid.dims, margin = l->along[2], margin_y = l->along[1];
    const vv_box box = {{0, 0, k - margin}, {d[0], d[1], 1 + 2 * margin}};
    vv_brick brick;
    vv_status st = vv_field_brick(&brick, l->field, &box, job);
    if (st != VV_OK)
        return st;
    for (int64_t j = margin_y; j < d[1] - margin_y && st == VV_OK; j += rows_apart) {
        const vv_box around = {{0, j - margin_y, box.lo[2]}, {d[0], 1 + 2 * margin_y, box.n[2]}};
        vvi_reals_of_box(l->reals, true, &brick, &around, (int64_t[3]){0, 0, 0}, l->component);
        look_at_row(l, l->reals + margin * l->stride[2] + margin_y * l->stride[1], d[0]);
        st = vvi_job_poll(job);
    }
    vv_brick_release(&brick);
    return st;
}

static vv_status look(looker *l, vv_job *job)
{
    const int64_t *d = l->info->grid.dims, margin = l->along[2], inner = d[2] - 2 * margin;
    const int64_t slices = inner < SLICES_MOST ? inner : SLICES_MOST, all = slices * d[0] * d[1];
    vv_status st = VV_OK;
    l->n = 0;
    l->least = UINT64_MAX;
    l->largest = 0;
    for (int64_t s = 0; s < slices && st == VV_OK; s++)
        st = look_at_slice(l, margin + (2 * s + 1) * inner / (2 * slices), 1 + all / SAMPLES_MOST, job);
    return st;
}

/* Goes on to the digit that the k-th size has, of those that begin so; *k: of those that begin with that too. */
static void take_digit(looker *l, size_t *k)
{
    uint64_t digit = 0;
    for (; *k >= l->count[digit]; digit++)
        *k -= l->count[digit];
    l->begins = (l->shift < 64 ? l->begins << DIGIT : 0) | digit;
    l->shift -= DIGIT;
    l->n = l->count[digit];
}

/* 0: there is none. */
static vv_status find_median(double *out, looker *l, vv_job *job)
{
    vv_status st = look(l, job);
    size_t k = l->n / 2;
    *out = 0;
    if (st != VV_OK || l->n == 0)
        return st;
    while (l->least < l->largest && l->count) {
        take_digit(l, &k);
        memset(l->count, 0, DIGITS * sizeof *l->count);
        if (l->n <= LISTED || l->shift == 0) {
            l->list = (uint64_t *)(void *)l->count;
            l->count = NULL;
        }
        if (l->shift == 0)
            l->least = l->largest = l->begins;
        else if ((st = look(l, job)) != VV_OK)
            return st;
    }
    if (l->least < l->largest) {
        qsort(l->list, l->n, sizeof *l->list, in_order);
        l->least = l->list[k];
    }
    memcpy(out, &l->least, sizeof *out);
    return st;
}

static vv_status measure(double *out, looker *l, vv_job *job)
{
    int axes = 0;
    for (int a = 0; a < 3; a++)
        axes += l->along[a];
    *out = 0;
    const vv_status st = axes > 0 ? find_median(out, l, job) : VV_OK;
    if (axes > 0)
        *out = NORMAL * *out * sqrt(2.0 * axes / (2 * axes + 1));
    return st;
}

static vv_status make(void **value_out, uint64_t *bytes_out, void *user, vv_job *job)
{
    const request *r = user;
    looker l = {.field = r->field, .info = vv_field_get_info(r->field), .component = r->component, .shift = 64};
    const int64_t *d = l.info->grid.dims;
    for (int a = 0; a < 3; a++)
        l.along[a] = d[a] > 2;
    l.stride[0] = 1, l.stride[1] = d[0], l.stride[2] = d[0] * (l.along[1] ? 3 : 1);
    const size_t bytes = (size_t)l.stride[2] * (l.along[2] ? 3 : 1) * sizeof(double);
    double *value = vvi_alloc(job, sizeof *value, VVI_MEM_DERIVED);
    uint32_t *counts = vvi_alloc_zeroed(job, DIGITS * sizeof *counts, VVI_MEM_SCRATCH);
    l.count = counts;
    l.reals = vvi_alloc(job, bytes, VVI_MEM_SCRATCH);
    vv_status st = value && counts && l.reals ? measure(value, &l, job) : vv_fail_memory(bytes);
    vvi_free(counts);
    vvi_free(l.reals);
    if (st != VV_OK) {
        vvi_free(value);
        return st;
    }
    vvi_log(job, VV_LOG_INFO, "filter", "noise of channel %d: a standard deviation of %.6g", r->component,
            *value * fabs(l.info->value_scale));
    *value_out = value;
    *bytes_out = sizeof *value;
    return VV_OK;
}

vv_status vvi_noise(double *out, const vv_field *field, int component, vv_job *job)
{
    request r = {field, component};
    const vvi_cache_key key = {"noise", vv_field_identity(field), (uint64_t)component};
    vvi_cached *cached;
    const vv_status st = vvi_cache_get(&cached, &key, make, vvi_free, &r, job);
    if (st != VV_OK)
        return st;
    *out = *(const double *)vvi_cached_value(cached);
    vvi_cache_release(cached);
    return VV_OK;
}
