#include "surface/fill.h"
#include "core/job.h"
#include "core/memory.h"
#include "surface/touching_loops.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define NONE UINT32_MAX

typedef struct point {
    double x, y;
} point;

/* A corner of a ring. Bridges give a point a second one. */
typedef struct corner {
    uint32_t point, before, after;
    bool gone;
} corner;

typedef struct ring {
    double area; /* twice, negative: a hole */
    point lo, hi;
    uint32_t first, left; /* corners; `left` is the leftmost */
    size_t n;
    uint32_t outline; /* of a hole: number of the ring around it */
} ring;

/* Corners by the cell of a grid that they lie in. */
typedef struct bins {
    point lo;
    double per_x, per_y;
    size_t nx, ny;
    uint32_t *begin, *corners;
} bins;

typedef struct filler {
    const vvi_loops *loops;
    corner *corners;
    size_t n_corners;
    ring *rings;
    uint32_t *holes; /* numbers of rings, by their leftmost x */
    size_t n_holes;
    bins bins;
    uint32_t *out;
    size_t n_out; /* triangles */
    vv_job *job;
} filler;

static point place(const filler *f, uint32_t c)
{
    const double *at = f->loops->at + 2 * (size_t)f->corners[c].point;
    return (point){at[0], at[1]};
}

static double turn(point a, point b, point c)
{
    return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

static bool is_same(point a, point b)
{
    return a.x == b.x && a.y == b.y;
}

/* Rings ----------------------------------------------------------------------------------------------------------- */

static uint32_t cut_off(filler *f, uint32_t c)
{
    corner *at = &f->corners[c];
    uint32_t *t = f->out + 3 * f->n_out++;
    t[0] = f->corners[at->before].point;
    t[1] = at->point;
    t[2] = f->corners[at->after].point;
    f->corners[at->before].after = at->after;
    f->corners[at->after].before = at->before;
    at->gone = true;
    return at->after;
}

static void link_ring(filler *f, size_t loop)
{
    ring *r = &f->rings[loop];
    const size_t begin = f->loops->begin[loop], n = f->loops->begin[loop + 1] - begin;
    *r = (ring){.first = (uint32_t)begin, .n = n, .outline = NONE};
    for (size_t i = 0; i < n; i++)
        f->corners[begin + i] = (corner){.point = f->loops->points[begin + i],
                                         .before = (uint32_t)(begin + (i + n - 1) % n),
                                         .after = (uint32_t)(begin + (i + 1) % n)};
}

static void make_ring(filler *f, size_t loop)
{
    ring *r = &f->rings[loop];
    link_ring(f, loop);
    r->left = r->first;
    r->lo = (point){INFINITY, INFINITY};
    r->hi = (point){-INFINITY, -INFINITY};
    const point origin = place(f, r->first);
    uint32_t c = r->first;
    do {
        const point p = place(f, c), q = place(f, f->corners[c].after), left = place(f, r->left);
        r->area += turn(origin, p, q);
        r->lo = (point){fmin(r->lo.x, p.x), fmin(r->lo.y, p.y)};
        r->hi = (point){fmax(r->hi.x, p.x), fmax(r->hi.y, p.y)};
        if (p.x < left.x || (p.x == left.x && p.y < left.y))
            r->left = c;
        c = f->corners[c].after;
    } while (c != r->first);
}

static bool is_within(const filler *f, const ring *r, point p)
{
    bool inside = false;
    if (p.x < r->lo.x || p.x > r->hi.x || p.y < r->lo.y || p.y > r->hi.y)
        return false;
    uint32_t c = r->first;
    do {
        const uint32_t after = f->corners[c].after;
        const point a = place(f, c), b = place(f, after);
        if ((a.y > p.y) != (b.y > p.y) && p.x < a.x + (p.y - a.y) * (b.x - a.x) / (b.y - a.y))
            inside = !inside;
        c = after;
    } while (c != r->first);
    return inside;
}

static vv_status find_outline(filler *f, ring *hole)
{
    const point p = place(f, hole->left);
    for (size_t i = 0; i < f->loops->n; i++) {
        const ring *r = &f->rings[i];
        if (r->area > -hole->area && (hole->outline == NONE || r->area < f->rings[hole->outline].area) &&
            is_within(f, r, p))
            hole->outline = (uint32_t)i;
    }
    return vvi_job_poll(f->job);
}

static int by_left(const void *a, const void *b, void *user)
{
    const filler *f = user;
    const uint32_t i = *(const uint32_t *)a, j = *(const uint32_t *)b;
    const double x = place(f, f->rings[i].left).x, y = place(f, f->rings[j].left).x;
    return x < y ? -1 : x > y ? 1 : i < j ? -1 : i > j;
}

/* Bridges --------------------------------------------------------------------------------------------------------- */

/* Whether a line from a corner to p begins inside its ring (O'Rourke). */
static bool begins_inside(const filler *f, uint32_t c, point p)
{
    const point at = place(f, c), before = place(f, f->corners[c].before), after = place(f, f->corners[c].after);
    if (turn(at, after, before) >= 0)
        return turn(at, p, before) >= 0 && turn(p, at, after) >= 0;
    return !(turn(at, p, after) > 0 && turn(p, at, before) > 0);
}

/* The side of the ring that is hit first from h to the left: its end that lies farther left; *x: where. */
static uint32_t hit_left(const filler *f, const ring *r, point h, double *x_out)
{
    uint32_t found = NONE, c = r->first;
    *x_out = -INFINITY;
    do {
        const uint32_t after = f->corners[c].after;
        const point a = place(f, c), b = place(f, after);
        if (a.y >= h.y && b.y <= h.y && a.y != b.y) { /* downwards: the inside is to the right of it */
            const double x = a.x + (h.y - a.y) * (b.x - a.x) / (b.y - a.y);
            if (x <= h.x && x > *x_out) {
                *x_out = x;
                found = a.x < b.x ? c : after;
            }
        }
        c = after;
    } while (c != r->first);
    return found;
}

/* Nothing lies between h and the corner that is hit, unless other corners are in that triangle: then the one that is
 * nearest to the line to the left. */
static uint32_t find_bridge(const filler *f, const ring *r, point h)
{
    double x, best = INFINITY;
    uint32_t found = hit_left(f, r, h, &x);
    if (found == NONE)
        return NONE;
    const point hit = {x, h.y}, end = place(f, found);
    const bool up = end.y >= h.y;
    uint32_t c = r->first;
    const uint32_t first_found = found;
    do {
        const point p = place(f, c);
        const bool within = p.x >= end.x && p.x <= h.x &&
                            (up ? turn(hit, h, p) >= 0 && turn(h, end, p) >= 0 && turn(end, hit, p) >= 0
                                : turn(hit, h, p) <= 0 && turn(h, end, p) <= 0 && turn(end, hit, p) <= 0);
        if (within && c != first_found && !is_same(p, h)) {
            const double slope = fabs(p.y - h.y) / (h.x - p.x);
            if (begins_inside(f, c, h) && (slope < best || (slope == best && p.x > place(f, found).x))) {
                best = slope;
                found = c;
            }
        }
        c = f->corners[c].after;
    } while (c != r->first);
    return found;
}

/* The hole becomes a part of the ring, by a line there and back. */
static void add_bridge(filler *f, uint32_t m, uint32_t h)
{
    corner *all = f->corners;
    const uint32_t m2 = (uint32_t)f->n_corners++, h2 = (uint32_t)f->n_corners++;
    const uint32_t after = all[m].after, before = all[h].before;
    all[m2] = (corner){.point = all[m].point, .before = h2, .after = after};
    all[h2] = (corner){.point = all[h].point, .before = before, .after = m2};
    all[m].after = h;
    all[h].before = m;
    all[after].before = m2;
    all[before].after = h2;
}

static vv_status bridge_holes(filler *f)
{
    vv_status st = VV_OK;
    for (size_t i = 0; i < f->loops->n && st == VV_OK; i++)
        if (f->rings[i].area < 0) {
            f->holes[f->n_holes++] = (uint32_t)i;
            st = find_outline(f, &f->rings[i]);
        }
    qsort_r(f->holes, f->n_holes, sizeof *f->holes, by_left, f);
    for (size_t i = 0; i < f->n_holes && st == VV_OK; i++) {
        ring *hole = &f->rings[f->holes[i]];
        ring *outline = hole->outline == NONE ? NULL : &f->rings[hole->outline];
        const uint32_t m = outline ? find_bridge(f, outline, place(f, hole->left)) : NONE;
        st = vvi_job_poll(f->job);
        if (m == NONE) /* rounding: it is filled by itself then */
            continue;
        add_bridge(f, m, hole->left);
        outline->n += hole->n + 2;
        hole->n = 0;
    }
    return st;
}

/* Ears ------------------------------------------------------------------------------------------------------------ */

static size_t bin_of(double at, double lo, double per, size_t n)
{
    const double bin = (at - lo) * per;
    return bin <= 0 ? 0 : bin >= (double)n ? n - 1 : (size_t)bin;
}

static size_t cell_of(const bins *b, point p)
{
    return bin_of(p.y, b->lo.y, b->per_y, b->ny) * b->nx + bin_of(p.x, b->lo.x, b->per_x, b->nx);
}

/* The room for the largest ring is there. */
static void sort_corners(filler *f, const ring *r)
{
    bins *b = &f->bins;
    const double width = r->hi.x - r->lo.x, height = r->hi.y - r->lo.y;
    const size_t side = (size_t)sqrt((double)r->n);
    b->lo = r->lo;
    b->nx = width > 0 && side > 0 ? side : 1;
    b->ny = height > 0 && side > 0 ? side : 1;
    b->per_x = width > 0 ? (double)b->nx / width : 0;
    b->per_y = height > 0 ? (double)b->ny / height : 0;
    const size_t n_cells = b->nx * b->ny;
    for (size_t i = 0; i <= n_cells; i++)
        b->begin[i] = 0;
    uint32_t c = r->first;
    do {
        b->begin[cell_of(b, place(f, c))]++;
        c = f->corners[c].after;
    } while (c != r->first);
    for (size_t i = 1; i <= n_cells; i++)
        b->begin[i] += b->begin[i - 1];
    do {
        b->corners[--b->begin[cell_of(b, place(f, c))]] = c;
        c = f->corners[c].after;
    } while (c != r->first);
}

static bool is_clear(const filler *f, size_t cell, const point t[3])
{
    const bins *b = &f->bins;
    for (uint32_t i = b->begin[cell]; i < b->begin[cell + 1]; i++) {
        const point p = place(f, b->corners[i]);
        if (!f->corners[b->corners[i]].gone && turn(t[0], t[1], p) >= 0 && turn(t[1], t[2], p) >= 0 &&
            turn(t[2], t[0], p) >= 0 && !is_same(p, t[0]) && !is_same(p, t[1]) && !is_same(p, t[2]))
            return false;
    }
    return true;
}

static bool is_ear(const filler *f, uint32_t c)
{
    const bins *b = &f->bins;
    const point t[3] = {place(f, f->corners[c].before), place(f, c), place(f, f->corners[c].after)};
    if (f->corners[f->corners[c].before].point == f->corners[f->corners[c].after].point)
        return false;
    if (is_same(t[0], t[1]) || is_same(t[1], t[2]) || is_same(t[0], t[2])) /* no area, and its sides are not needed */
        return true;
    if (!(turn(t[0], t[1], t[2]) > 0))
        return false;
    const size_t x0 = bin_of(fmin(t[0].x, fmin(t[1].x, t[2].x)), b->lo.x, b->per_x, b->nx),
                 x1 = bin_of(fmax(t[0].x, fmax(t[1].x, t[2].x)), b->lo.x, b->per_x, b->nx),
                 y0 = bin_of(fmin(t[0].y, fmin(t[1].y, t[2].y)), b->lo.y, b->per_y, b->ny),
                 y1 = bin_of(fmax(t[0].y, fmax(t[1].y, t[2].y)), b->lo.y, b->per_y, b->ny);
    for (size_t y = y0; y <= y1; y++)
        for (size_t x = x0; x <= x1; x++)
            if (!is_clear(f, y * b->nx + x, t))
                return false;
    return true;
}

/* Where rounding leaves no ear: what does the least harm. */
static uint32_t least_corner(const filler *f, uint32_t first)
{
    double least = INFINITY;
    uint32_t found = first, c = first;
    do {
        const corner *at = &f->corners[c];
        const double area = fabs(turn(place(f, at->before), place(f, c), place(f, at->after)));
        if (area < least && f->corners[at->before].point != f->corners[at->after].point) {
            least = area;
            found = c;
        }
        c = at->after;
    } while (c != first);
    return found;
}

static vv_status cut_ears(filler *f, const ring *r)
{
    uint32_t c = r->first;
    size_t tried = 0;
    vv_status st = VV_OK;
    if (r->n < 3)
        return VV_OK;
    sort_corners(f, r);
    for (size_t left = r->n; left > 2 && st == VV_OK;) {
        if (left > 3 && tried < left && !is_ear(f, c)) {
            c = f->corners[c].after;
            tried++;
            continue;
        }
        if (left > 3 && tried == left)
            c = least_corner(f, c);
        c = f->corners[cut_off(f, c)].after; /* not the next one: all would be slivers from one corner */
        left--;
        tried = 0;
        if (left % 256 == 0)
            st = vvi_job_poll(f->job);
    }
    return st;
}

static vv_status reserve(filler *f, size_t n_flat)
{
    const size_t n = f->loops->begin[f->loops->n], most = n + 2 * f->loops->n;
    if (most >= NONE)
        return vv_fail(VV_E_LIMIT, "a cut with %zu corners is too large; 2^32 are possible", most);
    f->corners = vvi_alloc(f->job, (most + 1) * sizeof *f->corners, VVI_MEM_SCRATCH);
    f->rings = vvi_alloc(f->job, (f->loops->n + 1) * sizeof *f->rings, VVI_MEM_SCRATCH);
    f->holes = vvi_alloc(f->job, (f->loops->n + 1) * sizeof *f->holes, VVI_MEM_SCRATCH);
    f->bins.begin = vvi_alloc(f->job, (most + 2) * sizeof *f->bins.begin, VVI_MEM_SCRATCH);
    f->bins.corners = vvi_alloc(f->job, (most + 1) * sizeof *f->bins.corners, VVI_MEM_SCRATCH);
    f->out = vvi_alloc(f->job, 3 * (most + n_flat + 1) * sizeof *f->out, VVI_MEM_SCRATCH);
    f->n_corners = n;
    return f->corners && f->rings && f->holes && f->bins.begin && f->bins.corners && f->out
               ? VV_OK
               : vv_fail_memory((most + n_flat) * sizeof *f->corners);
}

vv_status vvi_fill_loops(uint32_t **out, size_t *n_out, const vvi_loops *loops, vv_job *job)
{
    vvi_untangled untangled = {0};
    filler f = {.loops = &untangled.loops, .job = job};
    vv_status st = vvi_untangle(&untangled, loops, job);
    if (st == VV_OK && (st = reserve(&f, untangled.n_triangles)) == VV_OK) {
        memcpy(f.out, untangled.triangles, 3 * untangled.n_triangles * sizeof *f.out);
        f.n_out = untangled.n_triangles;
    }
    for (size_t i = 0; i < f.loops->n && st == VV_OK; i++)
        make_ring(&f, i);
    if (st == VV_OK)
        st = bridge_holes(&f);
    for (size_t i = 0; i < f.loops->n && st == VV_OK; i++)
        st = cut_ears(&f, &f.rings[i]);
    vvi_untangled_finish(&untangled);
    vvi_free(f.corners);
    vvi_free(f.rings);
    vvi_free(f.holes);
    vvi_free(f.bins.begin);
    vvi_free(f.bins.corners);
    if (st != VV_OK) {
        vvi_free(f.out);
        f.out = NULL;
    }
    *out = f.out;
    *n_out = f.n_out;
    return st;
}
