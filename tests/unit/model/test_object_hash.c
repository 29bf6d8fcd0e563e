/* Hashes of parts of a World. */
#include "model/context.h"
#include "model/object_hash.h"
#include "worlds.h"
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static vv_property_context context;

static vv_object *new_world(void)
{
    vv_object *world;
    context = vvi_registry_context(vv_registry_builtin());
    assert_int_equal(vv_object_new(&world, &vv_world_class, &context), VV_OK);
    return world;
}

static void set(vv_object **world, const char *path, const char *json)
{
    if (vv_path_set(world, path, json, &context) != VV_OK)
        fail_msg("%s", vv_error_last()->message);
}

/* Written out by hand after the rule: FNV-1a over lengths, names and values, 8 bytes each, the lowest first. */
static uint64_t fnv(const void *data, size_t n, uint64_t seed)
{
    const uint8_t *u = data;
    uint64_t h = UINT64_C(14695981039346656037) ^ seed;
    for (size_t i = 0; i < n; i++)
        h = (h ^ u[i]) * UINT64_C(1099511628211);
    return h;
}

static uint64_t fnv_number(uint64_t v, uint64_t h)
{
    uint8_t u[8];
    for (int i = 0; i < 8; i++)
        u[i] = (uint8_t)(v >> 8 * i);
    return fnv(u, 8, h);
}

static uint64_t fnv_text(const char *s, uint64_t h)
{
    return s ? fnv(s, strlen(s), fnv_number(strlen(s), h)) : fnv("", 0, fnv_number(UINT64_MAX, h));
}

static void the_hash_is_what_its_rule_says_on_any_machine(void **state)
{
    vv_object *world = new_world();
    (void)state;
    set(&world, "views.main", "{\"width\": 640}");
    uint64_t expected = fnv_text("view", 0);
    expected = fnv_number(640, fnv_text("width", expected));
    expected = fnv_text(NULL, expected);
    const uint64_t found = vvi_object_hash(vv_path_object(world, "views.main"), NULL, 0);
    assert_true(found == expected);
    vv_object_release(world);
}

/* Whatever is set: another value is another hash, and what was there before has the hash that it had. */
static void objects_are_equal_where_their_hashes_are(void **state)
{
    test_dice dice = {.seed = 1994};
    (void)state;
    vv_object_release(new_world()); /* which makes the context */
    vv_object *world = test_roll_world(&dice, 40, &context);
    for (int i = 0; i < 300; i++) {
        const vv_property *row;
        char *path = test_roll_path(&dice, &row, world), *json = test_roll_value(&dice, row, &context);
        vv_object *other = vv_object_retain(world);
        if (vv_path_set(&other, path, json, &context) == VV_OK) {
            const bool same = vvi_object_hash(world, NULL, 0) == vvi_object_hash(other, NULL, 0);
            if (same != vv_object_equal(world, other))
                fail_msg("%s = %s", path, json);
        }
        vv_object_release(other);
        free(path);
        free(json);
    }
    vv_object_release(world);
}

static bool leaves_title(const void *user, const vv_object *owner, const vv_property *row)
{
    return !strcmp(row->name, user);
}

static void what_a_reference_leads_to_counts_and_not_its_name(void **state)
{
    vv_object *a = new_world(), *b = new_world();
    (void)state;
    set(&a, "datasets.x", "{\"format\": \"nrrd\", \"title\": \"one\"}");
    set(&a, "volumes.v", "{\"data\": \"x\"}");
    set(&b, "datasets.y", "{\"format\": \"nrrd\", \"title\": \"other\"}");
    set(&b, "volumes.v", "{\"data\": \"y\"}");
    vvi_hash_rules of_a = {.leaves_out = leaves_title, .user = "title", .world = (vv_world *)a};
    vvi_hash_rules of_b = {.leaves_out = leaves_title, .user = "title", .world = (vv_world *)b};
    const vv_object *va = vv_path_object(a, "volumes.v"), *vb = vv_path_object(b, "volumes.v");
    assert_true(vvi_object_hash(va, &of_a, 0) == vvi_object_hash(vb, &of_b, 0));
    assert_true(vvi_object_hash(va, NULL, 0) != vvi_object_hash(vb, NULL, 0)); /* references as names */
    set(&b, "datasets.y.format", "\"nifti\"");
    of_b.world = (vv_world *)b;
    assert_true(vvi_object_hash(va, &of_a, 0) != vvi_object_hash(vv_path_object(b, "volumes.v"), &of_b, 0));
    vv_object_release(a);
    vv_object_release(b);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_hash_is_what_its_rule_says_on_any_machine),
        cmocka_unit_test(objects_are_equal_where_their_hashes_are),
        cmocka_unit_test(what_a_reference_leads_to_counts_and_not_its_name),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
