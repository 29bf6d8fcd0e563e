/* Pictures of triangles against pictures of rays: the same surface, the same light, the same cuts. */
#include "core/cache.h"
#include "core/vec.h"
#include "fields.h"
#include "jobs.h"
#include "model/context.h"
#include "scene/lens.h"
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <volvis/pick.h>
#include <volvis/render.h>

#include <cmocka.h>

enum { SIDE = 160 };
#define VOXEL (16.0 / 32)

static void set(vv_world **world, const char *path, const char *json)
{
    const vv_property_context context = vvi_registry_context(NULL);
    vv_object *root = &(*world)->base;
    if (vv_path_set(&root, path, json, &context) != VV_OK)
        fail_msg("%s", vv_error_last()->message);
    *world = (vv_world *)(void *)root;
}

/* A ball of radius 5 whose inside has negative values; the solid is [-1.5, 0], a shell. */
static vv_world *world_of(const test_form *form, const char *threshold)
{
    vv_world *world;
    vv_field *field = test_field_cube(form, 33, 0, 16, NULL);
    assert_non_null(field);
    assert_int_equal(vv_world_for_field(&world, "ball", field, NULL), VV_OK);
    vv_field_release(field);
    set(&world, "views.main.width", "160");
    set(&world, "views.main.height", "160");
    set(&world, "views.main.render.samples", "1"); /* through the middle of each pixel */
    set(&world, "views.main.camera.azimuth", "25");
    set(&world, "views.main.camera.elevation", "30");
    set(&world, "volumes.ball.segmentation.kind", "threshold");
    set(&world, "volumes.ball.segmentation.threshold", threshold);
    return world;
}

static vv_image *picture_of(vv_world *world, const char *method, vv_job *job)
{
    vv_image *image;
    vv_world *with = (vv_world *)(void *)vv_object_retain(&world->base);
    set(&with, "views.main.render.method", method);
    if (vv_render(&image, NULL, with, "main", NULL, job) != VV_OK)
        fail_msg("%s", vv_error_last()->message);
    vv_object_release(&with->base);
    return image;
}

typedef struct difference {
    size_t n_both, n_one;    /* pixels that see the surface in both pictures; in one of them */
    size_t n_far;            /* of n_both: whose depths differ by more than half a voxel */
    double mean, depth_mean; /* of light, and of depth in voxels, where both see it */
} difference;

static difference compare(const vv_image *a, const vv_image *b)
{
    difference d = {0};
    for (size_t i = 0; i < (size_t)SIDE * SIDE; i++) {
        const bool in_a = isfinite((double)a->depth[i]), in_b = isfinite((double)b->depth[i]);
        d.n_one += in_a != in_b;
        if (!in_a || !in_b)
            continue;
        const double far = fabs((double)(a->depth[i] - b->depth[i])) / VOXEL;
        d.n_both++;
        d.n_far += far > 0.5;
        d.depth_mean += fmin(far, 1);
        for (size_t c = 0; c < 3; c++)
            d.mean += fabs((double)(a->rgba[4 * i + c] - b->rgba[4 * i + c])) / 3;
    }
    d.mean /= (double)d.n_both;
    d.depth_mean /= (double)d.n_both;
    return d;
}

static void expect_same(vv_world *world, const char *what)
{
    vv_image *rays = picture_of(world, "raycast", NULL), *triangles = picture_of(world, "surface", NULL);
    const difference d = compare(rays, triangles);
    if (!(d.n_both > 1000 && d.n_one < d.n_both / 100 && d.n_far < d.n_both / 100 && d.mean < 0.004 &&
          d.depth_mean < 0.05))
        fail_msg("%s: %zu pixels, %zu in one alone, %zu at other depths, light differs by %g, depth by %g voxels", what,
                 d.n_both, d.n_one, d.n_far, d.mean, d.depth_mean);
    vv_image_release(rays);
    vv_image_release(triangles);
}

static const char *const ball = "{\"lo\": -100, \"hi\": 0}", *const shell = "{\"lo\": -1.5, \"hi\": 0}";

static void triangles_and_rays_see_the_same(void **state)
{
    (void)state;
    vv_world *world = world_of(&test_form_sphere, ball);
    expect_same(world, "a ball");
    set(&world, "views.main.camera.projection", "parallel");
    expect_same(world, "parallel");
    set(&world, "volumes.ball.shading.model", "phong");
    expect_same(world, "phong");
    set(&world, "volumes.ball.shading.model", "none");
    expect_same(world, "without light");
    vv_object_release(&world->base);
}

static void placed_volumes_are_where_they_are(void **state)
{
    (void)state;
    vv_world *world = world_of(&test_form_sphere, ball);
    set(&world, "volumes.ball.place",
        "{\"position\": [3, -2, 1], \"rotation\": [20, 30, 40], \"scale\": [1, 0.7, 1.3]}");
    expect_same(world, "placed");
    set(&world, "lights.key", "{\"kind\": \"point\", \"position\": [20, -10, 20], \"intensity\": 1}");
    expect_same(world, "a point light");
    vv_object_release(&world->base);
}

static void cuts_are_closed(void **state)
{
    (void)state;
    vv_world *world = world_of(&test_form_sphere, ball);
    set(&world, "cut_planes", "[{\"normal\": [0.3, 1, 0.2], \"offset\": 10}]");
    expect_same(world, "cut");
    set(&world, "volumes.ball.segmentation.threshold", shell);
    expect_same(world, "a shell cut open"); /* both sides of the solid are seen, and the cut between them */
    set(&world, "volumes.ball.cut_planes", "[{\"normal\": [1, 0, 0], \"offset\": 8}]");
    expect_same(world, "cut twice");
    vv_object_release(&world->base);
}

static void solids_that_reach_the_border_show_it(void **state)
{
    (void)state;
    vv_world *world = world_of(&test_form_ramp, "{\"lo\": 20}");
    expect_same(world, "a ramp");
    set(&world, "volumes.ball.segmentation.threshold", "{\"lo\": -1000}");
    expect_same(world, "a box");
    vv_object_release(&world->base);
}

static double mask(vv_vec3 p)
{
    return hypot(hypot(p.x - 8, p.y - 8), p.z - 8) < 7;
}

static double saturated(vv_vec3 p)
{
    return fmin(test_form_ramp.value(p), 12.3);
}

/* Faces have no holes where their samples equal the value of the surface: a little lower it is the same picture. */
static void cut_masks_have_whole_faces(void **state)
{
    (void)state;
    const test_form forms[] = {{.name = "mask", .value = mask}, {.name = "saturated", .value = saturated}};
    static const char *const methods[] = {"surface", "reduced"};
    static const char *const values[][2] = {{"{\"lo\": 1}", "{\"lo\": 0.9999}"},
                                            {"{\"lo\": 12.3}", "{\"lo\": 12.2999}"}};
    for (int i = 0; i < 4; i++) {
        vv_image *images[2];
        for (int k = 0; k < 2; k++) {
            vv_world *world = world_of(&forms[i & 1], values[i & 1][k]);
            if (!(i & 1))
                set(&world, "cut_planes", "[{\"normal\": [0.3, 1, 0.2], \"offset\": 9}]");
            images[k] = picture_of(world, methods[i >> 1], NULL);
            vv_object_release(&world->base);
        }
        const difference d = compare(images[0], images[1]);
        if (!(d.n_both > 1000 && d.n_one < d.n_both / 100 && d.n_far < d.n_both / 100))
            fail_msg("%d: %zu pixels, %zu in one alone, %zu at other depths", i, d.n_both, d.n_one, d.n_far);
        vv_image_release(images[0]);
        vv_image_release(images[1]);
    }
}

static double logarithm(vv_vec3 p)
{
    return mask(p) > 0 ? 2 : -INFINITY;
}

static void infinite_samples_hide_no_surface(void **state)
{
    (void)state;
    static const char *const methods[] = {"surface", "reduced", "boxes"};
    const test_form form = {.name = "logarithm", .value = logarithm};
    vv_world *world = world_of(&form, "{\"lo\": 1}");
    for (int i = 0; i < 3; i++) {
        vv_image *image = picture_of(world, methods[i], NULL);
        size_t n = 0;
        for (size_t p = 0; p < (size_t)SIDE * SIDE; p++)
            n += isfinite((double)image->depth[p]) && isfinite((double)image->rgba[4 * p]);
        assert_true(n > 2000);
        vv_image_release(image);
    }
    vv_object_release(&world->base);
}

static void several_volumes_hide_each_other(void **state)
{
    (void)state;
    vv_world *world = world_of(&test_form_sphere, shell);
    set(&world, "volumes.other",
        "{\"data\": \"ball\", \"color\": \"#4080ff\", \"place\": {\"position\": [5, 3, 2]}, "
        "\"segmentation\": {\"kind\": \"threshold\", \"threshold\": {\"lo\": -100, \"hi\": 0}}}");
    set(&world, "cut_planes", "[{\"normal\": [0, 1, 0], \"offset\": 8}]");
    expect_same(world, "two");
    vv_object_release(&world->base);
}

static void isosurfaces_need_no_threshold(void **state)
{
    (void)state;
    vv_world *world = world_of(&test_form_ramp, ball);
    set(&world, "volumes.ball.segmentation.kind", "transfer");
    set(&world, "views.main.render.raycast", "{\"mode\": \"isosurface\", \"iso\": 15}");
    set(&world, "views.main.render.surface.iso", "15");
    expect_same(world, "isosurface");
    vv_object_release(&world->base);
}

/* More samples at the silhouette, where it is neither there nor not. */
static void samples_make_edges_smooth(void **state)
{
    (void)state;
    vv_world *world = world_of(&test_form_sphere, ball);
    set(&world, "background", "\"#00000000\"");
    size_t partly[2] = {0};
    double area[2] = {0};
    for (int i = 0; i < 2; i++) {
        set(&world, "views.main.render.samples", i ? "8" : "1");
        vv_image *image = picture_of(world, "surface", NULL);
        for (size_t p = 0; p < (size_t)SIDE * SIDE; p++) {
            const float a = image->rgba[4 * p + 3];
            partly[i] += a > 0 && a < 1;
            area[i] += (double)a;
        }
        vv_image_release(image);
    }
    assert_int_equal(partly[0], 0);
    assert_true(partly[1] > 100);
    assert_true(fabs(area[0] - area[1]) < 0.01 * area[0]);
    vv_object_release(&world->base);
}

/* Vertices at four places lie within an eighth of a cell's edge; boxes hold the surface. */
static void coarse_methods_are_near(void **state)
{
    (void)state;
    vv_world *world = world_of(&test_form_sphere, ball);
    vv_image *rays = picture_of(world, "raycast", NULL), *reduced = picture_of(world, "reduced", NULL),
             *boxes = picture_of(world, "boxes", NULL);
    const difference d = compare(rays, reduced);
    assert_true(d.n_one < d.n_both / 30 && d.depth_mean < 0.2);
    size_t before = 0, n = 0;
    for (size_t i = 0; i < (size_t)SIDE * SIDE; i++)
        if (isfinite((double)rays->depth[i])) {
            n++;
            before += boxes->depth[i] < rays->depth[i] + 0.01F;
        }
    assert_true(before > n - n / 100);
    vv_image_release(rays);
    vv_image_release(reduced);
    vv_image_release(boxes);
    vv_object_release(&world->base);
}

/* Where they are cut they show faces, as the solid itself does: not their inside, which lies deeper. */
static void coarse_methods_are_closed_where_they_are_cut(void **state)
{
    static const char *const cuts[] = {"[{\"normal\": [0.3, 1, 0.2], \"offset\": 10}]",
                                       "[{\"normal\": [0, 1, 0], \"offset\": 8.1}]"};
    (void)state;
    for (int thick = 0; thick < 2; thick++)
        for (int cut = 0; cut < 2; cut++) {
            vv_world *world = world_of(&test_form_sphere, thick ? ball : "{\"lo\": -2.5, \"hi\": 0}");
            set(&world, "cut_planes", cuts[cut]);
            set(&world, "views.main.render.reduced.triangles", "2500");
            vv_image *rays = picture_of(world, "raycast", NULL), *reduced = picture_of(world, "reduced", NULL),
                     *boxes = picture_of(world, "boxes", NULL);
            const difference d = compare(rays, reduced);
            if (!(d.n_one < d.n_both / 20 && d.n_far < d.n_both / 10 && d.depth_mean < 0.25))
                fail_msg("%d, cut %d: %zu pixels, %zu in one alone, %zu at other depths, by %g voxels", thick, cut,
                         d.n_both, d.n_one, d.n_far, d.depth_mean);
            size_t before = 0, n = 0;
            for (size_t i = 0; i < (size_t)SIDE * SIDE; i++)
                if (isfinite((double)rays->depth[i])) {
                    n++;
                    before += boxes->depth[i] < rays->depth[i] + 0.01F;
                }
            assert_true(before > n - n / 100);
            vv_image_release(rays);
            vv_image_release(reduced);
            vv_image_release(boxes);
            vv_object_release(&world->base);
        }
}

/* Also at the border of the data, which coarser samples end at, too. */
static void coarse_methods_show_the_border_of_the_data(void **state)
{
    static const char *const methods[] = {"reduced", "boxes"};
    (void)state;
    vv_world *world = world_of(&test_form_ramp, "{\"lo\": -1000}");
    vv_image *rays = picture_of(world, "raycast", NULL);
    for (int i = 0; i < 2; i++) {
        vv_image *image = picture_of(world, methods[i], NULL);
        const difference d = compare(rays, image);
        assert_true(d.n_both > 1000 && d.n_one == 0 && d.n_far == 0);
        vv_image_release(image);
    }
    vv_image_release(rays);
    vv_object_release(&world->base);
}

static void picking_tells_what_the_picture_shows(void **state)
{
    (void)state;
    vv_world *world = world_of(&test_form_sphere, ball);
    set(&world, "views.main.render.method", "surface");
    vv_image *image = picture_of(world, "surface", NULL);
    const vv_pixel pixels[2] = {{80, 80}, {2, 3}};
    vv_picked picked[2];
    assert_int_equal(vv_pick(picked, pixels, 2, world, NULL, NULL), VV_OK);
    assert_true(picked[0].hit && !picked[1].hit);
    assert_true(picked[0].depth == (double)image->depth[80 * SIDE + 80]);
    assert_true(fabs(picked[0].value) < 0.02);
    assert_true(fabs(vvi_length(vvi_sub(picked[0].world, vvi_vec(7, 8, 9))) - 5) < 0.02);
    assert_string_equal(picked[0].volume, "ball");
    vv_image_release(image);
    vv_object_release(&world->base);
}

/* Also where the values do not change: the inside of a box is all of one value. */
static void picked_boxes_have_the_normals_of_their_faces(void **state)
{
    (void)state;
    vv_world *world = world_of(&test_form_sphere, ball);
    set(&world, "views.main.render.method", "boxes");
    set(&world, "views.main.render.layers", "{\"depth\": true, \"normal\": true}");
    vv_image *image = picture_of(world, "boxes", NULL);
    size_t n = 0;
    for (int32_t y = 0; y < SIDE; y += 7)
        for (int32_t x = 0; x < SIDE; x += 7) {
            const vv_pixel pixel = {x, y};
            vv_picked picked;
            assert_int_equal(vv_pick(&picked, &pixel, 1, world, NULL, NULL), VV_OK);
            if (!picked.hit)
                continue;
            const vv_vec3 axis = {fabs(picked.normal.x), fabs(picked.normal.y), fabs(picked.normal.z)};
            const float *drawn = image->normal + 3 * (y * SIDE + x);
            assert_float_equal(axis.x + axis.y + axis.z, 1, 1e-5);
            assert_float_equal(fmax(axis.x, fmax(axis.y, axis.z)), 1, 1e-5);
            assert_float_equal(
                vvi_length(vvi_sub(picked.normal, vvi_vec((double)drawn[0], (double)drawn[1], (double)drawn[2]))), 0,
                1e-6);
            n++;
        }
    assert_true(n > 20);
    vv_image_release(image);
    vv_object_release(&world->base);
}

static void the_bytes_are_the_same_for_any_number_of_threads(void **state)
{
    (void)state;
    vv_world *world = world_of(&test_form_sphere, shell);
    set(&world, "cut_planes", "[{\"normal\": [0, 1, 0], \"offset\": 8}]");
    set(&world, "views.main.render.samples", "4");
    vv_image *image[2];
    for (int i = 0; i < 2; i++) {
        vv_job *job = test_job(i ? 3 : 1, 0);
        image[i] = picture_of(world, "surface", job);
        vv_job_release(job);
    }
    assert_memory_equal(image[0]->rgba, image[1]->rgba, (size_t)SIDE * SIDE * 4 * sizeof(float));
    assert_memory_equal(image[0]->depth, image[1]->depth, (size_t)SIDE * SIDE * sizeof(float));
    vv_image_release(image[0]);
    vv_image_release(image[1]);
    vv_object_release(&world->base);
}

/* The mesh depends on the data and the value: not on where one looks from. */
static void a_second_view_makes_no_second_mesh(void **state)
{
    (void)state;
    vv_world *world = world_of(&test_form_sphere, ball);
    vv_job *job = test_job(1, 0);
    vvi_cache_counts before, after;
    set(&world, "views.main.camera.fit", "data");
    vv_image_release(picture_of(world, "surface", job));
    vvi_cache_get_counts(&before, vv_job_runtime(job));
    set(&world, "views.main.camera.azimuth", "77");
    vv_image_release(picture_of(world, "surface", job));
    vvi_cache_get_counts(&after, vv_job_runtime(job));
    assert_true(after.misses == before.misses && after.hits > before.hits);
    set(&world, "volumes.ball.segmentation.threshold.hi", "0.5");
    vv_image_release(picture_of(world, "surface", job));
    vvi_cache_get_counts(&before, vv_job_runtime(job));
    assert_true(before.misses == after.misses + 1);
    vv_job_release(job);
    vv_object_release(&world->base);
}

/* A ball of label 3 in its colour, and one of label 5 that is clear. */
static void labels_are_surfaces_in_their_colours(void **state)
{
    (void)state;
    vv_field_info info = vv_field_info_default();
    vv_field *field;
    void *data;
    vv_world *world;
    vv_image *image;
    size_t n = 0;
    for (int a = 0; a < 3; a++)
        info.grid.dims[a] = 24;
    info.meaning = VV_MEANING_LABEL;
    assert_int_equal(vv_field_new_empty(&field, &data, &info, NULL), VV_OK);
    for (int i = 0; i < 24 * 24 * 24; i++) {
        const double x = i % 24 - 9, y = i / 24 % 24 - 11.5, z = i / 576 - 11.5;
        ((uint8_t *)data)[i] = sqrt(x * x + y * y + z * z) < 6 ? 3 : x > 9 ? 5 : 0;
    }
    assert_int_equal(vv_world_for_field(&world, "ball", field, NULL), VV_OK);
    vv_field_release(field);
    set(&world, "views.main.render.samples", "1");
    set(&world, "volumes.ball.segmentation.labels.table", "[[3, 0, 0.5, 0.1, 1], [5, 1, 1, 1, 0]]");
    set(&world, "shading.model", "none");
    set(&world, "views.main.width", "160");
    set(&world, "views.main.height", "160");
    image = picture_of(world, "surface", NULL);
    for (size_t p = 0; p < (size_t)SIDE * SIDE; p++)
        if (isfinite((double)image->depth[p])) {
            assert_true(image->rgba[4 * p] == 0 && fabsf(image->rgba[4 * p + 1] - 0.5F) < 1e-5F);
            n++;
        }
    assert_true(n > 1000);
    vv_image_release(image);
    set(&world, "views.main.render.method", "reduced");
    assert_int_equal(vv_render(&image, NULL, world, "main", NULL, NULL), VV_E_UNSUPPORTED);
    vv_object_release(&world->base);
}

static void a_surface_of_no_value_is_no_error(void **state)
{
    (void)state;
    static const char *const methods[] = {"surface", "reduced", "boxes"};
    vv_world *world = world_of(&test_form_sphere, "{\"lo\": 100, \"hi\": 200}");
    for (int i = 0; i < 3; i++) {
        vv_image *image = picture_of(world, methods[i], NULL);
        for (size_t p = 0; p < (size_t)SIDE * SIDE; p++)
            assert_true(isinf((double)image->depth[p]));
        vv_image_release(image);
    }
    vv_object_release(&world->base);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(triangles_and_rays_see_the_same),
        cmocka_unit_test(placed_volumes_are_where_they_are),
        cmocka_unit_test(cuts_are_closed),
        cmocka_unit_test(solids_that_reach_the_border_show_it),
        cmocka_unit_test(cut_masks_have_whole_faces),
        cmocka_unit_test(infinite_samples_hide_no_surface),
        cmocka_unit_test(several_volumes_hide_each_other),
        cmocka_unit_test(isosurfaces_need_no_threshold),
        cmocka_unit_test(samples_make_edges_smooth),
        cmocka_unit_test(coarse_methods_are_near),
        cmocka_unit_test(coarse_methods_are_closed_where_they_are_cut),
        cmocka_unit_test(coarse_methods_show_the_border_of_the_data),
        cmocka_unit_test(picking_tells_what_the_picture_shows),
        cmocka_unit_test(picked_boxes_have_the_normals_of_their_faces),
        cmocka_unit_test(the_bytes_are_the_same_for_any_number_of_threads),
        cmocka_unit_test(a_second_view_makes_no_second_mesh),
        cmocka_unit_test(labels_are_surfaces_in_their_colours),
        cmocka_unit_test(a_surface_of_no_value_is_no_error),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
