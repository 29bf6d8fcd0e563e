/** @file
 * How much of the light arrives at VV_WIDTH points: light_volume.h with vectors. For kernels only.
 */
#ifndef VVI_RENDER_LIGHT_VOLUME_SIMD_H
#define VVI_RENDER_LIGHT_VOLUME_SIMD_H
#include "core/simd_vec.h"
#include "render/march/volume.h"

/** Eight cells around a point: the first one's number, and how far it is to the next on each axis. */
typedef struct light_place {
    vi cell;
    vf f[3];
} light_place;

/** From a surface to the place whose light it gets, world. */
VV_INLINE vf3 light_ahead(const vvi_light *light, vf3 normal)
{
    vf width = vf_set1(0.0f);
    VV_UNROLL
    for (int a = 0; a < 3; a++) {
        const float *edge = light->ahead[a];
        width = width + vf_abs(vf_fma(vf_set1(edge[0]), normal.x,
                                      vf_fma(vf_set1(edge[1]), normal.y, vf_set1(edge[2]) * normal.z)));
    }
    return vf3_scale(normal, width);
}

/** Around p in the volume's index space, or ahead of it if there is a normal. */
VV_INLINE light_place find_light_place(const vvi_light *light, vf3 p, const vf3 *normal)
{
    const vf3 way = normal ? light_ahead(light, *normal) : p;
    const vf at[3] = {p.x, p.y, p.z}, ahead[3] = {way.x, way.y, way.z};
    const int32_t *dims = light->volume.n, stride[3] = {1, dims[0], dims[0] * dims[1]};
    light_place out;
    out.cell = vi_set1(0);
    VV_UNROLL
    for (int a = 0; a < 3; a++) {
        vf q = vf_set1(light->cell_from_index[a][3]);
        VV_UNROLL
        for (int b = 0; b < 3; b++) {
            q = vf_fma(vf_set1(light->cell_from_index[a][b]), at[b], q);
            if (normal)
                q = vf_fma(vf_set1(light->cell_from_world[a][b]), ahead[b], q);
        }
        q = vf_min(vf_max(q, vf_set1(0.0f)), vf_set1((float)dims[a] - 1.001f)); /* 0 of NaN too */
        const vi whole = vi_trunc(q);
        out.f[a] = q - vf_from_vi(whole);
        out.cell = out.cell + whole * vi_set1(stride[a]);
    }
    return out;
}

/** Shares of the ambient light and of the lamps that are stored, at p in the volume's index space; normal: in the
 * world, on the side that is seen, or 0. */
VV_INLINE void light_shares(vf out[VVI_LIGHT_SHARES], const vvi_light *light, vf3 p, vf3 normal)
{
    const vvi_light_volume *v = &light->volume;
    const light_place at = find_light_place(light, p, &normal);
    const vf one = vf_set1(1.0f);
    const vm all = vm_first_n(VV_WIDTH);
    const vi first = v->n_words == 1 ? at.cell : at.cell * vi_set1(v->n_words);
    for (int i = 0; i < v->n_shares; i++)
        out[i] = vf_set1(0.0f);
    const vf along_y[2] = {one - at.f[1], at.f[1]}, along_z[2] = {one - at.f[2], at.f[2]};
    VV_UNROLL
    for (int row = 0; row < 4; row++) {
        const int32_t step = (row & 1 ? v->n[0] : 0) + (row & 2 ? v->n[0] * v->n[1] : 0);
        const vf weight = along_y[row & 1] * along_z[row >> 1];
        for (int w = 0; w < v->n_words; w++) {
            const uint32_t *words = v->cells + (ptrdiff_t)step * v->n_words + w;
            vi left, right;
            if (v->n_words == 1) { /* neighbours along x stand side by side */
                vi_gather_pair4(words, first, all, &left, &right);
            } else {
                left = vi_gather(words, vi_shl(first, 2), all);
                right = vi_gather(words + v->n_words, vi_shl(first, 2), all);
            }
            for (int i = 4 * w; i < v->n_shares && i < 4 * w + 4; i++) {
                const vf a = vf_from_vi(left & vi_set1(255)), b = vf_from_vi(right & vi_set1(255));
                out[i] = vf_fma(weight, vf_lerp(a, b, at.f[0]), out[i]);
                left = vi_shr_u(left, 8);
                right = vi_shr_u(right, 8);
            }
        }
    }
    for (int i = 0; i < v->n_shares; i++)
        out[i] = out[i] * out[i] * vf_set1(1.0f / (255 * 255));
    out[0] = out[0] * vf_set1(v->ambient);
}

/** What of an unshaded colour is left there: two words hold all eight cells. */
VV_INLINE vf scattered_light(const vvi_light *light, vf3 p, const vf3 *normal)
{
    const light_place at = find_light_place(light, p, normal);
    vi left, right;
    vf edge[4];
    vi_gather_pair4(light->volume.scattered, at.cell, vm_first_n(VV_WIDTH), &left, &right);
    VV_UNROLL
    for (int i = 0; i < 4; i++) {
        const vf a = vf_from_vi(left & vi_set1(255)), b = vf_from_vi(right & vi_set1(255));
        edge[i] = vf_lerp(a, b, at.f[0]);
        left = vi_shr_u(left, 8);
        right = vi_shr_u(right, 8);
    }
    const vf root = vf_lerp(vf_lerp(edge[0], edge[1], at.f[1]), vf_lerp(edge[2], edge[3], at.f[1]), at.f[2]);
    return root * root * vf_set1(1.0f / (255 * 255));
}

#endif
