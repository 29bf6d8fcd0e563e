/* Edges lie in the room of their lower vertex, sorted by the other one: triangles at an edge follow one another. A
 * corner of a triangle stands for the edge that begins there. Corners around a vertex that edges of two triangles join
 * are sets of a forest. */
#include "surface/self_contacts.h"
#include "core/job.h"
#include "core/memory.h"

#include <math.h>
#include <stdlib.h>

#define NONE UINT32_MAX
enum { BLOCK = 1 << 16, MOST_ROUNDS = 24, MOST_AROUND = 64 };

typedef struct edge {
    uint32_t other, corner;
} edge;

typedef struct cutter {
    vvi_cut *mesh;
    vv_job *job;
    size_t room;     /* of copied */
    size_t *begin;   /* n_vertices + n_copies + 1: rooms */
    uint8_t *turned; /* n_vertices + n_copies: an edge of the vertex is paired the other way round in this round */
    edge *edges;     /* n_indices */
    uint32_t *set;   /* n_indices: a corner of the same fan that is not later */
    uint32_t *first; /* n_vertices + n_copies: the fan that keeps the vertex */
    int round;
} cutter;

/* A triangle at a crowded edge. */
typedef struct leaf {
    double angle;
    uint32_t corner;
    bool up; /* it runs from the lower vertex to the higher one */
} leaf;

static size_t n_vertices(const cutter *c)
{
    return c->mesh->n_vertices + c->mesh->n_copies;
}

static uint32_t after(uint32_t corner)
{
    return corner % 3 == 2 ? corner - 2 : corner + 1;
}

static const float *place(const cutter *c, uint32_t vertex)
{
    const size_t n = c->mesh->n_vertices;
    return c->mesh->positions + 3 * (size_t)(vertex < n ? vertex : c->mesh->copied[vertex - n]);
}

/* Edges ----------------------------------------------------------------------------------------------------------- */

static int by_other(const void *a, const void *b)
{
    const edge *x = a, *y = b;
    return x->other != y->other ? (x->other > y->other) - (x->other < y->other)
                                : (x->corner > y->corner) - (x->corner < y->corner);
}

/* Most vertices have a few edges. */
static void sort_room(edge *e, size_t n)
{
    enum { FEW = 24 };
    if (n > FEW)
        qsort(e, n, sizeof *e, by_other);
    for (size_t i = 1; i < n && n <= FEW; i++) {
        const edge now = e[i];
        size_t to = i;
        for (; to > 0 && by_other(&e[to - 1], &now) > 0; to--)
            e[to] = e[to - 1];
        e[to] = now;
    }
}

static vv_status sort_edges(cutter *c)
{
    const uint32_t *v = c->mesh->indices;
    const size_t n = n_vertices(c);
    vvi_free(c->begin);
    vvi_free(c->turned);
    c->begin = vvi_alloc_zeroed(c->job, (n + 2) * sizeof *c->begin, VVI_MEM_SCRATCH);
    c->turned = vvi_alloc_zeroed(c->job, n + 1, VVI_MEM_SCRATCH);
    if (!c->begin || !c->turned)
        return vv_fail_memory((n + 2) * sizeof *c->begin);
    size_t *at = c->begin + 1; /* becomes the ends of the rooms, which are where the next begin */
    for (uint32_t k = 0; k < c->mesh->n_indices; k++) {
        const uint32_t a = v[k], b = v[after(k)];
        at[(a < b ? a : b) + 1]++;
    }
    for (size_t i = 0; i < n; i++)
        at[i + 1] += at[i];
    for (uint32_t k = 0; k < c->mesh->n_indices; k++) {
        const uint32_t a = v[k], b = v[after(k)];
        c->edges[at[a < b ? a : b]++] = (edge){a < b ? b : a, k};
    }
    for (size_t i = 0; i < n; i++) {
        if (i % BLOCK == 0 && vvi_job_poll(c->job) != VV_OK)
            return VV_E_CANCELLED;
        sort_room(c->edges + c->begin[i], c->begin[i + 1] - c->begin[i]);
    }
    return VV_OK;
}

/* How many triangles there are at the edge that begins with this one. */
static size_t count_around(const edge *e, const edge *end)
{
    size_t n = 1;
    while (e + n < end && e[n].other == e->other)
        n++;
    return n;
}

static bool is_up(const cutter *c, uint32_t corner)
{
    return c->mesh->indices[corner] < c->mesh->indices[after(corner)];
}

/* The vertex of the edge's triangle that is not at the edge. */
static uint32_t apex(const cutter *c, uint32_t corner)
{
    return c->mesh->indices[after(after(corner))];
}

/* Back to back ---------------------------------------------------------------------------------------------------- */

static bool is_gone(const cutter *c, uint32_t corner)
{
    return c->mesh->indices[corner - corner % 3] == NONE;
}

static void drop(const cutter *c, uint32_t corner)
{
    for (size_t i = 0; i < 3; i++)
        c->mesh->indices[corner - corner % 3 + i] = NONE;
}

static size_t drop_backs_at(const cutter *c, const edge *e, size_t n)
{
    size_t n_dropped = 0;
    for (size_t i = 0; i < n; i++)
        for (size_t j = i + 1; j < n; j++) {
            const uint32_t a = e[i].corner, b = e[j].corner;
            if (is_gone(c, a) || is_gone(c, b) || apex(c, a) != apex(c, b) || is_up(c, a) == is_up(c, b))
                continue;
            drop(c, a);
            drop(c, b);
            n_dropped += 2;
        }
    return n_dropped;
}

static bool drop_backs(cutter *c)
{
    vvi_cut *m = c->mesh;
    size_t n_dropped = 0, n = 0;
    for (size_t v = 0; v < n_vertices(c); v++) {
        const edge *e = c->edges + c->begin[v], *end = c->edges + c->begin[v + 1];
        for (size_t around; e < end; e += around) {
            around = count_around(e, end);
            n_dropped += around > 1 ? drop_backs_at(c, e, around) : 0;
        }
    }
    for (size_t k = 0; k < m->n_indices && n_dropped; k++)
        if (m->indices[k] != NONE)
            m->indices[n++] = m->indices[k];
    m->n_indices = n_dropped ? n : m->n_indices;
    return n_dropped != 0;
}

/* Fans ------------------------------------------------------------------------------------------------------------ */

static uint32_t find(uint32_t *set, uint32_t corner)
{
    while (set[corner] != corner) {
        set[corner] = set[set[corner]];
        corner = set[corner];
    }
    return corner;
}

static void unite(uint32_t *set, uint32_t a, uint32_t b)
{
    a = find(set, a);
    b = find(set, b);
    set[a > b ? a : b] = a < b ? a : b;
}

/* Two triangles stay together at an edge. */
static void keep_together(const cutter *c, uint32_t a, uint32_t b)
{
    const bool same = is_up(c, a) == is_up(c, b);
    unite(c->set, a, same ? b : after(b));
    unite(c->set, after(a), same ? after(b) : b);
}

static void subtract(double out[3], const float *a, const float *b)
{
    for (int i = 0; i < 3; i++)
        out[i] = (double)a[i] - (double)b[i];
}

static void cross(double out[3], const double a[3], const double b[3])
{
    for (int i = 0; i < 3; i++)
        out[i] = a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3];
}

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static int by_angle(const void *a, const void *b)
{
    const leaf *x = a, *y = b;
    return x->angle != y->angle ? (x->angle > y->angle) - (x->angle < y->angle)
                                : (x->corner > y->corner) - (x->corner < y->corner);
}

/* In the order in which one meets them when one turns about the edge from its lower vertex to its higher one, to the
 * left. */
static void sort_leaves(leaf *leaves, const cutter *c, const edge *e, size_t n, uint32_t low)
{
    double axis[3], from[3], zero[3], quarter[3];
    subtract(axis, place(c, e->other), place(c, low));
    subtract(from, place(c, apex(c, e->corner)), place(c, low));
    cross(quarter, axis, from);
    cross(zero, quarter, axis);
    const double length = sqrt(dot(axis, axis));
    for (size_t i = 0; i < n; i++) {
        double to[3];
        subtract(to, place(c, apex(c, e[i].corner)), place(c, low));
        leaves[i] = (leaf){atan2(dot(to, quarter) * length, dot(to, zero)), e[i].corner, is_up(c, e[i].corner)};
    }
    qsort(leaves, n, sizeof *leaves, by_angle);
}

/* Takes two neighbours out of a ring: one that runs down, then one that runs up. Whether there were such. */
static bool take_pair(uint32_t pair[2], leaf *leaves, size_t *n)
{
    for (size_t i = 0; i < *n; i++) {
        const size_t j = (i + 1) % *n;
        size_t left = 0;
        if (leaves[i].up || !leaves[j].up)
            continue;
        pair[0] = leaves[i].corner;
        pair[1] = leaves[j].corner;
        for (size_t k = 0; k < *n; k++)
            if (k != i && k != j)
                leaves[left++] = leaves[k];
        *n = left;
        return true;
    }
    return false;
}

/* The solid lies to the left of a triangle that runs down and to the right of one that runs up: they stay together.
 * `turned`: the first two pairs change partners. */
static void pair_leaves(const cutter *c, leaf *leaves, size_t n, bool turned)
{
    uint32_t pair[MOST_AROUND / 2][2];
    size_t n_pairs = 0;
    while (take_pair(pair[n_pairs], leaves, &n))
        if (++n_pairs == MOST_AROUND / 2)
            break;
    for (size_t i = 0; i < n_pairs; i++)
        keep_together(c, pair[i][0], pair[turned && n_pairs > 1 && i < 2 ? 1 - i : i][1]);
}

/* Where a crowded edge is left after the first round, both pairs are in one fan at both of its vertices: paired the
 * other way round, those fans fall in two. That is sure for one edge of a vertex at a time. */
static bool turn(cutter *c, size_t low, uint32_t high)
{
    if (c->round == 0 || c->turned[low] || c->turned[high])
        return false;
    c->turned[low] = 1;
    c->turned[high] = 1;
    return true;
}

static size_t join_corners(cutter *c)
{
    size_t n_crowded = 0;
    for (uint32_t k = 0; k < c->mesh->n_indices; k++)
        c->set[k] = k;
    for (size_t v = 0; v < n_vertices(c); v++) {
        const edge *e = c->edges + c->begin[v], *end = c->edges + c->begin[v + 1];
        for (size_t n; e < end; e += n) {
            leaf leaves[MOST_AROUND];
            n = count_around(e, end);
            if (n == 2)
                keep_together(c, e[0].corner, e[1].corner);
            n_crowded += n > 2;
            if (n <= 2 || n > MOST_AROUND)
                continue;
            sort_leaves(leaves, c, e, n, (uint32_t)v);
            pair_leaves(c, leaves, n, turn(c, v, e->other));
        }
    }
    return n_crowded;
}

/* A vertex of its own. */
static vv_status copy_vertex(uint32_t *out, cutter *c, uint32_t vertex)
{
    vvi_cut *m = c->mesh;
    if (m->n_copies == c->room) {
        const size_t room = 2 * c->room + 64;
        uint32_t *more = vvi_realloc(c->job, m->copied, room * sizeof *more, VVI_MEM_SCRATCH);
        if (!more)
            return vv_fail_memory(room * sizeof *more);
        m->copied = more;
        c->room = room;
    }
    m->copied[m->n_copies] = vertex < m->n_vertices ? vertex : m->copied[vertex - m->n_vertices];
    *out = (uint32_t)(m->n_vertices + m->n_copies++);
    return VV_OK;
}

/* The first fan of a vertex keeps it. The earliest corner of a fan comes first, and tells the others its vertex. */
static vv_status share_out(cutter *c)
{
    vvi_cut *m = c->mesh;
    vv_status st = VV_OK;
    const size_t n = n_vertices(c);
    vvi_free(c->first);
    if (!(c->first = vvi_alloc(c->job, (n + 1) * sizeof *c->first, VVI_MEM_SCRATCH)))
        return vv_fail_memory((n + 1) * sizeof *c->first);
    for (size_t v = 0; v < n; v++)
        c->first[v] = NONE;
    for (uint32_t k = 0; k < m->n_indices && st == VV_OK; k++) {
        const uint32_t fan = find(c->set, k), v = m->indices[k];
        if (fan != k)
            m->indices[k] = m->indices[fan];
        else if (c->first[v] == NONE)
            c->first[v] = k;
        else
            st = copy_vertex(&m->indices[k], c, v);
    }
    return st;
}

static vv_status cut(cutter *c)
{
    vv_status st = sort_edges(c);
    while (st == VV_OK && drop_backs(c))
        st = sort_edges(c);
    for (bool more = true; st == VV_OK && more; c->round++) {
        c->mesh->n_crowded = join_corners(c);
        more = c->mesh->n_crowded && c->round < MOST_ROUNDS;
        if ((st = share_out(c)) == VV_OK && more)
            st = sort_edges(c);
    }
    return st;
}

vv_status vvi_cut_apart(vvi_cut *mesh, vv_job *job)
{
    cutter c = {.mesh = mesh, .job = job};
    const size_t n = mesh->n_indices;
    vv_status st = VV_OK;
    mesh->copied = NULL;
    mesh->n_copies = 0;
    mesh->n_crowded = 0;
    if (n == 0 || n >= NONE) /* corners are numbered in 32 bits */
        return VV_OK;
    c.edges = vvi_alloc(job, n * sizeof *c.edges, VVI_MEM_SCRATCH);
    c.set = vvi_alloc(job, n * sizeof *c.set, VVI_MEM_SCRATCH);
    if (!c.edges || !c.set)
        st = vv_fail_memory(n * sizeof *c.edges);
    if (st == VV_OK)
        st = cut(&c);
    vvi_free(c.begin);
    vvi_free(c.turned);
    vvi_free(c.edges);
    vvi_free(c.set);
    vvi_free(c.first);
    if (st != VV_OK) {
        vvi_free(mesh->copied);
        mesh->copied = NULL;
    }
    return st;
}
