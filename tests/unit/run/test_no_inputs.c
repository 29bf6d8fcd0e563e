/* Operations that take nothing: a ramp, whose samples are a formula of their place, begins runs and datasets. */
#include "../io/io_test.h"
#include "jobs.h"
#include "operations.h"
#include "registry.h"
#include <volvis/run.h>
#include <volvis/sys/registry.h>

enum { NX = 160, NY = 150, NZ = 180 };

static float ramp_at(int64_t i, int64_t j, int64_t k)
{
    return (float)(i + 200 * j + 40000 * k);
}

static vv_status plan(vv_field_info *out, const vv_field_info *inputs, size_t n_inputs, const vv_object *params)
{
    const int64_t dims[3] = {NX, NY, NZ};
    assert_int_equal(n_inputs, 0);
    *out = vv_field_info_default();
    out->type = VV_TYPE_F32;
    memcpy(out->grid.dims, dims, sizeof dims);
    return VV_OK;
}

static vv_status run_box(vv_field **out, const vv_field *const *inputs, size_t n_inputs, const vv_object *params,
                         const vv_box *box, vv_job *job)
{
    vv_field_info info;
    void *data;
    vv_status st = plan(&info, NULL, n_inputs, params);
    info.grid = vv_grid_crop(&info.grid, box);
    if (st != VV_OK || (st = vv_field_new_empty(out, &data, &info, job)) != VV_OK)
        return st;
    float *sample = data;
    for (int64_t k = 0; k < box->n[2]; k++)
        for (int64_t j = 0; j < box->n[1]; j++)
            for (int64_t i = 0; i < box->n[0]; i++)
                *sample++ = ramp_at(box->lo[0] + i, box->lo[1] + j, box->lo[2] + k);
    return VV_OK;
}

static vv_operation ramp_row(void)
{
    static const vv_operand none[] = {{.name = NULL}};
    vv_operation row = vvi_operation_median; /* its parameters are as good as others */
    row.name = "ramp";
    row.inputs = none;
    row.run = NULL;
    row.run_box = run_box;
    row.plan = plan;
    row.memory = NULL;
    row.passes = NULL;
    row.looks = NULL;
    row.settle = NULL;
    row.in_order = true;
    return row;
}

/* Flipped along x. */
static void check_flipped(const vv_field *field, vv_job *job)
{
    for (int64_t k = 0; k < NZ; k++) {
        vv_brick b;
        io_ok(vv_field_brick(&b, field, &(vv_box){{0, 0, k}, {NX, NY, 1}}, job));
        for (int64_t j = 0; j < NY; j++)
            for (int64_t i = 0; i < NX; i++)
                assert_true(((const float *)(const void *)((const char *)b.data + j * b.stride[1]))[i] ==
                            ramp_at(NX - 1 - i, j, k));
        vv_brick_release(&b);
    }
}

static void a_run_begins_with_nothing(void **state)
{
    const vv_operation ramp = ramp_row();
    const uint64_t bytes = (uint64_t)NX * NY * NZ * sizeof(float);
    vv_step steps[2] = {{.operation = &ramp}, {.operation = &vvi_operation_flip}};
    io_ok(vv_operation_new_params(&steps[0].params, &ramp));
    io_ok(vv_operation_new_params(&steps[1].params, &vvi_operation_flip));
    io_ok(vv_path_set(&steps[1].params, "axes", "\"x\"", NULL));
    for (int small = 0; small < 2; small++) { /* in memory, and slab by slab in a quarter of it */
        const char *path = io_path(state, small ? "small.nrrd" : "large.nrrd");
        vv_job *job = test_job(2, small ? bytes / 4 : 0);
        vv_run *run;
        io_ok(vv_run_new(&run, NULL, 0, steps, 2, &(vv_run_output){.path = path}, "ramp", job));
        assert_int_equal(vv_run_get_about(run)->streamed, small);
        assert_int_equal(vv_run_get_about(run)->n_frames, 1);
        io_ok(vv_run_write(run));
        check_flipped(vv_run_field(run, 0), job);
        vv_run_release(run);
        vv_file *file = io_open(path);
        vv_field *field;
        io_ok(vv_file_read(&field, file, 0, NULL, NULL));
        check_flipped(field, NULL);
        vv_field_release(field);
        vv_file_close(file);
        vv_job_release(job);
    }
    vv_object_release(steps[0].params);
    vv_object_release(steps[1].params);
}

static void it_takes_nothing_and_others_take_something(void **state)
{
    const vv_operation ramp = ramp_row();
    vv_step step = {.operation = &ramp};
    vv_job *job = test_job(1, 0);
    vv_run *run;
    (void)state;
    const vv_run_input gap = {.frame = -1};
    io_ok(vv_operation_new_params(&step.params, &ramp));
    assert_int_equal(vv_run_new(&run, &gap, 1, &step, 1, &(vv_run_output){.path = NULL}, "ramp", job), VV_E_ARGUMENT);
    assert_non_null(strstr(vv_error_last()->message, "ramp: takes no inputs, and there are 1"));
    step.operation = &vvi_operation_median;
    assert_int_equal(vv_run_new(&run, NULL, 0, &step, 1, &(vv_run_output){.path = NULL}, "median", job), VV_E_ARGUMENT);
    assert_int_equal(vv_run_new(&run, NULL, 0, NULL, 0, &(vv_run_output){.path = NULL}, "none", job), VV_E_ARGUMENT);
    vv_object_release(step.params);
    vv_job_release(job);
}

static vv_job *job_with(const vv_registry *registry)
{
    vv_runtime_options options;
    vv_runtime *runtime;
    vv_job *job;
    vv_runtime_options_init(&options, sizeof options);
    options.registry = registry;
    io_ok(vv_runtime_new(&runtime, &options));
    io_ok(vv_job_new(&job, runtime, NULL, NULL));
    vv_runtime_release(runtime);
    return job;
}

static void datasets_of_a_scene_begin_with_nothing(void **state)
{
    static const char scene[] =
        "{\"datasets\": {\"r\": {\"operation\": \"ramp\"}, \"bad\": {\"operation\": \"ramp\", \"source\": \"r\"}, "
        "\"off\": {\"operation\": \"ramp\", \"on\": false}, "
        "\"x\": {\"operation\": \"flip\", \"inputs\": {\"volume\": \"r\"}, \"parameters\": {\"axes\": \"x\"}}}}";
    const vv_operation ramp = ramp_row(), *const rows[] = {&ramp, &vvi_operation_flip, NULL};
    vv_registry registry = *vv_registry_builtin();
    vv_world *world;
    vv_field *field;
    registry.operations = rows;
    vv_job *job = job_with(&registry);
    (void)state;
    io_ok(vv_scene_parse(&world, scene, strlen(scene), "test", NULL, NULL));
    static const struct {
        const char *id, *where, *text;
    } refused[] = {{"bad", "datasets.bad.source", "ramp takes no inputs"},
                   {"off", "datasets.off.on", "it has no first input"}};
    for (size_t i = 0; i < 2; i++) {
        const void *bad = vv_collection_find(world->datasets, refused[i].id);
        assert_int_equal(vv_dataset_field(&field, world, bad, NULL, 0, job), VV_E_ARGUMENT);
        assert_string_equal(vv_error_last()->where, refused[i].where);
        assert_non_null(strstr(vv_error_last()->message, refused[i].text));
    }
    io_ok(vv_dataset_field(&field, world, (const void *)vv_collection_find(world->datasets, "x"), NULL, 0, job));
    check_flipped(field, job);
    vv_field_release(field);
    vv_object_release(&world->base);
    vv_job_release(job);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(a_run_begins_with_nothing, io_setup, io_teardown),
        cmocka_unit_test(it_takes_nothing_and_others_take_something),
        cmocka_unit_test(datasets_of_a_scene_begin_with_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
