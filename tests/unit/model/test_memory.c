/* Failing allocations: each one in turn, in the library and in the JSON parser. Nothing is lost, nothing leaks. */
#include "core/memory.h"
#include "fail_alloc.h"
#include "fields.h"
#include "model/context.h"
#include "worlds.h"

#include <jansson.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static const char scene[] =
    "{\"schema\": 3, \"title\": \"x\", \"unit\": \"mm\", \"fog\": {\"density\": 1}, \"background\": \"#102030\","
    "\"cut_planes\": [{\"offset\": \"1cm\"}], \"datasets\": {\"d\": {\"path\": \"a/../b.nrrd\"}},"
    "\"volumes\": {\"v\": {\"data\": \"d\", \"segmentation\": {\"transfer\": {\"opacity\": [[0, 0], [1, 1]]}}}},"
    "\"lights\": {\"key\": {\"direction\": [1, 2, 3], \"kind\": \"area\"}}, \"views\": {\"main\": {\"camera\": "
    "{\"fov\": \"20deg\"}}}}";

static vv_status parse_scene(void *user)
{
    vv_world *world = NULL;
    (void)user;
    const vv_status st = vv_scene_parse(&world, scene, strlen(scene), "scene", "folder", NULL);
    if (st == VV_OK)
        vv_object_release(&world->base);
    else
        assert_null(world);
    return st;
}

static vv_status print_scene(void *user)
{
    char *json = NULL;
    const vv_status st = vv_scene_print(&json, user, "/tmp");
    free(json);
    return st;
}

static vv_status print_schema(void *user)
{
    char *json = NULL;
    (void)user;
    const vv_status st = vv_scene_schema(&json, NULL);
    free(json);
    return st;
}

static vv_world *sample_world(void)
{
    vv_world *world = NULL;
    assert_int_equal(vv_scene_parse(&world, scene, strlen(scene), "scene", NULL, NULL), VV_OK);
    return world;
}

static void reading_a_scene_survives_any_failing_allocation(void **state)
{
    (void)state;
    assert_true(test_fail_each_alloc(parse_scene, NULL) > 50);
}

static void printing_a_scene_survives_any_failing_allocation(void **state)
{
    (void)state;
    vv_world *world = sample_world();
    test_fail_each_alloc(print_scene, world);
    vv_object_release(&world->base);
}

static void printing_the_schema_survives_any_failing_allocation(void **state)
{
    (void)state;
    test_fail_each_alloc(print_schema, NULL);
}

typedef struct edit {
    vv_object *root;
    const char *path, *json;
} edit;

/* On failure the very same root is there; on success the next try starts from it again. */
static vv_status edit_and_forget(void *user)
{
    edit *e = user;
    const vv_property_context context = vvi_registry_context(NULL);
    vv_object *root = vv_object_retain(e->root);
    const vv_status st = vv_path_set(&root, e->path, e->json, &context);
    if (st != VV_OK)
        assert_ptr_equal(root, e->root);
    vv_object_release(root);
    return st;
}

static void edits_survive_any_failing_allocation(void **state)
{
    (void)state;
    static const char *const edits[][2] = {
        {"title", "a new title"},
        {"views.main.camera.fov", "30deg"},
        {"views.main.camera.eye", "1,2,3"},
        {"views.second", "{\"width\": 7}"},
        {"volumes.v.segmentation.transfer.opacity", "[[0, 0], [3, 1]]"},
        {"lights.key.kind", "spot"},
        {"cut_planes", "[{}, {}]"},
        {"lights.key", "null"},
    };
    vv_world *world = sample_world();
    for (size_t i = 0; i < sizeof edits / sizeof *edits; i++) {
        edit e = {&world->base, edits[i][0], edits[i][1]};
        test_fail_each_alloc(edit_and_forget, &e);
    }
    vv_object_release(&world->base);
}

/* A step of a model's life; after a failure the further ones are left out, so that the first error stays. */
#define STEP(call)                                                                                                     \
    if (st == VV_OK)                                                                                                   \
    st = (call)

static vv_status live_with_a_model(void *user)
{
    vv_model *model = NULL;
    vv_status st = vv_model_new(&model, NULL);
    STEP(vv_model_set(model, "ann", "title", "x"));
    STEP(vv_model_add(model, "bob", "lights", "key", NULL));
    STEP(vv_model_begin(model, "ann"));
    STEP(vv_model_set(model, "ann", "lights.key.intensity", "2"));
    STEP(vv_model_add(model, "ann", "views", "m", NULL));
    STEP(vv_model_end(model, true));
    STEP(vv_model_attach(model, "ann", "f", user));
    STEP(vv_model_undo(model, "ann"));
    STEP(vv_model_redo(model, "ann"));
    vv_model_release(model);
    return st;
}

/* A failed edit leaves the very same World, however it failed. */
static vv_status fail_to_edit_a_model(void *user)
{
    vv_world *before = vv_model_snapshot(user);
    const vv_status st = vv_model_set(user, "ann", "lights.key.intensity", "2");
    vv_world *after = vv_model_snapshot(user);
    assert_true(st == VV_OK || before == after);
    vv_object_release(&before->base);
    vv_object_release(&after->base);
    return st;
}

static void a_models_failed_edit_changes_nothing(void **state)
{
    (void)state;
    vv_model *model = NULL;
    assert_int_equal(vv_model_new(&model, NULL), VV_OK);
    assert_int_equal(vv_model_add(model, "bob", "lights", "key", NULL), VV_OK);
    assert_true(test_fail_each_alloc(fail_to_edit_a_model, model) > 5);
    vv_model_release(model);
}

static void a_model_survives_any_failing_allocation(void **state)
{
    (void)state;
    vv_field *field = test_field_cube(&test_form_ramp, 3, 0, 1, NULL);
    test_fail_each_alloc(live_with_a_model, field);
    vv_field_release(field);
}

/* The parser's own memory --------------------------------------------------------------------------------------- */

static int parser_countdown; /* tests run one after another on one thread */

static void *parser_malloc(size_t n)
{
    return parser_countdown > 0 && --parser_countdown == 0 ? NULL : malloc(n);
}

static void the_parsers_failing_allocations_are_errors(void **state)
{
    (void)state;
    vv_status st = VV_E_MEMORY;
    int n = 0;
    json_set_alloc_funcs(parser_malloc, free);
    while (st != VV_OK && ++n < 10000) {
        parser_countdown = n;
        st = parse_scene(NULL);
        assert_true(st == VV_OK || st == VV_E_MEMORY);
        st = parser_countdown > 0 ? st : VV_E_MEMORY; /* the failing one was never reached: done */
    }
    parser_countdown = 0;
    json_set_alloc_funcs(malloc, free);
    assert_true(n > 50 && n < 10000);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(reading_a_scene_survives_any_failing_allocation),
        cmocka_unit_test(printing_a_scene_survives_any_failing_allocation),
        cmocka_unit_test(printing_the_schema_survives_any_failing_allocation),
        cmocka_unit_test(edits_survive_any_failing_allocation),
        cmocka_unit_test(a_models_failed_edit_changes_nothing),
        cmocka_unit_test(a_model_survives_any_failing_allocation),
        cmocka_unit_test(the_parsers_failing_allocations_are_errors),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
