/* The items of Marching Cubes: some layers of cells are counted, and filled in at known places then. */
#include "core/job.h"
#include "surface/marching_planes.h"

#include <string.h>

/* Vertices ----------------------------------------------------------------------------------------------------------
 */

/* The rows around one end of the edges, at (j, k). */
static void surround(vvi_march_run *r, int end, const vvi_march_worker *w, const vvi_march *m, int64_t j, int64_t k)
{
    const int64_t j0 = j > 0 ? j - 1 : 0, j1 = j + 1 < m->n[1] ? j + 1 : j;
    const int64_t k0 = k > 0 ? k - 1 : 0, k1 = k + 1 < m->n[2] ? k + 1 : k;
    r->row[end][0] = vvi_march_row(w, j, k);
    r->row[end][1] = vvi_march_row(w, j0, k);
    r->row[end][2] = vvi_march_row(w, j1, k);
    r->row[end][3] = vvi_march_row(w, j, k0);
    r->row[end][4] = vvi_march_row(w, j, k1);
    r->y_times[end] = j1 - j0 == 1 ? 2 : 1;
    r->z_times[end] = k1 - k0 == 1 ? 2 : 1;
}

/* The vertices of the edges in a span of w->bits, which begin in row (j, k). */
static void put_run(vvi_march_worker *w, const vvi_march *m, vvi_march_span span, int axis, int64_t j, int64_t k)
{
    vvi_march_run run = {
        .bits = w->bits, .span = span, .nx = (int32_t)m->n[0], .axis = axis, .y = (float)j, .z = (float)k};
    surround(&run, 0, w, m, j, k);
    surround(&run, 1, w, m, j + (axis == 1), k + (axis == 2));
    m->kernels->queue[m->type](&w->queue, &run, &m->frame);
}

/* In the order of their numbers. */
static void put_plane(vvi_march_worker *w, const vvi_march *m, const vvi_march_plane *p, int64_t k)
{
    const vvi_march_row_count *count = vvi_march_counts(m, k);
    vvi_march_span span;
    w->queue.first = p->x_first[0];
    for (int64_t j = 0; j < m->n[1]; j++) {
        if (count[j].edges[0] && vvi_march_along(w->bits, &span, p, j, m))
            put_run(w, m, span, 0, j, k);
        if (count[j].edges[1] && vvi_march_between(w->bits, &span, p, j, p, j + 1, m))
            put_run(w, m, span, 1, j, k);
    }
    m->kernels->empty[m->type](&w->queue, &m->frame);
}

static void put_between(vvi_march_worker *w, const vvi_march *m, int64_t k)
{
    const vvi_march_row_count *count = vvi_march_counts(m, k);
    vvi_march_span span;
    w->queue.first = w->z_first[0];
    for (int64_t j = 0; j < m->n[1]; j++)
        if (count[j].edges[2] && vvi_march_between(w->bits, &span, &w->plane[0], j, &w->plane[1], j, m))
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
    vvi_march_along(row[0], &span, p, j, m);
    vvi_march_along(row[1], &span, p, j + 1, m);
    vvi_march_along(row[2], &span, q, j, m);
    vvi_march_along(row[3], &span, q, j + 1, m);
    vvi_march_between(row[4], &span, p, j, p, j + 1, m);
    vvi_march_between(row[5], &span, q, j, q, j + 1, m);
    vvi_march_between(row[6], &span, p, j, q, j, m);
    vvi_march_between(row[7], &span, p, j + 1, q, j + 1, m);
}

/* One row of cells. False when the surface does not pass there. */
static bool begin_cells(vvi_march_cells *c, const vvi_march_worker *w, const vvi_march *m, int64_t j, int64_t k)
{
    const vvi_march_plane *p = w->plane;
    const uint64_t *known[4];
    const bool all_known = p[0].all_known && p[1].all_known;
    for (int i = 0; i < 4; i++) {
        c->inside[i] = vvi_march_bits(p[i >> 1].inside, m, j + (i & 1));
        known[i] = vvi_march_bits(p[i >> 1].known, m, j + (i & 1));
    }
    c->span = vvi_march_one_before(
        vvi_march_join(vvi_march_join(p[0].span[j], p[0].span[j + 1]), vvi_march_join(p[1].span[j], p[1].span[j + 1])));
    if (c->span.begin == c->span.end ||
        !m->kernels->active(w->bits, c->inside, all_known ? NULL : known, m->n[0], c->span))
        return false;
    c->active = w->bits;
    c->y = (float)j;
    c->z = (float)k;
    for (int i = 0; i < 4 && m->decided; i++)
        c->samples[i] = vvi_march_row(w, j + (i & 1), k + (i >> 1));
    return true;
}

/* Where the numbers of its vertices begin. */
static void number_cells(vvi_march_cells *c, const vvi_march_worker *w, const vvi_march *m, int64_t j)
{
    const vvi_march_plane *p = w->plane;
    const uint32_t first[8] = {p[0].x_first[j], p[0].x_first[j + 1], p[1].x_first[j], p[1].x_first[j + 1],
                               p[0].y_first[j], p[1].y_first[j],     w->z_first[j],   w->z_first[j + 1]};
    memcpy(c->first, first, sizeof first);
    c->crossed[0] = NULL; /* of the row before */
    if (!p[0].all_known || !p[1].all_known)
        find_crossed(c, w, m, j);
}

/* Rows of cells that the surface passes are marked. */
static vv_status count_layer(vvi_march_cells *c, const vvi_march_worker *w, const vvi_march *m, int64_t k)
{
    for (int64_t j = 0; j + 1 < m->n[1]; j++)
        if (begin_cells(c, w, m, j, k)) {
            m->passes[k * m->n[1] + j] = true;
            m->kernels->count_cells[m->type](c);
        }
    return vvi_job_poll(m->job);
}

static vv_status fill_layer(vvi_march_cells *c, const vvi_march_worker *w, const vvi_march *m, int64_t k)
{
    for (int64_t j = 0; j + 1 < m->n[1]; j++)
        if (m->passes[k * m->n[1] + j] && begin_cells(c, w, m, j, k)) {
            number_cells(c, w, m, j);
            m->kernels->cells[m->type](c);
        }
    return vvi_job_poll(m->job);
}

/* Items: some layers of cells ---------------------------------------------------------------------------------------
 */

/* Gradients look one slice further than the surface: it is on its way before they do, not one sample at a time. */
static void fetch_ahead(const vvi_march_worker *w, const vvi_march *m, int64_t k)
{
    const size_t word = 64 * vv_type_bytes(m->brick.type);
    if (m->made || k >= m->n[2])
        return;
    const bool *here = m->passes + k * m->n[1], *before = here - m->n[1];
    for (int64_t j = 0; j < m->n[1]; j++) {
        if (!(here[j] || before[j] || (j > 0 && before[j - 1])))
            continue;
        const vvi_march_span span = m->span[k * m->n[1] + j];
        const char *row = vvi_march_row(w, j, k);
        vvi_march_fetch(row + span.begin * word, (size_t)(span.end - span.begin) * word);
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

static vv_status count_layers(vvi_march_worker *w, vvi_march *m, size_t item)
{
    vvi_march_cells c = {.frame = &m->frame};
    const int64_t begin = (int64_t)item * VVI_MARCH_LAYERS, end = item_end(m, item);
    size_t vertices = 0, unknown = 0;
    vv_status st = VV_OK;
    vvi_march_make(w, m, item);
    vvi_march_first_plane(w, m, begin, false);
    for (int64_t k = begin; k < end && st == VV_OK; k++) {
        const size_t interior = c.n_interior;
        vvi_march_next_plane(w, m, k + 1, false);
        keep_spans(m, &w->plane[0], k);
        unknown += vvi_march_count_unknown(&w->plane[0], m);
        vertices += vvi_march_count_edges(&w->plane[0], &w->plane[1], w, m, k);
        st = count_layer(&c, w, m, k);
        m->interior[k] = (uint32_t)(c.n_interior - interior);
    }
    if (end == m->n[2] - 1) {
        keep_spans(m, &w->plane[1], end);
        unknown += vvi_march_count_unknown(&w->plane[1], m);
        vertices += vvi_march_count_edges(&w->plane[1], NULL, w, m, end);
    }
    m->count[item] = (vvi_march_count){vertices + c.n_interior, c.n_triangles, unknown};
    return st;
}

static vv_status fill_layers(vvi_march_worker *w, vvi_march *m, size_t item)
{
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
    w->queue.missing = false;
    vvi_march_first_plane(w, m, begin, true);
    size_t n = vvi_march_number_plane(&w->plane[1], m, begin, at);
    for (int64_t k = begin; k < end && st == VV_OK; k++) {
        vvi_march_next_plane(w, m, k + 1, true);
        fetch_ahead(w, m, k + 2);
        put_plane(w, m, &w->plane[0], k);
        at += n;
        at += vvi_march_number_between(w, m, k, at);
        put_between(w, m, k);
        c.first_interior = (uint32_t)at;
        at += m->interior[k];
        n = vvi_march_number_plane(&w->plane[1], m, k + 1, at);
        st = fill_layer(&c, w, m, k);
    }
    if (end == m->n[2] - 1)
        put_plane(w, m, &w->plane[1], end);
    if (m->mirrored)
        vvi_march_turn_over(triangles, c.triangle);
    if (w->queue.missing || c.missing)
        atomic_store_explicit(&m->missing, true, memory_order_relaxed);
    return st;
}

/* Values take turns at a piece of the samples, so that these are read once. */
static vvi_march *of_item(const vvi_marches *all, size_t *item)
{
    vvi_march *m = &all->march[*item % all->n];
    *item /= all->n;
    return m->some ? m : NULL;
}

static vv_status count_item(void *scratch, void *user, size_t item)
{
    vvi_march *m = of_item(user, &item);
    return m ? count_layers(scratch, m, item) : VV_OK;
}

static vv_status fill_item(void *scratch, void *user, size_t item)
{
    vvi_march *m = of_item(user, &item);
    return m ? fill_layers(scratch, m, item) : VV_OK;
}

static vv_status start(void **scratch_out, void *user, int worker)
{
    const vvi_marches *all = user;
    vvi_march_worker *w = NULL;
    (void)worker;
    const vv_status st = vvi_march_worker_new(&w, all->march);
    *scratch_out = w;
    return st;
}

static void finish(void *scratch, void *user)
{
    (void)user;
    vvi_march_worker_free(scratch);
}

vv_status vvi_march_count_all(vvi_marches *all)
{
    static const vvi_work count = {.stage = "surface", .start = start, .item = count_item, .finish = finish};
    return vvi_parallel_for(all->march->job, &count, all, all->n * all->march->n_items);
}

vv_status vvi_march_fill_all(vvi_marches *all)
{
    static const vvi_work fill = {.stage = "triangles", .start = start, .item = fill_item, .finish = finish};
    return vvi_parallel_for(all->march->job, &fill, all, all->n * all->march->n_items);
}
