/** @file
 * Samples of a lattice whose type, or way to be fetched, is known at run time only (VVI_SAMPLE_ANY): out of line, one
 * copy for all kernels, by the same functions as where both are known. For kernels only.
 */
#ifndef VVI_RENDER_MARCH_ANY_SIMD_H
#define VVI_RENDER_MARCH_ANY_SIMD_H
#include "render/march/lattice_simd.h"

#define OUT_OF_LINE static __attribute__((noinline))

OUT_OF_LINE void any_place(sample_place *out, const vvi_lattice *g, const sample_place *sample, vm m)
{
    fetch_place(out, g, g->fetch, sample->x, sample->y, sample->z, m);
}

OUT_OF_LINE void any_pair(vf out[2], const vvi_lattice *g, const spot *s, vm m)
{
#define CALL(how) load_pair(g, how, s->at, vi_set1(0), s->z, m, &out[0], &out[1])
    switch (lattice_how(g)) {
        EACH_HOW
    }
#undef CALL
}

OUT_OF_LINE vf any_value(const vvi_lattice *g, bool nearest, const vf3 *p, vm m)
{
#define CALL(how) return sample_value(g, how, nearest, *p, m)
    switch (lattice_how(g)) {
        EACH_HOW
    }
#undef CALL
    return vf_set1(0.0f);
}

OUT_OF_LINE void any_gradient(vf3 *out, const vvi_lattice *g, const cell_at *c, vm m)
{
#define CALL(how) *out = sample_gradient(g, how, c, m)
    switch (lattice_how(g)) {
        EACH_HOW
    }
#undef CALL
}

#endif
