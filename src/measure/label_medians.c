/* Medians of many labels; see label_medians.h. */
#include "measure/label_medians.h"

#include "core/memory.h"
#include "grid/percentile.h"
#include "grid/selection.h"
#include "grid/statistics.h"

#include <stdatomic.h>
#include <string.h>

#define DIGIT 9
#define BINS ((size_t)1 << DIGIT)
#define RUN VVI_PASS_RUN

typedef enum stage { FOUND, NARROWING, FOLLOWING } stage;

struct vvi_label_middle {
    uint64_t from; /* the least key of the first bin; the lower number of the two once it is found */
    uint64_t rank; /* of the lower one among keys from there on */
    uint64_t count;
    _Atomic uint64_t above; /* the upper number of the two */
    int shift;              /* a bin has 2^shift keys */
    stage stage;
};

vv_status vvi_label_medians_begin(vvi_label_medians *m, size_t n, vv_type type, vv_job *job)
{
    *m = (vvi_label_medians){.type = type, .n = n, .in = n};
    m->middle = vvi_alloc_zeroed(job, (n + 1) * sizeof *m->middle, VVI_MEM_SCRATCH);
    if (!m->middle)
        return vv_fail_memory((n + 1) * sizeof *m->middle);
    /* Fewer at a time where memory is short: more passes. */
    while (m->in > 1 && vvi_memory_plan(job, m->in * BINS * sizeof *m->bins, "medians of all labels") != VV_OK)
        m->in = (m->in + 1) / 2;
    m->bins = vvi_alloc_zeroed(job, (m->in + 1) * BINS * sizeof *m->bins, VVI_MEM_SCRATCH);
    return m->bins ? VV_OK : vv_fail_memory((m->in + 1) * BINS * sizeof *m->bins);
}

void vvi_label_medians_set(vvi_label_medians *m, size_t at, uint64_t count, double min, double max)
{
    const double ends[2] = {min + 0.0, max + 0.0};
    vvi_label_middle *const one = &m->middle[at];
    uint64_t key[2];
    if (!count)
        return;
    vvi_selection_keys(key, ends, 2, m->type);
    one->count = count;
    one->from = key[0];
    one->rank = vvi_quantile_at(50, count).low;
    while ((key[1] - key[0]) >> one->shift >= BINS)
        one->shift++;
    one->stage = NARROWING;
}

/* The number is found; the upper one of an even number may lie behind the last bin. */
static void find(vvi_label_middle *one, const _Atomic uint64_t *bins, size_t b, uint64_t here)
{
    const vvi_quantile q = vvi_quantile_at(50, one->count);
    size_t next = b;
    if (q.high != q.low && one->rank + 1 >= here)
        do
            next++;
        while (next < BINS && !atomic_load_explicit(&bins[next], memory_order_relaxed));
    atomic_store(&one->above, next < BINS ? one->from - b + next : UINT64_MAX);
    one->stage = next < BINS ? FOUND : FOLLOWING;
}

static void narrow(vvi_label_middle *one, _Atomic uint64_t *bins)
{
    uint64_t here = 0;
    size_t b = 0;
    while (b < BINS && (here = atomic_load_explicit(&bins[b], memory_order_relaxed)) <= one->rank) {
        one->rank -= here;
        b++;
    }
    if (b == BINS) { /* samples changed between two passes */
        b = BINS - 1;
        one->rank = 0;
    }
    one->from += (uint64_t)b << one->shift;
    if (one->shift == 0)
        find(one, bins, b, here);
    one->shift = one->shift > DIGIT ? one->shift - DIGIT : 0;
}

/* After a pass. */
static void descend(vvi_label_medians *m)
{
    for (size_t i = 0; i < m->in && m->first + i < m->n; i++) {
        vvi_label_middle *const one = &m->middle[m->first + i];
        _Atomic uint64_t *const bins = m->bins + i * BINS;
        uint64_t sum = 0;
        for (size_t b = 0; b < BINS && !sum; b++)
            sum += atomic_load_explicit(&bins[b], memory_order_relaxed);
        if (one->stage == NARROWING && sum)
            narrow(one, bins);
        else if (one->stage == FOLLOWING && atomic_load(&one->above) != UINT64_MAX)
            one->stage = FOUND;
    }
    memset((void *)m->bins, 0, m->in * BINS * sizeof *m->bins);
}

bool vvi_label_medians_next(vvi_label_medians *m)
{
    descend(m);
    for (; m->first < m->n; m->first += m->in)
        for (size_t i = m->first; i < m->n && i < m->first + m->in; i++)
            if (m->middle[i].stage != FOUND)
                return true;
    return false;
}

static void take_key(vvi_label_middle *one, _Atomic uint64_t *bins, uint64_t key)
{
    if (key < one->from)
        return;
    const uint64_t bin = (key - one->from) >> one->shift;
    if (one->stage == NARROWING && bin < BINS)
        atomic_fetch_add_explicit(&bins[bin], 1, memory_order_relaxed);
    if (one->stage != FOLLOWING || key == one->from)
        return;
    uint64_t least = atomic_load_explicit(&one->above, memory_order_relaxed);
    while (key < least && !atomic_compare_exchange_weak(&one->above, &least, key))
        ;
}

void vvi_label_medians_take(vvi_label_medians *m, size_t at, const char *samples, int64_t stride, int64_t n)
{
    vvi_label_middle *const one = &m->middle[at];
    double v[RUN];
    uint64_t key[RUN];
    if (at < m->first || at - m->first >= m->in || one->stage == FOUND)
        return;
    for (int64_t i = 0; i < n; i += RUN) {
        const size_t now = n - i < RUN ? (size_t)(n - i) : RUN;
        for (size_t x = 0; x < now; x++) {
            vvi_samples_to_f64(&v[x], samples + (i + (int64_t)x) * stride, m->type, 1);
            v[x] += 0.0; /* the negative zero is none here */
        }
        vvi_selection_keys(key, v, now, m->type);
        for (size_t x = 0; x < now; x++)
            if (v[x] - v[x] == 0)
                take_key(one, m->bins + (at - m->first) * BINS, key[x]);
    }
}

double vvi_label_medians_get(const vvi_label_medians *m, size_t at)
{
    const vvi_label_middle *const one = &m->middle[at];
    const vvi_quantile q = vvi_quantile_at(50, one->count);
    return vvi_quantile_between(&q, vvi_selection_value(one->from, m->type),
                                vvi_selection_value(atomic_load(&one->above), m->type));
}

void vvi_label_medians_end(vvi_label_medians *m)
{
    vvi_free(m->middle);
    vvi_free((void *)m->bins);
    *m = (vvi_label_medians){0};
}
