/* The planes of Marching Cubes: which samples of a slice are inside, and its crossed edges counted and numbered. */
#include "surface/marching_planes.h"
#include "surface/marching_blocks.h"

#include <string.h>

static uint64_t last_word(const vvi_march *m)
{
    return m->n[0] & 63 ? ((uint64_t)1 << (m->n[0] & 63)) - 1 : ~(uint64_t)0;
}

static void invert(uint64_t *bits, const vvi_march *m)
{
    const size_t end = m->words - 1;
    for (size_t i = 0; i < end; i++)
        bits[i] = ~bits[i];
    bits[end - 1] &= last_word(m);
}

/* A row whose every word is read. `counted`: its span is known. */
static void classify_row(vvi_march_plane *p, const vvi_march_worker *w, const vvi_march *m, int64_t j, int64_t k,
                         bool counted)
{
    const vvi_march_span all = {0, (uint16_t)(m->words - 1)};
    const void *samples = vvi_march_row(w, j, k);
    uint64_t *bits = p->inside + (size_t)j * m->words;
    p->span[j] = counted && !m->inverted ? m->span[k * m->n[1] + j] : all;
    m->kernels->classify[m->type](bits, samples, m->n[0], m->threshold, &p->span[j]);
    if (m->inverted) {
        invert(bits, m);
        p->span[j] = all;
    }
    if (m->type == VVI_MARCH_F32)
        p->all_known &= m->kernels->known(p->known + (size_t)j * m->words, samples, m->n[0]);
}

/* Words [begin, end) of a row, of which blocks say nothing. Those of the next slice are mostly the same ones. */
static void read_words(vvi_march_plane *p, const vvi_march_worker *w, const vvi_march *m, int64_t j, int64_t k,
                       vvi_march_span run)
{
    const char *samples = vvi_march_row(w, j, k);
    const int64_t rest = m->n[0] - 64 * run.begin, whole = 64 * (run.end - run.begin), n = rest < whole ? rest : whole;
    const size_t row = (size_t)j * m->words, each = vv_type_bytes(m->brick.type);
    const char *first = samples + 64 * run.begin * each;
    vvi_march_span span = run;
    if (k + 1 < m->n[2])
        vvi_march_fetch(first + w->slice_bytes, (size_t)n * each);
    m->kernels->classify[m->type](p->inside + row, samples, m->n[0], m->threshold, &span);
    if (m->type == VVI_MARCH_F32)
        p->all_known &= m->kernels->known(p->known + row + run.begin, (const float *)(const void *)first, n);
}

/* Words from `at` on in one state; those that are read go on over a few that need not be. */
static vvi_march_span run_of_states(const uint8_t *states, uint16_t at, uint16_t n)
{
    const uint16_t gap = states[at] == VVI_MARCH_MIXED ? 2 : 0;
    uint16_t end = (uint16_t)(at + 1);
    for (uint16_t i = end; i < n && i <= end + gap; i++)
        if (states[i] == states[at])
            end = (uint16_t)(i + 1);
        else if (!gap)
            break;
    return (vvi_march_span){at, end};
}

/* A row of which only words are read that the surface may pass: the others are all one way, and so is what is around
 * them. Its span is that of the words that are read. */
static void classify_by_blocks(vvi_march_plane *p, const vvi_march_worker *w, const vvi_march *m, int64_t j, int64_t k)
{
    const uint16_t n = (uint16_t)(m->words - 1);
    uint64_t *bits = p->inside + (size_t)j * m->words;
    vvi_march_span *span = &p->span[j];
    *span = (vvi_march_span){0, 0};
    if (m->type == VVI_MARCH_F32)
        memset(p->known + (size_t)j * m->words, 0xff, m->words * sizeof *p->known);
    for (uint16_t at = 0; at < n;) {
        const uint8_t state = w->states[at];
        const vvi_march_span run = run_of_states(w->states, at, n);
        if (state == VVI_MARCH_INSIDE)
            memset(bits + run.begin, 0xff, (size_t)(run.end - run.begin) * sizeof *bits);
        else if (state == VVI_MARCH_MIXED) {
            read_words(p, w, m, j, k, run);
            *span = (vvi_march_span){span->end ? span->begin : run.begin, run.end};
        }
        at = run.end;
    }
    bits[n - 1] &= last_word(m);
    if (m->inverted)
        invert(bits, m);
}

static bool passes_row(const vvi_march *m, int64_t j, int64_t k)
{
    return j >= 0 && k >= 0 && m->passes[k * m->n[1] + j];
}

/* Whether vertices or triangles need the bits of a row, once they are counted. */
static bool is_needed(const vvi_march *m, int64_t j, int64_t k)
{
    return passes_row(m, j, k) || passes_row(m, j - 1, k) || passes_row(m, j, k - 1) || passes_row(m, j - 1, k - 1);
}

/* `counted`: the rows that the surface passes are known, and their spans. */
static void classify(vvi_march_plane *p, const vvi_march_worker *w, const vvi_march *m, int64_t k, bool counted)
{
    p->all_known = true;
    memset(p->inside, 0, (size_t)m->n[1] * m->words * sizeof(uint64_t));
    for (int64_t j = 0; j < m->n[1]; j++) {
        if (m->blocks && vvi_march_touches_others(m, j))
            vvi_march_words(w->states, m, j, k);
        if (counted && !is_needed(m, j, k))
            p->span[j] = (vvi_march_span){0, 0};
        else if (m->blocks)
            classify_by_blocks(p, w, m, j, k);
        else
            classify_row(p, w, m, j, k, counted);
    }
}

size_t vvi_march_along(uint64_t *out, vvi_march_span *span, const vvi_march_plane *p, int64_t j, const vvi_march *m)
{
    *span = vvi_march_one_before(p->span[j]);
    if (span->begin == span->end)
        return 0;
    return m->kernels->along(out, vvi_march_bits(p->inside, m, j), p->all_known ? NULL : vvi_march_bits(p->known, m, j),
                             m->n[0], *span);
}

size_t vvi_march_between(uint64_t *out, vvi_march_span *span, const vvi_march_plane *p, int64_t j,
                         const vvi_march_plane *q, int64_t i, const vvi_march *m)
{
    const uint64_t *inside[2] = {vvi_march_bits(p->inside, m, j), vvi_march_bits(q->inside, m, i)};
    const uint64_t *known[2] = {vvi_march_bits(p->known, m, j), vvi_march_bits(q->known, m, i)};
    *span = vvi_march_join(p->span[j], q->span[i]);
    if (span->begin == span->end)
        return 0;
    return m->kernels->between(out, inside, p->all_known && q->all_known ? NULL : known, *span);
}

/* A plane without its known bits counts as one where all are. */
static void complete(vvi_march_plane plane[2], const vvi_march *m)
{
    for (int i = 0; i < 2; i++)
        if (plane[i].all_known && !plane[1 - i].all_known)
            memset(plane[i].known, 0xff, (size_t)m->n[1] * m->words * sizeof(uint64_t));
}

/* Crossed edges that begin in row j of a slice, slowly: samples are missing, or q is NULL and there is no slice after.
 */
static void count_edges(uint32_t out[3], const vvi_march_plane *p, const vvi_march_plane *q, const vvi_march_worker *w,
                        const vvi_march *m, int64_t j)
{
    vvi_march_span span;
    out[0] = (uint32_t)vvi_march_along(w->bits, &span, p, j, m);
    out[1] = j + 1 < m->n[1] ? (uint32_t)vvi_march_between(w->bits, &span, p, j, p, j + 1, m) : 0;
    out[2] = q ? (uint32_t)vvi_march_between(w->bits, &span, p, j, q, j, m) : 0;
}

size_t vvi_march_count_edges(const vvi_march_plane *p, const vvi_march_plane *q, const vvi_march_worker *w,
                             const vvi_march *m, int64_t k)
{
    vvi_march_row_count *count = vvi_march_counts(m, k);
    const bool all_known = q && p->all_known && q->all_known;
    size_t n = 0;
    for (int64_t j = 0; j < m->n[1]; j++) {
        uint32_t *c = count[j].edges;
        if (all_known && j + 1 < m->n[1]) {
            const vvi_march_span span = vvi_march_join(vvi_march_join(p->span[j], p->span[j + 1]), q->span[j]);
            m->kernels->count(c, vvi_march_bits(p->inside, m, j), vvi_march_bits(p->inside, m, j + 1),
                              vvi_march_bits(q->inside, m, j), m->n[0], vvi_march_one_before(span));
        } else {
            count_edges(c, p, q, w, m, j);
        }
        m->passes[k * m->n[1] + j] = (c[0] | c[1] | c[2]) != 0;
        n += c[0] + c[1] + c[2];
    }
    return n;
}

size_t vvi_march_number_plane(vvi_march_plane *p, const vvi_march *m, int64_t k, size_t first)
{
    const vvi_march_row_count *count = vvi_march_counts(m, k);
    uint32_t n = (uint32_t)first;
    for (int64_t j = 0; j < m->n[1]; j++) {
        p->x_first[j] = n;
        p->y_first[j] = n + count[j].edges[0];
        n += count[j].edges[0] + count[j].edges[1];
    }
    return n - first;
}

size_t vvi_march_number_between(vvi_march_worker *w, const vvi_march *m, int64_t k, size_t first)
{
    const vvi_march_row_count *count = vvi_march_counts(m, k);
    uint32_t n = (uint32_t)first;
    for (int64_t j = 0; j < m->n[1]; j++) {
        w->z_first[j] = n;
        n += count[j].edges[2];
    }
    return n - first;
}

void vvi_march_first_plane(vvi_march_worker *w, const vvi_march *m, int64_t k, bool counted)
{
    classify(&w->plane[1], w, m, k, counted);
}

void vvi_march_next_plane(vvi_march_worker *w, const vvi_march *m, int64_t k, bool counted)
{
    const vvi_march_plane upper = w->plane[1];
    w->plane[1] = w->plane[0];
    w->plane[0] = upper;
    classify(&w->plane[1], w, m, k, counted);
    complete(w->plane, m);
}

size_t vvi_march_count_unknown(const vvi_march_plane *p, const vvi_march *m)
{
    size_t known = 0;
    if (p->all_known)
        return 0;
    for (int64_t j = 0; j < m->n[1]; j++) {
        const uint64_t *bits = vvi_march_bits(p->known, m, j);
        for (size_t w = 0; w + 1 < m->words; w++)
            known += (size_t)__builtin_popcountll(bits[w] & (w + 2 < m->words ? ~(uint64_t)0 : last_word(m)));
    }
    return (size_t)(m->n[0] * m->n[1]) - known;
}
