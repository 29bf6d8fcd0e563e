/* Images on triangles: what a pixel sees of them, against integrals; and how shares change, against differences. */
#include "core/job.h"
#include "fields.h"
#include "gfx/mesh_look.h"
#include "jobs.h"
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

/* A triangle with one image. */
static vv_mesh *mesh_of(const uint8_t *pixels, int32_t width, int32_t height, int wrap)
{
    static const float positions[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    static const uint32_t triangle[3] = {0, 1, 2};
    const vv_mesh_texture texture = {.width = width, .height = height, .wrap = {wrap, wrap}, .pixels = pixels};
    const vv_mesh_info info = {.n_vertices = 3,
                               .n_triangles = 1,
                               .positions = positions,
                               .triangles = triangle,
                               .n_textures = 1,
                               .textures = &texture};
    vv_mesh *mesh;
    assert_int_equal(vv_mesh_new(&mesh, &info, NULL), VV_OK);
    return mesh;
}

static int32_t wrapped(int32_t i, int32_t n, int wrap)
{
    if (wrap == VV_WRAP_CLAMP)
        return i < 0 ? 0 : i < n ? i : n - 1;
    while (i < 0)
        i += 2 * n;
    i %= wrap == VV_WRAP_REPEAT ? n : 2 * n;
    return i < n ? i : 2 * n - 1 - i;
}

/* Bilinear, linear light, premultiplied: the definition. */
static void exact(double out[4], const uint8_t *pixels, int32_t w, int32_t h, int wrap, double u, double v)
{
    const double x = u * w - 0.5, y = (1 - v) * h - 0.5;
    memset(out, 0, 4 * sizeof *out);
    for (int k = 0; k < 4; k++) {
        const int32_t i = (int32_t)floor(x) + (k & 1), j = (int32_t)floor(y) + (k >> 1);
        const double share = (1 - fabs(x - i)) * (1 - fabs(y - j));
        const uint8_t *p = pixels + 4 * (wrapped(j, h, wrap) * w + wrapped(i, w, wrap));
        for (int c = 0; c < 3; c++)
            out[c] += share * p[3] / 255 * vv_srgb_decode(p[c] / 255.0);
        out[3] += share * p[3] / 255;
    }
}

static void a_place_has_the_bilinear_colour_whatever_the_borders(void **state)
{
    enum { W = 7, H = 5 };
    uint8_t pixels[4 * W * H];
    (void)state;
    for (size_t i = 0; i < sizeof pixels; i++)
        pixels[i] = (uint8_t)(256 * test_random_unit(test_seed(), i));
    for (int wrap = VV_WRAP_REPEAT; wrap <= VV_WRAP_CLAMP; wrap++) {
        vv_mesh *mesh = mesh_of(pixels, W, H, wrap);
        vvi_cached *cached;
        assert_int_equal(vvi_gfx_textures_get(&cached, mesh, NULL), VV_OK);
        const vvi_gfx_textures *t = vvi_cached_value(cached);
        assert_true(t->n == 1 && t->texture[0].translucent);
        for (size_t i = 0; i < 500; i++) {
            const double at[2] = {6 * test_random_unit(1, i) - 2.5, 6 * test_random_unit(2, i) - 2.5},
                         across[2][2] = {{0.9 / W * test_random_unit(3, i), 0}, {0, 0.9 / H}};
            double got[4], want[4];
            vvi_gfx_texture_at(got, t, 0, at, across);
            exact(want, pixels, W, H, wrap, at[0], at[1]);
            assert_true(fabs(got[3] - want[3]) < 1e-6);
            for (int c = 0; c < 3; c++)
                if (!(fabs(got[c] * got[3] - want[c]) < 1e-6))
                    fail_msg("wrap %d, %g, %g: channel %d is %g, not %g", wrap, at[0], at[1], c, got[c] * got[3],
                             want[c]);
        }
        vvi_cache_release(cached);
        vv_mesh_release(mesh);
    }
}

/* Waves along u and v, an odd number of texels; the mean over what a pixel covers, by many places. */
static void a_pixel_has_the_mean_of_what_it_covers(void **state)
{
    enum { W = 251, H = 127, MANY = 64 };
    static uint8_t pixels[4 * W * H];
    double worst = 0, sum = 0;
    int n = 0;
    (void)state;
    for (int32_t j = 0; j < H; j++)
        for (int32_t i = 0; i < W; i++) {
            uint8_t *p = pixels + 4 * (j * W + i);
            p[0] = (uint8_t)(127.5 + 127 * sin(2 * M_PI * 40 * i / W));
            p[1] = (uint8_t)(127.5 + 127 * sin(2 * M_PI * 20 * j / H));
            p[2] = (uint8_t)((i / 8 + j / 8) % 2 * 255);
            p[3] = 255;
        }
    vv_mesh *mesh = mesh_of(pixels, W, H, VV_WRAP_REPEAT);
    vvi_cached *cached;
    assert_int_equal(vvi_gfx_textures_get(&cached, mesh, NULL), VV_OK);
    for (size_t i = 0; i < 300; i++) {
        const double turn = 2 * M_PI * test_random_unit(4, i), size = exp(4 * test_random_unit(5, i)),
                     slim = exp(-2 * test_random_unit(6, i)), at[2] = {test_random_unit(7, i), test_random_unit(8, i)};
        const double across[2][2] = {{size * cos(turn) / W, size * sin(turn) / H},
                                     {-slim * size * sin(turn) / W, slim * size * cos(turn) / H}};
        double got[4], want[4] = {0};
        vvi_gfx_texture_at(got, vvi_cached_value(cached), 0, at, across);
        for (int k = 0; k < MANY * MANY; k++) {
            double one[4];
            const double a = (k % MANY + 0.5) / MANY - 0.5, b = (double)(k / MANY + 0.5) / MANY - 0.5;
            exact(one, pixels, W, H, VV_WRAP_REPEAT, at[0] + a * across[0][0] + b * across[1][0],
                  at[1] + a * across[0][1] + b * across[1][1]);
            for (int c = 0; c < 4; c++)
                want[c] += one[c] / (MANY * MANY);
        }
        for (int c = 0; c < 3; c++, n++) {
            sum += fabs(got[c] - want[c]);
            worst = fmax(worst, fabs(got[c] - want[c]));
        }
    }
    if (!(sum / n < 0.02 && worst < 0.25))
        fail_msg("wrong by %g in the mean, %g at most", sum / n, worst);
    vvi_cache_release(cached);
    vv_mesh_release(mesh);
}

static void shares_change_from_pixel_to_pixel_as_they_do(void **state)
{
    const vv_vec3 corner[3] = {{-3, 1, 9}, {4, -2, 14}, {0.5, 5, 7}};
    (void)state;
    for (int parallel = 0; parallel < 2; parallel++) {
        const vv_lens lens = {.right = {1, 0, 0},
                              .up = {0, 1, 0},
                              .forward = {0, 0, 1},
                              .half_width = parallel ? 8 : 0.7,
                              .half_height = parallel ? 6 : 0.5,
                              .parallel = parallel};
        const vvi_gfx_view view = vvi_gfx_view_of(&lens, 320, 240);
        double share[3][3], slope[2][3];
        vv_vec3 start[3], way[3];
        for (int k = 0; k < 3; k++) { /* here, a hundredth of a pixel to the right, and down */
            const double x = 160 + (k == 1) * 0.01, y = 125 + (k == 2) * 0.01;
            const vv_vec3 across = {(x - 160) / view.scale_x, (120 - y) / view.scale_y, 0};
            start[k] = parallel ? across : (vv_vec3){0};
            way[k] = parallel ? lens.forward : vvi_add(lens.forward, across);
            assert_true(vvi_unit(&way[k]));
            vvi_gfx_shares(share[k], start[k], way[k], corner);
            assert_true(share[k][0] > 0 && share[k][1] > 0 && share[k][2] > 0);
        }
        vvi_gfx_share_slopes(slope, &view, start[0], way[0], corner);
        for (int i = 0; i < 2; i++)
            for (int k = 0; k < 3; k++)
                assert_true(fabs(slope[i][k] - (share[i + 1][k] - share[0][k]) / 0.01) < 1e-6);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_place_has_the_bilinear_colour_whatever_the_borders),
        cmocka_unit_test(a_pixel_has_the_mean_of_what_it_covers),
        cmocka_unit_test(shares_change_from_pixel_to_pixel_as_they_do),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
