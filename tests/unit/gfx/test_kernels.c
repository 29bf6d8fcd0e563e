/* Every build of the kernels against the definitions, on random input. */
#include "core/cpu.h"
#include "core/vec.h"
#include "fields.h"
#include "gfx/bin.h"
#include "gfx/software.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

extern const vvi_gfx_kernels vvi_gfx_kernels_scalar;

/* Builds that this machine runs, and one without vectors; NULL past the last. */
static const vvi_gfx_kernels *build(size_t index)
{
    const uint32_t cpu = vvi_cpu_detect();
    if (index-- == 0)
        return &vvi_gfx_kernels_scalar;
    for (size_t i = 0; vvi_gfx_kernels_nth(i); i++)
        if ((vvi_gfx_kernels_nth(i)->needs & ~cpu) == 0 && index-- == 0)
            return vvi_gfx_kernels_nth(i);
    return NULL;
}

static double between(uint64_t seed, uint64_t i, double lo, double hi)
{
    return lo + (hi - lo) * test_random_unit(seed, i);
}

/* Samples --------------------------------------------------------------------------------------------------------- */

enum { TRIANGLES = 331, VERTICES = 3 * TRIANGLES, TILE_X = 128, TILE_Y = 64 };

typedef struct tile {
    float near[VVI_GFX_SAMPLES_MOST], far[VVI_GFX_SAMPLES_MOST / 16];
    uint32_t id[VVI_GFX_SAMPLES_MOST];
    vvi_gfx_samples samples;
} tile;

static tile *new_tile(int samples)
{
    tile *t = malloc(sizeof *t);
    assert_non_null(t);
    for (size_t i = 0; i < VVI_GFX_SAMPLES_MOST; i++)
        t->near[i] = -INFINITY;
    for (size_t i = 0; i < VVI_GFX_SAMPLES_MOST / 16; i++)
        t->far[i] = -INFINITY;
    memset(t->id, 0, sizeof t->id);
    t->samples = (vvi_gfx_samples){.pattern = vvi_gfx_pattern_for(samples),
                                   .x0 = TILE_X,
                                   .y0 = TILE_Y,
                                   .near = t->near,
                                   .id = t->id,
                                   .far = t->far};
    return t;
}

/* Of many sizes, from far below a pixel to as far as vertices may lie; on whole half pixels for odd seeds, so that
 * edges and vertices meet samples. Each has depths of its own. */
static void random_triangles(vvi_gfx_vertex vertices[VERTICES], uint32_t triangles[VERTICES], uint64_t seed)
{
    for (uint32_t t = 0; t < TRIANGLES; t++) {
        const double size = pow(10, between(seed, 20 * t, -0.7, t % 16 ? 1.5 : 4.2));
        const double x = TILE_X + between(seed, 20 * t + 1, -10, 74), y = TILE_Y + between(seed, 20 * t + 2, -10, 74);
        const double depth = floor(between(seed, 20 * t + 3, 0, 1e6)) + 1;
        for (uint32_t k = 0; k < 3; k++) {
            const double px = x + size * between(seed, 20 * t + 4 + k, -1, 1),
                         py = y + size * between(seed, 20 * t + 8 + k, -1, 1);
            const double grid = seed & 1 ? 128 : 1;
            vertices[3 * t + k] = (vvi_gfx_vertex){.x = (int32_t)(floor(px * 256 / grid) * grid),
                                                   .y = (int32_t)(floor(py * 256 / grid) * grid),
                                                   .near = (float)(depth + between(seed, 20 * t + 12 + k, 0, 0.4))};
            triangles[3 * t + k] = 3 * t + k;
        }
    }
}

static void raster_with(const vvi_gfx_kernels *kernels, tile *t, const vvi_gfx_area *window,
                        const vvi_gfx_vertex *vertices, const uint32_t *triangles, size_t n)
{
    uint32_t entry[TRIANGLES];
    vvi_gfx_triangle pieces[TRIANGLES];
    const vvi_gfx_draw draw = {
        .surface.mesh = &(vv_mesh_info){.triangles = triangles}, .first = 100, .vertices = (vvi_gfx_vertex *)vertices};
    const vvi_gfx_bin bin = {.draw = &draw};
    for (uint32_t i = 0; i < n; i++) {
        vvi_gfx_bin_triangle(&pieces[i], &bin, i);
        entry[i] = i % 5 ? i : (uint32_t)VVI_GFX_CUT | i;
    }
    const vvi_gfx_rastering work = {.entry = entry,
                                    .n = n,
                                    .triangles = triangles,
                                    .vertices = vertices,
                                    .pieces = pieces,
                                    .first = 100,
                                    .window = *window,
                                    .partly = window->x1 - window->x0 < VVI_GFX_TILE};
    if (kernels)
        kernels->raster(&t->samples, &work);
    for (uint32_t i = 0; i < n && !kernels; i++)
        vvi_gfx_raster_ref(&t->samples, window, &pieces[i]);
}

static void samples_see_the_triangles_of_the_definition(void **state)
{
    (void)state;
    static vvi_gfx_vertex vertices[VERTICES];
    static uint32_t triangles[VERTICES];
    const vvi_gfx_area whole = {TILE_X, TILE_Y, TILE_X + 64, TILE_Y + 64},
                       part = {TILE_X + 3, TILE_Y + 17, TILE_X + 50, TILE_Y + 18};
    for (uint64_t run = 0; run < 24; run++) {
        const int samples = run % 3 == 0 ? 1 : run % 3 == 1 ? 4 : 8;
        const size_t counts[] = {1, 7, 17, TRIANGLES}, n = counts[run / 3 % 4];
        const vvi_gfx_area *window = run < 18 ? &whole : &part;
        random_triangles(vertices, triangles, run + test_seed());
        tile *expected = new_tile(samples);
        raster_with(NULL, expected, window, vertices, triangles, n);
        for (size_t b = 0; build(b); b++) {
            tile *got = new_tile(samples);
            raster_with(build(b), got, window, vertices, triangles, n);
            for (int i = 0; i < 64 * 64 * samples; i++) {
                assert_int_equal(got->id[i], expected->id[i]);
                if (got->id[i])
                    assert_float_equal(got->near[i], expected->near[i], 0.05 + 1e-6 * (double)expected->near[i]);
                assert_true(got->far[i / 16] <= got->near[i]);
            }
            free(got);
        }
        free(expected);
    }
}

static void sorting_leaves_out_only_what_covers_no_sample(void **state)
{
    (void)state;
    static vvi_gfx_vertex vertices[VERTICES];
    static uint32_t triangles[VERTICES];
    const vvi_gfx_area whole = {TILE_X, TILE_Y, TILE_X + 64, TILE_Y + 64};
    for (uint64_t run = 0; run < 12; run++) {
        const int samples = run % 3 == 0 ? 1 : run % 3 == 1 ? 4 : 8;
        random_triangles(vertices, triangles, run);
        for (size_t b = 0; build(b); b++) {
            int32_t numbers[3][TRIANGLES + VVI_GFX_SPARE];
            bool kept[TRIANGLES] = {false};
            vvi_gfx_sorted sorted = {.single = numbers[0], .tile = numbers[1], .other = numbers[2]};
            const vvi_gfx_sorting sorting = {
                .triangles = triangles, .vertices = vertices, .window = whole, .across = 10, .samples = samples};
            build(b)->sort(&sorted, &sorting, TRIANGLES);
            for (size_t i = 0; i < sorted.n_single; i++) {
                kept[sorted.single[i]] = true;
                assert_int_equal(sorted.tile[i], 10 * (TILE_Y / 64) + TILE_X / 64);
            }
            for (size_t i = 0; i < sorted.n_other; i++)
                kept[sorted.other[i]] = true;
            for (uint32_t t = 0; t < TRIANGLES; t++) {
                tile *alone = new_tile(samples);
                bool covers = false;
                raster_with(NULL, alone, &whole, vertices, triangles + 3 * t, 1);
                for (int i = 0; i < 64 * 64 * samples; i++)
                    covers |= alone->id[i] != 0;
                assert_true(kept[t] || !covers);
                free(alone);
            }
        }
        if (run == 2)
            break; /* the definition takes its time */
    }
}

/* Vertices and light ---------------------------------------------------------------------------------------------- */

enum { N = 67 };

typedef struct scene {
    float positions[9 * N], normals[9 * N];
    uint8_t colors[12 * N];
    float values[3 * N];
    uint32_t triangles[3 * N];
    vv_mesh_info mesh;
    vvi_gfx_view view;
    vv_lamp lamps[3];
    vvi_gfx_light_set lights;
    vv_plane planes[2];
    vvi_gfx_cut_set cuts;
    vvi_gfx_draw draw;
} scene;

static vv_vec3 unit_at(uint64_t seed, uint64_t i)
{
    vv_vec3 v = {between(seed, i, -1, 1), between(seed, i + 1, -1, 1), between(seed, i + 2, -1, 1)};
    vvi_unit(&v);
    return v;
}

static void make_scene(scene *s, uint64_t seed)
{
    for (uint64_t i = 0; i < 9 * N; i++)
        s->positions[i] = (float)between(seed, i, -40, 40);
    for (uint64_t i = 0; i < 3 * N; i++) {
        const vv_vec3 n = unit_at(seed, 2000 + 3 * i);
        s->normals[3 * i] = (float)n.x, s->normals[3 * i + 1] = (float)n.y, s->normals[3 * i + 2] = (float)n.z;
        s->triangles[i] = (uint32_t)(test_random(seed, 4000 + i) % (3 * N));
    }
    for (uint64_t i = 0; i < 12 * N; i++)
        s->colors[i] = (uint8_t)test_random(seed, 5000 + i);
    for (uint64_t i = 0; i < 3 * N; i++) /* some on both sides beyond the ramp, some none */
        s->values[i] = test_random(seed, 5500 + i) % 9 ? 5e4f + (float)between(seed, 5600 + i, -3, 13) : NAN;
    s->mesh = (vv_mesh_info){.n_vertices = (size_t)3 * N,
                             .n_triangles = N,
                             .origin = {1000, -2000, 3000},
                             .positions = s->positions,
                             .normals = seed % 3 ? s->normals : NULL,
                             .values = s->values,
                             .colors = seed % 4 ? NULL : s->colors,
                             .triangles = s->triangles};
    vv_lens lens = {.forward = unit_at(seed, 6000), .half_width = 0.4, .half_height = 0.3, .parallel = seed & 1};
    lens.right = vvi_cross(lens.forward, unit_at(seed, 6010));
    vvi_unit(&lens.right);
    lens.up = vvi_cross(lens.right, lens.forward);
    lens.eye = vvi_sub(s->mesh.origin, vvi_scaled(lens.forward, seed % 5 ? 200 : 30));
    if (lens.parallel)
        lens.half_width = 80, lens.half_height = 60;
    s->view = vvi_gfx_view_of(&lens, 640, 480);
    for (uint64_t i = 0; i < 3; i++)
        s->lamps[i] = (vv_lamp){.kind = VV_LIGHT_DIRECTIONAL + (int)i,
                                .position = vvi_add(s->mesh.origin, vvi_scaled(unit_at(seed, 7000 + 9 * i), 100)),
                                .direction = unit_at(seed, 7100 + 9 * i),
                                .color = {1, 0.5f, (float)i},
                                .cos_outer = 0.1,
                                .cos_inner = 0.7,
                                .falloff = {1, 0.001, 0.00001}};
    s->lights = (vvi_gfx_light_set){.lamps = s->lamps, .n_lamps = 3, .ambient = {0.1f, 0.2f, 0.3f}};
    for (int i = 0; i < 2; i++) {
        s->planes[i].normal = unit_at(seed, 8000 + 3 * (uint64_t)i);
        s->planes[i].offset = vvi_dot(s->planes[i].normal, s->mesh.origin) - 10;
    }
    s->cuts = (vvi_gfx_cut_set){.planes = s->planes, .n_planes = 2};
    vv_affine place = vv_affine_identity();
    s->draw = (vvi_gfx_draw){.state = {.view = &s->view, .lights = &s->lights, .cuts = &s->cuts},
                             .surface = {.mesh = &s->mesh, .place = place, .color = {0.7, 0.5, 0.3, 0.9}},
                             .reach = 300};
    static const double ramp[] = {5e4, 1, 0, 0, 5e4 + 2, 0.2, 0.9, 0, 5e4 + 7, 0, 0.1, 1, 5e4 + 10, 1, 1, 0.5};
    if (seed % 5 < 2) {
        s->draw.surface.ramp = ramp;
        s->draw.surface.n_ramp = 4;
    }
    place.origin = vvi_sub(s->mesh.origin, lens.eye);
    place.axis[0] = (vv_vec3){1.2, 0.1, 0};
    if (seed % 7 == 0) {
        place.axis[2].z = -0.8;
        s->draw.mirrored = true;
    }
    s->draw.to_eye = place;
    s->draw.state.material = vvi_gfx_material_default();
    s->draw.state.material.model = (int)(seed % 3);
    s->draw.state.material.sides = (int)(seed / 3 % 3);
    s->draw.state.material.shininess = seed & 2 ? 30 : 17.5f;
}

static vvi_gfx *any_picture(vv_image **image)
{
    vvi_gfx *gfx;
    assert_int_equal(vv_image_new(image, 8, 8, 0, NULL), VV_OK);
    assert_int_equal(vvi_gfx_begin(&gfx, &vvi_gfx_software, &(vvi_gfx_target){.image = *image}, NULL), VV_OK);
    return gfx;
}

static void vertices_lie_where_the_definition_says(void **state)
{
    (void)state;
    vv_image *image;
    vvi_gfx *gfx = any_picture(&image);
    for (uint64_t seed = 0; seed < 40; seed++) {
        scene s;
        vvi_gfx_prepared *prepared;
        make_scene(&s, seed);
        s.positions[5] = seed & 1 ? NAN : INFINITY;
        assert_int_equal(vvi_gfx_prepare(&prepared, gfx, &s.draw), VV_OK);
        for (size_t b = 0; build(b); b++)
            for (size_t n = 0; n <= 3 * N; n += n < 40 ? 1 : 3 * N - n) {
                vvi_gfx_vertex got[3 * N + 1];
                memset(got, 0xee, sizeof got);
                build(b)->project(got, s.positions, n, &prepared->projection);
                assert_int_equal(got[n].out, 0xeeeeeeee);
                for (size_t i = 0; i < n; i++) {
                    const float *p = s.positions + 3 * i;
                    const vv_vec3 world =
                        vvi_add(vv_affine_point(s.draw.to_eye, vvi_vec((double)p[0], (double)p[1], (double)p[2])),
                                s.view.lens.eye);
                    const vv_vec3 eye = vvi_gfx_to_eye(&s.view, world);
                    if (i == 1) {
                        assert_true(got[i].out & VVI_GFX_OUT_NAN);
                        continue;
                    }
                    for (uint32_t k = 0; k < 2; k++) {
                        const double in = vvi_dot(s.planes[k].normal, world) - s.planes[k].offset;
                        if (fabs(in) > 1e-3)
                            assert_int_equal(got[i].out / VVI_GFX_OUT_CUTS >> k & 1, in < 0);
                    }
                    if (eye.z < 1) {
                        assert_true(eye.z > 0 || (got[i].out & VVI_GFX_OUT_NEAR));
                        continue;
                    }
                    const vvi_gfx_spot spot = vvi_gfx_spot_of(&s.view, eye);
                    assert_int_equal(got[i].out & (VVI_GFX_OUT_CUTS - 1), 0);
                    assert_float_equal(got[i].x, spot.x * 256, 0.6 + 4e-5 * fabs(spot.x * 256));
                    assert_float_equal(got[i].y, spot.y * 256, 0.6 + 4e-5 * fabs(spot.y * 256));
                    assert_float_equal(got[i].near, spot.near, 1e-5 * fabs(spot.near));
                }
                if (n == 3 * N)
                    break;
            }
    }
    vvi_gfx_abandon(gfx);
    vv_image_release(image);
}

static void light_is_that_of_the_definition(void **state)
{
    (void)state;
    vv_image *image;
    vvi_gfx *gfx = any_picture(&image);
    for (uint64_t seed = 0; seed < 60; seed++) {
        enum { ROW = N + VVI_GFX_SPARE };
        scene s;
        vvi_gfx_prepared *prepared;
        make_scene(&s, seed);
        assert_int_equal(vvi_gfx_prepare(&prepared, gfx, &s.draw), VV_OK);
        for (size_t b = 0; build(b); b++) {
            float numbers[10][ROW] = {{0}};
            uint32_t triangle[ROW] = {0};
            vvi_gfx_fragments f = {.n = N,
                                   .triangle = triangle,
                                   .x = numbers[0],
                                   .y = numbers[1],
                                   .rgba = {numbers[2], numbers[3], numbers[4], numbers[5]},
                                   .depth = numbers[6],
                                   .normal = {numbers[7], numbers[8], numbers[9]}};
            const float color[4] = {0.7f, 0.5f, 0.3f, 0.9f};
            vvi_gfx_fragment expected[N];
            for (uint32_t i = 0; i < N; i++) {
                double share[3], sum = 0;
                vv_vec3 world = s.view.lens.eye;
                for (uint32_t k = 0; k < 3; k++)
                    sum += share[k] = between(seed, 9000 + 3 * i + k, 0.1, 1);
                for (uint32_t k = 0; k < 3; k++) {
                    const float *p = s.positions + 3 * (size_t)s.triangles[3 * i + k];
                    const vv_vec3 corner =
                        vv_affine_point(s.draw.to_eye, vvi_vec((double)p[0], (double)p[1], (double)p[2]));
                    world = vvi_add(world, vvi_scaled(corner, share[k] / sum));
                }
                const vvi_gfx_spot spot = vvi_gfx_spot_of(&s.view, vvi_gfx_to_eye(&s.view, world));
                triangle[i] = i;
                f.x[i] = (float)spot.x;
                f.y[i] = (float)spot.y;
                for (int c = 0; c < 4; c++)
                    f.rgba[c][i] = color[c];
                expected[i] = (vvi_gfx_fragment){.triangle = i, .x = f.x[i], .y = f.y[i]};
                vvi_gfx_shade_ref(&expected[i], &s.draw);
            }
            build(b)->shade(&f, &prepared->lighting);
            int different = 0;
            for (int i = 0; i < N; i++) {
                bool same = fabs((double)f.depth[i] - (double)expected[i].depth) < 2e-3 * fabs((double)f.depth[i]);
                for (int c = 0; c < 4; c++)
                    same &= fabs((double)f.rgba[c][i] - (double)expected[i].rgba[c]) < 5e-3;
                for (int c = 0; c < 3; c++)
                    same &= fabs((double)f.normal[c][i] - (double)expected[i].normal[c]) < 5e-3;
                different += !same;
            }
            /* triangles seen from the side have few right digits */
            assert_in_range(different, 0, 4);
        }
    }
    vvi_gfx_abandon(gfx);
    vv_image_release(image);
}

static void turned_patterns_look_at_every_part_of_a_pixel_once(void **state)
{
    (void)state;
    int seen[2][8][8] = {0};
    for (int turn = 0; turn < 8; turn++) {
        const vvi_gfx_pattern p = vvi_gfx_pattern_turned(8, turn);
        for (int i = 0; i < 16; i++) {
            assert_in_range(p.x[i], 0, 31);
            assert_in_range(p.y[i], 0, 15);
            assert_int_equal(p.x[i] / 16, i / 8);
            seen[i / 8][p.x[i] % 16 / 2][p.y[i] / 2]++;
        }
    }
    for (int i = 0; i < 128; i++)
        assert_int_equal((&seen[0][0][0])[i], 1);
    for (int samples = 1; samples <= 4; samples += 3) {
        const vvi_gfx_pattern p = vvi_gfx_pattern_turned(samples, 5);
        assert_memory_equal(&p, vvi_gfx_pattern_for(samples), sizeof p);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(turned_patterns_look_at_every_part_of_a_pixel_once),
        cmocka_unit_test(samples_see_the_triangles_of_the_definition),
        cmocka_unit_test(sorting_leaves_out_only_what_covers_no_sample),
        cmocka_unit_test(vertices_lie_where_the_definition_says),
        cmocka_unit_test(light_is_that_of_the_definition),
    };
    printf("seed %llu\n", (unsigned long long)test_seed());
    return cmocka_run_group_tests(tests, NULL, NULL);
}
