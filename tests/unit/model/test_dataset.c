/* Datasets from files, placements, paths of files, default Worlds. */
#include "core/cache.h"
#include "fields.h"
#include "jobs.h"
#include "model/context.h"
#include "model/file_path.h"
#include "model/placement.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

static void ok(vv_status st)
{
    if (st != VV_OK)
        fail_msg("%s", vv_error_last()->message);
}

/* A new folder with one file in it: 5^3 floats of the ramp. */
typedef struct disk {
    char folder[64], path[96];
    vv_field *field;
    vv_job *job;
} disk;

static int set_up(void **state)
{
    static disk d;
    d = (disk){.folder = "/tmp/volvis-dataset-XXXXXX"};
    if (!mkdtemp(d.folder))
        return -1;
    snprintf(d.path, sizeof d.path, "%s/3 ramp.x.nrrd", d.folder);
    d.job = test_job(2, 0);
    d.field = test_field_cube(&test_form_ramp, 5, 0, 8, d.job);
    const vv_field *fields[] = {d.field};
    *state = &d;
    return d.field && vv_field_write(d.path, fields, 1, NULL, d.job) == VV_OK ? 0 : -1;
}

static int tear_down(void **state)
{
    disk *d = *state;
    vv_field_release(d->field);
    vv_job_release(d->job);
    return remove(d->path) | rmdir(d->folder);
}

static vv_object *world_with(const char *json)
{
    vv_world *world = NULL;
    ok(vv_scene_parse(&world, json, strlen(json), "test", NULL, NULL));
    return &world->base;
}

static const vv_dataset *only_dataset(const vv_object *world)
{
    const vv_collection *datasets = ((const vv_world *)world)->datasets;
    assert_int_equal(datasets->n, 1);
    return (const vv_dataset *)datasets->entry[0].object;
}

static void a_file_becomes_a_world_in_which_something_is_seen(void **state)
{
    const disk *d = *state;
    vv_world *world = NULL;
    char *json = NULL;
    ok(vv_world_for_file(&world, d->path, NULL, d->job));
    assert_string_equal(world->datasets->entry[0].id, "v3_ramp");
    assert_string_equal(only_dataset(&world->base)->path, d->path);
    assert_string_equal(((const vv_volume *)vv_collection_find(world->volumes, "v3_ramp"))->data, "v3_ramp");
    assert_int_equal(world->lights->n, 2);
    assert_non_null(vv_collection_find(world->views, "main"));
    const vv_field_info *info = vv_field_get_info(d->field);
    assert_string_equal(world->unit, info->grid.unit);
    ok(vv_scene_print(&json, world, d->folder)); /* it is a scene like any other */
    assert_non_null(strstr(json, "\"path\": \"3 ramp.x.nrrd\""));
    vv_world *again = NULL;
    ok(vv_scene_parse(&again, json, strlen(json), "test", d->folder, d->job));
    assert_true(vv_object_equal(&world->base, &again->base));
    free(json);
    assert_true(vvi_world_context(world, d->job).voxel == 2);
    vv_object_release(&again->base);
    vv_object_release(&world->base);
}

static void samples_are_loaded_once_and_kept(void **state)
{
    const disk *d = *state;
    vv_world *world = NULL;
    vv_field *one = NULL, *two = NULL;
    ok(vv_world_for_file(&world, d->path, NULL, d->job));
    ok(vv_dataset_field(&one, NULL, only_dataset(&world->base), NULL, 0, d->job));
    ok(vv_dataset_field(&two, NULL, only_dataset(&world->base), NULL, 0, d->job));
    assert_ptr_equal(one, two);
    for (int64_t i = 0; i < 5; i++)
        assert_true(vv_field_value(one, i, 2, 3, 0) == vv_field_value(d->field, i, 2, 3, 0));
    vv_field_release(one);
    vv_field_release(two);
    vv_object_release(&world->base);
}

static void a_field_becomes_a_world_that_holds_it(void **state)
{
    const disk *d = *state;
    vv_world *world = NULL;
    vv_field *found = NULL;
    ok(vv_world_for_field(&world, "ramp", d->field, d->job));
    ok(vv_dataset_field(&found, NULL, only_dataset(&world->base), NULL, 0, d->job));
    assert_ptr_equal(found, d->field);
    vv_field_release(found);
    vv_object_release(&world->base);
    assert_int_equal(vv_world_for_field(&world, "a.b", d->field, d->job), VV_E_ARGUMENT);
    assert_null(world);
}

static vv_status load(const disk *d, const char *more, int64_t frame)
{
    char json[512];
    vv_field *field = NULL;
    snprintf(json, sizeof json, "{\"datasets\": {\"d\": {\"path\": \"%s\"%s}}}", d->path, more);
    vv_object *world = world_with(json);
    const vv_status st = vv_dataset_field(&field, NULL, only_dataset(world), NULL, frame, d->job);
    assert_true((st == VV_OK) == (field != NULL));
    vv_field_release(field);
    vv_object_release(world);
    return st;
}

static void checksums_are_checked_when_given(void **state)
{
    const disk *d = *state;
    char more[64];
    uint32_t crc = 0;
    ok(vv_field_checksum(&crc, d->field, d->job));
    snprintf(more, sizeof more, ", \"checksum\": \"crc32:%08x\"", crc);
    assert_int_equal(load(d, more, 0), VV_OK);
    snprintf(more, sizeof more, ", \"checksum\": \"crc32:%08x\"", crc ^ 1);
    assert_int_equal(load(d, more, 0), VV_E_FORMAT);
    assert_non_null(strstr(vv_error_last()->message, "checksum"));
}

static void frames_and_files_that_are_not_there_are_errors(void **state)
{
    const disk *d = *state;
    assert_int_equal(load(d, "", 1), VV_E_ARGUMENT);
    assert_non_null(strstr(vv_error_last()->message, "there is no time step 1: expected 0 to 0"));
    vv_field_info info;
    vv_object *world = world_with("{\"datasets\": {\"d\": {\"path\": \"/nowhere/x.nrrd\"}}}");
    assert_int_equal(vv_dataset_info(&info, NULL, only_dataset(world), d->job), VV_E_READ);
    vv_object_release(world);
    world = world_with("{\"datasets\": {\"d\": {}}}");
    assert_int_equal(vv_dataset_info(&info, NULL, only_dataset(world), d->job), VV_E_NOT_FOUND);
    vv_object_release(world);
}

static void a_kind_that_is_not_known_is_a_clear_error(void **state)
{
    const disk *d = *state;
    vv_world *world = NULL;
    vv_field_info info;
    char json[256]; /* of a newer schema, so that it is read at all */
    snprintf(json, sizeof json, "{\"schema\": 2, \"datasets\": {\"d\": {\"path\": \"%s\", \"kind\": \"regulr\"}}}",
             d->path);
    ok(vv_scene_parse(&world, json, strlen(json), "test", NULL, NULL));
    assert_int_equal(vv_dataset_info(&info, NULL, only_dataset(&world->base), d->job), VV_E_UNSUPPORTED);
    assert_string_equal(
        vv_error_last()->message,
        "kind: 'regulr' is not a known kind of data; did you mean 'regular'? There are regular and mesh");
    vv_object_release(&world->base);
}

static void expect_point(vv_vec3 p, double x, double y, double z)
{
    assert_true(fabs(p.x - x) < 1e-12 && fabs(p.y - y) < 1e-12 && fabs(p.z - z) < 1e-12);
}

static const vv_placement *frame_of(vv_object *world)
{
    return (const vv_placement *)vv_path_object(world, "volumes.v.place");
}

static void a_frame_scales_then_turns_about_x_y_z_then_moves(void **state)
{
    (void)state;
    vv_object *world =
        world_with("{\"volumes\": {\"v\": {\"place\": {\"position\": [10, 20, 30], \"rotation\": [90, 0, "
                   "90], \"scale\": [2, 3, 4]}}}}");
    /* (1, 1, 1) is scaled to (2, 3, 4), turned about x to (2, -4, 3), about z to (4, 2, 3) */
    expect_point(vv_affine_point(vvi_placement_matrix(frame_of(world)), (vv_vec3){1, 1, 1}), 14, 22, 33);
    vv_object_release(world);
    world = world_with("{\"volumes\": {\"v\": {\"place\": {\"position\": [1, 1, 1], \"matrix\": [[0, -1, 0, 5], [1, 0, "
                       "0, 6], [0, 0, 2, 7]]}}}}");
    expect_point(vv_affine_point(vvi_placement_matrix(frame_of(world)), (vv_vec3){1, 2, 3}), 3, 7, 13);
    vv_object_release(world);
}

static void expect_path(char *found, const char *expected)
{
    assert_string_equal(found, expected);
    free(found);
}

static void paths_move_between_a_folder_and_here(void **state)
{
    const disk *d = *state;
    char nested[128];
    expect_path(vvi_folder_of("a/b.c"), "a");
    expect_path(vvi_folder_of("b.c"), ".");
    expect_path(vvi_folder_of("/b.c"), "/");
    expect_path(vvi_path_from_folder("s", "a.nrrd"), "s/a.nrrd");
    expect_path(vvi_path_from_folder(".", "a.nrrd"), "a.nrrd");
    expect_path(vvi_path_from_folder("s", "/a.nrrd"), "/a.nrrd");
    expect_path(vvi_path_from_folder("s", "-"), "-");
    expect_path(vvi_path_to_folder(".", "a/b.nrrd"), "a/b.nrrd");
    snprintf(nested, sizeof nested, "%s/x/y.nrrd", d->folder);
    expect_path(vvi_path_to_folder(d->folder, nested), "x/y.nrrd");
    expect_path(vvi_path_to_folder(d->folder, "/elsewhere/y.nrrd"), "/elsewhere/y.nrrd");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_file_becomes_a_world_in_which_something_is_seen),
        cmocka_unit_test(samples_are_loaded_once_and_kept),
        cmocka_unit_test(a_field_becomes_a_world_that_holds_it),
        cmocka_unit_test(checksums_are_checked_when_given),
        cmocka_unit_test(frames_and_files_that_are_not_there_are_errors),
        cmocka_unit_test(a_kind_that_is_not_known_is_a_clear_error),
        cmocka_unit_test(a_frame_scales_then_turns_about_x_y_z_then_moves),
        cmocka_unit_test(paths_move_between_a_folder_and_here),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
