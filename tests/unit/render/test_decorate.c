/* Decorations: their numbers and outlines by themselves, and what they leave of a picture. */
#include "core/memory.h"
#include "core/vec.h"
#include "fields.h"
#include "jobs.h"
#include "model/context.h"
#include "render/decorate/decorate.h"
#include "render/decorate/round_numbers.h"
#include "render/decorate/sheet.h"
#include "scene/lens.h"
#include "scene/resolve.h"
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <volvis/render.h>

#include <cmocka.h>

/* Numbers --------------------------------------------------------------------------------------------------------- */

static void round_numbers_are_one_two_five(void **state)
{
    (void)state;
    const double of[][2] = {{1, 1},    {1.99, 1}, {2, 2},     {4.99, 2},   {5, 5},
                            {9.99, 5}, {10, 10},  {0.3, 0.2}, {1e-7, 1e-7}};
    for (size_t i = 0; i < sizeof of / sizeof *of; i++)
        assert_true(fabs(vvi_nice_below(of[i][0]) - of[i][1]) <= 1e-12 * of[i][1]);
    const double none[] = {0, -1, INFINITY, NAN};
    for (size_t i = 0; i < sizeof none / sizeof *none; i++)
        assert_true(vvi_nice_below(none[i]) == 0);
    for (uint64_t i = 0; i < 1000; i++) { /* the largest that is not above */
        const double x = pow(10, 40 * test_random_unit(5, i) - 20), n = vvi_nice_below(x);
        assert_true(n <= x * (1 + 1e-8) && 2.5 * n > x * (1 - 1e-8));
    }
}

static void ticks_lie_within_and_are_as_many_as_fit(void **state)
{
    (void)state;
    for (uint64_t i = 0; i < 2000; i++) {
        const double size = pow(10, 12 * test_random_unit(7, 3 * i) - 6);
        const double lo = (test_random_unit(7, 3 * i + 1) - 0.5) * 10 * size, hi = lo + size;
        const int most = 1 + (int)(test_random(7, 3 * i + 2) % 12);
        const vvi_ticks t = vvi_nice_ticks(lo, hi, most);
        assert_true(t.n >= 0 && t.n <= most + 1);
        assert_true(size / t.step <= most * (1 + 1e-6) && 2.5 * most * (1 + 1e-6) >= size / t.step);
        assert_true(fabs(vvi_nice_below(t.step) - t.step) < 1e-6 * t.step);
        for (int k = 0; k < t.n; k++) {
            const double at = vvi_tick_at(&t, k);
            assert_true(at >= lo - 1e-6 * t.step && at <= hi + 1e-6 * t.step);
        }
    }
    assert_int_equal(vvi_nice_ticks(1, 1, 5).n, 0);
    assert_int_equal(vvi_nice_ticks(2, 1, 5).n, 0);
    assert_int_equal(vvi_nice_ticks(0, 1, 0).n, 0);
    assert_int_equal(vvi_nice_ticks(0, INFINITY, 5).n, 0);
    assert_int_equal(vvi_nice_ticks(1e20, 1e20 + 65536, 5).n, 0);
    assert_int_equal(vvi_nice_ticks(0, 100, 5).n, 6);
}

static void numbers_are_written_as_people_do(void **state)
{
    (void)state;
    const struct {
        double value, step;
        const char *text;
    } of[] = {{0, 50, "0"},
              {-50, 50,
               "\xe2\x88\x92"
               "50"},
              {0.5, 0.5, "0.5"},
              {1, 0.5, "1.0"},
              {0.1 + 0.2, 0.1, "0.3"},
              {-0.04, 0.02,
               "\xe2\x88\x92"
               "0.04"},
              {1200000, 200000, "1200000"},
              {3e-7, 1e-7,
               "3e\xe2\x88\x92"
               "7"},
              {-1e-17, 0.1, "0.0"},
              {2e9, 1e9, "2000000000"},
              {6 * 1e37, 1e37, "6e37"},
              {1e15 + 1, 1, "1000000000000001"}};
    for (size_t i = 0; i < sizeof of / sizeof *of; i++) {
        char text[40];
        vvi_print_tick(text, of[i].value, of[i].step);
        assert_string_equal(text, of[i].text);
    }
}

static void lengths_take_the_unit_with_fewest_digits(void **state)
{
    (void)state;
    const struct {
        double length;
        const char *unit, *text;
    } of[] = {{50, "mm", "50 mm"},
              {0.05, "mm", "50 \xc2\xb5m"},
              {2000, "um", "2 mm"},
              {0.2, "nm", "0.2 nm"},
              {5, "voxels", "5 voxels"},
              {1, "voxels", "1 voxel"},
              {1.40625, "units", "1.41 units"},
              {0.7199, "mm", "720 \xc2\xb5m"},
              {20, "um", "20 \xc2\xb5m"},
              {1000, "m", "1 km"},
              {0.5, "m", "500 mm"}};
    for (size_t i = 0; i < sizeof of / sizeof *of; i++) {
        char text[64];
        vvi_print_length(text, of[i].length, of[i].unit);
        assert_string_equal(text, of[i].text);
    }
}

/* Outlines -------------------------------------------------------------------------------------------------------- */

static void a_plane_through_a_cube_is_the_polygon_that_it_is(void **state)
{
    (void)state;
    vv_vec3 c[8], out[VVI_CUT_CORNERS];
    for (int i = 0; i < 8; i++)
        c[i] = vvi_vec(i & 1, i >> 1 & 1, i >> 2);
    const double third = 1 / sqrt(3);
    const vv_plane diagonal = {{third, third, third}, 1.5 * third}, side = {{1, 0, 0}, 0.25}, past = {{1, 0, 0}, 2};
    assert_int_equal(vvi_cut_outline(out, c, &diagonal, NULL, 0), 6);
    for (int i = 0; i < 6; i++) { /* a regular hexagon */
        assert_true(fabs(vvi_length(vvi_sub(out[i], vvi_vec(0.5, 0.5, 0.5))) - sqrt(0.5)) < 1e-9);
        assert_true(fabs(vvi_length(vvi_sub(out[i], out[(i + 1) % 6])) - sqrt(0.5)) < 1e-9);
    }
    assert_int_equal(vvi_cut_outline(out, c, &side, NULL, 0), 4);
    for (int i = 0; i < 4; i++)
        assert_true(fabs(out[i].x - 0.25) < 1e-12);
    assert_int_equal(vvi_cut_outline(out, c, &past, NULL, 0), 0);
    const vv_plane both[2] = {side, {{0, 1, 0}, 0.5}}; /* half of the first is cut off by the second */
    assert_int_equal(vvi_cut_outline(out, c, &both[0], both, 2), 4);
    for (int i = 0; i < 4; i++)
        assert_true(out[i].y > 0.5 - 1e-9);
}

/* Pictures -------------------------------------------------------------------------------------------------------- */

static void set(vv_world **world, const char *path, const char *json)
{
    const vv_property_context context = vvi_registry_context(NULL);
    vv_object *root = &(*world)->base;
    if (vv_path_set(&root, path, json, &context) != VV_OK)
        fail_msg("%s", vv_error_last()->message);
    *world = (vv_world *)(void *)root;
}

/* A ball of radius 5 in a box of 16, seen from the front, parallel: a pixel is 0.2. */
static vv_world *ball(void)
{
    vv_world *world;
    vv_field *field = test_field_cube(&test_form_sphere, 33, 0, 16, NULL);
    assert_non_null(field);
    assert_int_equal(vv_world_for_field(&world, "ball", field, NULL), VV_OK);
    vv_field_release(field);
    set(&world, "views.main.width", "120");
    set(&world, "views.main.height", "100");
    set(&world, "views.main.camera", "{\"projection\": \"parallel\", \"height\": 20, \"at\": [8, 8, 8]}");
    set(&world, "volumes.ball.segmentation", "{\"kind\": \"threshold\", \"threshold\": {\"lo\": -100, \"hi\": 0}}");
    return world;
}

static vv_image *picture_of(vv_world *world)
{
    vv_image *image;
    if (vv_render(&image, NULL, world, "main", NULL, NULL) != VV_OK)
        fail_msg("%s", vv_error_last()->message);
    return image;
}

static size_t n_different(const vv_image *a, const vv_image *b, int32_t x0, int32_t y0, int32_t x1, int32_t y1)
{
    size_t n = 0;
    for (int32_t y = y0; y < y1; y++)
        for (int32_t x = x0; x < x1; x++) {
            const size_t at = 4 * ((size_t)y * (size_t)a->width + (size_t)x);
            n += memcmp(a->rgba + at, b->rgba + at, 4 * sizeof(float)) != 0;
        }
    return n;
}

static void nothing_wanted_changes_nothing(void **state)
{
    (void)state;
    vv_world *world = ball();
    vv_image *plain = picture_of(world);
    set(&world, "views.main.decorations", "{\"cube\": false, \"caption\": \"\"}");
    vv_image *same = picture_of(world);
    assert_int_equal(n_different(plain, same, 0, 0, 120, 100), 0);
    vv_image_release(plain);
    vv_image_release(same);
    vv_object_release(&world->base);
}

/* The camera frames the data alone: under the decorations is the picture that there is without them. */
/* But for boxes and axes where it is left open, which are to be seen whole. */
static void the_camera_stays(void **state)
{
    (void)state;
    vv_world *world = ball();
    vv_scene *plain, *decorated;
    set(&world, "views.main.camera", "{\"projection\": \"perspective\", \"eye\": [60, -40, 30], \"at\": [8, 8, 8]}");
    vv_image *before = picture_of(world);
    assert_int_equal(vv_scene_resolve(&plain, world, "main", NULL), VV_OK);
    set(&world, "views.main.decorations",
        "{\"cube\": true, \"scale_bar\": true, \"legend\": true, \"axes\": true, "
        "\"box\": true, \"title\": \"A ball\"}");
    assert_int_equal(vv_scene_resolve(&decorated, world, "main", NULL), VV_OK);
    assert_memory_equal(&plain->lens, &decorated->lens, sizeof plain->lens);
    vv_image *after = picture_of(world);
    assert_memory_equal(before->depth, after->depth, 120 * 100 * sizeof(float));
    assert_true(n_different(before, after, 0, 0, 120, 100) < 120 * 100 / 2);
    vv_scene_release(plain);
    vv_scene_release(decorated);
    vv_image_release(before);
    vv_image_release(after);
    vv_object_release(&world->base);
}

/* How far outside the picture the farthest corner of the box of all data is, in halves of it: 1 is its border. */
static double farthest_corner(vv_world *world)
{
    vv_scene *scene;
    double far = 0;
    assert_int_equal(vv_scene_resolve(&scene, world, "main", NULL), VV_OK);
    for (int k = 0; k < 8; k++) {
        vv_vec3 c[8];
        vvi_actor_corners(c, &scene->actors[0]);
        const vv_vec3 p = vvi_sub(c[k], scene->lens.eye);
        const double z = scene->lens.parallel ? 1 : vvi_dot(p, scene->lens.forward);
        far = fmax(far, fabs(vvi_dot(p, scene->lens.right)) / z / scene->lens.half_width);
        far = fmax(far, fabs(vvi_dot(p, scene->lens.up)) / z / scene->lens.half_height);
    }
    vv_scene_release(scene);
    return far;
}

static void boxes_and_axes_are_seen_whole_where_the_camera_is_open(void **state)
{
    (void)state;
    static const char *const cameras[] = {"{\"azimuth\": 30, \"elevation\": 20}", "{\"projection\": \"parallel\"}",
                                          "{\"azimuth\": 200, \"elevation\": -70, \"roll\": 30}"};
    vv_world *world = ball();
    for (size_t i = 0; i < sizeof cameras / sizeof *cameras; i++) {
        vv_world *with = (vv_world *)(void *)vv_object_retain(&world->base);
        set(&with, "views.main.camera", cameras[i]);
        assert_true(farthest_corner(with) > 1);
        set(&with, "views.main.decorations", "{\"box\": true}");
        assert_true(fabs(farthest_corner(with) - 0.95) < 0.01);
        set(&with, "views.main.decorations", "{\"axes\": true}");
        assert_true(farthest_corner(with) < 0.9);
        set(&with, "views.main.decorations", "{\"legend\": true, \"cube\": true}");
        assert_true(farthest_corner(with) > 1);
        vv_object_release(&with->base);
    }
    vv_object_release(&world->base);
}

static void each_stands_where_it_belongs_and_layers_stay(void **state)
{
    static const struct {
        const char *name;
        int32_t x0, y0, x1, y1; /* where it is */
    } of[] = {{"cube", 0, 30, 70, 100},
              {"scale_bar", 50, 60, 120, 100},
              {"legend", 20, 0, 120, 80},
              {"axes", 0, 0, 120, 100},
              {"box", 0, 0, 120, 100}};
    (void)state;
    vv_world *world = ball();
    set(&world, "views.main.camera.eye", "[8, -30, 8]"); /* depth is told from there */
    vv_image *plain = picture_of(world);
    for (size_t i = 0; i < sizeof of / sizeof *of; i++) {
        char path[64];
        vv_world *with = (vv_world *)(void *)vv_object_retain(&world->base);
        snprintf(path, sizeof path, "views.main.decorations.%s", of[i].name);
        set(&with, path, "true");
        vv_image *image = picture_of(with);
        const size_t all = n_different(plain, image, 0, 0, 120, 100);
        assert_true(all > 20);
        assert_int_equal(n_different(plain, image, of[i].x0, of[i].y0, of[i].x1, of[i].y1), all);
        assert_memory_equal(plain->depth, image->depth, 120 * 100 * sizeof(float));
        vv_image_release(image);
        vv_object_release(&with->base);
    }
    vv_image_release(plain);
    vv_object_release(&world->base);
}

/* Ink at a place of a picture that a plain one of the same World has not. */
static bool is_drawn(vv_world *world, vv_vec3 at)
{
    vv_world *without = (vv_world *)(void *)vv_object_retain(&world->base);
    set(&without, "views.main.decorations.measurements", "false");
    vv_image *plain = picture_of(without), *image = picture_of(world);
    vv_scene *scene;
    double x = 0, y = 0, depth;
    assert_int_equal(vv_scene_resolve(&scene, world, "main", NULL), VV_OK);
    const vvi_sheet sheet = vvi_sheet_new(scene, NULL);
    assert_true(vvi_sheet_project(&x, &y, &depth, &sheet, at));
    const int32_t px = (int32_t)x, py = (int32_t)y;
    const bool drawn = n_different(plain, image, px - 1, py - 1, px + 2, py + 2) > 2;
    assert_memory_equal(plain->depth, image->depth, 120 * 100 * sizeof(float));
    vv_scene_release(scene);
    vv_image_release(plain);
    vv_image_release(image);
    vv_object_release(&without->base);
    return drawn;
}

static void measurements_are_drawn_by_themselves_where_they_are(void **state)
{
    (void)state;
    const vv_vec3 end = {4, 8, 8}, on_line = {9, 8, 8}, beside = {8, 8, 13};
    vv_world *world = ball();
    assert_false(is_drawn(world, end));
    set(&world, "measurements.far",
        "{\"what\": \"distance\", \"points\": [[4, 8, 8], [12, 8, 8]], \"space\": \"world\"}");
    assert_true(is_drawn(world, end) && is_drawn(world, on_line)); /* also inside the ball */
    assert_false(is_drawn(world, beside));
    set(&world, "measurements.far.visible", "false");
    assert_false(is_drawn(world, end));
    set(&world, "measurements.part", "{\"what\": \"statistics\", \"box\": \"2..14,..,3..13\"}");
    vv_scene *scene;
    assert_int_equal(vv_scene_resolve(&scene, world, "main", NULL), VV_OK);
    const vv_affine place = scene->actors[0].index_to_world;
    vv_scene_release(scene);
    assert_true(is_drawn(world, vv_affine_point(place, vvi_vec(8, -0.5, 13.5))));
    assert_false(is_drawn(world, vv_affine_point(place, vvi_vec(8, -0.5, 8))));
    vv_object_release(&world->base);
}

static void a_slice_shows_what_is_measured_in_it(void **state)
{
    (void)state;
    vv_world *world = ball();
    set(&world, "views.main.render", "{\"method\": \"slice\", \"slice\": {\"orientation\": \"axial\"}}");
    set(&world, "cross_hair", "[8, 8, 8]");
    set(&world, "measurements.flat",
        "{\"what\": \"distance\", \"points\": [[4, 8, 8], [12, 8, 8]], \"space\": \"world\"}");
    set(&world, "measurements.through",
        "{\"what\": \"distance\", \"points\": [[8, 4, 2], [8, 12, 14]], \"space\": \"world\"}");
    assert_true(is_drawn(world, vvi_vec(5, 8, 8)));
    assert_false(is_drawn(world, vvi_vec(8, 5, 8))); /* it crosses the slice in the middle alone */
    set(&world, "cross_hair", "[8, 8, 12]");
    assert_false(is_drawn(world, vvi_vec(5, 8, 12)));
    vv_object_release(&world->base);
}

/* From the front the box is a square about the ball; from a corner its near edges cross the ball, its far ones are
 * behind it. */
static void the_box_is_hidden_by_what_is_before_it(void **state)
{
    (void)state;
    vv_world *world = ball();
    set(&world, "views.main.camera.azimuth", "45");
    set(&world, "views.main.camera.elevation", "35.264389682754654");
    vv_image *plain = picture_of(world);
    set(&world, "views.main.decorations.box", "true");
    vv_image *image = picture_of(world);
    vv_scene *scene;
    assert_int_equal(vv_scene_resolve(&scene, world, "main", NULL), VV_OK);
    const vvi_sheet sheet = vvi_sheet_new(scene, NULL);
    vv_vec3 c[8];
    size_t near = 0;
    double depth[8], x = 0, y = 0, nearest = INFINITY, farthest = -INFINITY;
    size_t far = 0;
    vvi_actor_corners(c, &scene->actors[0]);
    for (size_t i = 0; i < 8; i++) {
        assert_true(vvi_sheet_project(&x, &y, &depth[i], &sheet, c[i]));
        near = depth[i] < nearest ? i : near;
        far = depth[i] > farthest ? i : far;
        nearest = fmin(nearest, depth[i]);
        farthest = fmax(farthest, depth[i]);
    }
    assert_true(vvi_sheet_project(&x, &y, &depth[0], &sheet, c[near])); /* the middle of the picture, as the far one */
    const int32_t px = (int32_t)x, py = (int32_t)y;
    assert_true(isfinite((double)plain->depth[py * 120 + px]));
    assert_true(n_different(plain, image, px - 2, py - 2, px + 3, py + 3) > 4);
    /* along a far edge, a third on from the far corner: the ball is before it */
    const vv_vec3 along = vvi_add(vvi_scaled(c[far], 0.75), vvi_scaled(c[far ^ 4], 0.25));
    assert_true(vvi_sheet_project(&x, &y, &depth[0], &sheet, along));
    assert_true(isfinite((double)plain->depth[(int32_t)y * 120 + (int32_t)x]));
    assert_int_equal(n_different(plain, image, (int32_t)x - 1, (int32_t)y - 1, (int32_t)x + 2, (int32_t)y + 2), 0);
    vv_scene_release(scene);
    vv_image_release(plain);
    vv_image_release(image);
    vv_object_release(&world->base);
}

static vv_world *random_world(uint64_t seed);

static void scale_bars_are_as_long_as_they_say(void **state)
{
    (void)state;
    vv_world *world = ball();
    set(&world, "views.main.decorations.scale_bar", "true");
    vv_image *image = picture_of(world);
    /* 120 pixels of 0.2 are 24, a quarter is 6, so the bar is 5: 25 pixels of full ink */
    int32_t longest = 0;
    for (int32_t y = 70; y < 100; y++) {
        int32_t run = 0;
        for (int32_t x = 0; x < 120; x++) {
            run = image->rgba[4 * (y * 120 + x)] > 0.9F ? run + 1 : 0;
            longest = run > longest ? run : longest;
        }
    }
    assert_in_range(longest, 24, 25); /* it need not begin with a pixel */
    assert_true(vvi_scale_bar_length(0.2, 120, 0.25) == 5);
    assert_true(vvi_scale_bar_length(0, 120, 0.25) == 0);
    vv_image_release(image);
    vv_object_release(&world->base);
}

/* The rays through a bar's ends are as far apart as it says, at the depth of the middle of the data. */
static void scale_bars_are_right_for_every_camera(void **state)
{
    size_t n = 0;
    (void)state;
    for (uint64_t seed = 1; seed <= 120; seed++) {
        vv_world *world = random_world(seed);
        vv_scene *scene;
        vvi_sheet_scale_bar bar;
        char unit[16];
        double said, depth, x, y;
        set(&world, "volumes.ball.place.scale",
            seed % 3 ? "[1, 0.5, 3]" : "[0.001, 0.001, 0.002]"); /* voxels are no cubes */
        assert_int_equal(vv_scene_resolve(&scene, world, "main", NULL), VV_OK);
        vvi_sheet sheet = vvi_sheet_new(scene, NULL);
        vvi_sheet_scale_bar_place(&bar, &sheet);
        const vv_bounds b = vvi_sheet_bounds(&sheet);
        assert_true(vvi_sheet_project(&x, &y, &depth, &sheet, vvi_scaled(vvi_add(b.lo, b.hi), 0.5)));
        assert_int_equal(!*bar.note, scene->lens.parallel);
        if (bar.there) {
            vv_vec3 from[2], along[2];
            for (int i = 0; i < 2; i++) {
                vvi_lens_ray(&from[i], &along[i], &scene->lens, scene->width, scene->height, x + (i ? bar.pixels : 0),
                             y);
                const double t = (depth - vvi_dot(vvi_sub(from[i], scene->lens.eye), scene->lens.forward)) /
                                 vvi_dot(along[i], scene->lens.forward);
                from[i] = vvi_add(from[i], vvi_scaled(along[i], t));
            }
            assert_int_equal(sscanf(bar.text, "%lf %15s", &said, unit), 2);
            const double factor = strcmp(unit, "mm") == 0 ? 1 : strcmp(unit, "nm") == 0 ? 1e-6 : 1e-3;
            const double length = vvi_length(vvi_sub(from[1], from[0]));
            assert_true(fabs(said * factor - length) < 1e-6 * length);
            assert_true(fabs(vvi_nice_below(said) - said) < 1e-9 * said); /* 1, 2 or 5 */
            n++;
        }
        vv_scene_release(scene);
        vv_object_release(&world->base);
    }
    assert_true(n > 60);
}

static void expect_legend(vv_world *world, const char *const *lines)
{
    vv_scene *scene;
    vvi_sheet_legend legend;
    size_t n = 0;
    assert_int_equal(vv_scene_resolve(&scene, world, "main", NULL), VV_OK);
    vvi_sheet sheet = vvi_sheet_new(scene, NULL);
    assert_int_equal(vvi_sheet_legend_place(&legend, &sheet), VV_OK);
    for (; lines[n]; n++) {
        assert_non_null(vvi_sheet_legend_text(&legend, n));
        assert_string_equal(vvi_sheet_legend_text(&legend, n), lines[n]);
    }
    assert_null(vvi_sheet_legend_text(&legend, n));
    vvi_sheet_legend_finish(&legend);
    vv_scene_release(scene);
    vv_object_release(&world->base);
}

static vv_world *large_ball(void)
{
    vv_world *world = ball();
    set(&world, "views.main.width", "600");
    set(&world, "views.main.height", "600");
    return world;
}

static void legends_tell_labels_volumes_and_values(void **state)
{
    (void)state;
    vv_world *world = large_ball();
    expect_legend(world, (const char *const[]){"ball: \xe2\x88\x92"
                                               "100 to 0",
                                               NULL});
    world = large_ball();
    set(&world, "volumes.ball.segmentation",
        "{\"kind\": \"transfer\", \"transfer\": {\"opacity\": [[-5, 0], [5, 0.3]], "
        "\"opacity_length\": 1}}");
    set(&world, "volumes.second", "{\"data\": \"ball\", \"title\": \"another\"}");
    set(&world, "volumes.second.segmentation",
        "{\"kind\": \"transfer\", \"transfer\": {\"opacity\": [[-5, 0], [5, 0.1]]}}");
    expect_legend(world, (const char *const[]){"ball", "", "another", "", "opacity of 1 mm, 0 to 0.5", NULL});
}

static double three_labels(vv_vec3 p)
{
    return p.x < 3 ? 0 : p.x < 6 ? 3 : 7;
}

static void labels_without_names_have_their_numbers(void **state)
{
    static const test_form form = {"labels", three_labels, NULL};
    vv_field_info info = vv_field_info_default();
    vv_world *world;
    (void)state;
    info.grid = test_cube(10, 0, 9);
    info.type = VV_TYPE_U8;
    vv_field *field = test_field(&form, &info, NULL);
    assert_non_null(field);
    assert_int_equal(vv_world_for_field(&world, "ball", field, NULL), VV_OK);
    vv_field_release(field);
    set(&world, "volumes.ball.segmentation.kind", "\"labels\"");
    vv_world *named = (vv_world *)(void *)vv_object_retain(&world->base);
    expect_legend(world, (const char *const[]){"ball", "label 3", "label 7", NULL});
    set(&named, "volumes.ball.segmentation.labels.names",
        "[{\"label\": 7, \"name\": \"liver\"}, {\"label\": 5, \"name\": \"spleen\"}]");
    expect_legend(named, (const char *const[]){"ball", "liver", "spleen", "label 3", NULL});
}

static void ink_is_seen_on_dark_and_on_bright(void **state)
{
    static const char *const backgrounds[] = {"\"#000000\"", "\"#ffffff\"", "\"#ffffff00\"", "\"#1b1d21\""};
    (void)state;
    for (size_t i = 0; i < 4; i++) {
        vv_world *world = ball();
        vv_scene *scene;
        set(&world, "background", backgrounds[i]);
        assert_int_equal(vv_scene_resolve(&scene, world, "main", NULL), VV_OK);
        const vvi_sheet sheet = vvi_sheet_new(scene, NULL);
        assert_int_equal(sheet.ink.g > 0.5, i == 0 || i == 3);
        vv_scene_release(scene);
        vv_object_release(&world->base);
    }
}

static void letters_grow_with_the_picture(void **state)
{
    (void)state;
    double em[3];
    static const char *const sizes[] = {"64", "1000", "4000"};
    for (size_t i = 0; i < 3; i++) {
        vv_world *world = ball();
        vv_scene *scene;
        set(&world, "views.main.width", sizes[i]);
        set(&world, "views.main.height", sizes[i]);
        assert_int_equal(vv_scene_resolve(&scene, world, "main", NULL), VV_OK);
        em[i] = vvi_sheet_new(scene, NULL).em;
        vv_scene_release(scene);
        vv_object_release(&world->base);
    }
    assert_true(em[0] >= 9 && em[1] > 18 && fabs(em[2] - 4 * em[1]) < 1e-9);
}

/* Places ---------------------------------------------------------------------------------------------------------- */

static const char *const contents[] = {
    "{}", "{\"title\": \"A ball\"}",
    "{\"title\": \"A title of so many words that no picture of any usual size has a line for all of them and more\", "
    "\"caption\": \"AndALongWordWithoutAnyBlankThatMustBeBrokenSomewhereOrItWouldLeaveThePictureAtItsRightSide x\"}",
    "{\"caption\": "
    "\"one\\ntwo\\n\\nthree\\nfour\\nfive\\nsix\\nseven\\neight\\nnine\\nten\\neleven\\ntwelve\\nthirteen\"}"};
static const char *const kinds[] = {"{\"kind\": \"threshold\", \"threshold\": {\"lo\": -100, \"hi\": 0}}",
                                    "{\"kind\": \"transfer\"}",
                                    "{\"kind\": \"labels\", \"labels\": {\"names\": [{\"label\": 1, \"name\": "
                                    "\"a name of many words that is far "
                                    "too long to be written in a legend\"}, {\"label\": 2}]}}"};

static vv_world *random_world(uint64_t seed)
{
    char text[160];
    vv_world *world = ball();
    const bool tiny = test_random(seed, 0) % 4 == 0;
    snprintf(text, sizeof text, "%d", 1 + (int)(test_random(seed, 1) % (tiny ? 100 : 2000)));
    set(&world, "views.main.width", text);
    snprintf(text, sizeof text, "%d", 1 + (int)(test_random(seed, 2) % (tiny ? 100 : 1500)));
    set(&world, "views.main.height", text);
    snprintf(text, sizeof text, "{\"azimuth\": %d, \"elevation\": %d%s}", (int)(test_random(seed, 3) % 8) * 45,
             (int)(test_random(seed, 4) % 5) * 45 - 90,
             test_random(seed, 5) % 2 ? ", \"projection\": \"parallel\"" : "");
    set(&world, "views.main.camera", text);
    set(&world, "views.main.decorations", contents[test_random(seed, 6) % 4]);
    static const char *const names[] = {"cube", "axes", "scale_bar", "box", "cut_planes", "legend"};
    for (uint64_t i = 0; i < 6; i++) {
        snprintf(text, sizeof text, "views.main.decorations.%s", names[i]);
        set(&world, text, test_random(seed, 7 + i) % 4 ? "true" : "false");
    }
    snprintf(text, sizeof text, "%.2f", 0.1 + (test_random(seed, 13) % 3 ? 1 : 4) * test_random_unit(seed, 14));
    set(&world, "views.main.decorations.size", text);
    set(&world, "volumes.ball.segmentation", kinds[test_random(seed, 15) % 3]);
    return world;
}

/* Not of the layout's own making: the boxes that each item says it has. */
static size_t boxes_of(vvi_box *out, const vvi_sheet_plan *p, const vvi_sheet *s)
{
    size_t n = 0;
    if (p->captions.n)
        out[n++] = p->captions.box;
    if (p->bar.there)
        out[n++] = p->bar.box;
    if (p->legend.there)
        out[n++] = p->legend.box;
    if (p->cube.there)
        out[n++] = (vvi_box){p->cube.x - p->cube.half, p->cube.y - p->cube.half, p->cube.x + p->cube.half,
                             p->cube.y + p->cube.half};
    for (int a = 0; a < 3; a++)
        for (int i = -1; i < p->axes.axis[a].n; i++) {
            const vvi_sheet_axis_label *l = i < 0 ? &p->axes.axis[a].name : &p->axes.axis[a].tick[i].number;
            if (!l->there || !p->axes.axis[a].there)
                continue;
            const double size = i < 0 ? s->em : vvi_sheet_small(s), half = vvi_sheet_length(s, l->text, size) / 2;
            const bool turned = i < 0 && p->axes.axis[a].upright;
            const double x = turned ? 0.36 * size : half, y = turned ? half : 0.36 * size;
            out[n++] = (vvi_box){l->x - x, l->y - y, l->x + x, l->y + y};
        }
    return n;
}

static void no_two_meet_and_none_leaves_the_picture(void **state)
{
    vvi_font *font = NULL;
    size_t n_all = 0;
    (void)state;
    if (vvi_font_open(&font, NULL) != VV_OK)
        skip();
    for (uint64_t seed = 1; seed <= 400; seed++) {
        vv_world *world = random_world(seed);
        vv_scene *scene;
        vvi_sheet_plan plan = {0};
        vvi_box box[VVI_LAYOUT_MOST];
        assert_int_equal(vv_scene_resolve(&scene, world, "main", NULL), VV_OK);
        vvi_sheet sheet = vvi_sheet_new(scene, NULL);
        sheet.font = font;
        assert_int_equal(vvi_sheet_place(&plan, &sheet), VV_OK);
        const size_t n = boxes_of(box, &plan, &sheet);
        n_all += n;
        for (size_t i = 0; i < n; i++) {
            if (box[i].x0 < -1e-6 || box[i].y0 < -1e-6 || box[i].x1 > sheet.width + 1e-6 ||
                box[i].y1 > sheet.height + 1e-6)
                fail_msg("seed %d: item %zu of %zu leaves the picture", (int)seed, i, n);
            for (size_t k = 0; k < i; k++)
                if (box[i].x0 < box[k].x1 && box[k].x0 < box[i].x1 && box[i].y0 < box[k].y1 && box[k].y0 < box[i].y1)
                    fail_msg("seed %d: items %zu and %zu of %zu meet", (int)seed, k, i, n);
        }
        vvi_sheet_plan_finish(&plan);
        vv_scene_release(scene);
        vv_object_release(&world->base);
    }
    assert_true(n_all > 2000); /* they are not simply all left out */
    vvi_font_close(font);
}

/* What is drawn stays in the box that was kept free for it. */
static void items_stay_in_their_boxes(void **state)
{
    static const char *const wanted[] = {"{\"title\": \"A ball\", \"caption\": \"of many words gjpqy\"}",
                                         "{\"scale_bar\": true}", "{\"legend\": true}", "{\"cube\": true}"};
    (void)state;
    for (size_t i = 0; i < 24; i++) {
        vv_world *world = ball();
        char text[32];
        const int width = 150 + (int)(i / 4) * 90;
        snprintf(text, sizeof text, "%d", width);
        set(&world, "views.main.width", text);
        set(&world, "views.main.height", "200");
        set(&world, "volumes.ball.segmentation", kinds[i / 4 % 3]);
        set(&world, "background", i & 1 ? "\"#ffffff\"" : "\"#00000000\"");
        vv_image *plain = picture_of(world);
        set(&world, "views.main.decorations", wanted[i % 4]);
        vv_image *image = picture_of(world);
        vv_scene *scene;
        vvi_sheet_plan plan = {0};
        assert_int_equal(vv_scene_resolve(&scene, world, "main", NULL), VV_OK);
        vvi_sheet sheet = vvi_sheet_new(scene, NULL);
        sheet.image = plain;
        if (vvi_font_open(&sheet.font, NULL) != VV_OK)
            skip();
        assert_int_equal(vvi_sheet_place(&plan, &sheet), VV_OK);
        const vvi_box b = sheet.layout.box[0];
        const double pad = sheet.em * 0.45; /* halos and plates, and what hangs below the base line */
        assert_int_equal(sheet.layout.n, 1);
        const int32_t x0 = (int32_t)fmax(b.x0 - pad, 0), x1 = (int32_t)fmin(b.x1 + pad + 1, width);
        const int32_t y0 = (int32_t)fmax(b.y0 - pad, 0), y1 = (int32_t)fmin(b.y1 + pad + 1, 200);
        const size_t all = n_different(plain, image, 0, 0, width, 200);
        assert_true(all > 20);
        assert_int_equal(n_different(plain, image, x0, y0, x1, y1), all);
        vvi_sheet_plan_finish(&plan);
        vvi_font_close(sheet.font);
        vv_scene_release(scene);
        vv_image_release(plain);
        vv_image_release(image);
        vv_object_release(&world->base);
    }
}

static size_t n_different_in(const vv_image *a, const vv_image *b, vvi_box box)
{
    return n_different(a, b, (int32_t)ceil(box.x0), (int32_t)ceil(box.y0), (int32_t)box.x1, (int32_t)box.y1);
}

/* Without a font letters keep their places and are not drawn: what is seen there would be a line. */
static void lines_are_broken_where_something_stands(void **state)
{
    static const char *const cameras[] = {
        "{\"projection\": \"parallel\", \"height\": 18, \"eye\": [8, -40, 8], \"at\": [8, 8, 8]}",
        "{\"projection\": \"parallel\", \"height\": 19, \"eye\": [60, -40, 30], \"at\": [8, 8, 8]}",
        "{\"eye\": [40, -30, 20], \"at\": [8, 8, 8]}"};
    static const char lines[] = "\"box\": true, \"axes\": true, \"cross_hair\": true, \"font\": \"/nowhere/font.ttf\"";
    static const char letters[] = "\"sides\": true, \"title\": \"A ball\", \"caption\": \"and lines\"";
    size_t n_crossed = 0;
    (void)state;
    for (size_t i = 0; i < 3; i++) {
        vv_world *world = ball();
        char text[512];
        set(&world, "views.main.camera", cameras[i]);
        set(&world, "views.main.width", "200");
        set(&world, "views.main.height", "160");
        vv_image *plain = picture_of(world);
        snprintf(text, sizeof text, "{%s}", lines);
        set(&world, "views.main.decorations", text);
        vv_image *crossed = picture_of(world);
        snprintf(text, sizeof text, "{%s, %s}", lines, letters);
        set(&world, "views.main.decorations", text);
        vv_image *image = picture_of(world);
        vv_scene *scene;
        vvi_sheet_plan plan = {0};
        assert_int_equal(vv_scene_resolve(&scene, world, "main", NULL), VV_OK);
        vvi_sheet sheet = vvi_sheet_new(scene, NULL);
        sheet.image = plain;
        assert_int_equal(vvi_sheet_place(&plan, &sheet), VV_OK);
        assert_true(plan.captions.n > 0 && plan.sides.side[2].there);
        n_crossed += n_different_in(plain, crossed, plan.captions.box);
        assert_int_equal(n_different_in(plain, image, plan.captions.box), 0);
        for (int k = 0; k < 4; k++)
            if (plan.sides.side[k].there)
                assert_int_equal(n_different_in(plain, image, plan.sides.side[k].box), 0);
        vvi_sheet_plan_finish(&plan);
        vv_scene_release(scene);
        vv_image_release(plain);
        vv_image_release(crossed);
        vv_image_release(image);
        vv_object_release(&world->base);
    }
    assert_true(n_crossed > 20);
}

static void layouts_place_in_corners_and_say_when_they_are_full(void **state)
{
    (void)state;
    vvi_layout l = {.width = 100, .height = 100, .margin = 10, .gap = 2};
    const vvi_wish wish = {.width = 30, .height = 30, .right = true, .bottom = true};
    vvi_box b;
    assert_true(vvi_layout_place(&b, &l, &wish));
    assert_true(b.x1 == 90 && b.y1 == 90);
    assert_true(vvi_layout_place(&b, &l, &wish) && b.x1 == 90 && b.y0 == 10); /* the same side, the other end */
    assert_true(vvi_layout_place(&b, &l, &wish) && b.x0 == 10 && b.y1 == 90);
    assert_true(vvi_layout_place(&b, &l, &wish) && b.x0 == 10 && b.y0 == 10);
    assert_false(vvi_layout_place(&b, &l, &wish));
    assert_false(vvi_layout_take(&l, (vvi_box){45, 45, 101, 46}));
    assert_false(vvi_layout_take(&l, (vvi_box){45, NAN, 50, 46}));
    assert_false(vvi_layout_take(&l, (vvi_box){41, 20, 46, 30})); /* nearer than the gap */
    assert_true(vvi_layout_take(&l, (vvi_box){43, 20, 46, 30}));
    assert_int_equal(l.n, 5);
}

/* Captions -------------------------------------------------------------------------------------------------------- */

static void expect_caption(const vv_scene *scene, const char *text, const char *expected)
{
    char *filled;
    assert_int_equal(vvi_caption_fill(&filled, text, scene, "caption"), VV_OK);
    assert_string_equal(filled, expected);
    free(filled);
}

static void placeholders_are_filled_in(void **state)
{
    (void)state;
    vv_world *world = ball();
    vv_scene *scene;
    char *filled;
    set(&world, "title", "A ball");
    set(&world, "views.main.camera.azimuth", "-30");
    assert_int_equal(vv_scene_resolve(&scene, world, "main", NULL), VV_OK);
    expect_caption(scene, "{title}: {dims} of {spacing}",
                   "A ball: 33 \xc3\x97 33 \xc3\x97 33 of 0.5 \xc3\x97 0.5 \xc3\x97 0.5 mm");
    expect_caption(scene, "{file} {view} {method} {azimuth} {unit}", "ball main raycast -30\xc2\xb0 mm");
    expect_caption(scene, "{{title}} {{x }y", "{title} {x }y");
    expect_caption(scene, "", "");
    expect_caption(scene, "100 %s", "100 %s");
    assert_int_equal(vvi_caption_fill(&filled, "{dimz}", scene, "decorations.caption"), VV_E_ARGUMENT);
    assert_non_null(strstr(vv_error_last()->message, "'dims'"));
    assert_null(filled);
    assert_int_equal(vvi_caption_fill(&filled, "of {file", scene, "decorations.title"), VV_E_ARGUMENT);
    assert_non_null(strstr(vv_error_last()->message, "'{file' has no closing brace"));
    assert_null(filled);
    vv_scene_release(scene);
    vv_object_release(&world->base);
}

static void wrong_placeholders_fail_before_the_picture(void **state)
{
    (void)state;
    vv_world *world = ball();
    vv_image *image;
    set(&world, "views.main.decorations.caption", "\"{what}\"");
    assert_int_equal(vv_render(&image, NULL, world, "main", NULL, NULL), VV_E_ARGUMENT);
    assert_null(image);
    vv_object_release(&world->base);
}

static void a_picture_without_a_font_has_no_letters(void **state)
{
    (void)state;
    vv_world *world = ball();
    set(&world, "views.main.decorations",
        "{\"cube\": true, \"scale_bar\": true, \"legend\": true, \"axes\": true, "
        "\"title\": \"A ball\", \"font\": \"/nowhere/font.ttf\"}");
    vv_image_release(picture_of(world));
    vv_object_release(&world->base);
}

static void no_volume_and_odd_sizes_are_fine(void **state)
{
    static const char *const sizes[] = {"1", "2", "17", "97"};
    (void)state;
    for (size_t i = 0; i < 8; i++) {
        vv_world *world = ball();
        set(&world, "views.main.decorations",
            "{\"cube\": true, \"scale_bar\": true, \"legend\": true, \"axes\": true, \"box\": true, \"cut_planes\": "
            "true, \"title\": \"A ball of many words\", \"caption\": \"one\\ntwo three four\"}");
        set(&world, "cut_planes", "[{\"normal\": [1, 2, 3], \"offset\": 20}]");
        set(&world, "views.main.width", sizes[i % 4]);
        set(&world, "views.main.height", sizes[i / 2]);
        set(&world, "volumes.ball.visible", i & 1 ? "false" : "true");
        vv_image_release(picture_of(world));
        vv_object_release(&world->base);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(round_numbers_are_one_two_five),
        cmocka_unit_test(ticks_lie_within_and_are_as_many_as_fit),
        cmocka_unit_test(numbers_are_written_as_people_do),
        cmocka_unit_test(lengths_take_the_unit_with_fewest_digits),
        cmocka_unit_test(a_plane_through_a_cube_is_the_polygon_that_it_is),
        cmocka_unit_test(nothing_wanted_changes_nothing),
        cmocka_unit_test(the_camera_stays),
        cmocka_unit_test(boxes_and_axes_are_seen_whole_where_the_camera_is_open),
        cmocka_unit_test(each_stands_where_it_belongs_and_layers_stay),
        cmocka_unit_test(measurements_are_drawn_by_themselves_where_they_are),
        cmocka_unit_test(a_slice_shows_what_is_measured_in_it),
        cmocka_unit_test(the_box_is_hidden_by_what_is_before_it),
        cmocka_unit_test(scale_bars_are_as_long_as_they_say),
        cmocka_unit_test(scale_bars_are_right_for_every_camera),
        cmocka_unit_test(legends_tell_labels_volumes_and_values),
        cmocka_unit_test(labels_without_names_have_their_numbers),
        cmocka_unit_test(ink_is_seen_on_dark_and_on_bright),
        cmocka_unit_test(letters_grow_with_the_picture),
        cmocka_unit_test(no_two_meet_and_none_leaves_the_picture),
        cmocka_unit_test(items_stay_in_their_boxes),
        cmocka_unit_test(lines_are_broken_where_something_stands),
        cmocka_unit_test(layouts_place_in_corners_and_say_when_they_are_full),
        cmocka_unit_test(placeholders_are_filled_in),
        cmocka_unit_test(wrong_placeholders_fail_before_the_picture),
        cmocka_unit_test(a_picture_without_a_font_has_no_letters),
        cmocka_unit_test(no_volume_and_odd_sizes_are_fine),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
