/* How large Worlds are, and that what is kept to undo with has its limit: the oldest steps go. */
#include "core/memory.h"
#include "core/property_size.h"
#include "model/history.h"
#include "worlds.h"

#include <malloc.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { TEXT = 4000 };

static void ok(vv_status st)
{
    if (st != VV_OK)
        fail_msg("%s", vv_error_last()->message);
}

static vv_runtime *new_runtime(uint64_t undo_bytes, uint64_t memory_bytes)
{
    vv_runtime *runtime = NULL;
    vv_limits limits;
    vv_runtime_options options;
    vv_limits_init(&limits, sizeof limits);
    limits.undo_bytes = undo_bytes;
    vv_runtime_options_init(&options, sizeof options);
    options.threads = 1;
    options.memory_bytes = memory_bytes;
    options.limits = &limits;
    ok(vv_runtime_new(&runtime, &options));
    return runtime;
}

static vv_model *new_model(vv_runtime *runtime)
{
    vv_model *model = NULL;
    ok(vv_model_new(&model, runtime));
    ok(vv_model_add(model, "", "views", "main", NULL));
    return model;
}

/* Captions, each another one. */
static void set_captions(vv_model *model, const char *who, int n)
{
    char text[TEXT + 1];
    memset(text, 'x', TEXT);
    text[TEXT] = 0;
    for (int i = 0; i < n; i++) {
        snprintf(text, 16, "%d", i);
        text[strlen(text)] = ' ';
        ok(vv_model_set(model, who, "views.main.decorations.caption", text));
    }
}

static int count_undone(vv_model *model, const char *who)
{
    int n = 0;
    while (vv_model_undo(model, who) == VV_OK)
        n++;
    assert_int_equal(vv_error_last()->status, VV_E_NOT_FOUND);
    return n;
}

static void texts_are_no_longer_than_is_worked_out(void **state)
{
    (void)state;
    const vv_property_context context = {0};
    for (uint64_t seed = 0; seed < 60; seed++) {
        test_dice dice = {.seed = seed};
        char *text = NULL;
        vv_object *world = test_roll_world(&dice, (int)(seed * 4), &context);
        ok(vv_scene_print(&text, (vv_world *)(void *)world, NULL));
        const size_t n = strlen(text), most = vvi_object_text_most(world);
        assert_true(n <= most);
        assert_true(most <= 12 * n + 60000); /* variants that nobody has set cost a little too */
        free(text);
        vv_object_release(world);
    }
}

static void what_two_versions_share_is_not_counted(void **state)
{
    (void)state;
    vv_object *world = NULL;
    ok(vv_object_new(&world, &vv_world_class, NULL));
    for (int i = 0; i < 100; i++) {
        char id[16];
        snprintf(id, sizeof id, "l%d", i);
        ok(vv_path_add(&world, "lights", id, "{\"title\": \"a light\"}", NULL));
    }
    vv_object *before = vv_object_retain(world);
    const size_t whole = vvi_object_apart(world, NULL);
    assert_int_equal(vvi_object_apart(world, before), 0);
    ok(vv_path_set(&world, "lights.l50.title", "another", NULL));
    const size_t one = vvi_object_apart(before, world);
    assert_true(one > 100 && one < whole / 3);
    ok(vv_path_remove(&world, "lights.l10", NULL)); /* places of the others move */
    assert_true(vvi_object_apart(before, world) < whole / 3);
    assert_true(vvi_object_apart(world, before) < whole / 3);
    vv_object_release(before);
    vv_object_release(world);
}

static void the_oldest_steps_go_and_the_world_stays(void **state)
{
    (void)state;
    vv_runtime *runtime = new_runtime(1 << 20, (uint64_t)1 << 30);
    vv_model *model = new_model(runtime);
    uint64_t most;
    set_captions(model, "ann", 20);
    assert_int_equal(vvi_model_forgotten(model, &most), 0);
    assert_int_equal(most, 1 << 20);
    for (int i = 0; i < 10; i++) {
        set_captions(model, i % 2 ? "ann" : "bob", 200);
        assert_in_range(vvi_memory_by_tag(runtime, VVI_MEM_MODEL), 1 << 19, 1 << 20);
    }
    assert_true(vvi_model_forgotten(model, &most) > 1000);
    vv_world *world = vv_model_snapshot(model);
    const vv_view *view = (const vv_view *)(const void *)vv_collection_find(world->views, "main");
    assert_int_equal(strlen(((const vv_decorations *)(const void *)view->decorations)->caption), TEXT);
    vv_object_release(&world->base);
    assert_in_range(count_undone(model, "ann"), 20, 200);
    assert_int_equal(count_undone(model, "bob"), 0);
    vv_model_release(model);
    assert_int_equal(vv_runtime_memory_used(runtime), 0);
    vv_runtime_release(runtime);
}

static void a_runtime_with_little_memory_keeps_little(void **state)
{
    (void)state;
    vv_runtime *runtime = new_runtime((uint64_t)64 << 20, 4 << 20);
    vv_model *model = new_model(runtime);
    vv_job *job = NULL;
    set_captions(model, "", 1000);
    assert_in_range(vvi_memory_by_tag(runtime, VVI_MEM_MODEL), 1, 1 << 19);
    ok(vv_job_new(&job, runtime, NULL, NULL));
    void *others = vvi_alloc(job, (3 << 20) + (7 << 16), VVI_MEM_VOXELS);
    assert_non_null(others);
    set_captions(model, "", 100); /* hardly anything is left, and they are made all the same */
    assert_true(count_undone(model, "") >= 1);
    vvi_free(others);
    vv_job_release(job);
    vv_model_release(model);
    vv_runtime_release(runtime);
}

static size_t allocated(void)
{
    return mallinfo2().uordblks;
}

static void as_much_is_counted_as_there_is(void **state)
{
    (void)state;
    vv_runtime *runtime = new_runtime((uint64_t)1 << 30, (uint64_t)16 << 30);
    vv_model *model = new_model(runtime);
    const size_t before = allocated();
    char value[32];
    set_captions(model, "", 300);
    for (int i = 0; i < 300; i++) {
        snprintf(value, sizeof value, "%d", i);
        ok(vv_model_set(model, "", "seed", value));
        ok(vv_model_set(model, "", "views.main.camera.azimuth", value));
    }
    const size_t really = allocated() - before, counted = vvi_memory_by_tag(runtime, VVI_MEM_MODEL);
    if (before && (counted < really - really / 10 || counted > 4 * really)) /* 0: a sanitizer's heap */
        fail_msg("%zu bytes are counted of %zu", counted, really);
    vv_model_release(model);
    vv_runtime_release(runtime);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(texts_are_no_longer_than_is_worked_out),
        cmocka_unit_test(what_two_versions_share_is_not_counted),
        cmocka_unit_test(the_oldest_steps_go_and_the_world_stays),
        cmocka_unit_test(a_runtime_with_little_memory_keeps_little),
        cmocka_unit_test(as_much_is_counted_as_there_is),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
