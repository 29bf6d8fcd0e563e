#include "surface/smooth.h"
#include "core/job.h"
#include "core/memory.h"
#include "grid/mesh.h"
#include "grid/mesh_normals.h"
#include "surface/smooth_filter.h"
#include "surface/smooth_volume.h"
#include "surface/vertex_places.h"

#include <string.h>

enum { BLOCK = 1 << 13 };

/* Lists of vertices by vertex: those of v are from first[v] to first[v + 1]. */
typedef struct lists {
    size_t *first;
    uint32_t *all;
} lists;

/* A mesh while it is smoothed. */
typedef struct work {
    const vv_mesh_info *mesh;
    vvi_smooth_options options;
    vv_job *job;
    uint32_t *place; /* the vertex that stands for all at its place */
    lists to, from;  /* ends of the directed edges that begin, and beginnings of those that end, at a vertex */
    uint32_t *n;     /* neighbours that count, at the front of `to` */
    uint8_t *at_border;
    vvi_smooth_pieces pieces;
    double *now, *last, *sum; /* T_i(mean) of the places from their piece's origin, T_{i-1}, and the filter up to i */
    double now_by, last_by, c;
} work;

/* Neighbours --------------------------------------------------------------------------------------------------------
 */

/* `back`: from the ends of the edges to their beginnings. */
static vv_status list_edges(lists *l, const work *w, bool back)
{
    const vv_mesh_info *m = w->mesh;
    const size_t n = 3 * m->n_triangles;
    l->first = vvi_alloc_zeroed(w->job, (m->n_vertices + 2) * sizeof *l->first, VVI_MEM_SCRATCH);
    l->all = vvi_alloc(w->job, (n + 1) * sizeof *l->all, VVI_MEM_SCRATCH);
    if (!l->first || !l->all)
        return vv_fail_memory((n + 1) * sizeof *l->all);
    size_t *next = l->first + 1;
    for (size_t i = 0; i < n; i++)
        next[w->place[m->triangles[i]] + 1]++;
    for (size_t v = 1; v <= m->n_vertices; v++)
        next[v] += next[v - 1];
    for (size_t i = 0; i < n; i++) {
        const size_t t = i / 3 * 3, other = t + (i + (back ? 2 : 1)) % 3;
        l->all[next[w->place[m->triangles[i]]]++] = w->place[m->triangles[other]];
    }
    return vvi_job_poll(w->job);
}

static void sort(uint32_t *a, size_t n)
{
    for (size_t gap = n / 2; gap > 0; gap /= 2) /* Shell 1959: lists are of about six */
        for (size_t i = gap; i < n; i++) {
            const uint32_t x = a[i];
            size_t j = i;
            for (; j >= gap && a[j - gap] > x; j -= gap)
                a[j] = a[j - gap];
            a[j] = x;
        }
}

/* How many equal numbers begin a sorted list. */
static size_t run_of(const uint32_t *a, size_t n)
{
    size_t k = 1;
    while (k < n && a[k] == a[0])
        k++;
    return k;
}

/* Two sorted lists become at most as many numbers as both have, in `out`, which may not overlap them: those that are in
 * either, once; `open`: only those that the lists do not have equally often. */
static size_t merge(uint32_t *out, const uint32_t *a, size_t na, const uint32_t *b, size_t nb, bool open)
{
    size_t n = 0;
    while (na || nb) {
        const uint32_t x = !nb || (na && a[0] <= b[0]) ? a[0] : b[0];
        const size_t ka = na && a[0] == x ? run_of(a, na) : 0, kb = nb && b[0] == x ? run_of(b, nb) : 0;
        if (!open || ka != kb)
            out[n++] = x;
        a += ka, na -= ka;
        b += kb, nb -= kb;
    }
    return n;
}

/* The neighbours that a vertex is drawn to: all of them, or at the border, where more edges come than go or the other
 * way round, those along the border. They are put where the lists were, in `to` and, past its end, in `from`. */
static void choose_neighbours(work *w, size_t v, uint32_t *scratch)
{
    uint32_t *to = w->to.all + w->to.first[v], *from = w->from.all + w->from.first[v];
    const size_t n = w->to.first[v + 1] - w->to.first[v]; /* each triangle adds one to both */
    sort(to, n);
    sort(from, n);
    size_t k = merge(scratch, to, n, from, n, true);
    w->at_border[v] = k > 0;
    if (k > 0 && w->options.fix_border)
        k = 0;
    else if (k == 0)
        k = merge(scratch, to, n, from, n, false);
    memcpy(to, scratch, (k < n ? k : n) * sizeof *to);
    if (k > n)
        memcpy(from, scratch + n, (k - n) * sizeof *from);
    w->n[v] = (uint32_t)k;
}

static size_t blocks_of(const work *w)
{
    return w->mesh->n_vertices / BLOCK + (w->mesh->n_vertices % BLOCK != 0);
}

static size_t end_of(const work *w, size_t item)
{
    return (item + 1) * BLOCK < w->mesh->n_vertices ? (item + 1) * BLOCK : w->mesh->n_vertices;
}

static vv_status neighbours_item(void *none, void *shared, size_t item)
{
    (void)none;
    work *w = shared;
    size_t most = 0;
    for (size_t v = item * BLOCK; v < end_of(w, item); v++)
        most = most > w->to.first[v + 1] - w->to.first[v] ? most : w->to.first[v + 1] - w->to.first[v];
    uint32_t *scratch = vvi_alloc(w->job, (2 * most + 1) * sizeof *scratch, VVI_MEM_SCRATCH);
    if (!scratch)
        return vv_fail_memory((2 * most + 1) * sizeof *scratch);
    for (size_t v = item * BLOCK; v < end_of(w, item); v++)
        choose_neighbours(w, v, scratch);
    vvi_free(scratch);
    return VV_OK;
}

/* Steps -------------------------------------------------------------------------------------------------------------
 */

static void add(double sum[3], const double *places, const uint32_t *list, size_t n)
{
    for (size_t i = 0; i < n; i++)
        for (size_t c = 0; c < 3; c++)
            sum[c] += places[3 * (size_t)list[i] + c];
}

/* The mean of the neighbours; of a vertex without any, its own place. */
static void mean(double out[3], const work *w, size_t v)
{
    const size_t n = w->n[v], room = w->to.first[v + 1] - w->to.first[v];
    double sum[3] = {0};
    add(sum, w->now, w->to.all + w->to.first[v], n < room ? n : room);
    if (n > room)
        add(sum, w->now, w->from.all + w->from.first[v], n - room);
    for (size_t c = 0; c < 3; c++)
        out[c] = n ? sum[c] / (double)n : w->now[3 * v + c];
}

static bool is_done(const work *w, size_t v)
{
    return w->pieces.all[w->pieces.of[v]].done;
}

/* T_i is 2 x T_{i-1} - T_{i-2}: it takes the place of T_{i-2}. */
static vv_status step_item(void *none, void *shared, size_t item)
{
    (void)none;
    work *w = shared;
    for (size_t v = item * BLOCK; v < end_of(w, item); v++) {
        double x[3];
        if (is_done(w, v))
            continue;
        mean(x, w, v);
        for (size_t c = 0; c < 3; c++) {
            double *place = w->last + 3 * v + c;
            *place = w->now_by * x[c] - w->last_by * *place;
            w->sum[3 * v + c] += w->c * *place;
        }
    }
    return VV_OK;
}

/* Of the pieces that are not done: as they were, times the first coefficient. */
static void begin(work *w, const vvi_smooth_filter *f)
{
    for (size_t i = 0; i < 3 * w->mesh->n_vertices; i++)
        if (!is_done(w, i / 3)) {
            const double from = w->pieces.all[w->pieces.of[i / 3]].origin[i % 3];
            w->now[i] = (double)w->mesh->positions[i] - from;
            w->last[i] = 0;
            w->sum[i] = f->c[0] * w->now[i];
        }
}

static vv_status take_steps(work *w, const vvi_smooth_filter *f)
{
    const vvi_work items = {.item = step_item};
    vv_status st = VV_OK;
    begin(w, f);
    for (int i = 1; i < f->n && st == VV_OK; i++) {
        w->now_by = i == 1 ? 1 : 2;
        w->last_by = i == 1 ? 0 : 1;
        w->c = f->c[i];
        st = vvi_parallel_for(w->job, &items, w, blocks_of(w));
        double *const swap = w->now;
        w->now = w->last;
        w->last = swap;
        if (st == VV_OK)
            st = vvi_job_progress(w->job, "smooth", (uint64_t)i, (uint64_t)f->n - 1);
    }
    return st;
}

static vv_status filter(work *w, double pass_band)
{
    vvi_smooth_filter f;
    vv_status st = vvi_smooth_filter_make(&f, 2 * w->options.iterations, pass_band, w->job);
    if (st == VV_OK && (st = take_steps(w, &f)) == VV_OK)
        vvi_smooth_pieces_mend(&w->pieces, w->sum, w->last, w->mesh, w->place);
    vvi_free(f.c);
    return st;
}

static bool all_done(const work *w)
{
    bool done = true;
    for (size_t i = 0; i < w->pieces.n; i++)
        done &= w->pieces.all[i].done;
    return done;
}

/* With a wider and wider pass band for pieces that are short-waved as a whole. */
static vv_status smooth(work *w)
{
    const vvi_smooth_filter none = {.c = &(double){1}, .n = 1};
    vv_status st = VV_OK;
    for (double band = w->options.pass_band; w->options.iterations && band < 2 && st == VV_OK && !all_done(w);
         band *= 2)
        st = filter(w, band);
    begin(w, &none);
    return st;
}

/* The whole ---------------------------------------------------------------------------------------------------------
 */

static vv_status prepare(work *w)
{
    const vv_mesh_info *m = w->mesh;
    const vvi_work items = {.item = neighbours_item};
    vv_status st = vvi_number_places(&w->place, m->positions, m->n_vertices, w->job);
    if (st != VV_OK || (st = list_edges(&w->to, w, false)) != VV_OK || (st = list_edges(&w->from, w, true)) != VV_OK)
        return st;
    w->n = vvi_alloc(w->job, (m->n_vertices + 1) * sizeof *w->n, VVI_MEM_SCRATCH);
    w->at_border = vvi_alloc(w->job, m->n_vertices + 1, VVI_MEM_SCRATCH);
    w->last = vvi_alloc(w->job, (m->n_vertices + 1) * 3 * sizeof *w->last, VVI_MEM_SCRATCH);
    w->now = vvi_alloc(w->job, (m->n_vertices + 1) * 3 * sizeof *w->now, VVI_MEM_SCRATCH);
    w->sum = vvi_alloc(w->job, (m->n_vertices + 1) * 3 * sizeof *w->sum, VVI_MEM_SCRATCH);
    if (!w->n || !w->at_border || !w->last || !w->now || !w->sum)
        return vv_fail_memory((m->n_vertices + 1) * 3 * sizeof *w->last);
    if ((st = vvi_parallel_for(w->job, &items, w, blocks_of(w))) != VV_OK ||
        (st = vvi_smooth_pieces_find(&w->pieces, m, w->place, w->job)) != VV_OK)
        return st;
    for (size_t v = 0; v < m->n_vertices; v++)
        w->pieces.all[w->pieces.of[v]].open |= w->at_border[v] != 0;
    return VV_OK;
}

/* Vertices without neighbours are where they were, to the last bit. */
static void put_vertex(float out[3], const work *w, size_t v)
{
    const vvi_smooth_piece *piece = &w->pieces.all[w->pieces.of[v]];
    for (size_t c = 0; c < 3; c++)
        out[c] = (float)(w->sum[3 * v + c] + piece->origin[c]);
    if (w->n[v] == 0)
        memcpy(out, w->mesh->positions + 3 * v, 3 * sizeof *out);
}

static vv_status make_mesh(vv_mesh **out, const vv_mesh *mesh, const work *w)
{
    const vv_mesh_info *m = w->mesh;
    vvi_mesh_arrays a;
    vv_status st = vvi_mesh_copy(out, &a, mesh, vvi_mesh_with(mesh), w->job);
    if (st != VV_OK)
        return st;
    for (size_t v = 0; v < m->n_vertices; v++)
        put_vertex(a.positions + 3 * v, w, w->place[v]);
    if (m->normals)
        st = vvi_normals_of(a.normals, a.positions, m->n_vertices, a.triangles, m->n_triangles, w->job);
    if (st != VV_OK) {
        vv_mesh_release(*out);
        *out = NULL;
    }
    return st;
}

static vv_status check(const vvi_smooth_options *o)
{
    if (o->iterations < 0 || o->iterations > 1000)
        return vv_fail(VV_E_ARGUMENT, "smooth: iterations is %d; expected 0 to 1000", o->iterations);
    if (!(o->pass_band > 0 && o->pass_band < 2))
        return vv_fail(VV_E_ARGUMENT, "smooth: the pass band is %g; expected more than 0 and less than 2",
                       o->pass_band);
    return VV_OK;
}

vvi_smooth_options vvi_smooth_options_default(void)
{
    return (vvi_smooth_options){.iterations = 20, .pass_band = .1};
}

vv_status vvi_mesh_smooth(vv_mesh **out, const vv_mesh *mesh, const vvi_smooth_options *options, vv_job *job)
{
    work w = {.mesh = vv_mesh_get_info(mesh), .options = *options, .job = job};
    vv_status st;
    *out = NULL;
    if ((st = check(options)) != VV_OK)
        return st;
    if ((st = prepare(&w)) == VV_OK && (st = smooth(&w)) == VV_OK)
        st = make_mesh(out, mesh, &w);
    vvi_free(w.place);
    vvi_free(w.to.first);
    vvi_free(w.to.all);
    vvi_free(w.from.first);
    vvi_free(w.from.all);
    vvi_free(w.n);
    vvi_free(w.at_border);
    vvi_free(w.now);
    vvi_free(w.last);
    vvi_free(w.sum);
    vvi_smooth_pieces_finish(&w.pieces);
    return st;
}
