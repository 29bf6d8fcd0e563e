#include "surface/marching_kernel.h"
#include "surface/cell.h"
#include "surface/classify_simd.h"

/* Which samples are inside ---------------------------------------------------------------------------------------- */

/* Word w of a row of bits. The last of a row that is no multiple of 64 long is read together with samples before it; a
 * short row is copied first. */
#define WORD(type, above, p, n, w)                                                                                     \
    do {                                                                                                               \
        const int64_t rest = (n)-64 * (w);                                                                             \
        if (rest >= 64) {                                                                                              \
            bits[w] = above((p) + 64 * (w));                                                                           \
        } else if ((n) >= 64) {                                                                                        \
            bits[w] = above((p) + (n)-64) >> (64 - rest);                                                              \
        } else {                                                                                                       \
            type copy[64] = {0};                                                                                       \
            memcpy(copy, p, (size_t)(n) * sizeof copy[0]);                                                             \
            bits[w] = above(copy) & (((uint64_t)1 << rest) - 1);                                                       \
        }                                                                                                              \
    } while (0)

static void shrink(vvi_march_span *span, const uint64_t *bits)
{
    while (span->begin < span->end && !bits[span->begin])
        span->begin++;
    while (span->begin < span->end && !bits[span->end - 1])
        span->end--;
}

#define CLASSIFY(t, type)                                                                                              \
    static void classify_##t(uint64_t *bits, const void *row, int64_t n, const void *threshold, vvi_march_span *span)  \
    {                                                                                                                  \
        const type *p = row;                                                                                           \
        type least;                                                                                                    \
        memcpy(&least, threshold, sizeof least);                                                                       \
        for (int64_t w = span->begin; w < span->end; w++)                                                              \
            WORD(type, ABOVE_##t, p, n, w);                                                                            \
        shrink(span, bits);                                                                                            \
    }
#define ABOVE_u8(p) above64_u8(p, least)
#define ABOVE_u16(p) above64_u16(p, least)
#define ABOVE_i16(p) above64_i16(p, least)
#define ABOVE_f32(p) above64_f32(p, least)
CLASSIFY(u8, uint8_t)
CLASSIFY(u16, uint16_t)
CLASSIFY(i16, int16_t)
CLASSIFY(f32, float)

static bool known(uint64_t *bits, const float *row, int64_t n)
{
    const float *p = row;
    uint64_t missing = 0;
    for (int64_t w = 0; w < (n + 63) >> 6; w++)
        WORD(float, known64, p, n, w);
    for (int64_t w = 0; w < n >> 6; w++)
        missing |= ~bits[w];
    if (n & 63)
        missing |= bits[n >> 6] ^ (((uint64_t)1 << (n & 63)) - 1);
    return !missing;
}

/* Rows of bits ------------------------------------------------------------------------------------------------------
 */

/* Bit i of word w: bit i + 1 of the row, which has a word more than it needs. */
VV_INLINE uint64_t next_bits(const uint64_t *row, int64_t w)
{
    return row[w] >> 1 | row[w + 1] << 63;
}

/* Of the bits 0 to n - 1, those of word w. */
VV_INLINE uint64_t first_bits(int64_t n, int64_t w)
{
    const int64_t rest = n - 64 * w;
    return rest >= 64 ? ~(uint64_t)0 : rest <= 0 ? 0 : ((uint64_t)1 << rest) - 1;
}

static size_t along(uint64_t *out, const uint64_t *row, const uint64_t *known, int64_t n, vvi_march_span span)
{
    size_t count = 0;
    for (int64_t w = span.begin; w < span.end; w++) {
        uint64_t bits = (row[w] ^ next_bits(row, w)) & first_bits(n - 1, w);
        if (known)
            bits &= known[w] & next_bits(known, w);
        out[w] = bits;
        count += (size_t)__builtin_popcountll(bits);
    }
    return count;
}

static size_t between(uint64_t *out, const uint64_t *const row[2], const uint64_t *const known[2], vvi_march_span span)
{
    size_t count = 0;
    for (int64_t w = span.begin; w < span.end; w++) {
        uint64_t bits = row[0][w] ^ row[1][w];
        for (int i = 0; i < 2 && known; i++)
            bits &= known[i][w];
        out[w] = bits;
        count += (size_t)__builtin_popcountll(bits);
    }
    return count;
}

static size_t active(uint64_t *out, const uint64_t *const row[4], const uint64_t *const known[4], int64_t n,
                     vvi_march_span span)
{
    const uint64_t *a = row[0], *b = row[1], *c = row[2], *d = row[3];
    uint64_t any = a[span.begin] | b[span.begin] | c[span.begin] | d[span.begin];
    uint64_t all = a[span.begin] & b[span.begin] & c[span.begin] & d[span.begin];
    size_t count = 0;
    for (int64_t w = span.begin; w < span.end; w++) {
        const uint64_t next_any = a[w + 1] | b[w + 1] | c[w + 1] | d[w + 1];
        const uint64_t next_all = a[w + 1] & b[w + 1] & c[w + 1] & d[w + 1];
        uint64_t bits = (any | any >> 1 | next_any << 63) & ~(all & (all >> 1 | next_all << 63)) & first_bits(n - 1, w);
        for (int i = 0; i < 4 && known; i++)
            bits &= known[i][w] & next_bits(known[i], w);
        out[w] = bits;
        count += (size_t)__builtin_popcountll(bits);
        any = next_any;
        all = next_all;
    }
    return count;
}

static void count(uint32_t out[3], const uint64_t *row, const uint64_t *beyond_y, const uint64_t *beyond_z, int64_t n,
                  vvi_march_span span)
{
    uint32_t x = 0, y = 0, z = 0;
    for (int64_t w = span.begin; w < span.end; w++) {
        x += (uint32_t)__builtin_popcountll((row[w] ^ next_bits(row, w)) & first_bits(n - 1, w));
        y += (uint32_t)__builtin_popcountll(row[w] ^ beyond_y[w]);
        z += (uint32_t)__builtin_popcountll(row[w] ^ beyond_z[w]);
    }
    out[0] = x;
    out[1] = y;
    out[2] = z;
}

/* Vertices ----------------------------------------------------------------------------------------------------------
 */

/* One end of the edge at x of a run, whose neighbours along x are LOW and HIGH. X_TIMES makes their difference twice
 * the gradient. */
#define END(type, number, s, LOW, HIGH, X_TIMES)                                                                       \
    do {                                                                                                               \
        const type *const *row = (const type *const *)r->row[s];                                                       \
        const int32_t i = x + (s & along);                                                                             \
        const number v = row[0][i], gx = (number)(X_TIMES) * ((number)row[0][HIGH] - (number)row[0][LOW]);             \
        const number gy = ((number)row[2][i] - (number)row[1][i]) * (number)r->y_times[s];                             \
        const number gz = ((number)row[4][i] - (number)row[3][i]) * (number)r->z_times[s];                             \
        memcpy(&q->end[s][at], &v, 4);                                                                                 \
        memcpy(&q->gradient[s][0][at], &gx, 4);                                                                        \
        memcpy(&q->gradient[s][1][at], &gy, 4);                                                                        \
        memcpy(&q->gradient[s][2][at], &gz, 4);                                                                        \
    } while (0)
#define LOW_AT_BORDER (i > 0 ? i - 1 : 0)
#define HIGH_AT_BORDER (i < r->nx - 1 ? i + 1 : i)
#define X_TIMES_AT_BORDER (i > 0 && i < r->nx - 1 ? 1 : 2)

/* What n vertices of a run share, from place q->n on. */
VV_INLINE void queue_shared(vvi_march_queue *q, const vvi_march_run *r, int n)
{
    for (int at = q->n; at < q->n + n; at += VV_WIDTH) {
        vf_store(q->place[1] + at, vf_set1(r->y));
        vf_store(q->place[2] + at, vf_set1(r->z));
        vi_store(q->axis + at, vi_set1(r->axis));
    }
}

#define QUEUE(t, type, number, empty)                                                                                  \
    static void queue_##t(vvi_march_queue *q, const vvi_march_run *r, const vvi_march_setup *f)                        \
    {                                                                                                                  \
        const int32_t along = r->axis == 0;                                                                            \
        for (int32_t w = r->span.begin; w < r->span.end; w++) {                                                        \
            const int n = __builtin_popcountll(r->bits[w]);                                                            \
            if (n > VVI_MARCH_QUEUE - q->n)                                                                            \
                empty(q, f);                                                                                           \
            queue_shared(q, r, n);                                                                                     \
            for (uint64_t rest = r->bits[w]; rest; rest &= rest - 1) {                                                 \
                const int32_t at = q->n++, x = 64 * w + __builtin_ctzll(rest);                                         \
                q->place[0][at] = (float)x;                                                                            \
                if (x > 0 && x + 1 + along < r->nx) {                                                                  \
                    END(type, number, 0, i - 1, i + 1, 1);                                                             \
                    END(type, number, 1, i - 1, i + 1, 1);                                                             \
                } else {                                                                                               \
                    END(type, number, 0, LOW_AT_BORDER, HIGH_AT_BORDER, X_TIMES_AT_BORDER);                            \
                    END(type, number, 1, LOW_AT_BORDER, HIGH_AT_BORDER, X_TIMES_AT_BORDER);                            \
                }                                                                                                      \
            }                                                                                                          \
        }                                                                                                              \
    }

#define LOAD_INT(p) vf_from_vi(vi_load(p))
#define LOAD_FLOAT(p) vf_min(vf_max(vf_bits(vi_load(p)), vf_set1(-FLT_MAX)), vf_set1(FLT_MAX)) /* infinite samples */

/* Never quite an end: every triangle has an area. What is not finite takes the middle. The difference of two floats may
 * be too large for one. */
VV_INLINE vf crossing(vf iso, vf a, vf b)
{
    const vf whole = b - a;
    const vf unit = vf_select(vf_lt(vf_set1(FLT_MAX), vf_max(whole, vf_set1(0) - whole)), vf_set1(0.25f), vf_set1(1));
    const vf t = (iso * unit - a * unit) / (b * unit - a * unit), least = vf_set1(1e-6f), most = vf_set1(1 - 1e-6f);
    return vf_select(vf_eq(t, t), vf_min(vf_max(t, least), most), vf_set1(0.5f));
}

VV_INLINE void store3_lanes(float *out, const vf v[3], int lanes)
{
    float lane[3][VV_WIDTH];
    for (int a = 0; a < 3; a++)
        vf_store(lane[a], v[a]);
    for (int l = 0; l < lanes; l++)
        for (int a = 0; a < 3; a++)
            out[3 * l + a] = lane[a][l];
}

/* x y z of one lane after the other. */
VV_INLINE void store3(float *out, const vf v[3], int lanes)
{
#if defined(VV_ISA_AVX512)
    if (lanes ==
        VV_WIDTH) { /* place 16 i + j holds axis (16 i + j) % 3 of lane (16 i + j) / 3; + 16: of y; z comes second */
        const __m512i xy[3] = {_mm512_setr_epi32(0, 16, 0, 1, 17, 0, 2, 18, 0, 3, 19, 0, 4, 20, 0, 5),
                               _mm512_setr_epi32(21, 0, 6, 22, 0, 7, 23, 0, 8, 24, 0, 9, 25, 0, 10, 26),
                               _mm512_setr_epi32(0, 11, 27, 0, 12, 28, 0, 13, 29, 0, 14, 30, 0, 15, 31, 0)};
        const __m512i with_z[3] = {_mm512_setr_epi32(0, 1, 16, 3, 4, 17, 6, 7, 18, 9, 10, 19, 12, 13, 20, 15),
                                   _mm512_setr_epi32(0, 21, 2, 3, 22, 5, 6, 23, 8, 9, 24, 11, 12, 25, 14, 15),
                                   _mm512_setr_epi32(26, 1, 2, 27, 4, 5, 28, 7, 8, 29, 10, 11, 30, 13, 14, 31)};
        VV_UNROLL
        for (int i = 0; i < 3; i++)
            vf_store(out + 16 * i, _mm512_permutex2var_ps(_mm512_permutex2var_ps(v[0], xy[i], v[1]), with_z[i], v[2]));
        return;
    }
#endif
    store3_lanes(out, v, lanes);
}

VV_INLINE void store_positions(float *out, const vvi_march_queue *q, const vvi_march_setup *f, int at, int lanes, vf t)
{
    const vi axis = vi_load(q->axis + at);
    vf p[3], world[3];
    for (int a = 0; a < 3; a++)
        p[a] = vf_load(q->place[a] + at) + vf_select(vi_eq(axis, vi_set1(a)), t, vf_set1(0));
    for (int a = 0; a < 3; a++) {
        const float *m = f->to_world[a];
        world[a] = vf_fma(vf_set1(m[0]), p[0], vf_fma(vf_set1(m[1]), p[1], vf_fma(vf_set1(m[2]), p[2], vf_set1(m[3]))));
    }
    store3(out, world, lanes);
}

/* Zero where there is no gradient. Bit l: lane l is such. */
VV_INLINE uint32_t store_normals(float *out, const vvi_march_setup *f, int lanes, const vf g[3])
{
    vf n[3];
    for (int a = 0; a < 3; a++) {
        const float *m = f->to_normal[a];
        n[a] = vf_fma(vf_set1(m[0]), g[0], vf_fma(vf_set1(m[1]), g[1], vf_set1(m[2]) * g[2]));
    }
    const vf square = vf_fma(n[0], n[0], vf_fma(n[1], n[1], n[2] * n[2]));
    const vm some = vm_and(vf_lt(vf_set1(1e-30f), square), vf_lt(square, vf_set1(1e37f)));
    const vf scale = vf_select(some, vf_set1(1.0f) / vf_sqrt(square), vf_set1(0.0f));
    for (int a = 0; a < 3; a++)
        n[a] = vf_select(some, n[a] * scale, vf_set1(0.0f));
    store3(out, n, lanes);
    return ~vm_bits(some) & (((uint32_t)1 << lanes) - 1);
}

#define EMPTY(name, LOAD)                                                                                              \
    static void name(vvi_march_queue *q, const vvi_march_setup *f)                                                     \
    {                                                                                                                  \
        const vf iso = vf_set1(f->iso);                                                                                \
        for (int at = 0; at < q->n; at += VV_WIDTH) {                                                                  \
            const int lanes = q->n - at < VV_WIDTH ? q->n - at : VV_WIDTH;                                             \
            const size_t out = 3 * ((size_t)q->first + (size_t)at);                                                    \
            const vf t = crossing(iso, LOAD(q->end[0] + at), LOAD(q->end[1] + at));                                    \
            store_positions(f->position + out, q, f, at, lanes, t);                                                    \
            if (!f->normal)                                                                                            \
                continue;                                                                                              \
            vf g[3];                                                                                                   \
            for (int a = 0; a < 3; a++) {                                                                              \
                const vf low = LOAD(q->gradient[0][a] + at), high = LOAD(q->gradient[1][a] + at);                      \
                g[a] = vf_fma(t, high - low, low);                                                                     \
            }                                                                                                          \
            q->missing |= store_normals(f->normal + out, f, lanes, g) != 0;                                            \
        }                                                                                                              \
        q->first += (uint32_t)q->n;                                                                                    \
        q->n = 0;                                                                                                      \
    }
EMPTY(empty_int, LOAD_INT)
EMPTY(empty_float, LOAD_FLOAT)
QUEUE(u8, uint8_t, int32_t, empty_int)
QUEUE(u16, uint16_t, int32_t, empty_int)
QUEUE(i16, int16_t, int32_t, empty_int)
QUEUE(f32, float, float, empty_float)

/* Cells --------------------------------------------------------------------------------------------------------- */

/* The patterns of 64 cells: bit c of each from word c. */
VV_INLINE void patterns_of(uint8_t out[64], const uint64_t corner[8])
{
#if defined(VV_ISA_AVX512)
    __m512i all = _mm512_setzero_si512();
    VV_UNROLL
    for (int c = 0; c < 8; c++)
        all = _mm512_or_si512(all, _mm512_maskz_set1_epi8(corner[c], (char)(1 << c)));
    _mm512_storeu_si512(out, all);
#else
    for (int byte = 0; byte < 8; byte++) { /* a square of 8 x 8 bits is turned (Warren, Hacker's Delight, 7-3) */
        uint64_t x = 0;
        for (int c = 0; c < 8; c++)
            x |= (corner[c] >> 8 * byte & 255) << 8 * c;
        uint64_t t = (x ^ (x >> 7)) & 0x00aa00aa00aa00aau;
        x ^= t ^ (t << 7);
        t = (x ^ (x >> 14)) & 0x0000cccc0000ccccu;
        x ^= t ^ (t << 14);
        t = (x ^ (x >> 28)) & 0x00000000f0f0f0f0u;
        x ^= t ^ (t << 28);
        memcpy(out + 8 * byte, &x, 8);
    }
#endif
}

VV_INLINE void corners_of_word(uint64_t corner[8], const vvi_march_cells *c, size_t w)
{
    for (int i = 0; i < 4; i++) {
        corner[2 * i] = c->inside[i][w];
        corner[2 * i + 1] = next_bits(c->inside[i], (int64_t)w);
    }
}

/* The corners of a cell, less the value of the surface. */
#define CORNERS(t, type)                                                                                               \
    VV_INLINE void corners_##t(float v[8], const vvi_march_cells *c, size_t x)                                         \
    {                                                                                                                  \
        for (size_t i = 0; i < 8; i++)                                                                                 \
            v[i] = (float)((const type *)c->samples[i >> 1])[x + (i & 1)] - c->frame->iso;                             \
    }
CORNERS(u8, uint8_t)
CORNERS(u16, uint16_t)
CORNERS(i16, int16_t)
VV_INLINE void corners_f32(float v[8], const vvi_march_cells *c, size_t x)
{
    for (size_t i = 0; i < 8; i++)
        v[i] = vvi_cell_corner(((const float *)c->samples[i >> 1])[x + (i & 1)] - c->frame->iso);
}

/* How many bits are set before bit x. */
static uint32_t rank(const uint64_t *row, size_t x)
{
    uint32_t n = 0;
    for (size_t w = 0; w < x >> 6; w++)
        n += (uint32_t)__builtin_popcountll(row[w]);
    return n + (uint32_t)__builtin_popcountll(row[x >> 6] & (((uint64_t)1 << (x & 63)) - 1));
}

static void put_slowly(vvi_march_cells *c, const vvi_case_quick *k, const vvi_case *whole, const uint32_t first[8])
{
    static const uint8_t counter[12] = {0, 1, 2, 3, 4, 4, 5, 5, 6, 6, 7, 7};
    uint32_t number[13];
    for (int e = 0; e < 12; e++)
        number[e] = first[counter[e]] + k->ahead[e];
    number[12] = c->first_interior;
    for (int i = 0; i < 3 * k->n_triangles; i++)
        *c->triangle++ = number[whole->triangle[i]];
}

#if defined(VV_ISA_AVX512)
VV_INLINE __m512i widen(const uint8_t p[16])
{
    return _mm512_cvtepu8_epi32(_mm_loadu_si128((const __m128i *)(const void *)p));
}
VV_INLINE void put_triangles(vvi_march_cells *c, const vvi_case_quick *k, const vvi_case *whole)
{
    if (k->n_triangles > 5 || c->end - c->triangle < 16) {
        put_slowly(c, k, whole, c->first);
        return;
    }
    const __m512i counter = _mm512_setr_epi32(0, 1, 2, 3, 4, 4, 5, 5, 6, 6, 7, 7, 0, 0, 0, 0);
    const __m256i first = _mm256_loadu_si256((const __m256i *)(const void *)c->first);
    const __m512i number = _mm512_permutexvar_epi32(counter, _mm512_castsi256_si512(first));
    const __m512i id = _mm512_add_epi32(number, widen(k->ahead));
    _mm512_storeu_si512(c->triangle, _mm512_permutexvar_epi32(widen(k->triangle), id)); /* the rest is written over */
    c->triangle += 3 * k->n_triangles;
}
VV_INLINE void step_over(uint32_t first[8], const uint8_t step[8])
{
    const __m256i by = _mm256_cvtepu8_epi32(_mm_loadl_epi64((const __m128i *)(const void *)step));
    __m256i *at = (__m256i *)(void *)first;
    _mm256_storeu_si256(at, _mm256_add_epi32(_mm256_loadu_si256(at), by));
}
#else
VV_INLINE void put_triangles(vvi_march_cells *c, const vvi_case_quick *k, const vvi_case *whole)
{
    put_slowly(c, k, whole, c->first);
}
VV_INLINE void step_over(uint32_t first[8], const uint8_t step[8])
{
    for (int i = 0; i < 8; i++)
        first[i] += step[i];
}
#endif

static void put_by_rank(vvi_march_cells *c, const vvi_case_quick *k, const vvi_case *whole, size_t x)
{
    uint32_t first[8];
    for (int i = 0; i < 8; i++)
        first[i] = c->first[i] + rank(c->crossed[i], x);
    put_slowly(c, k, whole, first);
}

static void put_interior(vvi_march_cells *c, const vvi_case *k, const float v[8], size_t x)
{
    const float cell[3] = {(float)x, c->y, c->z};
    c->missing |= !vvi_cell_put_interior(c->frame, c->first_interior++, v, k->around[0], cell);
}

/* The active cells of a row, word by word: `patterns` are theirs. */
#define EACH_WORD(c, w, patterns)                                                                                      \
    for (size_t w = (c)->span.begin; w < (c)->span.end; w++)                                                           \
        if ((c)->active[w] && (patterns_of_word(patterns, c, w), true))

VV_INLINE void patterns_of_word(uint8_t out[64], const vvi_march_cells *c, size_t w)
{
    uint64_t corner[8];
    corners_of_word(corner, c, w);
    patterns_of(out, corner);
}

/* The case of the cell at x, and its corners where it has more than one. */
#define CASE(t)                                                                                                        \
    VV_INLINE unsigned case_##t(float v[8], const vvi_march_cells *c, unsigned pattern, size_t x)                      \
    {                                                                                                                  \
        if (!vvi_case_ambiguous[pattern] || !c->samples[0])                                                            \
            return vvi_case_first[pattern];                                                                            \
        corners_##t(v, c, x);                                                                                          \
        return vvi_case_first[pattern] + vvi_cell_decide(v, pattern);                                                  \
    }

/* Every crossed edge belongs to an active cell of each row beside it, so that counting in active cells counts all. */
#define COUNT_CELLS(t)                                                                                                 \
    static void count_cells_##t(vvi_march_cells *c)                                                                    \
    {                                                                                                                  \
        uint8_t patterns[64];                                                                                          \
        uint32_t sum = 0, n_interior = 0;                                                                              \
        EACH_WORD(c, w, patterns)                                                                                      \
        {                                                                                                              \
            for (uint64_t rest = c->active[w]; rest; rest &= rest - 1) {                                               \
                const unsigned bit = (unsigned)__builtin_ctzll(rest), pattern = patterns[bit];                         \
                float v[8];                                                                                            \
                if (vvi_case_triangles[pattern] != VVI_CASE_AMBIGUOUS) {                                               \
                    sum += vvi_case_triangles[pattern];                                                                \
                } else {                                                                                               \
                    const vvi_case_quick *k = &vvi_cases_quick[case_##t(v, c, pattern, 64 * w + bit)];                 \
                    sum += k->n_triangles;                                                                             \
                    n_interior += k->n_interior;                                                                       \
                }                                                                                                      \
            }                                                                                                          \
        }                                                                                                              \
        c->n_triangles += sum;                                                                                         \
        c->n_interior += n_interior;                                                                                   \
    }

#define CELLS(t)                                                                                                       \
    static void cells_##t(vvi_march_cells *c)                                                                          \
    {                                                                                                                  \
        uint8_t patterns[64];                                                                                          \
        EACH_WORD(c, w, patterns)                                                                                      \
        {                                                                                                              \
            for (uint64_t rest = c->active[w]; rest; rest &= rest - 1) {                                               \
                const unsigned bit = (unsigned)__builtin_ctzll(rest);                                                  \
                const size_t x = 64 * w + bit;                                                                         \
                float v[8] = {0};                                                                                      \
                const unsigned at = case_##t(v, c, patterns[bit], x);                                                  \
                const vvi_case_quick *k = &vvi_cases_quick[at];                                                        \
                if (c->crossed[0]) {                                                                                   \
                    put_by_rank(c, k, &vvi_cases[at], x);                                                              \
                } else {                                                                                               \
                    put_triangles(c, k, &vvi_cases[at]);                                                               \
                    step_over(c->first, k->step);                                                                      \
                }                                                                                                      \
                if (k->n_interior)                                                                                     \
                    put_interior(c, &vvi_cases[at], v, x);                                                             \
            }                                                                                                          \
        }                                                                                                              \
    }

#define OF_CELLS(t) CASE(t) COUNT_CELLS(t) CELLS(t)
OF_CELLS(u8)
OF_CELLS(u16)
OF_CELLS(i16)
OF_CELLS(f32)

const vvi_march_kernels VV_KERNEL_TABLE(vvi_march_kernels) = {
    .needs = VV_ISA_NEEDS,
    .isa = VV_ISA_NAME,
    .classify = {classify_u8, classify_u16, classify_i16, classify_f32},
    .known = known,
    .along = along,
    .between = between,
    .active = active,
    .count = count,
    .queue = {queue_u8, queue_u16, queue_i16, queue_f32},
    .empty = {empty_int, empty_int, empty_int, empty_float},
    .count_cells = {count_cells_u8, count_cells_u16, count_cells_i16, count_cells_f32},
    .cells = {cells_u8, cells_u16, cells_i16, cells_f32},
};
