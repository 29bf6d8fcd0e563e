/* Textures in double precision. Never removed and never made fast. */
#include "render/common/texture_ref.h"
#include "scene/lens.h"
#include <math.h>

#define PI 3.14159265358979323846

static double fade(double cycles)
{
    return fmin(fmax(2 - 4 * cycles, 0), 1);
}

static uint32_t hash(int32_t i, int32_t j, int32_t k, uint32_t seed)
{
    uint32_t h = vvi_hash_start(seed);
    const int32_t at[3] = {i, j, k};
    for (int a = 0; a < 3; a++) {
        h ^= (uint32_t)at[a] * VVI_HASH_STEP;
        h = (h << 15 | h >> 17) * VVI_HASH_TURN;
    }
    h ^= h >> 16;
    h *= VVI_HASH_MIX_A;
    h ^= h >> 13;
    h *= VVI_HASH_MIX_B;
    return h ^ h >> 16;
}

/* The gradients by number: towards the edges of a cube; the last four again, so that there are 16. */
static const int gradients[16][3] = {{1, 1, 0},  {-1, 1, 0},  {1, -1, 0}, {-1, -1, 0}, {1, 0, 1},  {-1, 0, 1},
                                     {1, 0, -1}, {-1, 0, -1}, {0, 1, 1},  {0, -1, 1},  {0, 1, -1}, {0, -1, -1},
                                     {1, 1, 0},  {0, -1, 1},  {-1, 1, 0}, {0, -1, -1}};

/* A corner's share of the cell, at a distance along one axis. */
static double weight(double distance)
{
    const double t = 1 - fabs(distance);
    return t * t * t * (t * (t * 6 - 15) + 10);
}

double vvi_texture_noise_ref(double x, double y, double z, uint32_t seed)
{
    double sum = 0;
    for (int corner = 0; corner < 8; corner++) {
        const double i = floor(x) + (corner & 1), j = floor(y) + (corner >> 1 & 1), k = floor(z) + (corner >> 2);
        const double dx = x - i, dy = y - j, dz = z - k;
        const int *g = gradients[hash((int32_t)i, (int32_t)j, (int32_t)k, seed) & 15];
        sum += weight(dx) * weight(dy) * weight(dz) * (g[0] * dx + g[1] * dy + g[2] * dz);
    }
    return sum;
}

static double octaves(vv_vec3 q, double w, bool folded, uint32_t seed)
{
    double sum = 0;
    for (int i = 0; i < VVI_TEXTURE_OCTAVES; i++) {
        const double f = pow(2, i), n = vvi_texture_noise_ref(f * q.x, f * q.y, f * q.z, seed);
        sum += fade(f * w) / f * (folded ? fabs(n) : n);
    }
    return sum;
}

/* The mean over w of a wave that is 1 in even cells and -1 in odd ones: its integral is a triangle. */
static double mean_sign(double x, double w)
{
    const double a = fmod(fmod(x - w / 2, 2) + 2, 2), b = fmod(fmod(x + w / 2, 2) + 2, 2);
    return ((1 - fabs(b - 1)) - (1 - fabs(a - 1))) / w;
}

static double share_at(const vv_texture *t, vv_vec3 q, double w)
{
    const double r = hypot(q.x, q.y) + vvi_texture_noise_ref(q.x / 4, q.y / 4, q.z / 4, t->seed) / 2;
    const double rings = pow((1 + cos(2 * PI * r)) / 2, 2);
    const double fibre = vvi_texture_noise_ref(6 * q.x, 6 * q.y, q.z / 2, t->seed);
    const double veins = pow((1 + cos(2 * PI * (q.x + 1.5 * octaves(q, w, true, t->seed)))) / 2, 3);
    double share = 0;
    if (t->kind == VV_TEXTURE_CHECKER)
        share = (1 - mean_sign(q.x, w) * mean_sign(q.y, w) * mean_sign(q.z, w)) / 2;
    else if (t->kind == VV_TEXTURE_WOOD)
        share = 3.0 / 8 + fade(w) * (rings - 3.0 / 8) + 0.15 * fade(6 * w) * fibre;
    else if (t->kind == VV_TEXTURE_MARBLE)
        share = 5.0 / 16 + fade(2 * w) * (veins - 5.0 / 16);
    else
        share = 0.5 + 0.75 * octaves(q, w, false, t->seed);
    return fmin(fmax(share, 0), 1);
}

/* A texel of a level that goes on beyond its borders. */
static int64_t texel(int64_t i, int64_t n, int wrap)
{
    const int64_t period = wrap == VV_WRAP_MIRROR ? 2 * n : n;
    if (wrap == VV_WRAP_CLAMP)
        return i < 0 ? 0 : i < n ? i : n - 1;
    i = (i % period + period) % period;
    return i < n ? i : 2 * n - 1 - i;
}

static void look_up(double rgba[4], const vvi_image_level *level, const int wrap[2], double u, double v)
{
    const double x = u * level->n[0] - 0.5, y = v * level->n[1] - 0.5;
    for (int c = 0; c < 4; c++)
        rgba[c] = 0;
    for (int corner = 0; corner < 4; corner++) {
        const double i = floor(x) + (corner & 1), j = floor(y) + (corner >> 1);
        const double share = (1 - fabs(x - i)) * (1 - fabs(y - j));
        const int64_t at =
            texel((int64_t)j, level->n[1], wrap[1]) * level->n[0] + texel((int64_t)i, level->n[0], wrap[0]);
        for (int c = 0; c < 4; c++)
            rgba[c] += share * (double)level->rgba[4 * at + c];
    }
}

static void image_color(double rgba[4], const vvi_texture *levels, const vv_texture *t, vv_vec3 q, double w)
{
    const double width = t->image->width, height = t->image->height, rho = hypot(q.x, q.y);
    double u = 0.5 + atan2(q.x, -q.y) / (2 * PI), v = 0.5 - q.z, du = 1 / (2 * PI * rho), dv = 1;
    int wrap[2] = {VV_WRAP_REPEAT, t->wrap};
    if (t->mapping == VV_MAP_PLANAR) {
        u = 0.5 + q.x;
        v = 0.5 - q.z * width / height;
        du = 1;
        dv = width / height;
        wrap[0] = t->wrap;
    } else if (t->mapping == VV_MAP_SPHERICAL) {
        v = acos(q.z / vvi_length(q)) / PI;
        dv = 1 / (PI * vvi_length(q));
        wrap[1] = VV_WRAP_CLAMP;
    }
    const double level = log2(fmax(du * width, dv * height) * w);
    const double clamped = fmin(fmax(level, 0), levels->levels.n - 1), below = floor(clamped);
    double a[4], b[4];
    look_up(a, &levels->levels.level[(size_t)below], wrap, u, v);
    look_up(b, &levels->levels.level[(size_t)ceil(clamped)], wrap, u, v);
    for (int c = 0; c < 4; c++)
        rgba[c] = a[c] + (clamped - below) * (b[c] - a[c]);
}

/* Lengths of the texture in one of the World, along the axis where there are most. */
static double per_length(const vv_affine *m)
{
    const double rows[3][3] = {{m->axis[0].x, m->axis[1].x, m->axis[2].x},
                               {m->axis[0].y, m->axis[1].y, m->axis[2].y},
                               {m->axis[0].z, m->axis[1].z, m->axis[2].z}};
    double most = 0;
    for (int i = 0; i < 3; i++)
        most = fmax(most, vvi_length(vvi_vec(rows[i][0], rows[i][1], rows[i][2])));
    return most;
}

void vvi_texture_ref(double rgb[3], const vvi_texture *t, const vv_texture *texture, const vv_lens *lens,
                     int32_t height, vv_vec3 world, double distance)
{
    const vv_vec3 q = vv_affine_point(texture->from_world, world);
    const double pixel = 2 * lens->half_height / height * (lens->parallel ? 1 : distance);
    const double w = pixel * per_length(&texture->from_world);
    double rgba[4] = {0, 0, 0, 1};
    if (texture->kind == VV_TEXTURE_IMAGE) {
        image_color(rgba, t, texture, q, w);
    } else {
        const double share = share_at(texture, q, w);
        for (int c = 0; c < 3; c++)
            rgba[c] = texture->color[0][c] * (1 - share) + texture->color[1][c] * share;
    }
    for (int c = 0; c < 3; c++) {
        const double factor = texture->apply == VV_APPLY_REPLACE ? 1 : rgb[c];
        rgb[c] = rgb[c] * (1 - texture->strength * rgba[3]) + texture->strength * rgba[c] * factor;
    }
}
