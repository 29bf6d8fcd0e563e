/* What is left open in a World, worked out. Fields are made here; nothing is read from files. */
#include "fail_alloc.h"
#include "fields.h"
#include "model/context.h"
#include "scene/lens.h"
#include "scene/transfer.h"
#include "worlds.h"
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include <volvis/sys/scene.h>

#include <cmocka.h>

/* Scenes are worked out for a renderer, which need not draw here. */
typedef struct no_params {
    vv_object base;
    double iso;
} no_params;
static const vv_property no_params_rows[] = {
    {VV_PROP(no_params, iso), .kind = VV_KIND_F64, .automatic = "from the histogram", .doc = "level of surfaces"},
    {0},
};
static const vv_class no_params_class = {
    "no_params", "of a renderer for tests", sizeof(no_params), no_params_rows, NULL, NULL, NULL};
static const vv_renderer no_renderer = {.api = VV_RENDERER_API,
                                        .name = "raycast",
                                        .doc = "draws nothing",
                                        .params = &no_params_class,
                                        .takes = VV_CONTENT_SAMPLES};
static const vv_renderer *const renderers[] = {&no_renderer, NULL};

typedef struct setup {
    vv_registry registry;
    vv_job *job;
    vv_object *world;
    vv_scene *scene;
} setup;

/* A World on one field, named "a". */
static void begin(setup *s, const vv_field *field)
{
    vv_runtime_options options;
    vv_runtime *runtime = NULL;
    vv_world *world = NULL;
    *s = (setup){.registry = *vv_registry_builtin()};
    s->registry.renderers = renderers;
    vv_runtime_options_init(&options, sizeof options);
    options.threads = 1;
    options.registry = &s->registry;
    assert_int_equal(vv_runtime_new(&runtime, &options), VV_OK);
    assert_int_equal(vv_job_new(&s->job, runtime, NULL, NULL), VV_OK);
    vv_runtime_release(runtime);
    assert_non_null(field);
    assert_int_equal(vv_world_for_field(&world, "a", field, s->job), VV_OK);
    s->world = &world->base;
    vv_field_release((vv_field *)field);
}

static void set(setup *s, const char *path, const char *json)
{
    const vv_property_context context = vvi_registry_context(&s->registry);
    if (vv_path_set(&s->world, path, json, &context) != VV_OK)
        fail_msg("%s", vv_error_last()->message);
}

static const vv_actor *resolve(setup *s)
{
    vv_scene_release(s->scene);
    s->scene = NULL;
    if (vv_scene_resolve(&s->scene, (vv_world *)s->world, NULL, s->job) != VV_OK)
        fail_msg("%s", vv_error_last()->message);
    return s->scene->n_actors ? &s->scene->actors[0] : NULL;
}

static void refused(setup *s, vv_status status, const char *path)
{
    vv_scene *scene = NULL;
    assert_int_equal(vv_scene_resolve(&scene, (vv_world *)s->world, NULL, s->job), status);
    assert_null(scene);
    if (!strstr(vv_error_last()->message, path))
        fail_msg("'%s' does not name '%s'", vv_error_last()->message, path);
}

static void end(setup *s)
{
    vv_scene_release(s->scene);
    vv_object_release(s->world);
    vv_job_release(s->job);
}

static const vv_field *ball(void)
{
    return test_field_cube(&test_form_sphere, 17, 0, 16, NULL);
}

/* A box of n samples, u8, each filled by `fill` of its number. */
static vv_field *bytes(const int64_t dims[3], vv_meaning meaning, vv_space space, uint8_t (*fill)(size_t index))
{
    vv_field_info info = vv_field_info_default();
    vv_field *field = NULL;
    void *data = NULL;
    memcpy(info.grid.dims, dims, sizeof info.grid.dims);
    info.grid.space = space;
    info.meaning = meaning;
    assert_int_equal(vv_field_new_empty(&field, &data, &info, NULL), VV_OK);
    for (size_t i = 0; i < (size_t)(dims[0] * dims[1] * dims[2]); i++)
        ((uint8_t *)data)[i] = fill(i);
    return field;
}

static uint8_t numbered(size_t index)
{
    return (uint8_t)(index % 7);
}

static uint8_t same(size_t index)
{
    return (uint8_t)(index * 0 + 9);
}

static void something_is_always_to_be_seen(void **state)
{
    static const int64_t cube[3] = {9, 9, 9}, slice[3] = {9, 9, 1}, one[3] = {1, 1, 1};
    const vv_field *const fields[] = {
        ball(),
        test_field_cube(&test_form_constant, 5, 0, 1, NULL),
        test_field_cube(&test_form_marschner_lobb, 21, -1, 1, NULL),
        bytes(cube, VV_MEANING_SCALAR, VV_SPACE_RAS, numbered),
        bytes(cube, VV_MEANING_LABEL, VV_SPACE_RAS, numbered),
        bytes(cube, VV_MEANING_SCALAR, VV_SPACE_PLAIN, same),
        bytes(slice, VV_MEANING_SCALAR, VV_SPACE_PLAIN, numbered),
        bytes(one, VV_MEANING_SCALAR, VV_SPACE_PLAIN, same),
    };
    for (size_t i = 0; i < sizeof fields / sizeof fields[0]; i++) {
        setup s;
        begin(&s, fields[i]);
        const vv_actor *a = resolve(&s);
        assert_non_null(a);
        assert_true(vvi_transfer_visible(&a->classes, a->statistics->min, a->statistics->max));
        assert_true(a->classes.opacity_length > 0 && isfinite(a->iso));
        assert_true(s.scene->n_lamps == 2 && s.scene->lens.half_height > 0);
        end(&s);
    }
}

static void a_field_of_nothing_but_nan_is_clear(void **state)
{
    vv_field_info info = vv_field_info_default();
    float *data = NULL;
    vv_field *field = NULL;
    setup s;
    info.type = VV_TYPE_F32;
    info.grid.dims[0] = 4;
    assert_int_equal(vv_field_new_empty(&field, (void **)&data, &info, NULL), VV_OK);
    for (int i = 0; i < 4; i++)
        data[i] = NAN;
    begin(&s, field);
    const vv_actor *a = resolve(&s);
    assert_false(vvi_transfer_visible(&a->classes, -1e30, 1e30));
    assert_true(a->classes.n_color > 0 && isfinite(a->classes.color[0]));
    end(&s);
}

static void typed_nodes_are_taken_and_refer_to_one_unit(void **state)
{
    setup s;
    begin(&s, ball());
    set(&s, "volumes.a.segmentation.transfer.opacity", "[[1, 0], [2, 0.5]]");
    set(&s, "volumes.a.segmentation.transfer.color", "[[0, 1, 0, 0]]");
    set(&s, "volumes.a.segmentation.transfer.opacity_scale", "3");
    const vv_actor *a = resolve(&s);
    assert_int_equal(a->classes.n_opacity, 2);
    assert_true(a->classes.opacity[2] == 2 && a->classes.opacity[3] == 0.5);
    assert_true(a->classes.n_color == 1 && a->classes.color[1] == 1);
    assert_true(a->classes.opacity_length == 1 && a->classes.opacity_scale == 3);
    set(&s, "volumes.a.segmentation.transfer.opacity_length", "0.25");
    assert_true(resolve(&s)->classes.opacity_length == 0.25);
    end(&s);
}

static void presets_and_automatic_ones_refer_to_the_smallest_spacing(void **state)
{
    setup s;
    vv_field_info info = vv_field_info_default();
    info.type = VV_TYPE_F32;
    for (int i = 0; i < 3; i++)
        info.grid.dims[i] = 5;
    info.grid.index_to_world.axis[0].x = 2;
    info.grid.index_to_world.axis[1].y = 0.5;
    begin(&s, test_field(&test_form_ramp, &info, NULL));
    assert_true(resolve(&s)->classes.opacity_length == 0.5);
    set(&s, "volumes.a.segmentation.transfer.preset", "ramp");
    assert_true(resolve(&s)->classes.opacity_length == 0.5);
    set(&s, "volumes.a.place.scale", "[10, 10, 10]");
    assert_true(fabs(resolve(&s)->classes.opacity_length - 5) < 1e-12);
    end(&s);
}

static void normalised_presets_are_stretched_over_the_range(void **state)
{
    setup s;
    begin(&s, ball());
    set(&s, "volumes.a.segmentation.transfer.preset", "ramp");
    set(&s, "volumes.a.segmentation.transfer.colormap", "gray");
    set(&s, "volumes.a.segmentation.transfer.range_lo", "-2");
    set(&s, "volumes.a.segmentation.transfer.range_hi", "6");
    const vv_actor *a = resolve(&s);
    assert_true(a->classes.opacity[0] == -2 && a->classes.opacity[2] == 6 && a->classes.opacity[1] == 0);
    assert_true(a->classes.color[0] == -2 && a->classes.color[4 * (a->classes.n_color - 1)] == 6);
    assert_true(a->classes.color[1] < 1e-3 && a->classes.color[4 * (a->classes.n_color - 1) + 1] > 0.99);
    end(&s);
}

static void wrong_words_are_answered_with_their_path(void **state)
{
    setup s;
    begin(&s, ball());
    set(&s, "volumes.a.segmentation.transfer.preset", "bonne");
    refused(&s, VV_E_NOT_FOUND, "volumes.a.segmentation.transfer.preset");
    assert_non_null(strstr(vv_error_last()->message, "'bone'"));
    set(&s, "volumes.a.segmentation.transfer.preset", "null");
    set(&s, "volumes.a.segmentation.transfer.colormap", "viridi");
    refused(&s, VV_E_NOT_FOUND, "volumes.a.segmentation.transfer.colormap");
    set(&s, "volumes.a.segmentation.transfer.colormap", "null");
    set(&s, "volumes.a.segmentation.transfer.range_lo", "5");
    set(&s, "volumes.a.segmentation.transfer.range_hi", "5");
    refused(&s, VV_E_ARGUMENT, "volumes.a.segmentation.transfer.range_hi");
    set(&s, "volumes.a.segmentation.transfer.range_hi", "9");
    set(&s, "volumes.a.component", "1");
    refused(&s, VV_E_ARGUMENT, "volumes.a.component");
    set(&s, "volumes.a.component", "0");
    set(&s, "volumes.a.data", "b");
    refused(&s, VV_E_NOT_FOUND, "volumes.a.data");
    set(&s, "volumes.a.data", "null"); /* the only one */
    set(&s, "volumes.a.frame", "3");
    refused(&s, VV_E_NOT_FOUND, "volumes.a");
    set(&s, "volumes.a.frame", "0");
    set(&s, "volumes.a.segmentation.kind", "threshold");
    set(&s, "volumes.a.segmentation.threshold.lo", "3");
    set(&s, "volumes.a.segmentation.threshold.hi", "2");
    refused(&s, VV_E_ARGUMENT, "volumes.a.segmentation.threshold.hi");
    set(&s, "volumes.a.segmentation.threshold.hi", "4");
    set(&s, "views.main.camera.eye", "[1, 2, 3]");
    set(&s, "views.main.camera.at", "[1, 2, 3]");
    refused(&s, VV_E_ARGUMENT, "views.main.camera.eye");
    set(&s, "views.main.camera.at", "[1, 2, 9]");
    resolve(&s);
    end(&s);
}

static void regions_whose_sides_stand_the_wrong_way_round_are_refused(void **state)
{
    static const struct {
        const char *region, *path;
    } wrong[] = {
        {"[{\"value_lo\": 9, \"value_hi\": 2}]", "regions.0.value_hi: 2 is below value_lo, which is 9"},
        {"[{\"value_lo\": 9}]", "regions.0.value_hi"},
        {"[{}, {\"top_lo\": 3, \"top_hi\": 2}]", "regions.1.top_hi"},
        {"[{\"gradient_lo\": 3, \"gradient_hi\": 2}]", "regions.0.gradient_hi"},
    };
    setup s;
    begin(&s, ball());
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        set(&s, "volumes.a.segmentation.transfer.regions", wrong[i].region);
        refused(&s, VV_E_ARGUMENT, wrong[i].path);
    }
    set(&s, "volumes.a.segmentation.transfer.regions", "[{\"value_lo\": 4, \"value_hi\": 4, \"top_hi\": 9}]");
    resolve(&s); /* a triangle: one end is a point */
    end(&s);
}

static void an_unknown_view_is_answered_with_a_real_one(void **state)
{
    setup s;
    vv_scene *scene = NULL;
    begin(&s, ball());
    assert_int_equal(vv_scene_resolve(&scene, (vv_world *)s.world, "side", s.job), VV_E_NOT_FOUND);
    assert_non_null(strstr(vv_error_last()->message, "'main'"));
    end(&s);
}

static void thresholds_start_at_the_best_split_and_are_solid(void **state)
{
    setup s;
    begin(&s, ball());
    set(&s, "volumes.a.segmentation.kind", "threshold");
    const vv_actor *a = resolve(&s);
    assert_true(a->classes.lo > a->statistics->min && a->classes.lo < a->statistics->max);
    assert_true(a->classes.hi == a->statistics->max && a->iso == a->classes.lo);
    set(&s, "volumes.a.segmentation.threshold.lo", "2.5");
    a = resolve(&s);
    assert_true(a->classes.lo == 2.5 && a->iso == 2.5);
    end(&s);
}

static void labels_are_nearest_and_the_rest_linear_unless_said(void **state)
{
    static const int64_t cube[3] = {4, 4, 4}, slice[3] = {4, 4, 1};
    setup s;
    begin(&s, bytes(cube, VV_MEANING_SCALAR, VV_SPACE_PLAIN, numbered));
    assert_false(resolve(&s)->nearest);
    set(&s, "volumes.a.interpolation", "nearest");
    assert_true(resolve(&s)->nearest);
    end(&s);
    begin(&s, bytes(cube, VV_MEANING_LABEL, VV_SPACE_PLAIN, numbered));
    assert_true(resolve(&s)->nearest && s.scene->actors[0].classes.kind == VV_SEGMENT_LABELS);
    end(&s);
    begin(&s, bytes(slice, VV_MEANING_SCALAR, VV_SPACE_PLAIN, numbered));
    assert_true(resolve(&s)->nearest);
    end(&s);
}

static void shading_comes_from_the_volume_then_the_world_then_the_default(void **state)
{
    setup s;
    begin(&s, ball());
    const float plain = resolve(&s)->diffuse;
    assert_true(plain > 0);
    set(&s, "shading.diffuse", "0.125");
    set(&s, "shading.specular", "0.5");
    set(&s, "shading.model", "phong");
    set(&s, "volumes.a.shading.specular", "0.75");
    const vv_actor *a = resolve(&s);
    assert_true(a->diffuse == 0.125f && a->specular == 0.75f && a->shading_model == VV_SHADING_PHONG);
    set(&s, "shading.diffuse", "null");
    assert_true(resolve(&s)->diffuse == plain);
    end(&s);
}

/* A plane given in the data's space keeps the same points wherever the volume stands. */
static void cut_planes_go_with_their_volume_and_global_ones_stay(void **state)
{
    const uint64_t seed = test_seed();
    setup s;
    begin(&s, ball());
    const vv_property_context context = vvi_registry_context(&s.registry);
    assert_int_equal(vv_path_add(&s.world, "cut_planes", NULL, "{\"normal\": [0, 0, 2], \"offset\": 3}", &context),
                     VV_OK);
    assert_int_equal(
        vv_path_add(&s.world, "volumes.a.cut_planes", NULL, "{\"normal\": [1, 2, 2], \"offset\": 7}", &context), VV_OK);
    assert_int_equal(vv_path_add(&s.world, "cut_planes", NULL, "{\"on\": false, \"normal\": [1, 0, 0]}", &context),
                     VV_OK);
    set(&s, "volumes.a.place.matrix", "[[0, -2, 0.5, 4], [3, 0, 0, -5], [0, 0.25, 1, 6]]");
    const vv_actor *a = resolve(&s);
    const vv_affine place = {{{0, 3, 0}, {-2, 0, 0.25}, {0.5, 0, 1}}, {4, -5, 6}};
    assert_int_equal(a->n_planes, 2);
    assert_true(a->planes[0].normal.z == 1 && a->planes[0].offset == 3);
    assert_true(fabs(vvi_length(a->planes[1].normal) - 1) < 1e-12);
    for (uint64_t i = 0; i < 300; i++) {
        const vv_vec3 p = {20 * test_random_unit(seed, 3 * i) - 5, 20 * test_random_unit(seed, 3 * i + 1) - 5,
                           20 * test_random_unit(seed, 3 * i + 2) - 5};
        const double here = (p.x + 2 * p.y + 2 * p.z) / 3 - 7;
        const double there = vvi_dot(a->planes[1].normal, vv_affine_point(place, p)) - a->planes[1].offset;
        assert_int_equal(here >= 0, there >= 0);
    }
    end(&s);
}

static void volumes_stand_where_their_place_says(void **state)
{
    setup s;
    begin(&s, ball());
    set(&s, "volumes.a.place.position", "[100, 0, 0]");
    set(&s, "views.main.camera.fit", "\"data\"");
    const vv_actor *a = resolve(&s);
    const vv_vec3 p = vv_affine_point(a->index_to_world, vvi_vec(1, 2, 3));
    assert_true(fabs(p.x - 101) < 1e-12 && fabs(p.y - 2) < 1e-12 && fabs(p.z - 3) < 1e-12);
    assert_true(fabs(vvi_dot(vvi_sub(vvi_vec(108, 8, 8), s.scene->lens.eye), s.scene->lens.right)) < 1e-9);
    end(&s);
}

static void units_are_brought_to_the_worlds(void **state)
{
    vv_field_info info = vv_field_info_default();
    setup s;
    info.type = VV_TYPE_F32;
    for (int i = 0; i < 3; i++)
        info.grid.dims[i] = 3;
    strcpy(info.grid.unit, "mm");
    begin(&s, test_field(&test_form_ramp, &info, NULL));
    assert_true(resolve(&s)->index_to_world.axis[0].x == 1);
    set(&s, "unit", "um");
    assert_true(fabs(resolve(&s)->index_to_world.axis[0].x - 1000) < 1e-9);
    set(&s, "unit", "voxels");
    assert_true(resolve(&s)->index_to_world.axis[0].x == 1);
    end(&s);
}

static void hidden_volumes_are_left_out_and_others_are_all_passed(void **state)
{
    setup s;
    begin(&s, ball());
    const vv_property_context context = vvi_registry_context(&s.registry);
    assert_int_equal(vv_path_add(&s.world, "volumes", "b", "{\"data\": \"a\"}", &context), VV_OK);
    resolve(&s);
    assert_int_equal(s.scene->n_actors, 2);
    assert_string_equal(s.scene->actors[1].id, "b");
    set(&s, "volumes.a.visible", "false");
    resolve(&s);
    assert_int_equal(s.scene->n_actors, 1);
    set(&s, "volumes.b.visible", "false");
    resolve(&s);
    assert_int_equal(s.scene->n_actors, 0);
    end(&s);
}

static void lights_are_brought_to_the_world_and_ambient_ones_summed(void **state)
{
    setup s;
    begin(&s, ball());
    set(&s, "ambient", "[0.25, 0.25, 0.25]");
    set(&s, "lights.fill.kind", "ambient");
    set(&s, "lights.fill.intensity", "0.5");
    set(&s, "lights.fill.color", "[1, 0.5, 0]");
    set(&s, "lights.key.kind", "spot");
    set(&s, "lights.key.position", "[1, 2, 3]");
    set(&s, "lights.key.direction", "[0, 0, -2]");
    set(&s, "lights.key.cone", "60");
    resolve(&s);
    const vv_lamp *lamp = &s.scene->lamps[0];
    const vv_lens *lens = &s.scene->lens;
    assert_int_equal(s.scene->n_lamps, 1);
    assert_true(s.scene->ambient[0] == 0.75f && s.scene->ambient[1] == 0.5f && s.scene->ambient[2] == 0.25f);
    assert_true(vvi_length(vvi_sub(lamp->direction, lens->forward)) < 1e-12);
    const vv_vec3 from_eye = vvi_sub(lamp->position, lens->eye);
    assert_true(fabs(vvi_dot(from_eye, lens->up) - 2) < 1e-9 && fabs(vvi_dot(from_eye, lens->forward) + 3) < 1e-9);
    assert_true(fabs(lamp->cos_outer - cos(M_PI / 6)) < 1e-12 && lamp->cos_inner > lamp->cos_outer);
    set(&s, "lights.key.frame", "world");
    resolve(&s);
    assert_true(s.scene->lamps[0].position.y == 2 && s.scene->lamps[0].direction.z == -1);
    set(&s, "lights.key.direction", "[0, 0, 0]");
    refused(&s, VV_E_ARGUMENT, "lights.key.direction");
    set(&s, "lights.key.on", "false");
    resolve(&s);
    assert_int_equal(s.scene->n_lamps, 0);
    end(&s);
}

static void a_world_without_lights_is_lit_as_the_default_one(void **state)
{
    vv_lamp before[2];
    setup s;
    begin(&s, ball());
    const vv_property_context context = vvi_registry_context(&s.registry);
    resolve(&s);
    assert_int_equal(s.scene->n_lamps, 2);
    memcpy(before, s.scene->lamps, sizeof before);
    assert_int_equal(vv_path_remove(&s.world, "lights.key", &context), VV_OK);
    assert_int_equal(vv_path_remove(&s.world, "lights.fill", &context), VV_OK);
    resolve(&s);
    assert_int_equal(s.scene->n_lamps, 2);
    for (int i = 0; i < 2; i++) {
        assert_true(vvi_length(vvi_sub(before[i].direction, s.scene->lamps[i].direction)) < 1e-12);
        assert_true(before[i].color[0] == s.scene->lamps[i].color[0]);
    }
    end(&s);
}

static void backgrounds_are_premultiplied(void **state)
{
    setup s;
    begin(&s, ball());
    set(&s, "background", "[1, 0.5, 0, 0.5]");
    resolve(&s);
    assert_true(s.scene->background[0] == 0.5f && s.scene->background[1] == 0.25f && s.scene->background[3] == 0.5f);
    end(&s);
}

static void assert_same_rows(const double *a, const double *b, size_t n)
{
    for (size_t i = 0; i < n; i++)
        assert_true(a[i] == b[i]);
}

/* Everything that decides pixels, after it was written back and worked out again. */
static void a_fixed_world_resolves_to_the_same_scene(void **state)
{
    static const char *const cameras[] = {"{}", "{\"roll\": 25, \"zoom\": 1.5, \"elevation\": 90}",
                                          "{\"projection\": \"parallel\", \"azimuth\": 40}"};
    static const char *const kinds[] = {"transfer", "threshold", "labels"};
    for (int round = 0; round < 9; round++) {
        setup s;
        vv_world *fixed = NULL;
        vv_scene *again = NULL;
        begin(&s, ball());
        const vv_property_context context = vvi_registry_context(&s.registry);
        assert_int_equal(vv_path_remove(&s.world, "lights.key", &context), VV_OK);
        assert_int_equal(vv_path_remove(&s.world, "lights.fill", &context), VV_OK);
        set(&s, "views.main.camera", cameras[round % 3]);
        set(&s, "volumes.a.segmentation.kind", kinds[round / 3]);
        const vv_actor *a = resolve(&s);
        assert_int_equal(vv_scene_fix(&fixed, s.scene), VV_OK);
        assert_true(vv_object_is_set(vv_path_object(&fixed->base, "views.main.camera"), "eye"));
        assert_int_equal(vv_scene_resolve(&again, fixed, NULL, s.job), VV_OK);
        const vv_actor *b = &again->actors[0];
        assert_int_equal(a->classes.kind, b->classes.kind);
        assert_int_equal(a->classes.n_opacity, b->classes.n_opacity);
        assert_same_rows(a->classes.opacity, b->classes.opacity, 2 * a->classes.n_opacity);
        if (a->classes.kind == VV_SEGMENT_TRANSFER)
            assert_same_rows(a->classes.color, b->classes.color, 4 * a->classes.n_color);
        assert_true(a->classes.opacity_length == b->classes.opacity_length && a->classes.lo == b->classes.lo);
        assert_true(a->nearest == b->nearest && a->iso == b->iso);
        const vv_lens *l = &s.scene->lens, *m = &again->lens;
        assert_true(vvi_length(vvi_sub(l->eye, m->eye)) < 1e-9 && vvi_length(vvi_sub(l->up, m->up)) < 1e-12);
        assert_true(fabs(l->half_height - m->half_height) < 1e-9 * l->half_height && l->parallel == m->parallel);
        assert_true(((const no_params *)again->params)->iso == a->iso);
        assert_int_equal(s.scene->n_lamps, again->n_lamps);
        for (size_t i = 0; i < again->n_lamps; i++)
            assert_true(vvi_length(vvi_sub(s.scene->lamps[i].direction, again->lamps[i].direction)) < 1e-9);
        vv_scene_release(again);
        vv_object_release(&fixed->base);
        end(&s);
    }
}

/* Of real data the fitted transfer function shows the object and not the air; shares were judged on pictures. */
static void fitted_functions_show_the_object_of_real_data(void **state)
{
    static const struct {
        const char *name;
        double least, most; /* share of the samples that are visible */
        double iso_least, iso_most;
    } cases[] = {
        {"volumes/lobster_301x324x56_u8.nhdr", 0.03, 0.12, 30, 90}, /* without the block of resin */
        {"volumes/engine_256x256x256_u8.nhdr", 0.05, 0.15, 40, 110},
        {"volumes/tooth.nhdr", 0.2, 0.4, 550, 800},
        {"volumes/neuron_409x415x119_u8.nhdr", 0.0005, 0.001, 20, 150},
        {"volumes/mra_head_256x256x256_u8.nhdr", 0.2, 0.35, 20, 80},
        {"volumes/CT_AVM.nii.gz", 0.01, 0.06, 50, 250},
    };
    const char *root = getenv("VOLVIS_SHARED");
    size_t seen = 0;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        char path[1024];
        vv_world *world = NULL;
        setup s;
        snprintf(path, sizeof path, "%s/data/%s", root ? root : VOLVIS_SHARED_DIR, cases[i].name);
        if (access(path, R_OK) != 0) {
            print_message("%s is not there: skipped\n", path);
            continue;
        }
        begin(&s, ball());
        vv_object_release(s.world);
        assert_int_equal(vv_world_for_file(&world, path, NULL, s.job), VV_OK);
        s.world = &world->base;
        const vv_actor *a = resolve(&s);
        const vv_statistics *t = a->statistics;
        const double width = (t->histogram_hi - t->histogram_lo) / t->n_bins;
        double visible = 0;
        for (int b = 0; b < t->n_bins; b++) {
            double rgbk[4];
            vvi_transfer_evaluate(rgbk, &a->classes, t->histogram_lo + (b + 0.5) * width);
            visible += rgbk[3] > 0 ? (double)t->histogram[b] / (double)t->count : 0;
        }
        if (visible < cases[i].least || visible > cases[i].most || a->iso < cases[i].iso_least ||
            a->iso > cases[i].iso_most)
            fail_msg("%s: %g of the samples are visible, iso is %g", cases[i].name, visible, a->iso);
        seen++;
        end(&s);
    }
    if (!seen)
        skip();
}

static vv_status resolve_and_fix(void *user)
{
    setup *s = user;
    vv_scene *scene = NULL;
    vv_world *fixed = NULL;
    vv_status st = vv_scene_resolve(&scene, (vv_world *)s->world, NULL, s->job);
    if (st == VV_OK)
        st = vv_scene_fix(&fixed, scene);
    if (fixed)
        vv_object_release(&fixed->base);
    vv_scene_release(scene);
    return st;
}

static void any_allocation_may_fail(void **state)
{
    const vv_property_context context = vvi_registry_context(NULL);
    setup s;
    begin(&s, ball());
    assert_int_equal(vv_path_add(&s.world, "cut_planes", NULL, "{\"normal\": [0, 0, 2]}", &context), VV_OK);
    assert_true(test_fail_each_alloc(resolve_and_fix, &s) > 5);
    end(&s);
}

static bool finite_vec(vv_vec3 v)
{
    return isfinite(v.x) && isfinite(v.y) && isfinite(v.z);
}

/* Whatever the tables allow is worked out or refused with a sentence. */
static void random_properties_give_a_finite_scene_or_an_error(void **state)
{
    static const char *const paths[] = {"views.main.camera", "volumes.a.segmentation", "volumes.a.shading",
                                        "volumes.a.place", "lights.key"};
    test_dice dice = {test_seed(), 0};
    int good = 0;
    for (int round = 0; round < 400; round++) {
        setup s;
        vv_scene *scene = NULL;
        begin(&s, ball());
        const vv_property_context context = vvi_registry_context(&s.registry);
        for (int i = 0; i < 5; i++) {
            vv_object *part = vv_object_retain(vv_path_object(s.world, paths[i]));
            if (test_roll(&dice, 3) == 0)
                test_roll_object(&dice, &part, 40, &context);
            assert_int_equal(vv_path_put(&s.world, paths[i], part, &context), VV_OK);
            vv_object_release(part);
        }
        if (vv_scene_resolve(&scene, (vv_world *)s.world, NULL, s.job) == VV_OK) {
            const vv_lens *l = &scene->lens;
            assert_true(finite_vec(l->forward) && finite_vec(l->up) && finite_vec(l->right) && finite_vec(l->eye));
            assert_true(l->half_height > 0 && l->half_width > 0 && isfinite(l->half_height));
            for (size_t i = 0; i < scene->n_lamps; i++)
                assert_true(finite_vec(scene->lamps[i].direction));
            good++;
        } else {
            assert_true(strlen(vv_error_last()->message) > 10);
        }
        vv_scene_release(scene);
        end(&s);
    }
    assert_true(good > 100);
}

/* The best one, else the first that takes all, else the first. */
static void a_method_is_chosen_by_what_is_seen(void **state)
{
    static const vv_renderer a = {.name = "a", .takes = VV_CONTENT_SAMPLES};
    static const vv_renderer b = {.name = "b", .takes = VV_CONTENT_SAMPLES | VV_CONTENT_MESHES};
    static const vv_renderer c = {.name = "c", .takes = VV_CONTENT_MESHES, .best_for = VV_CONTENT_MESHES};
    static const vv_renderer *const all[] = {&a, &b, &c, NULL}, *const few[] = {&a, &c, NULL};
    const vv_registry two = {.renderers = few}, three = {.renderers = all};
    (void)state;
    assert_ptr_equal(vv_registry_renderer_for(&three, 0), &a);
    assert_ptr_equal(vv_registry_renderer_for(&three, VV_CONTENT_SAMPLES), &a);
    assert_ptr_equal(vv_registry_renderer_for(&three, VV_CONTENT_MESHES), &c);
    assert_ptr_equal(vv_registry_renderer_for(&three, VV_CONTENT_SAMPLES | VV_CONTENT_MESHES), &b);
    assert_ptr_equal(vv_registry_renderer_for(&two, VV_CONTENT_SAMPLES | VV_CONTENT_MESHES), &a);
    assert_null(vv_registry_plane_renderer(&two));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(something_is_always_to_be_seen),
        cmocka_unit_test(a_field_of_nothing_but_nan_is_clear),
        cmocka_unit_test(typed_nodes_are_taken_and_refer_to_one_unit),
        cmocka_unit_test(presets_and_automatic_ones_refer_to_the_smallest_spacing),
        cmocka_unit_test(normalised_presets_are_stretched_over_the_range),
        cmocka_unit_test(wrong_words_are_answered_with_their_path),
        cmocka_unit_test(regions_whose_sides_stand_the_wrong_way_round_are_refused),
        cmocka_unit_test(an_unknown_view_is_answered_with_a_real_one),
        cmocka_unit_test(thresholds_start_at_the_best_split_and_are_solid),
        cmocka_unit_test(labels_are_nearest_and_the_rest_linear_unless_said),
        cmocka_unit_test(shading_comes_from_the_volume_then_the_world_then_the_default),
        cmocka_unit_test(cut_planes_go_with_their_volume_and_global_ones_stay),
        cmocka_unit_test(volumes_stand_where_their_place_says),
        cmocka_unit_test(units_are_brought_to_the_worlds),
        cmocka_unit_test(hidden_volumes_are_left_out_and_others_are_all_passed),
        cmocka_unit_test(lights_are_brought_to_the_world_and_ambient_ones_summed),
        cmocka_unit_test(a_world_without_lights_is_lit_as_the_default_one),
        cmocka_unit_test(backgrounds_are_premultiplied),
        cmocka_unit_test(a_fixed_world_resolves_to_the_same_scene),
        cmocka_unit_test(fitted_functions_show_the_object_of_real_data),
        cmocka_unit_test(any_allocation_may_fail),
        cmocka_unit_test(random_properties_give_a_finite_scene_or_an_error),
        cmocka_unit_test(a_method_is_chosen_by_what_is_seen),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
