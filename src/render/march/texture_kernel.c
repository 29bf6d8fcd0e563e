/* Textures on colours, as many points at once as a vector has lanes; the formulas are in texture.h. */
#include "core/simd_math.h"
#include "render/common/texture.h"
#include "render/march/kernels.h"
#include <stddef.h>

#define TURN 6.2831853071795865f
#define FAR 4e6f /* places beyond this have no fraction that is worth much, and must still be integers */

/* Whole numbers that wrap around. */
#if VV_WIDTH == 1
typedef uint32_t vu;
#else
typedef uint32_t vu __attribute__((vector_size(4 * VV_WIDTH)));
#endif

VV_INLINE vf fraction(vf x)
{
    return x - vf_floor(x);
}

/* What is left of a wave when a point spans `cycles` of it. */
VV_INLINE vf fade(vf cycles)
{
    return vf_clamp(vf_fma(cycles, vf_set1(-4.0f), vf_set1(2.0f)), vf_set1(0.0f), vf_set1(1.0f));
}

/* (1 + cos(2 pi x)) / 2, by the sine of pi z for z in [-1/2, 1/2]; error below 1e-7 (least maximum, as simd_math.h). */
VV_INLINE vf wave(vf x)
{
    const vf z = fraction(x) - vf_set1(0.5f), z2 = z * z;
    vf s = vf_set1(0.0776594084f);
    s = vf_fma(s, z2, vf_set1(-0.598292160f));
    s = vf_fma(s, z2, vf_set1(2.55007766f));
    s = vf_fma(s, z2, vf_set1(-5.16771009f));
    s = vf_fma(s, z2, vf_set1(3.14159264f)) * z;
    return s * s;
}

/* The angle of (x, y) from the x axis, in turns: -1/2 to 1/2. Error below 1e-7. */
VV_INLINE vf angle_of(vf y, vf x)
{
    const vf zero = vf_set1(0.0f), ax = vf_abs(x), ay = vf_abs(y);
    const vf t = vf_min(ax, ay) / vf_max(vf_max(ax, ay), vf_set1(1e-30f)), t2 = t * t;
    vf a = vf_set1(-0.000760833207f);
    a = vf_fma(a, t2, vf_set1(0.00390838808f));
    a = vf_fma(a, t2, vf_set1(-0.00953413198f));
    a = vf_fma(a, t2, vf_set1(0.0158243928f));
    a = vf_fma(a, t2, vf_set1(-0.0223285151f));
    a = vf_fma(a, t2, vf_set1(0.0317854308f));
    a = vf_fma(a, t2, vf_set1(-0.0530496745f));
    a = vf_fma(a, t2, vf_set1(0.159154929f)) * t;
    a = vf_select(vf_lt(ax, ay), vf_set1(0.25f) - a, a);
    a = vf_select(vf_lt(x, zero), vf_set1(0.5f) - a, a);
    return vf_select(vf_lt(y, zero), zero - a, a);
}

VV_INLINE vf length2(vf x, vf y)
{
    return vf_sqrt(vf_fma(x, x, y * y));
}

/* Noise --------------------------------------------------------------------------------------------------------- */

/* vvi_texture_hash(), a coordinate at a time: `at` is the coordinate times VVI_HASH_STEP, so that neighbours share. */
VV_INLINE vu hash_on(vu h, vu at)
{
    h = h ^ at;
    return (h << 15 | h >> 17) * VVI_HASH_TURN;
}
VV_INLINE vu hash_end(vu h)
{
    h = h ^ h >> 16;
    h = h * VVI_HASH_MIX_A;
    h = h ^ h >> 13;
    h = h * VVI_HASH_MIX_B;
    return h ^ h >> 16;
}

/* The gradient of a lattice point times the way from it: the sum of two of its parts, with signs. Where a vector holds
 * the table of all 16, by that: the same numbers, as one of three parts is 0. */
#if VV_WIDTH == 16
VV_INLINE vf slope(vu hash, vf x, vf y, vf z)
{
    static const float gx[16] = {1, -1, 1, -1, 1, -1, 1, -1, 0, 0, 0, 0, 1, 0, -1, 0};
    static const float gy[16] = {1, 1, -1, -1, 0, 0, 0, 0, 1, -1, 1, -1, 1, -1, 1, -1};
    static const float gz[16] = {0, 0, 0, 0, 1, 1, -1, -1, 1, 1, -1, -1, 0, 1, 0, -1};
    const vi h = (vi)hash; /* of which permutations take the lowest four bits */
    return vf_fma(vf_permute(vf_load(gx), h), x, vf_fma(vf_permute(vf_load(gy), h), y, vf_permute(vf_load(gz), h) * z));
}
#else
VV_INLINE vf slope(vu hash, vf x, vf y, vf z)
{
    const vi h = (vi)hash & vi_set1(15);
    const vf u = vf_select(vi_lt(h, vi_set1(8)), x, y);
    const vf w = vf_select(vi_eq(h & vi_set1(13), vi_set1(12)), x, z);
    const vf v = vf_select(vi_lt(h, vi_set1(4)), y, w);
    return vf_bits(vi_bits(u) ^ vi_shl(h, 31)) + vf_bits(vi_bits(v) ^ vi_shl(h & vi_set1(2), 30));
}
#endif

VV_INLINE vf smooth(vf t)
{
    const vf p = vf_fma(t, vf_fma(t, vf_set1(6.0f), vf_set1(-15.0f)), vf_set1(10.0f));
    return t * t * t * p;
}

/* Out of line: patterns ask for it up to four times. */
static __attribute__((noinline)) vf noise(const vf q[3], float scale_xy, float scale_z, uint32_t seed)
{
    vf in[3][2], along[3];
    vu at[3][2];
    VV_UNROLL
    for (int a = 0; a < 3; a++) {
        const vf x = q[a] * vf_set1(a < 2 ? scale_xy : scale_z), cell = vf_floor(x);
        in[a][0] = x - cell;
        in[a][1] = in[a][0] - vf_set1(1.0f);
        along[a] = smooth(in[a][0]);
        at[a][0] = (vu)vi_trunc(cell) * VVI_HASH_STEP;
        at[a][1] = at[a][0] + VVI_HASH_STEP;
    }
    const vu start = (vu)vi_set1((int32_t)vvi_hash_start(seed));
    const vu left = hash_on(start, at[0][0]), right = hash_on(start, at[0][1]);
    vf side[2];
    VV_UNROLL
    for (int k = 0; k < 2; k++) {
        vf edge[2];
        VV_UNROLL
        for (int j = 0; j < 2; j++) {
            const vu a = hash_end(hash_on(hash_on(left, at[1][j]), at[2][k]));
            const vu b = hash_end(hash_on(hash_on(right, at[1][j]), at[2][k]));
            edge[j] = vf_lerp(slope(a, in[0][0], in[1][j], in[2][k]), slope(b, in[0][1], in[1][j], in[2][k]), along[0]);
        }
        side[k] = vf_lerp(edge[0], edge[1], along[1]);
    }
    return vf_lerp(side[0], side[1], along[2]);
}

/* Octaves, each half as high and half as wide as the one before; folded: absolute values. */
VV_INLINE vf octaves(const vf q[3], vf w, bool folded, uint32_t seed, vm m)
{
    vf sum = vf_set1(0.0f);
    float scale = 1;
    for (int i = 0; i < VVI_TEXTURE_OCTAVES; i++, scale *= 2) {
        const vf left = fade(w * vf_set1(scale));
        if (!vm_any(vm_and(m, vf_lt(vf_set1(0.0f), left))))
            break;
        const vf n = noise(q, scale, scale, seed);
        sum = vf_fma(left * vf_set1(1 / scale), folded ? vf_abs(n) : n, sum);
    }
    return sum;
}

/* Patterns: the second colour's share ---------------------------------------------------------------------------- */

/* The integral of a square wave: 1 from 0 to 1, -1 from 1 to 2. */
VV_INLINE vf ramp(vf x)
{
    const vf in = fraction(x * vf_set1(0.5f)), one = vf_set1(1.0f);
    return one - vf_abs(in + in - one);
}

/* Mean of the square wave over w about x. Of less than a cell, by the distance to the nearest edge: the difference of
 * two integrals would be mostly rounding. */
VV_INLINE vf mean_sign(vf x, vf w)
{
    const vf half = vf_set1(0.5f), one = vf_set1(1.0f), in = fraction(x);
    const vm odd = vf_le(half, fraction(x * half));
    const vf sign = vf_select(odd, vf_set1(-1.0f), one);
    const vf near = vf_min(vf_set1(2.0f) * vf_min(in, one - in) / w, one) * sign;
    const vf wide = (ramp(vf_fma(w, half, x)) - ramp(x - w * half)) / w;
    return vf_select(vf_lt(one, w), wide, near);
}

VV_INLINE vf share_at(const vvi_texture *t, const vf q[3], vf w, vm m)
{
    const vf zero = vf_set1(0.0f), half = vf_set1(0.5f), one = vf_set1(1.0f);
    if (t->kind == VV_TEXTURE_CHECKER) {
        const vf sign = mean_sign(q[0], w) * mean_sign(q[1], w) * mean_sign(q[2], w);
        return half - half * sign;
    }
    if (t->kind == VV_TEXTURE_WOOD) {
        const vf mean = vf_set1(0.375f);
        const vf s = wave(vf_fma(noise(q, 0.25f, 0.25f, t->seed), half, length2(q[0], q[1])));
        const vf fibre = fade(vf_set1(6.0f) * w) * vf_set1(0.15f) * noise(q, 6.0f, 0.5f, t->seed);
        return vf_clamp(vf_fma(fade(w), s * s - mean, mean) + fibre, zero, one);
    }
    if (t->kind == VV_TEXTURE_MARBLE) {
        const vf mean = vf_set1(0.3125f);
        const vf s = wave(vf_fma(octaves(q, w, true, t->seed, m), vf_set1(1.5f), q[0]));
        return vf_fma(fade(w + w), s * s * s - mean, mean);
    }
    return vf_clamp(vf_fma(octaves(q, w, false, t->seed, m), vf_set1(0.75f), half), zero, one);
}

/* Images -------------------------------------------------------------------------------------------------------- */

/* A place in an image, and how it changes in one length: images, from the left and from the top. */
typedef struct image_at {
    vf u, v, du, dv;
    int wrap_u, wrap_v;
} image_at;

VV_INLINE image_at map_point(const vvi_texture *t, const vf q[3])
{
    const vf half = vf_set1(0.5f), one = vf_set1(1.0f), little = vf_set1(1e-6f);
    image_at p;
    p.wrap_u = t->mapping == VV_MAP_PLANAR ? t->wrap : VV_WRAP_REPEAT;
    p.wrap_v = t->mapping == VV_MAP_SPHERICAL ? VV_WRAP_CLAMP : t->wrap;
    if (t->mapping == VV_MAP_PLANAR) {
        p.u = half + q[0];
        p.v = half - q[2] * vf_set1(t->aspect);
        p.du = one;
        p.dv = vf_set1(t->aspect);
        return p;
    }
    const vf rho = length2(q[0], q[1]);
    p.u = half + angle_of(q[0], vf_set1(0.0f) - q[1]);
    p.du = vf_set1(1 / TURN) / vf_max(rho, little);
    p.v = half - q[2];
    p.dv = one;
    if (t->mapping == VV_MAP_SPHERICAL) { /* not by acos(z / r), which is coarse near the poles */
        p.v = vf_set1(2.0f) * angle_of(rho, q[2]);
        p.dv = vf_set1(2 / TURN) / vf_max(length2(rho, q[2]), little);
    }
    return p;
}

/* To [0, 1]. */
VV_INLINE vf wrapped(vf u, int wrap)
{
    const vf one = vf_set1(1.0f);
    if (wrap == VV_WRAP_CLAMP)
        return vf_clamp(u, vf_set1(0.0f), one);
    if (wrap == VV_WRAP_REPEAT)
        return fraction(u);
    const vf twice = vf_set1(2.0f) * fraction(u * vf_set1(0.5f));
    return vf_min(twice, vf_set1(2.0f) - twice);
}

/* The two texels on either side along one axis, and the second's weight. Beyond the border lies the other end of an
 * image that repeats; one that is mirrored or clamped has its last texel once more. */
typedef struct texel_pair {
    vi at[2];
    vf weight;
} texel_pair;

VV_INLINE texel_pair find_texels(vf u, vi n, int wrap)
{
    const vi zero = vi_set1(0), last = n - vi_set1(1);
    const bool round = wrap == VV_WRAP_REPEAT;
    const vf x = vf_fma(u, vf_from_vi(n), vf_set1(-0.5f)), first = vf_floor(x);
    const vi i = vi_trunc(first), next = i + vi_set1(1);
    texel_pair p;
    p.at[0] = vi_min(vi_select(vi_lt(i, zero), round ? last : zero, i), last);
    p.at[1] = vi_select(vi_lt(last, next), round ? zero : last, next);
    p.weight = x - first;
    return p;
}

/* The level that all lanes of m look in; -1: they differ. */
VV_INLINE int32_t common_level(vi level, vm m)
{
    int32_t of[VV_WIDTH];
    vi_store(of, level);
    const int32_t first = of[__builtin_ctz(vm_bits(m))];
    return vm_any(vm_andnot(m, vi_eq(level, vi_set1(first)))) ? -1 : first;
}

/* Lanes whose texels stand beside each other in memory: no border is between them. */
VV_INLINE vm are_neighbours(const texel_pair *p)
{
    return vi_eq(p->at[1], p->at[0] + vi_set1(1));
}

VV_INLINE void mix_texels(vf rgba[4], vf from[4][4], vf fx, vf fy)
{
    VV_UNROLL
    for (int i = 0; i < 4; i++)
        rgba[i] = vf_lerp(vf_lerp(from[0][i], from[1][i], fx), vf_lerp(from[2][i], from[3][i], fx), fy);
}

/* All in one level. Where no lane is at a border, one number of each says where its four texels are: to take a vector
 * of numbers apart costs as much as the texels. */
static __attribute__((noinline)) bool look_up_inside(vf rgba[4], const vvi_texture *t, const image_at *p,
                                                     const vvi_image_level *level, vm m)
{
    const vi width = vi_set1(level->n[0]), first = vi_set1(level->first);
    const texel_pair x = find_texels(p->u, width, p->wrap_u), y = find_texels(p->v, vi_set1(level->n[1]), p->wrap_v);
    if (vm_any(vm_andnot(m, vm_and(are_neighbours(&x), are_neighbours(&y)))))
        return false;
    const vi at = vi_shl(vi_select(m, first + y.at[0] * width + x.at[0], first), 2);
    const float *texels = t->levels.texels, *below = texels + 4 * (size_t)level->n[0];
    vf four[4][4];
    vf_rows4(four[0], texels, at);
    vf_rows4(four[1], texels + 4, at);
    vf_rows4(four[2], below, at);
    vf_rows4(four[3], below + 4, at);
    mix_texels(rgba, four, x.weight, y.weight);
    return true;
}

/* Each lane in a level of its own. */
static __attribute__((noinline)) void look_up(vf rgba[4], const vvi_texture *t, const image_at *p, vi level, vm m)
{
    enum { ROW = sizeof(vvi_image_level) / sizeof(float) };
    const int32_t common = common_level(level, m);
    if (common >= 0 && look_up_inside(rgba, t, p, &t->levels.level[common], m))
        return;
    vf row[4], four[4][4];
    vf_rows4(row, (const float *)(const void *)t->levels.level, level * vi_set1(ROW));
    const vi width = vi_bits(row[0]), first = vi_bits(row[2]);
    const texel_pair x = find_texels(p->u, width, p->wrap_u), y = find_texels(p->v, vi_bits(row[1]), p->wrap_v);
    const vi above = first + y.at[0] * width, below = first + y.at[1] * width;
    vf_rows4(four[0], t->levels.texels, vi_shl(above + x.at[0], 2));
    vf_rows4(four[1], t->levels.texels, vi_shl(above + x.at[1], 2));
    vf_rows4(four[2], t->levels.texels, vi_shl(below + x.at[0], 2));
    vf_rows4(four[3], t->levels.texels, vi_shl(below + x.at[1], 2));
    mix_texels(rgba, four, x.weight, y.weight);
}

VV_INLINE void image_color(vf rgba[4], const vvi_texture *t, const vf q[3], vf w, vm m)
{
    const vf one = vf_set1(1.0f), last = vf_set1((float)(t->levels.n - 1));
    image_at p = map_point(t, q);
    p.u = wrapped(p.u, p.wrap_u);
    p.v = wrapped(p.v, p.wrap_v);
    const vf texels =
        vf_max(p.du * vf_set1((float)t->levels.level[0].n[0]), p.dv * vf_set1((float)t->levels.level[0].n[1])) * w;
    const vf level = vf_min(vf_log2(vf_max(texels, one)), last), first = vf_floor(level);
    look_up(rgba, t, &p, vi_trunc(first), m);
    if (!vm_any(vm_and(m, vf_lt(first, level))))
        return;
    vf above[4];
    look_up(above, t, &p, vi_trunc(vf_min(first + one, last)), m);
    for (int c = 0; c < 4; c++)
        rgba[c] = vf_lerp(rgba[c], above[c], level - first);
}

/* On colours ---------------------------------------------------------------------------------------------------- */

VV_INLINE void apply(float *const rgb[3], const vvi_texture *t, const float *const at[3], const float *distance, vm m)
{
    const vf nearest = vf_set1(-FAR), far = vf_set1(FAR), strength = vf_set1(t->strength), one = vf_set1(1.0f);
    vf q[3], rgba[4];
    const vf x = vf_load(at[0]), y = vf_load(at[1]), z = vf_load(at[2]);
    for (int a = 0; a < 3; a++) { /* what is no number is -FAR */
        const float *f = t->from_index[a];
        const vf sum = vf_fma(vf_set1(f[0]), x, vf_fma(vf_set1(f[1]), y, vf_fma(vf_set1(f[2]), z, vf_set1(f[3]))));
        q[a] = vf_clamp(sum, nearest, far);
    }
    const vf pixel = (t->parallel ? one : vf_load(distance)) * vf_set1(t->pixel);
    const vf w = vf_clamp(pixel, vf_set1(1e-6f), far);
    if (t->kind == VV_TEXTURE_IMAGE) {
        image_color(rgba, t, q, w, m);
    } else {
        const vf share = share_at(t, q, w, m);
        for (int c = 0; c < 3; c++)
            rgba[c] = vf_lerp(vf_set1(t->color[0][c]), vf_set1(t->color[1][c]), share);
        rgba[3] = one;
    }
    for (int c = 0; c < 3; c++) {
        const vf before = vf_load(rgb[c]), texture = rgba[c] * (t->replace ? one : before);
        vf_store(rgb[c], vf_select(m, vf_fma(strength, texture, before * (one - strength * rgba[3])), before));
    }
}

extern vvi_texture_kernel VV_KERNEL_TABLE(vvi_texture_apply);
void VV_KERNEL_TABLE(vvi_texture_apply)(float rgb[3][VVI_TEXTURE_LANES], const vvi_texture *t,
                                        float at[3][VVI_TEXTURE_LANES], const float distance[VVI_TEXTURE_LANES],
                                        uint32_t bits)
{
    for (int i = 0; i < VVI_TEXTURE_LANES; i += VV_WIDTH) {
        const uint32_t here = bits >> i & ((1U << VV_WIDTH) - 1);
        if (here)
            apply((float *const[]){rgb[0] + i, rgb[1] + i, rgb[2] + i}, t,
                  (const float *const[]){at[0] + i, at[1] + i, at[2] + i}, distance + i, vm_from_bits(here));
    }
}
