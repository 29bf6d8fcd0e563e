/* A reduced surface as a mesh with shared vertices. Edges belong to the brick of their lower end; every brick marks
 * those of its cells, with their places, in bits that others may set too: the same ones. Then they are counted, and all
 * else has its place. Normals are sums of whole numbers, so that their order does not matter. */
#include "core/job.h"
#include "core/memory.h"
#include "grid/mesh.h"
#include "surface/cell.h"
#include "surface/reduced_records.h"

#include <math.h>
#include <string.h>

enum { SHIFT = VVI_REDUCED_SHIFT, SIDE = VVI_REDUCED_SIDE, WORDS = 3 * SIDE * SIDE * SIDE / 64, CHUNK = 4096 };

/* The edges of a brick of samples: bit 3 * sample + axis. */
typedef struct edges {
    uint64_t crossed[WORDS], low[WORDS], high[WORDS]; /* low, high: the bits of q */
    uint16_t before[WORDS];
    uint32_t first;
    int32_t at[3];
} edges;

typedef struct meshing {
    const vvi_reduced *r;
    int32_t n[3]; /* bricks of samples */
    int32_t *of;  /* by brick of samples: its edges; -1: none */
    edges *edges;
    size_t n_edges, n_vertices;
    uint64_t *sum; /* by vertex: three fields of 21 bits */
    vvi_mesh_arrays to;
    float to_world[3][3], to_normal[3][3];
    bool mirrored;
    vv_job *job;
} meshing;

/* Where edges are ------------------------------------------------------------------------------------------------- */

static size_t brick_number(const meshing *m, const int32_t at[3])
{
    return ((size_t)at[2] * (size_t)m->n[1] + (size_t)at[1]) * (size_t)m->n[0] + (size_t)at[0];
}

/* Edges of the bricks around one that has cells: i & 1 further along x, ... */
static void find_near(edges *near[8], const meshing *m, const vvi_reduced_brick *b)
{
    for (int i = 0; i < 8; i++) {
        const int32_t at[3] = {b->at[0] + (i & 1), b->at[1] + (i >> 1 & 1), b->at[2] + (i >> 2)};
        near[i] = &m->edges[m->of[brick_number(m, at)]];
    }
}

/* Which of the bricks around, and the bit there, an edge of a cell is. */
static int edge_bit(int *which, const int32_t cell[3], unsigned e)
{
    int32_t at[3] = {cell[0], cell[1], cell[2]};
    const int axis = (int)e / 4;
    at[vvi_across(axis, 0)] += (int32_t)(e & 1);
    at[vvi_across(axis, 1)] += (int32_t)(e >> 1 & 1);
    *which = at[0] >> SHIFT | (at[1] >> SHIFT) << 1 | (at[2] >> SHIFT) << 2;
    return 3 * ((at[2] & (SIDE - 1)) << 2 * SHIFT | (at[1] & (SIDE - 1)) << SHIFT | (at[0] & (SIDE - 1))) + axis;
}

static uint32_t vertex_number(const edges *b, int bit)
{
    const uint64_t below = b->crossed[bit >> 6] & (((uint64_t)1 << (bit & 63)) - 1);
    return b->first + b->before[bit >> 6] + (uint32_t)__builtin_popcountll(below);
}

/* Every brick with cells needs its own edges and those of the seven after it. */
static vv_status find_bricks(meshing *m)
{
    const vvi_reduced *r = m->r;
    size_t total;
    for (int a = 0; a < 3; a++)
        m->n[a] = r->n[a] + 1;
    vv_status st = vvi_mul3_size(&total, (size_t)m->n[0], (size_t)m->n[1], (size_t)m->n[2]);
    if (st != VV_OK)
        return st;
    if (!(m->of = vvi_alloc_zeroed(m->job, total * sizeof *m->of, VVI_MEM_SCRATCH)))
        return vv_fail_memory(total * sizeof *m->of);
    for (size_t i = 0; i < r->n_bricks; i++)
        for (int near = 0; near < 8; near++) {
            const int32_t *b = r->bricks[i].at;
            const int32_t at[3] = {b[0] + (near & 1), b[1] + (near >> 1 & 1), b[2] + (near >> 2)};
            m->of[brick_number(m, at)] = 1;
        }
    for (size_t i = 0; i < total; i++)
        m->of[i] = m->of[i] ? (int32_t)m->n_edges++ : -1;
    size_t bytes;
    if ((st = vvi_mul_size(&bytes, m->n_edges, sizeof *m->edges)) != VV_OK)
        return st;
    m->edges = vvi_alloc_zeroed(m->job, bytes + 1, VVI_MEM_SCRATCH);
    if (!m->edges)
        return vv_fail_memory(bytes);
    for (size_t i = 0; i < total; i++)
        if (m->of[i] >= 0) {
            int32_t *at = m->edges[m->of[i]].at;
            at[0] = (int32_t)(i % (size_t)m->n[0]);
            at[1] = (int32_t)(i / (size_t)m->n[0] % (size_t)m->n[1]);
            at[2] = (int32_t)(i / (size_t)m->n[0] / (size_t)m->n[1]);
        }
    return VV_OK;
}

/* NOLINTNEXTLINE(readability-non-const-parameter): the bit is set there */
static void set_bit(uint64_t *word, uint64_t bit)
{
    if (!(__atomic_load_n(word, __ATOMIC_RELAXED) & bit))
        __atomic_fetch_or(word, bit, __ATOMIC_RELAXED);
}

/* Item: marks the edges of one brick's cells. */
static vv_status mark_brick(void *scratch, void *user, size_t item)
{
    const meshing *m = user;
    const vvi_reduced_brick *b = &m->r->bricks[item];
    vvi_reduced_reader reader = {.at = m->r->records + b->first_byte};
    edges *near[8];
    (void)scratch;
    find_near(near, m, b);
    for (uint32_t i = 0; i < b->n_cells; i++) {
        vvi_reduced_cell c;
        vvi_reduced_read(&c, &reader);
        for (unsigned rest = c.k->edges; rest; rest &= rest - 1) {
            const unsigned e = (unsigned)__builtin_ctz(rest);
            int which;
            const int at = edge_bit(&which, c.at, e);
            const uint64_t bit = (uint64_t)1 << (at & 63);
            set_bit(&near[which]->crossed[at >> 6], bit);
            if (c.q[e] & 1)
                set_bit(&near[which]->low[at >> 6], bit);
            if (c.q[e] & 2)
                set_bit(&near[which]->high[at >> 6], bit);
        }
    }
    return VV_OK;
}

static void number_vertices(meshing *m)
{
    for (size_t i = 0; i < m->n_edges; i++) {
        edges *b = &m->edges[i];
        uint32_t n = 0;
        b->first = (uint32_t)m->n_vertices;
        for (int w = 0; w < WORDS; w++) {
            b->before[w] = (uint16_t)n;
            n += (uint32_t)__builtin_popcountll(b->crossed[w]);
        }
        m->n_vertices += n;
    }
}

/* Vertices and triangles ------------------------------------------------------------------------------------------ */

/* Item: the places of one brick's vertices. */
static vv_status place_brick(void *scratch, void *user, size_t item)
{
    const meshing *m = user;
    const edges *b = &m->edges[item];
    float *to = m->to.positions + 3 * (size_t)b->first;
    (void)scratch;
    for (int w = 0; w < WORDS; w++)
        for (uint64_t rest = b->crossed[w]; rest; rest &= rest - 1) {
            const int at = __builtin_ctzll(rest), bit = 64 * w + at, sample = bit / 3;
            float p[3];
            for (int a = 0; a < 3; a++)
                p[a] = (float)(b->at[a] * SIDE + (sample >> a * SHIFT & (SIDE - 1)));
            p[bit % 3] += 0.25f * (float)((b->low[w] >> at & 1) + 2 * (b->high[w] >> at & 1)) + 0.125f;
            for (int i = 0; i < 3; i++)
                *to++ = m->to_world[i][0] * p[0] + m->to_world[i][1] * p[1] + m->to_world[i][2] * p[2];
        }
    return VV_OK;
}

/* Three signed numbers in one: sums stay apart as long as each is below 2^20. */
static uint64_t pack(const int16_t n[3])
{
    return (uint64_t)(int64_t)n[0] + ((uint64_t)(int64_t)n[1] << 21) + ((uint64_t)(int64_t)n[2] << 42);
}

static void unpack(float out[3], uint64_t sum)
{
    for (int a = 0; a < 3; a++) {
        const int64_t v = (int64_t)(sum << 43) >> 43;
        out[a] = (float)v;
        sum = (sum - (uint64_t)v) >> 21;
    }
}

/* Item: the triangles of one brick. */
static vv_status join_brick(void *scratch, void *user, size_t item)
{
    const meshing *m = user;
    const vvi_reduced_brick *b = &m->r->bricks[item];
    vvi_reduced_reader reader = {.at = m->r->records + b->first_byte};
    uint32_t *to = m->to.triangles + 3 * b->first_triangle;
    edges *near[8];
    (void)scratch;
    find_near(near, m, b);
    for (uint32_t i = 0; i < b->n_cells; i++) {
        vvi_reduced_triangle triangles[VVI_CASE_TRIANGLES];
        uint32_t vertex[12];
        uint64_t normal[12] = {0};
        vvi_reduced_cell c;
        vvi_reduced_read(&c, &reader);
        vvi_reduced_triangles(triangles, &c);
        for (unsigned rest = c.k->edges; rest; rest &= rest - 1) {
            const unsigned e = (unsigned)__builtin_ctz(rest);
            int which;
            const int bit = edge_bit(&which, c.at, e);
            vertex[e] = vertex_number(near[which], bit);
        }
        for (int t = 0; t < c.k->n_triangles; t++, to += 3)
            for (int v = 0; v < 3; v++) {
                const int e = c.k->triangle[3 * t + v];
                to[m->mirrored && v ? 3 - v : v] = vertex[e];
                normal[e] += pack(triangles[t].normal);
            }
        for (unsigned rest = c.k->edges; rest; rest &= rest - 1) {
            const int e = __builtin_ctz(rest);
            __atomic_fetch_add(&m->sum[vertex[e]], normal[e], __ATOMIC_RELAXED);
        }
    }
    return VV_OK;
}

/* Item: some normals. */
static vv_status turn_normals(void *scratch, void *user, size_t item)
{
    const meshing *m = user;
    const size_t begin = item * CHUNK, end = begin + CHUNK < m->n_vertices ? begin + CHUNK : m->n_vertices;
    (void)scratch;
    for (size_t v = begin; v < end; v++) {
        float sum[3], n[3], square = 0;
        unpack(sum, m->sum[v]);
        for (int i = 0; i < 3; i++) {
            n[i] = m->to_normal[i][0] * sum[0] + m->to_normal[i][1] * sum[1] + m->to_normal[i][2] * sum[2];
            square += n[i] * n[i];
        }
        for (size_t i = 0; i < 3; i++)
            m->to.normals[3 * v + i] = square > 0 ? n[i] / sqrtf(square) : 0;
    }
    return VV_OK;
}

/* The whole ------------------------------------------------------------------------------------------------------- */

static vv_status open_meshing(meshing *m)
{
    const vv_affine *to_world = &m->r->grid.index_to_world;
    const double voxel = vv_grid_voxel(&m->r->grid);
    vv_affine inverse;
    if (!vv_affine_invert(&inverse, *to_world))
        return vv_fail(VV_E_ARGUMENT, "the grid's axes lie in one plane: there is no surface");
    m->mirrored = vv_affine_determinant(*to_world) < 0;
    for (int i = 0; i < 3; i++)
        for (int a = 0; a < 3; a++) {
            m->to_world[i][a] = (float)(&to_world->axis[a].x)[i];
            m->to_normal[i][a] = (float)(voxel * (&inverse.axis[i].x)[a]);
        }
    return VV_OK;
}

static vv_status new_mesh(vv_mesh **out, meshing *m)
{
    const vv_grid *grid = &m->r->grid;
    vv_mesh_info info = {.n_vertices = m->n_vertices,
                         .n_triangles = m->r->n_triangles,
                         .origin = grid->index_to_world.origin,
                         .space = grid->space};
    memcpy(info.unit, grid->unit, sizeof info.unit);
    const vv_status st = vvi_mesh_new(out, &m->to, &info, VVI_MESH_NORMALS, m->job);
    if (st != VV_OK)
        return st;
    m->sum = vvi_alloc_zeroed(m->job, m->n_vertices * sizeof *m->sum + 1, VVI_MEM_SCRATCH);
    return m->sum ? VV_OK : vv_fail_memory(m->n_vertices * sizeof *m->sum);
}

static vv_status fill(vv_mesh **out, meshing *m)
{
    static const vvi_work mark = {.item = mark_brick}, place = {.item = place_brick};
    static const vvi_work join = {.stage = "triangles", .item = join_brick}, normals = {.item = turn_normals};
    vv_status st = open_meshing(m);
    if (st == VV_OK)
        st = find_bricks(m);
    if (st == VV_OK)
        st = vvi_parallel_for(m->job, &mark, m, m->r->n_bricks);
    if (st == VV_OK) {
        number_vertices(m);
        st = new_mesh(out, m);
    }
    if (st == VV_OK)
        st = vvi_parallel_for(m->job, &place, m, m->n_edges);
    if (st == VV_OK)
        st = vvi_parallel_for(m->job, &join, m, m->r->n_bricks);
    if (st == VV_OK)
        st = vvi_parallel_for(m->job, &normals, m, (m->n_vertices + CHUNK - 1) / CHUNK);
    return st;
}

vv_status vvi_reduced_mesh(vv_mesh **out, const vvi_reduced *reduced, vv_job *job)
{
    meshing m = {.r = reduced, .job = job};
    *out = NULL;
    const vv_status st = fill(out, &m);
    vvi_free(m.of);
    vvi_free(m.edges);
    vvi_free(m.sum);
    if (st != VV_OK) {
        vv_mesh_release(*out);
        *out = NULL;
    }
    return st;
}
