/** @file
 * Vectors of three vf, as vec.h has them of three doubles. For kernels only.
 */
#ifndef VVI_CORE_SIMD_VEC_H
#define VVI_CORE_SIMD_VEC_H
#include "core/simd_math.h"

typedef struct vf3 {
    vf x, y, z;
} vf3;

VV_INLINE vf3 vf3_set(vf x, vf y, vf z)
{
    return (vf3){x, y, z};
}
VV_INLINE vf3 vf3_set1(const float v[3])
{
    return (vf3){vf_set1(v[0]), vf_set1(v[1]), vf_set1(v[2])};
}
VV_INLINE vf3 vf3_add(vf3 a, vf3 b)
{
    return (vf3){a.x + b.x, a.y + b.y, a.z + b.z};
}
VV_INLINE vf3 vf3_sub(vf3 a, vf3 b)
{
    return (vf3){a.x - b.x, a.y - b.y, a.z - b.z};
}
VV_INLINE vf3 vf3_scale(vf3 a, vf s)
{
    return (vf3){a.x * s, a.y * s, a.z * s};
}
VV_INLINE vf3 vf3_fma(vf3 a, vf s, vf3 b)
{
    return (vf3){vf_fma(a.x, s, b.x), vf_fma(a.y, s, b.y), vf_fma(a.z, s, b.z)};
}
VV_INLINE vf vf3_dot(vf3 a, vf3 b)
{
    return vf_fma(a.x, b.x, vf_fma(a.y, b.y, a.z * b.z));
}
VV_INLINE vf3 vf3_cross(vf3 a, vf3 b)
{
    return (vf3){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
VV_INLINE vf3 vf3_select(vm m, vf3 a, vf3 b)
{
    return (vf3){vf_select(m, a.x, b.x), vf_select(m, a.y, b.y), vf_select(m, a.z, b.z)};
}

/* The squares of lengths below this are taken for 0: far below what floats of positions can tell apart. */
#define VF3_NOTHING 1e-36f

/** Length 1; what has none stays next to 0. */
VV_INLINE vf3 vf3_unit(vf3 a)
{
    return vf3_scale(a, vf_rsqrt(vf_max(vf3_dot(a, a), vf_set1(VF3_NOTHING))));
}
/** The matrix (rows) times a. */
VV_INLINE vf3 vf3_turn(const float m[3][3], vf3 a)
{
    return (vf3){vf3_dot(vf3_set1(m[0]), a), vf3_dot(vf3_set1(m[1]), a), vf3_dot(vf3_set1(m[2]), a)};
}

#endif
