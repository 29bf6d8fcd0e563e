/* Textures point by point, in single precision; the formulas are in texture.h. */
#include "render/common/texture.h"
#include <math.h>

#define TURN 6.2831853071795865f
#define FAR 4e6f /* places beyond this have no fraction that is worth much, and must still be integers */

static float clampf(float x, float lo, float hi)
{
    return fminf(fmaxf(x, lo), hi); /* NaN is lo */
}

/* What is left of a wave when a point spans `cycles` of it. */
static float fade(float cycles)
{
    return clampf(2 - 4 * cycles, 0, 1);
}

/* Noise --------------------------------------------------------------------------------------------------------- */

static float smooth(float t)
{
    return t * t * t * (t * (t * 6 - 15) + 10);
}

/* The gradient of a lattice point times the way from it: the sum of two of its parts, with signs. */
static float slope(uint32_t hash, float x, float y, float z)
{
    const uint32_t h = hash & 15;
    const float u = h < 8 ? x : y, v = h < 4 ? y : h == 12 || h == 14 ? x : z;
    return (h & 1 ? -u : u) + (h & 2 ? -v : v);
}

static float lerp(float a, float b, float t)
{
    return a + t * (b - a);
}

static float noise(float x, float y, float z, uint32_t seed)
{
    const float fx = floorf(x), fy = floorf(y), fz = floorf(z);
    const int32_t i = (int32_t)fx, j = (int32_t)fy, k = (int32_t)fz;
    float edge[4];
    x -= fx;
    y -= fy;
    z -= fz;
    for (int e = 0; e < 4; e++) {
        const int b = e & 1, c = e >> 1;
        const float yb = y - (float)b, zc = z - (float)c;
        edge[e] = lerp(slope(vvi_texture_hash(i, j + b, k + c, seed), x, yb, zc),
                       slope(vvi_texture_hash(i + 1, j + b, k + c, seed), x - 1, yb, zc), smooth(x));
    }
    return lerp(lerp(edge[0], edge[1], smooth(y)), lerp(edge[2], edge[3], smooth(y)), smooth(z));
}

/* Octaves, each half as high and half as wide as the one before; folded: absolute values. */
static float octaves(const float q[3], float w, bool folded, uint32_t seed)
{
    float sum = 0, scale = 1;
    for (int i = 0; i < VVI_TEXTURE_OCTAVES; i++, scale *= 2) {
        const float left = fade(w * scale);
        if (left <= 0)
            break;
        const float n = noise(q[0] * scale, q[1] * scale, q[2] * scale, seed);
        sum += left / scale * (folded ? fabsf(n) : n);
    }
    return sum;
}

/* Patterns: the second colour's share ---------------------------------------------------------------------------- */

/* The integral of a square wave: 1 from 0 to 1, -1 from 1 to 2. */
static float ramp(float x)
{
    const float half = x / 2;
    return 1 - fabsf(2 * (half - floorf(half)) - 1);
}

/* Mean of the square wave over w about x. Of less than a cell, by the distance to the nearest edge: the difference of
 * two integrals would be mostly rounding. */
static float mean_sign(float x, float w)
{
    if (w > 1)
        return (ramp(x + w / 2) - ramp(x - w / 2)) / w;
    const float cell = floorf(x), in = x - cell, edge = fminf(in, 1 - in);
    const float sign = cell - 2 * floorf(cell / 2) > 0 ? -1.0f : 1.0f;
    return 2 * edge >= w ? sign : sign * 2 * edge / w;
}

static float checker(const float q[3], float w)
{
    return 0.5f - 0.5f * mean_sign(q[0], w) * mean_sign(q[1], w) * mean_sign(q[2], w);
}

static float wood(const float q[3], float w, uint32_t seed)
{
    const float mean = 0.375f, r = hypotf(q[0], q[1]) + noise(q[0] / 4, q[1] / 4, q[2] / 4, seed) / 2;
    const float s = 0.5f + 0.5f * cosf(TURN * (r - floorf(r)));
    const float fibre = fade(6 * w) * 0.15f * noise(6 * q[0], 6 * q[1], q[2] / 2, seed);
    return clampf(mean + fade(w) * (s * s - mean) + fibre, 0, 1);
}

static float marble(const float q[3], float w, uint32_t seed)
{
    const float mean = 0.3125f, x = q[0] + 1.5f * octaves(q, w, true, seed);
    const float s = 0.5f + 0.5f * cosf(TURN * (x - floorf(x)));
    return mean + fade(2 * w) * (s * s * s - mean);
}

static float share_at(const vvi_texture *t, const float q[3], float w)
{
    switch (t->kind) {
    case VV_TEXTURE_CHECKER:
        return checker(q, w);
    case VV_TEXTURE_WOOD:
        return wood(q, w, t->seed);
    case VV_TEXTURE_MARBLE:
        return marble(q, w, t->seed);
    default:
        return clampf(0.5f + 0.75f * octaves(q, w, false, t->seed), 0, 1);
    }
}

/* Images -------------------------------------------------------------------------------------------------------- */

/* A place in an image, and how it changes in one length: images, from the left and from the top. */
typedef struct image_at {
    float u, v, du, dv;
} image_at;

static image_at map_point(const vvi_texture *t, const float q[3])
{
    if (t->mapping == VV_MAP_PLANAR)
        return (image_at){0.5f + q[0], 0.5f - q[2] * t->aspect, 1, t->aspect};
    const float rho = hypotf(q[0], q[1]), u = 0.5f + atan2f(q[0], -q[1]) / TURN, du = 1 / (TURN * fmaxf(rho, 1e-6f));
    if (t->mapping == VV_MAP_CYLINDRICAL)
        return (image_at){u, 0.5f - q[2], du, 1};
    /* atan2 for acos(z / r), which is coarse near the poles */
    return (image_at){u, atan2f(rho, q[2]) * 2 / TURN, du, 2 / (TURN * fmaxf(hypotf(rho, q[2]), 1e-6f))};
}

/* To [0, 1]. */
static float wrapped(float u, int wrap)
{
    if (wrap == VV_WRAP_CLAMP)
        return clampf(u, 0, 1);
    if (wrap == VV_WRAP_REPEAT)
        return u - floorf(u);
    const float twice = u - 2 * floorf(u / 2);
    return twice > 1 ? 2 - twice : twice;
}

/* The two texels on either side along one axis, and the second's weight. Beyond the border lies the other end of an
 * image that repeats; one that is mirrored or clamped has its last texel once more. */
typedef struct texel_pair {
    int32_t at[2];
    float weight;
} texel_pair;

static texel_pair find_texels(float u, int32_t n, int wrap)
{
    const float x = wrapped(u, wrap) * (float)n - 0.5f, first = floorf(x);
    const int32_t i = (int32_t)first;
    const bool round = wrap == VV_WRAP_REPEAT;
    const int32_t lo = i < 0 ? (round ? n - 1 : 0) : i < n ? i : n - 1;
    const int32_t hi = i + 1 < n ? i + 1 : round ? 0 : n - 1;
    return (texel_pair){{lo, hi}, x - first};
}

static void look_up(float rgba[4], const vvi_texture_level *level, const vvi_texture *t, const image_at *p)
{
    const bool planar = t->mapping == VV_MAP_PLANAR;
    const texel_pair x = find_texels(p->u, level->n[0], planar ? t->wrap : VV_WRAP_REPEAT);
    const texel_pair y = find_texels(p->v, level->n[1], t->mapping == VV_MAP_SPHERICAL ? VV_WRAP_CLAMP : t->wrap);
    const float *row[2];
    for (int i = 0; i < 2; i++)
        row[i] = level->rgba + (size_t)y.at[i] * (size_t)level->n[0] * 4;
    const size_t a = (size_t)x.at[0] * 4, b = (size_t)x.at[1] * 4;
    for (size_t c = 0; c < 4; c++)
        rgba[c] =
            lerp(lerp(row[0][a + c], row[0][b + c], x.weight), lerp(row[1][a + c], row[1][b + c], x.weight), y.weight);
}

static void image_color(float rgba[4], const vvi_texture *t, const float q[3], float w)
{
    const image_at p = map_point(t, q);
    const float texels = fmaxf(p.du * (float)t->level[0].n[0], p.dv * (float)t->level[0].n[1]) * w;
    const float level = clampf(log2f(fmaxf(texels, 1)), 0, (float)(t->n_levels - 1)), first = floorf(level);
    const int32_t i = (int32_t)first;
    look_up(rgba, &t->level[i], t, &p);
    if (level > first) {
        float above[4];
        look_up(above, &t->level[i + 1], t, &p);
        for (int c = 0; c < 4; c++)
            rgba[c] = lerp(rgba[c], above[c], level - first);
    }
}

/* On colours ---------------------------------------------------------------------------------------------------- */

static void color_at(float rgba[4], const vvi_texture *t, const float q[3], float w)
{
    if (t->kind == VV_TEXTURE_IMAGE) {
        image_color(rgba, t, q, w);
        return;
    }
    const float share = share_at(t, q, w);
    for (int c = 0; c < 3; c++)
        rgba[c] = lerp(t->color[0][c], t->color[1][c], share);
    rgba[3] = 1;
}

void vvi_texture_apply(float rgb[3][VVI_TEXTURE_LANES], const vvi_texture *t, float at[3][VVI_TEXTURE_LANES],
                       const float distance[VVI_TEXTURE_LANES], uint32_t bits)
{
    for (int l = 0; l < VVI_TEXTURE_LANES; l++) {
        if (!(bits >> l & 1))
            continue;
        float q[3], rgba[4];
        for (int a = 0; a < 3; a++) {
            const float *m = t->from_index[a];
            q[a] = clampf(m[0] * at[0][l] + m[1] * at[1][l] + m[2] * at[2][l] + m[3], -FAR, FAR);
        }
        color_at(rgba, t, q, clampf(t->parallel ? t->pixel : t->pixel * distance[l], 1e-6f, FAR));
        for (int c = 0; c < 3; c++) {
            const float texture = t->replace ? rgba[c] : rgba[c] * rgb[c][l];
            rgb[c][l] = rgb[c][l] * (1 - t->strength * rgba[3]) + t->strength * texture;
        }
    }
}
