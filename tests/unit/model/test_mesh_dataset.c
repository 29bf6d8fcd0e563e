/* Meshes as datasets: default Worlds, edits, scenes, files that are not what they should be. */
#include "fields.h"
#include "jobs.h"
#include "meshes.h"
#include <volvis/mesh_file.h>
#include <volvis/model.h>
#include <volvis/sys/scene.h>

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

/* A new folder with a mesh, a volume, and room for a scene. */
typedef struct disk {
    char folder[64], mesh_path[96], volume_path[96], scene_path[96];
    vv_mesh *mesh;
    vv_job *job;
} disk;

static vv_status write_volume(const disk *d)
{
    vv_field *field = test_field_cube(&test_form_ramp, 5, 0, 8, d->job);
    const vv_field *fields[] = {field};
    const vv_status st = vv_field_write(d->volume_path, fields, 1, NULL, d->job);
    vv_field_release(field);
    return st;
}

static int set_up(void **state)
{
    static disk d;
    d = (disk){.folder = "/tmp/volvis-mesh-XXXXXX"};
    if (!mkdtemp(d.folder))
        return -1;
    snprintf(d.mesh_path, sizeof d.mesh_path, "%s/7 strip.ply", d.folder);
    snprintf(d.volume_path, sizeof d.volume_path, "%s/ramp.nrrd", d.folder);
    snprintf(d.scene_path, sizeof d.scene_path, "%s/scene.vv.json", d.folder);
    d.job = test_job(2, 0);
    d.mesh = test_mesh_strip(13, TEST_MESH_NORMALS | TEST_MESH_PARTS);
    *state = &d;
    return vv_mesh_write(d.mesh_path, d.mesh, NULL, d.job) == VV_OK && write_volume(&d) == VV_OK ? 0 : -1;
}

static int tear_down(void **state)
{
    disk *d = *state;
    vv_mesh_release(d->mesh);
    vv_job_release(d->job);
    remove(d->scene_path);
    return remove(d->mesh_path) | remove(d->volume_path) | rmdir(d->folder);
}

static const vv_dataset *only_dataset(const vv_world *world)
{
    assert_int_equal(world->datasets->n, 1);
    return (const vv_dataset *)world->datasets->entry[0].object;
}

static vv_world *world_of(const disk *d)
{
    vv_world *world = NULL;
    ok(vv_world_for_file(&world, d->mesh_path, NULL, d->job));
    return world;
}

static vv_world *parse(const char *json)
{
    vv_world *world = NULL;
    ok(vv_scene_parse(&world, json, strlen(json), "test", NULL, NULL));
    return world;
}

/* The only dataset of a World is this mesh, all of it. */
static void expect_mesh(const vv_world *world, const disk *d)
{
    vv_mesh *found = NULL;
    assert_true(vv_dataset_is_mesh(only_dataset(world), d->job));
    ok(vv_dataset_mesh(&found, NULL, only_dataset(world), d->job));
    assert_int_equal(vv_mesh_checksum(found), vv_mesh_checksum(d->mesh));
    vv_mesh_release(found);
}

static void a_mesh_file_becomes_a_world_in_which_it_is_seen(void **state)
{
    const disk *d = *state;
    vv_world *world = world_of(d);
    vv_scene *scene = NULL;
    assert_string_equal(world->datasets->entry[0].id, "v7_strip");
    assert_string_equal(only_dataset(world)->path, d->mesh_path);
    assert_string_equal(only_dataset(world)->kind, "mesh");
    assert_string_equal(world->unit, "mm");
    assert_int_equal(world->volumes->n, 1);
    assert_string_equal(((const vv_volume *)(const void *)world->volumes->entry[0].object)->data, "v7_strip");
    assert_true(world->lights->n > 0);
    expect_mesh(world, d);
    ok(vv_scene_resolve(&scene, world, NULL, d->job));
    assert_int_equal(scene->n_actors, 0);
    assert_int_equal(scene->n_mesh_actors, 1);
    assert_string_equal(scene->renderer->name, "surface");
    vv_scene_release(scene);
    vv_object_release(&world->base);
}

static void a_mesh_is_read_once_and_kept(void **state)
{
    const disk *d = *state;
    vv_world *world = world_of(d);
    vv_mesh *one = NULL, *two = NULL;
    ok(vv_dataset_mesh(&one, NULL, only_dataset(world), d->job));
    ok(vv_dataset_mesh(&two, NULL, only_dataset(world), d->job));
    assert_ptr_equal(one, two);
    vv_mesh_release(one);
    vv_mesh_release(two);
    vv_object_release(&world->base);
}

static void edits_of_a_mesh_are_undone(void **state)
{
    const disk *d = *state;
    vv_world *before = world_of(d);
    vv_model *model = NULL;
    ok(vv_model_new(&model, NULL));
    ok(vv_model_replace(model, NULL, before));
    ok(vv_model_set(model, NULL, "volumes.v7_strip.color", "\"#d0a08060\""));
    ok(vv_model_set(model, NULL, "volumes.v7_strip.place.position", "[1, 2, 3]"));
    ok(vv_model_set(model, NULL, "datasets.v7_strip.path", "\"/nowhere/x.ply\""));
    vv_world *edited = vv_model_snapshot(model);
    vv_mesh *mesh = NULL;
    assert_false(vv_object_equal(&edited->base, &before->base));
    assert_int_equal(vv_dataset_mesh(&mesh, NULL, only_dataset(edited), d->job), VV_E_READ);
    assert_null(mesh);
    vv_object_release(&edited->base);
    for (int i = 0; i < 3; i++)
        ok(vv_model_undo(model, NULL));
    vv_world *after = vv_model_snapshot(model);
    assert_true(vv_object_equal(&after->base, &before->base));
    expect_mesh(after, d);
    vv_object_release(&after->base);
    vv_object_release(&before->base);
    vv_model_release(model);
}

static void a_scene_with_a_mesh_is_saved_and_read_again(void **state)
{
    const disk *d = *state;
    vv_world *world = world_of(d), *again = NULL;
    char *json = NULL;
    ok(vv_scene_write(d->scene_path, world, d->job));
    ok(vv_scene_read(&again, d->scene_path, d->job));
    assert_true(vv_object_equal(&world->base, &again->base));
    expect_mesh(again, d);
    ok(vv_scene_print(&json, again, d->folder));
    assert_non_null(strstr(json, "\"path\": \"7 strip.ply\""));
    free(json);
    vv_object_release(&again->base);
    vv_object_release(&world->base);
}

/* The mesh of a dataset with these properties: its status. */
static vv_status load(const disk *d, const char *properties)
{
    char json[512];
    vv_mesh *mesh = NULL;
    snprintf(json, sizeof json, "{\"datasets\": {\"d\": {%s}}}", properties);
    vv_world *world = parse(json);
    const vv_status st = vv_dataset_mesh(&mesh, NULL, only_dataset(world), d->job);
    assert_true((st == VV_OK) == (mesh != NULL));
    vv_mesh_release(mesh);
    vv_object_release(&world->base);
    return st;
}

static void expect_message(const char *part)
{
    if (!strstr(vv_error_last()->message, part))
        fail_msg("'%s' is not in: %s", part, vv_error_last()->message);
}

static void a_mesh_that_is_not_there_is_an_error(void **state)
{
    const disk *d = *state;
    vv_world *world = NULL;
    assert_int_equal(load(d, "\"path\": \"/nowhere/x.ply\""), VV_E_READ);
    expect_message("/nowhere/x.ply");
    assert_int_equal(load(d, "\"path\": \"/nowhere/x\", \"kind\": \"mesh\""), VV_E_READ);
    assert_int_equal(load(d, "\"kind\": \"mesh\""), VV_E_ARGUMENT);
    assert_int_equal(vv_world_for_file(&world, "/nowhere/x.ply", NULL, d->job), VV_E_READ);
    assert_null(world);
}

static void a_file_of_another_kind_is_an_error(void **state)
{
    const disk *d = *state;
    char properties[256];
    snprintf(properties, sizeof properties, "\"path\": \"%s\"", d->volume_path);
    assert_int_equal(load(d, properties), VV_E_ARGUMENT);
    expect_message("samples, not triangles");
    snprintf(properties, sizeof properties, "\"path\": \"%s\", \"kind\": \"mesh\"", d->volume_path);
    assert_true(load(d, properties) < 0);
    expect_message("ramp.nrrd");
    snprintf(properties, sizeof properties, "\"path\": \"%s\", \"format\": \"stl\"", d->mesh_path);
    assert_int_equal(load(d, properties), VV_E_FORMAT);
}

static void a_mesh_has_no_samples(void **state)
{
    const disk *d = *state;
    vv_world *world = world_of(d);
    vv_field *field = NULL;
    vv_field_info info;
    assert_int_equal(vv_dataset_field(&field, NULL, only_dataset(world), NULL, 0, d->job), VV_E_UNSUPPORTED);
    expect_message("is a mesh");
    assert_null(field);
    assert_int_equal(vv_dataset_info(&info, NULL, only_dataset(world), d->job), VV_E_UNSUPPORTED);
    vv_object_release(&world->base);
}

static void the_checksum_of_a_mesh_is_checked_when_given(void **state)
{
    const disk *d = *state;
    char properties[256];
    const uint32_t crc = vv_mesh_checksum(d->mesh);
    for (uint32_t wrong = 0; wrong < 2; wrong++) {
        snprintf(properties, sizeof properties, "\"path\": \"%s\", \"checksum\": \"crc32:%08x\"", d->mesh_path,
                 crc ^ wrong);
        assert_int_equal(load(d, properties), wrong ? VV_E_FORMAT : VV_OK);
    }
    expect_message("checksum");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_mesh_file_becomes_a_world_in_which_it_is_seen),
        cmocka_unit_test(a_mesh_is_read_once_and_kept),
        cmocka_unit_test(edits_of_a_mesh_are_undone),
        cmocka_unit_test(a_scene_with_a_mesh_is_saved_and_read_again),
        cmocka_unit_test(a_mesh_that_is_not_there_is_an_error),
        cmocka_unit_test(a_file_of_another_kind_is_an_error),
        cmocka_unit_test(a_mesh_has_no_samples),
        cmocka_unit_test(the_checksum_of_a_mesh_is_checked_when_given),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
