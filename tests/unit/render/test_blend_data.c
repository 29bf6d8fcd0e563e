/* What the general kernel of the ray caster reads: colours, coefficients of splines, planes of values and gradients.
 * And how a World says so. */
#include "core/cache.h"
#include "core/memory.h"
#include "fields.h"
#include "model/context.h"
#include "ray_scene.h"
#include "render/common/cubic_spline.h"
#include "render/common/transfer_plane.h"
#include "scene/colors.h"
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <volvis/image.h>
#include <volvis/render.h>

#include <cmocka.h>

/* Colours -----------------------------------------------------------------------------------------------------------
 */

static vv_field *colors_of(vv_type type, vv_meaning meaning, const void *samples, size_t bytes)
{
    vv_field_info info = vv_field_info_default();
    vv_field *field;
    void *data;
    info.type = type;
    info.meaning = meaning;
    info.components = meaning == VV_MEANING_RGBA ? 4 : 3;
    info.grid.dims[0] = 2;
    assert_int_equal(vv_field_new_empty(&field, &data, &info, NULL), VV_OK);
    memcpy(data, samples, bytes);
    return field;
}

static void bytes_are_srgb_and_become_premultiplied_light(void **state)
{
    (void)state;
    const uint8_t samples[2][4] = {{255, 128, 0, 255}, {10, 200, 255, 51}};
    vv_field *field = colors_of(VV_TYPE_U8, VV_MEANING_RGBA, samples, sizeof samples), *scalar;
    for (int encoded = 0; encoded < 2; encoded++) {
        vvi_cached *cached = NULL;
        assert_int_equal(vvi_colors_open(&cached, field, encoded, NULL), VV_OK);
        const vv_field *colors = vvi_cached_value(cached);
        const vv_box box = vv_field_box(colors);
        vv_brick brick;
        assert_int_equal(vv_field_brick(&brick, colors, &box, NULL), VV_OK);
        for (int i = 0; i < 8; i++) {
            const double v = samples[i / 4][i % 4] / 255.0, alpha = samples[i / 4][3] / 255.0;
            const double want = i % 4 == 3 ? alpha : alpha * (encoded ? vv_srgb_decode(v) : v);
            assert_true(fabs(((const uint16_t *)brick.data)[i] / 65535.0 - want) < 1e-5);
        }
        vv_brick_release(&brick);
        vvi_cache_release(cached);
    }
    assert_int_equal(vvi_colors_scalar(&scalar, field, true, NULL), VV_OK);
    vv_statistics *s = malloc(sizeof *s);
    assert_int_equal(vv_field_statistics(s, scalar, 0, NULL), VV_OK);
    assert_true(s->max == 1 && s->min == 51 / 255.0); /* alpha, as it was stored */
    assert_int_equal(vv_field_get_info(scalar)->type, VV_TYPE_U8);
    free(s);
    vv_field_release(scalar);
    vv_field_release(field);
}

static void colours_without_alpha_are_as_opaque_as_they_are_bright(void **state)
{
    (void)state;
    const float samples[2][3] = {{0.5f, 0.25f, 1}, {2, NAN, -1}}; /* beyond 0 to 1 is cut off, NaN is none */
    vv_field *field = colors_of(VV_TYPE_F32, VV_MEANING_RGB, samples, sizeof samples), *scalar;
    assert_int_equal(vvi_colors_scalar(&scalar, field, false, NULL), VV_OK);
    vv_statistics *s = malloc(sizeof *s);
    assert_int_equal(vv_field_statistics(s, scalar, 0, NULL), VV_OK);
    const double first = 0.2126 * 0.5 + 0.7152 * 0.25 + 0.0722, second = 0.2126;
    assert_true(fabs(s->max - first) < 1e-6 && fabs(s->min - second) < 1e-6);
    free(s);
    vv_field_release(scalar);
    vv_field_release(field);
}

/* Splines -----------------------------------------------------------------------------------------------------------
 */

static double weight(double x)
{
    const double a = fabs(x);
    return a < 1 ? 2.0 / 3 - a * a + a * a * a / 2 : a < 2 ? (2 - a) * (2 - a) * (2 - a) / 6 : 0;
}

static int64_t mirrored(int64_t i, int64_t n)
{
    while (n > 1 && (i < 0 || i >= n))
        i = i < 0 ? -i : 2 * (n - 1) - i;
    return n > 1 ? i : 0;
}

static double spline_at(const vvi_lattice *g, double x, double y, double z)
{
    double sum = 0;
    for (int64_t k = (int64_t)floor(z) - 1; k < (int64_t)floor(z) + 3; k++)
        for (int64_t j = (int64_t)floor(y) - 1; j < (int64_t)floor(y) + 3; j++)
            for (int64_t i = (int64_t)floor(x) - 1; i < (int64_t)floor(x) + 3; i++)
                sum += weight(x - (double)i) * weight(y - (double)j) * weight(z - (double)k) *
                       (double)((const float *)g->data)[mirrored(k, g->n[2]) * g->slice +
                                                        mirrored(j, g->n[1]) * g->row + mirrored(i, g->n[0])];
    return sum;
}

static void the_spline_goes_through_every_sample(void **state)
{
    (void)state;
    static const int64_t sizes[][3] = {{13, 17, 40}, {2, 3, 1}, {1, 1, 1}, {5, 2, 64}, {16, 1, 15}};
    for (size_t z = 0; z < sizeof sizes / sizeof *sizes; z++) {
        vv_field_info info = vv_field_info_default();
        memcpy(info.grid.dims, sizes[z], sizeof info.grid.dims);
        info.type = z % 2 ? VV_TYPE_I16 : VV_TYPE_U8;
        vv_field *field = test_field_random(&info, test_seed(), NULL);
        vvi_lattice_hold spline, plain;
        assert_int_equal(vvi_lattice_open_cubic(&spline, field, 0, NULL), VV_OK);
        assert_int_equal(vvi_lattice_open(&plain, field, 0, NULL), VV_OK);
        for (int64_t i = 0; i < sizes[z][0] * sizes[z][1] * sizes[z][2]; i++) {
            const int64_t x = i % sizes[z][0], y = i / sizes[z][0] % sizes[z][1], k = i / (sizes[z][0] * sizes[z][1]);
            const double want =
                z % 2 ? ((const int16_t *)plain.lattice.data)[i] : ((const uint8_t *)plain.lattice.data)[i];
            const double got = spline_at(&spline.lattice, (double)x, (double)y, (double)k);
            assert_true(fabs(got - want) < (z % 2 ? 0.1 : 1e-3));
        }
        vvi_lattice_close(&spline);
        vvi_lattice_close(&plain);
        vv_field_release(field);
    }
}

static void the_spline_of_a_wave_is_closer_to_it_than_straight_lines(void **state)
{
    (void)state;
    enum { N = 64 };
    vv_field_info info = vv_field_info_default();
    vv_field *field;
    void *data;
    vvi_lattice_hold hold;
    info.type = VV_TYPE_F32;
    info.grid.dims[0] = N;
    assert_int_equal(vv_field_new_empty(&field, &data, &info, NULL), VV_OK);
    for (int i = 0; i < N; i++)
        ((float *)data)[i] = (float)cos(2 * M_PI * i / 8);
    assert_int_equal(vvi_lattice_open_cubic(&hold, field, 0, NULL), VV_OK);
    double worst = 0;
    for (double x = 8; x < N - 8; x += 0.13)
        worst = fmax(worst, fabs(spline_at(&hold.lattice, x, 0, 0) - cos(2 * M_PI * x / 8)));
    assert_true(worst < 0.004); /* straight lines: 0.076 */
    vvi_lattice_close(&hold);
    vv_field_release(field);
}

/* Planes ------------------------------------------------------------------------------------------------------------
 */

static const vv_region two[] = {
    {.value_lo = 10,
     .value_hi = 20,
     .top_lo = 10,
     .top_hi = 20,
     .gradient_hi = INFINITY,
     .color = {1, 0, 0},
     .opacity = 0.5},
    {.value_lo = 30,
     .value_hi = 30,
     .top_lo = 20,
     .top_hi = 40,
     .gradient_lo = 2,
     .gradient_hi = 6,
     .color = {0, 0, 1},
     .opacity = 0.8,
     .edge = 1},
};
static const vv_classification plane_classes = {.kind = VV_SEGMENT_TRANSFER,
                                                .regions = two,
                                                .n_regions = 2,
                                                .gradient_top = 8,
                                                .opacity_length = 1,
                                                .opacity_scale = 2};

static double extinction_at(double value, double gradient)
{
    double rgbk[4];
    vvi_transfer_plane_evaluate(rgbk, &plane_classes, value, gradient);
    return rgbk[3];
}

static void regions_are_rectangles_and_triangles(void **state)
{
    (void)state;
    const double red = 2 * log(2), blue = -2 * log(0.2);
    assert_true(fabs(extinction_at(15, 0) - red) < 1e-12 && fabs(extinction_at(10, 100) - red) < 1e-12);
    assert_true(extinction_at(9.99, 1) == 0 && extinction_at(20.01, 1) == 0);
    assert_true(extinction_at(30, 1.9) == 0 && extinction_at(30, 6.1) == 0);
    assert_true(fabs(extinction_at(30, 4) - blue) < 1e-12);           /* half way up, in the middle of [25, 35] */
    assert_true(fabs(extinction_at(32.5, 4) + 2 * log(0.6)) < 1e-12); /* half way to its edge */
    assert_true(extinction_at(35.01, 4) == 0 && extinction_at(36, 6) > 0);
}

static void the_plane_holds_the_regions_and_its_columns_where_they_are(void **state)
{
    (void)state;
    vvi_transfer_plane plane;
    vvi_transfer_table columns;
    assert_int_equal(vvi_transfer_plane_init(&plane, &columns, &plane_classes, NULL), VV_OK);
    for (size_t v = 0; v < VVI_PLANE_SIDE; v += 5)
        for (size_t u = 1; u < VVI_PLANE_SIDE - 1; u += 3) {
            const double value = plane.lo + (plane.hi - plane.lo) * (double)u / (VVI_PLANE_SIDE - 1);
            const double want = extinction_at(value, 8 * (double)v / (VVI_PLANE_SIDE - 1));
            assert_true(fabs((double)plane.rgbk[4 * (v * VVI_PLANE_SIDE + u) + 3] - want) < 1e-5);
        }
    assert_true(vvi_transfer_occupancy(&columns, 11, 12));
    assert_true(vvi_transfer_occupancy(&columns, -100, 100));
    assert_false(vvi_transfer_occupancy(&columns, 41, 1000));
    assert_false(vvi_transfer_occupancy(&columns, -50, 9));
    vvi_transfer_plane_finish(&plane);
    vvi_transfer_table_finish(&columns);
}

/* Smooth labels -----------------------------------------------------------------------------------------------------
 */

/* A ball of radius 12 voxels of label 3 in label 0: the border that wins is where the trilinear share is a half. */
static void a_ball_of_a_label_is_round_and_its_light_smooth(void **state)
{
    (void)state;
    enum { N = 32 };
    vv_field_info info = vv_field_info_default();
    vv_field *field;
    void *data;
    info.meaning = VV_MEANING_LABEL;
    info.grid.dims[0] = info.grid.dims[1] = info.grid.dims[2] = N;
    assert_int_equal(vv_field_new_empty(&field, &data, &info, NULL), VV_OK);
    for (int i = 0; i < N * N * N; i++) {
        const double x = i % N - 15.6, y = i / N % N - 15.4, z = i / (N * N) - 15.5;
        ((uint8_t *)data)[i] = x * x + y * y + z * z < 144 ? 3 : 0;
    }
    test_ray_scene s;
    test_ray_scene_init(&s, field, 30);
    s.actor.classes.kind = VV_SEGMENT_LABELS;
    s.actor.classes.label_opacity = 1;
    for (const char *const *cpu = test_ray_cpus(); *cpu; cpu++) {
        vv_image *image = test_ray_picture(&s, *cpu, 1);
        double area = 0;
        for (int i = 0; i < 64 * 64; i++)
            area += (double)image->rgba[4 * i + 3];
        area *= 30.0 * 30 / (64 * 64);
        assert_true(fabs(area / (M_PI * 144) - 1) < 0.04);
        vv_image_release(image);
    }
    test_ray_scene_finish(&s);
    vv_field_release(field);
}

/* Worlds ------------------------------------------------------------------------------------------------------------
 */

typedef struct setup {
    vv_job *job;
    vv_object *world;
} setup;

static void begin(setup *s, vv_field *field)
{
    vv_runtime_options options;
    vv_runtime *runtime = NULL;
    vv_world *world = NULL;
    vv_runtime_options_init(&options, sizeof options);
    options.threads = 1;
    assert_int_equal(vv_runtime_new(&runtime, &options), VV_OK);
    assert_int_equal(vv_job_new(&s->job, runtime, NULL, NULL), VV_OK);
    vv_runtime_release(runtime);
    assert_int_equal(vv_world_for_field(&world, "a", field, s->job), VV_OK);
    s->world = &world->base;
    vv_field_release(field);
}

static void finish(setup *s)
{
    vv_object_release(s->world);
    vv_job_release(s->job);
}

static void set(setup *s, const char *path, const char *json)
{
    const vv_property_context context = vvi_registry_context(vv_registry_builtin());
    if (vv_path_set(&s->world, path, json, &context) != VV_OK)
        fail_msg("%s", vv_error_last()->message);
}

/* The actor of the scene that comes of the World and back from it: what is fixed shows the same. */
static vv_scene *resolve(setup *s, bool again)
{
    vv_scene *scene = NULL;
    vv_world *fixed = NULL;
    assert_int_equal(vv_scene_resolve(&scene, (vv_world *)s->world, NULL, s->job), VV_OK);
    if (!again)
        return scene;
    assert_int_equal(vv_scene_fix(&fixed, scene), VV_OK);
    vv_scene_release(scene);
    assert_int_equal(vv_scene_resolve(&scene, fixed, NULL, s->job), VV_OK);
    vv_object_release(&fixed->base);
    return scene;
}

static void refused(setup *s, vv_status status, const char *words)
{
    vv_image *image = NULL;
    assert_int_equal(vv_render(&image, NULL, (vv_world *)s->world, NULL, NULL, s->job), status);
    if (!strstr(vv_error_last()->message, words) && !(vv_error_last()->where && strstr(vv_error_last()->where, words)))
        fail_msg("'%s' does not say '%s'", vv_error_last()->message, words);
}

static vv_field *some_colors(vv_meaning meaning)
{
    vv_field_info info = vv_field_info_default();
    info.meaning = meaning;
    info.components = meaning == VV_MEANING_RGBA ? 4 : meaning == VV_MEANING_RGB ? 3 : 1;
    info.grid.dims[0] = info.grid.dims[1] = info.grid.dims[2] = 9;
    return test_field_random(&info, 5, NULL);
}

static void data_of_colours_show_them_unless_a_component_is_named(void **state)
{
    (void)state;
    setup s;
    begin(&s, some_colors(VV_MEANING_RGBA));
    for (int again = 0; again < 2; again++) {
        vv_scene *scene = resolve(&s, again);
        const vv_actor *a = &scene->actors[0];
        assert_non_null(a->colors);
        assert_true(a->colors_encoded);
        assert_int_equal(a->classes.kind, VV_SEGMENT_TRANSFER);
        assert_int_equal(a->classes.n_opacity, 2); /* alpha is the opacity */
        assert_true(a->classes.opacity[2] == 1 && a->classes.opacity[3] == 1);
        assert_int_equal(vv_field_get_info(a->field)->components, 1);
        vv_scene_release(scene);
    }
    set(&s, "volumes.a.component", "1");
    vv_scene *scene = resolve(&s, true);
    assert_null(scene->actors[0].colors);
    vv_scene_release(scene);
    set(&s, "volumes.a.segmentation.kind", "colors");
    set(&s, "volumes.a.segmentation.colors.encoding", "linear");
    scene = resolve(&s, true);
    assert_non_null(scene->actors[0].colors);
    assert_false(scene->actors[0].colors_encoded);
    vv_scene_release(scene);
    finish(&s);
    begin(&s, some_colors(VV_MEANING_SCALAR));
    set(&s, "volumes.a.segmentation.kind", "colors");
    refused(&s, VV_E_ARGUMENT, "segmentation.kind");
    finish(&s);
}

static void what_cubic_cannot_do_is_refused_with_a_sentence(void **state)
{
    (void)state;
    setup s;
    vv_image *image = NULL;
    begin(&s, some_colors(VV_MEANING_SCALAR));
    set(&s, "volumes.a.interpolation", "cubic");
    assert_int_equal(vv_render(&image, NULL, (vv_world *)s.world, NULL, NULL, s.job), VV_OK);
    vv_image_release(image);
    set(&s, "views.main.render.raycast.mode", "maximum");
    refused(&s, VV_E_UNSUPPORTED, "cubic is for light through a cloud");
    set(&s, "views.main.render.raycast.mode", "composite");
    set(&s, "volumes.a.segmentation.kind", "labels");
    refused(&s, VV_E_UNSUPPORTED, "labels cannot be interpolated cubically");
    finish(&s);
    vv_field_info info = vv_field_info_default();
    vv_field *field;
    void *data;
    info.type = VV_TYPE_F32;
    info.grid.dims[0] = info.grid.dims[1] = info.grid.dims[2] = 4;
    assert_int_equal(vv_field_new_empty(&field, &data, &info, NULL), VV_OK);
    for (int i = 0; i < 64; i++)
        ((float *)data)[i] = i == 7 ? NAN : (float)i;
    begin(&s, field);
    set(&s, "volumes.a.interpolation", "cubic");
    refused(&s, VV_E_UNSUPPORTED, "1 samples are not finite numbers");
    finish(&s);
}

static const vvi_raycast_params *params_at(const vv_scene *scene, size_t i)
{
    return (const vvi_raycast_params *)(const void *)vv_actor_params(scene, &scene->actors[i]);
}

static void what_a_volume_says_of_rays_takes_the_place_of_the_view(void **state)
{
    (void)state;
    setup s;
    begin(&s, some_colors(VV_MEANING_SCALAR));
    set(&s, "volumes.b", "{\"data\": \"a\"}");
    set(&s, "views.main.render.raycast", "{\"mode\": \"mean\", \"iso\": 20, \"threshold\": 30, \"step\": 0.5}");
    for (int again = 0; again < 2; again++) {
        vv_scene *scene = resolve(&s, again);
        for (size_t i = 0; i < 2; i++) {
            assert_int_equal(params_at(scene, i)->mode, VV_RAY_MEAN);
            assert_true(params_at(scene, i)->step == 0.5 && params_at(scene, i)->threshold == 30);
        }
        vv_scene_release(scene);
    }
    set(&s, "volumes.b.rays", "{\"mode\": \"mip\", \"iso\": 40, \"threshold\": 50, \"step\": 0.25}");
    vv_scene *scene = resolve(&s, true);
    const vvi_raycast_params *a = params_at(scene, 0), *b = params_at(scene, 1);
    assert_true(a->mode == VV_RAY_MEAN && a->iso == 20 && a->threshold == 30 && a->step == 0.5);
    assert_true(b->mode == VV_RAY_MAXIMUM && b->iso == 40 && b->threshold == 50 && b->step == 0.25);
    assert_true(((const vvi_raycast_params *)(const void *)scene->params)->mode == VV_RAY_MEAN);
    vv_scene_release(scene);
    finish(&s);
}

/* The maximum of one over the cloud of the other: who is a layer, who has the opacity that somebody gave. */
static void layers_follow_from_colours_and_opacities_that_are_set(void **state)
{
    (void)state;
    setup s;
    begin(&s, some_colors(VV_MEANING_SCALAR));
    set(&s, "volumes.b", "{\"data\": \"a\", \"rays\": {\"mode\": \"maximum\", \"opacity\": 0.5}}");
    vv_scene *scene = resolve(&s, false);
    const vv_classification *k = &scene->actors[1].classes;
    assert_true(scene->actors[1].layer.blend == VV_SLICE_OVER && scene->actors[1].layer.opacity == 0.5);
    assert_int_equal(k->n_opacity, 2);
    assert_true(k->opacity[0] == k->color[0] && k->opacity[1] == 0);
    assert_true(k->opacity[2] == k->color[4 * (k->n_color - 1)] && k->opacity[3] == 1);
    vv_scene_release(scene);
    set(&s, "volumes.b.rays.mode", "minimum");
    scene = resolve(&s, true);
    k = &scene->actors[1].classes;
    assert_true(k->n_opacity == 2 && k->opacity[1] == 1 && k->opacity[3] == 0);
    vv_scene_release(scene);
    set(&s, "volumes.b.segmentation.transfer.colormap", "#00ff00");
    scene = resolve(&s, true);
    k = &scene->actors[1].classes;
    assert_true(scene->actors[1].layer.blend == VV_SLICE_ADD);
    assert_true(k->n_opacity == 1 && k->opacity[1] == 1);
    vv_scene_release(scene);
    set(&s, "volumes.b.rays.blend", "over");
    set(&s, "volumes.b.segmentation.transfer.opacity", "[[0, 0], [100, 0.5]]");
    scene = resolve(&s, true);
    k = &scene->actors[1].classes;
    assert_true(scene->actors[1].layer.blend == VV_SLICE_OVER && k->opacity[2] == 100 && k->opacity[3] == 0.5);
    vv_scene_release(scene);
    finish(&s);
}

static void regions_and_paint_reach_the_renderer(void **state)
{
    (void)state;
    setup s;
    begin(&s, some_colors(VV_MEANING_SCALAR));
    set(&s, "volumes.a.segmentation.transfer.regions",
        "[{\"value_lo\": 10, \"value_hi\": 90, \"top_hi\": 120, \"gradient_lo\": 3}, {\"gradient_hi\": 900}]");
    set(&s, "volumes.a.paint", "{\"data\": \"a\", \"colormap\": \"magma\", \"range_lo\": 20}");
    set(&s, "volumes.a.segmentation.transfer.gradient_power", "2");
    for (int again = 0; again < 2; again++) {
        vv_scene *scene = resolve(&s, again);
        const vv_actor *a = &scene->actors[0];
        assert_int_equal(a->classes.n_regions, 2);
        assert_true(a->classes.regions[0].top_lo == 10 && a->classes.regions[0].top_hi == 120);
        assert_true(isinf(a->classes.regions[0].gradient_hi) && a->classes.gradient_top >= 900);
        assert_true(a->classes.gradient_power == 2 && a->classes.gradient_reference > 0);
        assert_non_null(a->paint.field);
        assert_true(a->paint.color[0] == 20 && a->paint.n_color == 33);
        vv_scene_release(scene);
    }
    set(&s, "volumes.a.paint", "{\"data\": \"b\"}");
    refused(&s, VV_E_NOT_FOUND, "paint.data");
    set(&s, "volumes.a.paint", "{\"data\": \"a\", \"component\": 4}");
    refused(&s, VV_E_ARGUMENT, "paint.component");
    set(&s, "volumes.a.paint", "{\"data\": \"a\", \"colormap\": \"virids\"}");
    refused(&s, VV_E_NOT_FOUND, "viridis");
    finish(&s);
}

/* Frames without memory: each of the ways above, with every allocation failing in turn. */
static void any_frame_without_memory_is_an_error_and_leaves_nothing(void **state)
{
    (void)state;
    static const char *const ways[][2] = {
        {"volumes.a.interpolation", "cubic"},
        {"volumes.a.segmentation.transfer.regions", "[{\"value_hi\": 200}]"},
        {"volumes.a.segmentation.transfer.gradient_power", "1"},
        {"views.main.render.raycast.preintegrated", "true"},
        {"volumes.a.paint", "{\"data\": \"a\"}"},
        {"volumes.b", "{\"data\": \"a\", \"segmentation\": {\"kind\": \"threshold\"}}"},
        {"volumes.a.title", "colours"}};
    for (size_t w = 0; w < sizeof ways / sizeof *ways; w++) {
        setup s;
        begin(&s, some_colors(w == 6 ? VV_MEANING_RGB : VV_MEANING_SCALAR));
        set(&s, ways[w][0], ways[w][1]);
        set(&s, "views.main.width", "20");
        set(&s, "views.main.height", "20");
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
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bytes_are_srgb_and_become_premultiplied_light),
        cmocka_unit_test(colours_without_alpha_are_as_opaque_as_they_are_bright),
        cmocka_unit_test(the_spline_goes_through_every_sample),
        cmocka_unit_test(the_spline_of_a_wave_is_closer_to_it_than_straight_lines),
        cmocka_unit_test(regions_are_rectangles_and_triangles),
        cmocka_unit_test(the_plane_holds_the_regions_and_its_columns_where_they_are),
        cmocka_unit_test(a_ball_of_a_label_is_round_and_its_light_smooth),
        cmocka_unit_test(data_of_colours_show_them_unless_a_component_is_named),
        cmocka_unit_test(what_cubic_cannot_do_is_refused_with_a_sentence),
        cmocka_unit_test(what_a_volume_says_of_rays_takes_the_place_of_the_view),
        cmocka_unit_test(layers_follow_from_colours_and_opacities_that_are_set),
        cmocka_unit_test(regions_and_paint_reach_the_renderer),
        cmocka_unit_test(any_frame_without_memory_is_an_error_and_leaves_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
