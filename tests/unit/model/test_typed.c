/* Operations by name, with parameters that are values of C. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <volvis/volvis.h>

static void reads(const vv_object *object, const char *path, const char *json)
{
    char *found = NULL;
    assert_int_equal(vv_path_get(&found, object, path), VV_OK);
    assert_string_equal(found, json);
    free(found);
}

static void values_of_c_become_properties(void **state)
{
    vv_object *world;
    const double eye[3] = {1, 0.1, -1e-300}, rows[4] = {0, 0, 100, 0.5};
    assert_int_equal(vv_object_new(&world, &vv_world_class, NULL), VV_OK);
    assert_int_equal(vv_path_add(&world, "views", "main", NULL, NULL), VV_OK);
    assert_int_equal(vv_path_add(&world, "volumes", "a", NULL, NULL), VV_OK);
    assert_int_equal(vv_path_set_number(&world, "views.main.camera.azimuth", 30, NULL), VV_OK);
    assert_int_equal(vv_path_set_integer(&world, "seed", (INT64_C(1) << 53) - 1, NULL), VV_OK);
    assert_int_equal(vv_path_set_bool(&world, "volumes.a.visible", false, NULL), VV_OK);
    assert_int_equal(vv_path_set_text(&world, "title", "a \"b\", 1", NULL), VV_OK);
    assert_int_equal(vv_path_set_text(&world, "views.main.camera.projection", "parallel", NULL), VV_OK);
    assert_int_equal(vv_path_set_numbers(&world, "views.main.camera.eye", eye, 3, NULL), VV_OK);
    assert_int_equal(vv_path_set_numbers(&world, "volumes.a.segmentation.transfer.opacity", rows, 4, NULL), VV_OK);
    reads(world, "views.main.camera.azimuth", "30");
    reads(world, "seed", "9007199254740991");
    reads(world, "volumes.a.visible", "false");
    reads(world, "title", "\"a \\\"b\\\", 1\"");
    reads(world, "views.main.camera.projection", "\"parallel\"");
    reads(world, "views.main.camera.eye", "[1, 0.1, -1e-300]");
    reads(world, "volumes.a.segmentation.transfer.opacity", "[[0, 0], [100, 0.5]]");
    assert_int_equal(vv_path_set_number(&world, "views.main.camera.azimuth", NAN, NULL), VV_E_ARGUMENT);
    assert_int_equal(vv_path_set_numbers(&world, "views.main.camera.eye", (double[]){INFINITY, 0, 0}, 3, NULL),
                     VV_E_ARGUMENT);
    assert_int_equal(vv_path_set_numbers(&world, "volumes.a.segmentation.transfer.opacity", rows, 3, NULL),
                     VV_E_ARGUMENT);
    assert_int_equal(vv_path_set_text(&world, "titel", "x", NULL), VV_E_ARGUMENT);
    assert_non_null(strstr(vv_error_last()->message, "title"));
    reads(world, "views.main.camera.azimuth", "30");
    vv_object_release(world);
}

/* A ball of radius 10 in a cube of 32 samples of 0.5 mm. */
static vv_field *ball(void)
{
    static float samples[32 * 32 * 32];
    for (int i = 0; i < 32 * 32 * 32; i++) {
        const double x = i % 32 - 15.5, y = i / 32 % 32 - 15.5, z = i / 1024 - 15.5;
        samples[i] = (float)(10 - sqrt(x * x + y * y + z * z));
    }
    vv_field *field;
    vv_field_info info = vv_field_info_default();
    info.type = VV_TYPE_F32;
    for (int a = 0; a < 3; a++)
        info.grid.dims[a] = 32;
    info.grid.index_to_world.axis[0].x = info.grid.index_to_world.axis[1].y = info.grid.index_to_world.axis[2].z = 0.5;
    strcpy(info.grid.unit, "mm");
    assert_int_equal(vv_field_new(&field, &info, samples, 0, NULL, NULL, NULL), VV_OK);
    return field;
}

static void an_operation_runs_by_its_name(void **state)
{
    vv_data in = {.field = ball()}, out;
    vv_object *params;
    vv_mesh_measures found;
    const vv_operation *operation = vv_operation_find("isosurface", NULL);
    assert_non_null(operation);
    assert_int_equal(vv_operation_makes(operation), VV_IS_MESH);
    assert_int_equal(vv_operation_new_params(&params, operation), VV_OK);
    const vv_property_context context = vv_data_context(&in);
    assert_string_equal(context.length_unit, "mm");
    assert_true(context.voxel == 0.5);
    assert_int_equal(vv_path_set_number(&params, "iso", 0, &context), VV_OK);
    assert_int_equal(vv_operation_make(&out, operation, &in, 1, params, NULL), VV_OK);
    assert_null(out.field);
    assert_int_equal(vv_mesh_measure(&found, out.mesh, NULL, NULL), VV_OK);
    assert_true(fabs(found.volume.value / (4.0 / 3 * 3.14159265358979 * 125) - 1) < 0.01);
    assert_string_equal(vv_data_context(&out).length_unit, "mm");
    vv_data_release(&out);
    assert_null(out.mesh);
    vv_object_release(params);

    operation = vv_operation_find("gaussian", NULL);
    assert_int_equal(vv_operation_new_params(&params, operation), VV_OK);
    assert_int_equal(vv_path_set_text(&params, "sigma", "2vox", &context), VV_OK);
    reads(params, "sigma", "1");
    assert_int_equal(vv_operation_make(&out, operation, &in, 1, params, NULL), VV_OK);
    assert_true(vv_field_value(out.field, 15, 15, 15, 0) < vv_field_value(in.field, 15, 15, 15, 0) - 1);
    vv_data_release(&out);
    vv_object_release(params);
    assert_null(vv_operation_find("gausian", NULL));
    assert_non_null(strstr(vv_error_last()->message, "gaussian"));
    vv_data_release(&in);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(values_of_c_become_properties),
        cmocka_unit_test(an_operation_runs_by_its_name),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
