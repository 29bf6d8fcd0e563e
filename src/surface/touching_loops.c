#include "surface/touching_loops.h"
#include "core/memory.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define NONE UINT32_MAX

/* A side at a place, seen from there. */
typedef struct spoke {
    double x, y;
    bool out;        /* it begins here */
    uint32_t corner; /* whose side it is: one comes in and one goes out */
} spoke;

/* Corners are numbered as the loops have their points. */
typedef struct untangler {
    const vvi_loops *loops;
    vvi_untangled *to;
    size_t n; /* corners */
    double *at;
    uint32_t *after, *before; /* corners; NONE: gone */
    uint32_t *place;          /* of a corner: the first corner there */
    uint32_t *link;           /* of a corner's side that comes in: the corner whose side goes on */
    uint32_t *order;          /* corners, those of a place one after the other */
    spoke *spokes;            /* of one place */
    uint32_t *stack;
    double near; /* what is not farther apart is at one place */
    vv_job *job;
} untangler;

static uint32_t point_of(const untangler *u, uint32_t corner)
{
    return u->loops->points[corner];
}

static const double *place_of(const untangler *u, uint32_t corner)
{
    return u->at + 2 * (size_t)point_of(u, corner);
}

static void add_triangle(untangler *u, uint32_t a, uint32_t b, uint32_t c)
{
    uint32_t *t = u->to->triangles + 3 * u->to->n_triangles++;
    t[0] = point_of(u, a);
    t[1] = point_of(u, b);
    t[2] = point_of(u, c);
}

/* Places ---------------------------------------------------------------------------------------------------------- */

static int64_t cell_of(const untangler *u, double x)
{
    return (int64_t)fmin(fmax(x / u->near, -1e15), 1e15);
}

static size_t slot_of(int64_t i, int64_t j, size_t mask)
{
    uint64_t x = (uint64_t)i * 0x9e3779b97f4a7c15u + (uint64_t)j * 0xbf58476d1ce4e5b9u;
    x ^= x >> 31;
    x *= 0x94d049bb133111ebu;
    return (size_t)(x ^ x >> 29) & mask;
}

/* The corner that stands for a place near p, NONE: there is none yet. */
static uint32_t find_place(const untangler *u, const uint32_t *first, const uint32_t *next, size_t mask,
                           const double p[2])
{
    const int64_t i = cell_of(u, p[0]), j = cell_of(u, p[1]);
    for (int64_t k = 0; k < 9; k++)
        for (uint32_t c = first[slot_of(i + k % 3 - 1, j + k / 3 - 1, mask)]; c != NONE; c = next[c]) {
            const double *q = place_of(u, c);
            if (fabs(p[0] - q[0]) <= u->near && fabs(p[1] - q[1]) <= u->near)
                return c;
        }
    return NONE;
}

static void measure_near(untangler *u)
{
    double most = 0;
    for (size_t c = 0; c < u->n; c++)
        for (int a = 0; a < 2; a++)
            most = fmax(most, fabs(place_of(u, (uint32_t)c)[a]));
    u->near = most > 0 ? 8 * (double)FLT_EPSILON * most : 1;
}

static vv_status merge_places(untangler *u)
{
    size_t n_slots = 16;
    while (n_slots < 2 * u->n)
        n_slots *= 2;
    uint32_t *first = vvi_alloc(u->job, n_slots * sizeof *first, VVI_MEM_SCRATCH);
    uint32_t *next = vvi_alloc(u->job, (u->n + 1) * sizeof *next, VVI_MEM_SCRATCH);
    const vv_status st = first && next ? VV_OK : vv_fail_memory(n_slots * sizeof *first);
    measure_near(u);
    if (st == VV_OK)
        memset(first, 0xff, n_slots * sizeof *first);
    for (uint32_t c = 0; c < u->n && st == VV_OK; c++) {
        double *p = u->at + 2 * (size_t)point_of(u, c);
        const uint32_t found = find_place(u, first, next, n_slots - 1, p);
        u->place[c] = found == NONE ? c : found;
        if (found != NONE) {
            memcpy(p, place_of(u, found), 2 * sizeof *p);
            continue;
        }
        const size_t slot = slot_of(cell_of(u, p[0]), cell_of(u, p[1]), n_slots - 1);
        next[c] = first[slot];
        first[slot] = c;
    }
    vvi_free(first);
    vvi_free(next);
    return st;
}

/* Sides without length -------------------------------------------------------------------------------------------- */

static void link_loops(untangler *u)
{
    for (size_t l = 0; l < u->loops->n; l++) {
        const size_t begin = u->loops->begin[l], n = u->loops->begin[l + 1] - begin;
        for (size_t i = 0; i < n; i++) {
            u->before[begin + i] = (uint32_t)(begin + (i + n - 1) % n);
            u->after[begin + i] = (uint32_t)(begin + (i + 1) % n);
        }
    }
}

static void take_out(untangler *u, uint32_t corner)
{
    u->after[u->before[corner]] = u->after[corner];
    u->before[u->after[corner]] = u->before[corner];
    u->after[corner] = NONE;
}

/* Two sides that are left run there and back. */
static void drop_short_sides(untangler *u, size_t loop)
{
    const size_t begin = u->loops->begin[loop], n = u->loops->begin[loop + 1] - begin;
    size_t left = n;
    for (size_t i = 0; i < n && left > 2; i++) {
        const uint32_t c = (uint32_t)(begin + i), before = u->before[c], after = u->after[c];
        if (u->place[c] != u->place[after])
            continue;
        add_triangle(u, before, c, after);
        take_out(u, c);
        left--;
    }
    for (size_t i = 0; i < n && left <= 2; i++)
        u->after[begin + i] = NONE;
}

/* Sides that meet ------------------------------------------------------------------------------------------------- */

static bool is_lower(const spoke *s)
{
    return s->y < 0 || (s->y == 0 && s->x < 0);
}

/* To the left, from the direction of x on; where two lie upon each other, the solid is between them for no width: the
 * one that goes out is met first. */
static int by_direction(const void *a, const void *b)
{
    const spoke *s = a, *t = b;
    const double turn = s->x * t->y - s->y * t->x;
    if (is_lower(s) != is_lower(t))
        return is_lower(s) ? 1 : -1;
    if (turn != 0)
        return turn > 0 ? -1 : 1;
    if (s->out != t->out)
        return s->out ? -1 : 1;
    return s->corner < t->corner ? -1 : s->corner > t->corner;
}

static spoke spoke_to(const untangler *u, uint32_t corner, bool out)
{
    const double *p = place_of(u, corner), *q = place_of(u, out ? u->after[corner] : u->before[corner]);
    return (spoke){q[0] - p[0], q[1] - p[1], out, corner};
}

/* As brackets: the solid begins at a side that goes out and ends, further to the left, at one that comes in. */
static void link_place(untangler *u, const uint32_t *corners, size_t n)
{
    size_t n_spokes = 0, n_open = 0;
    for (size_t i = 0; i < n; i++) {
        u->spokes[n_spokes++] = spoke_to(u, corners[i], false);
        u->spokes[n_spokes++] = spoke_to(u, corners[i], true);
        u->link[corners[i]] = NONE;
    }
    qsort(u->spokes, n_spokes, sizeof *u->spokes, by_direction);
    for (int round = 0; round < 2; round++)
        for (size_t i = 0; i < n_spokes; i++) {
            const spoke *s = &u->spokes[i];
            if (s->out && round == 0)
                u->stack[n_open++] = s->corner;
            else if (!s->out && n_open && u->link[s->corner] == NONE)
                u->link[s->corner] = u->stack[--n_open];
        }
}

/* The corners that are left, by place. */
static vv_status sort_by_place(untangler *u, size_t *n_out)
{
    size_t *begin = vvi_alloc_zeroed(u->job, (u->n + 2) * sizeof *begin, VVI_MEM_SCRATCH);
    *n_out = 0;
    if (!begin)
        return vv_fail_memory((u->n + 2) * sizeof *begin);
    for (size_t c = 0; c < u->n; c++)
        if (u->after[c] != NONE) {
            begin[u->place[c] + 1]++;
            ++*n_out;
        }
    for (size_t c = 0; c < u->n; c++)
        begin[c + 1] += begin[c];
    for (uint32_t c = 0; c < u->n; c++)
        if (u->after[c] != NONE)
            u->order[begin[u->place[c]]++] = c;
    vvi_free(begin);
    return VV_OK;
}

static void link_places(untangler *u, size_t n)
{
    for (size_t i = 0, end; i < n; i = end) {
        for (end = i + 1; end < n && u->place[u->order[end]] == u->place[u->order[i]];)
            end++;
        link_place(u, u->order + i, end - i);
    }
}

/* Triangles that go round a place from point to point have these between them. */
static void fill_round(untangler *u, uint32_t first, bool *seen)
{
    uint32_t at = u->link[first];
    seen[first] = true;
    for (; at != first && u->link[at] != first; at = u->link[at]) {
        seen[at] = true;
        add_triangle(u, first, u->link[at], at);
    }
    seen[at] = true;
}

static vv_status join_sides(untangler *u, size_t n)
{
    bool *seen = vvi_alloc_zeroed(u->job, u->n + 1, VVI_MEM_SCRATCH);
    if (!seen)
        return vv_fail_memory(u->n + 1);
    for (size_t i = 0; i < n; i++)
        if (!seen[u->order[i]])
            fill_round(u, u->order[i], seen);
    for (size_t i = 0; i < n; i++) {
        const uint32_t c = u->order[i], at = u->after[c], on = u->link[at];
        if (on != at)
            add_triangle(u, c, at, on);
        u->before[c] = on; /* the corner that follows now */
    }
    vvi_free(seen);
    return VV_OK;
}

/* Two sides that are left run there and back. */
static void follow(untangler *u, size_t n)
{
    uint32_t *points = (uint32_t *)u->to->loops.points;
    size_t *begin = (size_t *)u->to->loops.begin, n_points = 0, n_loops = 0;
    for (size_t i = 0; i < n; i++) {
        const size_t first = n_points;
        for (uint32_t c = u->order[i], next; u->before[c] != NONE; c = next) {
            next = u->before[c];
            u->before[c] = NONE;
            points[n_points++] = point_of(u, c);
        }
        if (n_points - first < 3)
            n_points = first;
        else
            begin[n_loops++] = first;
    }
    begin[n_loops] = n_points;
    u->to->loops.n = n_loops;
}

/* All of it ------------------------------------------------------------------------------------------------------- */

static void *room(untangler *u, size_t n, size_t bytes, vv_status *st)
{
    void *memory = *st == VV_OK ? vvi_alloc(u->job, (n + 1) * bytes, VVI_MEM_SCRATCH) : NULL;
    if (*st == VV_OK && !memory)
        *st = vv_fail_memory((n + 1) * bytes);
    return memory;
}

static vv_status reserve(untangler *u)
{
    vv_status st = VV_OK;
    size_t n_points = 0;
    for (size_t c = 0; c < u->n; c++)
        n_points = point_of(u, (uint32_t)c) >= n_points ? (size_t)point_of(u, (uint32_t)c) + 1 : n_points;
    u->to->loops.at = u->at = room(u, n_points, 2 * sizeof *u->at, &st);
    u->to->loops.points = room(u, u->n, sizeof *u->to->loops.points, &st);
    u->to->loops.begin = room(u, u->n, sizeof *u->to->loops.begin, &st);
    u->to->triangles = room(u, 3 * u->n, 3 * sizeof *u->to->triangles, &st);
    u->after = room(u, u->n, sizeof *u->after, &st);
    u->before = room(u, u->n, sizeof *u->before, &st);
    u->place = room(u, u->n, sizeof *u->place, &st);
    u->link = room(u, u->n, sizeof *u->link, &st);
    u->order = room(u, u->n, sizeof *u->order, &st);
    u->stack = room(u, u->n, sizeof *u->stack, &st);
    u->spokes = room(u, 2 * u->n, sizeof *u->spokes, &st);
    for (size_t c = 0; c < u->n && st == VV_OK; c++)
        memcpy(u->at + 2 * (size_t)point_of(u, (uint32_t)c), u->loops->at + 2 * (size_t)point_of(u, (uint32_t)c),
               2 * sizeof *u->at);
    return st;
}

vv_status vvi_untangle(vvi_untangled *out, const vvi_loops *loops, vv_job *job)
{
    untangler u = {.loops = loops, .to = out, .n = loops->begin[loops->n], .job = job};
    size_t n = 0;
    *out = (vvi_untangled){0};
    vv_status st = reserve(&u);
    if (st == VV_OK && (st = merge_places(&u)) == VV_OK) {
        link_loops(&u);
        for (size_t i = 0; i < loops->n; i++)
            drop_short_sides(&u, i);
        st = sort_by_place(&u, &n);
    }
    if (st == VV_OK) {
        link_places(&u, n);
        st = join_sides(&u, n);
    }
    if (st == VV_OK)
        follow(&u, n);
    else
        vvi_untangled_finish(out);
    vvi_free(u.after);
    vvi_free(u.before);
    vvi_free(u.place);
    vvi_free(u.link);
    vvi_free(u.order);
    vvi_free(u.stack);
    vvi_free(u.spokes);
    return st;
}

void vvi_untangled_finish(vvi_untangled *untangled)
{
    vvi_free((double *)untangled->loops.at);
    vvi_free((uint32_t *)untangled->loops.points);
    vvi_free((size_t *)untangled->loops.begin);
    vvi_free(untangled->triangles);
    *untangled = (vvi_untangled){0};
}
