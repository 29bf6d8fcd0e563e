#include "filter/normals_kernel.h"
#include "core/simd.h"

typedef double eight __attribute__((vector_size(64)));
typedef uint64_t bits __attribute__((vector_size(64)));

VV_INLINE eight all(double v)
{
    return (eight){v, v, v, v, v, v, v, v};
}

VV_INLINE eight choose(bits mask, eight yes, eight no)
{
    return (eight)(((bits)yes & mask) | ((bits)no & ~mask));
}

/* The mixer of splitmix64 (Steele, Lea & Flood 2014). */
VV_INLINE bits mixed(bits v)
{
    v = (v ^ v >> 30) * 0xbf58476d1ce4e5b9;
    v = (v ^ v >> 27) * 0x94d049bb133111eb;
    return v ^ v >> 31;
}

/* Whole numbers below 2^53 as doubles: halves put where a double of 2^52 or 2^84 has them. */
VV_INLINE eight from_bits(bits v)
{
    const eight low = (eight)((v & 0xffffffff) | 0x4330000000000000), high = (eight)(v >> 32 | 0x4530000000000000);
    return (high - all(0x1.00000001p84)) + low;
}

/* In (0, 1]. */
VV_INLINE eight unit(bits v)
{
    return (from_bits(v >> 11) + all(1)) * all(0x1p-53);
}

/* Natural logarithm of numbers in [2^-53, 1]: 2^e m, m in [sqrt(1/2), sqrt(2)), and log m = 2 atanh((m - 1) / (m + 1))
 * by its series, whose next term is 6e-19. */
VV_INLINE eight logarithm(eight v)
{
    const uint64_t one = 0x3ff0000000000000, root = 0x3fe6a09e667f3bcd;
    const bits exponent = ((bits)v + (one - root)) >> 52; /* 1023 and e */
    const eight m = (eight)((bits)v + one - (exponent << 52));
    const eight e = (eight)(exponent | 0x4330000000000000) - all(0x1p52 + 1023);
    const eight s = (m - all(1)) / (m + all(1)), z = s * s;
    eight p = all(1.0 / 21);
    VV_UNROLL
    for (int k = 19; k >= 3; k -= 2)
        p = p * z + all(1.0 / k);
    return e * all(0x1.62e42fefa39efp-1) + (all(2) * s + all(2) * s * z * p);
}

/* Cosine and sine of turns in (0, 1]: quarters, and what is left, in [-1/8, 1/8], by Taylor's series. */
VV_INLINE void circle(eight *cosine, eight *sine, eight turn)
{
    static const double c[] = {1.0 / 20922789888000,
                               -1.0 / 87178291200,
                               1.0 / 479001600,
                               -1.0 / 3628800,
                               1.0 / 40320,
                               -1.0 / 720,
                               1.0 / 24,
                               -0.5,
                               1};
    static const double s[] = {1.0 / 355687428096000,
                               -1.0 / 1307674368000,
                               1.0 / 6227020800,
                               -1.0 / 39916800,
                               1.0 / 362880,
                               -1.0 / 5040,
                               1.0 / 120,
                               -1.0 / 6,
                               1};
    const eight to_whole = all(0x1.8p52), rounded = turn * all(4) + to_whole, quarters = rounded - to_whole;
    const bits quarter = (bits)rounded;
    const eight x = (turn - quarters * all(0.25)) * all(0x1.921fb54442d18p2), z = x * x;
    eight p = all(c[0]), q = all(s[0]);
    VV_UNROLL
    for (int k = 1; k < 9; k++) {
        p = p * z + all(c[k]);
        q = q * z + all(s[k]);
    }
    q = q * x;
    const bits odd = -(quarter & 1), sign = (quarter & 2) << 62, other = ((quarter + 1) & 2) << 62;
    *cosine = (eight)((bits)choose(odd, q, p) ^ other);
    *sine = (eight)((bits)choose(odd, p, q) ^ sign);
}

static void make(double *a, double *b, uint64_t seed, uint64_t first, int64_t n)
{
    for (int64_t at = 0; at < n; at += 8) {
        const bits lane = {1, 2, 3, 4, 5, 6, 7, 8};
        const bits key = mixed(seed + (lane + (first + (uint64_t)at)) * VVI_NORMALS_STEP);
        const eight square = all(-2) * logarithm(unit(mixed(key + VVI_NORMALS_STEP)));
        eight cosine, sine;
        double length[8], squares[8];
        memcpy(squares, &square, sizeof squares);
        for (int i = 0; i < 8; i++)
            length[i] = sqrt(squares[i]);
        eight l;
        memcpy(&l, length, sizeof l);
        circle(&cosine, &sine, unit(mixed(key + 2 * VVI_NORMALS_STEP)));
        cosine = l * cosine;
        sine = l * sine;
        memcpy(a + at, &cosine, sizeof cosine);
        memcpy(b + at, &sine, sizeof sine);
    }
}

const vvi_normals_kernels VV_KERNEL_TABLE(vvi_normals_kernels) = {
    .isa = VV_ISA_NAME,
    .needs = VV_ISA_NEEDS,
    .make = make,
};
