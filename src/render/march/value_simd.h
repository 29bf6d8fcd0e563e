/** @file
 * Values and gradients of a lattice whose sample type is known at run time only. For kernels only.
 */
#ifndef VVI_RENDER_MARCH_VALUE_SIMD_H
#define VVI_RENDER_MARCH_VALUE_SIMD_H
#include "render/march/lattice_simd.h"

#define OUT_OF_LINE static __attribute__((noinline))

OUT_OF_LINE vf value_linear(const vvi_lattice *g, const vf3 *p, vm m)
{
    switch (vvi_lattice_kernel(g)) {
    case VVI_SAMPLE_U8:
        return sample_value(g, VVI_SAMPLE_U8, false, *p, m);
    case VVI_SAMPLE_U16:
        return sample_value(g, VVI_SAMPLE_U16, false, *p, m);
    case VVI_SAMPLE_I16:
        return sample_value(g, VVI_SAMPLE_I16, false, *p, m);
    case VVI_SAMPLE_F32:
        return sample_value(g, VVI_SAMPLE_F32, false, *p, m);
    default:
        return sample_value(g, VVI_SAMPLE_WIDE, false, *p, m);
    }
}

OUT_OF_LINE vf value_nearest(const vvi_lattice *g, const vf3 *p, vm m)
{
    switch (vvi_lattice_kernel(g)) {
    case VVI_SAMPLE_U8:
        return sample_value(g, VVI_SAMPLE_U8, true, *p, m);
    case VVI_SAMPLE_U16:
        return sample_value(g, VVI_SAMPLE_U16, true, *p, m);
    case VVI_SAMPLE_I16:
        return sample_value(g, VVI_SAMPLE_I16, true, *p, m);
    case VVI_SAMPLE_F32:
        return sample_value(g, VVI_SAMPLE_F32, true, *p, m);
    default:
        return sample_value(g, VVI_SAMPLE_WIDE, true, *p, m);
    }
}

#endif
