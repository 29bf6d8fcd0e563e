/* Layouts of a volume of bytes and ways to sample them, for layouts.c. */
#ifndef BENCH_LAYOUTS_WAYS_H
#define BENCH_LAYOUTS_WAYS_H
#include "render/march/lattice_simd.h"
#include <stdio.h>
#include <stdlib.h>

enum { GUARD = 8 }; /* bytes that gathers may read after the last sample */

static void *take_memory(size_t bytes)
{
    void *p = malloc(bytes ? bytes : 1);
    if (!p) {
        fprintf(stderr, "layouts: no memory for %zu bytes\n", bytes);
        exit(1);
    }
    return p;
}

/* What is sampled ------------------------------------------------------------------------------------------------ */

/* Cells 2^bits a side; the samples of a brick lie x fastest in `bytes` bytes, bricks x fastest after each other. */
typedef struct brick_shape {
    int bits;
    int32_t below, side; /* samples before its first cell's; samples along an axis, those and the last cell's with it */
    int32_t bytes;       /* padded so that every gather stays in it */
} brick_shape;

static const brick_shape small_shape = {3, 0, 9, 736}, large_shape = {4, 0, 17, 4928};
static const brick_shape wide_shape = {4, 1, 19, 6880}; /* with what central differences need */

typedef struct bricks {
    uint8_t *data;
    int32_t n; /* along an axis */
    size_t bytes;
} bricks;

typedef struct volume {
    vvi_lattice lattice, padded;
    bricks small, large, wide;
    int16_t *words; /* value, then central differences along x, y, z over two voxels, not halved */
} volume;

/* A smooth pattern and a little noise: the rates do not depend on it, the comparison with double precision does. */
static uint8_t *make_samples(int n)
{
    uint8_t *data = take_memory((size_t)n * (size_t)n * (size_t)n + GUARD), *out = data;
    float *wave = take_memory((size_t)n * sizeof *wave);
    for (int i = 0; i < n; i++)
        wave[i] = sinf(0.13f * (float)i) + 0.5f * sinf(0.41f * (float)i);
    for (int k = 0; k < n; k++)
        for (int j = 0; j < n; j++) {
            const float yz = 40.0f * wave[j] * wave[k] + 120.0f;
            for (int i = 0; i < n; i++) {
                const uint32_t hash = (uint32_t)i * 73856093u ^ (uint32_t)j * 19349663u ^ (uint32_t)k * 83492791u;
                *out++ = (uint8_t)(yz + 25.0f * wave[i] + (float)(hash * 2654435761u >> 30));
            }
        }
    memset(out, 0, GUARD);
    free(wave);
    return data;
}

/* The same rows, but further apart: rows and slices a power of two apart compete for the same few lines of a cache. */
static vvi_lattice make_padded(const vvi_lattice *g)
{
    enum { LINE = 64, PAGE = 4096, ROW_PAD = 12, SLICE_PAD = 320 };
    vvi_lattice p = *g;
    p.row = (g->row + LINE - 1) / LINE * LINE + ROW_PAD;
    p.slice = ((int64_t)p.row * g->n[1] + PAGE - 1) / PAGE * PAGE + SLICE_PAD;
    uint8_t *data = take_memory((size_t)(p.slice * g->n[2]) + GUARD);
    for (int32_t k = 0; k < g->n[2]; k++)
        for (int32_t j = 0; j < g->n[1]; j++)
            memcpy(data + k * p.slice + j * p.row, (const uint8_t *)g->data + k * g->slice + j * g->row,
                   (size_t)g->n[0]);
    p.data = data;
    return p;
}

/* Samples beyond the grid repeat its border. */
static void fill_brick(uint8_t *to, const vvi_lattice *g, const brick_shape *shape, const int32_t low[3])
{
    const int32_t side = shape->side, n = g->n[0], skip = low[0] < 0, left = n - low[0] - skip;
    const int32_t row = left < side - skip ? left : side - skip;
    for (int32_t k = 0; k < side; k++)
        for (int32_t j = 0; j < side; j++, to += side) {
            const int32_t y = low[1] + j < 0 ? 0 : low[1] + j < n ? low[1] + j : n - 1;
            const int32_t z = low[2] + k < 0 ? 0 : low[2] + k < n ? low[2] + k : n - 1;
            const uint8_t *from = (const uint8_t *)g->data + z * g->slice + y * g->row + low[0] + skip;
            memcpy(to + skip, from, (size_t)row);
            if (skip)
                to[0] = from[0];
            for (int32_t i = skip + row; i < side; i++)
                to[i] = from[row - 1];
        }
}

static bricks make_bricks(const vvi_lattice *g, const brick_shape *shape)
{
    const int32_t size = 1 << shape->bits, n = (g->n[0] - 1 + size - 1) >> shape->bits;
    bricks b = {.n = n, .bytes = (size_t)n * (size_t)n * (size_t)n * (size_t)shape->bytes};
    uint8_t *to = b.data = take_memory(b.bytes);
    for (int32_t k = 0; k < n; k++)
        for (int32_t j = 0; j < n; j++)
            for (int32_t i = 0; i < n; i++, to += shape->bytes) {
                const int32_t below = shape->below;
                const int32_t low[3] = {i * size - below, j * size - below, k * size - below};
                fill_brick(to, g, shape, low);
            }
    return b;
}

/* Twice the central difference; one-sided, and twice too, at the border. */
static int16_t twice_difference(const uint8_t *v, int32_t i, int32_t n, ptrdiff_t step)
{
    return (int16_t)(i == 0 ? 2 * (v[step] - v[0]) : i == n - 1 ? 2 * (v[0] - v[-step]) : v[step] - v[-step]);
}

static size_t words_bytes(int32_t n)
{
    return (size_t)n * (size_t)n * (size_t)n * 4 * sizeof(int16_t);
}

static int16_t *make_words(const vvi_lattice *g)
{
    const int32_t n = g->n[0];
    int16_t *words = take_memory(words_bytes(n)), *to = words;
    const uint8_t *v = g->data;
    for (int32_t k = 0; k < n; k++)
        for (int32_t j = 0; j < n; j++)
            for (int32_t i = 0; i < n; i++, v++, to += 4) {
                to[0] = *v;
                to[1] = twice_difference(v, i, n, 1);
                to[2] = twice_difference(v, j, n, g->row);
                to[3] = twice_difference(v, k, n, g->slice);
            }
    return words;
}

/* Ways to sample -------------------------------------------------------------------------------------------------- */

typedef struct sample {
    vf value;
    vf3 gradient; /* of the stored values in index space; 0 where only the value is taken */
} sample;

VV_INLINE vm every_lane(void)
{
    return vm_first_n(VV_WIDTH);
}

/* Where the cell's lowest sample lies; the shape is a constant. A coordinate's place is the coordinate, less a brick's
 * cells for each brick before it. */
VV_INLINE vi brick_place(const bricks *b, const brick_shape *shape, const cell_at *c)
{
    const int32_t side = shape->side, size = 1 << shape->bits, bits = shape->bits, bytes = shape->bytes;
    const vi x = c->i + vi_shr_u(c->i, bits) * vi_set1(bytes - size);
    const vi y = c->j * vi_set1(side) + vi_shr_u(c->j, bits) * vi_set1(b->n * bytes - size * side);
    const vi z = c->k * vi_set1(side * side) + vi_shr_u(c->k, bits) * vi_set1(b->n * b->n * bytes - size * side * side);
    return x + y + z + vi_set1(shape->below * (1 + side + side * side));
}

VV_INLINE vf brick_value(const vvi_lattice *g, const bricks *b, const brick_shape *shape, vf3 p)
{
    const cell_at c = find_cell(g, p);
    const vi weights = row_weights(g, c.fx), at = brick_place(b, shape, &c);
    vf row[4];
    VV_UNROLL
    for (int r = 0; r < 4; r++) {
        const vi place = at + vi_set1((r & 1) * shape->side + (r >> 1) * shape->side * shape->side);
        row[r] = vf_from_vi(vi_madd16(vi_bytes01(vi_gather(b->data, place, every_lane())), weights));
    }
    const vf v = vf_lerp(vf_lerp(row[0], row[1], c.fy), vf_lerp(row[2], row[3], c.fy), c.fz);
    return v * vf_set1(1.0f / FRACTION_ONE);
}

/* inner_gradient() of lattice_simd.h in bricks: every sample that it takes is in one of them. */
VV_INLINE vf3 brick_gradient(const vvi_lattice *g, const bricks *b, vf3 p)
{
    const brick_shape *shape = &wide_shape;
    const cell_at c = find_cell(g, p);
    const vvi_lattice in_bricks = {.data = b->data};
    const vi weights = row_weights(g, c.fx), at = brick_place(b, shape, &c);
    const vi up_y = vi_set1(shape->side), up_z = vi_set1(shape->side * shape->side);
    const vi at_y = at + up_y, at_z = at + up_z, at_yz = at_y + up_z;
    const vm m = every_lane();
    vi in[2][2];
#define QUAD(place, row) vf_from_vi(quad_differences(&in_bricks, VVI_SAMPLE_U8, place, weights, m, row))
#define ROW(place) vi_madd16(load_pair_16(&in_bricks, VVI_SAMPLE_U8, place, m), weights)
    const vf gx0 = vf_lerp(QUAD(at, &in[0][0]), QUAD(at_y, &in[0][1]), c.fy);
    const vf gx1 = vf_lerp(QUAD(at_z, &in[1][0]), QUAD(at_yz, &in[1][1]), c.fy);
    const vf gy0 = inner_difference(ROW(at - up_y), in[0][0], in[0][1], ROW(at_y + up_y), c.fy);
    const vf gy1 = inner_difference(ROW(at_z - up_y), in[1][0], in[1][1], ROW(at_yz + up_y), c.fy);
    const vf gz0 = inner_difference(ROW(at - up_z), in[0][0], in[1][0], ROW(at_z + up_z), c.fz);
    const vf gz1 = inner_difference(ROW(at_y - up_z), in[0][1], in[1][1], ROW(at_yz + up_z), c.fz);
#undef QUAD
#undef ROW
    const vf scale = vf_set1(0.5f / FRACTION_ONE);
    return vf3_scale((vf3){vf_lerp(gx0, gx1, c.fz), vf_lerp(gy0, gy1, c.fz), vf_lerp(gz0, gz1, c.fy)}, scale);
}

/* The derivative of the trilinear cell, with the value, from the same four gathers. */
VV_INLINE sample sample_cell(const vvi_lattice *g, vf3 p)
{
    const cell_at c = find_cell(g, p);
    const vi weights = row_weights(g, c.fx), minus_plus = vi_set1(0x0001ffff); /* right less left */
    const vi at = c.i + y_offset(g, c.j) + z_offset(g, VVI_SAMPLE_U8, c.k);
    const vi up_y = y_up(g), up_z = z_up(g, VVI_SAMPLE_U8);
    const vi place[4] = {at, at + up_y, at + up_z, at + up_y + up_z};
    vf row[4], dx[4];
    VV_UNROLL
    for (int r = 0; r < 4; r++) {
        const vi pair = load_pair_16(g, VVI_SAMPLE_U8, place[r], every_lane());
        row[r] = vf_from_vi(vi_madd16(pair, weights)) * vf_set1(1.0f / FRACTION_ONE);
        dx[r] = vf_from_vi(vi_madd16(pair, minus_plus));
    }
    const vf low = vf_lerp(row[0], row[1], c.fy), high = vf_lerp(row[2], row[3], c.fy);
    return (sample){vf_lerp(low, high, c.fz),
                    {vf_lerp(vf_lerp(dx[0], dx[1], c.fy), vf_lerp(dx[2], dx[3], c.fy), c.fz),
                     vf_lerp(row[1] - row[0], row[3] - row[2], c.fz), high - low}};
}

/* The lower and the upper halves of two words, interpolated between the words. */
VV_INLINE void lerp_halves(vi left, vi right, vi weights, vf *lower, vf *upper)
{
    const vi high_half = vi_set1((int32_t)0xffff0000);
    *lower = vf_from_vi(vi_madd16((left & vi_set1(0xffff)) | vi_shl(right, 16), weights));
    *upper = vf_from_vi(vi_madd16(vi_shr_u(left, 16) | (right & high_half), weights));
}

/* Value and central differences from the words: eight gathers of 64 bits. */
VV_INLINE sample sample_words(const volume *v, vf3 p)
{
    const vvi_lattice *g = &v->lattice;
    const cell_at c = find_cell(g, p);
    const vi weights = row_weights(g, c.fx);
    const vi at = c.i + y_offset(g, c.j) + z_offset(g, VVI_SAMPLE_U8, c.k);
    const vi up_y = y_up(g), up_z = z_up(g, VVI_SAMPLE_U8);
    const vi place[4] = {at, at + up_y, at + up_z, at + up_y + up_z};
    vf row[4][4]; /* [row][value, x, y, z] */
    VV_UNROLL
    for (int r = 0; r < 4; r++) {
        vi left[2], right[2];
        const vi word = vi_shl(place[r], 1); /* in units of four bytes */
        vi_gather_pair4(v->words, word, every_lane(), &left[0], &left[1]);
        vi_gather_pair4(v->words, word + vi_set1(2), every_lane(), &right[0], &right[1]);
        lerp_halves(left[0], right[0], weights, &row[r][0], &row[r][1]);
        lerp_halves(left[1], right[1], weights, &row[r][2], &row[r][3]);
    }
    vf out[4];
    VV_UNROLL
    for (int a = 0; a < 4; a++)
        out[a] = vf_lerp(vf_lerp(row[0][a], row[1][a], c.fy), vf_lerp(row[2][a], row[3][a], c.fy), c.fz);
    const vf one = vf_set1(1.0f / FRACTION_ONE), half = vf_set1(0.5f / FRACTION_ONE);
    return (sample){out[0] * one, vf3_scale((vf3){out[1], out[2], out[3]}, half)};
}

typedef enum way {
    VALUE_LINEAR,
    VALUE_PADDED,
    VALUE_BRICKS_8,
    VALUE_BRICKS_16,
    GRADIENT_CENTRAL,
    GRADIENT_PADDED,
    GRADIENT_BRICKS,
    GRADIENT_CELL,
    BOTH_CENTRAL,
    BOTH_CELL,
    BOTH_WORDS,
    WAYS
} way;

static const char *const way_name[WAYS] = {
    [VALUE_LINEAR] = "value_linear",
    [VALUE_PADDED] = "value_padded",
    [VALUE_BRICKS_8] = "value_bricks_8",
    [VALUE_BRICKS_16] = "value_bricks_16",
    [GRADIENT_CENTRAL] = "gradient_central",
    [GRADIENT_PADDED] = "gradient_central_padded",
    [GRADIENT_BRICKS] = "gradient_central_bricks_16",
    [GRADIENT_CELL] = "gradient_cell",
    [BOTH_CENTRAL] = "value_and_central",
    [BOTH_CELL] = "value_and_cell",
    [BOTH_WORDS] = "value_and_central_words",
};

/* w is a constant everywhere. */
VV_INLINE sample take_sample(const volume *v, way w, vf3 p)
{
    const vvi_lattice *g = w == VALUE_PADDED || w == GRADIENT_PADDED ? &v->padded : &v->lattice;
    sample s = {vf_set1(0.0f), vf3_set(vf_set1(0.0f), vf_set1(0.0f), vf_set1(0.0f))};
    if (w == VALUE_BRICKS_8)
        s.value = brick_value(g, &v->small, &small_shape, p);
    if (w == VALUE_BRICKS_16)
        s.value = brick_value(g, &v->large, &large_shape, p);
    if (w == VALUE_LINEAR || w == VALUE_PADDED || w == BOTH_CENTRAL)
        s.value = sample_value(g, VVI_SAMPLE_U8, false, p, every_lane());
    if (w == GRADIENT_CENTRAL || w == GRADIENT_PADDED || w == BOTH_CENTRAL) {
        const cell_at c = find_cell(g, p);
        s.gradient = sample_gradient(g, VVI_SAMPLE_U8, &c, every_lane());
    }
    if (w == GRADIENT_BRICKS)
        s.gradient = brick_gradient(g, &v->wide, p);
    if (w == GRADIENT_CELL) {
        const cell_at c = find_cell(g, p);
        s.gradient = cell_gradient(g, VVI_SAMPLE_U8, &c, every_lane());
    }
    if (w == BOTH_CELL)
        s = sample_cell(g, p);
    return w == BOTH_WORDS ? sample_words(v, p) : s;
}

#endif
