/* The order of painting. Two areas that overlap on the picture have one, since one is before the other; a strongly
 * connected component (Tarjan 1972) of these relations is a circle that must be cut. */
#include "core/job.h"
#include "gfx/facets.h"
#include <stdlib.h>
#include <string.h>

/* Overlaps below decide nothing, and areas that go through each other by less are not cut: square pixels. */
#define OVERLAP 0.02
#define THROUGH 1.0

enum { ROUNDS = 64, NONE = -1 };
/* Pairs looked at, after which nothing more is cut: some seconds. */
#define WORK_MOST UINT64_C(20000000)

/* "over" is painted after "under". */
typedef struct relation {
    uint32_t over, under;
} relation;

typedef struct ordering {
    vvi_gfx_facet *facet;
    size_t n;
    vv_job *job;
    double tolerance; /* of nearness */
    /* cells of the picture, and the facets in each, ascending */
    double x0, y0, cell;
    int32_t across, down;
    size_t *begin;
    uint32_t *entry;
    /* relations */
    relation *relation;
    size_t n_relations, room;
    uint64_t work;    /* pairs looked at */
    uint32_t *mark;   /* of each facet: 1 + the last one that it was compared with */
    int32_t *through; /* of each facet: another one whose plane cuts it; NONE */
    /* components, in the order of painting */
    uint32_t *order, *component;
} ordering;

/* Cells ----------------------------------------------------------------------------------------------------------- */

static int32_t cell_at(double v, double from, double cell, int32_t n)
{
    const double i = floor((v - from) / cell);
    return i < 0 ? 0 : i >= n ? n - 1 : (int32_t)i;
}

/* Cells of a row that a facet may touch: [*left, *right]. */
static bool cells_of_row(int32_t *left, int32_t *right, const ordering *o, const vvi_gfx_facet *f, int32_t row)
{
    const double top = o->y0 + row * o->cell, bottom = top + o->cell;
    double x0 = INFINITY, x1 = -INFINITY;
    for (size_t k = 0; k < f->n; k++) {
        const vvi_gfx_spot a = f->spot[k], b = f->spot[k + 1 < f->n ? k + 1 : 0];
        if ((a.y < top && b.y < top) || (a.y > bottom && b.y > bottom))
            continue;
        const double step = b.y - a.y;
        const double t0 = step != 0 ? (top - a.y) / step : 0, t1 = step != 0 ? (bottom - a.y) / step : 1;
        const double from = fmin(1, fmax(0, fmin(t0, t1))), to = fmin(1, fmax(0, fmax(t0, t1)));
        const double p = a.x + from * (b.x - a.x), q = a.x + to * (b.x - a.x);
        x0 = fmin(x0, fmin(p, q));
        x1 = fmax(x1, fmax(p, q));
    }
    *left = cell_at(x0, o->x0, o->cell, o->across);
    *right = cell_at(x1, o->x0, o->cell, o->across);
    return x0 <= x1;
}

static void rows_of(int32_t *first, int32_t *last, const ordering *o, const vvi_gfx_facet *f)
{
    *first = cell_at(f->low[1], o->y0, o->cell, o->down);
    *last = cell_at(f->high[1], o->y0, o->cell, o->down);
}

static void count_or_fill(ordering *o, bool fill)
{
    for (size_t i = 0; i < o->n; i++) {
        int32_t first, last, left, right;
        rows_of(&first, &last, o, &o->facet[i]);
        for (int32_t y = first; y <= last; y++) {
            if (!cells_of_row(&left, &right, o, &o->facet[i], y))
                continue;
            for (int32_t x = left; x <= right; x++) {
                size_t *at = &o->begin[(size_t)y * (size_t)o->across + (size_t)x + (fill ? 0 : 1)];
                if (fill)
                    o->entry[*at] = (uint32_t)i;
                ++*at;
            }
        }
    }
}

/* Cells are as large as facets are in the mean. */
static void lay_cells(ordering *o)
{
    double x1 = -INFINITY, y1 = -INFINITY;
    o->x0 = o->y0 = INFINITY;
    for (size_t i = 0; i < o->n; i++) {
        o->x0 = fmin(o->x0, o->facet[i].low[0]), o->y0 = fmin(o->y0, o->facet[i].low[1]);
        x1 = fmax(x1, o->facet[i].high[0]), y1 = fmax(y1, o->facet[i].high[1]);
    }
    o->cell = fmax(2, sqrt((x1 - o->x0) * (y1 - o->y0) / (double)o->n));
    o->across = (int32_t)fmin(8192, 1 + (x1 - o->x0) / o->cell);
    o->down = (int32_t)fmin(8192, 1 + (y1 - o->y0) / o->cell);
}

static vv_status sort_into_cells(ordering *o)
{
    lay_cells(o);
    const size_t n = (size_t)o->across * (size_t)o->down;
    o->begin = vvi_alloc_zeroed(o->job, (n + 2) * sizeof *o->begin, VVI_MEM_SCRATCH);
    if (!o->begin)
        return vv_fail_memory((n + 2) * sizeof *o->begin);
    count_or_fill(o, false);
    for (size_t i = 0; i < n; i++)
        o->begin[i + 1] += o->begin[i];
    const size_t all = o->begin[n];
    o->entry = vvi_alloc(o->job, (all + 1) * sizeof *o->entry, VVI_MEM_SCRATCH);
    if (!o->entry)
        return vv_fail_memory((all + 1) * sizeof *o->entry);
    count_or_fill(o, true);
    memmove(o->begin + 1, o->begin, n * sizeof *o->begin); /* filling has moved each to its end */
    o->begin[0] = 0;
    return VV_OK;
}

/* Relations ------------------------------------------------------------------------------------------------------- */

static vv_status relate(ordering *o, size_t over, size_t under)
{
    if (o->n_relations == o->room) {
        const size_t room = o->room ? 2 * o->room : 4096;
        relation *more = vvi_realloc(o->job, o->relation, room * sizeof *more, VVI_MEM_SCRATCH);
        if (!more)
            return vv_fail_memory(room * sizeof *more);
        o->relation = more;
        o->room = room;
    }
    o->relation[o->n_relations++] = (relation){(uint32_t)over, (uint32_t)under};
    return VV_OK;
}

static double area_of(const vvi_gfx_facet *f)
{
    return vvi_gfx_facet_area(f->spot, f->n);
}

static vv_status compare(ordering *o, size_t i, size_t j)
{
    double before, behind;
    if (!vvi_gfx_facet_compare(&before, &behind, &o->facet[i], &o->facet[j], o->tolerance) ||
        fmax(before, behind) < OVERLAP)
        return VV_OK;
    if (fmin(before, behind) > THROUGH) {
        const bool first = area_of(&o->facet[i]) <= area_of(&o->facet[j]); /* others may go through the larger one */
        o->through[first ? i : j] = (int32_t)(first ? j : i);
    }
    return before > behind ? relate(o, i, j) : relate(o, j, i);
}

static vv_status compare_with_all(ordering *o, size_t i)
{
    int32_t first, last, left, right;
    vv_status st = VV_OK;
    rows_of(&first, &last, o, &o->facet[i]);
    for (int32_t y = first; y <= last; y++) {
        if (!cells_of_row(&left, &right, o, &o->facet[i], y))
            continue;
        for (int32_t x = left; x <= right; x++) {
            const size_t cell = (size_t)y * (size_t)o->across + (size_t)x;
            for (size_t e = o->begin[cell + 1]; e-- > o->begin[cell] && o->entry[e] > i && st == VV_OK;) {
                const size_t j = o->entry[e];
                o->work++;
                if (o->mark[j] == i + 1)
                    continue;
                o->mark[j] = (uint32_t)i + 1;
                st = compare(o, i, j);
            }
        }
    }
    return st;
}

static vv_status find_relations(ordering *o)
{
    vv_status st = sort_into_cells(o);
    for (size_t i = 0; i < o->n; i++)
        o->through[i] = NONE;
    for (size_t i = 0; i < o->n && st == VV_OK; i++) {
        st = compare_with_all(o, i);
        if (st == VV_OK && i % 64 == 0)
            st = vvi_job_poll(o->job);
    }
    return st;
}

/* Components ------------------------------------------------------------------------------------------------------ */

typedef struct walk {
    uint32_t *begin, *under; /* what each is over */
    uint32_t *number, *low, *next, *path, *stack;
    uint32_t *memory;
} walk;

static vv_status open_walk(walk *w, const ordering *o)
{
    const size_t n = o->n, all = 6 * (n + 2) + o->n_relations;
    *w = (walk){.memory = vvi_alloc_zeroed(o->job, all * sizeof *w->memory, VVI_MEM_SCRATCH)};
    if (!w->memory)
        return vv_fail_memory(all * sizeof *w->memory);
    uint32_t **const arrays[] = {&w->begin, &w->number, &w->low, &w->next, &w->path, &w->stack};
    for (size_t k = 0; k < sizeof arrays / sizeof *arrays; k++)
        *arrays[k] = w->memory + k * (n + 2);
    w->under = w->memory + 6 * (n + 2);
    for (size_t e = 0; e < o->n_relations; e++)
        w->begin[o->relation[e].over + 1]++;
    for (size_t i = 0; i < n; i++)
        w->begin[i + 1] += w->begin[i];
    memcpy(w->next, w->begin, n * sizeof *w->next);
    for (size_t e = 0; e < o->n_relations; e++)
        w->under[w->next[o->relation[e].over]++] = o->relation[e].under;
    memcpy(w->next, w->begin, n * sizeof *w->next);
    return VV_OK;
}

/* Components come with what is under them first. Numbers count from 1; those of finished ones are above all. */
static void find_components(ordering *o, walk *w)
{
    uint32_t count = 0, n_components = 0;
    size_t done = 0, n_stack = 0;
    for (size_t root = 0; root < o->n; root++) {
        size_t depth = 0;
        if (w->number[root])
            continue;
        w->path[depth++] = (uint32_t)root;
        while (depth) {
            const uint32_t v = w->path[depth - 1];
            if (!w->number[v]) {
                w->number[v] = w->low[v] = ++count;
                w->stack[n_stack++] = v;
            }
            if (w->next[v] < w->begin[v + 1]) {
                const uint32_t u = w->under[w->next[v]++];
                if (!w->number[u])
                    w->path[depth++] = u;
                else if (w->low[u] != UINT32_MAX && w->number[u] < w->low[v])
                    w->low[v] = w->number[u];
                continue;
            }
            depth--;
            if (depth && w->low[v] < w->low[w->path[depth - 1]])
                w->low[w->path[depth - 1]] = w->low[v];
            if (w->low[v] != w->number[v])
                continue;
            for (uint32_t u = UINT32_MAX; u != v;) {
                u = w->stack[--n_stack];
                w->low[u] = UINT32_MAX;
                o->component[u] = n_components;
                o->order[done++] = u;
            }
            n_components++;
        }
    }
}

/* Cutting --------------------------------------------------------------------------------------------------------- */

static bool cut_by_plane(vvi_gfx_facet *a, vvi_gfx_facet *b, const vvi_gfx_facet *f, const vvi_gfx_facet *other)
{
    double at[VVI_GFX_FACET_CORNERS];
    for (size_t i = 0; i < f->n; i++)
        at[i] = f->spot[i].near - vvi_gfx_facet_near(other, f->spot[i].x, f->spot[i].y);
    return vvi_gfx_facet_cut(a, b, f, at);
}

/* How many of a circle lie on both sides of the plane of one of them. */
static size_t count_cut(const ordering *o, size_t first, size_t n, const vvi_gfx_facet *plane)
{
    size_t count = 0;
    for (size_t i = first; i < first + n; i++) {
        vvi_gfx_facet a, b;
        count += &o->facet[o->order[i]] != plane && cut_by_plane(&a, &b, &o->facet[o->order[i]], plane);
    }
    return count;
}

/* Of a circle, o->order[first .. first + n - 1], one is chosen whose plane cuts all others: what is left of them before
 * it cannot be under what is left behind it (Fuchs, Kedem & Naylor 1980), and it is in no circle with either. */
static void open_circle(const ordering *o, size_t first, size_t n)
{
    enum { TRIED = 16 };
    size_t least = SIZE_MAX, best = first;
    for (size_t k = 0; k < TRIED && k < n; k++) {
        const size_t i = first + (n < TRIED ? k : k * (n / TRIED)),
                     count = count_cut(o, first, n, &o->facet[o->order[i]]);
        if (count && count < least) {
            least = count;
            best = i;
        }
    }
    for (size_t i = first; i < first + n; i++)
        if (i != best)
            o->through[o->order[i]] = (int32_t)o->order[best];
}

static int by_number(const void *a, const void *b)
{
    const uint32_t x = *(const uint32_t *)a, y = *(const uint32_t *)b;
    return (x > y) - (x < y);
}

/* Sorts the members of circles by depth, which is that of their numbers, and says how they are to be cut. */
static size_t open_circles(const ordering *o)
{
    size_t circles = 0;
    for (size_t i = 0, n; i < o->n; i += n) {
        for (n = 1; i + n < o->n && o->component[o->order[i + n]] == o->component[o->order[i]]; n++)
            ;
        if (n == 1)
            continue;
        bool crossed = false; /* then its crossings are cut first, which may be enough */
        for (size_t k = i; k < i + n; k++)
            crossed |= o->through[o->order[k]] != NONE;
        qsort(o->order + i, n, sizeof *o->order, by_number);
        if (!crossed)
            open_circle(o, i, n);
        circles++;
    }
    return circles;
}

/* *cut_out: how many were cut; *left_out: whether circles or crossings are left. */
static vv_status cut(size_t *cut_out, bool *left_out, vvi_gfx_facets *all, const ordering *o, size_t most)
{
    size_t wanted = 0;
    *cut_out = 0;
    *left_out = open_circles(o) > 0;
    for (size_t i = 0; i < o->n; i++)
        wanted += o->through[i] != NONE;
    *left_out |= wanted > 0;
    const vv_status st = vvi_gfx_facets_grow(all, wanted, o->job);
    for (size_t i = 0; i < o->n && st == VV_OK && all->n < most; i++) {
        vvi_gfx_facet a, b;
        if (o->through[i] == NONE || !cut_by_plane(&a, &b, &all->facet[i], &all->facet[o->through[i]]))
            continue;
        all->facet[i] = a;
        all->facet[all->n++] = b;
        ++*cut_out;
    }
    return st;
}

/* Rounds ---------------------------------------------------------------------------------------------------------- */

static double middle_of(const vvi_gfx_facet *f)
{
    return vvi_gfx_facet_middle(f).near;
}

/* By depth, so that what has no relation is furthest first; then by all that tells facets apart. */
static int by_depth(const void *a, const void *b)
{
    const vvi_gfx_facet *x = a, *y = b;
    const double u = middle_of(x), v = middle_of(y);
    if (u != v)
        return u < v ? -1 : 1;
    if (x->draw->state.id != y->draw->state.id)
        return x->draw->state.id < y->draw->state.id ? -1 : 1;
    if (x->triangle != y->triangle)
        return x->triangle < y->triangle ? -1 : 1;
    if (x->low[0] != y->low[0])
        return x->low[0] < y->low[0] ? -1 : 1;
    return (x->low[1] > y->low[1]) - (x->low[1] < y->low[1]);
}

/* Rounding of single precision, in which vertices are, as nearness. */
static double tolerance_of(const vvi_gfx_facets *all)
{
    double most = 0;
    for (size_t i = 0; i < all->n; i++)
        for (size_t k = 0; k < all->facet[i].n; k++)
            most = fmax(most, fabs(all->facet[i].spot[k].near));
    return 1e-6 * most;
}

static void close_ordering(ordering *o)
{
    vvi_free(o->begin);
    vvi_free(o->entry);
    vvi_free(o->relation);
    vvi_free(o->mark);
}

static vv_status open_ordering(ordering *o, vvi_gfx_facets *all, vv_job *job)
{
    const size_t n = all->n + 1;
    qsort(all->facet, all->n, sizeof *all->facet, by_depth);
    *o = (ordering){.facet = all->facet, .n = all->n, .job = job, .tolerance = tolerance_of(all)};
    o->mark = vvi_alloc_zeroed(job, 4 * n * sizeof *o->mark, VVI_MEM_SCRATCH);
    if (!o->mark)
        return vv_fail_memory(4 * n * sizeof *o->mark);
    o->through = (int32_t *)(o->mark + n);
    o->order = o->mark + 2 * n;
    o->component = o->mark + 3 * n;
    return VV_OK;
}

static vv_status find_order(ordering *o)
{
    walk w;
    vv_status st = find_relations(o);
    if (st != VV_OK || (st = open_walk(&w, o)) != VV_OK)
        return st;
    find_components(o, &w);
    vvi_free(w.memory);
    return VV_OK;
}

static vv_status put_in_order(vvi_gfx_facets *all, const ordering *o)
{
    const size_t bytes = o->n * sizeof *all->facet;
    vvi_gfx_facet *sorted = vvi_alloc(o->job, bytes, VVI_MEM_SCRATCH);
    if (!sorted)
        return vv_fail_memory(bytes);
    for (size_t i = 0; i < o->n; i++)
        sorted[i] = all->facet[o->order[i]];
    vvi_free(all->facet);
    all->facet = sorted;
    all->room = o->n;
    return VV_OK;
}

vv_status vvi_gfx_facets_order(bool *whole_out, vvi_gfx_facets *all, size_t most, vv_job *job)
{
    vv_status st = VV_OK;
    uint64_t work = 0;
    *whole_out = true;
    for (int round = 0; st == VV_OK && all->n; round++) {
        ordering o;
        size_t n_cut = 0;
        bool left = false;
        if ((st = open_ordering(&o, all, job)) == VV_OK && (st = find_order(&o)) == VV_OK) {
            work += o.work;
            st = cut(&n_cut, &left, all, &o, round < ROUNDS && work < WORK_MOST ? most : 0);
        }
        if (st == VV_OK && !n_cut) {
            *whole_out = !left;
            st = put_in_order(all, &o);
        }
        close_ordering(&o);
        if (!n_cut)
            break;
    }
    return st;
}
