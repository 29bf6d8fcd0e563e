/* Textures: formulas of mappings and patterns, pyramids, every build against the reference in double precision, and how
 * a World says so. */
#include "core/job.h"
#include "core/memory.h"
#include "fields.h"
#include "model/context.h"
#include "ray_scene.h"
#include "render/common/texture_ref.h"
#include "scene/lens.h"
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include <volvis/render.h>

#include <cmocka.h>

extern const vvi_ray_kernels vvi_ray_kernels_scalar;

/* One texture by itself ----------------------------------------------------------------------------------------------
 */

static vv_image *new_image(int32_t width, int32_t height)
{
    vv_image *image = NULL;
    assert_int_equal(vv_image_new(&image, width, height, 0, NULL), VV_OK);
    for (int32_t i = 0; i < width * height; i++)
        image->rgba[4 * i + 3] = 1;
    return image;
}

/* Red by column, green by row, in steps of one: which texel it is can be read from it. */
static vv_image *numbered_image(int32_t width, int32_t height)
{
    vv_image *image = new_image(width, height);
    for (int32_t i = 0; i < width * height; i++) {
        image->rgba[4 * i] = (float)(i % width);
        image->rgba[4 * i + 1] = (float)(i / width);
    }
    return image;
}

/* A texture whose space is the index space, looked at so closely that nothing is averaged; replaces colours. */
static vvi_texture texture_of(int kind, const vv_image *image)
{
    vvi_texture t = {.kind = kind, .replace = true, .parallel = true, .strength = 1, .pixel = 1e-4f, .seed = 7};
    for (int i = 0; i < 3; i++) {
        t.from_index[i][i] = 1;
        t.color[1][i] = 1; /* the second colour's share */
    }
    if (image) {
        t.aspect = (float)image->width / (float)image->height;
        assert_int_equal(vvi_image_levels_build(&t.levels, image, NULL), VV_OK);
    }
    return t;
}

/* Which of the builds that this machine runs the formulas are tried with. */
static const vvi_ray_kernels *tested = &vvi_ray_kernels_scalar;

static void color_at(float rgb_out[3], const vvi_texture *t, double x, double y, double z)
{
    float rgb[3][VVI_TEXTURE_LANES] = {{0}}, at[3][VVI_TEXTURE_LANES] = {{0}}, distance[VVI_TEXTURE_LANES] = {0};
    at[0][5] = (float)x;
    at[1][5] = (float)y;
    at[2][5] = (float)z;
    distance[5] = 1;
    tested->texture(rgb, t, at, distance, 1U << 5);
    for (int c = 0; c < 3; c++) {
        rgb_out[c] = rgb[c][5];
        assert_true(rgb[c][4] == 0 && rgb[c][6] == 0); /* points that nobody asked for stay */
    }
}

static bool near_to(float a, double b, double tolerance)
{
    return fabs((double)a - b) <= tolerance;
}

static void every_level_has_the_mean_of_the_image(void **state)
{
    (void)state;
    static const int32_t sizes[][2] = {{1, 1}, {8, 8}, {5, 3}, {1, 7}, {13, 2}, {100, 37}};
    for (size_t s = 0; s < sizeof sizes / sizeof *sizes; s++) {
        vv_image *image = new_image(sizes[s][0], sizes[s][1]);
        const size_t n = (size_t)image->width * (size_t)image->height;
        for (size_t i = 0; i < 4 * n; i++)
            image->rgba[i] = (float)test_random_unit(s, i);
        vvi_texture t = texture_of(VV_TEXTURE_IMAGE, image);
        double mean[4] = {0};
        for (size_t i = 0; i < 4 * n; i++)
            mean[i % 4] += (double)image->rgba[i] / (double)n;
        for (int32_t l = 0; l < t.levels.n; l++) {
            const vvi_image_level *level = &t.levels.level[l];
            const size_t texels = (size_t)level->n[0] * (size_t)level->n[1];
            double sum[4] = {0};
            for (size_t i = 0; i < 4 * texels; i++)
                sum[i % 4] += (double)level->rgba[i] / (double)texels;
            for (int c = 0; c < 4; c++)
                assert_true(fabs(sum[c] - mean[c]) < 1e-6);
        }
        assert_true(t.levels.level[t.levels.n - 1].n[0] == 1 && t.levels.level[t.levels.n - 1].n[1] == 1);
        vvi_texture_close(&t);
        vv_image_release(image);
    }
}

static void an_image_of_too_many_texels_is_refused(void **state)
{
    (void)state;
    const vv_image image = {.width = 32768, .height = 32768};
    vvi_image_levels levels;
    assert_int_equal(vvi_image_levels_build(&levels, &image, NULL), VV_E_LIMIT);
    assert_non_null(strstr(vv_error_last()->message, "32768 x 32768"));
}

static void five_texels_halve_to_two_with_half_of_the_middle_one_each(void **state)
{
    (void)state;
    vv_image *image = new_image(5, 1);
    const float values[5] = {1, 2, 4, 8, 16};
    for (int i = 0; i < 5; i++)
        image->rgba[4 * i] = values[i];
    vvi_texture t = texture_of(VV_TEXTURE_IMAGE, image);
    assert_int_equal(t.levels.n, 3);
    assert_true(near_to(t.levels.level[1].rgba[0], (1 + 2 + 4 / 2.0) / 2.5, 1e-6));
    assert_true(near_to(t.levels.level[1].rgba[4], (4 / 2.0 + 8 + 16) / 2.5, 1e-6));
    assert_true(near_to(t.levels.level[2].rgba[0], 31 / 5.0, 1e-6));
    vvi_texture_close(&t);
    vv_image_release(image);
}

/* Looked at from the front (-y), column i and row j from the top left. */
static void a_plane_shows_every_texel_in_its_place_whatever_the_depth(void **state)
{
    (void)state;
    vv_image *image = numbered_image(6, 4);
    vvi_texture t = texture_of(VV_TEXTURE_IMAGE, image);
    for (int j = 0; j < 4; j++)
        for (int i = 0; i < 6; i++) {
            float rgb[3];
            color_at(rgb, &t, (i + 0.5) / 6 - 0.5, 3.7 * i, (0.5 - (j + 0.5) / 4) * 4 / 6);
            assert_true(near_to(rgb[0], i, 1e-4) && near_to(rgb[1], j, 1e-4));
        }
    float rgb[3]; /* between four of them: their mean */
    color_at(rgb, &t, 0, 0, 0);
    assert_true(near_to(rgb[0], 2.5, 1e-4) && near_to(rgb[1], 1.5, 1e-4));
    vvi_texture_close(&t);
    vv_image_release(image);
}

static void beyond_the_border_an_image_repeats_is_mirrored_or_stays(void **state)
{
    (void)state;
    vv_image *image = numbered_image(4, 4);
    vvi_texture t = texture_of(VV_TEXTURE_IMAGE, image);
    for (int n = -13; n < 17; n++) { /* columns, from the first */
        const int repeat = (n % 4 + 4) % 4, of8 = (n % 8 + 8) % 8, mirror = of8 < 4 ? of8 : 7 - of8;
        const int clamp = n < 0 ? 0 : n > 3 ? 3 : n;
        const int want[] = {[VV_WRAP_REPEAT] = repeat, [VV_WRAP_MIRROR] = mirror, [VV_WRAP_CLAMP] = clamp};
        for (int wrap = VV_WRAP_REPEAT; wrap <= VV_WRAP_CLAMP; wrap++) {
            float across[3], down[3];
            t.wrap = wrap;
            color_at(across, &t, (n + 0.5) / 4 - 0.5, 0, 0.125);
            color_at(down, &t, 0.125, 0, 0.5 - (n + 0.5) / 4);
            assert_true(near_to(across[0], want[wrap], 1e-4) && near_to(across[1], 1, 1e-4));
            assert_true(near_to(down[1], want[wrap], 1e-4) && near_to(down[0], 2, 1e-4));
        }
    }
    float a[3], b[3], c[3]; /* on the border: the mean of both ends; the last texel */
    t.wrap = VV_WRAP_REPEAT;
    color_at(a, &t, 0.5, 0, 0.125);
    t.wrap = VV_WRAP_MIRROR;
    color_at(b, &t, 0.5, 0, 0.125);
    t.wrap = VV_WRAP_CLAMP;
    color_at(c, &t, 0.5, 0, 0.125);
    assert_true(near_to(a[0], 1.5, 1e-4) && near_to(b[0], 3, 1e-4) && near_to(c[0], 3, 1e-4));
    vvi_texture_close(&t);
    vv_image_release(image);
}

/* 36 x 18 texels of ten degrees: longitude from the back over the left to the front, latitude from the north pole. */
static void a_globe_has_its_longitudes_and_latitudes(void **state)
{
    (void)state;
    vv_image *image = numbered_image(36, 18);
    vvi_texture t = texture_of(VV_TEXTURE_IMAGE, image);
    for (int mapping = VV_MAP_CYLINDRICAL; mapping <= VV_MAP_SPHERICAL; mapping++)
        for (int i = 0; i < 36; i++)
            for (int j = 1; j < 17; j++) {
                const double east = (i + 0.5) * 10 * M_PI / 180 - M_PI, south = (j + 0.5) * 10 * M_PI / 180;
                const double r = 0.4 + 0.3 * (i % 3);
                float rgb[3];
                t.mapping = mapping;
                if (mapping == VV_MAP_SPHERICAL)
                    color_at(rgb, &t, r * sin(south) * sin(east), -r * sin(south) * cos(east), r * cos(south));
                else
                    color_at(rgb, &t, r * sin(east), -r * cos(east), 0.5 - (j + 0.5) / 18);
                assert_true(near_to(rgb[0], i, 1e-3) && near_to(rgb[1], j, 1e-3));
            }
    /* what one sees from the front is not mirrored: to the right is more to the east */
    float left[3], right[3];
    color_at(left, &t, -0.2, -0.9, 0);
    color_at(right, &t, 0.2, -0.9, 0);
    assert_true(left[0] < right[0] && left[0] > 12 && right[0] < 24);
    vvi_texture_close(&t);
    vv_image_release(image);
}

static void cells_of_a_checker_differ_from_their_six_neighbours(void **state)
{
    (void)state;
    const vvi_texture t = texture_of(VV_TEXTURE_CHECKER, NULL);
    for (int i = -3; i < 3; i++)
        for (int j = -3; j < 3; j++)
            for (int k = -3; k < 3; k++) {
                float rgb[3];
                color_at(rgb, &t, i + 0.3, j + 0.6, k + 0.9);
                assert_true(rgb[0] == ((i + j + k) & 1 ? 1 : 0));
            }
    float edge[3];
    color_at(edge, &t, 1, 0.5, 0.5);
    assert_true(near_to(edge[0], 0.5, 1e-6));
}

/* Means of patterns over what a pixel spans, against sums of many points. */
static void a_wide_pixel_sees_the_mean_of_a_checker(void **state)
{
    (void)state;
    static const double widths[] = {0.3, 0.9, 1.4, 2.7, 100};
    vvi_texture t = texture_of(VV_TEXTURE_CHECKER, NULL);
    for (int w = 0; w < 5; w++)
        for (uint64_t n = 0; n < 8; n++) {
            const double p[3] = {8 * test_random_unit(1, 3 * n) - 4, 8 * test_random_unit(1, 3 * n + 1) - 4,
                                 8 * test_random_unit(1, 3 * n + 2) - 4};
            double product = 1;
            for (int a = 0; a < 3; a++) { /* the mean over a cube is a product of means */
                double sum = 0;
                for (int i = 0; i < 20000; i++)
                    sum += (long)floor(p[a] + widths[w] * ((i + 0.5) / 20000 - 0.5)) & 1 ? -1 : 1;
                product *= sum / 20000;
            }
            float rgb[3];
            t.pixel = (float)widths[w];
            color_at(rgb, &t, p[0], p[1], p[2]);
            assert_true(near_to(rgb[0], (1 - product) / 2, 1e-3));
        }
}

static void noise_is_0_at_lattice_points_and_nearly_so_in_the_mean(void **state)
{
    (void)state;
    double sum = 0, squares = 0, most = 0, other = 0;
    enum { N = 20000 };
    for (int i = -4; i < 4; i++)
        assert_true(vvi_texture_noise_ref(i, 2 * i, 3 - i, 9) == 0);
    for (uint64_t i = 0; i < N; i++) {
        const double x = 60 * test_random_unit(2, 3 * i) - 30, y = 60 * test_random_unit(2, 3 * i + 1) - 30;
        const double z = 60 * test_random_unit(2, 3 * i + 2) - 30, n = vvi_texture_noise_ref(x, y, z, 9);
        sum += n;
        squares += n * n;
        most = fmax(most, fabs(n));
        other += fabs(n - vvi_texture_noise_ref(x, y, z, 10)) / N;
        assert_true(fabs(n - vvi_texture_noise_ref(x + 1e-6, y, z, 9)) < 1e-5); /* no jumps */
    }
    assert_true(fabs(sum / N) < 0.01 && squares / N > 0.03 && most > 0.6 && most < 1.2);
    assert_true(other > 0.1); /* another seed, another noise */
}

static void strength_and_alpha_leave_the_rest_of_a_colour(void **state)
{
    (void)state;
    vv_image *image = new_image(1, 1);
    const float premultiplied[4] = {0.3f, 0.1f, 0, 0.5f};
    memcpy(image->rgba, premultiplied, sizeof premultiplied);
    vvi_texture t = texture_of(VV_TEXTURE_IMAGE, image);
    t.strength = 0.5f;
    for (int replace = 0; replace < 2; replace++) {
        float rgb[3][VVI_TEXTURE_LANES], at[3][VVI_TEXTURE_LANES] = {{0}}, distance[VVI_TEXTURE_LANES] = {0};
        for (int c = 0; c < 3; c++)
            rgb[c][0] = 0.8f;
        t.replace = replace;
        tested->texture(rgb, &t, at, distance, 1);
        for (int c = 0; c < 3; c++) {
            const double target = (double)premultiplied[c] * (replace ? 1 : 0.8);
            assert_true(near_to(rgb[c][0], 0.8 * (1 - 0.25) + 0.5 * target, 1e-6));
        }
    }
    vvi_texture_close(&t);
    vv_image_release(image);
}

static void places_beyond_all_measure_have_some_colour(void **state)
{
    (void)state;
    vv_image *image = numbered_image(3, 5);
    vvi_texture t = texture_of(VV_TEXTURE_IMAGE, image);
    static const double far[] = {0, 1e9, -1e30, INFINITY, -INFINITY, NAN};
    for (t.kind = VV_TEXTURE_IMAGE; t.kind <= VV_TEXTURE_NOISE; t.kind++)
        for (int i = 0; i < 27; i++) {
            t.mapping = i % 3;
            t.wrap = i / 3 % 3;
            for (int f = 0; f < 36; f++) {
                float rgb[3];
                t.pixel = f % 5 ? 1e-3f : INFINITY;
                color_at(rgb, &t, far[f % 6], far[f / 6], far[(f + i) % 6]);
                for (int c = 0; c < 3; c++)
                    assert_true(rgb[c] >= 0 && rgb[c] <= 5);
            }
        }
    vvi_texture_close(&t);
    vv_image_release(image);
}

/* Pictures ---------------------------------------------------------------------------------------------------------
 */

/* A ball of values above 0 within 5 of (7, 8, 9), seen from the front or from a corner. */
static vv_field *ball(void)
{
    return test_field_cube(&test_form_sphere, 20, 0, 16, NULL);
}

static void give_texture(test_ray_scene *s, int kind, vv_image *image)
{
    vv_texture *t = &s->actor.texture;
    *t = (vv_texture){.kind = kind, .image = image, .strength = 1, .seed = 3, .from_world = vv_affine_identity()};
    for (int i = 0; i < 3; i++) /* about the middle of the ball, turned a little */
        t->from_world.axis[i] = vvi_scaled(vvi_vec(i == 0, i == 1, i == 2), 0.3);
    t->from_world.axis[1].z = 0.1;
    t->from_world.origin = vvi_vec(-7 * 0.3, -8 * 0.3, -9 * 0.3 - 0.8);
    for (int c = 0; c < 3; c++)
        t->color[1][c] = 0.2 + 0.4 * c;
    t->color[0][0] = 0.9;
}

static void compare(const test_ray_scene *s, const char *cpu, const double *want, const char *what)
{
    vv_image *image = cpu ? test_ray_picture(s, cpu, 2) : test_ray_picture_by(s, &vvi_ray_kernels_scalar);
    const int n = s->scene.width * s->scene.height;
    int bad = 0;
    double worst = 0;
    for (int i = 0; i < n; i++) {
        double d = 0;
        for (int c = 0; c < 4; c++)
            d = fmax(d, fabs((double)image->rgba[4 * i + c] - want[5 * i + c]));
        bad += d > 2e-3;
        worst = fmax(worst, d);
    }
    vv_image_release(image);
    if (bad > 0.02 * n)
        fail_msg("%s, %s: %d of %d pixels differ, by up to %g", cpu ? cpu : "scalar", what, bad, n, worst);
}

static void compare_all(test_ray_scene *s, bool plain_differs, const char *what)
{
    double *want = test_ray_reference(s), most = 0;
    const int kind = s->actor.texture.kind;
    for (const char *const *cpu = test_ray_cpus(); *cpu; cpu++)
        compare(s, *cpu, want, what);
    compare(s, NULL, want, what);
    s->actor.texture.kind = VV_TEXTURE_NONE;
    double *plain = test_ray_reference(s);
    s->actor.texture.kind = kind;
    for (int i = 0; i < 5 * s->scene.width * s->scene.height; i++)
        most = i % 5 < 3 ? fmax(most, fabs(want[i] - plain[i])) : most;
    assert_int_equal(most > 0.05, plain_differs);
    free(plain);
    free(want);
}

static void textures_equal_the_reference_in_every_build(void **state)
{
    (void)state;
    static const char *const names[] = {"none", "image", "checker", "wood", "marble", "noise"};
    vv_field *field = ball();
    vv_image *image = new_image(24, 15);
    for (size_t i = 0; i < 24 * 15 * 4; i++)
        image->rgba[i] = (float)test_random_unit(4, i) * (i % 4 == 3 ? 1.0f : 0.5f);
    for (int kind = VV_TEXTURE_IMAGE; kind <= VV_TEXTURE_NOISE; kind++)
        for (int way = 0; way < 6; way++) { /* solid, cubic, cloud; along parallels and from a point */
            test_ray_scene s;
            char what[64];
            test_ray_scene_init(&s, field, 12);
            s.scene.width = s.scene.height = s.scene.rows = 40;
            test_ray_scene_look(&s, vvi_vec(-20, -30, 25), vvi_vec(7, 8, 9), way % 2 ? 0.35 : 0, 13);
            test_ray_scene_light(&s);
            give_texture(&s, kind, kind == VV_TEXTURE_IMAGE ? image : NULL);
            s.actor.texture.apply = way % 3 == 0 ? VV_APPLY_REPLACE : VV_APPLY_MODULATE;
            s.actor.texture.mapping = way % 3;
            s.actor.texture.wrap = (way + 1) % 3;
            s.actor.texture.strength = way == 5 ? 0.6 : 1;
            if (way < 4) {
                s.actor.classes.kind = VV_SEGMENT_THRESHOLD;
                s.actor.classes.lo = -100;
                s.actor.classes.hi = 0;
            } else {
                test_ray_scene_opacity(&s, (const double[]){-4, 0.3, -1, 0.4, 0, 0.1, 0.5, 0}, 4);
                test_ray_scene_color(&s, (const double[]){-4, 0.3, 0.4, 1, 0, 1, 0.9, 0.3}, 2);
            }
            s.actor.cubic = way == 2 || way == 3;
            snprintf(what, sizeof what, "%s, way %d", names[kind], way);
            compare_all(&s, true, what);
            if (way == 4 && kind == VV_TEXTURE_WOOD) {
                s.actor.texture.strength = 0;
                compare_all(&s, false, "none of it");
            }
            test_ray_scene_finish(&s);
        }
    vv_image_release(image);
    vv_field_release(field);
}

/* Black and white texels, many in a pixel: a picture without levels would be black and white, and shimmer. */
static void a_far_checker_is_grey(void **state)
{
    (void)state;
    vv_field *field = ball();
    vv_image *image = new_image(256, 256);
    for (int i = 0; i < 256 * 256; i++)
        for (int c = 0; c < 3; c++)
            image->rgba[4 * i + c] = (float)((i % 256 / 4 + i / 256 / 4) & 1);
    for (int kind = VV_TEXTURE_IMAGE; kind <= VV_TEXTURE_CHECKER; kind++)
        for (int far = 0; far < 3; far++) { /* near; far along parallels; far from a point */
            test_ray_scene s;
            test_ray_scene_init(&s, field, 4);
            if (far == 2)
                test_ray_scene_look(&s, vvi_vec(7, -8000, 9), vvi_vec(7, 8, 9), 2 * atan(2.0 / 8000), 0);
            else
                test_ray_scene_look(&s, vvi_vec(7, -80, 9), vvi_vec(7, 8, 9), 0, far ? 4 : 0.02);
            give_texture(&s, kind, kind == VV_TEXTURE_IMAGE ? image : NULL);
            s.actor.texture.apply = VV_APPLY_REPLACE;
            s.actor.texture.from_world = vv_affine_identity();
            for (int i = 0; i < 3; i++) /* 64 cells a length */
                s.actor.texture.from_world.axis[i] =
                    vvi_scaled(vvi_vec(i == 0, i == 1, i == 2), kind == VV_TEXTURE_IMAGE ? 1 : 64);
            for (int c = 0; c < 3; c++) {
                s.actor.texture.color[0][c] = 0;
                s.actor.texture.color[1][c] = 1;
            }
            s.actor.classes.kind = VV_SEGMENT_THRESHOLD;
            s.actor.classes.lo = -100;
            vv_image *picture = test_ray_picture(&s, NULL, 1);
            int grey = 0;
            for (int i = 0; i < 64 * 64; i++) {
                assert_true(picture->rgba[4 * i + 3] == 1);
                grey += near_to(picture->rgba[4 * i], 0.5, 0.02);
            }
            if (far)
                assert_int_equal(grey, 64 * 64);
            else
                assert_true(grey < 64 * 64 / 4);
            vv_image_release(picture);
            test_ray_scene_finish(&s);
        }
    vv_image_release(image);
    vv_field_release(field);
}

/* Worlds ------------------------------------------------------------------------------------------------------------
 */

typedef struct setup {
    vv_job *job;
    vv_object *world;
    char image[64];
} setup;

static void set(setup *s, const char *path, const char *json)
{
    const vv_property_context context = vvi_registry_context(vv_registry_builtin());
    if (vv_path_set(&s->world, path, json, &context) != VV_OK)
        fail_msg("%s", vv_error_last()->message);
}

/* A volume of 17 x 17 x 17 samples over [0, 16]^3, and an image of 2 x 1 white pixels. */
static void begin(setup *s)
{
    vv_runtime_options options;
    vv_runtime *runtime = NULL;
    vv_world *world = NULL;
    vv_field *field = test_field_cube(&test_form_sphere, 17, 0, 16, NULL);
    vv_runtime_options_init(&options, sizeof options);
    options.threads = 1;
    assert_int_equal(vv_runtime_new(&runtime, &options), VV_OK);
    assert_int_equal(vv_job_new(&s->job, runtime, NULL, NULL), VV_OK);
    vv_runtime_release(runtime);
    assert_int_equal(vv_world_for_field(&world, "a", field, s->job), VV_OK);
    s->world = &world->base;
    vv_field_release(field);
    vv_image *image = new_image(2, 1);
    image->rgba[0] = image->rgba[1] = image->rgba[2] = 1;
    snprintf(s->image, sizeof s->image, "texture-%d.png", (int)getpid());
    assert_int_equal(vv_image_write(s->image, image, NULL, s->job), VV_OK);
    vv_image_release(image);
    set(s, "views.main.width", "20");
    set(s, "views.main.height", "20");
}

static void finish(setup *s)
{
    unlink(s->image);
    vv_object_release(s->world);
    vv_job_release(s->job);
}

static vv_scene *resolve(setup *s, bool again)
{
    vv_scene *scene = NULL;
    vv_world *fixed = NULL;
    if (vv_scene_resolve(&scene, (vv_world *)s->world, NULL, s->job) != VV_OK)
        fail_msg("%s", vv_error_last()->message);
    if (!again)
        return scene;
    assert_int_equal(vv_scene_fix(&fixed, scene), VV_OK);
    vv_scene_release(scene);
    assert_int_equal(vv_scene_resolve(&scene, fixed, NULL, s->job), VV_OK);
    vv_object_release(&fixed->base);
    return scene;
}

static void assert_point(const vv_scene *scene, vv_vec3 world, vv_vec3 want)
{
    const vv_vec3 got = vv_affine_point(scene->actors[0].texture.from_world, world);
    assert_true(vvi_length(vvi_sub(got, want)) < 1e-9);
}

static void a_texture_fits_the_volume_unless_it_is_placed(void **state)
{
    (void)state;
    setup s;
    begin(&s);
    vv_scene *scene = resolve(&s, false);
    assert_int_equal(scene->actors[0].texture.kind, VV_TEXTURE_NONE);
    vv_scene_release(scene);
    for (int again = 0; again < 2; again++) {
        set(&s, "volumes.a.texture", "{\"kind\": \"checker\"}");
        scene = resolve(&s, again);
        assert_point(scene, vvi_vec(8, 8, 8), vvi_vec(0, 0, 0));
        assert_point(scene, vvi_vec(-0.5, 8, 16.5), vvi_vec(-4, 0, 4)); /* 8 cells over 17 voxels */
        vv_scene_release(scene);
        set(&s, "volumes.a.texture",
            "{\"kind\": \"wood\", \"frequency\": 2, \"place\": {\"position\": [1, 0, 0], \"rotation\": [0, 0, 90], "
            "\"scale\": [1, 1, 4]}}");
        scene = resolve(&s, again);
        assert_point(scene, vvi_vec(9, 8, 8), vvi_vec(0, 0, 0));
        assert_point(scene, vvi_vec(9, 9, 8), vvi_vec(2, 0, 0));
        assert_point(scene, vvi_vec(9, 8, 10), vvi_vec(0, 0, 1));
        vv_scene_release(scene);
    }
    /* it moves with the volume */
    set(&s, "volumes.a.place", "{\"position\": [100, 0, 0], \"scale\": [3, 3, 3]}");
    set(&s, "volumes.a.texture", "{\"kind\": \"checker\"}");
    scene = resolve(&s, true);
    assert_point(scene, vvi_vec(100 - 1.5, 24, 49.5), vvi_vec(-4, 0, 4));
    vv_scene_release(scene);
    finish(&s);
}

static void an_image_alone_says_what_kind_it_is(void **state)
{
    (void)state;
    setup s;
    begin(&s);
    char json[96];
    snprintf(json, sizeof json, "\"%s\"", s.image);
    set(&s, "volumes.a.texture.image", json);
    vv_scene *scene = resolve(&s, true);
    const vv_texture *t = &scene->actors[0].texture;
    assert_int_equal(t->kind, VV_TEXTURE_IMAGE);
    assert_true(t->image && t->image->width == 2 && t->image->height == 1);
    assert_point(scene, vvi_vec(-0.5, 8, 8), vvi_vec(-0.5, 0, 0)); /* as wide as the volume */
    vv_scene_release(scene);
    set(&s, "volumes.a.texture.kind", "none");
    scene = resolve(&s, true);
    assert_null(scene->actors[0].texture.image);
    vv_scene_release(scene);
    finish(&s);
}

static void refused(setup *s, vv_status status, const char *words)
{
    vv_image *image = NULL;
    assert_int_equal(vv_render(&image, NULL, (vv_world *)s->world, NULL, NULL, s->job), status);
    const vv_error *e = vv_error_last();
    if (!strstr(e->message, words) && !(e->where && strstr(e->where, words)) && !(e->file && strstr(e->file, words)))
        fail_msg("'%s' does not say '%s'", e->message, words);
}

static void what_cannot_be_is_refused_with_a_sentence(void **state)
{
    (void)state;
    const vv_property_context context = vvi_registry_context(vv_registry_builtin());
    setup s;
    begin(&s);
    set(&s, "volumes.a.texture.kind", "image");
    refused(&s, VV_E_ARGUMENT, "volumes.a.texture.image");
    set(&s, "volumes.a.texture.image", "\"no-such-file.png\"");
    refused(&s, VV_E_READ, "no-such-file.png");
    refused(&s, VV_E_READ, "volumes.a.texture.image");
    assert_int_equal(vv_path_set(&s.world, "volumes.a.texture.kind", "marbel", &context), VV_E_ARGUMENT);
    assert_non_null(strstr(vv_error_last()->message, "marble"));
    assert_int_equal(vv_path_set(&s.world, "volumes.a.texture.strength", "1.5", &context), VV_E_ARGUMENT);
    assert_int_equal(vv_path_set(&s.world, "volumes.a.texture.frequency", "0", &context), VV_E_ARGUMENT);
    set(&s, "volumes.a.texture.kind", "wood");
    set(&s, "volumes.a.texture.place.position", "[1e308, 1e308, 0]");
    set(&s, "volumes.a.texture.frequency", "1e10");
    refused(&s, VV_E_ARGUMENT, "volumes.a.texture.place");
    finish(&s);
}

/* With every allocation failing in turn. */
static void a_frame_without_memory_is_an_error_and_leaves_nothing(void **state)
{
    (void)state;
    for (int solid = 0; solid < 2; solid++) {
        setup s;
        char json[96];
        begin(&s);
        snprintf(json, sizeof json, "\"%s\"", s.image);
        set(&s, "volumes.a.texture.image", json);
        set(&s, "volumes.a.segmentation.kind", solid ? "threshold" : "transfer");
        int64_t n = 1;
        for (;; n++) {
            vv_image *image = NULL;
            vvi_alloc_fail_after(n);
            const vv_status st = vv_render(&image, NULL, (vv_world *)s.world, NULL, NULL, NULL);
            const bool failed = vvi_alloc_has_failed();
            vvi_alloc_fail_after(0);
            assert_int_equal(st == VV_OK, image != NULL);
            vv_image_release(image);
            if (!failed)
                break;
        }
        assert_true(n > 5);
        finish(&s);
    }
}

int main(void)
{
    const struct CMUnitTest formulas[] = {
        cmocka_unit_test(a_plane_shows_every_texel_in_its_place_whatever_the_depth),
        cmocka_unit_test(beyond_the_border_an_image_repeats_is_mirrored_or_stays),
        cmocka_unit_test(a_globe_has_its_longitudes_and_latitudes),
        cmocka_unit_test(cells_of_a_checker_differ_from_their_six_neighbours),
        cmocka_unit_test(a_wide_pixel_sees_the_mean_of_a_checker),
        cmocka_unit_test(strength_and_alpha_leave_the_rest_of_a_colour),
        cmocka_unit_test(places_beyond_all_measure_have_some_colour),
    };
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_level_has_the_mean_of_the_image),
        cmocka_unit_test(an_image_of_too_many_texels_is_refused),
        cmocka_unit_test(five_texels_halve_to_two_with_half_of_the_middle_one_each),
        cmocka_unit_test(noise_is_0_at_lattice_points_and_nearly_so_in_the_mean),
        cmocka_unit_test(textures_equal_the_reference_in_every_build),
        cmocka_unit_test(a_far_checker_is_grey),
        cmocka_unit_test(a_texture_fits_the_volume_unless_it_is_placed),
        cmocka_unit_test(an_image_alone_says_what_kind_it_is),
        cmocka_unit_test(what_cannot_be_is_refused_with_a_sentence),
        cmocka_unit_test(a_frame_without_memory_is_an_error_and_leaves_nothing),
    };
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    failed += cmocka_run_group_tests_name("formulas, scalar", formulas, NULL, NULL);
    for (const char *const *cpu = test_ray_cpus(); *cpu; cpu++) {
        for (size_t i = 0; (tested = vvi_ray_kernels_nth(i)) && strcmp(tested->isa, *cpu) != 0; i++)
            ;
        failed += cmocka_run_group_tests_name(*cpu, formulas, NULL, NULL);
    }
    return failed;
}
