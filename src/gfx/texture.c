#include "gfx/texture.h"
#include "core/job.h"
#include "core/memory.h"
#include "image/image_srgb.h"
#include <math.h>
#include <string.h>

enum { PLACES_MOST = 8 };

/* Pyramids -------------------------------------------------------------------------------------------------------- */

static void drop(void *value)
{
    vvi_gfx_textures *all = value;
    for (size_t i = 0; all->texture && i < all->n; i++)
        vvi_free(all->texture[i].texels);
    vvi_free(all->texture);
    vvi_free(all);
}

/* As images have them: linear and premultiplied. */
static void put_light(float *rgba, const uint8_t *pixels, size_t n, const vvi_gfx_decode *decode)
{
    for (size_t i = 0; i < 4 * n; i += 4) {
        const float a = (float)pixels[i + 3] / 255;
        for (size_t c = 0; c < 3; c++)
            rgba[i + c] = a * decode->light[pixels[i + c]];
        rgba[i + 3] = a;
    }
}

static vv_status build_levels(vvi_image_levels *out, const vv_mesh_texture *from, const vvi_gfx_decode *decode,
                              vv_job *job)
{
    vv_image *image;
    vv_status st = vv_image_new(&image, from->width, from->height, 0, job);
    if (st != VV_OK)
        return st;
    put_light(image->rgba, from->pixels, (size_t)from->width * (size_t)from->height, decode);
    st = vvi_image_levels_build(out, image, job);
    vv_image_release(image);
    return st;
}

/* The first level as it came, the others rounded to what pixels are. */
static vv_status make_texture(vvi_gfx_texture *out, const vv_mesh_texture *from, const vvi_gfx_decode *decode,
                              vv_job *job)
{
    vvi_image_levels levels = {0};
    vv_status st = build_levels(&levels, from, decode, job);
    size_t n = 0;
    for (int32_t i = 0; i < levels.n && st == VV_OK; i++) {
        out->first[i] = n;
        memcpy(out->n[i], levels.level[i].n, sizeof out->n[i]);
        n += (size_t)out->n[i][0] * (size_t)out->n[i][1];
    }
    if (st == VV_OK && !(out->texels = vvi_alloc(job, 4 * n, VVI_MEM_DERIVED)))
        st = vv_fail_memory(4 * n);
    if (st == VV_OK) {
        const size_t whole = (size_t)from->width * (size_t)from->height;
        vvi_srgb_table table;
        vvi_srgb_table_init(&table);
        memcpy(out->texels, from->pixels, 4 * whole);
        for (size_t i = whole; i < n; i++)
            vvi_srgb_pixel(out->texels + 4 * i, &table, levels.texels + 4 * i);
        for (size_t i = 0; i < whole && !out->translucent; i++)
            out->translucent = from->pixels[4 * i + 3] < 255;
        out->n_levels = levels.n;
        memcpy(out->wrap, from->wrap, sizeof out->wrap);
    }
    vvi_image_levels_free(&levels);
    return st;
}

static vv_status make(void **value_out, uint64_t *bytes_out, void *user, vv_job *job)
{
    const vv_mesh_info *m = vv_mesh_get_info(user);
    const size_t bytes = m->n_textures * sizeof(vvi_gfx_texture);
    vvi_gfx_textures *all = vvi_alloc_zeroed(job, sizeof *all, VVI_MEM_DERIVED);
    if (!all)
        return vv_fail_memory(sizeof *all);
    *bytes_out = sizeof *all + bytes;
    vvi_gfx_decode_init(&all->decode);
    all->texture = vvi_alloc_zeroed(job, bytes, VVI_MEM_DERIVED);
    vv_status st = all->texture ? VV_OK : vv_fail_memory(bytes);
    for (size_t i = 0; i < m->n_textures && st == VV_OK; i++) {
        const vv_mesh_texture *from = &m->textures[i];
        all->n = i + 1;
        st = make_texture(&all->texture[i], from, &all->decode, job);
        *bytes_out += 16 * (uint64_t)from->width * (uint64_t)from->height / 3;
    }
    if (st == VV_OK) {
        *value_out = all;
        return VV_OK;
    }
    drop(all);
    return st;
}

vv_status vvi_gfx_textures_get(vvi_cached **out, const vv_mesh *mesh, vv_job *job)
{
    const vvi_cache_key key = {"mesh textures", 0, vv_mesh_checksum(mesh)};
    return vvi_cache_get(out, &key, make, drop, (void *)(uintptr_t)mesh, job);
}

/* Looking up ------------------------------------------------------------------------------------------------------ */

void vvi_gfx_decode_init(vvi_gfx_decode *out)
{
    for (int i = 0; i < 256; i++)
        out->light[i] = (float)vv_srgb_decode(i / 255.0);
}

/* A texel of a level that goes on beyond its borders; i is far from what int64_t has not. */
static int64_t texel(int64_t i, int64_t n, int wrap)
{
    if (i >= 0 && i < n)
        return i;
    if (wrap == VV_WRAP_CLAMP)
        return i < 0 ? 0 : n - 1;
    const int64_t period = wrap == VV_WRAP_MIRROR ? 2 * n : n;
    i = (i % period + period) % period;
    return i < n ? i : 2 * n - 1 - i;
}

/* Adds `weight` times the bilinear colour at (u, v), premultiplied. */
static void look_up(double sum[4], double weight, const vvi_gfx_texture *t, int32_t level, const vvi_gfx_decode *decode,
                    double u, double v)
{
    const int32_t *n = t->n[level];
    const double x = u * n[0] - 0.5, y = v * n[1] - 0.5, left = floor(x), top = floor(y);
    const double share[2][2] = {{1 - (x - left), x - left}, {1 - (y - top), y - top}};
    const uint8_t *texels = t->texels + 4 * t->first[level];
    for (int k = 0; k < 4; k++) {
        const int64_t i = texel((int64_t)left + (k & 1), n[0], t->wrap[0]),
                      j = texel((int64_t)top + (k >> 1), n[1], t->wrap[1]);
        const uint8_t *p = texels + 4 * (j * n[0] + i);
        const double w = weight * share[0][k & 1] * share[1][k >> 1], a = p[3] == 255 ? w : w * p[3] / 255;
        for (int c = 0; c < 3; c++)
            sum[c] += a * (double)decode->light[p[c]];
        sum[3] += a;
    }
}

/* Whole images more or less do not matter, and places far out lose no precision in whole numbers. */
static double settle(double at, int wrap)
{
    const double least = -4, most = 5;
    if (wrap == VV_WRAP_CLAMP)
        return at < least ? least : at > most ? most : at;
    return at - 2 * floor(at / 2);
}

void vvi_gfx_texture_at(double rgba[4], const vvi_gfx_textures *textures, size_t index, const double at[2],
                        const double across[2][2])
{
    const vvi_gfx_texture *t = &textures->texture[index];
    const vvi_gfx_decode *decode = &textures->decode;
    const double a[2] = {across[0][0] * t->n[0][0], across[0][1] * t->n[0][1]},
                 b[2] = {across[1][0] * t->n[0][0], across[1][1] * t->n[0][1]};
    const double side[2] = {sqrt(a[0] * a[0] + a[1] * a[1]), sqrt(b[0] * b[0] + b[1] * b[1])},
                 area = fabs(a[0] * b[1] - a[1] * b[0]);
    const int longer = side[1] > side[0];
    const double most = side[longer], least = most > 0 ? area / most : 0;
    int places = 1;
    if (most > 1)
        places = most < PLACES_MOST * fmax(least, 1) ? (int)ceil(most / fmax(least, 1)) : PLACES_MOST;
    const double width = fmax(most / places, 1), level = fmin(log2(width), t->n_levels - 1), below = floor(level);
    double sum[4] = {0};
    if (!isfinite(at[0] + at[1] + level)) {
        rgba[0] = rgba[1] = rgba[2] = rgba[3] = 1;
        return;
    }
    for (int i = 0; i < places; i++) {
        const double way = (i + 0.5) / places - 0.5, u = settle(at[0] + way * across[longer][0], t->wrap[0]),
                     v = settle(1 - at[1] - way * across[longer][1], t->wrap[1]);
        if (level < below + 1)
            look_up(sum, (below + 1 - level) / places, t, (int32_t)below, decode, u, v);
        if (level > below)
            look_up(sum, (level - below) / places, t, (int32_t)below + 1, decode, u, v);
    }
    for (int c = 0; c < 3; c++)
        rgba[c] = sum[3] > 0 ? sum[c] / sum[3] : 0;
    rgba[3] = fmin(sum[3], 1);
}
