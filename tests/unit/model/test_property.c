/* The property engine on the model's classes: paths, JSON, copy on write, errors. */
#include "model/context.h"
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static vv_object *new_world(void)
{
    vv_object *world = NULL;
    const vv_property_context context = vvi_registry_context(NULL);
    assert_int_equal(vv_object_new(&world, &vv_world_class, &context), VV_OK);
    return world;
}

static void set(vv_object **world, const char *path, const char *json)
{
    const vv_property_context context = vvi_registry_context(NULL);
    if (vv_path_set(world, path, json, &context) != VV_OK)
        fail_msg("%s", vv_error_last()->message);
}

static void expect(const vv_object *world, const char *path, const char *json)
{
    char *got = NULL;
    if (vv_path_get(&got, world, path) != VV_OK)
        fail_msg("%s", vv_error_last()->message);
    assert_string_equal(got, json);
    free(got);
}

/* What is known follows in the sentence. */
static void expect_begin(const char *message)
{
    if (strncmp(vv_error_last()->message, message, strlen(message)) != 0)
        assert_string_equal(vv_error_last()->message, message);
}

static void expect_error(vv_object **world, const char *path, const char *json, const char *message)
{
    const vv_property_context context = vvi_registry_context(NULL);
    vv_object *before = *world;
    assert_int_not_equal(vv_path_set(world, path, json, &context), VV_OK);
    expect_begin(message);
    assert_ptr_equal(*world, before);
}

static void add(vv_object **world, const char *path, const char *id, const char *json)
{
    const vv_property_context context = vvi_registry_context(NULL);
    if (vv_path_add(world, path, id, json, &context) != VV_OK)
        fail_msg("%s", vv_error_last()->message);
}

static char *print(const vv_object *object)
{
    char *json = NULL;
    assert_int_equal(vv_object_to_json(&json, object, 0), VV_OK);
    return json;
}

static void an_empty_world_prints_as_an_empty_object(void **state)
{
    (void)state;
    vv_object *world = new_world();
    char *json = print(world);
    assert_string_equal(json, "{}");
    free(json);
    vv_object_release(world);
}

static void unset_properties_give_their_default(void **state)
{
    (void)state;
    vv_object *world = new_world();
    add(&world, "views", "main", NULL);
    expect(world, "views.main.camera.fov", "20");
    expect(world, "views.main.camera.eye", "null");
    expect(world, "shading.model", "\"blinn\"");
    expect(world, "background", "\"#000000\"");
    assert_false(vv_object_is_set(world, "background"));
    vv_object_release(world);
}

static void what_is_set_is_printed_in_table_order(void **state)
{
    (void)state;
    vv_object *world = new_world();
    set(&world, "seed", "7");
    set(&world, "title", "a head");
    add(&world, "lights", "key", "{\"intensity\": 2}");
    set(&world, "lights.key.kind", "spot");
    set(&world, "lights.key.cone", "30deg");
    char *json = print(world);
    assert_string_equal(json, "{\"title\": \"a head\", \"seed\": 7, \"lights\": {\"key\": {\"kind\": \"spot\", "
                              "\"intensity\": 2, \"cone\": 30}}}");
    free(json);
    vv_object_release(world);
}

static void an_edit_shares_what_is_not_on_its_path(void **state)
{
    (void)state;
    vv_object *world = new_world();
    add(&world, "lights", "key", NULL);
    add(&world, "views", "main", NULL);
    vv_object *before = vv_object_retain(world);
    set(&world, "lights.key.intensity", "3");
    assert_ptr_not_equal(world, before);
    assert_ptr_equal(vv_path_object(world, "views.main"), vv_path_object(before, "views.main"));
    assert_ptr_not_equal(vv_path_object(world, "lights.key"), vv_path_object(before, "lights.key"));
    expect(before, "lights.key.intensity", "1");
    expect(world, "lights.key.intensity", "3");
    vv_object_release(before);
    vv_object_release(world);
}

static void errors_name_the_path_and_the_nearest_name(void **state)
{
    (void)state;
    vv_object *world = new_world();
    add(&world, "lights", "key", NULL);
    expect_error(&world, "lights.key.intensty", "1",
                 "lights.key.intensty: unknown property 'intensty'; did you mean 'intensity'?");
    expect_error(&world, "lights.0.intensity", "1", "lights.0: entries have names and no numbers; did you mean 'key'?");
    expect_error(&world, "lights.kay.intensity", "1", "lights.kay: unknown name 'kay'; did you mean 'key'?");
    expect_error(&world, "lights.key.kind", "spott", "lights.key.kind: unknown kind 'spott'; did you mean 'spot'?");
    expect_error(&world, "lights.key.cone", "200", "lights.key.cone: 200 is out of range: expected 0 to 180 degrees");
    expect_error(&world, "lights.key.on", "7", "lights.key.on: expected true or false, found 7");
    expect_error(&world, "lights.key.on.x", "7", "lights.key.on: 'on' is a plain value: it has no properties");
    expect_error(&world, "background", "bleu",
                 "background: expected a colour such as #ff8800, #ff880080, [1, 0.5, 0] or a name of CSS such as "
                 "orange, found 'bleu'; did you "
                 "mean 'blue'?");
    assert_string_equal(vv_error_last()->where, "background");
    vv_object_release(world);
}

static void null_unsets_and_defaults_come_back(void **state)
{
    (void)state;
    vv_object *world = new_world();
    set(&world, "background", "#102030");
    expect(world, "background", "\"#102030\"");
    set(&world, "background", "#1aF");
    expect(world, "background", "\"#11aaff\"");
    set(&world, "background", "#1aF8");
    expect(world, "background", "\"#11aaff88\"");
    set(&world, "background", "null");
    expect(world, "background", "\"#000000\"");
    assert_false(vv_object_is_set(world, "background"));
    vv_object_release(world);
}

static void lists_are_addressed_by_number(void **state)
{
    (void)state;
    const vv_property_context context = vvi_registry_context(NULL);
    vv_object *world = new_world();
    add(&world, "cut_planes", NULL, "{\"offset\": 1}");
    add(&world, "cut_planes", NULL, "{\"offset\": 2}");
    set(&world, "cut_planes.1.normal", "1,0,0");
    expect(world, "cut_planes.1.normal", "[1, 0, 0]");
    assert_int_equal(vv_path_remove(&world, "cut_planes.0", &context), VV_OK);
    expect(world, "cut_planes.0.offset", "2");
    expect_error(&world, "cut_planes.1.offset", "2", "cut_planes.1: the list has 1 entries, counted from 0");
    expect_error(&world, "cut_planes.0.normal", "[0,0,0]",
                 "cut_planes.0.normal: a normal needs a direction: expected finite numbers that are not all 0");
    vv_object_release(world);
}

static void rows_are_added_to_a_table_and_a_row_alone_needs_no_brackets(void **state)
{
    (void)state;
    const vv_property_context context = vvi_registry_context(NULL);
    vv_object *world = new_world();
    add(&world, "measurements", "m", NULL);
    for (int i = 0; i < 2; i++)
        assert_int_equal(vv_path_add(&world, "measurements.m.points", NULL, i ? "[4, 5, 6]" : ".5,+2,-3.", &context),
                         VV_OK);
    expect(world, "measurements.m.points", "[[0.5, 2, -3], [4, 5, 6]]");
    assert_int_equal(vv_path_add(&world, "measurements.m.points", NULL, "1,2", &context), VV_E_ARGUMENT);
    expect_begin("measurements.m.points.2: expected a row of 3 numbers, found an array of 2");
    expect_error(&world, "measurements.m.points", "1,2,3", "measurements.m.points.0: expected a row of 3 numbers");
    for (int i = 0; i < 2; i++) {
        set(&world, "measurements.m.range", i ? "[[-1, 2.5]]" : "-1..2.5");
        expect(world, "measurements.m.range", "[[-1, 2.5]]");
    }
    expect_error(&world, "measurements.m.range", "5", "measurements.m.range: expected two numbers, as in 0..300");
    expect_error(&world, "measurements.m.range", "1,2,3",
                 "measurements.m.range: expected a row of 2 numbers, found an array of 3");
    vv_object_release(world);
}

static void a_failed_document_names_the_path(void **state)
{
    (void)state;
    static const char text[] = "{\"views\": {\"main\": {\"camera\": {\"fovv\": 3}}}}";
    vv_object *world = NULL;
    assert_int_equal(vv_object_from_json(&world, &vv_world_class, text, strlen(text), NULL), VV_E_ARGUMENT);
    assert_null(world);
    expect_begin("views.main.camera: unknown property 'fovv'; did you mean 'fov'? There are projection, ");
}

static void angles_are_degrees_outside_and_exact(void **state)
{
    (void)state;
    vv_object *world = new_world();
    add(&world, "views", "main", NULL);
    for (int i = 1; i < 1700; i++) {
        char text[32], expected[32];
        snprintf(text, sizeof text, "%d.%ddeg", i / 10, i % 10);
        snprintf(expected, sizeof expected, i % 10 ? "%d.%d" : "%d", i / 10, i % 10);
        set(&world, "views.main.camera.fov", text);
        expect(world, "views.main.camera.fov", expected);
        const vv_camera *camera = (const vv_camera *)vv_path_object(world, "views.main.camera");
        assert_true(fabs(camera->fov - i / 10.0 * M_PI / 180) < 1e-15);
    }
    vv_object_release(world);
}

static vv_status collect_path(void *user, const char *path)
{
    char *all = user;
    strcat(strcat(all, path), " ");
    return strcmp(path, "lights.b.intensity") == 0 && all[0] == '!' ? VV_E_CANCELLED : VV_OK;
}

static void stars_and_numbers_stand_for_entries(void **state)
{
    vv_object *world = new_world();
    char all[512] = "";
    set(&world, "lights.a", "{\"intensity\": 1}");
    set(&world, "lights.b", "{\"intensity\": 2}");
    assert_int_equal(vv_path_expand(world, "lights.*.intensity", collect_path, all), VV_OK);
    assert_string_equal(all, "lights.a.intensity lights.b.intensity ");
    strcpy(all, "");
    assert_int_equal(vv_path_expand(world, "lights.1.intensity", collect_path, all), VV_OK);
    assert_int_equal(vv_path_expand(world, "lights.7.intensity", collect_path, all), VV_OK);
    assert_string_equal(all, "lights.b.intensity lights.7.intensity ");
    strcpy(all, "!");
    assert_int_equal(vv_path_expand(world, "lights.*.intensity", collect_path, all), VV_E_CANCELLED);
    assert_int_equal(vv_path_expand(world, "volumes.*.visible", collect_path, all), VV_E_NOT_FOUND);
    expect_begin("volumes.*.visible: there are no volumes");
    assert_int_equal(vv_path_expand(world, "unit.*", collect_path, all), VV_E_ARGUMENT);
    vv_object_release(world);
    (void)state;
}

static void a_row_is_found_without_an_object(void **state)
{
    const vv_property_context context = vvi_registry_context(NULL);
    const vv_property *row;
    const vv_class *cls;
    assert_int_equal(vv_path_row(&row, &cls, &vv_world_class, "lights.ANY.intensity", &context), VV_OK);
    assert_string_equal(row->name, "intensity");
    assert_null(cls);
    assert_int_equal(vv_path_row(&row, &cls, &vv_world_class, "views.ANY.render.raycast.mode", &context), VV_OK);
    assert_int_equal(row->kind, VV_KIND_ENUM);
    assert_int_equal(vv_path_row(&row, &cls, &vv_world_class, "volumes", &context), VV_OK);
    assert_ptr_equal(cls, row->cls);
    assert_int_equal(vv_path_row(&row, &cls, &vv_world_class, "lights.ANY.intensty", &context), VV_E_NOT_FOUND);
    assert_non_null(strstr(vv_error_last()->message, "did you mean 'intensity'"));
    (void)state;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(an_empty_world_prints_as_an_empty_object),
        cmocka_unit_test(unset_properties_give_their_default),
        cmocka_unit_test(what_is_set_is_printed_in_table_order),
        cmocka_unit_test(an_edit_shares_what_is_not_on_its_path),
        cmocka_unit_test(errors_name_the_path_and_the_nearest_name),
        cmocka_unit_test(null_unsets_and_defaults_come_back),
        cmocka_unit_test(lists_are_addressed_by_number),
        cmocka_unit_test(rows_are_added_to_a_table_and_a_row_alone_needs_no_brackets),
        cmocka_unit_test(a_failed_document_names_the_path),
        cmocka_unit_test(angles_are_degrees_outside_and_exact),
        cmocka_unit_test(stars_and_numbers_stand_for_entries),
        cmocka_unit_test(a_row_is_found_without_an_object),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
