/* Bounds of cubic splines along rows; what for, cubic_range.c says. */
#include "core/simd_vec.h"
#include "render/march/kernels.h"

extern vvi_range_mean_kernel VV_KERNEL_TABLE(vvi_range_mean);
void VV_KERNEL_TABLE(vvi_range_mean)(float *restrict to, const float *const from[4], const float weight[4], size_t n)
{
    const vf w0 = vf_set1(weight[0]), w1 = vf_set1(weight[1]), w2 = vf_set1(weight[2]), w3 = vf_set1(weight[3]);
    size_t i = 0;
    for (; i + VV_WIDTH <= n; i += VV_WIDTH)
        vf_store(to + i,
                 vf_fma(w0, vf_load(from[0] + i),
                        vf_fma(w1, vf_load(from[1] + i), vf_fma(w2, vf_load(from[2] + i), w3 * vf_load(from[3] + i)))));
    for (; i < n; i++)
        to[i] = weight[0] * from[0][i] + weight[1] * from[1][i] + weight[2] * from[2][i] + weight[3] * from[3][i];
}

extern vvi_range_fold_kernel VV_KERNEL_TABLE(vvi_range_fold);
void VV_KERNEL_TABLE(vvi_range_fold)(float *restrict lo, float *restrict hi, const float *restrict row, size_t cells)
{
    for (size_t i = 0; i < cells; i += VV_WIDTH) {
        const vf c[4] = {vf_load(row + i), vf_load(row + i + 1), vf_load(row + i + 2), vf_load(row + i + 3)};
        vf least = vf_load(lo + i), most = vf_load(hi + i);
        VV_UNROLL
        for (int p = 0; p < VVI_RANGE_INNER + 2; p++) {
            const float *w = vvi_range_weight[p]; /* of which one is 0 */
            const int first = p > VVI_RANGE_INNER / 2;
            const vf at = vf_fma(vf_set1(w[first]), c[first],
                                 vf_fma(vf_set1(w[first + 1]), c[first + 1], vf_set1(w[first + 2]) * c[first + 2]));
            least = vf_min(least, at);
            most = vf_max(most, at);
        }
        vf_store(lo + i, least);
        vf_store(hi + i, most);
    }
}
