/** @file
 * The faces by which the rays of a packet enter their volume: where a cut goes through something solid or dense, light
 * falls on the cut. For kernels only.
 */
#ifndef VVI_RENDER_MARCH_ENTRY_H
#define VVI_RENDER_MARCH_ENTRY_H
#include "render/march/packet.h"

/** Unit normals of the faces by which `lanes` enter, into the volume, which is how gradients point; and which of the
 * faces are those of cut planes. Out of line: it is rare, and one lane after the other. */
static __attribute__((noinline)) void find_entries(float out[3][VV_WIDTH], uint32_t *by_cut_out, const packet *r,
                                                   const vvi_march_volume *f, uint32_t lanes)
{
    *by_cut_out = 0;
    memset(out, 0, 3 * VV_WIDTH * sizeof(float));
    for (int l = 0; l < VV_WIDTH; l++) {
        if (!(lanes >> l & 1))
            continue;
        bool cut = false;
        double best = -INFINITY, normal[3] = {r->dir[0][l], r->dir[1][l], r->dir[2][l]};
        for (int a = 0; a < 3; a++) {
            const double *m = f->sampler.world_to_index[a];
            const double o = m[0] * r->origin[0][l] + m[1] * r->origin[1][l] + m[2] * r->origin[2][l] + m[3];
            const double d = m[0] * r->dir[0][l] + m[1] * r->dir[1][l] + m[2] * r->dir[2][l];
            if (fabs(d) < 1e-200)
                continue;
            const double t = ((d > 0 ? f->sampler.lo[a] : f->sampler.hi[a]) - o) / d;
            if (t > best) {
                best = t;
                for (int i = 0; i < 3; i++)
                    normal[i] = d > 0 ? m[i] : -m[i];
            }
        }
        for (size_t p = 0; p < f->sampler.n_planes; p++) {
            const double *n = f->sampler.planes[p];
            const double d = n[0] * r->dir[0][l] + n[1] * r->dir[1][l] + n[2] * r->dir[2][l];
            const double o = n[0] * r->origin[0][l] + n[1] * r->origin[1][l] + n[2] * r->origin[2][l];
            if (d > 1e-200 && (n[3] - o) / d >= best) {
                best = (n[3] - o) / d;
                memcpy(normal, n, sizeof normal);
                cut = true;
            }
        }
        /* the eye itself is inside: there is no face, and the cut is seen straight on */
        const bool at_eye = best < 0;
        const double s = at_eye ? 1 : 1 / sqrt(normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2]);
        for (int i = 0; i < 3; i++)
            out[i][l] = (float)((at_eye ? r->dir[i][l] : normal[i]) * s);
        *by_cut_out |= (uint32_t)(cut && !at_eye) << l;
    }
}

/** The same of the lanes in `flat`, long enough to count as gradients. */
VV_INLINE vf3 entry_gradient(const packet *r, const vvi_march_volume *f, vm flat)
{
    float g[3][VV_WIDTH];
    uint32_t by_cut;
    find_entries(g, &by_cut, r, f, vm_bits(flat));
    return vf3_scale(vf3_set(vf_load(g[0]), vf_load(g[1]), vf_load(g[2])),
                     vf_set1(2.0f * f->light.flat_gradient + 1.0f));
}

/** Gradients of samples (k steps along ray number `lane`), but on cuts: what lies less than a voxel behind the face of
 * a cut plane is lit as that face. */
VV_INLINE vf3 cap_gradient(vf3 g, const packet *r, const vvi_march_volume *f, vf k, vi lane, vm m)
{
    const vm near = vm_and(m, vf_lt(k, vf_set1(f->light.cap_depth)));
    if (!f->light.capped || !vm_any(near))
        return g;
    float e[3][VV_WIDTH];
    int32_t of[VV_WIDTH];
    uint32_t lanes = 0, by_cut = 0, capped = 0;
    vi_store(of, lane);
    for (int i = 0; i < VV_WIDTH; i++)
        lanes |= (vm_bits(near) >> i & 1) << of[i];
    find_entries(e, &by_cut, r, f, lanes);
    for (int i = 0; i < VV_WIDTH; i++)
        capped |= (vm_bits(near) >> i & by_cut >> of[i] & 1) << i;
    const vm cap = vm_from_bits(capped);
    const vf size = vf_set1(2.0f * f->light.flat_gradient + 1.0f);
    g.x = vf_select(cap, vf_permute(vf_load(e[0]), lane) * size, g.x);
    g.y = vf_select(cap, vf_permute(vf_load(e[1]), lane) * size, g.y);
    g.z = vf_select(cap, vf_permute(vf_load(e[2]), lane) * size, g.z);
    return g;
}

/** Numbers of the lanes themselves. */
VV_INLINE vi own_lanes(void)
{
    int32_t lanes[VV_WIDTH];
    for (int l = 0; l < VV_WIDTH; l++)
        lanes[l] = l;
    return vi_load(lanes);
}

#endif
