/* The model: commits, transactions, undo and redo, watchers, snapshots beside edits. */
#include "fields.h"
#include "model/context.h"
#include "worlds.h"

#include <pthread.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static vv_model *new_model(void)
{
    vv_model *model = NULL;
    assert_int_equal(vv_model_new(&model, NULL), VV_OK);
    return model;
}

static void ok(vv_status st)
{
    if (st != VV_OK)
        fail_msg("%s", vv_error_last()->message);
}

static char *print(vv_model *model)
{
    char *json = NULL;
    vv_world *world = vv_model_snapshot(model);
    ok(vv_object_to_json(&json, &world->base, 0));
    vv_object_release(&world->base);
    return json;
}

static void expect(vv_model *model, const char *json)
{
    char *found = print(model);
    assert_string_equal(found, json);
    free(found);
}

static void undo_takes_back_the_last_commit_and_redo_makes_it_again(void **state)
{
    (void)state;
    vv_model *model = new_model();
    ok(vv_model_set(model, NULL, "title", "one"));
    ok(vv_model_set(model, NULL, "title", "two"));
    ok(vv_model_undo(model, NULL));
    expect(model, "{\"title\": \"one\"}");
    ok(vv_model_undo(model, NULL));
    expect(model, "{}");
    assert_int_equal(vv_model_undo(model, NULL), VV_E_NOT_FOUND);
    ok(vv_model_redo(model, NULL));
    ok(vv_model_redo(model, NULL));
    expect(model, "{\"title\": \"two\"}");
    assert_int_equal(vv_model_redo(model, NULL), VV_E_NOT_FOUND);
    vv_model_release(model);
}

static void undo_leaves_what_others_have_committed_since(void **state)
{
    (void)state;
    vv_model *model = new_model();
    ok(vv_model_add(model, "ann", "lights", "key", NULL));
    ok(vv_model_set(model, "ann", "lights.key.intensity", "2"));
    ok(vv_model_set(model, "bob", "lights.key.kind", "spot"));
    ok(vv_model_set(model, "bob", "title", "by bob"));
    ok(vv_model_undo(model, "ann"));
    expect(model, "{\"title\": \"by bob\", \"lights\": {\"key\": {\"kind\": \"spot\"}}}");
    ok(vv_model_undo(model, "bob"));
    expect(model, "{\"lights\": {\"key\": {\"kind\": \"spot\"}}}");
    ok(vv_model_redo(model, "ann"));
    expect(model, "{\"lights\": {\"key\": {\"kind\": \"spot\", \"intensity\": 2}}}");
    assert_int_equal(vv_model_undo(model, "cid"), VV_E_NOT_FOUND);
    vv_model_release(model);
}

static void undo_of_what_another_has_set_since_waits_for_him(void **state)
{
    (void)state;
    vv_model *model = new_model();
    ok(vv_model_set(model, "ann", "title", "by ann"));
    ok(vv_model_set(model, "bob", "title", "by bob"));
    ok(vv_model_undo(model, "ann"));
    expect(model, "{\"title\": \"by bob\"}");
    ok(vv_model_undo(model, "bob"));
    expect(model, "{}");
    ok(vv_model_redo(model, "bob"));
    ok(vv_model_redo(model, "ann"));
    expect(model, "{\"title\": \"by bob\"}");
    ok(vv_model_undo(model, "bob"));
    expect(model, "{\"title\": \"by ann\"}");
    vv_model_release(model);
}

static void undo_passes_by_what_another_has_removed(void **state)
{
    (void)state;
    vv_model *model = new_model();
    ok(vv_model_add(model, "ann", "lights", "key", NULL));
    ok(vv_model_set(model, "cid", "title", "x"));
    ok(vv_model_set(model, "cid", "lights.key.intensity", "2"));
    ok(vv_model_remove(model, "bob", "lights.key"));
    ok(vv_model_undo(model, "cid"));
    expect(model, "{}");
    assert_int_not_equal(vv_model_undo(model, "cid"), VV_OK);
    assert_non_null(strstr(vv_error_last()->message, "key"));
    ok(vv_model_undo(model, "bob"));
    expect(model, "{\"lights\": {\"key\": {\"intensity\": 2}}}");
    ok(vv_model_undo(model, "cid"));
    expect(model, "{\"lights\": {\"key\": {}}}");
    vv_model_release(model);
}

static void a_new_commit_ends_what_can_be_redone(void **state)
{
    (void)state;
    vv_model *model = new_model();
    ok(vv_model_set(model, "ann", "title", "one"));
    ok(vv_model_undo(model, "ann"));
    ok(vv_model_set(model, "ann", "seed", "3"));
    assert_int_equal(vv_model_redo(model, "ann"), VV_E_NOT_FOUND);
    expect(model, "{\"seed\": 3}");
    vv_model_release(model);
}

static void a_removed_entry_comes_back_at_its_place(void **state)
{
    (void)state;
    vv_model *model = new_model();
    ok(vv_model_add(model, NULL, "lights", "a", NULL));
    ok(vv_model_add(model, NULL, "lights", "b", "{\"seed\": 1}") == VV_E_ARGUMENT ? VV_OK : VV_E_INTERNAL);
    ok(vv_model_add(model, NULL, "lights", "b", "{\"intensity\": 3}"));
    ok(vv_model_add(model, NULL, "lights", "c", NULL));
    char *before = print(model);
    ok(vv_model_remove(model, NULL, "lights.b"));
    ok(vv_model_undo(model, NULL));
    expect(model, before);
    free(before);
    vv_model_release(model);
}

static void a_transaction_is_one_commit_or_none(void **state)
{
    (void)state;
    vv_model *model = new_model();
    ok(vv_model_begin(model, "ann"));
    ok(vv_model_set(model, "ann", "title", "x"));
    ok(vv_model_add(model, "ann", "lights", "key", NULL));
    ok(vv_model_set(model, "ann", "lights.key.intensity", "2"));
    assert_int_equal(vv_model_set(model, "bob", "seed", "1"), VV_E_ARGUMENT);
    assert_int_equal(vv_model_begin(model, "bob"), VV_E_ARGUMENT);
    assert_int_equal(vv_model_undo(model, "ann"), VV_E_ARGUMENT);
    ok(vv_model_end(model, true));
    expect(model, "{\"title\": \"x\", \"lights\": {\"key\": {\"intensity\": 2}}}");
    ok(vv_model_begin(model, "ann"));
    ok(vv_model_remove(model, "ann", "lights.key"));
    ok(vv_model_end(model, false));
    expect(model, "{\"title\": \"x\", \"lights\": {\"key\": {\"intensity\": 2}}}");
    ok(vv_model_undo(model, "ann"));
    expect(model, "{}");
    ok(vv_model_redo(model, "ann"));
    expect(model, "{\"title\": \"x\", \"lights\": {\"key\": {\"intensity\": 2}}}");
    assert_int_equal(vv_model_end(model, true), VV_E_ARGUMENT);
    vv_model_release(model);
}

typedef struct diary {
    vv_model *model;
    char text[512];
    vv_status tried;
} diary;

static void note_commit(void *user, const vv_commit *commit, const vv_world *world)
{
    diary *d = user;
    const size_t n = strlen(d->text);
    snprintf(d->text + n, sizeof d->text - n, "%d %s", (int)commit->number, commit->who);
    for (size_t i = 0; i < commit->n_paths; i++) {
        const size_t m = strlen(d->text);
        snprintf(d->text + m, sizeof d->text - m, " %s", commit->paths[i]);
    }
    strcat(d->text, world->title ? " t; " : "; ");
    d->tried = vv_model_set(d->model, "watcher", "title", "no");
}

static void watchers_hear_of_each_commit_and_cannot_edit(void **state)
{
    (void)state;
    vv_model *model = new_model();
    diary d = {.model = model};
    ok(vv_model_watch(model, note_commit, &d));
    ok(vv_model_set(model, "ann", "title", "x"));
    ok(vv_model_begin(model, "bob"));
    ok(vv_model_add(model, "bob", "cut_planes", NULL, NULL));
    ok(vv_model_set(model, "bob", "cut_planes.0.offset", "1"));
    ok(vv_model_end(model, true));
    ok(vv_model_undo(model, "ann"));
    assert_string_equal(d.text, "1 ann title t; 2 bob cut_planes cut_planes.0.offset t; 3 ann title; ");
    assert_int_equal(d.tried, VV_E_ARGUMENT);
    vv_model_release(model);
}

static void all_commits_can_be_taken_back(void **state)
{
    (void)state;
    vv_model *model = new_model();
    for (int i = 1; i <= 1100; i++) {
        char number[16];
        snprintf(number, sizeof number, "%d", i);
        ok(vv_model_set(model, NULL, "seed", number));
    }
    int n = 0;
    while (vv_model_undo(model, NULL) == VV_OK)
        n++;
    assert_int_equal(n, 1100);
    expect(model, "{}");
    while (vv_model_redo(model, NULL) == VV_OK)
        n--;
    assert_int_equal(n, 0);
    expect(model, "{\"seed\": 1100}");
    vv_model_release(model);
}

static void a_gesture_is_one_step(void **state)
{
    (void)state;
    bool undo, redo;
    vv_model *model = new_model();
    vv_model_can(&undo, &redo, model, "ann");
    assert_false(undo || redo);
    ok(vv_model_join(model, "ann"));
    ok(vv_model_set(model, "ann", "title", "x"));
    ok(vv_model_join(model, "ann")); /* alone it stays */
    ok(vv_model_set(model, "ann", "seed", "1"));
    for (int i = 2; i < 10; i++) {
        char number[16];
        snprintf(number, sizeof number, "%d", i);
        ok(vv_model_set(model, "bob", "unit", i % 2 ? "mm" : "cm"));
        ok(vv_model_set(model, "ann", "seed", number));
        ok(vv_model_set(model, "ann", "background", "red"));
        ok(vv_model_join(model, "ann"));
        ok(vv_model_join(model, "ann"));
    }
    expect(model, "{\"title\": \"x\", \"unit\": \"mm\", \"background\": \"#ff0000\", \"seed\": 9}");
    ok(vv_model_undo(model, "ann"));
    expect(model, "{\"title\": \"x\", \"unit\": \"mm\"}");
    vv_model_can(&undo, &redo, model, "ann");
    assert_true(undo && redo);
    ok(vv_model_redo(model, "ann"));
    expect(model, "{\"title\": \"x\", \"unit\": \"mm\", \"background\": \"#ff0000\", \"seed\": 9}");
    ok(vv_model_undo(model, "ann"));
    ok(vv_model_undo(model, "ann"));
    expect(model, "{\"unit\": \"mm\"}");
    vv_model_release(model);
}

static void a_failed_edit_changes_nothing(void **state)
{
    (void)state;
    vv_model *model = new_model();
    vv_world *before = vv_model_snapshot(model);
    assert_int_equal(vv_model_set(model, NULL, "titel", "x"), VV_E_ARGUMENT);
    assert_non_null(
        strstr(vv_error_last()->message, "titel: unknown property 'titel'; did you mean 'title'? There are schema, "));
    assert_int_equal(vv_model_remove(model, NULL, "lights.key"), VV_E_NOT_FOUND);
    vv_world *after = vv_model_snapshot(model);
    assert_ptr_equal(before, after);
    assert_int_equal(vv_model_undo(model, NULL), VV_E_NOT_FOUND);
    vv_object_release(&before->base);
    vv_object_release(&after->base);
    vv_model_release(model);
}

static void an_attached_field_is_found_and_taken_back(void **state)
{
    (void)state;
    vv_model *model = new_model();
    vv_field *field = test_field_cube(&test_form_ramp, 4, 0, 6, NULL), *found = NULL;
    ok(vv_model_attach(model, NULL, "ramp", field));
    vv_world *world = vv_model_snapshot(model);
    const vv_dataset *dataset = (const vv_dataset *)vv_collection_find(world->datasets, "ramp");
    ok(vv_dataset_field(&found, NULL, dataset, NULL, 0, NULL));
    assert_ptr_equal(found, field);
    vv_field_release(found);
    assert_int_equal(vv_dataset_field(&found, NULL, dataset, NULL, 1, NULL), VV_E_NOT_FOUND);
    assert_null(found);
    assert_true(vv_model_context(model).voxel == 2);
    vv_object_release(&world->base);
    ok(vv_model_undo(model, NULL));
    expect(model, "{}");
    ok(vv_model_redo(model, NULL));
    world = vv_model_snapshot(model);
    ok(vv_dataset_field(&found, NULL, (const vv_dataset *)vv_collection_find(world->datasets, "ramp"), NULL, 0, NULL));
    assert_ptr_equal(found, field);
    vv_field_release(found);
    vv_object_release(&world->base);
    vv_field_release(field);
    vv_model_release(model);
}

/* Random commands ----------------------------------------------------------------------------------------------- */

static const char *const people[] = {"ann", "bob", ""};

static vv_status random_edit(test_dice *dice, vv_model *model, const char *who)
{
    static const char *const names[] = {"head", "key", "A-1", "_x", "b2", "main"};
    static const char *const maps[] = {"lights", "views", "volumes", "datasets"};
    const vv_property_context context = vvi_registry_context(NULL);
    const char *map = maps[test_roll(dice, 4)], *name = names[test_roll(dice, 6)];
    char path[64];
    snprintf(path, sizeof path, "%s.%s", map, name);
    switch (test_roll(dice, 8)) {
    case 0:
        return vv_model_add(model, who, map, name, NULL);
    case 1:
        return vv_model_remove(model, who, path);
    case 2:
        return vv_model_add(model, who, "cut_planes", NULL, "{\"offset\": 4}");
    case 3:
        return vv_model_remove(model, who, "cut_planes.0");
    default:
        break;
    }
    const vv_property *property = NULL;
    vv_world *world = vv_model_snapshot(model);
    char *somewhere = test_roll_path(dice, &property, &world->base);
    char *json = test_roll_value(dice, property, &context);
    const vv_status st =
        test_roll(dice, 5) ? vv_model_set(model, who, somewhere, json) : vv_model_unset(model, who, somewhere);
    free(json);
    free(somewhere);
    vv_object_release(&world->base);
    return st;
}

/* One edit, or a transaction of several; whether it made a commit. */
static bool random_command(test_dice *dice, vv_model *model, const char *who)
{
    if (test_roll(dice, 4))
        return random_edit(dice, model, who) == VV_OK;
    bool any = false;
    const bool keep = test_roll(dice, 4) > 0;
    ok(vv_model_begin(model, who));
    for (uint64_t n = test_roll(dice, 6); n > 0; n--)
        any = random_edit(dice, model, who) == VV_OK || any;
    ok(vv_model_end(model, keep));
    return any && keep;
}

static void random_commands_are_undone_and_redone_to_the_byte(void **state)
{
    (void)state;
    enum { COMMANDS = 300 };
    const vv_property_context context = vvi_registry_context(NULL);
    test_dice dice = {test_seed(), 0};
    for (int round = 0; round < 8; round++) {
        const char *who[COMMANDS];
        int n = 0;
        vv_model *model = new_model();
        vv_object *world = test_roll_world(&dice, 40, &context);
        ok(vv_model_replace(model, "opening", (vv_world *)world));
        char *start = print(model);
        for (int i = 0; i < COMMANDS; i++) {
            const char *person = people[test_roll(&dice, 3)];
            if (random_command(&dice, model, person))
                who[n++] = person;
        }
        assert_true(n > COMMANDS / 3);
        char *end = print(model);
        for (int i = n; i-- > 0;)
            ok(vv_model_undo(model, who[i]));
        expect(model, start);
        for (int i = 0; i < n; i++)
            ok(vv_model_redo(model, who[i]));
        expect(model, end);
        free(start);
        free(end);
        vv_object_release(world);
        vv_model_release(model);
    }
}

/* Threads ------------------------------------------------------------------------------------------------------- */

typedef struct reader {
    vv_model *model;
    vv_world *world;
    const char *json;
    int differences;
} reader;

static void *read_snapshot(void *user)
{
    reader *r = user;
    for (int i = 0; i < 200; i++) {
        char *json = NULL;
        vv_world *newest = vv_model_snapshot(r->model);
        if (vv_object_to_json(&json, &r->world->base, 0) != VV_OK || strcmp(json, r->json) != 0)
            r->differences++;
        free(json);
        if (vv_object_to_json(&json, &newest->base, 0) != VV_OK)
            r->differences++;
        free(json);
        vv_object_release(&newest->base);
    }
    return NULL;
}

static void a_snapshot_stays_as_it_was_while_others_edit(void **state)
{
    (void)state;
    enum { READERS = 2 };
    test_dice dice = {test_seed(), 0};
    const vv_property_context context = vvi_registry_context(NULL);
    vv_model *model = new_model();
    vv_object *world = test_roll_world(&dice, 60, &context);
    ok(vv_model_replace(model, NULL, (vv_world *)world));
    char *json = print(model);
    reader readers[READERS];
    pthread_t threads[READERS];
    for (int i = 0; i < READERS; i++) {
        readers[i] = (reader){.model = model, .world = vv_model_snapshot(model), .json = json};
        assert_int_equal(pthread_create(&threads[i], NULL, read_snapshot, &readers[i]), 0);
    }
    for (int i = 0; i < 300; i++)
        random_command(&dice, model, "");
    while (vv_model_undo(model, "") == VV_OK)
        ;
    for (int i = 0; i < READERS; i++) {
        pthread_join(threads[i], NULL);
        assert_int_equal(readers[i].differences, 0);
        vv_object_release(&readers[i].world->base);
    }
    free(json);
    vv_object_release(world);
    vv_model_release(model);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(undo_takes_back_the_last_commit_and_redo_makes_it_again),
        cmocka_unit_test(undo_leaves_what_others_have_committed_since),
        cmocka_unit_test(undo_of_what_another_has_set_since_waits_for_him),
        cmocka_unit_test(undo_passes_by_what_another_has_removed),
        cmocka_unit_test(a_new_commit_ends_what_can_be_redone),
        cmocka_unit_test(a_removed_entry_comes_back_at_its_place),
        cmocka_unit_test(a_transaction_is_one_commit_or_none),
        cmocka_unit_test(watchers_hear_of_each_commit_and_cannot_edit),
        cmocka_unit_test(all_commits_can_be_taken_back),
        cmocka_unit_test(a_gesture_is_one_step),
        cmocka_unit_test(a_failed_edit_changes_nothing),
        cmocka_unit_test(an_attached_field_is_found_and_taken_back),
        cmocka_unit_test(random_commands_are_undone_and_redone_to_the_byte),
        cmocka_unit_test(a_snapshot_stays_as_it_was_while_others_edit),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
