/* Tiny edges collapse one after another. Each vertex has the list of its corners, joined when vertices are. */
#include "surface/weld.h"
#include "core/job.h"
#include "core/memory.h"

#include <math.h>

#define NONE UINT32_MAX
enum { BLOCK = 1 << 16, MOST_PASSES = 8 };

typedef struct weld {
    vvi_weld *mesh;
    double square;          /* of the length from which edges stay */
    uint32_t *first, *last; /* n_vertices: of the corners of each vertex */
    uint32_t *next;         /* n_indices */
    uint32_t *stamp;        /* n_vertices: the collapse in which a vertex was met last */
    uint8_t *times;         /* n_vertices: triangles at the edge to it, in that collapse */
    uint32_t now;
} weld;

/* What is around an edge between two vertices. */
typedef struct around {
    uint32_t opposite[2];
    int n_opposite;
    size_t n_keep, n_go; /* triangles of each vertex */
    bool keep_open, go_open, crowded;
} around;

static double square_between(const float *p, uint32_t a, uint32_t b)
{
    double sum = 0;
    for (size_t i = 0; i < 3; i++) {
        const double d = (double)p[3 * (size_t)a + i] - (double)p[3 * (size_t)b + i];
        sum += d * d;
    }
    return sum;
}

double vvi_tiny_edge(const vvi_weld *m)
{
    const double of_edges = 1e-4, of_coordinates = 2 * 1.2e-7;
    double sum = 0, largest = 0;
    for (size_t i = 0; i < m->n_indices; i++)
        sum += square_between(m->positions, m->indices[i], m->indices[i % 3 == 2 ? i - 2 : i + 1]);
    for (size_t i = 0; i < 3 * m->n_vertices; i++)
        largest = fmax(largest, fabs((double)m->positions[i]));
    const double mean = m->n_indices ? sqrt(sum / (double)m->n_indices) : 0;
    return fmin(fmax(of_edges * mean, of_coordinates * largest), mean / 100);
}

static bool is_gone(const weld *w, size_t triangle)
{
    return w->mesh->indices[3 * triangle] == NONE;
}

static void drop(weld *w, size_t triangle)
{
    for (size_t i = 0; i < 3; i++)
        w->mesh->indices[3 * triangle + i] = NONE;
}

/* The other two vertices of a corner's triangle. */
static void others_of(uint32_t out[2], const weld *w, uint32_t corner)
{
    const uint32_t *t = w->mesh->indices + corner - corner % 3;
    out[0] = t[(corner % 3 + 1) % 3];
    out[1] = t[(corner % 3 + 2) % 3];
}

static bool is_live(const weld *w, uint32_t corner)
{
    return !is_gone(w, corner / 3);
}

/* Counts the triangles at each edge of a vertex. */
static void count_ring(weld *w, uint32_t vertex)
{
    w->now++;
    for (uint32_t c = w->first[vertex]; c != NONE; c = w->next[c]) {
        uint32_t o[2];
        if (!is_live(w, c))
            continue;
        others_of(o, w, c);
        for (int i = 0; i < 2; i++) {
            if (w->stamp[o[i]] != w->now)
                w->times[o[i]] = 0;
            w->stamp[o[i]] = w->now;
            w->times[o[i]] = (uint8_t)(w->times[o[i]] < 3 ? w->times[o[i]] + 1 : 3);
        }
    }
}

static void look_at_ring(bool *open, bool *crowded, size_t *n, const weld *w, uint32_t vertex)
{
    for (uint32_t c = w->first[vertex]; c != NONE; c = w->next[c]) {
        uint32_t o[2];
        if (!is_live(w, c))
            continue;
        others_of(o, w, c);
        ++*n;
        for (int i = 0; i < 2; i++) {
            *open |= w->times[o[i]] == 1;
            *crowded |= w->times[o[i]] > 2;
        }
    }
}

/* The ring of `keep` was counted last when this returns. */
static around look_around(weld *w, uint32_t keep, uint32_t go)
{
    around a = {.n_opposite = 0};
    count_ring(w, go);
    look_at_ring(&a.go_open, &a.crowded, &a.n_go, w, go);
    count_ring(w, keep);
    look_at_ring(&a.keep_open, &a.crowded, &a.n_keep, w, keep);
    for (uint32_t c = w->first[go]; c != NONE && !a.crowded; c = w->next[c]) {
        uint32_t o[2];
        if (!is_live(w, c))
            continue;
        others_of(o, w, c);
        if (o[0] != keep && o[1] != keep)
            continue;
        if (a.n_opposite == 2)
            a.crowded = true;
        else
            a.opposite[a.n_opposite++] = o[0] == keep ? o[1] : o[0];
    }
    return a;
}

/* Vertices beside both, other than the opposite ones. Their counts are those of the ring of `keep`. */
static bool have_others_in_common(const weld *w, uint32_t keep, uint32_t go, const around *a)
{
    for (uint32_t c = w->first[go]; c != NONE; c = w->next[c]) {
        uint32_t o[2];
        if (!is_live(w, c))
            continue;
        others_of(o, w, c);
        for (int i = 0; i < 2; i++) {
            const bool own = o[i] == keep || o[i] == a->opposite[0] || (a->n_opposite == 2 && o[i] == a->opposite[1]);
            if (!own && w->stamp[o[i]] == w->now)
                return true;
        }
    }
    return false;
}

/* The triangle of a vertex with two others; NONE. */
static uint32_t triangle_with(const weld *w, uint32_t vertex, const uint32_t with[2])
{
    for (uint32_t c = w->first[vertex]; c != NONE; c = w->next[c]) {
        uint32_t o[2];
        if (!is_live(w, c))
            continue;
        others_of(o, w, c);
        if ((o[0] == with[0] && o[1] == with[1]) || (o[0] == with[1] && o[1] == with[0]))
            return c / 3;
    }
    return NONE;
}

static bool is_tiny(const weld *w, uint32_t a, uint32_t b)
{
    return square_between(w->mesh->positions, a, b) < w->square;
}

/* A tetrahedron goes as a whole when it is tiny; else its edges stay. */
static bool is_tetrahedron(weld *w, uint32_t keep, uint32_t go, const around *a, bool *dropped)
{
    const uint32_t *o = a->opposite;
    if (a->n_opposite != 2)
        return false;
    const uint32_t one = triangle_with(w, keep, o), two = triangle_with(w, go, o);
    if (one == NONE || two == NONE)
        return false;
    *dropped = a->n_keep == 3 && a->n_go == 3 && is_tiny(w, keep, o[0]) && is_tiny(w, keep, o[1]) &&
               is_tiny(w, o[0], o[1]) && !(a->keep_open || a->go_open);
    if (*dropped) {
        for (uint32_t c = w->first[keep]; c != NONE; c = w->next[c])
            drop(w, c / 3);
        drop(w, two);
    }
    return true;
}

static void join(weld *w, uint32_t keep, uint32_t go)
{
    for (uint32_t c = w->first[go]; c != NONE; c = w->next[c]) {
        uint32_t o[2];
        if (!is_live(w, c))
            continue;
        others_of(o, w, c);
        if (o[0] == keep || o[1] == keep)
            drop(w, c / 3);
        else
            w->mesh->indices[c] = keep;
    }
    w->next[w->last[keep]] = w->first[go];
    w->last[keep] = w->last[go];
    w->first[go] = NONE;
}

/* Whether it was possible. */
static bool collapse(weld *w, uint32_t keep, uint32_t go)
{
    const around a = look_around(w, keep, go);
    bool dropped = false;
    if (a.crowded || a.n_opposite == 0 || (a.n_opposite == 2 && a.opposite[0] == a.opposite[1]))
        return false;
    if (a.go_open && (w->mesh->fix_border || (a.keep_open && a.n_opposite == 2)))
        return false;
    if (a.go_open && !a.keep_open) /* the border does not move inwards: it is the other way round that this goes */
        return false;
    if (have_others_in_common(w, keep, go, &a))
        return false;
    if (is_tetrahedron(w, keep, go, &a, &dropped))
        return dropped;
    join(w, keep, go);
    return true;
}

static size_t weld_triangle(weld *w, size_t triangle)
{
    const uint32_t *t = w->mesh->indices + 3 * triangle;
    for (size_t i = 0; i < 3 && !is_gone(w, triangle); i++) {
        const uint32_t a = t[i], b = t[(i + 1) % 3], low = a < b ? a : b, high = a < b ? b : a;
        if (is_tiny(w, a, b) && (collapse(w, low, high) || collapse(w, high, low)))
            return 1;
    }
    return 0;
}

static vv_status weld_all(weld *w, vv_job *job)
{
    const size_t n = w->mesh->n_indices / 3;
    size_t n_done = 1;
    for (int pass = 0; pass < MOST_PASSES && n_done; pass++) {
        n_done = 0;
        for (size_t t = 0; t < n; t++) {
            if (t % BLOCK == 0 && vvi_job_poll(job) != VV_OK)
                return VV_E_CANCELLED;
            n_done += weld_triangle(w, t);
        }
    }
    return VV_OK;
}

/* Triangles that have a vertex twice go first: no list is ready for them. */
static void list_corners(weld *w)
{
    for (size_t v = 0; v < w->mesh->n_vertices; v++) {
        w->first[v] = NONE;
        w->last[v] = NONE;
        w->stamp[v] = 0;
    }
    for (size_t c = 0; c < w->mesh->n_indices; c++) {
        const uint32_t *t = w->mesh->indices + c - c % 3;
        if (c % 3 == 0 && (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]))
            drop(w, c / 3);
        if (is_gone(w, c / 3))
            continue;
        const uint32_t v = w->mesh->indices[c];
        w->next[c] = NONE;
        if (w->first[v] == NONE)
            w->first[v] = (uint32_t)c;
        else
            w->next[w->last[v]] = (uint32_t)c;
        w->last[v] = (uint32_t)c;
    }
}

static void close_ranks(vvi_weld *m)
{
    size_t n = 0;
    for (size_t c = 0; c < m->n_indices; c++)
        if (m->indices[c] != NONE)
            m->indices[n++] = m->indices[c];
    m->n_indices = n;
}

static bool has_tiny_edges(const weld *w)
{
    const vvi_weld *m = w->mesh;
    for (size_t i = 0; i < m->n_indices; i++)
        if (is_tiny(w, m->indices[i], m->indices[i % 3 == 2 ? i - 2 : i + 1]))
            return true;
    return false;
}

vv_status vvi_weld_edges(vvi_weld *mesh, double length, vv_job *job)
{
    weld w = {.mesh = mesh, .square = length * length};
    vv_status st = VV_OK;
    if (mesh->n_indices >= NONE || !has_tiny_edges(&w)) /* corners are numbered in 32 bits */
        return VV_OK;
    w.first = vvi_alloc(job, mesh->n_vertices * sizeof *w.first, VVI_MEM_SCRATCH);
    w.last = vvi_alloc(job, mesh->n_vertices * sizeof *w.last, VVI_MEM_SCRATCH);
    w.stamp = vvi_alloc(job, mesh->n_vertices * sizeof *w.stamp, VVI_MEM_SCRATCH);
    w.times = vvi_alloc(job, mesh->n_vertices * sizeof *w.times, VVI_MEM_SCRATCH);
    w.next = vvi_alloc(job, mesh->n_indices * sizeof *w.next, VVI_MEM_SCRATCH);
    if (!w.first || !w.last || !w.stamp || !w.times || !w.next)
        st = vv_fail_memory(mesh->n_indices * sizeof *w.next);
    if (st == VV_OK) {
        list_corners(&w);
        st = weld_all(&w, job);
        close_ranks(mesh);
    }
    vvi_free(w.first);
    vvi_free(w.last);
    vvi_free(w.stamp);
    vvi_free(w.times);
    vvi_free(w.next);
    return st;
}
