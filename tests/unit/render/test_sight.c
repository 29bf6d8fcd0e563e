/* Layers and picking against geometry: a sphere whose values are the distance from its surface. */
#include "fields.h"
#include "jobs.h"
#include "model/context.h"
#include "ray_scene.h"
#include "render/pixel_value.h"
#include "scene/lens.h"
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <volvis/pick.h>
#include <volvis/render.h>
#include <volvis/sys/scene.h>

#include <cmocka.h>

enum { WIDTH = 61, HEIGHT = 47, ALL_LAYERS = (1 << VV_LAYER_COUNT) - 1 };
static const vv_vec3 centre = {7, 8, 9};
#define RADIUS 5.0

static void set(vv_world **world, const char *path, const char *json)
{
    const vv_property_context context = vvi_registry_context(NULL);
    vv_object *root = &(*world)->base;
    if (vv_path_set(&root, path, json, &context) != VV_OK)
        fail_msg("%s", vv_error_last()->message);
    *world = (vv_world *)(void *)root;
}

/* The sphere as a solid, small, seen from the side, with all layers. */
static vv_world *sphere(void)
{
    vv_world *world;
    vv_field *field = test_field_cube(&test_form_sphere, 48, 0, 16, NULL);
    assert_non_null(field);
    assert_int_equal(vv_world_for_field(&world, "ball", field, NULL), VV_OK);
    vv_field_release(field);
    set(&world, "views.main.width", "61");
    set(&world, "views.main.height", "47");
    set(&world, "views.main.camera.azimuth", "25");
    set(&world, "views.main.camera.elevation", "-35");
    set(&world, "volumes.ball.segmentation", "{\"kind\": \"threshold\", \"threshold\": {\"lo\": -100, \"hi\": 0}}");
    set(&world, "views.main.render.layers",
        "{\"depth\": true, \"normal\": true, \"id\": true, \"samples\": true, \"value\": true}");
    return world;
}

static vv_image *picture_of(vv_world *world, vv_job *job)
{
    vv_image *image;
    if (vv_render(&image, NULL, world, "main", NULL, job) != VV_OK)
        fail_msg("%s", vv_error_last()->message);
    return image;
}

/* Where a ray meets the sphere; false where it passes by, or grazes it. */
static bool meets(double *depth_out, vv_vec3 *normal_out, const vv_lens *lens, int32_t x, int32_t y)
{
    vv_vec3 origin, direction;
    vvi_lens_ray(&origin, &direction, lens, WIDTH, HEIGHT, x + 0.5, y + 0.5);
    const vv_vec3 to = vvi_sub(origin, centre);
    const double b = vvi_dot(to, direction), inside = b * b - vvi_dot(to, to) + RADIUS * RADIUS;
    if (inside < 6)
        return false;
    *depth_out = -b - sqrt(inside);
    *normal_out = vvi_scaled(vvi_add(to, vvi_scaled(direction, *depth_out)), 1 / RADIUS);
    return true;
}

static void the_layers_of_a_sphere_are_its_geometry(void **state)
{
    (void)state;
    vv_world *world = sphere();
    vv_image *image = picture_of(world, NULL);
    vv_scene *scene;
    size_t n_hits = 0, n_misses = 0;
    assert_int_equal(vv_scene_resolve(&scene, world, "main", NULL), VV_OK);
    assert_int_equal(vv_image_layers(image), ALL_LAYERS);
    for (int32_t y = 0; y < HEIGHT; y++)
        for (int32_t x = 0; x < WIDTH; x++) {
            const size_t at = (size_t)(y * WIDTH + x);
            const float *n = image->normal + 3 * at;
            double depth;
            vv_vec3 normal;
            assert_int_equal(image->samples[at], 1);
            if (!isfinite(image->depth[at])) {
                assert_true(image->id[at] == 0 && isnan(image->value[at]) && n[0] == 0 && n[1] == 0 && n[2] == 0);
                n_misses++;
                continue;
            }
            assert_int_equal(image->id[at], 1);
            assert_true(fabs((double)image->value[at]) < 2e-3);
            assert_true(fabs((double)(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]) - 1) < 1e-5);
            if (!meets(&depth, &normal, &scene->lens, x, y))
                continue;
            /* linear between samples 0.34 apart: at most h^2 / 8 times the largest second derivative, 2 / R */
            assert_true(fabs((double)image->depth[at] - depth) < 0.02);
            assert_true((double)n[0] * normal.x + (double)n[1] * normal.y + (double)n[2] * normal.z > 0.9995);
            n_hits++;
        }
    assert_true(n_hits > 100 && n_misses > 200);
    vv_scene_release(scene);
    vv_image_release(image);
    vv_object_release(&world->base);
}

static void picking_tells_what_the_layers_hold(void **state)
{
    (void)state;
    vv_world *world = sphere();
    vv_image *image = picture_of(world, NULL);
    vv_pixel pixels[WIDTH * HEIGHT];
    vv_picked *picked = calloc(WIDTH * HEIGHT, sizeof *picked);
    for (int32_t i = 0; i < WIDTH * HEIGHT; i++)
        pixels[i] = (vv_pixel){i % WIDTH, i / WIDTH};
    assert_int_equal(vv_pick(picked, pixels, WIDTH * HEIGHT, world, NULL, NULL), VV_OK);
    for (size_t i = 0; i < WIDTH * HEIGHT; i++) {
        const vv_picked *p = &picked[i];
        assert_true(p->pixel.x == pixels[i].x && p->pixel.y == pixels[i].y);
        assert_true(p->hit == (bool)isfinite(image->depth[i]) && p->id == image->id[i]);
        assert_true(memcmp(p->rgba, image->rgba + 4 * i, sizeof p->rgba) == 0 || !p->hit);
        if (!p->hit)
            continue;
        assert_string_equal(p->volume, "ball");
        assert_true((float)p->depth == image->depth[i] && (float)p->value == image->value[i]);
        assert_true((float)p->normal.z == image->normal[3 * i + 2]);
        assert_true(fabs(vvi_length(vvi_sub(p->world, centre)) - RADIUS) < 0.02);
        assert_true(fabs(p->index.x * 16 / 47 - p->world.x) < 1e-9 && fabs(p->index.z * 16 / 47 - p->world.z) < 1e-9);
        assert_true(fabs(vvi_length(p->gradient) - 1) < 0.01); /* of a distance */
        assert_false(p->labelled);
    }
    const vv_pixel outside = {WIDTH, 0};
    assert_int_equal(vv_pick(picked, &outside, 1, world, NULL, NULL), VV_E_ARGUMENT);
    assert_non_null(strstr(vv_error_last()->message, "61 x 47"));
    free(picked);
    vv_image_release(image);
    vv_object_release(&world->base);
}

/* A plane through the middle shows the inside. */
static void a_cut_through_the_solid_faces_as_its_plane_does(void **state)
{
    (void)state;
    vv_world *world = sphere();
    size_t n_flat = 0;
    set(&world, "volumes.ball.segmentation", "{\"kind\": \"threshold\", \"threshold\": {\"lo\": -100, \"hi\": 0}}");
    set(&world, "views.main.render.raycast.mode", "composite");
    set(&world, "views.main.camera.azimuth", "0");
    set(&world, "views.main.camera.elevation", "0");
    set(&world, "cut_planes", "[{\"normal\": [0, 1, 0], \"offset\": 8}]");
    vv_image *image = picture_of(world, NULL);
    for (size_t i = 0; i < WIDTH * HEIGHT; i++) {
        const float *n = image->normal + 3 * i;
        if (!isfinite(image->depth[i]) || image->value[i] > -0.2f)
            continue;
        assert_true(fabsf(n[0]) < 1e-6f && fabsf(n[1] + 1) < 1e-6f && fabsf(n[2]) < 1e-6f);
        n_flat++;
    }
    assert_true(n_flat > 100);
    vv_image_release(image);
    vv_object_release(&world->base);
}

static void of_several_volumes_each_has_its_number(void **state)
{
    (void)state;
    vv_world *world = sphere();
    set(&world, "volumes.other",
        "{\"data\": \"ball\", \"place\": {\"position\": [14, 0, 0]}, \"segmentation\": {\"kind\": \"threshold\", "
        "\"threshold\": {\"lo\": -100, \"hi\": 0}}}");
    vv_image *image = picture_of(world, NULL);
    vv_scene *scene;
    size_t n[3] = {0};
    assert_int_equal(vv_scene_resolve(&scene, world, "main", NULL), VV_OK);
    for (size_t i = 0; i < WIDTH * HEIGHT; i++) {
        vv_vec3 origin, direction;
        n[image->id[i]]++;
        if (!image->id[i])
            continue;
        vvi_lens_ray(&origin, &direction, &scene->lens, WIDTH, HEIGHT, (double)(i % WIDTH) + 0.5,
                     (double)(i / WIDTH) + 0.5);
        const vv_vec3 p = vvi_add(origin, vvi_scaled(direction, (double)image->depth[i]));
        assert_int_equal(image->id[i], p.x > 14 ? 2 : 1); /* half way between the balls' centres */
    }
    assert_true(n[0] > 100 && n[1] > 50 && n[2] > 50);
    vv_scene_release(scene);
    vv_image_release(image);
    vv_object_release(&world->base);
}

static void a_label_is_told(void **state)
{
    (void)state;
    vv_field_info info = vv_field_info_default();
    void *data;
    vv_field *field;
    vv_world *world;
    vv_picked picked;
    info.grid = test_cube(9, 0, 8);
    info.meaning = VV_MEANING_LABEL;
    assert_int_equal(vv_field_new_empty(&field, &data, &info, NULL), VV_OK);
    memset(data, 3, 9 * 9 * 9);
    assert_int_equal(vv_world_for_field(&world, "atlas", field, NULL), VV_OK);
    vv_field_release(field);
    const vv_pixel middle = {400, 400};
    assert_int_equal(vv_pick(&picked, &middle, 1, world, NULL, NULL), VV_OK);
    assert_true(picked.hit && picked.labelled && picked.label == 3 && picked.value == 3);
    vv_object_release(&world->base);
}

static void threads_change_no_number(void **state)
{
    (void)state;
    vv_world *world = sphere();
    vv_image *alone = picture_of(world, NULL);
    for (int threads = 2; threads <= 3; threads++) {
        vv_job *job = test_job(threads, 0);
        vv_image *image = picture_of(world, job);
        assert_memory_equal(image->normal, alone->normal, sizeof(float) * 3 * WIDTH * HEIGHT);
        assert_memory_equal(image->value, alone->value, sizeof(float) * WIDTH * HEIGHT);
        vv_image_release(image);
        vv_job_release(job);
    }
    vv_image_release(alone);
    vv_object_release(&world->base);
}

/* The layers of a picture by one build against the data, looked up in double precision where the depths are. */
static size_t compare_with_the_data(vv_world *world, const char *cpu, const char *what, bool spline)
{
    const double h = 16.0 / 47;
    vv_runtime_options options;
    vv_runtime *runtime;
    vv_job *job;
    vv_scene *scene;
    vvi_sight sight;
    size_t n_hits = 0, n_other = 0;
    vv_runtime_options_init(&options, sizeof options);
    options.cpu = cpu;
    assert_int_equal(vv_runtime_new(&runtime, &options), VV_OK);
    assert_int_equal(vv_job_new(&job, runtime, NULL, NULL), VV_OK);
    vv_image *image = picture_of(world, job);
    assert_int_equal(vv_scene_resolve(&scene, world, "main", job), VV_OK);
    assert_int_equal(vvi_sight_open(&sight, scene, job), VV_OK);
    for (size_t i = 0; i < WIDTH * HEIGHT; i++) {
        const float *n = image->normal + 3 * i;
        vvi_seen seen;
        if (!isfinite(image->depth[i])) {
            assert_true(image->id[i] == 0 && isnan(image->value[i]) && n[0] == 0 && n[1] == 0 && n[2] == 0);
            continue;
        }
        assert_true(image->id[i] >= 1 && image->id[i] <= scene->n_actors);
        vvi_sight_of(&seen, &sight, image->id[i], (double)(i % WIDTH) + 0.5, (double)(i / WIDTH) + 0.5,
                     (double)image->depth[i]);
        /* looked up linearly: h^2 / 8 times the sum of second derivatives, 2 / r, from the ball and its spline */
        const double *at = &seen.index.x;
        bool border = false; /* where a spline's coefficients are mirrored, which bends it */
        for (int a = 0; a < 3; a++)
            border = border || at[a] < 4 || at[a] > 43;
        if (spline && border)
            continue;
        const double slack = spline ? 1.1 * h * h / 8 * 2 / fmax(RADIUS + seen.value, h) : 2e-4;
        if (fabs((double)image->value[i] - seen.value) > slack)
            fail_msg("%s, %s: pixel %zu has value %g, the data %g", cpu, what, i, (double)image->value[i], seen.value);
        const double along = (double)n[0] * seen.normal.x + (double)n[1] * seen.normal.y + (double)n[2] * seen.normal.z;
        n_other += along < 0.999; /* where the gradient jumps, or a face is entered at its edge */
        n_hits++;
    }
    if (n_other > n_hits / 100)
        fail_msg("%s, %s: %zu of %zu normals are others than those of the data", cpu, what, n_other, n_hits);
    vvi_sight_close(&sight);
    vv_scene_release(scene);
    vv_image_release(image);
    vv_job_release(job);
    vv_runtime_release(runtime);
    return n_hits;
}

static void what_kernels_meet_is_what_the_data_are_there(void **state)
{
    static const char *const sets[][3] = {
        {"a solid", "raycast.mode", "composite"},         {"an isosurface", "raycast.mode", "isosurface"},
        {"a maximum", "raycast.mode", "maximum"},         {"a local maximum", "raycast.mode", "local-maximum"},
        {"half of a cloud", "raycast.mode", "composite"}, {"a cloud and a solid", "raycast.mode", "composite"}};
    (void)state;
    for (const char *const *cpu = test_ray_cpus(); *cpu; cpu++)
        for (size_t i = 0; i < sizeof sets / sizeof *sets; i++)
            for (int cubic = 0; cubic < 2; cubic++) {
                char path[64], json[64];
                if (cubic && (i == 2 || i == 3))
                    continue; /* refused */
                vv_world *world = sphere();
                snprintf(path, sizeof path, "views.main.render.%s", sets[i][1]);
                snprintf(json, sizeof json, "\"%s\"", sets[i][2]);
                set(&world, path, json);
                if (cubic)
                    set(&world, "volumes.ball.interpolation", "\"cubic\"");
                if (i == 1)
                    set(&world, "views.main.render.raycast.iso", "-1.5");
                if (i == 1 || i == 0)
                    set(&world, "cut_planes", "[{\"normal\": [0, 1, 0.2], \"offset\": 9}]");
                if (i >= 4)
                    set(&world, "volumes.ball.segmentation",
                        "{\"kind\": \"transfer\", \"transfer\": {\"opacity\": [[-5, 0.9], [-1, 0.3], [0, 0.01]], "
                        "\"opacity_length\": 1}}");
                if (i == 5)
                    set(&world, "volumes.other",
                        "{\"data\": \"ball\", \"place\": {\"position\": [6, 0, 0]}, \"segmentation\": "
                        "{\"kind\": \"threshold\", \"threshold\": {\"lo\": -100, \"hi\": 0}}}");
                const size_t n = compare_with_the_data(world, *cpu, sets[i][0], cubic);
                assert_true(n > 200);
                vv_object_release(&world->base);
            }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_layers_of_a_sphere_are_its_geometry),
        cmocka_unit_test(picking_tells_what_the_layers_hold),
        cmocka_unit_test(a_cut_through_the_solid_faces_as_its_plane_does),
        cmocka_unit_test(of_several_volumes_each_has_its_number),
        cmocka_unit_test(a_label_is_told),
        cmocka_unit_test(threads_change_no_number),
        cmocka_unit_test(what_kernels_meet_is_what_the_data_are_there),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
