/* Laws of reading and writing that hold for every World: written, read and written again it is the same, bit for bit.
 */
#include "core/property_impl.h"
#include "fields.h"
#include "locales.h"
#include "model/context.h"
#include "worlds.h"

#include <locale.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static vv_object *read_back(const char *json, const vv_property_context *context)
{
    vv_object *world = NULL;
    if (vv_object_from_json(&world, &vv_world_class, json, strlen(json), context) != VV_OK)
        fail_msg("%s in %s", vv_error_last()->message, json);
    return world;
}

static char *print(const vv_object *world, int indent)
{
    char *json = NULL;
    assert_int_equal(vv_object_to_json(&json, world, indent), VV_OK);
    return json;
}

static void random_worlds_read_back_equal_bit_for_bit(void **state)
{
    (void)state;
    const vv_property_context context = vvi_registry_context(NULL);
    test_dice dice = {test_seed(), 0};
    size_t bytes = 0;
    for (int i = 0; i < 1000; i++) {
        vv_object *world = test_roll_world(&dice, 16 + i % 128, &context);
        assert_non_null(world);
        char *first = print(world, i % 5);
        vv_object *again = read_back(first, &context);
        char *second = print(again, i % 5);
        assert_string_equal(first, second);
        assert_true(vv_object_equal(world, again));
        bytes += strlen(first);
        free(first);
        free(second);
        vv_object_release(world);
        vv_object_release(again);
    }
    assert_true(bytes > 100000); /* the worlds said something */
}

static void random_worlds_survive_scene_files(void **state)
{
    (void)state;
    const vv_property_context context = vvi_registry_context(NULL);
    test_dice dice = {test_seed() + 1, 0};
    for (int i = 0; i < 200; i++) {
        vv_object *world = test_roll_world(&dice, 64, &context);
        vv_world *again = NULL;
        char *first = NULL, *second = NULL;
        assert_int_equal(vv_scene_print(&first, (const vv_world *)world, NULL), VV_OK);
        if (vv_scene_parse(&again, first, strlen(first), "test", NULL, NULL) != VV_OK)
            fail_msg("%s", vv_error_last()->message);
        assert_int_equal(vv_scene_print(&second, again, NULL), VV_OK);
        assert_string_equal(first, second);
        assert_true(vv_object_equal(world, &again->base));
        free(first);
        free(second);
        vv_object_release(world);
        vv_object_release(&again->base);
    }
}

static bool get_and_set(void *user, const char *path, const vv_property *property, const vv_object *owner)
{
    vv_object **world = user;
    const vv_property_context context = vvi_registry_context(NULL);
    char *json = NULL, *again = NULL;
    assert_int_equal(vv_path_get(&json, *world, path), VV_OK);
    if (!vv_object_is_set(owner, property->name)) {
        free(json);
        return true;
    }
    if (vv_path_set(world, path, json, &context) != VV_OK)
        fail_msg("%s", vv_error_last()->message);
    assert_int_equal(vv_path_get(&again, *world, path), VV_OK);
    assert_string_equal(json, again);
    free(json);
    free(again);
    return true;
}

static void setting_every_path_to_what_it_is_changes_nothing(void **state)
{
    (void)state;
    const vv_property_context context = vvi_registry_context(NULL);
    test_dice dice = {test_seed() + 2, 0};
    for (int i = 0; i < 30; i++) {
        vv_object *world = test_roll_world(&dice, 100, &context);
        vv_object *edited = vv_object_retain(world);
        vv_path_each(world, get_and_set, &edited);
        assert_true(vv_object_equal(world, edited));
        vv_object_release(world);
        vv_object_release(edited);
    }
}

static void degrees_of_any_radians_lose_nothing(void **state)
{
    (void)state;
    test_dice dice = {test_seed() + 3, 0};
    for (int i = 0; i < 200000; i++) {
        const double degrees = test_roll_double(&dice), radians = vvi_radians(degrees);
        const double back = vvi_degrees(radians);
        assert_true(vvi_radians(back) == radians && signbit(back) == signbit(radians));
    }
}

static void what_a_person_types_in_degrees_is_printed_as_typed(void **state)
{
    (void)state;
    for (int i = -36000; i <= 36000; i++)
        assert_true(vvi_degrees(vvi_radians(i / 100.0)) == i / 100.0);
}

static void radians_between_two_degrees_are_written_as_radians(void **state)
{
    (void)state;
    double radians = 0.7; /* where a step of the degrees is 1.1 steps of the radians */
    for (int i = 0; i < 100 && vvi_radians(vvi_degrees(radians)) == radians; i++)
        radians = nextafter(radians, 1);
    vvi_text text = {0};
    vvi_number_print(&text, radians, VV_Q_ANGLE);
    assert_non_null(strstr(text.s, "rad\""));
    assert_true(strtod(text.s + 1, NULL) == radians);
    vvi_text_free(&text);
}

static void a_locale_with_decimal_commas_changes_no_byte(void **state)
{
    (void)state;
    const vv_property_context context = vvi_registry_context(NULL);
    test_dice dice = {test_seed() + 4, 0};
    vv_object *world = test_roll_world(&dice, 128, &context);
    char *first = print(world, 2);
    if (!test_comma_locale()) {
        free(first);
        vv_object_release(world);
        print_message("no locale with decimal commas is installed, and localedef makes none: not tested\n");
        skip();
    }
    vv_object *again = read_back(first, &context);
    char *second = print(again, 2);
    setlocale(LC_ALL, "C");
    assert_string_equal(first, second);
    assert_true(vv_object_equal(world, again));
    free(first);
    free(second);
    vv_object_release(world);
    vv_object_release(again);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(random_worlds_read_back_equal_bit_for_bit),
        cmocka_unit_test(random_worlds_survive_scene_files),
        cmocka_unit_test(setting_every_path_to_what_it_is_changes_nothing),
        cmocka_unit_test(degrees_of_any_radians_lose_nothing),
        cmocka_unit_test(what_a_person_types_in_degrees_is_printed_as_typed),
        cmocka_unit_test(radians_between_two_degrees_are_written_as_radians),
        cmocka_unit_test(a_locale_with_decimal_commas_changes_no_byte),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
