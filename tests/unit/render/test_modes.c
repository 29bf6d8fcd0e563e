/* Several volumes in one picture, each in its own mode and with its own step: closed forms, pictures of each alone laid
 * one over the other, and every build against the reference in double precision. */
#include "fields.h"
#include "scene/lens.h"
#include "together.h"
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

extern const vvi_ray_kernels vvi_ray_kernels_scalar;

static double z_value(vv_vec3 p)
{
    return p.z;
}
static vv_vec3 up_gradient(vv_vec3 p)
{
    (void)p;
    return (vv_vec3){0, 0, 1};
}
static const test_form along_z = {"z", z_value, up_gradient};

/* Values from 0 to 1 along z over [0, 1]^3, of the colour (value, 0.5, 0.25). */
static test_ray_scene *add_ramp(test_together *t, const char *mode)
{
    test_ray_scene *s = test_together_add(t, test_field_cube(&along_z, 9, 0, 1, NULL));
    test_ray_scene_color(s, (const double[]){0, 0, 0.5, 0.25, 1, 1, 0.5, 0.25}, 2);
    test_ray_scene_set(s, "mode", mode);
    test_ray_scene_set(s, "step", "0.0625");
    return s;
}

static const double red[3] = {1, 0, 0}, blue[3] = {0, 0, 1};

static void look_down(test_together *t)
{
    test_ray_scene_look(&t->part[0], vvi_vec(0.51, 0.49, 20), vvi_vec(0.51, 0.49, 0), 0, 0.3);
}

static void check_pixel(const vv_image *image, const double want[4], const char *what)
{
    const float *p = image->rgba + 4 * (32 * image->width + 32);
    for (int c = 0; c < 4; c++)
        if (!(fabs((double)p[c] - want[c]) < 2e-4))
            fail_msg("%s: channel %d is %.6f, not %.6f", what, c, (double)p[c], want[c]);
}

/* Layers --------------------------------------------------------------------------------------------------------- */

/* Over a red cloud of optical depth 1.5; the ray meets values from 0 to 1. */
static void one_value_of_a_ray_lies_over_a_cloud(void **state)
{
    static const struct {
        const char *mode;
        double value;
    } cases[] = {{"maximum", 1}, {"minimum", 0}, {"mean", 0.5}, {"sum", 0.5 / 1.7320508}};
    (void)state;
    for (const char *const *cpu = test_ray_cpus(); *cpu; cpu++)
        for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
            for (int how = 0; how < 2; how++) {
                test_together t = {.own = true};
                test_together_box(&t, 0, 1, 1.5, red);
                test_ray_scene *s = add_ramp(&t, cases[i].mode);
                double opacity = 0.2 + 0.4 * cases[i].value;
                test_ray_scene_opacity(s, (const double[]){0, 0.2, 1, 0.6}, 2);
                s->actor.classes.opacity_length = 0.01; /* taken once, however long the way is */
                if (how) {
                    s->actor.layer.opacity = 0.5;
                    opacity *= 0.5;
                }
                look_down(&t);
                vv_image *image = test_ray_picture(test_together_all(&t), *cpu, 1);
                const double cloud = 1 - exp(-1.5), v = cases[i].value;
                const double want[4] = {opacity * v + (1 - opacity) * cloud, opacity * 0.5, opacity * 0.25,
                                        opacity + (1 - opacity) * cloud};
                check_pixel(image, want, cases[i].mode);
                vv_image_release(image);
                test_together_finish(&t);
            }
}

/* Light is added, and hides nothing. */
static void channels_add_their_light(void **state)
{
    (void)state;
    for (const char *const *cpu = test_ray_cpus(); *cpu; cpu++) {
        test_together t = {.own = true};
        add_ramp(&t, "maximum");
        test_ray_scene *s = add_ramp(&t, "mean");
        test_ray_scene_opacity(s, (const double[]){0, 1}, 1);
        s->actor.layer.blend = VV_SLICE_ADD;
        s->actor.layer.opacity = 0.5;
        look_down(&t);
        vv_image *image = test_ray_picture(test_together_all(&t), *cpu, 1);
        check_pixel(image, (const double[]){1 + 0.25, 0.5 + 0.25, 0.25 + 0.125, 1}, "added");
        vv_image_release(image);
        test_together_finish(&t);
    }
}

/* Where there is nothing but layers, the first is as dense as if it were alone, over something it is not. */
static void the_first_of_layers_is_the_ground(void **state)
{
    (void)state;
    for (const char *const *cpu = test_ray_cpus(); *cpu; cpu++) {
        test_together t = {.own = true};
        add_ramp(&t, "mean");
        look_down(&t);
        vv_image *alone = test_ray_picture(test_together_all(&t), *cpu, 1);
        check_pixel(alone, (const double[]){0.5, 0.5, 0.25, 1}, "alone");
        test_ray_scene_opacity(add_ramp(&t, "mean"), (const double[]){0, 0.4}, 1);
        vv_image *two = test_ray_picture(test_together_all(&t), *cpu, 1);
        check_pixel(two, (const double[]){0.5, 0.5, 0.25, 1}, "two of the same");
        t.part[1].actor.layer.opacity = 0;
        vv_image *faded = test_ray_picture(test_together_all(&t), *cpu, 1);
        assert_memory_equal(faded->rgba, alone->rgba, 64 * 64 * 4 * sizeof(float));
        vv_image_release(alone);
        vv_image_release(two);
        vv_image_release(faded);
        test_together_finish(&t);
    }
}

/* The maximum lies at 1, where the ray enters; the surface of 0.25 in the other is seen through it, or not. */
static void a_layer_has_the_depth_where_it_hides_half(void **state)
{
    (void)state;
    for (int dense = 0; dense < 2; dense++) {
        test_together t = {.own = true};
        test_ray_scene *s = test_together_add(&t, test_field_cube(&along_z, 9, 0, 1, NULL));
        test_ray_scene_set(s, "mode", "isosurface");
        test_ray_scene_set(s, "iso", "0");
        test_ray_scene *layer = add_ramp(&t, "maximum");
        test_ray_scene_opacity(layer, (const double[]){0, 1}, 1);
        layer->actor.layer.opacity = dense ? 0.75 : 0.25;
        /* the surface is where its ray enters: at 1; that of the layer is moved up by 2 */
        layer->actor.index_to_world.origin = vvi_add(layer->actor.index_to_world.origin, vvi_vec(0, 0, 2));
        look_down(&t);
        vv_image *image = test_ray_picture(test_together_all(&t), NULL, 1);
        assert_true(fabs((double)image->depth[32 * 64 + 32] - (dense ? 17 : 19)) < 1e-4);
        vv_image_release(image);
        test_together_finish(&t);
    }
}

/* Steps ---------------------------------------------------------------------------------------------------------- */

/* A fine box in a coarse one, and one apart: extinctions are exact whatever the steps, and samples as few as they are
 * alone. */
static void opacity_is_per_length_whatever_the_steps(void **state)
{
    static const char *const steps[][3] = {
        {"1", "1", "1"}, {"0.3", "0.001", "0.7"}, {"0.001", "0.3", "2"}, {"0.07", "0.05", "0.0008"}};
    (void)state;
    for (const char *const *cpu = test_ray_cpus(); *cpu; cpu++)
        for (size_t i = 0; i < sizeof steps / sizeof *steps; i++) {
            test_together t = {.own = true};
            test_together_box(&t, 0, 1, 1.5, red);
            test_together_box(&t, 0.4, 0.6, 2.5, blue);
            test_ray_scene *apart = test_together_box(&t, 0, 1, 0.5, red);
            apart->actor.index_to_world.origin = vvi_add(apart->actor.index_to_world.origin, vvi_vec(0, 0, -3));
            for (size_t v = 0; v < 3; v++)
                test_ray_scene_set(&t.part[v], "step", steps[i][v]);
            look_down(&t);
            vv_image *image = test_ray_picture(test_together_all(&t), *cpu, 1);
            const double alpha = 1 - exp(-1.5 - 2.5 * 0.2 - 0.5);
            if (!(fabs((double)image->rgba[4 * (32 * 64 + 32) + 3] - alpha) < 2e-5))
                fail_msg("%s, steps %zu: %.7f is not %.7f", *cpu, i, (double)image->rgba[4 * (32 * 64 + 32) + 3],
                         alpha);
            vv_image_release(image);
            test_together_finish(&t);
        }
}

static uint64_t count_samples(test_ray_scene *s)
{
    void *state = NULL;
    vv_image *image = NULL;
    vv_render_counts counts = {0};
    const vv_pass pass = {.x = 0.5, .y = 0.5, .stride = 1};
    assert_int_equal(vvi_raycast_prepare(&state, &s->scene, NULL), VV_OK);
    assert_int_equal(vv_image_new(&image, 64, 64, VV_LAYER_DEPTH, NULL), VV_OK);
    assert_int_equal(s->scene.renderer->render(state, &pass, &(vv_tile){0, 0, 64, 64}, image, &counts, NULL), VV_OK);
    vv_image_release(image);
    vvi_raycast_finish(state);
    return counts.samples;
}

/* One of steps a thousandth of the other's, beside it and inside of it. */
static void a_fine_volume_costs_no_more_beside_a_coarse_one(void **state)
{
    (void)state;
    for (int inside = 0; inside < 2; inside++) {
        test_together t = {.own = true};
        test_together_box(&t, 0, 1, 0.1, red);
        test_ray_scene *fine = test_together_box(&t, 0.45, 0.55, 0.1, blue);
        if (!inside)
            fine->actor.index_to_world.origin = vvi_add(fine->actor.index_to_world.origin, vvi_vec(0, 0, 3));
        test_ray_scene_set(&t.part[0], "step", "0.1");
        test_ray_scene_set(&t.part[1], "step", "0.0001");
        look_down(&t);
        uint64_t alone = 0;
        for (size_t i = 0; i < 2; i++) {
            test_ray_scene *s = test_together_all(&t);
            s->scene.actors = &t.actors[i];
            s->scene.n_actors = 1;
            alone += count_samples(s);
        }
        const uint64_t both = count_samples(test_together_all(&t));
        if (both > 2 * alone + 4 * 64 * 64)
            fail_msg("%s: %llu samples, and %llu alone", inside ? "inside" : "beside", (unsigned long long)both,
                     (unsigned long long)alone);
        test_together_finish(&t);
    }
}

/* Random volumes --------------------------------------------------------------------------------------------------- */

static const vv_type types[] = {VV_TYPE_U8, VV_TYPE_U16, VV_TYPE_I16, VV_TYPE_F32};
static const char *const mode_names[] = {"composite", "maximum",       "minimum",   "mean",
                                         "sum",       "local-maximum", "isosurface"};

static void add_random(test_together *t, uint64_t seed)
{
    vv_field_info info = vv_field_info_default();
    char number[32];
    info.type = types[seed % 4];
    for (uint64_t a = 0; a < 3; a++)
        info.grid.dims[a] = 3 + (int64_t)(test_random(seed, a) % 12);
    info.grid.index_to_world.axis[0] = vvi_vec(-1.1 + 0.6 * test_random_unit(seed, 4), 0.1, 0);
    info.grid.index_to_world.axis[1] = vvi_vec(0.2, 0.9, 0.1);
    info.grid.index_to_world.axis[2] = vvi_vec(0, -0.3, 1.4 - 0.5 * test_random_unit(seed, 5));
    info.grid.index_to_world.origin = vvi_vec(3 * test_random_unit(seed, 6), -2, 4 * test_random_unit(seed, 7) - 4);
    test_ray_scene *s = test_together_add(t, test_field_random(&info, seed, NULL));
    const double lo = s->statistics.min, w = s->statistics.max - lo;
    test_ray_scene_opacity(
        s, (const double[]){lo, 0, lo + 0.4 * w, 0, lo + 0.5 * w, 0.3, lo + 0.7 * w, 0.1, lo + 0.7 * w, 0, lo + w, 0.6},
        6);
    test_ray_scene_color(s, (const double[]){lo, 0.1, 0.9, 0.2, lo + 0.5 * w, 0.9, 0.3, 0.1, lo + w, 0.2, 0.3, 1}, 3);
    s->actor.iso = lo + 0.6 * w;
    s->actor.layer = (vv_ray_layer){.blend = seed % 3 ? VV_SLICE_OVER : VV_SLICE_ADD,
                                    .opacity = 0.3 + 0.7 * test_random_unit(seed, 9)};
    test_ray_scene_set(s, "mode", mode_names[test_random(seed, 10) % 7]);
    snprintf(number, sizeof number, "%.6f", 0.05 + 0.6 * test_random_unit(seed, 11));
    test_ray_scene_set(s, "step", number);
}

static void look_at_all(test_together *t, uint64_t seed)
{
    test_ray_scene *s = &t->part[0];
    vv_vec3 away = {test_random_unit(seed, 1) - 0.5, test_random_unit(seed, 2) - 0.5, test_random_unit(seed, 3) - 0.4};
    assert_true(vvi_unit(&away));
    s->scene.width = 23; /* no multiple of a packet or a tile */
    s->scene.height = s->scene.rows = 19;
    const vv_vec3 at = {0, 1, 0};
    test_ray_scene_look(s, vvi_add(at, vvi_scaled(away, 25)), at, seed % 2 ? 0 : 0.5, 14);
}

static void compare(const vv_image *image, const double *want, int stride, const char *cpu, const char *what)
{
    const int n = image->width * image->height;
    int bad = 0;
    double worst = 0;
    for (int i = 0; i < n; i++) {
        double d = 0;
        for (int c = 0; c < 4; c++)
            d = fmax(d, fabs((double)image->rgba[4 * i + c] - want[stride * i + c]));
        bad += d > 2e-3;
        worst = fmax(worst, d);
    }
    if (bad > 0.03 * n)
        fail_msg("%s, %s: %d of %d pixels differ, by up to %g", cpu ? cpu : "scalar", what, bad, n, worst);
}

static void random_modes_and_steps_equal_the_reference_in_every_build(void **state)
{
    (void)state;
    for (uint64_t round = 0; round < 40; round++) {
        const uint64_t seed = test_random(test_seed(), round);
        test_together t = {.own = true};
        char what[64];
        for (uint64_t i = 0; i < 2 + round % 3; i++)
            add_random(&t, test_random(seed, 50 + i));
        look_at_all(&t, seed);
        if (round % 4 == 0)
            for (size_t i = 0; i < t.n; i++) /* steps alone */
                test_ray_scene_set(&t.part[i], "mode", "composite");
        if (round % 8 == 4)
            test_ray_scene_set(&t.part[0], "preintegrated", "true");
        snprintf(what, sizeof what, "round %d, seed %llu", (int)round, (unsigned long long)seed);
        test_ray_scene *s = test_together_all(&t);
        double *want = test_ray_reference(s);
        for (const char *const *cpu = test_ray_cpus(); *cpu; cpu++) {
            vv_image *image = test_ray_picture(s, *cpu, 1);
            compare(image, want, 5, *cpu, what);
            vv_image_release(image);
        }
        vv_image *image = test_ray_picture_by(s, &vvi_ray_kernels_scalar);
        compare(image, want, 5, NULL, what);
        vv_image_release(image);
        free(want);
        test_together_finish(&t);
    }
}

/* What is no layer, drawn without the layers; then each layer drawn alone, laid over it as the formula says. */
static void a_picture_is_those_of_its_parts_one_over_the_other(void **state)
{
    enum { PIXELS = 23 * 19 };
    (void)state;
    for (uint64_t round = 0; round < 12; round++) {
        const uint64_t seed = test_random(test_seed(), 300 + round);
        test_together t = {.own = true};
        char what[64];
        for (uint64_t i = 0; i < 4; i++)
            add_random(&t, test_random(seed, 50 + i));
        test_ray_scene_set(&t.part[0], "mode", "composite");
        test_ray_scene_set(&t.part[2], "mode", round % 2 ? "isosurface" : "composite");
        test_ray_scene_set(&t.part[1], "mode", mode_names[1 + round % 5]);
        test_ray_scene_set(&t.part[3], "mode", mode_names[1 + (round + 1) % 5]);
        for (size_t i = 1; i < 4; i += 2) /* of one opacity, which pictures of them alone have too */
            test_ray_scene_opacity(&t.part[i], (const double[]){0, 1}, 1);
        look_at_all(&t, seed);
        snprintf(what, sizeof what, "round %d, seed %llu", (int)round, (unsigned long long)seed);
        test_ray_scene *s = test_together_all(&t);
        vv_image *whole = test_ray_picture(s, NULL, 1);
        vv_actor rest[2] = {t.actors[0], t.actors[2]};
        s->scene.actors = rest;
        s->scene.n_actors = 2;
        vv_image *below = test_ray_picture(s, NULL, 1);
        double sum[4 * PIXELS];
        for (int i = 0; i < 4 * PIXELS; i++)
            sum[i] = (double)below->rgba[i];
        for (size_t v = 1; v < 4; v += 2) {
            s->scene.actors = &t.actors[v];
            s->scene.n_actors = 1;
            vv_image *layer = test_ray_picture(s, NULL, 1);
            const bool adds = t.actors[v].layer.blend == VV_SLICE_ADD;
            for (int i = 0; i < PIXELS; i++) {
                const double alpha = (double)layer->rgba[4 * i + 3];
                for (int c = 0; c < 3; c++)
                    sum[4 * i + c] = (double)layer->rgba[4 * i + c] + (adds ? 1 : 1 - alpha) * sum[4 * i + c];
                sum[4 * i + 3] = alpha + (1 - alpha) * sum[4 * i + 3];
            }
            vv_image_release(layer);
        }
        for (int i = 0; i < 4 * PIXELS; i++)
            if (!(fabs((double)whole->rgba[i] - sum[i]) < 1e-6))
                fail_msg("%s: pixel %d is %g, not %g", what, i / 4, (double)whole->rgba[i], sum[i]);
        vv_image_release(whole);
        vv_image_release(below);
        test_together_finish(&t);
    }
}

/* Bright specks in a dark box. */
static test_ray_scene *add_specks(test_together *t, uint64_t seed, double voxel, vv_vec3 origin)
{
    vv_field_info info = vv_field_info_default();
    info.grid.dims[0] = 37, info.grid.dims[1] = 41, info.grid.dims[2] = 29;
    for (int a = 0; a < 3; a++)
        info.grid.index_to_world.axis[a] = vvi_scaled(info.grid.index_to_world.axis[a], voxel);
    info.grid.index_to_world.origin = origin;
    vv_field *field;
    void *data;
    assert_int_equal(vv_field_new_empty(&field, &data, &info, NULL), VV_OK);
    uint8_t *v = data;
    memset(v, 10, 37 * 41 * 29);
    for (uint64_t i = 0; i < 60; i++)
        v[test_random(seed, i) % (37 * 41 * 29)] = (uint8_t)(100 + test_random(seed, i + 100) % 156);
    test_ray_scene *s = test_together_add(t, field);
    test_ray_scene_opacity(s, (const double[]){30, 0, 60, 0.2, 255, 0.9}, 3);
    test_ray_scene_color(s, (const double[]){0, 0.1, 0.9, 0.2, 100, 0.9, 0.3, 0.1, 255, 0.2, 0.3, 1}, 3);
    s->actor.classes.opacity_length = voxel;
    return s;
}

static void skipping_changes_no_byte_and_neither_do_threads(void **state)
{
    (void)state;
    for (const char *const *cpu = test_ray_cpus(); *cpu; cpu++)
        for (uint64_t round = 0; round < 6; round++) {
            const uint64_t seed = test_random(test_seed(), 900 + round);
            test_together t = {.own = true};
            add_specks(&t, seed, 1, vvi_vec(0, 0, 0));
            add_specks(&t, seed + 1, 0.01, vvi_vec(11.3, 10, 7.7));
            add_specks(&t, seed + 2, 0.4, vvi_vec(5, 15, 3));
            add_specks(&t, seed + 3, 1.3, vvi_vec(-7, 3, 3));
            test_ray_scene_set(&t.part[0], "step", round % 2 ? "0.7" : "1.3");
            test_ray_scene_set(&t.part[1], "step", "0.009");
            test_ray_scene_set(&t.part[2], "step", "0.31");
            test_ray_scene_set(&t.part[3], "mode", round < 3 ? "maximum" : "local-maximum");
            for (size_t i = 0; i < 3; i++)
                test_ray_scene_set(&t.part[i], "preintegrated", round > 3 ? "true" : "false");
            const vv_vec3 at = {11.5, 10.2, 7.85};
            vv_vec3 away = {test_random_unit(seed, 1) - 0.5, test_random_unit(seed, 2) - 0.5, 0.6};
            assert_true(vvi_unit(&away));
            test_ray_scene *s = &t.part[0];
            test_ray_scene_look(s, vvi_add(at, vvi_scaled(away, 150)), at, 0, round % 2 ? 1 : 40);
            s->scene.width = s->scene.height = s->scene.rows = 32;
            vv_image *first = NULL;
            for (int i = 0; i < 6; i++) {
                for (size_t v = 0; v < t.n; v++) {
                    test_ray_scene_set(&t.part[v], "skipping", i & 1 ? "true" : "false");
                    test_ray_scene_set(&t.part[v], "parc", i & 2 ? "true" : "false");
                }
                vv_image *image = test_ray_picture(test_together_all(&t), *cpu, i < 4 ? 1 : i - 2);
                if (first) {
                    assert_memory_equal(image->rgba, first->rgba, 32 * 32 * 4 * sizeof(float));
                    assert_memory_equal(image->depth, first->depth, 32 * 32 * sizeof(float));
                    vv_image_release(image);
                } else {
                    first = image;
                }
            }
            vv_image_release(first);
            test_together_finish(&t);
        }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(one_value_of_a_ray_lies_over_a_cloud),
        cmocka_unit_test(channels_add_their_light),
        cmocka_unit_test(the_first_of_layers_is_the_ground),
        cmocka_unit_test(a_layer_has_the_depth_where_it_hides_half),
        cmocka_unit_test(opacity_is_per_length_whatever_the_steps),
        cmocka_unit_test(a_fine_volume_costs_no_more_beside_a_coarse_one),
        cmocka_unit_test(random_modes_and_steps_equal_the_reference_in_every_build),
        cmocka_unit_test(a_picture_is_those_of_its_parts_one_over_the_other),
        cmocka_unit_test(skipping_changes_no_byte_and_neither_do_threads),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
