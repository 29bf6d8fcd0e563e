/* CRC-32 by folding: Gopal et al. 2009, "Fast CRC Computation for Generic Polynomials Using PCLMULQDQ".
 *
 * 64 bytes at a time are multiplied forward by x^512 modulo the polynomial and added to the next 64; what is left in
 * the end is a message of 16 bytes with the same checksum, which zlib finishes. */
#include "grid/crc.h"

#include <zlib.h>

#if defined(__x86_64__)
#include <immintrin.h>

/* x^n modulo the polynomial, bits reversed, times x: for n = 512 + 32, 512 - 32, 128 + 32, 128 - 32. */
#define FORWARD_544 0x154442bd4
#define FORWARD_480 0x1c6e41596
#define FORWARD_160 0x1751997d0
#define FORWARD_96 0x0ccaa009e

#define FOLD_CODE __attribute__((target("pclmul,sse2")))

bool vvi_crc_has_fold(void)
{
    return __builtin_cpu_supports("pclmul");
}

FOLD_CODE static inline __m128i forward(__m128i v, __m128i by, __m128i next)
{
    return _mm_xor_si128(_mm_xor_si128(_mm_clmulepi64_si128(v, by, 0x00), _mm_clmulepi64_si128(v, by, 0x11)), next);
}

FOLD_CODE static inline __m128i load(const char *p)
{
    return _mm_loadu_si128((const __m128i *)(const void *)p);
}

/* n is a multiple of 64, at least 64. */
FOLD_CODE static uint32_t fold(uint32_t crc, const char *p, size_t n)
{
    const __m128i by_512 = _mm_set_epi64x(FORWARD_480, FORWARD_544), by_128 = _mm_set_epi64x(FORWARD_96, FORWARD_160);
    /* zlib's checksums are kept inverted */
    __m128i a = _mm_xor_si128(load(p), _mm_cvtsi32_si128((int)~crc));
    __m128i b = load(p + 16), c = load(p + 32), d = load(p + 48);
    for (p += 64, n -= 64; n >= 64; p += 64, n -= 64) {
        a = forward(a, by_512, load(p));
        b = forward(b, by_512, load(p + 16));
        c = forward(c, by_512, load(p + 32));
        d = forward(d, by_512, load(p + 48));
    }
    d = forward(forward(forward(a, by_128, b), by_128, c), by_128, d);
    unsigned char rest[16];
    _mm_storeu_si128((__m128i *)(void *)rest, d);
    return (uint32_t)crc32_z(~0u, rest, sizeof rest);
}
#else
bool vvi_crc_has_fold(void)
{
    return false;
}

static uint32_t fold(uint32_t crc, const char *p, size_t n)
{
    return (uint32_t)crc32_z(crc, (const unsigned char *)p, n);
}
#endif

uint32_t vvi_crc32(uint32_t crc, const void *data, size_t n, bool use_fold)
{
    const char *p = data;
    const size_t whole = use_fold && n >= 64 ? n / 64 * 64 : 0;
    if (whole)
        crc = fold(crc, p, whole);
    return n > whole ? (uint32_t)crc32_z(crc, (const unsigned char *)p + whole, n - whole) : crc;
}
