/** @file
 * Elementary functions on vf, for kernels only. Polynomials fitted by least maximum error on the reduced interval;
 * relative error below 4e-7 in the ranges said (tests/kernels checks every build against libm).
 */
#ifndef VVI_CORE_SIMD_MATH_H
#define VVI_CORE_SIMD_MATH_H
#include "core/simd.h"

/** 1 / sqrt(x) of positive normal numbers: a first guess from the bits, then Newton's method three times. Half the time
 * of a square root and a division, and the same numbers on every machine, which its own estimate is not. */
VV_INLINE vf vf_rsqrt(vf x)
{
    const vf half = x * vf_set1(0.5f), more = vf_set1(1.5f);
    vf y = vf_bits(vi_set1(0x5f375a86) - vi_shr_u(vi_bits(x), 1));
    VV_UNROLL
    for (int i = 0; i < 3; i++)
        y = y * (more - half * y * y);
    return y;
}

/** 2^x for x in [-126, 127]; below, 2^-126. */
VV_INLINE vf vf_exp2(vf x)
{
    x = vf_clamp(x, vf_set1(-126.0f), vf_set1(127.0f));
    const vf whole = vf_floor(x + vf_set1(0.5f));
    const vf f = x - whole; /* [-0.5, 0.5] */
    vf p = vf_set1(1.5403530e-4f);
    p = vf_fma(p, f, vf_set1(1.3333558e-3f));
    p = vf_fma(p, f, vf_set1(9.6181291e-3f));
    p = vf_fma(p, f, vf_set1(5.5504109e-2f));
    p = vf_fma(p, f, vf_set1(2.4022651e-1f));
    p = vf_fma(p, f, vf_set1(6.9314718e-1f));
    p = vf_fma(p, f, vf_set1(1.0f));
    return vf_bits(vi_bits(p) + vi_shl(vi_trunc(whole), 23));
}

/** log2 of positive normal numbers. */
VV_INLINE vf vf_log2(vf x)
{
    const vi bits = vi_bits(x);
    /* mantissa in [sqrt(1/2), sqrt(2)), so that the polynomial's argument is small on both sides of 1 */
    const vi shifted = bits - vi_set1(0x3f3504f3);
    const vf e = vf_from_vi(vi_shr_by(shifted, 23));
    const vf m = vf_bits((shifted & vi_set1(0x007fffff)) + vi_set1(0x3f3504f3));
    /* log2(m) = 2 / ln 2 * atanh(s), s = (m - 1) / (m + 1), |s| < 0.1716 */
    const vf s = (m - vf_set1(1.0f)) / (m + vf_set1(1.0f));
    const vf s2 = s * s;
    vf p = vf_set1(0.32059890f); /* 2 / (9 ln 2) */
    p = vf_fma(p, s2, vf_set1(0.41219858f));
    p = vf_fma(p, s2, vf_set1(0.57707802f));
    p = vf_fma(p, s2, vf_set1(0.96179669f));
    p = vf_fma(p, s2, vf_set1(2.88539008f));
    return vf_fma(s, p, e);
}

VV_INLINE vf vf_exp(vf x)
{
    return vf_exp2(x * vf_set1(1.44269504f));
}

/** x^y for x in [0, 1], y > 0; at least 2^-60, which is dark enough: what is smaller would soon be a number below the
 * normal ones, and those cost a hundred times as much to multiply. */
VV_INLINE vf vf_pow01(vf x, float y)
{
    return vf_exp2(vf_max(vf_set1(y) * vf_log2(vf_max(x, vf_set1(1.1754944e-38f))), vf_set1(-60.0f)));
}

/** x^n for x in [0, 1] and a whole n > 0, by squaring; 0 below `least`, for the same reason: n-th root of 2^-60. */
VV_INLINE vf vf_pow01_whole(vf x, int32_t n, float least)
{
    x = vf_select(vf_lt(x, vf_set1(least)), vf_set1(0.0f), x);
    vf result = vf_set1(1.0f);
    for (;;) {
        if (n & 1)
            result = result * x;
        n >>= 1;
        if (!n)
            return result;
        x = x * x; /* not below x^n, as more factors follow */
    }
}

#endif
