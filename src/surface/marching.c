#include "surface/marching.h"
#include "core/cpu.h"
#include "core/job.h"
#include "core/memory.h"
#include "grid/field.h"
#include "surface/marching_blocks.h"
#include "surface/normals.h"

#include <math.h>
#include <string.h>

/* Planes of samples -------------------------------------------------------------------------------------------------
 */

static const uint64_t *row_of(const uint64_t *bits, const vvi_march *m, int64_t j)
{
    return bits + (size_t)j * m->words;
}

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
    const void *samples = vvi_march_row(w, m, j, k);
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

/* Words [begin, end) of a row, of which blocks say nothing. */
static void read_words(vvi_march_plane *p, const vvi_march_worker *w, const vvi_march *m, int64_t j, int64_t k,
                       vvi_march_span run)
{
    const float *samples = vvi_march_row(w, m, j, k);
    const int64_t rest = m->n[0] - 64 * run.begin, whole = 64 * (run.end - run.begin);
    const size_t row = (size_t)j * m->words;
    vvi_march_span span = run;
    m->kernels->classify[m->type](p->inside + row, samples, m->n[0], m->threshold, &span);
    if (m->type == VVI_MARCH_F32)
        p->all_known &=
            m->kernels->known(p->known + row + run.begin, samples + 64 * run.begin, rest < whole ? rest : whole);
}

/* A row of which only words are read that the surface may pass: the others are all one way, and so is what is around
 * them. Its span is that of the words that are read. */
static void classify_by_blocks(vvi_march_plane *p, const vvi_march_worker *w, const vvi_march *m, int64_t j, int64_t k)
{
    const uint16_t n = (uint16_t)(m->words - 1);
    uint64_t *bits = p->inside + (size_t)j * m->words;
    vvi_march_span *span = &p->span[j];
    *span = (vvi_march_span){0, 0};
    vvi_march_words(w->states, m, j, k);
    if (m->type == VVI_MARCH_F32)
        memset(p->known + (size_t)j * m->words, 0xff, m->words * sizeof *p->known);
    for (uint16_t at = 0; at < n;) {
        const uint8_t state = w->states[at];
        vvi_march_span run = {at, at};
        while (run.end < n && w->states[run.end] == state)
            run.end++;
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

/* `counted`: the spans of the rows are known. */
static void classify(vvi_march_plane *p, const vvi_march_worker *w, const vvi_march *m, int64_t k, bool counted)
{
    p->all_known = true;
    memset(p->inside, 0, (size_t)m->n[1] * m->words * sizeof(uint64_t));
    for (int64_t j = 0; j < m->n[1]; j++) {
        if (m->blocks)
            classify_by_blocks(p, w, m, j, k);
        else
            classify_row(p, w, m, j, k, counted);
    }
}

/* Words with all that two spans have, and the word before, in whose last bit a row may begin to differ. */
static vvi_march_span join(vvi_march_span a, vvi_march_span b)
{
    if (a.begin == a.end)
        return b;
    if (b.begin == b.end)
        return a;
    return (vvi_march_span){a.begin < b.begin ? a.begin : b.begin, a.end > b.end ? a.end : b.end};
}

static vvi_march_span one_before(vvi_march_span a)
{
    return (vvi_march_span){a.begin > 0 && a.begin < a.end ? (uint16_t)(a.begin - 1) : a.begin, a.end};
}

static size_t along_row(uint64_t *out, vvi_march_span *span, const vvi_march_plane *p, const vvi_march *m, int64_t j)
{
    *span = one_before(p->span[j]);
    if (span->begin == span->end)
        return 0;
    return m->kernels->along(out, row_of(p->inside, m, j), p->all_known ? NULL : row_of(p->known, m, j), m->n[0],
                             *span);
}

/* Edges from row j of one plane to row i of the same or another. */
static size_t between_rows(uint64_t *out, vvi_march_span *span, const vvi_march_plane *p, int64_t j,
                           const vvi_march_plane *q, int64_t i, const vvi_march *m)
{
    const uint64_t *inside[2] = {row_of(p->inside, m, j), row_of(q->inside, m, i)};
    const uint64_t *known[2] = {row_of(p->known, m, j), row_of(q->known, m, i)};
    *span = join(p->span[j], q->span[i]);
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

static vvi_march_row_count *counts_of(const vvi_march *m, int64_t k)
{
    return m->rows + (size_t)(k * m->n[1]);
}

/* Crossed edges within a slice; their sum. */
static size_t count_plane(const vvi_march_plane *p, const vvi_march_worker *w, const vvi_march *m, int64_t k)
{
    vvi_march_row_count *count = counts_of(m, k);
    vvi_march_span span;
    size_t n = 0;
    for (int64_t j = 0; j < m->n[1]; j++) {
        count[j].x = (uint32_t)along_row(w->bits, &span, p, m, j);
        count[j].y = j + 1 < m->n[1] ? (uint32_t)between_rows(w->bits, &span, p, j, p, j + 1, m) : 0;
        n += count[j].x + count[j].y;
    }
    return n;
}

/* The same from slice k to the next. */
static size_t count_between(const vvi_march_plane plane[2], const vvi_march_worker *w, const vvi_march *m, int64_t k)
{
    vvi_march_row_count *count = counts_of(m, k);
    vvi_march_span span;
    size_t n = 0;
    for (int64_t j = 0; j < m->n[1]; j++) {
        count[j].z = (uint32_t)between_rows(w->bits, &span, &plane[0], j, &plane[1], j, m);
        n += count[j].z;
    }
    return n;
}

/* Numbers the vertices of a slice's edges from `first` on; how many there are. */
static size_t number_plane(vvi_march_plane *p, const vvi_march *m, int64_t k, size_t first)
{
    const vvi_march_row_count *count = counts_of(m, k);
    uint32_t n = (uint32_t)first;
    for (int64_t j = 0; j < m->n[1]; j++) {
        p->x_first[j] = n;
        p->y_first[j] = n + count[j].x;
        n += count[j].x + count[j].y;
    }
    return n - first;
}

static size_t number_between(vvi_march_worker *w, const vvi_march *m, int64_t k, size_t first)
{
    const vvi_march_row_count *count = counts_of(m, k);
    uint32_t n = (uint32_t)first;
    for (int64_t j = 0; j < m->n[1]; j++) {
        w->z_first[j] = n;
        n += count[j].z;
    }
    return n - first;
}

/* Vertices ----------------------------------------------------------------------------------------------------------
 */

/* The rows around one end of the edges, at (j, k). */
static void surround(vvi_march_run *r, int end, const vvi_march_worker *w, const vvi_march *m, int64_t j, int64_t k)
{
    const int64_t j0 = j > 0 ? j - 1 : 0, j1 = j + 1 < m->n[1] ? j + 1 : j;
    const int64_t k0 = k > 0 ? k - 1 : 0, k1 = k + 1 < m->n[2] ? k + 1 : k;
    r->row[end][0] = vvi_march_row(w, m, j, k);
    r->row[end][1] = vvi_march_row(w, m, j0, k);
    r->row[end][2] = vvi_march_row(w, m, j1, k);
    r->row[end][3] = vvi_march_row(w, m, j, k0);
    r->row[end][4] = vvi_march_row(w, m, j, k1);
    r->y_times[end] = j1 - j0 == 1 ? 2 : 1;
    r->z_times[end] = k1 - k0 == 1 ? 2 : 1;
}

/* The vertices of the edges in a span of w->bits, which begin in row (j, k). */
static void put_run(vvi_march_worker *w, const vvi_march *m, vvi_march_span span, int axis, int64_t j, int64_t k)
{
    vvi_march_run run = {.x = w->list, .nx = (int32_t)m->n[0], .axis = axis, .y = (float)j, .z = (float)k};
    run.n = m->kernels->list(w->list, w->bits, span);
    surround(&run, 0, w, m, j, k);
    surround(&run, 1, w, m, j + (axis == 1), k + (axis == 2));
    m->kernels->queue[m->type](&w->queue, &run, &m->frame);
}

/* In the order of their numbers. */
static void put_plane(vvi_march_worker *w, const vvi_march *m, const vvi_march_plane *p, int64_t k)
{
    const vvi_march_row_count *count = counts_of(m, k);
    vvi_march_span span;
    w->queue.first = p->x_first[0];
    for (int64_t j = 0; j < m->n[1]; j++) {
        if (count[j].x && along_row(w->bits, &span, p, m, j))
            put_run(w, m, span, 0, j, k);
        if (count[j].y && between_rows(w->bits, &span, p, j, p, j + 1, m))
            put_run(w, m, span, 1, j, k);
    }
    m->kernels->empty[m->type](&w->queue, &m->frame);
}

static void put_between(vvi_march_worker *w, const vvi_march *m, int64_t k)
{
    const vvi_march_row_count *count = counts_of(m, k);
    vvi_march_span span;
    w->queue.first = w->z_first[0];
    for (int64_t j = 0; j < m->n[1]; j++)
        if (count[j].z && between_rows(w->bits, &span, &w->plane[0], j, &w->plane[1], j, m))
            put_run(w, m, span, 2, j, k);
    m->kernels->empty[m->type](&w->queue, &m->frame);
}

/* Cells -------------------------------------------------------------------------------------------------------------
 */

static void find_crossed(vvi_march_cells *c, const vvi_march_worker *w, const vvi_march *m, int64_t j)
{
    const vvi_march_plane *p = &w->plane[0], *q = &w->plane[1];
    vvi_march_span span;
    uint64_t *row[8];
    memset(w->crossed, 0, 8 * m->words * sizeof(uint64_t));
    for (int i = 0; i < 8; i++)
        c->crossed[i] = row[i] = w->crossed + (size_t)i * m->words;
    along_row(row[0], &span, p, m, j);
    along_row(row[1], &span, p, m, j + 1);
    along_row(row[2], &span, q, m, j);
    along_row(row[3], &span, q, m, j + 1);
    between_rows(row[4], &span, p, j, p, j + 1, m);
    between_rows(row[5], &span, q, j, q, j + 1, m);
    between_rows(row[6], &span, p, j, q, j, m);
    between_rows(row[7], &span, p, j + 1, q, j + 1, m);
}

/* Whether edges of a row of cells are crossed, once they are counted. */
static bool has_crossings(const vvi_march *m, int64_t j, int64_t k)
{
    const vvi_march_row_count *near = counts_of(m, k) + j, *far = counts_of(m, k + 1) + j;
    return (near[0].x | near[0].y | near[0].z | near[1].x | near[1].z | far[0].x | far[0].y | far[1].x) != 0;
}

/* One row of cells. False when the surface does not pass there. */
static bool begin_cells(vvi_march_cells *c, const vvi_march_worker *w, const vvi_march *m, int64_t j, int64_t k)
{
    const vvi_march_plane *p = w->plane;
    const uint64_t *known[4];
    const bool all_known = p[0].all_known && p[1].all_known;
    for (int i = 0; i < 4; i++) {
        c->inside[i] = row_of(p[i >> 1].inside, m, j + (i & 1));
        known[i] = row_of(p[i >> 1].known, m, j + (i & 1));
    }
    c->span = one_before(join(join(p[0].span[j], p[0].span[j + 1]), join(p[1].span[j], p[1].span[j + 1])));
    if (c->span.begin == c->span.end ||
        !m->kernels->active(w->bits, c->inside, all_known ? NULL : known, m->n[0], c->span))
        return false;
    c->active = w->bits;
    c->y = (float)j;
    c->z = (float)k;
    for (int i = 0; i < 4 && m->decided; i++)
        c->samples[i] = vvi_march_row(w, m, j + (i & 1), k + (i >> 1));
    if (!c->triangle)
        return true;
    const uint32_t first[8] = {p[0].x_first[j], p[0].x_first[j + 1], p[1].x_first[j], p[1].x_first[j + 1],
                               p[0].y_first[j], p[1].y_first[j],     w->z_first[j],   w->z_first[j + 1]};
    memcpy(c->first, first, sizeof first);
    c->crossed[0] = NULL; /* of the row before */
    if (!all_known)
        find_crossed(c, w, m, j);
    return true;
}

static vv_status cells_of_layer(vvi_march_cells *c, const vvi_march_worker *w, const vvi_march *m, int64_t k)
{
    for (int64_t j = 0; j + 1 < m->n[1]; j++)
        if ((!c->triangle || has_crossings(m, j, k)) && begin_cells(c, w, m, j, k))
            m->kernels->cells[m->type](c);
    return vvi_job_poll(m->job);
}

void vvi_march_turn_over(uint32_t *from, const uint32_t *to)
{
    for (; from < to; from += 3) {
        const uint32_t v = from[1];
        from[1] = from[2];
        from[2] = v;
    }
}

/* Items: some layers of cells ---------------------------------------------------------------------------------------
 */

static void next_plane(vvi_march_worker *w, const vvi_march *m, int64_t k, bool counted)
{
    const vvi_march_plane upper = w->plane[1];
    w->plane[1] = w->plane[0];
    w->plane[0] = upper;
    classify(&w->plane[1], w, m, k, counted);
    complete(w->plane, m);
}

/* Gradients look one slice further than the surface: it is on its way before they do, not one sample at a time. */
static void fetch_ahead(const vvi_march *m, int64_t k)
{
    const size_t line = 64, word = 64 * vv_type_bytes(m->brick.type);
    if (m->made || k >= m->n[2])
        return;
    for (int64_t j = 0; j < m->n[1]; j++) {
        const vvi_march_span span = m->span[k * m->n[1] + j];
        const char *row = vvi_march_row(NULL, m, j, k);
        for (size_t at = span.begin * word; at < span.end * word; at += line)
            __builtin_prefetch(row + at, 0, 2);
    }
}

static int64_t item_end(const vvi_march *m, size_t item)
{
    const int64_t end = (int64_t)(item + 1) * VVI_MARCH_LAYERS;
    return end < m->n[2] - 1 ? end : m->n[2] - 1;
}

static void keep_spans(vvi_march *m, const vvi_march_plane *p, int64_t k)
{
    memcpy(m->span + k * m->n[1], p->span, (size_t)m->n[1] * sizeof *m->span);
}

/* Samples of a plane that are no numbers. */
static size_t count_unknown(const vvi_march_plane *p, const vvi_march *m)
{
    size_t known = 0;
    if (p->all_known)
        return 0;
    for (int64_t j = 0; j < m->n[1]; j++) {
        const uint64_t *bits = row_of(p->known, m, j);
        for (size_t w = 0; w + 1 < m->words; w++)
            known += (size_t)__builtin_popcountll(bits[w] & (w + 2 < m->words ? ~(uint64_t)0 : last_word(m)));
    }
    return (size_t)(m->n[0] * m->n[1]) - known;
}

static vv_status count_item(void *scratch, void *user, size_t item)
{
    vvi_march *m = user;
    vvi_march_worker *w = scratch;
    vvi_march_cells c = {.frame = &m->frame};
    const int64_t begin = (int64_t)item * VVI_MARCH_LAYERS, end = item_end(m, item);
    size_t vertices = 0, unknown = 0;
    vv_status st = VV_OK;
    vvi_march_make(w, m, item);
    classify(&w->plane[1], w, m, begin, false);
    for (int64_t k = begin; k < end && st == VV_OK; k++) {
        const size_t interior = c.n_interior;
        next_plane(w, m, k + 1, false);
        keep_spans(m, &w->plane[0], k);
        unknown += count_unknown(&w->plane[0], m);
        vertices += count_plane(&w->plane[0], w, m, k) + count_between(w->plane, w, m, k);
        st = cells_of_layer(&c, w, m, k);
        m->interior[k] = (uint32_t)(c.n_interior - interior);
    }
    if (end == m->n[2] - 1) {
        vertices += count_plane(&w->plane[1], w, m, end);
        keep_spans(m, &w->plane[1], end);
        unknown += count_unknown(&w->plane[1], m);
    }
    m->count[item] = (vvi_march_count){vertices + c.n_interior, c.n_triangles, unknown};
    return st;
}

static vv_status fill_item(void *scratch, void *user, size_t item)
{
    vvi_march *m = user;
    vvi_march_worker *w = scratch;
    const vvi_march_count *count = &m->count[item];
    const int64_t begin = (int64_t)item * VVI_MARCH_LAYERS, end = item_end(m, item);
    uint32_t *const triangles = m->arrays.triangles + 3 * count->triangles;
    vvi_march_cells c = {
        .frame = &m->frame, .triangle = triangles, .end = m->arrays.triangles + 3 * count[1].triangles};
    size_t at = count->vertices;
    vv_status st = VV_OK;
    if (count[1].vertices == at && count[1].triangles == count->triangles)
        return VV_OK;
    vvi_march_make(w, m, item);
    classify(&w->plane[1], w, m, begin, true);
    size_t n = number_plane(&w->plane[1], m, begin, at);
    for (int64_t k = begin; k < end && st == VV_OK; k++) {
        next_plane(w, m, k + 1, true);
        fetch_ahead(m, k + 2);
        put_plane(w, m, &w->plane[0], k);
        at += n;
        at += number_between(w, m, k, at);
        put_between(w, m, k);
        c.first_interior = (uint32_t)at;
        at += m->interior[k];
        n = number_plane(&w->plane[1], m, k + 1, at);
        st = cells_of_layer(&c, w, m, k);
    }
    if (end == m->n[2] - 1)
        put_plane(w, m, &w->plane[1], end);
    if (m->mirrored)
        vvi_march_turn_over(triangles, c.triangle);
    return st;
}

static vv_status start(void **scratch_out, void *user, int worker)
{
    (void)worker;
    vvi_march_worker *w = NULL;
    const vv_status st = vvi_march_worker_new(&w, user);
    *scratch_out = w;
    return st;
}

static void finish(void *scratch, void *user)
{
    (void)user;
    vvi_march_worker_free(scratch);
}

/* The whole ---------------------------------------------------------------------------------------------------------
 */

static bool read_as_it_lies(const vvi_march *m, const vvi_marching_options *o)
{
    static const vv_type types[VVI_MARCH_TYPES] = {VV_TYPE_U8, VV_TYPE_U16, VV_TYPE_I16, VV_TYPE_F32};
    for (int t = 0; t < VVI_MARCH_TYPES; t++)
        if (types[t] == m->brick.type && m->brick.stride[0] == (int64_t)vv_type_bytes(types[t]) && !o->cap)
            return true;
    return false;
}

/* The least sample of the type that is not below `stored`, or, inverted, that is above. False: there is none, or all
 * are. */
static bool find_threshold(vvi_march *m)
{
    const double s = m->inverted ? nextafter(m->stored, INFINITY) : m->stored;
    const double least = ceil(s);
    switch (m->brick.type) {
#define INTEGER(vv_name, march_type, ctype)                                                                            \
    case vv_name: {                                                                                                    \
        const ctype t = (ctype)fmin(fmax(least, vvi_type_min(vv_name)), vvi_type_max(vv_name));                        \
        memcpy(m->threshold, &t, sizeof t);                                                                            \
        m->type = march_type;                                                                                          \
        return least > vvi_type_min(vv_name) && least <= vvi_type_max(vv_name);                                        \
    }
        INTEGER(VV_TYPE_U8, VVI_MARCH_U8, uint8_t)
        INTEGER(VV_TYPE_U16, VVI_MARCH_U16, uint16_t)
        INTEGER(VV_TYPE_I16, VVI_MARCH_I16, int16_t)
#undef INTEGER
    default: {
        float t = (float)s;
        if ((double)t < s)
            t = nextafterf(t, INFINITY);
        memcpy(m->threshold, &t, sizeof t);
        m->type = VVI_MARCH_F32;
        return isfinite(t);
    }
    }
}

/* Places count from the world place of the first sample, and with the cap from one before it. */
static vv_status make_frame(vvi_march *m, const vv_grid *grid)
{
    const vv_affine *to_world = &grid->index_to_world;
    const double voxel = vv_grid_voxel(grid), sign = m->inverted ? 1 : -1;
    vv_affine inverse;
    if (!vv_affine_invert(&inverse, *to_world))
        return vv_fail(VV_E_ARGUMENT, "the grid's axes lie in one plane: there is no surface");
    for (int i = 0; i < 3; i++) {
        float *row = m->frame.to_world[i];
        row[3] = 0;
        for (int a = 0; a < 3; a++) {
            row[a] = (float)(&to_world->axis[a].x)[i];
            row[3] -= (float)m->pad * row[a];
            m->frame.to_normal[i][a] = (float)(sign * voxel * (&inverse.axis[i].x)[a]);
        }
    }
    m->mirrored = vv_affine_determinant(*to_world) < 0;
    m->frame.iso = m->made ? 0 : (float)m->stored;
    return VV_OK;
}

static vv_status prepare(vvi_march *m, const vv_field *field, const vvi_marching_options *o)
{
    const vv_field_info *info = vv_field_get_info(field);
    m->kernels = vvi_march_kernels_for(vvi_job_cpu(m->job));
    m->component = o->component;
    m->decided = o->topology == VVI_MARCHING_DECIDED;
    m->pad = o->cap;
    m->stored = (o->value - info->value_offset) / info->value_scale;
    m->made = !read_as_it_lies(m, o);
    m->falls = info->value_scale < 0;
    m->inverted = m->falls && !m->made; /* made floats rise with the value */
    if (m->made) {
        const float zero = 0;
        memcpy(m->threshold, &zero, sizeof zero);
        m->type = VVI_MARCH_F32;
    }
    for (int a = 0; a < 3; a++)
        m->n[a] = m->grid.dims[a] + 2 * m->pad;
    m->words = (size_t)(m->n[0] + 63) / 64 + 1;
    return make_frame(m, &m->grid);
}

static vv_status check(const vv_field *field, const vvi_marching_options *o)
{
    const vv_field_info *info = vv_field_get_info(field);
    if (!isfinite(o->value))
        return vv_fail(VV_E_ARGUMENT, "a surface needs a finite value; this is %g", o->value);
    if (o->component < 0 || o->component >= info->components)
        return vv_fail(VV_E_ARGUMENT, "component %d is not there; there are 0 to %d", o->component,
                       info->components - 1);
    if (info->meaning == VV_MEANING_LABEL)
        return vv_fail(VV_E_UNSUPPORTED, "labels are names and have no values in between: choose one of them");
    return VV_OK;
}

/* Counts become those of all items before. */
static void sum_counts(vvi_march *m)
{
    vvi_march_count before = {0, 0, 0};
    for (size_t i = 0; i <= m->n_items; i++) {
        const vvi_march_count here = m->count[i];
        m->count[i] = before;
        before.vertices += here.vertices;
        before.triangles += here.triangles;
        before.unknown += here.unknown;
    }
}

vv_status vvi_march_new_mesh(vv_mesh **out, vvi_march *m, vvi_march_count count, bool normals)
{
    vv_mesh_info mesh = {.n_vertices = count.vertices,
                         .n_triangles = count.triangles,
                         .origin = m->grid.index_to_world.origin,
                         .space = m->grid.space};
    memcpy(mesh.unit, m->grid.unit, sizeof mesh.unit);
    const vv_status st = vvi_mesh_new(out, &m->arrays, &mesh, normals ? VVI_MESH_NORMALS : 0, m->job);
    m->frame.position = m->arrays.positions;
    m->frame.normal = m->arrays.normals;
    return st;
}

/* What the min-max blocks of a field say of its rows, where they are wanted and can say it. */
static vv_status ask_blocks(vvi_march *m, const vv_field *field, const vvi_marching_options *o)
{
    enum { SHIFT = 3 };
    vvi_cached *minmax = NULL;
    if (!o->blocks || m->made || o->box.n[0] || !m->n_items)
        return VV_OK;
    const vvi_cache_key key = vvi_minmax_key("minmax", field, o->component, SHIFT);
    vv_status st = vvi_minmax_get(&minmax, &key, &m->brick, o->component, SHIFT, m->job);
    if (st == VV_OK)
        st = vvi_march_blocks(m, vvi_cached_value(minmax));
    vvi_cache_release(minmax);
    return st;
}

static vv_status march(vv_mesh **out, vvi_march *m, const vv_field *field, bool normals)
{
    static const vvi_work count = {.stage = "surface", .start = start, .item = count_item, .finish = finish};
    static const vvi_work fill = {.stage = "triangles", .start = start, .item = fill_item, .finish = finish};
    vv_status st;
    if ((st = vvi_parallel_for(m->job, &count, m, m->n_items)) != VV_OK)
        return st;
    sum_counts(m);
    const size_t unknown = m->count[m->n_items].unknown;
    if (unknown)
        vvi_log(m->job, VV_LOG_WARNING, "surface", "%zu samples are no numbers: the cells around them are left out",
                unknown);
    if ((st = vvi_march_new_mesh(out, m, m->count[m->n_items], normals)) == VV_OK)
        st = vvi_parallel_for(m->job, &fill, m, m->n_items);
    if (st == VV_OK)
        st = vvi_normals_fill(m->arrays.normals, *out, m->job);
    if (st == VV_OK)
        st = vv_field_health(field);
    return st;
}

static bool has_cells(const vvi_march *m)
{
    return m->n[0] > 1 && m->n[1] > 1 && m->n[2] > 1;
}

vv_status vvi_march_open(bool *some_out, vvi_march *m, const vv_field *field, const vvi_marching_options *o,
                         vv_job *job)
{
    const vv_box box = o->box.n[0] ? o->box : vv_field_box(field);
    *m = (vvi_march){.job = job};
    *some_out = false;
    vv_status st = check(field, o);
    if (st == VV_OK)
        st = vv_field_brick(&m->brick, field, &box, job);
    if (st != VV_OK)
        return st;
    m->grid = vv_grid_crop(&vv_field_get_info(field)->grid, &box);
    if ((st = prepare(m, field, o)) == VV_OK)
        *some_out = has_cells(m) && (m->made || find_threshold(m));
    return st;
}

vv_status vvi_marching_cubes(vv_mesh **out, const vv_field *field, const vvi_marching_options *o, vv_job *job)
{
    vvi_march m;
    bool some;
    *out = NULL;
    vv_status st = vvi_march_open(&some, &m, field, o, job);
    if (st == VV_OK) {
        m.n_items = some ? (size_t)(m.n[2] - 2) / VVI_MARCH_LAYERS + 1 : 0;
        m.count = vvi_alloc_zeroed(job, (m.n_items + 1) * sizeof *m.count, VVI_MEM_SCRATCH);
        m.interior = vvi_alloc_zeroed(job, (size_t)m.n[2] * sizeof *m.interior, VVI_MEM_SCRATCH);
        m.span = vvi_alloc(job, (size_t)(m.n[1] * m.n[2]) * sizeof *m.span, VVI_MEM_SCRATCH);
        m.rows = vvi_alloc(job, (size_t)(m.n[1] * m.n[2]) * sizeof *m.rows, VVI_MEM_SCRATCH);
        if (!m.count || !m.interior || !m.span || !m.rows)
            st = vv_fail_memory((size_t)(m.n[1] * m.n[2]) * sizeof *m.rows);
        if (st == VV_OK && (st = ask_blocks(&m, field, o)) == VV_OK)
            st = march(out, &m, field, !o->no_normals);
    }
    vvi_free(m.count);
    vvi_free(m.interior);
    vvi_free(m.span);
    vvi_free(m.rows);
    vvi_free(m.blocks);
    vv_brick_release(&m.brick);
    if (st != VV_OK) {
        vv_mesh_release(*out);
        *out = NULL;
    }
    return st;
}
