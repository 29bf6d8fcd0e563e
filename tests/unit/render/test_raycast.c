/* Ray casting against closed forms: section 2 of the algorithm notes. */
#include "fail_alloc.h"
#include "fields.h"
#include "jobs.h"
#include "ray_scene.h"
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static void set(test_ray_scene *s, const char *path, const char *json)
{
    vv_object *params = &s->params->base;
    assert_int_equal(vv_path_set(&params, path, json, NULL), VV_OK);
    s->params = (vvi_raycast_params *)params;
    s->scene.params = params;
}

static double alpha_at(const vv_image *image, int32_t x, int32_t y)
{
    return (double)image->rgba[4 * (y * image->width + x) + 3];
}

static double opacity_of(double kappa)
{
    return 1 - exp(-kappa);
}

/* A box of n samples a side over [0, 1]^3 with v(p) = the form's. */
static vv_field *unit_box(const test_form *form, int64_t n)
{
    vv_field *field = test_field_cube(form, n, 0, 1, NULL);
    assert_non_null(field);
    return field;
}

static double one_value(vv_vec3 p)
{
    (void)p;
    return 1;
}
static vv_vec3 no_gradient(vv_vec3 p)
{
    (void)p;
    return (vv_vec3){0, 0, 0};
}
static const test_form one = {"one", one_value, no_gradient};

static double z_value(vv_vec3 p)
{
    return 1 - p.z;
}
static vv_vec3 z_gradient(vv_vec3 p)
{
    (void)p;
    return (vv_vec3){0, 0, -1};
}
/** 0 where a ray along -z enters, 1 where it leaves. */
static const test_form along_view = {"along view", z_value, z_gradient};

static void a_uniform_slab_has_the_same_opacity_for_any_step(void **state)
{
    (void)state;
    vv_field *field = test_field_cube(&one, 5, 0, 0.5, NULL);
    const char *const steps[] = {"0.5", "0.1", "0.037", "0.125", "3"};
    for (const char *const *cpu = test_ray_cpus(); *cpu; cpu++)
        for (size_t i = 0; i < sizeof steps / sizeof *steps; i++) {
            test_ray_scene s;
            test_ray_scene_init(&s, field, 0.4);
            test_ray_scene_opacity(&s, (const double[]){1, opacity_of(2)}, 1);
            set(&s, "step", steps[i]);
            vv_image *image = test_ray_picture(&s, *cpu, 1);
            assert_true(fabs(alpha_at(image, 32, 32) - 0.632121) < 1e-6);
            assert_true(fabs(alpha_at(image, 3, 60) - 0.632121) < 1e-6);
            vv_image_release(image);
            test_ray_scene_finish(&s);
        }
    vv_field_release(field);
}

/* Opacity 0.5 for a length of 1: one step of another length has the opacity of that length. */
static void opacity_is_that_of_the_length(void **state)
{
    (void)state;
    static const struct {
        double length, opacity, step, want;
    } cases[] = {{0.5, 0.5, 0.5, 0.292893}, {2, 0.5, 2, 0.75}, {10, 0.1, 1, 0.651322}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        vv_field *field = test_field_cube(&one, 5, 0, cases[i].length, NULL);
        char step[32];
        test_ray_scene s;
        test_ray_scene_init(&s, field, 0.4);
        test_ray_scene_opacity(&s, (const double[]){1, cases[i].opacity}, 1);
        snprintf(step, sizeof step, "%g", cases[i].step);
        set(&s, "step", step);
        for (const char *const *cpu = test_ray_cpus(); *cpu; cpu++) {
            vv_image *image = test_ray_picture(&s, *cpu, 1);
            assert_true(fabs(alpha_at(image, 32, 32) - cases[i].want) < 1e-6);
            vv_image_release(image);
        }
        test_ray_scene_finish(&s);
        vv_field_release(field);
    }
}

static void the_last_shorter_step_counts_as_long_as_it_is(void **state)
{
    (void)state;
    vv_field *field = test_field_cube(&one, 4, 0, 1.05, NULL);
    test_ray_scene s;
    test_ray_scene_init(&s, field, 0.5);
    test_ray_scene_opacity(&s, (const double[]){1, opacity_of(1)}, 1);
    set(&s, "step", "0.1");
    for (const char *const *cpu = test_ray_cpus(); *cpu; cpu++) {
        vv_image *image = test_ray_picture(&s, *cpu, 1);
        assert_true(fabs(alpha_at(image, 30, 30) - 0.650062) < 1e-6);
        vv_image_release(image);
    }
    test_ray_scene_finish(&s);
    vv_field_release(field);
}

static void a_ramp_in_front_of_the_light_has_its_closed_form(void **state)
{
    (void)state;
    vv_field *field = unit_box(&along_view, 101);
    test_ray_scene s;
    test_ray_scene_init(&s, field, 0.5);
    test_ray_scene_opacity(&s, (const double[]){0, opacity_of(2), 1, opacity_of(2)}, 2);
    test_ray_scene_color(&s, (const double[]){0, 0, 0, 0, 1, 1, 1, 1}, 2);
    set(&s, "step", "0.01");
    const double exact = (1 - 3 * exp(-2)) / 2;
    for (const char *const *cpu = test_ray_cpus(); *cpu; cpu++) {
        vv_image *image = test_ray_picture(&s, *cpu, 1);
        const double got = (double)image->rgba[4 * (32 * 64 + 32)];
        assert_true(fabs(got - exact) < 2e-5);
        vv_image_release(image);
    }
    test_ray_scene_finish(&s);
    vv_field_release(field);
}

static double ball_value(vv_vec3 p)
{
    return 1 - sqrt(p.x * p.x + p.y * p.y + p.z * p.z); /* 0 at radius 1 */
}
static vv_vec3 ball_gradient(vv_vec3 p)
{
    const double r = -sqrt(p.x * p.x + p.y * p.y + p.z * p.z);
    return (vv_vec3){p.x / r, p.y / r, p.z / r};
}
static const test_form ball = {"ball", ball_value, ball_gradient};

/* The uniform ball of radius 1 and extinction kappa: a jump of the transfer function at its surface. */
static void make_ball(test_ray_scene *s, vv_field **field, double kappa, int32_t size)
{
    *field = test_field_cube(&ball, 129, -1.1, 1.1, NULL);
    assert_non_null(*field);
    test_ray_scene_init(s, *field, 2);
    s->scene.width = s->scene.height = s->scene.rows = size;
    test_ray_scene_opacity(s, (const double[]){-10, 0, 0, 0, 0, opacity_of(kappa), 10, opacity_of(kappa)}, 4);
    set(s, "step", "0.01");
}

static void a_uniform_ball_has_the_mean_opacity_of_its_closed_form(void **state)
{
    (void)state;
    vv_field *field;
    test_ray_scene s;
    make_ball(&s, &field, 1, 256);
    vv_image *image = test_ray_picture(&s, NULL, 2);
    double sum = 0;
    for (int32_t i = 0; i < 256 * 256; i++)
        sum += (double)image->rgba[4 * i + 3];
    const double mean = sum / (256.0 * 256.0) * 4 / M_PI; /* over the disc */
    assert_true(fabs(mean - 0.703003) < 0.002 * 0.703003);
    vv_image_release(image);
    test_ray_scene_finish(&s);
    vv_field_release(field);
}

static void a_cut_plane_through_the_centre_halves_the_optical_depth(void **state)
{
    (void)state;
    vv_field *field;
    test_ray_scene s;
    make_ball(&s, &field, 1, 65);
    vv_image *image = test_ray_picture(&s, NULL, 1);
    assert_true(fabs(alpha_at(image, 32, 32) - 0.864665) < 2e-3);
    vv_image_release(image);
    s.actor.n_planes = 1;
    s.planes[0] = (vv_plane){{0, 0, 1}, 0}; /* the half towards the viewer */
    image = test_ray_picture(&s, NULL, 1);
    assert_true(fabs(alpha_at(image, 32, 32) - 0.632121) < 2e-3);
    vv_image_release(image);
    s.planes[0] = (vv_plane){{0, 0, -1}, 0};
    image = test_ray_picture(&s, NULL, 1);
    assert_true(fabs(alpha_at(image, 32, 32) - 0.632121) < 2e-3);
    vv_image_release(image);
    test_ray_scene_finish(&s);
    vv_field_release(field);
}

static void ending_early_changes_no_pixel_by_more_than_what_is_left(void **state)
{
    (void)state;
    vv_field *field;
    test_ray_scene s;
    make_ball(&s, &field, 20, 64);
    vv_image *whole = test_ray_picture(&s, NULL, 1);
    set(&s, "opaque", "0.001953125");
    vv_image *early = test_ray_picture(&s, NULL, 1);
    for (int32_t i = 0; i < 64 * 64 * 4; i++)
        assert_true(fabsf(whole->rgba[i] - early->rgba[i]) <= 1.0f / 512);
    assert_true(alpha_at(early, 32, 32) < 1);
    vv_image_release(whole);
    vv_image_release(early);
    test_ray_scene_finish(&s);
    vv_field_release(field);
}

static void the_maximum_of_one_bright_sample_is_its_value(void **state)
{
    (void)state;
    vv_field_info info = vv_field_info_default();
    info.grid.dims[0] = 11, info.grid.dims[1] = 9, info.grid.dims[2] = 7;
    vv_field *field;
    void *data;
    assert_int_equal(vv_field_new_empty(&field, &data, &info, NULL), VV_OK);
    memset(data, 0, 11 * 9 * 7);
    ((uint8_t *)data)[(3 * 9 + 4) * 11 + 5] = 200;
    test_ray_scene s;
    test_ray_scene_init(&s, field, 8);
    s.scene.width = s.scene.height = s.scene.rows =
        8; /* pixel centres at half voxels; shift by half a voxel onto the sample */
    test_ray_scene_look(&s, (vv_vec3){5.5, 4.5, 20}, (vv_vec3){5.5, 4.5, 0}, 0, 8);
    test_ray_scene_color(&s, (const double[]){0, 0, 0, 0, 255, 1, 1, 1}, 2);
    set(&s, "mode", "maximum");
    for (const char *const *cpu = test_ray_cpus(); *cpu; cpu++) {
        vv_image *image = test_ray_picture(&s, *cpu, 1);
        float most = 0;
        for (int32_t i = 0; i < 64; i++)
            most = fmaxf(most, image->rgba[4 * i]);
        assert_true(fabs((double)most - 200.0 / 255) < 1e-6);
        vv_image_release(image);
    }
    test_ray_scene_finish(&s);
    vv_field_release(field);
}

static double soft_ball_value(vv_vec3 p)
{
    const double inside = (0.8 - sqrt(p.x * p.x + p.y * p.y + p.z * p.z)) / 0.1; /* over 2 w = 0.2 from 1 to 0 */
    return fmin(fmax(inside, -1), 1) / 2 + 0.5;
}
static const test_form soft_ball = {"soft ball", soft_ball_value, no_gradient};

static void the_maximum_through_a_voxelized_ball_is_one_inside_of_its_soft_rim(void **state)
{
    (void)state;
    vv_field *field = test_field_cube(&soft_ball, 61, -1, 1, NULL);
    test_ray_scene s;
    test_ray_scene_init(&s, field, 2);
    test_ray_scene_look(&s, (vv_vec3){3, -2, 4}, (vv_vec3){0, 0, 0}, 0, 2);
    test_ray_scene_color(&s, (const double[]){0, 0, 0, 0, 1, 1, 1, 1}, 2);
    set(&s, "mode", "maximum");
    set(&s, "step", "0.02");
    for (const char *const *cpu = test_ray_cpus(); *cpu; cpu++) {
        vv_image *image = test_ray_picture(&s, *cpu, 1);
        for (int32_t y = 0; y < 64; y++)
            for (int32_t x = 0; x < 64; x++) {
                const double r = hypot((x + 0.5) / 32 - 1, (y + 0.5) / 32 - 1);
                const double got = (double)image->rgba[4 * (y * 64 + x)];
                if (r < 0.7 - 0.06) /* cells that are inside as a whole: a diagonal of 0.058 */
                    assert_true(got == 1);
                if (r > 0.9 + 0.06 && !(got == 0))
                    fail_msg("%g at radius %g", got, r);
            }
        vv_image_release(image);
    }
    test_ray_scene_finish(&s);
    vv_field_release(field);
}

/* A distance field of a ball of radius 20 voxels in a box of given spacing; iso 0 is its surface. */
static vv_field *distance_ball(vv_vec3 spacing)
{
    vv_field_info info = vv_field_info_default();
    info.type = VV_TYPE_F32;
    const double s[3] = {spacing.x, spacing.y, spacing.z};
    for (int a = 0; a < 3; a++)
        info.grid.dims[a] = (int64_t)floor(52 / s[a]) + 1;
    info.grid.index_to_world.axis[0].x = s[0];
    info.grid.index_to_world.axis[1].y = s[1];
    info.grid.index_to_world.axis[2].z = s[2];
    info.grid.index_to_world.origin = (vv_vec3){-26, -26, -26};
    vv_field *field;
    void *data;
    assert_int_equal(vv_field_new_empty(&field, &data, &info, NULL), VV_OK);
    float *v = data;
    for (int64_t k = 0; k < info.grid.dims[2]; k++)
        for (int64_t j = 0; j < info.grid.dims[1]; j++)
            for (int64_t i = 0; i < info.grid.dims[0]; i++) {
                const double x = -26 + (double)i * s[0], y = -26 + (double)j * s[1], z = -26 + (double)k * s[2];
                *v++ = (float)(20 - sqrt(x * x + y * y + z * z));
            }
    return field;
}

static void an_isosurface_of_a_ball_is_where_it_is(void **state)
{
    (void)state;
    vv_field *field = distance_ball((vv_vec3){1, 1, 1});
    test_ray_scene s;
    test_ray_scene_init(&s, field, 50);
    test_ray_scene_look(&s, (vv_vec3){41, -37, 60}, (vv_vec3){0, 0, 0}, 0, 36);
    set(&s, "mode", "isosurface");
    set(&s, "iso", "0");
    for (const char *const *cpu = test_ray_cpus(); *cpu; cpu++) {
        vv_image *image = test_ray_picture(&s, *cpu, 1);
        double worst = 0;
        for (int32_t y = 0; y < 64; y++)
            for (int32_t x = 0; x < 64; x++) {
                const vv_lens *l = &s.scene.lens;
                const double u = ((x + 0.5) / 32 - 1) * 18, v = (1 - (y + 0.5) / 32) * 18;
                if (u * u + v * v > 17 * 17)
                    continue; /* grazing rays multiply the radial error */
                const double b = 60 * 60 + 41 * 41 + 37 * 37;
                const double exact = sqrt(b) - sqrt(400 - u * u - v * v);
                const double cosine = sqrt(400 - u * u - v * v) / 20;
                const double got = (double)image->depth[y * 64 + x];
                worst = fmax(worst, fabs(got - exact) * cosine);
                (void)l;
            }
        if (worst > 1.0 / 80 + 1e-3)
            fail_msg("%s: off by %g", *cpu, worst);
        vv_image_release(image);
    }
    test_ray_scene_finish(&s);
    vv_field_release(field);
}

static void spacing_does_not_change_a_shaded_surface(void **state)
{
    (void)state;
    vv_field *a = distance_ball((vv_vec3){1, 1, 1}), *b = distance_ball((vv_vec3){1, 1, 2.5});
    vv_image *image[2];
    for (int i = 0; i < 2; i++) {
        test_ray_scene s;
        test_ray_scene_init(&s, i ? b : a, 50);
        test_ray_scene_look(&s, (vv_vec3){60, -50, 30}, (vv_vec3){0, 0, 0}, 0, 50);
        test_ray_scene_light(&s);
        s.lamps[1].color[0] = s.lamps[1].color[1] = s.lamps[1].color[2] = 0;
        set(&s, "mode", "isosurface");
        set(&s, "iso", "0");
        image[i] = test_ray_picture(&s, NULL, 2);
        test_ray_scene_finish(&s);
    }
    double sum = 0;
    for (int32_t i = 0; i < 64 * 64 * 4; i++)
        sum += pow((double)image[0]->rgba[i] - (double)image[1]->rgba[i], 2);
    assert_true(sqrt(sum / (64 * 64 * 4)) < 0.01);
    assert_true(alpha_at(image[0], 32, 32) > 0.999);
    vv_image_release(image[0]);
    vv_image_release(image[1]);
    vv_field_release(a);
    vv_field_release(b);
}

static void a_volume_of_which_nothing_is_visible_gives_a_clear_picture(void **state)
{
    (void)state;
    vv_field *field = unit_box(&one, 3);
    test_ray_scene s;
    test_ray_scene_init(&s, field, 2);
    vv_image *image = test_ray_picture(&s, NULL, 1);
    for (int32_t i = 0; i < 64 * 64; i++) {
        assert_true(image->rgba[4 * i + 3] == 0);
        assert_true(isinf(image->depth[i]));
    }
    vv_image_release(image);
    test_ray_scene_finish(&s);
    vv_field_release(field);
}

static vv_status prepare_once(void *user)
{
    const test_ray_scene *s = user;
    void *prepared = NULL;
    const vv_status st = vvi_raycast_prepare(&prepared, &s->scene, NULL);
    assert_true((st == VV_OK) == (prepared != NULL));
    vvi_raycast_finish(prepared);
    return st;
}

static void a_frame_without_memory_is_an_error_and_leaves_nothing(void **state)
{
    (void)state;
    static const vv_type types[] = {VV_TYPE_F32, VV_TYPE_F64}; /* as it lies, and converted */
    for (int t = 0; t < 2; t++)
        for (int mode = 0; mode < 3; mode++) {
            vv_field_info info = vv_field_info_default();
            info.type = types[t];
            info.grid = test_cube(9, 0, 8);
            vv_field *field = test_field(&test_form_sphere, &info, NULL);
            test_ray_scene s;
            test_ray_scene_init(&s, field, 8);
            test_ray_scene_opacity(&s, (const double[]){-3, 0.5, 0, 0}, 2);
            set(&s, "mode", mode == 0 ? "composite" : mode == 1 ? "maximum" : "isosurface");
            assert_true(test_fail_each_alloc(prepare_once, &s) > 2);
            test_ray_scene_finish(&s);
            vv_field_release(field);
        }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_uniform_slab_has_the_same_opacity_for_any_step),
        cmocka_unit_test(opacity_is_that_of_the_length),
        cmocka_unit_test(the_last_shorter_step_counts_as_long_as_it_is),
        cmocka_unit_test(a_ramp_in_front_of_the_light_has_its_closed_form),
        cmocka_unit_test(a_uniform_ball_has_the_mean_opacity_of_its_closed_form),
        cmocka_unit_test(a_cut_plane_through_the_centre_halves_the_optical_depth),
        cmocka_unit_test(ending_early_changes_no_pixel_by_more_than_what_is_left),
        cmocka_unit_test(the_maximum_of_one_bright_sample_is_its_value),
        cmocka_unit_test(the_maximum_through_a_voxelized_ball_is_one_inside_of_its_soft_rim),
        cmocka_unit_test(an_isosurface_of_a_ball_is_where_it_is),
        cmocka_unit_test(spacing_does_not_change_a_shaded_surface),
        cmocka_unit_test(a_frame_without_memory_is_an_error_and_leaves_nothing),
        cmocka_unit_test(a_volume_of_which_nothing_is_visible_gives_a_clear_picture),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
