/** @file
 * Vectors of VV_WIDTH lanes for kernels: vf (float), vi (int32), vm (mask). One source, compiled once per instruction
 * set with VV_ISA naming it; width 1 (VV_ISA_SCALAR) is plain C.
 *
 * + - * / on vf and + - * & | ^ << >> on vi are the language's own operators. Everything else is a named function here.
 * Only kernel sources include this file: all of it is static inline, so no copy built with wide instructions can be
 * linked into code that runs everywhere.
 */
#ifndef VVI_CORE_SIMD_H
#define VVI_CORE_SIMD_H
#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <string.h>

#define VV_INLINE static inline __attribute__((always_inline))
/** Before a loop of at most 16 turns over vectors: no loop, so that they stay in registers. */
#ifdef __clang__
#define VV_UNROLL _Pragma("unroll")
#else
#define VV_UNROLL _Pragma("GCC unroll 16")
#endif
#define VV_PASTE_(a, b) a##_##b
#define VV_PASTE(a, b) VV_PASTE_(a, b)
/** The name of a kernel table in this build: VV_KERNEL_TABLE(vvi_sample_kernels) is vvi_sample_kernels_avx2. */
#define VV_KERNEL_TABLE(name) VV_PASTE(name, VV_ISA)
#define VV_STRING_(a) #a
#define VV_STRING(a) VV_STRING_(a)
#define VV_ISA_NAME VV_STRING(VV_ISA)

/* A table of one-line functions reads better than pages of braces. */
/* clang-format off */
#if defined(VV_ISA_AVX512)
/* ------------------------------------------------------------------------------------------------ 16 lanes, AVX-512 */
#include <immintrin.h>
#define VV_WIDTH 16
#define VV_ISA_NEEDS 3u /* VVI_CPU_AVX2 | VVI_CPU_AVX512 */
typedef __m512 vf;
typedef int32_t vi __attribute__((vector_size(64)));
typedef __mmask16 vm;
#define I512(a) ((__m512i)(a))

VV_INLINE vf vf_set1(float a) { return _mm512_set1_ps(a); }
VV_INLINE vi vi_set1(int32_t a) { return (vi)_mm512_set1_epi32(a); }
VV_INLINE vf vf_load(const float *p) { return _mm512_loadu_ps(p); }
VV_INLINE void vf_store(float *p, vf a) { _mm512_storeu_ps(p, a); }
VV_INLINE vi vi_load(const int32_t *p) { return (vi)_mm512_loadu_si512(p); }
VV_INLINE void vi_store(int32_t *p, vi a) { _mm512_storeu_si512(p, I512(a)); }
VV_INLINE vf vf_fma(vf a, vf b, vf c) { return _mm512_fmadd_ps(a, b, c); }
VV_INLINE vf vf_min(vf a, vf b) { return _mm512_min_ps(a, b); }
VV_INLINE vf vf_max(vf a, vf b) { return _mm512_max_ps(a, b); }
VV_INLINE vf vf_sqrt(vf a) { return _mm512_sqrt_ps(a); }
VV_INLINE vf vf_floor(vf a) { return _mm512_roundscale_ps(a, _MM_FROUND_TO_NEG_INF | _MM_FROUND_NO_EXC); }
VV_INLINE vf vf_abs(vf a) { return _mm512_abs_ps(a); }
VV_INLINE vi vi_min(vi a, vi b) { return (vi)_mm512_min_epi32(I512(a), I512(b)); }
VV_INLINE vi vi_max(vi a, vi b) { return (vi)_mm512_max_epi32(I512(a), I512(b)); }
VV_INLINE vi vi_trunc(vf a) { return (vi)_mm512_cvttps_epi32(a); }
VV_INLINE vf vf_from_vi(vi a) { return _mm512_cvtepi32_ps(I512(a)); }
VV_INLINE vf vf_bits(vi a) { return (vf)a; }
VV_INLINE vi vi_bits(vf a) { return (vi)a; }
VV_INLINE vi vi_shr_u(vi a, int n) { return (vi)_mm512_srli_epi32(I512(a), (unsigned)n); }
VV_INLINE vi vi_shl(vi a, int n) { return (vi)_mm512_slli_epi32(I512(a), (unsigned)n); }
VV_INLINE vi vi_shr_by(vi a, int n) { return (vi)_mm512_sra_epi32(I512(a), _mm_cvtsi32_si128(n)); }
VV_INLINE vm vf_lt(vf a, vf b) { return _mm512_cmp_ps_mask(a, b, _CMP_LT_OQ); }
VV_INLINE vm vf_le(vf a, vf b) { return _mm512_cmp_ps_mask(a, b, _CMP_LE_OQ); }
VV_INLINE vm vf_eq(vf a, vf b) { return _mm512_cmp_ps_mask(a, b, _CMP_EQ_OQ); }
VV_INLINE vm vi_lt(vi a, vi b) { return _mm512_cmplt_epi32_mask(I512(a), I512(b)); }
VV_INLINE vm vi_eq(vi a, vi b) { return _mm512_cmpeq_epi32_mask(I512(a), I512(b)); }
VV_INLINE vf vf_select(vm m, vf yes, vf no) { return _mm512_mask_blend_ps(m, no, yes); }
VV_INLINE vi vi_select(vm m, vi yes, vi no) { return (vi)_mm512_mask_blend_epi32(m, I512(no), I512(yes)); }
VV_INLINE vm vm_and(vm a, vm b) { return (vm)(a & b); }
VV_INLINE vm vm_or(vm a, vm b) { return (vm)(a | b); }
VV_INLINE vm vm_andnot(vm a, vm b) { return (vm)(a & ~b); } /* a and not b */
VV_INLINE uint32_t vm_bits(vm a) { return a; }
VV_INLINE vm vm_from_bits(uint32_t b) { return (vm)b; }
/* 32-bit words at base + offset bytes; any alignment. Lanes off the mask read nothing and give 0. */
VV_INLINE vi vi_gather(const void *base, vi offset, vm m)
{
    return (vi)_mm512_mask_i32gather_epi32(_mm512_setzero_si512(), m, I512(offset), base, 1);
}
VV_INLINE vi vi_gather2(const void *base, vi index, vm m) /* offsets of 2 bytes */
{
    return (vi)_mm512_mask_i32gather_epi32(_mm512_setzero_si512(), m, I512(index), base, 2);
}
VV_INLINE vf vf_gather4(const float *base, vi index, vm m) /* base[index] */
{
    return _mm512_mask_i32gather_ps(_mm512_setzero_ps(), m, I512(index), base, 4);
}
/* Four numbers at base + index of each lane, turned into four vectors; every lane's are read. Half the work of four
 * gathers, and less where gathers are slow. */
VV_INLINE void vf_rows4(vf out[4], const float *base, vi index)
{
    uint32_t at[16];
    __m512 z[4];
    _mm512_storeu_si512(at, I512(index));
    VV_UNROLL
    for (int i = 0; i < 4; i++) {
        z[i] = _mm512_castps128_ps512(_mm_loadu_ps(base + at[i]));
        z[i] = _mm512_mask_broadcast_f32x4(z[i], 0x00f0, _mm_loadu_ps(base + at[i + 4]));
        z[i] = _mm512_mask_broadcast_f32x4(z[i], 0x0f00, _mm_loadu_ps(base + at[i + 8]));
        z[i] = _mm512_mask_broadcast_f32x4(z[i], 0xf000, _mm_loadu_ps(base + at[i + 12]));
    }
    const __m512 a = _mm512_unpacklo_ps(z[0], z[1]), b = _mm512_unpacklo_ps(z[2], z[3]);
    const __m512 c = _mm512_unpackhi_ps(z[0], z[1]), d = _mm512_unpackhi_ps(z[2], z[3]);
    out[0] = _mm512_shuffle_ps(a, b, 0x44);
    out[1] = _mm512_shuffle_ps(a, b, 0xee);
    out[2] = _mm512_shuffle_ps(c, d, 0x44);
    out[3] = _mm512_shuffle_ps(c, d, 0xee);
}
/* Words of 64 bits at base + index * scale bytes, as their low and high halves. */
VV_INLINE void split512(__m512d low8, __m512d high8, vi *low, vi *high)
{
    const __m512i even = _mm512_setr_epi32(0, 2, 4, 6, 8, 10, 12, 14, 16, 18, 20, 22, 24, 26, 28, 30);
    const __m512i odd = _mm512_setr_epi32(1, 3, 5, 7, 9, 11, 13, 15, 17, 19, 21, 23, 25, 27, 29, 31);
    *low = (vi)_mm512_permutex2var_epi32((__m512i)low8, even, (__m512i)high8);
    *high = (vi)_mm512_permutex2var_epi32((__m512i)low8, odd, (__m512i)high8);
}
#define GATHER_PAIR(name, scale) \
    VV_INLINE void name(const void *base, vi index, vm m, vi *low, vi *high) \
    { \
        const __m512d z = _mm512_setzero_pd(); \
        const __m256i i0 = _mm512_castsi512_si256(I512(index)), i1 = _mm512_extracti64x4_epi64(I512(index), 1); \
        const __m512d a = _mm512_mask_i32gather_pd(z, (__mmask8)m, i0, base, scale); \
        const __m512d b = _mm512_mask_i32gather_pd(z, (__mmask8)(m >> 8), i1, base, scale); \
        split512(a, b, low, high); \
    }
VV_INLINE vf vf_permute(vf table, vi lane) { return _mm512_permutexvar_ps(I512(lane), table); }
/* Lanes as two signed numbers of 16 bits: the sum of their products; and their lower two bytes as such numbers. */
VV_INLINE vi vi_madd16(vi a, vi b) { return (vi)_mm512_madd_epi16(I512(a), I512(b)); }
VV_INLINE vi vi_bytes01(vi a)
{
    const __m512i at = _mm512_set4_epi32((int)0x800d800c, (int)0x80098008, (int)0x80058004, (int)0x80018000);
    return (vi)_mm512_shuffle_epi8(I512(a), at);
}
/* The lanes in m, moved together, at p; writes VV_WIDTH numbers. */
VV_INLINE void vf_compress(float *p, vf a, vm m) { _mm512_storeu_ps(p, _mm512_maskz_compress_ps(m, a)); }
VV_INLINE void vi_compress(int32_t *p, vi a, vm m) { _mm512_storeu_si512(p, _mm512_maskz_compress_epi32(m, I512(a))); }
/* The numbers at p, one for each lane in m; 0 in the others. Reads VV_WIDTH numbers. */
VV_INLINE vf vf_expand(const float *p, vm m) { return _mm512_maskz_expand_ps(m, _mm512_loadu_ps(p)); }

#elif defined(VV_ISA_AVX2)
/* ---------------------------------------------------------------------------------------------------- 8 lanes, AVX2 */
#include <immintrin.h>
#define VV_WIDTH 8
#define VV_ISA_NEEDS 1u /* VVI_CPU_AVX2 */
typedef __m256 vf;
typedef int32_t vi __attribute__((vector_size(32)));
typedef int32_t vm __attribute__((vector_size(32)));
#define I256(a) ((__m256i)(a))

VV_INLINE vf vf_set1(float a) { return _mm256_set1_ps(a); }
VV_INLINE vi vi_set1(int32_t a) { return (vi)_mm256_set1_epi32(a); }
VV_INLINE vf vf_load(const float *p) { return _mm256_loadu_ps(p); }
VV_INLINE void vf_store(float *p, vf a) { _mm256_storeu_ps(p, a); }
VV_INLINE vi vi_load(const int32_t *p) { return (vi)_mm256_loadu_si256((const __m256i *)(const void *)p); }
VV_INLINE void vi_store(int32_t *p, vi a) { _mm256_storeu_si256((__m256i *)(void *)p, I256(a)); }
VV_INLINE vf vf_fma(vf a, vf b, vf c) { return _mm256_fmadd_ps(a, b, c); }
VV_INLINE vf vf_min(vf a, vf b) { return _mm256_min_ps(a, b); }
VV_INLINE vf vf_max(vf a, vf b) { return _mm256_max_ps(a, b); }
VV_INLINE vf vf_sqrt(vf a) { return _mm256_sqrt_ps(a); }
VV_INLINE vf vf_floor(vf a) { return _mm256_floor_ps(a); }
VV_INLINE vf vf_abs(vf a) { return _mm256_and_ps(a, (vf)vi_set1(0x7fffffff)); }
VV_INLINE vi vi_min(vi a, vi b) { return (vi)_mm256_min_epi32(I256(a), I256(b)); }
VV_INLINE vi vi_max(vi a, vi b) { return (vi)_mm256_max_epi32(I256(a), I256(b)); }
VV_INLINE vi vi_trunc(vf a) { return (vi)_mm256_cvttps_epi32(a); }
VV_INLINE vf vf_from_vi(vi a) { return _mm256_cvtepi32_ps(I256(a)); }
VV_INLINE vf vf_bits(vi a) { return (vf)a; }
VV_INLINE vi vi_bits(vf a) { return (vi)a; }
VV_INLINE vi vi_shr_u(vi a, int n) { return (vi)_mm256_srli_epi32(I256(a), n); }
VV_INLINE vi vi_shl(vi a, int n) { return (vi)_mm256_slli_epi32(I256(a), n); }
VV_INLINE vi vi_shr_by(vi a, int n) { return (vi)_mm256_sra_epi32(I256(a), _mm_cvtsi32_si128(n)); }
VV_INLINE vm vf_lt(vf a, vf b) { return (vm)_mm256_cmp_ps(a, b, _CMP_LT_OQ); }
VV_INLINE vm vf_le(vf a, vf b) { return (vm)_mm256_cmp_ps(a, b, _CMP_LE_OQ); }
VV_INLINE vm vf_eq(vf a, vf b) { return (vm)_mm256_cmp_ps(a, b, _CMP_EQ_OQ); }
VV_INLINE vm vi_lt(vi a, vi b) { return a < b; }
VV_INLINE vm vi_eq(vi a, vi b) { return a == b; }
VV_INLINE vf vf_select(vm m, vf yes, vf no) { return _mm256_blendv_ps(no, yes, (vf)m); }
VV_INLINE vi vi_select(vm m, vi yes, vi no) { return (vi)_mm256_blendv_epi8(I256(no), I256(yes), I256(m)); }
VV_INLINE vm vm_and(vm a, vm b) { return a & b; }
VV_INLINE vm vm_or(vm a, vm b) { return a | b; }
VV_INLINE vm vm_andnot(vm a, vm b) { return a & ~b; }
VV_INLINE uint32_t vm_bits(vm a) { return (uint32_t)_mm256_movemask_ps((vf)a); }
VV_INLINE vm vm_from_bits(uint32_t b)
{
    const vi lane = {1, 2, 4, 8, 16, 32, 64, 128};
    return (vi_set1((int32_t)b) & lane) == lane;
}
VV_INLINE vi vi_gather(const void *base, vi offset, vm m)
{
    return (vi)_mm256_mask_i32gather_epi32(_mm256_setzero_si256(), base, I256(offset), I256(m), 1);
}
VV_INLINE vi vi_gather2(const void *base, vi index, vm m)
{
    return (vi)_mm256_mask_i32gather_epi32(_mm256_setzero_si256(), base, I256(index), I256(m), 2);
}
VV_INLINE vf vf_gather4(const float *base, vi index, vm m)
{
    return _mm256_mask_i32gather_ps(_mm256_setzero_ps(), base, I256(index), (vf)m, 4);
}
VV_INLINE void vf_rows4(vf out[4], const float *base, vi index)
{
    uint32_t at[8];
    __m256 z[4];
    _mm256_storeu_si256((__m256i *)(void *)at, I256(index));
    VV_UNROLL
    for (int i = 0; i < 4; i++)
        z[i] = _mm256_insertf128_ps(_mm256_castps128_ps256(_mm_loadu_ps(base + at[i])), _mm_loadu_ps(base + at[i + 4]), 1);
    const __m256 a = _mm256_unpacklo_ps(z[0], z[1]), b = _mm256_unpacklo_ps(z[2], z[3]);
    const __m256 c = _mm256_unpackhi_ps(z[0], z[1]), d = _mm256_unpackhi_ps(z[2], z[3]);
    out[0] = _mm256_shuffle_ps(a, b, 0x44);
    out[1] = _mm256_shuffle_ps(a, b, 0xee);
    out[2] = _mm256_shuffle_ps(c, d, 0x44);
    out[3] = _mm256_shuffle_ps(c, d, 0xee);
}
VV_INLINE void split256(__m256d low4, __m256d high4, vi *low, vi *high)
{
    const __m256 a = _mm256_shuffle_ps((__m256)low4, (__m256)high4, 0x88); /* evens: 0 1 4 5 2 3 6 7 */
    const __m256 b = _mm256_shuffle_ps((__m256)low4, (__m256)high4, 0xdd);
    *low = (vi)_mm256_permute4x64_epi64((__m256i)a, 0xd8);
    *high = (vi)_mm256_permute4x64_epi64((__m256i)b, 0xd8);
}
#define GATHER_PAIR(name, scale) \
    VV_INLINE void name(const void *base, vi index, vm m, vi *low, vi *high) \
    { \
        const __m256d z = _mm256_setzero_pd(); \
        const __m128i i0 = _mm256_castsi256_si128(I256(index)), i1 = _mm256_extracti128_si256(I256(index), 1); \
        const __m256d m0 = (__m256d)_mm256_cvtepi32_epi64(_mm256_castsi256_si128(I256(m))); \
        const __m256d m1 = (__m256d)_mm256_cvtepi32_epi64(_mm256_extracti128_si256(I256(m), 1)); \
        const __m256d a = _mm256_mask_i32gather_pd(z, base, i0, m0, scale); \
        const __m256d b = _mm256_mask_i32gather_pd(z, base, i1, m1, scale); \
        split256(a, b, low, high); \
    }
VV_INLINE vf vf_permute(vf table, vi lane) { return _mm256_permutevar8x32_ps(table, I256(lane)); }
VV_INLINE vi vi_madd16(vi a, vi b) { return (vi)_mm256_madd_epi16(I256(a), I256(b)); }
VV_INLINE vi vi_bytes01(vi a)
{
    const __m256i at = _mm256_setr_epi32((int)0x80018000, (int)0x80058004, (int)0x80098008, (int)0x800d800c,
                                         (int)0x80018000, (int)0x80058004, (int)0x80098008, (int)0x800d800c);
    return (vi)_mm256_shuffle_epi8(I256(a), at);
}
/* Numbers of the lanes in m, in order, as indices for a permutation. */
VV_INLINE __m256i packed_lanes(vm m)
{
    const uint64_t bytes = _pdep_u64(vm_bits(m), 0x0101010101010101u) * 255;
    return _mm256_cvtepu8_epi32(_mm_cvtsi64_si128((long long)_pext_u64(0x0706050403020100u, bytes)));
}
VV_INLINE vf vf_expand(const float *p, vm m)
{
    const uint64_t bytes = _pdep_u64(vm_bits(m), 0x0101010101010101u) * 255;
    const __m256i from = _mm256_cvtepu8_epi32(_mm_cvtsi64_si128((long long)_pdep_u64(0x0706050403020100u, bytes)));
    return _mm256_and_ps(_mm256_permutevar8x32_ps(_mm256_loadu_ps(p), from), (vf)m);
}
VV_INLINE void vf_compress(float *p, vf a, vm m) { _mm256_storeu_ps(p, _mm256_permutevar8x32_ps(a, packed_lanes(m))); }
VV_INLINE void vi_compress(int32_t *p, vi a, vm m)
{
    _mm256_storeu_si256((__m256i *)(void *)p, _mm256_permutevar8x32_epi32(I256(a), packed_lanes(m)));
}

#elif defined(VV_ISA_SCALAR)
/* ----------------------------------------------------------------------------------------------------- 1 lane, plain C */
#define VV_WIDTH 1
#define VV_ISA_NEEDS 0u
typedef float vf;
typedef int32_t vi;
typedef int32_t vm; /* 0 or -1 */

VV_INLINE vf vf_set1(float a) { return a; }
VV_INLINE vi vi_set1(int32_t a) { return a; }
VV_INLINE vf vf_load(const float *p) { return *p; }
VV_INLINE void vf_store(float *p, vf a) { *p = a; }
VV_INLINE vi vi_load(const int32_t *p) { return *p; }
VV_INLINE void vi_store(int32_t *p, vi a) { *p = a; }
VV_INLINE vf vf_fma(vf a, vf b, vf c) { return a * b + c; }
VV_INLINE vf vf_min(vf a, vf b) { return a < b ? a : b; }
VV_INLINE vf vf_max(vf a, vf b) { return a > b ? a : b; }
VV_INLINE vf vf_sqrt(vf a) { return sqrtf(a); }
VV_INLINE vf vf_floor(vf a) { return floorf(a); }
VV_INLINE vf vf_abs(vf a) { return fabsf(a); }
VV_INLINE vi vi_min(vi a, vi b) { return a < b ? a : b; }
VV_INLINE vi vi_max(vi a, vi b) { return a > b ? a : b; }
VV_INLINE vi vi_trunc(vf a) { return a >= 2147483648.0f || a < -2147483648.0f || a != a ? INT32_MIN : (vi)a; }
VV_INLINE vf vf_from_vi(vi a) { return (vf)a; }
VV_INLINE vf vf_bits(vi a) { vf r; memcpy(&r, &a, 4); return r; }
VV_INLINE vi vi_bits(vf a) { vi r; memcpy(&r, &a, 4); return r; }
VV_INLINE vi vi_shr_u(vi a, int n) { return (vi)((uint32_t)a >> n); }
VV_INLINE vi vi_shl(vi a, int n) { return (vi)((uint32_t)a << n); }
VV_INLINE vi vi_shr_by(vi a, int n) { return a >> n; }
VV_INLINE vm vf_lt(vf a, vf b) { return -(a < b); }
VV_INLINE vm vf_le(vf a, vf b) { return -(a <= b); }
VV_INLINE vm vf_eq(vf a, vf b) { return -(a == b); }
VV_INLINE vm vi_lt(vi a, vi b) { return -(a < b); }
VV_INLINE vm vi_eq(vi a, vi b) { return -(a == b); }
VV_INLINE vf vf_select(vm m, vf yes, vf no) { return m ? yes : no; }
VV_INLINE vi vi_select(vm m, vi yes, vi no) { return m ? yes : no; }
VV_INLINE vm vm_and(vm a, vm b) { return a & b; }
VV_INLINE vm vm_or(vm a, vm b) { return a | b; }
VV_INLINE vm vm_andnot(vm a, vm b) { return a & ~b; }
VV_INLINE uint32_t vm_bits(vm a) { return (uint32_t)a & 1; }
VV_INLINE vm vm_from_bits(uint32_t b) { return b & 1 ? -1 : 0; }
VV_INLINE vi vi_gather(const void *base, vi offset, vm m)
{
    vi r = 0;
    if (m)
        memcpy(&r, (const char *)base + offset, 4);
    return r;
}
VV_INLINE vi vi_gather2(const void *base, vi index, vm m)
{
    vi r = 0;
    if (m)
        memcpy(&r, (const char *)base + (int64_t)index * 2, 4);
    return r;
}
VV_INLINE vf vf_gather4(const float *base, vi index, vm m)
{
    return m ? base[index] : 0;
}
VV_INLINE void vf_rows4(vf out[4], const float *base, vi index)
{
    memcpy(out, base + index, 16);
}
VV_INLINE vf vf_permute(vf table, vi lane) { (void)lane; return table; }
VV_INLINE vi vi_madd16(vi a, vi b) { return (int16_t)a * (int16_t)b + (a >> 16) * (b >> 16); }
VV_INLINE vi vi_bytes01(vi a) { return (a & 255) | (a & 0xff00) << 8; }
VV_INLINE void vf_compress(float *p, vf a, vm m) { if (m) *p = a; }
VV_INLINE vf vf_expand(const float *p, vm m) { return m ? *p : 0; }
VV_INLINE void vi_compress(int32_t *p, vi a, vm m) { if (m) *p = a; }

#else
/* ------------------------------------------------------------------- 4 lanes, what every machine has (SSE2, NEON, ...) */
#if defined(__SSE2__)
#include <emmintrin.h>
#elif defined(__aarch64__)
#include <arm_neon.h>
#endif
#define VV_WIDTH 4
#define VV_ISA_NEEDS 0u
typedef float vf __attribute__((vector_size(16)));
typedef int32_t vi __attribute__((vector_size(16)));
typedef int32_t vm __attribute__((vector_size(16)));

VV_INLINE vf vf_set1(float a) { return (vf){a, a, a, a}; }
VV_INLINE vi vi_set1(int32_t a) { return (vi){a, a, a, a}; }
VV_INLINE vf vf_load(const float *p) { vf r; memcpy(&r, p, sizeof r); return r; }
VV_INLINE void vf_store(float *p, vf a) { memcpy(p, &a, sizeof a); }
VV_INLINE vi vi_load(const int32_t *p) { vi r; memcpy(&r, p, sizeof r); return r; }
VV_INLINE void vi_store(int32_t *p, vi a) { memcpy(p, &a, sizeof a); }
VV_INLINE vf vf_bits(vi a) { return (vf)a; }
VV_INLINE vi vi_bits(vf a) { return (vi)a; }
VV_INLINE vm vf_lt(vf a, vf b) { return a < b; }
VV_INLINE vm vf_le(vf a, vf b) { return a <= b; }
VV_INLINE vm vf_eq(vf a, vf b) { return a == b; }
VV_INLINE vm vi_lt(vi a, vi b) { return a < b; }
VV_INLINE vm vi_eq(vi a, vi b) { return a == b; }
VV_INLINE vi vi_select(vm m, vi yes, vi no) { return (m & yes) | (~m & no); }
VV_INLINE vf vf_select(vm m, vf yes, vf no) { return (vf)vi_select(m, (vi)yes, (vi)no); }
VV_INLINE vf vf_abs(vf a) { return (vf)((vi)a & vi_set1(0x7fffffff)); }
VV_INLINE vi vi_min(vi a, vi b) { return vi_select(a < b, a, b); }
VV_INLINE vi vi_max(vi a, vi b) { return vi_select(a > b, a, b); }
VV_INLINE vf vf_from_vi(vi a) { return __builtin_convertvector(a, vf); }
VV_INLINE vi vi_shr_u(vi a, int n)
{
    typedef uint32_t vu __attribute__((vector_size(16)));
    return (vi)((vu)a >> (uint32_t)n);
}
VV_INLINE vi vi_shl(vi a, int n) { return a << n; }
VV_INLINE vi vi_shr_by(vi a, int n) { return a >> n; }
VV_INLINE vm vm_and(vm a, vm b) { return a & b; }
VV_INLINE vm vm_or(vm a, vm b) { return a | b; }
VV_INLINE vm vm_andnot(vm a, vm b) { return a & ~b; }
VV_INLINE vm vm_from_bits(uint32_t b)
{
    const vi lane = {1, 2, 4, 8};
    return (vi_set1((int32_t)b) & lane) == lane;
}
#if defined(__SSE2__)
VV_INLINE vf vf_fma(vf a, vf b, vf c) { return a * b + c; }
VV_INLINE vf vf_min(vf a, vf b) { return (vf)_mm_min_ps((__m128)a, (__m128)b); }
VV_INLINE vf vf_max(vf a, vf b) { return (vf)_mm_max_ps((__m128)a, (__m128)b); }
VV_INLINE vf vf_sqrt(vf a) { return (vf)_mm_sqrt_ps((__m128)a); }
VV_INLINE vi vi_trunc(vf a) { return (vi)_mm_cvttps_epi32((__m128)a); }
VV_INLINE uint32_t vm_bits(vm a) { return (uint32_t)_mm_movemask_ps((__m128)a); }
#else
VV_INLINE vf vf_min(vf a, vf b) { return vf_select(a < b, a, b); }
VV_INLINE vf vf_max(vf a, vf b) { return vf_select(a > b, a, b); }
VV_INLINE uint32_t vm_bits(vm a)
{
    return ((uint32_t)a[0] & 1) | ((uint32_t)a[1] & 2) | ((uint32_t)a[2] & 4) | ((uint32_t)a[3] & 8);
}
#if defined(__aarch64__)
VV_INLINE vf vf_fma(vf a, vf b, vf c) { return (vf)vfmaq_f32((float32x4_t)c, (float32x4_t)a, (float32x4_t)b); }
VV_INLINE vf vf_sqrt(vf a) { return (vf)vsqrtq_f32((float32x4_t)a); }
VV_INLINE vi vi_trunc(vf a) { return (vi)vcvtq_s32_f32((float32x4_t)a); }
#else
VV_INLINE vf vf_fma(vf a, vf b, vf c) { return a * b + c; }
VV_INLINE vf vf_sqrt(vf a) { return (vf){sqrtf(a[0]), sqrtf(a[1]), sqrtf(a[2]), sqrtf(a[3])}; }
VV_INLINE vi vi_trunc(vf a) { return __builtin_convertvector(a, vi); }
#endif
#endif
/* Right for |a| < 2^31, which is all that kernels ask of it. */
VV_INLINE vf vf_floor(vf a)
{
    const vf t = vf_from_vi(vi_trunc(a));
    return t - (vf)((vi)(t > a) & (vi)vf_set1(1.0f));
}
VV_INLINE vi vi_gather(const void *base, vi offset, vm m)
{
    vi r = {0, 0, 0, 0};
    for (int l = 0; l < 4; l++)
        if (m[l]) {
            int32_t w;
            memcpy(&w, (const char *)base + offset[l], 4);
            r[l] = w;
        }
    return r;
}
VV_INLINE vi vi_gather2(const void *base, vi index, vm m)
{
    vi r = {0, 0, 0, 0};
    for (int l = 0; l < 4; l++)
        if (m[l]) {
            int32_t w;
            memcpy(&w, (const char *)base + (int64_t)index[l] * 2, 4);
            r[l] = w;
        }
    return r;
}
VV_INLINE vf vf_gather4(const float *base, vi index, vm m)
{
    vf r = {0, 0, 0, 0};
    for (int l = 0; l < 4; l++)
        if (m[l])
            r[l] = base[index[l]];
    return r;
}
VV_INLINE void vf_rows4(vf out[4], const float *base, vi index)
{
    vf z[4];
    for (int i = 0; i < 4; i++)
        z[i] = vf_load(base + index[i]);
    const vf a = __builtin_shufflevector(z[0], z[1], 0, 4, 1, 5), b = __builtin_shufflevector(z[2], z[3], 0, 4, 1, 5);
    const vf c = __builtin_shufflevector(z[0], z[1], 2, 6, 3, 7), d = __builtin_shufflevector(z[2], z[3], 2, 6, 3, 7);
    out[0] = __builtin_shufflevector(a, b, 0, 1, 4, 5);
    out[1] = __builtin_shufflevector(a, b, 2, 3, 6, 7);
    out[2] = __builtin_shufflevector(c, d, 0, 1, 4, 5);
    out[3] = __builtin_shufflevector(c, d, 2, 3, 6, 7);
}
#if defined(__SSE2__)
VV_INLINE vi vi_madd16(vi a, vi b) { return (vi)_mm_madd_epi16((__m128i)a, (__m128i)b); }
#else
VV_INLINE vi vi_madd16(vi a, vi b)
{
    const vi a0 = (vi)((a << 16) >> 16), b0 = (vi)((b << 16) >> 16);
    return a0 * b0 + (a >> 16) * (b >> 16);
}
#endif
VV_INLINE vi vi_bytes01(vi a) { return (a & vi_set1(255)) | (a & vi_set1(0xff00)) << 8; }
VV_INLINE vf vf_permute(vf table, vi lane)
{
    return (vf){table[lane[0] & 3], table[lane[1] & 3], table[lane[2] & 3], table[lane[3] & 3]};
}
VV_INLINE vf vf_expand(const float *p, vm m)
{
    vf r = {0, 0, 0, 0};
    for (int l = 0; l < 4; l++)
        if (m[l])
            r[l] = *p++;
    return r;
}
VV_INLINE void vi_compress(int32_t *p, vi a, vm m)
{
    for (int l = 0; l < 4; l++) {
        *p = a[l];
        p += m[l] & 1;
    }
}
VV_INLINE void vf_compress(float *p, vf a, vm m)
{
    for (int l = 0; l < 4; l++) {
        *p = a[l];
        p += m[l] & 1;
    }
}
#endif

#ifndef GATHER_PAIR
#define GATHER_PAIR(name, scale) \
    VV_INLINE void name(const void *base, vi index, vm m, vi *low, vi *high) \
    { \
        int32_t at[VV_WIDTH], a[VV_WIDTH] = {0}, b[VV_WIDTH] = {0}; \
        const uint32_t live = vm_bits(m); \
        vi_store(at, index); \
        for (int l = 0; l < VV_WIDTH; l++) \
            if (live >> l & 1) { \
                const char *from = (const char *)base + (int64_t)at[l] * (scale); \
                memcpy(&a[l], from, 4); \
                memcpy(&b[l], from + 4, 4); \
            } \
        *low = vi_load(a); \
        *high = vi_load(b); \
    }
#endif
GATHER_PAIR(vi_gather_pair2, 2) /* four numbers of 16 bits */
GATHER_PAIR(vi_gather_pair4, 4) /* two of 32 bits */

/* ------------------------------------------------------------------------------------------- what all widths share */

/* clang-format on */
VV_INLINE bool vm_any(vm a)
{
    return vm_bits(a) != 0;
}
VV_INLINE int vm_count(vm a)
{
    return __builtin_popcount(vm_bits(a));
}
/** Lanes 0 .. n-1. */
VV_INLINE vm vm_first_n(uint64_t n)
{
    return vm_from_bits(n >= VV_WIDTH ? (1u << VV_WIDTH) - 1 : (1u << n) - 1);
}
VV_INLINE vm vm_none(void)
{
    return vm_from_bits(0);
}
VV_INLINE vf vf_lerp(vf a, vf b, vf f)
{
    return vf_fma(f, b - a, a);
}
VV_INLINE vf vf_clamp(vf a, vf lo, vf hi)
{
    return vf_min(vf_max(a, lo), hi);
}
VV_INLINE vi vi_clamp(vi a, vi lo, vi hi)
{
    return vi_min(vi_max(a, lo), hi);
}

#endif
