/* The software back end against rays: what each pixel sees, how far, how bright; covered once; hidden by depth. */
#include "core/memory.h"
#include "core/vec.h"
#include "fail_alloc.h"
#include "fields.h"
#include "gfx/gfx.h"
#include "jobs.h"
#include "render/common/shade_ref.h"
#include "scene/lens.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static const vv_color white = {1, 1, 1, 1}, red = {1, 0, 0, 1};

static vv_lens lens_at(double distance, bool parallel, double half)
{
    return (vv_lens){.eye = {0, -distance, 0},
                     .right = {1, 0, 0},
                     .up = {0, 0, 1},
                     .forward = {0, 1, 0},
                     .half_width = half,
                     .half_height = half,
                     .parallel = parallel};
}

static vv_image *picture(int32_t width, int32_t height)
{
    vv_image *image;
    assert_int_equal(vv_image_new(&image, width, height, VV_LAYER_DEPTH | VV_LAYER_NORMAL | VV_LAYER_ID, NULL), VV_OK);
    return image;
}

static vvi_gfx *begin(vv_image *image, int samples, vv_job *job)
{
    vvi_gfx *gfx;
    const vvi_gfx_target target = {.image = image, .samples = samples};
    assert_int_equal(vvi_gfx_begin(&gfx, &vvi_gfx_software, &target, job), VV_OK);
    return gfx;
}

/* Triangles ------------------------------------------------------------------------------------------------------- */

enum { TRIANGLES = 60 };

typedef struct soup {
    float positions[9 * TRIANGLES];
    uint32_t triangles[3 * TRIANGLES];
    vv_mesh_info info;
} soup;

/* Triangles of all sizes around the origin. */
static void make_soup(soup *s, uint64_t seed)
{
    for (uint32_t t = 0; t < TRIANGLES; t++) {
        double middle[3];
        for (int a = 0; a < 3; a++)
            middle[a] = 1.6 * test_random_unit(seed, 100 * t + (uint64_t)a) - 0.8;
        const double size = pow(10, -2 * test_random_unit(seed, 100 * t + 4));
        for (uint32_t k = 0; k < 9; k++)
            s->positions[9 * t + k] =
                (float)(middle[k % 3] + size * (2 * test_random_unit(seed, 100 * t + 10 + k) - 1));
        for (uint32_t k = 0; k < 3; k++)
            s->triangles[3 * t + k] = 3 * t + k;
    }
    s->info = (vv_mesh_info){.n_vertices = (size_t)3 * TRIANGLES,
                             .n_triangles = TRIANGLES,
                             .positions = s->positions,
                             .triangles = s->triangles};
}

static vv_vec3 place_of(const soup *s, uint32_t t, int k)
{
    const float *p = s->positions + 9 * t + 3 * k;
    return vvi_vec((double)p[0], (double)p[1], (double)p[2]);
}

/* How far from an edge, as a share of the triangle; below 0: outside. *depth: where the ray meets the plane. */
static double inside(double *depth, const soup *s, uint32_t t, vv_vec3 origin, vv_vec3 way)
{
    const vv_vec3 a = place_of(s, t, 0), e1 = vvi_sub(place_of(s, t, 1), a), e2 = vvi_sub(place_of(s, t, 2), a);
    const vv_vec3 n = vvi_cross(e1, e2), to = vvi_sub(a, origin);
    *depth = vvi_dot(n, to) / vvi_dot(n, way);
    const vv_vec3 p = vvi_sub(vvi_add(origin, vvi_scaled(way, *depth)), a);
    const double u = vvi_dot(vvi_cross(p, e2), n) / vvi_dot(n, n), v = vvi_dot(vvi_cross(e1, p), n) / vvi_dot(n, n);
    return fmin(fmin(u, v), 1 - u - v);
}

/* Pixels whose ray passes this near to an edge, as a share of a triangle, are not asked: places are rounded. */
static double margin_of(const soup *s, uint32_t t, double pixel)
{
    const vv_vec3 a = place_of(s, t, 0), e1 = vvi_sub(place_of(s, t, 1), a), e2 = vvi_sub(place_of(s, t, 2), a);
    const double longest = fmax(fmax(vvi_length(e1), vvi_length(e2)), vvi_length(vvi_sub(e2, e1)));
    const double height = vvi_length(vvi_cross(e1, e2)) / longest;
    return pixel / 100 / height;
}

static void pixels_see_the_triangle_that_their_ray_meets_first(void **state)
{
    (void)state;
    const int32_t n = 97;
    for (uint64_t seed = 0; seed < 8; seed++) {
        soup s;
        make_soup(&s, seed);
        const bool parallel = seed & 1;
        const vv_lens lens = lens_at(seed < 6 ? 4 : 0.3, parallel, parallel ? 1 : 0.3);
        vv_image *image = picture(n, n);
        vvi_gfx *gfx = begin(image, 1, NULL);
        vvi_gfx_camera(gfx, &lens);
        vvi_gfx_id(gfx, 7);
        const vvi_gfx_surface surface = {.mesh = &s.info, .place = vv_affine_identity(), .color = white};
        assert_int_equal(vvi_gfx_mesh(gfx, &surface), VV_OK);
        assert_int_equal(vvi_gfx_end(gfx), VV_OK);
        int asked = 0, hits = 0;
        for (int32_t y = 0; y < n; y++)
            for (int32_t x = 0; x < n; x++) {
                vv_vec3 origin, way;
                double nearest = INFINITY;
                bool sure = true;
                vvi_lens_ray(&origin, &way, &lens, n, n, x + 0.5, y + 0.5);
                for (uint32_t t = 0; t < TRIANGLES; t++) {
                    double depth;
                    const double in = inside(&depth, &s, t, origin, way),
                                 pixel = parallel ? 2.0 / n : 0.6 / n * fmax(depth, 0.01);
                    sure &= fabs(in) > 4 * margin_of(&s, t, pixel) || !(depth > 0);
                    if (in > 0 && depth > 0)
                        nearest = fmin(nearest, depth);
                }
                if (!sure)
                    continue;
                const size_t i = (size_t)(y * n + x);
                asked++;
                hits += isfinite(nearest);
                assert_int_equal(image->id[i], isfinite(nearest) ? 7 : 0);
                if (isfinite(nearest))
                    assert_float_equal(image->depth[i], nearest, 1e-4 * nearest + 1e-5);
                else
                    assert_true(isinf(image->depth[i]));
            }
        assert_true(asked > n * n / 3);
        assert_true(hits > 100);
        vv_image_release(image);
    }
}

/* Around the eye ----------------------------------------------------------------------------------------------------
 */

/* Triangles around the eye, before it and behind it, from far smaller than their distance to far larger; many have
 * corners on both sides of the eye's plane, and some lie in it. */
static void make_soup_around(soup *s, uint64_t seed, vv_vec3 eye)
{
    const double at[3] = {eye.x, eye.y, eye.z};
    make_soup(s, seed);
    for (uint32_t t = 0; t < TRIANGLES; t++) {
        const double distance = pow(10, 4 * test_random_unit(seed, 100 * t + 50) - 2);
        const double size = distance * pow(10, 2 * test_random_unit(seed, 100 * t + 51) - 1);
        for (uint32_t a = 0; a < 3; a++) {
            const double middle = distance * (2 * test_random_unit(seed, 100 * t + 60 + a) - 1);
            for (uint32_t k = a; k < 9; k += 3)
                s->positions[9 * t + k] =
                    (float)(at[a] + middle + size * (2 * test_random_unit(seed, 100 * t + 70 + k) - 1));
        }
        if (t % 10 == 0) /* a corner in the eye's plane */
            s->positions[9 * t + 1] = (float)at[1];
    }
}

/* Where rays around the middle of a pixel first meet a triangle; INFINITY: nowhere. False: they do not agree, or the
 * place is as near as what is cut off. */
static bool first_of_pixel(double *nearest, const soup *s, const vv_lens *lens, double reach, int32_t n, int32_t x,
                           int32_t y)
{
    static const double aside[5][2] = {{0, 0}, {-0.02, -0.02}, {0.02, -0.02}, {-0.02, 0.02}, {0.02, 0.02}};
    *nearest = INFINITY;
    for (uint32_t t = 0; t < TRIANGLES; t++) {
        int met = 0;
        double first = INFINITY;
        for (int i = 0; i < 5; i++) {
            vv_vec3 origin, way;
            double depth;
            vvi_lens_ray(&origin, &way, lens, n, n, x + 0.5 + aside[i][0], y + 0.5 + aside[i][1]);
            const bool in = inside(&depth, s, t, origin, way) > 0 && depth > 0;
            met += in;
            first = in && i == 0 ? depth : first;
            if (in && depth < 4e-6 * reach)
                return false;
        }
        if (met != 0 && met != 5)
            return false;
        *nearest = fmin(*nearest, first);
    }
    return true;
}

static double reach_of(const soup *s, vv_vec3 eye)
{
    double most = 0;
    for (uint32_t t = 0; t < TRIANGLES; t++)
        for (int k = 0; k < 3; k++)
            most = fmax(most, vvi_length(vvi_sub(place_of(s, t, k), eye)));
    return most;
}

static void triangles_around_the_eye_are_seen_by_the_rays_that_meet_them(void **state)
{
    (void)state;
    const int32_t n = 149; /* several tiles */
    const double degrees[] = {10, 30, 60, 90, 120, 150};
    for (uint64_t seed = 0; seed < 12; seed++) {
        soup s;
        const double half = tan(degrees[seed % 6] * 3.14159265358979 / 360);
        const vv_lens lens = lens_at(seed < 6 ? 0 : 3, false, half);
        make_soup_around(&s, 100 + seed, lens.eye);
        const double reach = reach_of(&s, lens.eye);
        vv_image *image = picture(n, n);
        vvi_gfx *gfx = begin(image, 1, NULL);
        vvi_gfx_camera(gfx, &lens);
        vvi_gfx_id(gfx, 7);
        const vvi_gfx_surface surface = {.mesh = &s.info, .place = vv_affine_identity(), .color = white};
        assert_int_equal(vvi_gfx_mesh(gfx, &surface), VV_OK);
        assert_int_equal(vvi_gfx_end(gfx), VV_OK);
        int asked = 0;
        for (int32_t y = 0; y < n; y++)
            for (int32_t x = 0; x < n; x++) {
                const size_t i = (size_t)(y * n + x);
                double nearest;
                assert_true(image->depth[i] > 0);
                if (!first_of_pixel(&nearest, &s, &lens, reach, n, x, y))
                    continue;
                asked++;
                assert_int_equal(image->id[i], isfinite(nearest) ? 7 : 0);
                if (isfinite(nearest))
                    assert_float_equal(image->depth[i], nearest, 1e-4 * nearest + 2e-6 * reach);
            }
        assert_true(asked > n * n / 3);
        vv_image_release(image);
    }
}

/* A fan of a random star-shaped outline around an inner point: its triangles share edges and one vertex. */
static void every_sample_of_a_plane_is_covered_once(void **state)
{
    (void)state;
    enum { N = 64, GRID = 12 };
    float positions[3 * (GRID + 1) * (GRID + 1)];
    uint32_t triangles[6 * GRID * GRID];
    const vv_lens lens = lens_at(1, true, 1);
    for (int samples = 1; samples <= 8; samples *= samples == 1 ? 4 : 2) {
        for (uint32_t j = 0; j <= GRID; j++)
            for (uint32_t i = 0; i <= GRID; i++) {
                const uint32_t v = j * (GRID + 1) + i;
                const bool rim = i == 0 || j == 0 || i == GRID || j == GRID;
                const double shift = rim ? 0 : 0.08;
                positions[3 * v] = (float)(1.1 * (2.0 * i / GRID - 1) + shift * (test_random_unit(5, 2 * v) - 0.5));
                positions[3 * v + 1] = 0;
                positions[3 * v + 2] =
                    (float)(1.1 * (2.0 * j / GRID - 1) + shift * (test_random_unit(5, 2 * v + 1) - 0.5));
            }
        uint32_t *t = triangles;
        for (uint32_t j = 0; j < GRID; j++)
            for (uint32_t i = 0; i < GRID; i++) {
                const uint32_t a = j * (GRID + 1) + i, b = a + 1, c = a + GRID + 1, d = c + 1;
                const uint32_t six[6] = {a, b, c, b, d, c};
                memcpy(t, six, sizeof six);
                t += 6;
            }
        /* each drawn alone adds its share of light: together they must be 1 */
        vv_image *sum = picture(N, N);
        for (uint32_t k = 0; k < 2 * GRID * GRID; k++) {
            const vv_mesh_info one = {.n_vertices = (size_t)(GRID + 1) * (GRID + 1),
                                      .n_triangles = 1,
                                      .positions = positions,
                                      .triangles = triangles + 3 * k};
            const vvi_gfx_material none = {.model = VV_SHADING_NONE};
            vv_image *image = picture(N, N);
            vvi_gfx *gfx = begin(image, samples, NULL);
            vvi_gfx_camera(gfx, &lens);
            vvi_gfx_set_material(gfx, &none);
            const vvi_gfx_surface surface = {.mesh = &one, .place = vv_affine_identity(), .color = white};
            assert_int_equal(vvi_gfx_mesh(gfx, &surface), VV_OK);
            assert_int_equal(vvi_gfx_end(gfx), VV_OK);
            for (size_t i = 0; i < (size_t)N * N; i++)
                sum->rgba[4 * i + 3] += image->rgba[4 * i + 3];
            vv_image_release(image);
        }
        for (size_t i = 0; i < (size_t)N * N; i++)
            assert_float_equal(sum->rgba[4 * i + 3], 1, 0);
        vv_image_release(sum);
    }
}

static const vv_mesh_info *square(double y, double half)
{
    static float positions[12];
    static const uint32_t triangles[6] = {0, 1, 2, 0, 2, 3};
    static vv_mesh_info info;
    const double corner[4][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
    for (int i = 0; i < 4; i++) {
        positions[3 * i] = (float)(half * corner[i][0]);
        positions[3 * i + 1] = (float)y;
        positions[3 * i + 2] = (float)(half * corner[i][1]);
    }
    info = (vv_mesh_info){.n_vertices = 4, .n_triangles = 2, .positions = positions, .triangles = triangles};
    return &info;
}

static void light_is_that_of_the_definition(void **state)
{
    (void)state;
    const vv_lens lens = lens_at(3, false, 0.3);
    vv_lamp lamps[3] = {{.kind = VV_LIGHT_DIRECTIONAL, .direction = {0.6, 0.8, 0}, .color = {1, 0.5f, 0.25f}},
                        {.kind = VV_LIGHT_POINT, .position = {0, -2, 1}, .color = {2, 2, 2}, .falloff = {1, 0.1, 0.2}},
                        {.kind = VV_LIGHT_SPOT,
                         .position = {0.5, -2, 0},
                         .direction = {0, 1, 0},
                         .color = {1, 2, 3},
                         .falloff = {1, 0, 0},
                         .cos_outer = 0.9,
                         .cos_inner = 0.99}};
    const float ambient[3] = {0.5f, 0.25f, 0.125f};
    for (int model = 0; model < 3; model++)
        for (int sides = 0; sides < 3; sides++) {
            const vvi_gfx_material material = {
                .model = model, .ambient = 0.5f, .diffuse = 0.5f, .specular = 0.5f, .shininess = 20, .sides = sides};
            vv_image *image = picture(16, 16);
            vvi_gfx *gfx = begin(image, 1, NULL);
            vvi_gfx_camera(gfx, &lens);
            assert_int_equal(vvi_gfx_lights(gfx, lamps, 3, ambient), VV_OK);
            vvi_gfx_set_material(gfx, &material);
            const vvi_gfx_surface surface = {
                .mesh = square(0, 2), .place = vv_affine_identity(), .color = {0.2, 0.4, 0.8, 1}};
            assert_int_equal(vvi_gfx_mesh(gfx, &surface), VV_OK);
            assert_int_equal(vvi_gfx_end(gfx), VV_OK);
            const vv_scene scene = {.lamps = lamps, .n_lamps = 3, .ambient = {0.5f, 0.25f, 0.125f}};
            const vv_actor actor = {.shading_model = model,
                                    .ambient = 0.5f,
                                    .diffuse = 0.5f,
                                    .specular = 0.5f,
                                    .shininess = 20,
                                    .two_sided = sides == VVI_GFX_BOTH};
            for (int i = 0; i < 256; i++) {
                vv_vec3 origin, way;
                const double color[3] = {0.2, 0.4, 0.8};
                double expected[3];
                vvi_lens_ray(&origin, &way, &lens, 16, 16, i % 16 + 0.5, i / 16 + 0.5);
                const double depth = 3 / way.y;
                assert_float_equal(image->depth[i], depth, 1e-5 * depth);
                vvi_shade_ref(expected, &scene, &actor, color, vvi_add(origin, vvi_scaled(way, depth)),
                              vvi_vec(0, 1, 0), vvi_scaled(way, -1), 1e-6, NULL);
                for (int c = 0; c < 3; c++)
                    assert_float_equal(image->rgba[4 * i + c], expected[c], 2e-4);
            }
            vv_image_release(image);
        }
}

/* With what is there already ----------------------------------------------------------------------------------------
 */

static void depth_merges_with_what_the_image_has(void **state)
{
    (void)state;
    const vv_lens lens = lens_at(2, false, 0.3);
    const vvi_gfx_material none = {.model = VV_SHADING_NONE};
    vv_image *image = picture(8, 8);
    for (size_t i = 0; i < 64; i++) {
        image->rgba[4 * i + 2] = 0.5f;
        image->rgba[4 * i + 3] = 0.5f;
        image->depth[i] = i % 8 < 4 ? 1 : 10; /* before the square, and behind it */
        image->id[i] = 3;
    }
    vvi_gfx *gfx = begin(image, 4, NULL);
    vvi_gfx_camera(gfx, &lens);
    vvi_gfx_set_material(gfx, &none);
    vvi_gfx_id(gfx, 9);
    const vvi_gfx_surface surface = {.mesh = square(0, 2), .place = vv_affine_identity(), .color = red};
    assert_int_equal(vvi_gfx_mesh(gfx, &surface), VV_OK);
    assert_int_equal(vvi_gfx_end(gfx), VV_OK);
    for (size_t i = 0; i < 64; i++) {
        const bool hidden = i % 8 < 4;
        assert_float_equal(image->rgba[4 * i], hidden ? 0.5 : 1, 1e-6);
        assert_float_equal(image->rgba[4 * i + 2], hidden ? 0.5 : 0, 1e-6);
        assert_float_equal(image->rgba[4 * i + 3], 1, 1e-6);
        assert_int_equal(image->id[i], hidden ? 3 : 9);
        assert_true(hidden ? image->depth[i] == 1 : image->depth[i] < 3);
    }
    vv_image_release(image);
}

/* Two squares of different colours and opacities, the red one nearer; each of two triangles. */
static vv_image *squares(bool red_first, int samples)
{
    static const float positions[24] = {-2, -1, -2, 2, -1, -2, 2, -1, 2, -2, -1, 2,
                                        -2, 1,  -2, 2, 1,  -2, 2, 1,  2, -2, 1,  2};
    static const uint32_t red_triangles[6] = {0, 1, 2, 0, 2, 3}, green_triangles[6] = {4, 5, 6, 4, 6, 7};
    const vv_mesh_info info[2] = {
        {.n_vertices = 8, .n_triangles = 2, .positions = positions, .triangles = red_triangles},
        {.n_vertices = 8, .n_triangles = 2, .positions = positions, .triangles = green_triangles}};
    const vv_color colors[2] = {{1, 0, 0, 0.25}, {0, 1, 0, 0.5}};
    const vv_lens lens = lens_at(4, false, 0.3);
    const vvi_gfx_material none = {.model = VV_SHADING_NONE};
    vv_image *image = picture(40, 40);
    for (size_t i = 0; i < 1600; i++) {
        image->rgba[4 * i + 2] = image->rgba[4 * i + 3] = 0.5f;
        image->depth[i] = i % 40 < 20 ? 4.5f : 1; /* between the squares; before both */
    }
    vvi_gfx *gfx = begin(image, samples, NULL);
    vvi_gfx_camera(gfx, &lens);
    vvi_gfx_set_material(gfx, &none);
    for (int i = 0; i < 2; i++) {
        const int which = red_first ? i : 1 - i;
        const vvi_gfx_surface surface = {.mesh = &info[which], .place = vv_affine_identity(), .color = colors[which]};
        assert_int_equal(vvi_gfx_mesh(gfx, &surface), VV_OK);
    }
    assert_int_equal(vvi_gfx_end(gfx), VV_OK);
    return image;
}

static void translucent_surfaces_are_blended_by_depth_without_seams(void **state)
{
    (void)state;
    for (int run = 0; run < 6; run++) {
        const int samples = run / 2 == 0 ? 1 : run / 2 == 1 ? 4 : 8;
        vv_image *image = squares(run & 1, samples);
        for (size_t i = 0; i < 1600; i++) {
            const float *c = image->rgba + 4 * i;
            if (i % 40 < 20) { /* red, what was there, green */
                assert_float_equal(c[0], 0.25, 1e-6);
                assert_float_equal(c[1], 0.75 * 0.5 * 0.5, 1e-6);
                assert_float_equal(c[2], 0.75 * 0.5, 1e-6);
            } else { /* what was there, red, green */
                assert_float_equal(c[0], 0.5 * 0.25, 1e-6);
                assert_float_equal(c[1], 0.5 * 0.75 * 0.5, 1e-6);
                assert_float_equal(c[2], 0.5, 1e-6);
            }
            assert_float_equal(c[3], c[0] + c[1] + c[2], 1e-6);
            assert_int_equal(image->id[i], 0);
        }
        vv_image_release(image);
    }
}

/* In pixels --------------------------------------------------------------------------------------------------------
 */

static double total(const vv_image *image, int channel)
{
    double sum = 0;
    for (size_t i = 0; i < (size_t)image->width * (size_t)image->height; i++)
        sum += (double)image->rgba[4 * i + (size_t)channel];
    return sum;
}

static void areas_and_lines_cover_as_much_as_they_are_large(void **state)
{
    (void)state;
    vv_image *image = picture(150, 90);
    vvi_gfx *gfx = begin(image, 0, NULL);
    assert_int_equal(vvi_gfx_rectangle(gfx, 3.25, 5.5, 140.75, 70, &(vvi_gfx_fill){.color = red}), VV_OK);
    assert_int_equal(vvi_gfx_end(gfx), VV_OK);
    assert_float_equal(total(image, 0), 137.5 * 64.5, 1e-2);
    assert_float_equal(image->rgba[4 * (5 * 150 + 3)], 0.75 * 0.5, 1e-6);
    assert_float_equal(image->rgba[4 * (20 * 150 + 50)], 1, 1e-6);
    vv_image_release(image);

    for (int i = 0; i < 4; i++) {
        const double width = 0.5 * (1 << i);
        image = picture(150, 90);
        gfx = begin(image, 0, NULL);
        const vv_vec3 ends[2] = {{20, 45.3, 0}, {120, 45.3, 0}};
        const vvi_gfx_stroke stroke = {.color = red, .width = width};
        assert_int_equal(vvi_gfx_line(gfx, ends, 2, VVI_GFX_STRIP, &stroke), VV_OK);
        assert_int_equal(vvi_gfx_end(gfx), VV_OK);
        assert_in_range((int64_t)(1000 * total(image, 0)), (int64_t)(1000 * 100 * width),
                        (int64_t)(1000 * (100 * width + 2 * width * width + width)));
        vv_image_release(image);
    }
}

static vv_status block_font(void *user, vvi_gfx_coverage *out, const char *utf8, double size, vv_job *job)
{
    (void)user, (void)job;
    const int32_t n = (int32_t)strlen(utf8), em = (int32_t)size;
    *out = (vvi_gfx_coverage){.width = n * em, .height = em / 2, .top = -em / 2, .advance = n * em};
    out->coverage = vvi_alloc(job, (size_t)(out->width * out->height), VVI_MEM_SCRATCH);
    if (!out->coverage)
        return vv_fail_memory((size_t)(out->width * out->height));
    memset(out->coverage, 255, (size_t)(out->width * out->height));
    return VV_OK;
}

/* Box of the pixels that are not clear: x0, y0, x1, y1. */
static void box_of(int32_t box[4], const vv_image *image)
{
    box[0] = box[1] = INT32_MAX;
    box[2] = box[3] = -1;
    for (int32_t y = 0; y < image->height; y++)
        for (int32_t x = 0; x < image->width; x++)
            if (image->rgba[4 * (y * image->width + x) + 3] > 0) {
                box[0] = x < box[0] ? x : box[0];
                box[1] = y < box[1] ? y : box[1];
                box[2] = x >= box[2] ? x + 1 : box[2];
                box[3] = y >= box[3] ? y + 1 : box[3];
            }
}

static void text_stands_where_its_anchor_says(void **state)
{
    (void)state;
    const vvi_gfx_font font = {.draw = block_font};
    const int32_t expected[4][4] = {{50, 45, 80, 50}, {45, 20, 50, 50}, {20, 50, 50, 55}, {50, 50, 55, 80}};
    for (int quarters = 0; quarters < 4; quarters++) {
        vv_image *image = picture(100, 100);
        vvi_gfx *gfx;
        int32_t box[4];
        const vvi_gfx_target target = {.image = image, .font = &font};
        assert_int_equal(vvi_gfx_begin(&gfx, &vvi_gfx_software, &target, NULL), VV_OK);
        const vvi_gfx_label label = {.size = 10, .color = white, .quarters = quarters};
        assert_int_equal(vvi_gfx_text(gfx, (vv_vec3){50, 50, 0}, &label, "abc"), VV_OK);
        assert_int_equal(vvi_gfx_text(gfx, (vv_vec3){50, 50, 0}, &label, "a\nc"), VV_E_ARGUMENT);
        assert_int_equal(vvi_gfx_end(gfx), VV_OK);
        box_of(box, image);
        assert_memory_equal(box, expected[quarters], sizeof box);
        vv_image_release(image);
    }
}

/* Of all ---------------------------------------------------------------------------------------------------------- */

static vv_image *everything(int threads, int samples)
{
    vv_job *job = test_job(threads, 0);
    soup s;
    make_soup(&s, 77);
    const vv_lens lens = lens_at(3, false, 0.4);
    const vv_lamp lamp = {.kind = VV_LIGHT_DIRECTIONAL, .direction = {0.6, 0.8, 0}, .color = {1, 1, 1}};
    const vv_plane cut = {{0, 0, 1}, -0.3};
    vv_image *image = picture(201, 131);
    vvi_gfx *gfx = begin(image, samples, job);
    vvi_gfx_camera(gfx, &lens);
    assert_int_equal(vvi_gfx_lights(gfx, &lamp, 1, NULL), VV_OK);
    assert_int_equal(vvi_gfx_cuts(gfx, &cut, 1), VV_OK);
    const vvi_gfx_surface surface = {.mesh = &s.info, .place = vv_affine_identity(), .color = white};
    assert_int_equal(vvi_gfx_mesh(gfx, &surface), VV_OK);
    const vv_vec3 way[4] = {{-1, -1, -1}, {1, 1, 1}, {-1, 1, 1}, {1, -1, -5}};
    const vvi_gfx_stroke stroke = {.color = red, .width = 3, .dash = 8, .space = 4};
    assert_int_equal(vvi_gfx_line(gfx, way, 4, VVI_GFX_LOOP, &stroke), VV_OK);
    vvi_gfx_camera(gfx, NULL);
    assert_int_equal(vvi_gfx_points(gfx, way, 4, 9, red), VV_OK);
    assert_int_equal(vvi_gfx_end(gfx), VV_OK);
    vv_job_release(job);
    return image;
}

static void any_number_of_threads_draws_the_same_bytes(void **state)
{
    (void)state;
    vv_image *one = everything(1, 4);
    for (int threads = 2; threads < 8; threads += 3) {
        vv_image *many = everything(threads, 4);
        const size_t n = (size_t)one->width * (size_t)one->height;
        assert_memory_equal(one->rgba, many->rgba, n * 16);
        assert_memory_equal(one->depth, many->depth, n * 4);
        assert_memory_equal(one->normal, many->normal, n * 12);
        assert_memory_equal(one->id, many->id, n * 4);
        vv_image_release(many);
    }
    vv_image_release(one);
}

static void picking_finds_what_is_drawn(void **state)
{
    (void)state;
    soup s;
    make_soup(&s, 3);
    const vv_lens lens = lens_at(4, false, 0.3);
    vv_image *image = picture(64, 64);
    vvi_gfx *gfx = begin(image, 1, NULL);
    vvi_gfx_picked picked[64];
    vvi_gfx_camera(gfx, &lens);
    vvi_gfx_id(gfx, 5);
    const vvi_gfx_surface surface = {.mesh = &s.info, .place = vv_affine_identity(), .color = white};
    assert_int_equal(vvi_gfx_mesh(gfx, &surface), VV_OK);
    for (int i = 0; i < 64; i++)
        assert_int_equal(vvi_gfx_pick(&picked[i], gfx, i + 0.5, 31.5, 0), VV_OK);
    assert_int_equal(vvi_gfx_end(gfx), VV_OK);
    int different = 0, hits = 0;
    for (int i = 0; i < 64; i++) {
        const double there = (double)image->depth[31 * 64 + i];
        hits += picked[i].hit;
        different += !(picked[i].hit ? fabs(there - picked[i].depth) < 1e-3 : isinf(there));
        if (picked[i].hit)
            assert_int_equal(picked[i].id, 5);
    }
    assert_true(hits > 5);
    assert_true(different <= 4); /* on edges */
    vv_image_release(image);
}

static vv_status try_everything(vv_job *job)
{
    vv_image *image;
    vvi_gfx *gfx;
    static soup s;
    const vv_lens lens = lens_at(1.2, false, 0.4);
    const vvi_gfx_font font = {.draw = block_font};
    make_soup(&s, 12);
    vv_status st = vv_image_new(&image, 70, 70, VV_LAYER_DEPTH, job);
    if (st != VV_OK)
        return st;
    if ((st = vvi_gfx_begin(&gfx, &vvi_gfx_software, &(vvi_gfx_target){.image = image, .font = &font}, job)) == VV_OK) {
        vvi_gfx_camera(gfx, &lens);
        vvi_gfx_surface surface = {.mesh = &s.info, .place = vv_affine_identity(), .color = white};
        st = vvi_gfx_mesh(gfx, &surface);
        surface.color.a = 0.5;
        st = st == VV_OK ? vvi_gfx_mesh(gfx, &surface) : st;
        const vv_vec3 corners[3] = {{-1, 0, -1}, {1, 0, -1}, {0, 1, 1}};
        const vvi_gfx_label label = {.size = 10, .color = white, .halo = red};
        st = st == VV_OK ? vvi_gfx_polygon(gfx, corners, 3, &(vvi_gfx_fill){.color = red}) : st;
        st = st == VV_OK ? vvi_gfx_text(gfx, corners[2], &label, "ab") : st;
        st = st == VV_OK ? vvi_gfx_end(gfx) : (vvi_gfx_abandon(gfx), st);
    }
    vv_image_release(image);
    return st;
}

static vv_status try_alone(void *user)
{
    (void)user;
    return try_everything(NULL);
}

static void without_memory_there_is_an_error_and_no_harm(void **state)
{
    (void)state;
    assert_true(test_fail_each_alloc(try_alone, NULL) > 20);
}

static void a_cancelled_picture_says_so(void **state)
{
    (void)state;
    vv_job *job = test_job(2, 0);
    vv_job_cancel(job);
    assert_int_equal(try_everything(job), VV_E_CANCELLED);
    vv_job_release(job);
}

static void what_cannot_be_drawn_says_so(void **state)
{
    (void)state;
    vv_image *image = picture(8, 8);
    vvi_gfx *gfx;
    const vvi_gfx_target nothing = {.width = 8, .height = 8}, odd = {.image = image, .samples = 3};
    assert_int_equal(vvi_gfx_begin(&gfx, &vvi_gfx_software, &nothing, NULL), VV_E_ARGUMENT);
    assert_int_equal(vvi_gfx_begin(&gfx, &vvi_gfx_software, &odd, NULL), VV_E_ARGUMENT);
    gfx = begin(image, 0, NULL);
    vv_mesh_info info = *square(0, 1);
    const uint32_t wrong[3] = {0, 1, 4};
    vvi_gfx_surface surface = {.mesh = &info, .place = vv_affine_identity(), .color = white};
    assert_int_equal(vvi_gfx_mesh(gfx, &surface), VV_E_ARGUMENT);
    const vv_lens lens = lens_at(1, false, 1);
    vvi_gfx_camera(gfx, &lens);
    surface.place.axis[1] = surface.place.axis[0];
    assert_int_equal(vvi_gfx_mesh(gfx, &surface), VV_E_ARGUMENT);
    surface.place = vv_affine_identity();
    info.triangles = wrong;
    info.n_triangles = 1;
    assert_int_equal(vvi_gfx_mesh(gfx, &surface), VV_E_ARGUMENT);
    assert_non_null(strstr(vv_error_last()->message, "vertex 4 of a mesh of 4"));
    const vv_vec3 bad[2] = {{0, 0, 0}, {NAN, 0, 0}};
    const vvi_gfx_stroke stroke = {.color = red, .width = 1}, thin = {.color = red, .width = 0};
    assert_int_equal(vvi_gfx_line(gfx, bad, 2, VVI_GFX_STRIP, &stroke), VV_E_ARGUMENT);
    assert_int_equal(vvi_gfx_line(gfx, bad, 1, VVI_GFX_STRIP, &thin), VV_E_ARGUMENT);
    assert_int_equal(vvi_gfx_text(gfx, bad[0], &(vvi_gfx_label){.size = 9}, "a"), VV_E_UNSUPPORTED);
    assert_int_equal(vvi_gfx_end(gfx), VV_OK);
    assert_int_equal(vvi_gfx_end(NULL), VV_OK);
    vv_image_release(image);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pixels_see_the_triangle_that_their_ray_meets_first),
        cmocka_unit_test(triangles_around_the_eye_are_seen_by_the_rays_that_meet_them),
        cmocka_unit_test(every_sample_of_a_plane_is_covered_once),
        cmocka_unit_test(light_is_that_of_the_definition),
        cmocka_unit_test(depth_merges_with_what_the_image_has),
        cmocka_unit_test(translucent_surfaces_are_blended_by_depth_without_seams),
        cmocka_unit_test(areas_and_lines_cover_as_much_as_they_are_large),
        cmocka_unit_test(text_stands_where_its_anchor_says),
        cmocka_unit_test(any_number_of_threads_draws_the_same_bytes),
        cmocka_unit_test(picking_finds_what_is_drawn),
        cmocka_unit_test(without_memory_there_is_an_error_and_no_harm),
        cmocka_unit_test(a_cancelled_picture_says_so),
        cmocka_unit_test(what_cannot_be_drawn_says_so),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
