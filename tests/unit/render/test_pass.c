/* Where the rays of a pass go: coarse grids and shifted ones show what full pictures show at the same places. */
#include "fields.h"
#include "jobs.h"
#include "ray_scene.h"
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <volvis/render.h>

#include <cmocka.h>

extern const vv_renderer vvi_renderer_raycast;

static const char *const modes[] = {"\"composite\"", "\"maximum\"", "\"mean\"", "\"isosurface\""};
enum { MODES = sizeof modes / sizeof modes[0] };

/* A shaded cube of the ripples of Marschner and Lobb, seen at an angle. */
static void make_scene(test_ray_scene *s, vv_field **field, const char *mode)
{
    *field = test_field_cube(&test_form_marschner_lobb, 20, -1, 1, NULL);
    assert_non_null(*field);
    test_ray_scene_init(s, *field, 0);
    test_ray_scene_look(s, (vv_vec3){3, 4, 2.5}, (vv_vec3){0, 0, 0}, 0.6, 0);
    test_ray_scene_opacity(s, (const double[]){0.3, 0, 0.7, 0.9}, 2);
    test_ray_scene_color(s, (const double[]){0, 0.9, 0.2, 0.1, 1, 0.3, 0.9, 1}, 2);
    test_ray_scene_light(s);
    s->actor.iso = 0.5;
    vv_object *params = &s->params->base;
    assert_int_equal(vv_path_set(&params, "mode", mode, NULL), VV_OK);
    assert_int_equal(vv_path_set(&params, "step", "0.05", NULL), VV_OK);
    s->params = (vvi_raycast_params *)params;
    s->scene.params = params;
}

static vv_image *picture(const test_ray_scene *s, const vv_pass *pass, int32_t width, int32_t height)
{
    void *state = NULL;
    vv_image *image = NULL;
    vv_render_counts counts = {0};
    const vv_tile all = {0, 0, width, height};
    assert_int_equal(vv_image_new(&image, width, height, VV_LAYER_DEPTH, NULL), VV_OK);
    assert_int_equal(vvi_raycast_prepare(&state, &s->scene, NULL), VV_OK);
    assert_int_equal(vvi_renderer_raycast.render(state, pass, &all, image, &counts, NULL), VV_OK);
    assert_true(counts.rays == (uint64_t)width * (uint64_t)height);
    vvi_raycast_finish(state);
    return image;
}

static void a_coarse_pass_has_every_nth_pixel(void **state)
{
    const vv_pass full = {.x = 0.5, .y = 0.5, .stride = 1};
    (void)state;
    for (size_t m = 0; m < MODES; m++) {
        test_ray_scene s;
        vv_field *field;
        make_scene(&s, &field, modes[m]);
        s.params->jitter = true; /* by the pixel of the scene, so that it is the same too */
        vv_image *all = picture(&s, &full, 64, 64);
        for (int32_t stride = 2; stride <= 4; stride++) {
            const vv_pass pass = {.x = 0.5 + 1, .y = 0.5, .stride = stride};
            const int32_t n = 64 / stride;
            vv_image *some = picture(&s, &pass, n, n);
            for (int32_t i = 0; i < n * n; i++) {
                const size_t at = (size_t)(i / n * stride) * 64 + (size_t)(i % n * stride + 1);
                assert_memory_equal(some->rgba + 4 * i, all->rgba + 4 * at, 4 * sizeof(float));
                assert_memory_equal(some->depth + i, all->depth + at, sizeof(float));
            }
            vv_image_release(some);
        }
        vv_image_release(all);
        test_ray_scene_finish(&s);
        vv_field_release(field);
    }
}

static void a_shifted_pass_has_the_pixels_of_a_finer_picture(void **state)
{
    const vv_pass full = {.x = 0.5, .y = 0.5, .stride = 1};
    (void)state;
    for (size_t m = 0; m < MODES; m++) {
        test_ray_scene s;
        vv_field *field;
        make_scene(&s, &field, modes[m]);
        s.scene.width = s.scene.height = s.scene.rows = 128;
        vv_image *fine = picture(&s, &full, 128, 128);
        s.scene.width = s.scene.height = s.scene.rows = 64;
        for (int32_t i = 0; i < 4; i++) {
            const int32_t dx = i % 2, dy = i / 2;
            const vv_pass pass = {.x = 0.25 + 0.5 * dx - 1, .y = 0.25 + 0.5 * dy, .stride = 1};
            vv_image *shifted = picture(&s, &pass, 65, 64); /* one column more on the left */
            for (int32_t p = 0; p < 64 * 64; p++) {
                const size_t at = (size_t)(p / 64 * 2 + dy) * 128 + (size_t)(p % 64 * 2 + dx);
                const size_t here = (size_t)(p / 64) * 65 + (size_t)(p % 64) + 1;
                for (size_t c = 0; c < 4; c++)
                    assert_true(fabsf(shifted->rgba[4 * here + c] - fine->rgba[4 * at + c]) < 1e-5f);
            }
            vv_image_release(shifted);
        }
        vv_image_release(fine);
        test_ray_scene_finish(&s);
        vv_field_release(field);
    }
}

static void nobody(void *user, const vv_refinement *refinement)
{
    *(int *)user += 1;
    assert_int_equal(refinement->image->width, 77);
}

static vv_image *view(vv_world *world, const vv_render_options *options, int threads)
{
    vv_job *job = test_job(threads, 0);
    vv_image *image = NULL;
    if (vv_render(&image, NULL, world, NULL, options, job) != VV_OK)
        fail_msg("%s", vv_error_last()->message);
    vv_job_release(job);
    return image;
}

static void pictures_that_grow_end_as_the_ones_made_at_once(void **state)
{
    static const char *const edits[][2] = {{"width", "77"}, {"height", "53"}, {"render.raycast.jitter", "true"}};
    vv_field *field = test_field_cube(&test_form_marschner_lobb, 20, -1, 1, NULL);
    vv_world *world = NULL;
    vv_render_options options;
    int calls = 0;
    assert_int_equal(vv_world_for_field(&world, "a", field, NULL), VV_OK);
    vv_object *root = &world->base;
    for (size_t i = 0; i < 3; i++) {
        char path[64];
        snprintf(path, sizeof path, "views.main.%s", edits[i][0]);
        assert_int_equal(vv_path_set(&root, path, edits[i][1], NULL), VV_OK);
    }
    vv_render_options_init(&options, sizeof options);
    options.on_refined = nobody;
    options.user = &calls;
    for (int samples = 1; samples <= 3; samples += 2) {
        assert_int_equal(vv_path_set(&root, "views.main.render.samples", samples == 1 ? "1" : "3", NULL), VV_OK);
        vv_image *at_once = view((vv_world *)root, NULL, 1);
        for (int threads = 1; threads <= 3; threads++) {
            calls = 0;
            vv_image *grown = view((vv_world *)root, &options, threads);
            assert_int_equal(calls, samples + 2);
            assert_memory_equal(at_once->rgba, grown->rgba, 77 * 53 * 4 * sizeof(float));
            assert_memory_equal(at_once->depth, grown->depth, 77 * 53 * sizeof(float));
            vv_image_release(grown);
        }
        vv_image_release(at_once);
    }
    vv_object_release(root);
    vv_field_release(field);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_coarse_pass_has_every_nth_pixel),
        cmocka_unit_test(a_shifted_pass_has_the_pixels_of_a_finer_picture),
        cmocka_unit_test(pictures_that_grow_end_as_the_ones_made_at_once),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
