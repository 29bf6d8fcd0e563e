/* Which build of the loops around formulas a machine runs. */
#include "config.h"
#include "filter/calc_kernel.h"

#ifdef VV_HAVE_AVX512
extern const vvi_calc_kernels vvi_calc_kernels_avx512;
#endif
#ifdef VV_HAVE_AVX2
extern const vvi_calc_kernels vvi_calc_kernels_avx2;
#endif
extern const vvi_calc_kernels vvi_calc_kernels_base;

static const vvi_calc_kernels *const builds[] = {/* best first; the last always runs */
#ifdef VV_HAVE_AVX512
                                                 &vvi_calc_kernels_avx512,
#endif
#ifdef VV_HAVE_AVX2
                                                 &vvi_calc_kernels_avx2,
#endif
                                                 &vvi_calc_kernels_base};
enum { BUILDS = sizeof builds / sizeof builds[0] };

const vvi_calc_kernels *vvi_calc_kernels_for(uint32_t cpu)
{
    for (size_t i = 0; i < BUILDS; i++)
        if ((builds[i]->needs & ~cpu) == 0)
            return builds[i];
    return builds[BUILDS - 1];
}

const vvi_calc_kernels *vvi_calc_kernels_nth(size_t index)
{
    return index < BUILDS ? builds[index] : NULL;
}
