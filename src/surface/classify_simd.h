/* Which samples are at or above a threshold, 64 at a time: bit i of the result for sample i. */
#ifndef VVI_SURFACE_CLASSIFY_SIMD_H
#define VVI_SURFACE_CLASSIFY_SIMD_H
#include "core/simd.h"

#if defined(VV_ISA_AVX512)
VV_INLINE uint64_t above64_u8(const uint8_t *p, uint8_t t)
{
    return _mm512_cmpge_epu8_mask(_mm512_loadu_si512(p), _mm512_set1_epi8((char)t));
}
VV_INLINE uint64_t above64_u16(const uint16_t *p, uint16_t t)
{
    const __m512i v = _mm512_set1_epi16((short)t);
    return _mm512_cmpge_epu16_mask(_mm512_loadu_si512(p), v) |
           (uint64_t)_mm512_cmpge_epu16_mask(_mm512_loadu_si512(p + 32), v) << 32;
}
VV_INLINE uint64_t above64_i16(const int16_t *p, int16_t t)
{
    const __m512i v = _mm512_set1_epi16(t);
    return _mm512_cmpge_epi16_mask(_mm512_loadu_si512(p), v) |
           (uint64_t)_mm512_cmpge_epi16_mask(_mm512_loadu_si512(p + 32), v) << 32;
}
#elif defined(VV_ISA_AVX2)
VV_INLINE __m256i load256(const void *p)
{
    return _mm256_loadu_si256((const __m256i *)p);
}
VV_INLINE uint64_t above64_u8(const uint8_t *p, uint8_t t)
{
    const __m256i v = _mm256_set1_epi8((char)t), a = load256(p), b = load256(p + 32);
    const uint32_t low = (uint32_t)_mm256_movemask_epi8(_mm256_cmpeq_epi8(_mm256_max_epu8(a, v), a));
    const uint32_t high = (uint32_t)_mm256_movemask_epi8(_mm256_cmpeq_epi8(_mm256_max_epu8(b, v), b));
    return low | (uint64_t)high << 32;
}
/* Two masks of 16 lanes of 16 bits as 32 bits. */
VV_INLINE uint32_t pack_masks(__m256i a, __m256i b)
{
    return (uint32_t)_mm256_movemask_epi8(_mm256_permute4x64_epi64(_mm256_packs_epi16(a, b), 0xd8));
}
VV_INLINE __m256i ge_u16(const uint16_t *p, __m256i v)
{
    const __m256i a = load256(p);
    return _mm256_cmpeq_epi16(_mm256_max_epu16(a, v), a);
}
VV_INLINE uint64_t above64_u16(const uint16_t *p, uint16_t t)
{
    const __m256i v = _mm256_set1_epi16((short)t);
    return pack_masks(ge_u16(p, v), ge_u16(p + 16, v)) | (uint64_t)pack_masks(ge_u16(p + 32, v), ge_u16(p + 48, v))
                                                             << 32;
}
VV_INLINE __m256i ge_i16(const int16_t *p, __m256i v)
{
    const __m256i a = load256(p);
    return _mm256_cmpeq_epi16(_mm256_max_epi16(a, v), a);
}
VV_INLINE uint64_t above64_i16(const int16_t *p, int16_t t)
{
    const __m256i v = _mm256_set1_epi16(t);
    return pack_masks(ge_i16(p, v), ge_i16(p + 16, v)) | (uint64_t)pack_masks(ge_i16(p + 32, v), ge_i16(p + 48, v))
                                                             << 32;
}
#else
#define ABOVE64(name, type)                                                                                            \
    VV_INLINE uint64_t name(const type *p, type t)                                                                     \
    {                                                                                                                  \
        uint64_t bits = 0;                                                                                             \
        for (int i = 0; i < 64; i++)                                                                                   \
            bits |= (uint64_t)(p[i] >= t) << i;                                                                        \
        return bits;                                                                                                   \
    }
#if defined(__SSE2__) && !defined(VV_ISA_SCALAR)
VV_INLINE uint64_t above64_u8(const uint8_t *p, uint8_t t)
{
    const __m128i v = _mm_set1_epi8((char)t);
    uint64_t bits = 0;
    VV_UNROLL
    for (int i = 0; i < 4; i++) {
        const __m128i a = _mm_loadu_si128((const __m128i *)(const void *)(p + 16 * i));
        bits |= (uint64_t)(uint32_t)_mm_movemask_epi8(_mm_cmpeq_epi8(_mm_max_epu8(a, v), a)) << 16 * i;
    }
    return bits;
}
VV_INLINE uint64_t above64_i16(const int16_t *p, int16_t t)
{
    const __m128i v = _mm_set1_epi16(t);
    uint64_t bits = 0;
    VV_UNROLL
    for (int i = 0; i < 4; i++) {
        const __m128i a = _mm_loadu_si128((const __m128i *)(const void *)(p + 16 * i));
        const __m128i b = _mm_loadu_si128((const __m128i *)(const void *)(p + 16 * i + 8));
        const __m128i below = _mm_packs_epi16(_mm_cmplt_epi16(a, v), _mm_cmplt_epi16(b, v));
        bits |= (uint64_t)(~(uint32_t)_mm_movemask_epi8(below) & 0xffff) << 16 * i;
    }
    return bits;
}
VV_INLINE uint64_t above64_u16(const uint16_t *p, uint16_t t)
{
    const __m128i v = _mm_set1_epi16((short)t), zero = _mm_setzero_si128();
    uint64_t bits = 0;
    VV_UNROLL
    for (int i = 0; i < 4; i++) { /* t - p, not below 0, is 0 */
        const __m128i a = _mm_loadu_si128((const __m128i *)(const void *)(p + 16 * i));
        const __m128i b = _mm_loadu_si128((const __m128i *)(const void *)(p + 16 * i + 8));
        const __m128i above =
            _mm_packs_epi16(_mm_cmpeq_epi16(_mm_subs_epu16(v, a), zero), _mm_cmpeq_epi16(_mm_subs_epu16(v, b), zero));
        bits |= (uint64_t)(uint32_t)_mm_movemask_epi8(above) << 16 * i;
    }
    return bits;
}
#else
ABOVE64(above64_u8, uint8_t)
ABOVE64(above64_u16, uint16_t)
ABOVE64(above64_i16, int16_t)
#endif
#endif

VV_INLINE uint64_t above64_f32(const float *p, float t)
{
    const vf v = vf_set1(t);
    uint64_t bits = 0;
    VV_UNROLL
    for (int i = 0; i < 64; i += VV_WIDTH)
        bits |= (uint64_t)vm_bits(vf_le(v, vf_load(p + i))) << i;
    return bits;
}
VV_INLINE uint64_t known64(const float *p)
{
    uint64_t bits = 0;
    VV_UNROLL
    for (int i = 0; i < 64; i += VV_WIDTH) {
        const vf a = vf_load(p + i);
        bits |= (uint64_t)vm_bits(vf_eq(a, a)) << i;
    }
    return bits;
}
#endif
