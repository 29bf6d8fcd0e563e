/* Surface tracking. A state is a loop of a cell; loops that share a crossed edge belong together. Edges are marked
 * where the piece crosses them, and numbered when all are known. */
#include "surface/tracking.h"
#include "core/job.h"
#include "core/memory.h"
#include "grid/mesh_normals.h"
#include "surface/cell.h"
#include "surface/marching_plan.h"
#include "surface/tracked_cells.h"

#include <stdlib.h>
#include <string.h>

/* What a brick keeps for a cell: its case + 1, and which of its loops belong to the piece. */
enum { CASE_BITS = 10, CASE_MASK = (1 << CASE_BITS) - 1, NO_CASE = CASE_MASK, POLL = 4096 };

typedef struct state {
    int32_t at[3], loop;
} state;

typedef struct tracker {
    vvi_march m;
    vvi_tracked known;
    double iso; /* as samples have it */
    uint16_t edges[VVI_CASES][VVI_CASE_LOOPS];
    state *stack;
    size_t n, room;
} tracker;

/* Cells ----------------------------------------------------------------------------------------------------------- */

static void find_edges(tracker *t)
{
    for (int c = 0; c < VVI_CASES; c++) {
        const vvi_case *k = &vvi_cases[c];
        for (int i = 0; i < 3 * k->n_triangles; i++)
            if (k->triangle[i] < 12)
                t->edges[c][k->loop[i / 3]] |= (uint16_t)(1 << k->triangle[i]);
    }
}

static void corners(float v[8], const vvi_march *m, const int32_t at[3])
{
    for (int c = 0; c < 8; c++)
        v[c] = vvi_cell_corner((float)vvi_march_sample(m, at[0] + (c & 1), at[1] + (c >> 1 & 1), at[2] + (c >> 2)) -
                               m->frame.iso);
}

static bool is_inside(const tracker *t, double sample)
{
    return t->m.inverted ? sample <= t->iso : sample >= t->iso;
}

/* The case of a cell; NO_CASE where the surface does not pass or a corner is no number. */
static unsigned classify(const tracker *t, const int32_t at[3])
{
    unsigned pattern = 0;
    for (int c = 0; c < 8; c++) {
        const double v = vvi_march_sample(&t->m, at[0] + (c & 1), at[1] + (c >> 1 & 1), at[2] + (c >> 2));
        if (isnan(v))
            return NO_CASE;
        pattern |= (unsigned)is_inside(t, v) << c;
    }
    if (pattern == 0 || pattern == 255)
        return NO_CASE;
    unsigned found = vvi_case_first[pattern];
    if (vvi_case_ambiguous[pattern] && t->m.decided) {
        float v[8];
        corners(v, &t->m, at);
        found += vvi_cell_decide(v, pattern);
    }
    return found;
}

static bool is_cell(const tracker *t, const int32_t at[3])
{
    for (int a = 0; a < 3; a++)
        if (at[a] < 0 || at[a] >= t->m.n[a] - 1)
            return false;
    return true;
}

/* Following ------------------------------------------------------------------------------------------------------- */

static vv_status push(tracker *t, const int32_t at[3], int loop)
{
    if (t->n == t->room) {
        const size_t room = t->room ? 2 * t->room : 1024;
        state *stack = vvi_realloc(t->m.job, t->stack, room * sizeof *stack, VVI_MEM_SCRATCH);
        if (!stack)
            return vv_fail_memory(room * sizeof *stack);
        t->stack = stack;
        t->room = room;
    }
    t->stack[t->n++] = (state){{at[0], at[1], at[2]}, loop};
    return VV_OK;
}

/* The loop of a cell that crosses an edge joins the piece. */
static vv_status join(tracker *t, const int32_t at[3], int edge)
{
    vvi_tracked_brick *b;
    if (!is_cell(t, at))
        return VV_OK;
    const vv_status st = vvi_tracked_make(&b, &t->known, at);
    if (st != VV_OK)
        return st;
    uint16_t *cell = &b->cell[vvi_tracked_local(at)];
    if (!*cell) {
        const unsigned here = classify(t, at);
        *cell = (uint16_t)(here == NO_CASE ? NO_CASE : here + 1);
    }
    if ((*cell & CASE_MASK) == NO_CASE)
        return VV_OK;
    const unsigned found = (*cell & CASE_MASK) - 1u;
    for (int loop = 0; loop < vvi_cases[found].n_loops; loop++) {
        const uint16_t mark = (uint16_t)(1 << (CASE_BITS + loop));
        if (!(t->edges[found][loop] >> edge & 1) || *cell & mark)
            continue;
        *cell |= mark;
        return push(t, at, loop);
    }
    return VV_OK;
}

/* The sample that edge e of a cell begins at. */
static void edge_place(int32_t out[3], const int32_t cell[3], int e)
{
    memcpy(out, cell, 3 * sizeof *out);
    out[vvi_across(e / 4, 0)] += e & 1;
    out[vvi_across(e / 4, 1)] += e >> 1 & 1;
}

/* Marks an edge and joins the loops of all four cells around it. */
static vv_status cross_edge(tracker *t, const int32_t cell[3], int e)
{
    const int axis = e / 4;
    int32_t at[3];
    vvi_tracked_brick *b;
    edge_place(at, cell, e);
    vv_status st = vvi_tracked_make(&b, &t->known, at);
    if (st != VV_OK)
        return st;
    const int edge = 3 * vvi_tracked_local(at) + axis;
    if (b->edge[edge >> 6] >> (edge & 63) & 1)
        return VV_OK;
    b->edge[edge >> 6] |= (uint64_t)1 << (edge & 63);
    for (int side = 0; side < 4 && st == VV_OK; side++) {
        int32_t other[3] = {at[0], at[1], at[2]};
        other[vvi_across(axis, 0)] -= side & 1;
        other[vvi_across(axis, 1)] -= side >> 1;
        st = join(t, other, 4 * axis + side);
    }
    return st;
}

static vv_status follow(tracker *t)
{
    vv_status st = VV_OK;
    for (size_t i = 0; t->n && st == VV_OK; i++) {
        const state s = t->stack[--t->n];
        vvi_tracked_brick *b;
        if ((st = vvi_tracked_make(&b, &t->known, s.at)) != VV_OK)
            return st;
        const unsigned found = (b->cell[vvi_tracked_local(s.at)] & CASE_MASK) - 1u;
        for (unsigned rest = t->edges[found][s.loop]; rest && st == VV_OK; rest &= rest - 1)
            st = cross_edge(t, s.at, __builtin_ctz(rest));
        if (st == VV_OK && i % POLL == 0)
            st = vvi_job_progress(t->m.job, "tracking", i, i + t->n);
    }
    return st;
}

/* Seed ------------------------------------------------------------------------------------------------------------ */

typedef struct search {
    double seed[3]; /* index coordinates with the cap's */
    double nearest; /* square of a world length */
    int32_t at[3];
    int edge;
} search;

static double square_distance(const tracker *t, const double p[3], const search *s)
{
    double sum = 0;
    for (int i = 0; i < 3; i++) {
        double d = 0;
        for (int a = 0; a < 3; a++)
            d += (double)t->m.frame.to_world[i][a] * (p[a] - s->seed[a]);
        sum += d * d;
    }
    return sum;
}

/* Every crossing of a cell is a candidate; the first of equals is taken. */
static void look_at(search *s, const tracker *t, const int32_t at[3])
{
    const unsigned found = classify(t, at);
    if (found == NO_CASE)
        return;
    for (int e = 0; e < 12; e++) {
        int32_t low[3];
        if (!(vvi_cases[found].edges >> e & 1))
            continue;
        edge_place(low, at, e);
        double p[3] = {low[0], low[1], low[2]};
        int32_t high[3] = {low[0], low[1], low[2]};
        high[e / 4]++;
        const double a = vvi_march_sample(&t->m, low[0], low[1], low[2]) - t->iso;
        const double b = vvi_march_sample(&t->m, high[0], high[1], high[2]) - t->iso;
        const double u = a / (a - b);
        p[e / 4] += u >= 0 && u <= 1 ? u : 0.5;
        const double d = square_distance(t, p, s);
        if (!(d < s->nearest))
            continue;
        s->nearest = d;
        s->edge = e;
        memcpy(s->at, at, sizeof s->at);
    }
}

/* The cells at Chebyshev distance r from the middle one. */
static void look_at_shell(search *s, const tracker *t, const int32_t middle[3], int32_t r)
{
    int32_t lo[3], hi[3], at[3];
    for (int a = 0; a < 3; a++) {
        lo[a] = middle[a] - r > 0 ? middle[a] - r : 0;
        hi[a] = middle[a] + r < t->m.n[a] - 2 ? middle[a] + r : (int32_t)t->m.n[a] - 2;
    }
    for (at[2] = lo[2]; at[2] <= hi[2]; at[2]++)
        for (at[1] = lo[1]; at[1] <= hi[1]; at[1]++) {
            const bool whole = abs(at[2] - middle[2]) == r || abs(at[1] - middle[1]) == r;
            for (at[0] = lo[0]; at[0] <= hi[0]; at[0]++) {
                if (!whole && abs(at[0] - middle[0]) != r)
                    at[0] = at[0] < middle[0] + r && middle[0] + r <= hi[0] ? middle[0] + r : hi[0];
                if (whole || abs(at[0] - middle[0]) == r)
                    look_at(s, t, at);
            }
        }
}

static vv_status begin_search(search *s, const tracker *t, const vvi_tracking_options *o)
{
    vv_affine to_index;
    if (!isfinite(o->seed.x) || !isfinite(o->seed.y) || !isfinite(o->seed.z))
        return vv_fail(VV_E_ARGUMENT, "the seed of a surface must be a finite point; this is (%g, %g, %g)", o->seed.x,
                       o->seed.y, o->seed.z);
    if (!vv_affine_invert(&to_index, t->m.grid.index_to_world))
        return vv_fail(VV_E_ARGUMENT, "the grid's axes lie in one plane: there is no surface");
    const vv_vec3 p = vv_affine_point(to_index, o->seed);
    *s =
        (search){.seed = {p.x + (double)t->m.pad, p.y + (double)t->m.pad, p.z + (double)t->m.pad}, .nearest = INFINITY};
    return VV_OK;
}

/* *found_out: whether the surface passes within reach. The shell after the first that is crossed is looked at too,
 * since its corner-wise distance is not the distance. */
static vv_status find_seed(search *s, bool *found_out, const tracker *t, const vvi_tracking_options *o)
{
    int32_t middle[3], last = 0;
    vv_status st = begin_search(s, t, o);
    *found_out = false;
    for (int a = 0; a < 3 && st == VV_OK; a++) {
        const double most = (double)t->m.n[a] - 2;
        middle[a] = (int32_t)fmin(fmax(floor(s->seed[a]), 0), most);
        last = middle[a] > last ? middle[a] : last;
        last = (int32_t)most - middle[a] > last ? (int32_t)most - middle[a] : last;
    }
    if (o->reach > 0 && o->reach < last)
        last = (int32_t)o->reach;
    for (int32_t r = 0; r <= last && st == VV_OK; r++) {
        const bool over = *found_out;
        look_at_shell(s, t, middle, r);
        *found_out = s->nearest < INFINITY;
        if (over)
            break;
        st = vvi_job_poll(t->m.job);
    }
    return st;
}

/* Mesh ------------------------------------------------------------------------------------------------------------ */

static void count_brick(vvi_tracked_brick *b)
{
    for (int w = 0; w < VVI_TRACKED_WORDS; w++) {
        b->before[w] = (uint16_t)b->n_edges;
        b->n_edges += (uint32_t)__builtin_popcountll(b->edge[w]);
    }
    for (int c = 0; c < VVI_TRACKED_CELLS; c++) {
        const unsigned loops = b->cell[c] >> CASE_BITS;
        if (!loops)
            continue;
        const vvi_case *k = &vvi_cases[(b->cell[c] & CASE_MASK) - 1];
        uint8_t used = 0;
        for (int i = 0; i < k->n_triangles; i++)
            if (loops >> k->loop[i] & 1) {
                b->n_triangles++;
                for (int v = 0; v < 3; v++)
                    used |= k->triangle[3 * i + v] >= 12;
            }
        b->n_interior += used;
    }
}

static vvi_march_count count_bricks(tracker *t)
{
    vvi_march_count all = {0, 0};
    for (size_t i = 0; i < t->known.n_bricks; i++) {
        vvi_tracked_brick *b = t->known.sorted[i];
        count_brick(b);
        b->first_vertex = (uint32_t)all.vertices;
        b->first_triangle = all.triangles;
        all.vertices += b->n_edges + b->n_interior;
        all.triangles += b->n_triangles;
    }
    return all;
}

static void put_number(int32_t *out, double v, bool is_float)
{
    const int32_t whole = is_float ? 0 : (int32_t)v;
    const float real = (float)v;
    memcpy(out, is_float ? (const void *)&real : &whole, sizeof *out);
}

/* One vertex on its way to the kernel: samples and twice the gradients at both ends of its edge. Differences of floats
 * in double precision round to the same float as those in single precision. */
static void queue_vertex(vvi_march_queue *q, const vvi_march *m, const int32_t at[3], int axis)
{
    const bool real = m->type == VVI_MARCH_F32;
    const int32_t slot = q->n++;
    for (int s = 0; s < 2; s++) {
        int64_t p[3] = {at[0], at[1], at[2]};
        p[axis] += s;
        put_number(&q->end[s][slot], vvi_march_sample(m, p[0], p[1], p[2]), real);
        for (int a = 0; a < 3; a++) {
            int64_t lo[3] = {p[0], p[1], p[2]}, hi[3] = {p[0], p[1], p[2]};
            lo[a] -= lo[a] > 0;
            hi[a] += hi[a] + 1 < m->n[a];
            double d = vvi_march_sample(m, hi[0], hi[1], hi[2]) - vvi_march_sample(m, lo[0], lo[1], lo[2]);
            d = real ? (double)(float)d : d;
            put_number(&q->gradient[s][a][slot], hi[a] - lo[a] == 2 ? d : 2 * d, real);
        }
    }
    for (int a = 0; a < 3; a++)
        q->place[a][slot] = (float)at[a];
    q->axis[slot] = axis;
}

static void sample_place(int32_t out[3], const vvi_tracked_brick *b, int local)
{
    for (int a = 0; a < 3; a++)
        out[a] = b->at[a] * VVI_TRACKED_SIDE + (local >> a * VVI_TRACKED_SHIFT & (VVI_TRACKED_SIDE - 1));
}

static void put_vertices(const tracker *t, const vvi_tracked_brick *b)
{
    vvi_march_queue q = {.first = b->first_vertex};
    for (int w = 0; w < VVI_TRACKED_WORDS; w++)
        for (uint64_t rest = b->edge[w]; rest; rest &= rest - 1) {
            const int edge = 64 * w + __builtin_ctzll(rest);
            int32_t at[3];
            sample_place(at, b, edge / 3);
            queue_vertex(&q, &t->m, at, edge % 3);
            if (q.n == VVI_MARCH_QUEUE)
                t->m.kernels->empty[t->m.type](&q, &t->m.frame);
        }
    t->m.kernels->empty[t->m.type](&q, &t->m.frame);
}

/* The number of the vertex on an edge of a cell. near[i]: the brick i & 1 along x, ... from the cell's. */
static uint32_t vertex_of(vvi_tracked_brick *const near[8], const vvi_tracked_brick *b, const int32_t cell[3], int e)
{
    int32_t at[3];
    edge_place(at, cell, e);
    int which = 0;
    for (int a = 0; a < 3; a++)
        which |= ((at[a] >> VVI_TRACKED_SHIFT) - b->at[a]) << a;
    return near[which]->first_vertex + vvi_tracked_rank(near[which], 3 * vvi_tracked_local(at) + e / 4);
}

static void put_interior(const tracker *t, const vvi_case *k, const int32_t at[3], uint32_t vertex)
{
    const float cell[3] = {(float)at[0], (float)at[1], (float)at[2]};
    float v[8];
    corners(v, &t->m, at);
    vvi_cell_put_interior(&t->m.frame, vertex, v, k->around[0], cell);
}

static uint32_t *put_cell(const tracker *t, uint32_t *to, vvi_tracked_brick *const near[8], const vvi_tracked_brick *b,
                          int local, uint32_t *interior)
{
    const vvi_case *k = &vvi_cases[(b->cell[local] & CASE_MASK) - 1];
    const unsigned loops = b->cell[local] >> CASE_BITS;
    bool used = false;
    int32_t at[3];
    sample_place(at, b, local);
    for (int i = 0; i < 3 * k->n_triangles; i++) {
        if (!(loops >> k->loop[i / 3] & 1))
            continue;
        const bool inner = k->triangle[i] >= 12;
        *to++ = inner ? *interior : vertex_of(near, b, at, k->triangle[i]);
        used |= inner;
    }
    if (used)
        put_interior(t, k, at, (*interior)++);
    return to;
}

/* Item: the vertices and triangles of one brick. */
static vv_status fill_brick(void *scratch, void *user, size_t item)
{
    const tracker *t = user;
    const vvi_tracked_brick *b = t->known.sorted[item];
    uint32_t *const first = t->m.arrays.triangles + 3 * b->first_triangle, *to = first;
    uint32_t interior = b->first_vertex + b->n_edges;
    vvi_tracked_brick *near[8];
    (void)scratch;
    for (int i = 0; i < 8; i++) {
        const int32_t at[3] = {b->at[0] + (i & 1), b->at[1] + (i >> 1 & 1), b->at[2] + (i >> 2)};
        near[i] = vvi_tracked_find(&t->known, at);
    }
    put_vertices(t, b);
    for (int local = 0; local < VVI_TRACKED_CELLS; local++)
        if (b->cell[local] >> CASE_BITS)
            to = put_cell(t, to, near, b, local, &interior);
    if (t->m.mirrored)
        vvi_march_turn_over(first, to);
    return VV_OK;
}

/* The whole ------------------------------------------------------------------------------------------------------- */

static vv_status make_mesh(vv_mesh **out, tracker *t, bool normals)
{
    static const vvi_work fill = {.stage = "triangles", .item = fill_brick};
    vv_status st = vvi_tracked_sort(&t->known);
    if (st == VV_OK)
        st = vvi_march_new_mesh(out, &t->m, count_bricks(t), 0, normals);
    if (st == VV_OK)
        st = vvi_parallel_for(t->m.job, &fill, t, t->known.n_bricks);
    if (st == VV_OK)
        st = vvi_normals_fill(t->m.arrays.normals, *out, t->m.job);
    return st;
}

static vv_status track(vv_mesh **out, tracker *t, const vv_field *field, const vvi_tracking_options *o, bool some)
{
    search s;
    bool found = false;
    vv_status st = some ? find_seed(&s, &found, t, o) : VV_OK;
    if (st == VV_OK && !found)
        return vv_fail(
            VV_E_NOT_FOUND,
            "there is no surface of value %g near (%g, %g, %g); choose another value or point, or a longer reach",
            o->surface.value, o->seed.x, o->seed.y, o->seed.z);
    find_edges(t);
    if (st == VV_OK)
        st = join(t, s.at, s.edge);
    if (st == VV_OK)
        st = follow(t);
    if (st == VV_OK)
        st = make_mesh(out, t, !o->surface.no_normals);
    return st == VV_OK ? vv_field_health(field) : st;
}

vv_status vvi_track_surface(vv_mesh **out, const vv_field *field, const vvi_tracking_options *o, vv_job *job)
{
    *out = NULL;
    tracker *t = vvi_alloc_zeroed(job, sizeof *t, VVI_MEM_SCRATCH);
    if (!t)
        return vv_fail_memory(sizeof *t);
    t->known.job = job;
    vv_status st = vvi_march_open(&t->m, field, &o->surface, job);
    t->iso = t->m.made ? 0 : t->m.stored;
    if (st == VV_OK)
        st = track(out, t, field, o, t->m.some);
    vv_brick_release(&t->m.brick);
    vvi_tracked_finish(&t->known);
    vvi_free(t->stack);
    vvi_free(t);
    if (st != VV_OK) {
        vv_mesh_release(*out);
        *out = NULL;
    }
    return st;
}
