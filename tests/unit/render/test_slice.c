/* Slices against formulas: the light of a pixel from the place of its middle, without a ray and without a lens. */
#include "core/vec.h"
#include "fields.h"
#include "jobs.h"
#include "model/context.h"
#include "render/decorate/sheet.h"
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

static void set(vv_world **world, const char *path, const char *json)
{
    const vv_property_context context = vvi_registry_context(NULL);
    vv_object *root = &(*world)->base;
    if (vv_path_set(&root, path, json, &context) != VV_OK)
        fail_msg("%s: %s", path, vv_error_last()->message);
    *world = (vv_world *)(void *)root;
}

static void set_number(vv_world **world, const char *path, double number)
{
    char text[32];
    snprintf(text, sizeof text, "%.17g", number);
    set(world, path, text);
}

/* A World that shows slices of a field, which is released; transparent where nothing is. */
static vv_world *slices_of(vv_field *field, int width, int height, const char *orientation)
{
    vv_world *world;
    assert_non_null(field);
    assert_int_equal(vv_world_for_field(&world, "it", field, NULL), VV_OK);
    vv_field_release(field);
    set(&world, "background", "transparent");
    set_number(&world, "views.main.width", width);
    set_number(&world, "views.main.height", height);
    set(&world, "views.main.render.method", "slice");
    set(&world, "views.main.render.slice.orientation", orientation);
    return world;
}

static vv_image *picture_of(vv_world *world, vv_job *job)
{
    vv_image *image;
    if (vv_render(&image, NULL, world, "main", NULL, job) != VV_OK)
        fail_msg("%s", vv_error_last()->message);
    return image;
}

static const float *pixel(const vv_image *image, int x, int y)
{
    return image->rgba + 4 * ((size_t)y * (size_t)image->width + (size_t)x);
}

/* Light of a value over a window, as screens show greys. */
static double grey(double value, double lo, double hi)
{
    return vv_srgb_decode(fmin(fmax((value - lo) / (hi - lo), 0), 1));
}

static void expect_near(double found, double expected, double error, const char *what, int x, int y)
{
    if (!(fabs(found - expected) <= error))
        fail_msg("%s, pixel (%d, %d): %.9g instead of %.9g", what, x, y, found, expected);
}

/* Where they are ------------------------------------------------------------------------------------------------- */

enum { WIDTH = 53, HEIGHT = 31 };
static const vv_vec3 hair = {3.25, 9.5, 5.125};

/* What is right, up and looked along in the plain axes of each plane. */
static const struct {
    const char *name;
    vv_vec3 right, up;
} ways[] = {{"axial", {1, 0, 0}, {0, -1, 0}}, {"coronal", {1, 0, 0}, {0, 0, 1}}, {"sagittal", {0, 1, 0}, {0, 0, 1}}};

/* In a parallel picture of the plane through the cross-hair, whose middle is (8, 8, 8) moved into that plane. */
static vv_vec3 place_of(double x, double y, vv_vec3 right, vv_vec3 up, double height)
{
    const vv_vec3 normal = vvi_cross(right, up), middle = {8, 8, 8};
    const double u = (x + 0.5 - WIDTH / 2.0) * height / HEIGHT, v = (HEIGHT / 2.0 - y - 0.5) * height / HEIGHT;
    const vv_vec3 in_plane = vvi_add(middle, vvi_scaled(normal, vvi_dot(normal, vvi_sub(hair, middle))));
    return vvi_add(in_plane, vvi_add(vvi_scaled(right, u), vvi_scaled(up, v)));
}

static bool inside(vv_vec3 p)
{
    return fmin(fmin(p.x, p.y), p.z) >= 0 && fmax(fmax(p.x, p.y), p.z) <= 16;
}

static vv_world *ramp(const char *orientation)
{
    vv_world *world = slices_of(test_field_cube(&test_form_ramp, 17, 0, 16, NULL), WIDTH, HEIGHT, orientation);
    set(&world, "cross_hair", "[3.25, 9.5, 5.125]");
    set(&world, "views.main.camera.height", "20");
    set(&world, "views.main.render.layers", "{\"depth\": true, \"id\": true, \"value\": true, \"normal\": true}");
    set(&world, "volumes.it.slices", "{\"window_lo\": 0, \"window_hi\": 30}");
    return world;
}

static void expect_ramp(const vv_image *image, vv_vec3 right, vv_vec3 up, double height, const char *what)
{
    int seen = 0;
    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < WIDTH; x++) {
            const vv_vec3 p = place_of(x, y, right, up, height);
            const float *c = pixel(image, x, y);
            const double value = test_form_ramp.value(p);
            expect_near((double)c[3], inside(p), 0, what, x, y);
            for (int k = 0; k < 3; k++)
                expect_near((double)c[k], inside(p) ? grey(value, 0, 30) : 0, 2e-6, what, x, y);
            if (inside(p))
                expect_near((double)image->value[y * WIDTH + x], value, 2e-4, "values", x, y);
            assert_int_equal(image->id[y * WIDTH + x], inside(p));
            assert_int_equal(isfinite((double)image->depth[y * WIDTH + x]), inside(p));
            seen += inside(p);
        }
    assert_true(seen > 400);
}

static void a_linear_field_is_seen_exactly(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof ways / sizeof *ways; i++) {
        vv_world *world = ramp(ways[i].name);
        vv_image *image = picture_of(world, NULL);
        expect_ramp(image, ways[i].right, ways[i].up, 20, ways[i].name);
        vv_image_release(image);
        set(&world, "views.main.render.slice.axes", "samples"); /* which are the World's */
        image = picture_of(world, NULL);
        expect_ramp(image, ways[i].right, ways[i].up, 20, "of samples");
        vv_image_release(image);
        set(&world, "volumes.it.interpolation", "cubic"); /* mirrored at the border: not linear there, nearly inside */
        image = picture_of(world, NULL);
        const vv_vec3 p = place_of(WIDTH / 2, HEIGHT / 2, ways[i].right, ways[i].up, 20);
        expect_near((double)pixel(image, WIDTH / 2, HEIGHT / 2)[0], grey(test_form_ramp.value(p), 0, 30), 1e-4, "cubic",
                    0, 0);
        vv_image_release(image);
        vv_object_release(&world->base);
    }
}

/* At any angle, in perspective too: the plane through the cross-hair that faces the camera. */
static void planes_at_any_angle_are_seen_exactly(void **state)
{
    (void)state;
    const vv_vec3 forward = {2 / 3.0, 1 / 3.0, -2 / 3.0}, eye = {8 - 60 * forward.x, 8 - 60 * forward.y, 8 + 40};
    vv_vec3 right = vvi_cross(forward, vvi_vec(0, 0, 1));
    vvi_unit(&right);
    const vv_vec3 up = vvi_cross(right, forward);
    for (int perspective = 0; perspective < 2; perspective++) {
        vv_world *world = ramp("camera");
        char text[96];
        snprintf(text, sizeof text, "[%.17g, %.17g, %.17g]", eye.x, eye.y, eye.z);
        set(&world, "views.main.camera.eye", text);
        set(&world, "views.main.camera.at", "[8, 8, 8]");
        set(&world, "views.main.camera.projection", perspective ? "perspective" : "parallel");
        const double distance = vvi_dot(vvi_sub(hair, eye), forward);
        const double height = perspective ? 2 * distance * tan(20 * M_PI / 360) : 20;
        vv_image *image = picture_of(world, NULL);
        expect_ramp(image, right, up, height, perspective ? "perspective" : "parallel");
        vv_image_release(image);
        vv_object_release(&world->base);
    }
}

static void the_cross_hair_is_the_middle_sample_until_it_is_set(void **state)
{
    (void)state;
    vv_world *world = slices_of(test_field_cube(&test_form_ramp, 8, 0, 7, NULL), WIDTH, HEIGHT, "axial"), *fixed;
    vv_scene *scene;
    assert_int_equal(vv_scene_resolve(&scene, world, NULL, NULL), VV_OK);
    assert_true(scene->cross_hair.x == 4 && scene->cross_hair.y == 4 && scene->cross_hair.z == 4);
    assert_int_equal(vv_scene_fix(&fixed, scene), VV_OK);
    assert_true(fixed->cross_hair.z == 4 && vv_object_is_set(&fixed->base, "cross_hair"));
    vv_image *a = picture_of(world, NULL), *b = picture_of(fixed, NULL);
    assert_memory_equal(a->rgba, b->rgba, 4 * sizeof *a->rgba * WIDTH * HEIGHT);
    vv_image_release(a);
    vv_image_release(b);
    vv_scene_release(scene);
    vv_object_release(&fixed->base);
    vv_object_release(&world->base);
}

/* Which side is which --------------------------------------------------------------------------------------------- */

/* Samples along R, A and S of a body, stored along any axes in any direction; one is bright. */
static vv_field *head(const int order[3], int flips, const int64_t bright[3])
{
    static const int64_t body[3] = {5, 7, 9};
    static const double spacing[3] = {2, 1, 3};
    vv_field_info info = vv_field_info_default();
    vv_field *field;
    uint8_t *data;
    int64_t at = 0, stride = 1;
    info.grid.space = VV_SPACE_RAS;
    snprintf(info.grid.unit, sizeof info.grid.unit, "mm");
    info.grid.index_to_world.origin = vvi_vec(0, 0, 0);
    for (int a = 0; a < 3; a++) {
        const int w = order[a], flipped = flips >> a & 1;
        const double step = flipped ? -spacing[w] : spacing[w], from = flipped ? spacing[w] * (double)(body[w] - 1) : 0;
        info.grid.dims[a] = body[w];
        info.grid.index_to_world.axis[a] = vvi_vec(w == 0 ? step : 0, w == 1 ? step : 0, w == 2 ? step : 0);
        info.grid.index_to_world.origin =
            vvi_add(info.grid.index_to_world.origin, vvi_vec(w == 0 ? from : 0, w == 1 ? from : 0, w == 2 ? from : 0));
        at += stride * (flipped ? body[w] - 1 - bright[w] : bright[w]);
        stride *= body[w];
    }
    assert_int_equal(vv_field_new_empty(&field, (void **)&data, &info, NULL), VV_OK);
    memset(data, 0, (size_t)stride);
    data[at] = 255;
    return field;
}

/* Sample (3, 4, 6) of 5 x 7 x 9 to the right, the front and the top: in millimetres (6, 4, 18), the middle being
 * (4, 3, 12). The patient's right is on the left, seen from the left the front is. A pixel is 1 mm. */
static void expect_head(vv_field *field, const char *what)
{
    static const struct {
        const char *name;
        double x, y; /* of the bright sample, from the middle, right and up */
    } where[] = {{"axial", -2, 1}, {"coronal", -2, 6}, {"sagittal", -1, 6}};
    for (size_t i = 0; i < 3; i++) {
        vv_world *world = slices_of(vv_field_retain(field), 61, 61, where[i].name);
        set(&world, "cross_hair", "[6, 4, 18]");
        set(&world, "views.main.camera.height", "61");
        set(&world, "volumes.it.interpolation", "nearest");
        for (int samples = 0; samples < 2; samples++) {
            double sum[3] = {0};
            set(&world, "views.main.render.slice.axes", samples ? "samples" : "world");
            vv_image *image = picture_of(world, NULL);
            for (int p = 0; p < 61 * 61; p++) {
                const double light = (double)image->rgba[4 * p];
                sum[0] += light;
                sum[1] += light * (p % 61 - 30);
                sum[2] += light * (30 - p / 61);
            }
            if (!(sum[0] > 0.9) || fabs(sum[1] / sum[0] - where[i].x) > 0.51 ||
                fabs(sum[2] / sum[0] - where[i].y) > 0.51)
                fail_msg("%s, %s: the bright sample is at (%g, %g) instead of (%g, %g)", what, where[i].name,
                         sum[1] / sum[0], sum[2] / sum[0], where[i].x, where[i].y);
            vv_image_release(image);
        }
        vv_object_release(&world->base);
    }
    vv_field_release(field);
}

static void the_patients_right_is_on_the_left_however_samples_are_stored(void **state)
{
    static const int orders[6][3] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
    (void)state;
    for (int i = 0; i < 48; i++) {
        char what[64];
        const int *order = orders[i / 8];
        snprintf(what, sizeof what, "axes %d %d %d, flips %d", order[0], order[1], order[2], i % 8);
        expect_head(head(order, i % 8, (const int64_t[3]){3, 4, 6}), what);
    }
}

static void borders_have_the_letters_of_where_they_look(void **state)
{
    static const struct {
        const char *plane, *anatomical[4], *plain[4]; /* left, right, top, bottom */
    } expected[] = {
        {"axial", {"R", "L", "A", "P"}, {"\xe2\x88\x92x", "x", "\xe2\x88\x92y", "y"}},
        {"coronal", {"R", "L", "S", "I"}, {"\xe2\x88\x92x", "x", "z", "\xe2\x88\x92z"}},
        {"sagittal", {"A", "P", "S", "I"}, {"\xe2\x88\x92y", "y", "z", "\xe2\x88\x92z"}},
    };
    (void)state;
    for (size_t i = 0; i < 3; i++)
        for (int plain = 0; plain < 2; plain++) {
            vv_field *field = plain ? test_field_cube(&test_form_ramp, 5, 0, 4, NULL)
                                    : head((const int[3]){1, 2, 0}, 3, (const int64_t[3]){0, 0, 0});
            vv_world *world = slices_of(field, 90, 80, expected[i].plane);
            vv_scene *scene;
            assert_int_equal(vv_scene_resolve(&scene, world, NULL, NULL), VV_OK);
            vvi_sheet sheet = vvi_sheet_new(scene, NULL);
            vvi_sheet_sides sides;
            vvi_sheet_sides_place(&sides, &sheet);
            for (int side = 0; side < 4; side++) {
                assert_true(sides.side[side].there);
                assert_string_equal(sides.side[side].text,
                                    plain ? expected[i].plain[side] : expected[i].anatomical[side]);
            }
            assert_true(sides.side[0].x < 30 && sides.side[1].x > 60 && sides.side[2].y < 30 && sides.side[3].y > 50);
            vv_scene_release(scene);
            vv_object_release(&world->base);
        }
    char text[VVI_SIDE_TEXT];
    vvi_sheet_side_text(text, vvi_vec(0.6, -0.8, 0), true);
    assert_string_equal(text, "PR");
    vvi_sheet_side_text(text, vvi_vec(0.99, -0.1, 0.1), true);
    assert_string_equal(text, "R");
}

/* The samples reach from the first to the last, half a sample more where they are nearest. */
static void proportions_are_those_of_the_body(void **state)
{
    (void)state;
    static const double extent[3][2] = {{10, 7}, {10, 27}, {7, 27}}; /* mm: 5 x 2, 7 x 1, 9 x 3 */
    for (size_t i = 0; i < 3; i++) {
        vv_world *world =
            slices_of(head((const int[3]){2, 0, 1}, 5, (const int64_t[3]){0, 0, 0}), 97, 89, ways[i].name);
        set(&world, "views.main.camera.height", "44.5"); /* a pixel is half a millimetre */
        set(&world, "volumes.it.interpolation", "nearest");
        vv_image *image = picture_of(world, NULL);
        int n = 0, lo[2] = {1000, 1000}, hi[2] = {-1, -1};
        for (int p = 0; p < 97 * 89; p++) {
            const int at[2] = {p % 97, p / 97};
            for (int a = 0; image->rgba[4 * p + 3] > 0 && a < 2; a++) {
                lo[a] = at[a] < lo[a] ? at[a] : lo[a];
                hi[a] = at[a] > hi[a] ? at[a] : hi[a];
            }
            n += image->rgba[4 * p + 3] > 0;
        }
        assert_true(abs(hi[0] - lo[0] + 1 - (int)(2 * extent[i][0])) <= 1);
        assert_true(abs(hi[1] - lo[1] + 1 - (int)(2 * extent[i][1])) <= 1);
        assert_int_equal(n, (hi[0] - lo[0] + 1) * (hi[1] - lo[1] + 1));
        vv_image_release(image);
        vv_object_release(&world->base);
    }
}

/* What they show -------------------------------------------------------------------------------------------------- */

/* A pixel a sample, the first at the top left: the plane across z of a field of w x h x n samples at k. */
static vv_world *samples_of(vv_field *field, int64_t k)
{
    const int64_t *n = vv_field_get_info(field)->grid.dims;
    const int width = (int)n[0], height = (int)n[1];
    vv_world *world = slices_of(field, width, height, "axial");
    char text[64];
    set_number(&world, "views.main.camera.height", height);
    snprintf(text, sizeof text, "[0, 0, %lld]", (long long)k);
    set(&world, "cross_hair", text);
    return world;
}

static const int64_t sizes[][3] = {{1, 1, 1}, {1, 5, 1}, {7, 1, 3}, {1, 1, 11}, {2, 3, 2}, {13, 17, 5}, {31, 8, 2}};

static void every_type_and_size_is_seen_sample_by_sample(void **state)
{
    (void)state;
    for (int t = 0; t < VV_TYPE_COUNT; t++)
        for (size_t s = 0; s < sizeof sizes / sizeof *sizes; s++)
            for (int interpolation = 0; interpolation < 2; interpolation++) {
                static const char *const names[] = {"nearest", "linear"};
                vv_field_info info = vv_field_info_default();
                info.type = (vv_type)t;
                memcpy(info.grid.dims, sizes[s], sizeof sizes[s]);
                vv_field *field = test_field_random(&info, test_seed() + s, NULL), *kept = vv_field_retain(field);
                vv_statistics all;
                assert_int_equal(vv_field_statistics(&all, kept, 0, NULL), VV_OK);
                const double lo = all.min, hi = all.max > lo ? all.max : lo + 1;
                const int64_t k = sizes[s][2] - 1;
                vv_world *world = samples_of(field, k);
                set_number(&world, "volumes.it.slices.window_lo", lo);
                set_number(&world, "volumes.it.slices.window_hi", hi);
                set(&world, "volumes.it.interpolation", names[interpolation]);
                vv_image *image = picture_of(world, NULL);
                for (int y = 0; y < image->height; y++)
                    for (int x = 0; x < image->width; x++) {
                        expect_near((double)pixel(image, x, y)[3], 1, 0, vv_type_name((vv_type)t), x, y);
                        expect_near((double)pixel(image, x, y)[0], grey(vv_field_value(kept, x, y, k, 0), lo, hi), 3e-6,
                                    vv_type_name((vv_type)t), x, y);
                    }
                vv_image_release(image);
                vv_object_release(&world->base);
                vv_field_release(kept);
            }
}

static vv_field *row_of(const float *values, int64_t n)
{
    vv_field_info info = vv_field_info_default();
    vv_field *field;
    float *data;
    info.type = VV_TYPE_F32;
    info.grid.dims[0] = n;
    assert_int_equal(vv_field_new_empty(&field, (void **)&data, &info, NULL), VV_OK);
    memcpy(data, values, (size_t)n * sizeof *values);
    return field;
}

static void what_is_no_number_is_clear(void **state)
{
    (void)state;
    vv_world *world = samples_of(row_of((const float[]){0, NAN, INFINITY, -INFINITY, 2, 1}, 6), 0);
    set(&world, "volumes.it.slices", "{\"window_lo\": 0, \"window_hi\": 2}");
    vv_image *image = picture_of(world, NULL);
    static const float expected[6][2] = {{0, 1}, {0, 0}, {1, 1}, {0, 1}, {1, 1}, {0.2140411F, 1}};
    for (int x = 0; x < 6; x++) {
        expect_near((double)pixel(image, x, 0)[0], (double)expected[x][0], 1e-6, "light", x, 0);
        expect_near((double)pixel(image, x, 0)[3], (double)expected[x][1], 0, "alpha", x, 0);
    }
    assert_true(isinf((double)image->depth[1]));
    vv_image_release(image);
    set(&world, "volumes.it.slices", "{\"window_lo\": 1, \"window_hi\": 1}"); /* a step */
    image = picture_of(world, NULL);
    assert_true(pixel(image, 0, 0)[0] == 0 && pixel(image, 4, 0)[0] == 1);
    vv_image_release(image);
    vv_object_release(&world->base);
}

static void a_window_that_nobody_set_is_of_percentiles(void **state)
{
    (void)state;
    vv_world *world = slices_of(test_field_cube(&test_form_ramp, 17, 0, 16, NULL), 20, 20, "axial"), *fixed;
    vv_scene *scene;
    assert_int_equal(vv_scene_resolve(&scene, world, NULL, NULL), VV_OK);
    const vv_slice_look *look = &scene->actors[0].slices;
    assert_true(look->lo == scene->actors[0].statistics->percentile[1]);
    assert_true(look->hi == scene->actors[0].statistics->percentile[4]);
    assert_int_equal(vv_scene_fix(&fixed, scene), VV_OK);
    const vv_volume *volume = (const vv_volume *)(void *)vv_collection_find(fixed->volumes, "it");
    assert_true(((const vv_volume_slices *)(void *)volume->slices)->window_lo == look->lo);
    vv_scene_release(scene);
    vv_object_release(&fixed->base);
    vv_object_release(&world->base);
}

/* Black and white samples like a chessboard, smaller than pixels: a pixel is the mean of their light. */
static void pixels_of_many_samples_are_their_mean(void **state)
{
    (void)state;
    vv_field_info info = vv_field_info_default();
    vv_field *field;
    uint8_t *data;
    info.grid.dims[0] = 64;
    info.grid.dims[1] = 24;
    assert_int_equal(vv_field_new_empty(&field, (void **)&data, &info, NULL), VV_OK);
    for (int i = 0; i < 64 * 24; i++)
        data[i] = (uint8_t)((i + i / 64) % 2);
    vv_world *world = samples_of(field, 0);
    set(&world, "volumes.it.slices", "{\"window_lo\": 0, \"window_hi\": 1}");
    set(&world, "views.main.width", "8");
    set(&world, "views.main.height", "3");
    vv_image *image = picture_of(world, NULL);
    for (int i = 0; i < 8 * 3; i++) {
        expect_near((double)image->rgba[4 * i], 0.5, 1e-6, "mean", i % 8, i / 8);
        expect_near((double)image->rgba[4 * i + 3], 1, 0, "mean", i % 8, i / 8);
    }
    vv_image_release(image);
    vv_object_release(&world->base);
}

/* Cuts and light change nothing; threads neither; a picture that is looked at on its way neither. */
static void ignore(void *user, const vv_refinement *r)
{
    ++*(int *)user;
    assert_true(r->level == 2);
}

static void cuts_threads_and_lookers_change_nothing(void **state)
{
    (void)state;
    vv_world *world = ramp("coronal");
    vv_job *one = test_job(1, 0), *three = test_job(3, 0);
    vv_image *a = picture_of(world, one), *b = picture_of(world, three), *c;
    vv_render_options options;
    int shown = 0;
    assert_memory_equal(a->rgba, b->rgba, 4 * sizeof *a->rgba * WIDTH * HEIGHT);
    vv_image_release(b);
    set(&world, "cut_planes", "[{\"normal\": [1, 0, 0], \"offset\": 5}]");
    set(&world, "views.main.render.quality", "draft");
    vv_render_options_init(&options, sizeof options);
    options.on_refined = ignore;
    options.user = &shown;
    assert_int_equal(vv_render(&c, NULL, world, "main", &options, three), VV_OK);
    assert_int_equal(shown, 1);
    assert_memory_equal(a->rgba, c->rgba, 4 * sizeof *a->rgba * WIDTH * HEIGHT);
    vv_image_release(a);
    vv_image_release(c);
    vv_object_release(&world->base);
    vv_job_release(one);
    vv_job_release(three);
}

/* Several, and colours -------------------------------------------------------------------------------------------- */

/* Labels over values: clear ones leave them, others lie over them. */
static void labels_lie_over_values(void **state)
{
    (void)state;
    vv_field_info info = vv_field_info_default();
    vv_field *labels;
    uint8_t *data;
    vv_world *world = samples_of(row_of((const float[]){2, 2, 2, 1}, 4), 0);
    info.grid.dims[0] = 4;
    info.meaning = VV_MEANING_LABEL;
    assert_int_equal(vv_field_new_empty(&labels, (void **)&data, &info, NULL), VV_OK);
    memcpy(data, (const uint8_t[]){0, 1, 2, 1}, 4);
    vv_model *model;
    vv_runtime *runtime;
    assert_int_equal(vv_runtime_new(&runtime, NULL), VV_OK);
    assert_int_equal(vv_model_new(&model, runtime), VV_OK);
    set(&world, "volumes.it.data", "it");
    set(&world, "volumes.it.slices", "{\"window_lo\": 0, \"window_hi\": 2}");
    assert_int_equal(vv_model_replace(model, NULL, world), VV_OK);
    assert_int_equal(vv_model_attach(model, NULL, "names", labels), VV_OK);
    assert_int_equal(vv_model_add(model, NULL, "volumes", "names",
                                  "{\"data\": \"names\", \"segmentation\": {\"kind\": \"labels\", \"labels\": "
                                  "{\"table\": [[1, 1, 0, 0, 0.1], [2, 0, 1, 0, 0]]}}}"),
                     VV_OK);
    vv_field_release(labels);
    vv_object_release(&world->base);
    world = vv_model_snapshot(model);
    static const float half = 0.2140411F; /* a middle grey */
    const float expected[4][3] = {{1, 1, 1}, {1, 0.5F, 0.5F}, {1, 1, 1}, {0.5F + half / 2, half / 2, half / 2}};
    vv_image *image = picture_of(world, NULL);
    for (int x = 0; x < 4; x++)
        for (int c = 0; c < 3; c++)
            expect_near((double)pixel(image, x, 0)[c], (double)expected[x][c], 1e-6, "labels", x, c);
    vv_image_release(image);
    set(&world, "volumes.names.slices.opacity", "25%");
    image = picture_of(world, NULL);
    expect_near((double)pixel(image, 1, 0)[1], 0.75, 1e-6, "opacity", 1, 0);
    vv_image_release(image);
    set(&world, "volumes.names.slices.blend", "add");
    image = picture_of(world, NULL);
    expect_near((double)pixel(image, 3, 0)[0], 0.25 + (double)half, 1e-6, "add", 3, 0);
    vv_image_release(image);
    vv_object_release(&world->base);
    vv_model_release(model);
    vv_runtime_release(runtime);
}

static void colors_are_those_of_the_data_or_of_the_transfer_function(void **state)
{
    (void)state;
    vv_field_info info = vv_field_info_default();
    vv_field *field;
    uint8_t *data;
    info.grid.dims[0] = 2;
    info.components = 3;
    info.meaning = VV_MEANING_RGB;
    assert_int_equal(vv_field_new_empty(&field, (void **)&data, &info, NULL), VV_OK);
    memcpy(data, (const uint8_t[]){255, 0, 0, 0, 128, 255}, 6);
    vv_world *world = samples_of(field, 0);
    vv_image *image = picture_of(world, NULL);
    const double expected[2][3] = {{1, 0, 0}, {0, vv_srgb_decode(128 / 255.0), 1}};
    for (int x = 0; x < 2; x++)
        for (int c = 0; c < 3; c++)
            expect_near((double)pixel(image, x, 0)[c], expected[x][c], 2e-5, "rgb", x, c);
    vv_image_release(image);
    vv_object_release(&world->base);

    world = samples_of(row_of((const float[]){0, 1, 2, 3}, 4), 0);
    set(&world, "volumes.it.slices.colors", "transfer");
    set(&world, "volumes.it.segmentation.transfer.opacity", "[[0, 0], [3, 1]]");
    set(&world, "volumes.it.segmentation.transfer.color", "[[0, 1, 0, 0], [3, 0, 1, 0.5]]");
    image = picture_of(world, NULL);
    for (int x = 0; x < 4; x++) {
        expect_near((double)pixel(image, x, 0)[0], 1 - x / 3.0, 1e-3, "transfer", x, 0);
        expect_near((double)pixel(image, x, 0)[2], x / 6.0, 1e-3, "transfer", x, 2);
        expect_near((double)pixel(image, x, 0)[3], 1, 0, "transfer", x, 3);
    }
    vv_image_release(image);
    set(&world, "volumes.it.slices", "{\"colormap\": \"viridi\"}");
    assert_int_equal(vv_render(&image, NULL, world, "main", NULL, NULL), VV_E_NOT_FOUND);
    assert_non_null(strstr(vv_error_last()->message, "viridi"));
    vv_object_release(&world->base);
}

/* A pixel of a slice tells what is there. */
static void picking_tells_the_value_of_a_slice(void **state)
{
    (void)state;
    vv_world *world = ramp("sagittal");
    vv_picked picked;
    const vv_pixel at = {20, 10};
    assert_int_equal(vv_pick(&picked, &at, 1, world, "main", NULL), VV_OK);
    const vv_vec3 p = place_of(20, 10, ways[2].right, ways[2].up, 20);
    assert_true(picked.hit && strcmp(picked.volume, "it") == 0);
    assert_true(vvi_length(vvi_sub(picked.world, p)) < 1e-4);
    assert_true(fabs(picked.value - test_form_ramp.value(p)) < 1e-3);
    vv_object_release(&world->base);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_linear_field_is_seen_exactly),
        cmocka_unit_test(planes_at_any_angle_are_seen_exactly),
        cmocka_unit_test(the_cross_hair_is_the_middle_sample_until_it_is_set),
        cmocka_unit_test(the_patients_right_is_on_the_left_however_samples_are_stored),
        cmocka_unit_test(borders_have_the_letters_of_where_they_look),
        cmocka_unit_test(proportions_are_those_of_the_body),
        cmocka_unit_test(every_type_and_size_is_seen_sample_by_sample),
        cmocka_unit_test(what_is_no_number_is_clear),
        cmocka_unit_test(a_window_that_nobody_set_is_of_percentiles),
        cmocka_unit_test(pixels_of_many_samples_are_their_mean),
        cmocka_unit_test(cuts_threads_and_lookers_change_nothing),
        cmocka_unit_test(labels_lie_over_values),
        cmocka_unit_test(colors_are_those_of_the_data_or_of_the_transfer_function),
        cmocka_unit_test(picking_tells_the_value_of_a_slice),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
