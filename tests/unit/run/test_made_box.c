/* Boxes of what is made, of every row that can make them: the truth is the whole, which is made by itself. */
#include "../io/io_test.h"
#include "core/text.h"
#include "fields.h"
#include "jobs.h"
#include "model/dataset.h"
#include "run/made.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { NX = 13, NY = 10, NZ = 8 };

static void ok(vv_status st)
{
    if (st != VV_OK)
        fail_msg("%s", vv_error_last()->message); /* it begins with the path */
}

/* Values that no filter leaves as they are, in two channels where `components` says so. */
static vv_field *make_field(int components)
{
    vv_field_info info = vv_field_info_default();
    vv_field *field;
    void *data;
    info.type = VV_TYPE_F32;
    info.components = components;
    snprintf(info.grid.unit, sizeof info.grid.unit, "mm");
    info.grid.dims[0] = NX;
    info.grid.dims[1] = NY;
    info.grid.dims[2] = NZ;
    ok(vv_field_new_empty(&field, &data, &info, NULL));
    for (int i = 0; i < NX * NY * NZ * components; i++)
        ((float *)data)[i] = (float)(i * i % 97) + (float)(i % NX);
    return field;
}

/* What rows need that have no default for it. */
static const struct {
    const char *operation, *parameters;
    int components;
} needed[] = {
    {"calc", "{\"formula\": \"2*a+1\"}", 1},
    {"channel", "{\"components\": \"1\"}", 2},
    {"clamp", "{\"range\": \"10..50\"}", 1},
    {"crop", "{\"x\": \"2..9\"}", 1},
    {"flip", "{\"axes\": \"x\"}", 1},
    {"gaussian", "{\"sigma\": \"1vox\"}", 1},
    {"pad", "{\"all\": 2}", 1},
    {"project", "{\"axis\": \"y\"}", 1},
    {"reorient", "{\"order\": \"zyx\"}", 1},
    {"resample", "{\"spacing\": \"0.7\"}", 1},
    {"threshold", "{\"method\": \"otsu\"}", 1},
    {"vesselness", "{\"c\": 20}", 1},
};

/* All of its inputs are the same volume. */
static char *recipe_of(const vv_operation *o, const char *parameters)
{
    vvi_text text = {0};
    vvi_text_printf(&text, "{\"operation\": \"%s\", \"inputs\": {", o->name);
    for (const vv_operand *p = o->inputs; p->name; p++)
        for (size_t i = 0; i < p->least; i++) {
            const char letter[2] = {(char)('a' + i), 0};
            vvi_text_printf(&text, "%s\"%s\": \"in\"", p == o->inputs && i == 0 ? "" : ", ",
                            p->names ? letter : p->name);
        }
    vvi_text_printf(&text, "}, \"parameters\": %s}", parameters);
    return vvi_text_take(&text);
}

static void same_bytes(const vv_field *part, const vv_field *whole, const vv_box *box, const char *name)
{
    const vv_field_info *info = vv_field_get_info(whole);
    const size_t row = (size_t)box->n[0] * vv_type_bytes(info->type) * (size_t)info->components;
    const vv_box all = vv_field_box(part);
    vv_brick a, b;
    assert_memory_equal(all.n, box->n, sizeof all.n);
    ok(vv_field_brick(&a, part, &all, NULL));
    ok(vv_field_brick(&b, whole, box, NULL));
    for (int64_t k = 0; k < box->n[2]; k++)
        for (int64_t j = 0; j < box->n[1]; j++)
            if (memcmp((const char *)a.data + j * a.stride[1] + k * a.stride[2],
                       (const char *)b.data + j * b.stride[1] + k * b.stride[2], row) != 0)
                fail_msg("%s: the box is not the whole's", name);
    vv_brick_release(&a);
    vv_brick_release(&b);
}

/* A slice along each axis, its neighbours, and a corner. */
static void compare_boxes(const vvi_made *made, const vv_object *params, const vv_field *whole, vv_job *job)
{
    const int64_t *dims = vv_field_get_info(whole)->grid.dims;
    vvi_made_fields fields;
    ok(vvi_made_fields_open(&fields, made, 0, job));
    for (int axis = 0; axis < 4; axis++) {
        vv_box box = {{0, 0, 0}, {dims[0], dims[1], dims[2]}};
        for (int a = 0; a < 3; a++)
            if (axis == 3 || axis == a) {
                box.lo[a] = dims[a] / 2;
                box.n[a] = dims[a] - box.lo[a] > 1 ? 2 : 1;
            }
        vv_field *part = NULL;
        ok(vvi_made_box(&part, made, &fields, params, &box, job));
        same_bytes(part, whole, &box, made->operation->name);
        vv_field_release(part);
    }
    vvi_made_fields_close(&fields);
}

/* How many of those there are is known: else a row that is local no more would be left out in silence. */
static bool compare_row(const vv_operation *o, vv_job *job)
{
    const char *parameters = "{}";
    int components = 1;
    for (size_t i = 0; i < sizeof needed / sizeof *needed; i++)
        if (strcmp(needed[i].operation, o->name) == 0) {
            parameters = needed[i].parameters;
            components = needed[i].components;
        }
    vv_field *in = make_field(components), *whole = NULL;
    vv_world *world = NULL;
    vv_object *params = NULL;
    vvi_made made;
    ok(vv_world_for_field(&world, "in", in, job));
    vv_object *root = &world->base;
    char *recipe = recipe_of(o, parameters);
    ok(vv_path_add(&root, "datasets", "out", recipe, NULL));
    world = (vv_world *)(void *)root;
    const vv_dataset *dataset = (const vv_dataset *)(const void *)vv_collection_find(world->datasets, "out");
    ok(vvi_made_open(&made, world, dataset, job));
    ok(vvi_made_params(&params, &made, job));
    const bool local = vvi_made_is_local(&made, params, 1);
    assert_int_equal(vvi_made_is_local(&made, params, 2), local && !(o->looks && o->looks(params)));
    if (local) {
        ok(vv_dataset_field(&whole, world, dataset, NULL, 0, job));
        compare_boxes(&made, params, whole, job);
    }
    vv_field_release(whole);
    vv_object_release(params);
    vvi_made_close(&made);
    free(recipe);
    vv_object_release(&world->base);
    vv_field_release(in);
    return local;
}

static void every_local_row_makes_of_a_box_what_it_makes_of_the_whole(void **state)
{
    vv_job *job = test_job(2, 0);
    const vv_registry *registry = vv_runtime_registry(vv_job_runtime(job));
    int n_rows = 0, n_local = 0;
    (void)state;
    for (const vv_operation *const *o = registry->operations; *o; o++) {
        if (!(*o)->run_box || (*o)->joins)
            continue;
        n_rows++;
        n_local += compare_row(*o, job);
    }
    assert_true(n_rows > 20);
    assert_int_equal(n_local, n_rows);
    vv_job_release(job);
}

static void what_samples_decide_is_not_made_in_boxes(void **state)
{
    vv_job *job = test_job(1, 0);
    vv_field *in = make_field(1), *part = NULL;
    vv_world *world = NULL;
    vv_object *params = NULL;
    vvi_made made;
    vvi_made_fields fields;
    const vv_box box = {{0, 0, 0}, {1, 1, 1}};
    (void)state;
    ok(vv_world_for_field(&world, "in", in, job));
    vv_object *root = &world->base;
    ok(vv_path_add(&root, "datasets", "out", "{\"operation\": \"vesselness\", \"inputs\": {\"volume\": \"in\"}}",
                   NULL));
    world = (vv_world *)(void *)root;
    ok(vvi_made_open(&made, world, (const vv_dataset *)(const void *)vv_collection_find(world->datasets, "out"), job));
    ok(vvi_made_params(&params, &made, job));
    assert_false(vvi_made_is_local(&made, params, 1));
    ok(vvi_made_fields_open(&fields, &made, 0, job));
    assert_int_equal(vvi_made_box(&part, &made, &fields, params, &box, job), VV_E_UNSUPPORTED);
    assert_non_null(strstr(vv_error_last()->message, "datasets.out"));
    vvi_made_fields_close(&fields);
    vv_object_release(params);
    vvi_made_close(&made);
    vv_object_release(&world->base);
    vv_field_release(in);
    vv_job_release(job);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_local_row_makes_of_a_box_what_it_makes_of_the_whole),
        cmocka_unit_test(what_samples_decide_is_not_made_in_boxes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
