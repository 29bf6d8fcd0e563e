#include "segment/runs_kernel.h"
#include "core/simd.h"

/* 64 bytes of 0 and 1 as bits. */
VV_INLINE uint64_t bits_of(const uint8_t m[64])
{
#if defined(VV_ISA_AVX512)
    const __m512i v = _mm512_loadu_si512(m);
    return _mm512_test_epi8_mask(v, v);
#elif defined(VV_ISA_AVX2)
    const __m256i a = _mm256_loadu_si256((const __m256i *)(const void *)m);
    const __m256i b = _mm256_loadu_si256((const __m256i *)(const void *)(m + 32));
    return (uint32_t)_mm256_movemask_epi8(_mm256_slli_epi16(a, 7)) |
           (uint64_t)(uint32_t)_mm256_movemask_epi8(_mm256_slli_epi16(b, 7)) << 32;
#else
    uint64_t word = 0;
    for (int i = 0; i < 8; i++) { /* the product brings bit 0 of byte i to bit 56 + i */
        uint64_t eight;
        memcpy(&eight, m + 8 * i, sizeof eight);
        word |= (eight * 0x0102040810204080 >> 56) << (8 * i);
    }
    return word;
#endif
}

VV_INLINE uint64_t first_bits(int64_t n)
{
    return n >= 64 ? ~(uint64_t)0 : ((uint64_t)1 << n) - 1;
}

/* 64 keys at a time; what is read beyond the row is masked. */
#define OF_KEYS(key, bytes)                                                                                            \
    static void inside_##bytes(uint64_t *bits, const void *keys, int64_t n, int64_t lo, int64_t hi)                    \
    {                                                                                                                  \
        const key *k = keys, least = (key)lo, most = (key)hi;                                                          \
        uint8_t m[64];                                                                                                 \
        for (int64_t at = 0; at < n; at += 64, k += 64) {                                                              \
            for (int i = 0; i < 64; i++)                                                                               \
                m[i] = (uint8_t)((k[i] >= least) & (k[i] <= most));                                                    \
            bits[at / 64] = bits_of(m) & first_bits(n - at);                                                           \
        }                                                                                                              \
    }                                                                                                                  \
    static void differ_##bytes(uint64_t *bits, const void *keys, int64_t n)                                            \
    {                                                                                                                  \
        const key *k = keys;                                                                                           \
        uint8_t m[64];                                                                                                 \
        for (int64_t at = 0; at < n; at += 64, k += 64) {                                                              \
            m[0] = at == 0 || k[0] != k[-1];                                                                           \
            for (int i = 1; i < 64; i++)                                                                               \
                m[i] = k[i] != k[i - 1];                                                                               \
            bits[at / 64] = bits_of(m) & first_bits(n - at);                                                           \
        }                                                                                                              \
    }
OF_KEYS(uint8_t, 1)
OF_KEYS(int16_t, 2)
OF_KEYS(int32_t, 4)
OF_KEYS(int64_t, 8)

static uint32_t starts(uint64_t *out, const uint64_t *inside, const uint64_t *differs, size_t words)
{
    uint64_t carry = 0;
    uint32_t n = 0;
    for (size_t w = 0; w < words; w++) {
        const uint64_t in = inside[w], before = in << 1 | carry;
        out[w] = in & (differs ? differs[w] : ~before);
        n += (uint32_t)__builtin_popcountll(out[w]);
        carry = in >> 63;
    }
    return n;
}

/* Samples before which a run has ended: the one before is inside, and here is none, or another run. */
VV_INLINE uint64_t ends_of(uint64_t inside, uint64_t starts_here, uint64_t carry)
{
    return (inside << 1 | carry) & (starts_here | ~inside);
}

static void ends(int32_t *lo, int32_t *end, const uint64_t *inside, const uint64_t *begin, int64_t n)
{
    const size_t words = (size_t)((n + 63) / 64);
    uint64_t carry = 0;
    for (size_t w = 0; w < words; w++) {
        for (uint64_t left = begin[w]; left; left &= left - 1)
            *lo++ = (int32_t)(64 * w) + __builtin_ctzll(left);
        for (uint64_t left = ends_of(inside[w], begin[w], carry); left; left &= left - 1)
            *end++ = (int32_t)(64 * w) + __builtin_ctzll(left);
        carry = inside[w] >> 63;
    }
    if (carry)
        *end = (int32_t)n; /* in the row's last bit, of a row of whole words */
}

/* Runs that have begun at or before bit x of a word. */
VV_INLINE uint32_t begun(uint64_t begin, int x)
{
    return (uint32_t)__builtin_popcountll(begin & (((uint64_t)2 << x) - 1));
}

VV_INLINE size_t touching(const vvi_run_pairs *out, const vvi_run_bits *a, const vvi_run_bits *b, size_t words,
                          bool corners)
{
    uint64_t carry_a = 0, carry_b = 0;
    uint32_t n_a = a->first - 1, n_b = b->first - 1; /* the last run that has begun; wraps and comes back */
    size_t n = 0;
    for (size_t w = 0; w < words; w++) {
        const uint64_t in_a = a->inside[w], in_b = b->inside[w], s_a = a->starts[w], s_b = b->starts[w];
        const uint64_t both = in_a & in_b, before = (in_a << 1 | carry_a) & (in_b << 1 | carry_b);
        for (uint64_t left = both & (~before | s_a | s_b); left; left &= left - 1) {
            const int x = __builtin_ctzll(left);
            out->a[n] = n_a + begun(s_a, x);
            out->b[n++] = n_b + begun(s_b, x);
        }
        if (corners) {
            for (uint64_t left = s_a & ends_of(in_b, s_b, carry_b); left; left &= left - 1) {
                const int x = __builtin_ctzll(left);
                out->a[n] = n_a + begun(s_a, x);
                out->b[n++] = n_b + begun(s_b, x) - (uint32_t)(s_b >> x & 1);
            }
            for (uint64_t left = s_b & ends_of(in_a, s_a, carry_a); left; left &= left - 1) {
                const int x = __builtin_ctzll(left);
                out->a[n] = n_a + begun(s_a, x) - (uint32_t)(s_a >> x & 1);
                out->b[n++] = n_b + begun(s_b, x);
            }
        }
        n_a += (uint32_t)__builtin_popcountll(s_a);
        n_b += (uint32_t)__builtin_popcountll(s_b);
        carry_a = in_a >> 63;
        carry_b = in_b >> 63;
    }
    return n;
}

static size_t touch_straight(const vvi_run_pairs *out, const vvi_run_bits *a, const vvi_run_bits *b, size_t words)
{
    return touching(out, a, b, words, false);
}

static size_t touch_corners(const vvi_run_pairs *out, const vvi_run_bits *a, const vvi_run_bits *b, size_t words)
{
    return touching(out, a, b, words, true);
}

const vvi_runs_kernels VV_KERNEL_TABLE(vvi_runs_kernels) = {
    .needs = VV_ISA_NEEDS,
    .isa = VV_ISA_NAME,
    .inside = {inside_1, inside_2, inside_4, inside_8},
    .differ = {differ_1, differ_2, differ_4, differ_8},
    .starts = starts,
    .ends = ends,
    .touch = {touch_straight, touch_corners},
};
