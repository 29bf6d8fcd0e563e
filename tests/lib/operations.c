#include "operations.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

vv_object *test_params(const vv_operation *operation, const char *settings, const vv_grid *grid)
{
    const vv_property_context context = {.length_unit = grid->unit, .voxel = vv_grid_voxel(grid)};
    vv_object *object = NULL;
    if (vv_object_new(&object, operation->params, &context) != VV_OK)
        return NULL;
    char one[200];
    for (const char *s = settings ? settings : ""; *s;) {
        const size_t n = strcspn(s, ";");
        snprintf(one, sizeof one, "%.*s", (int)n, s);
        char *value = strchr(one, '=');
        assert_non_null(value);
        *value++ = 0;
        if (vv_path_set(&object, one, value, &context) != VV_OK) {
            vv_object_release(object);
            return NULL;
        }
        s += n + (s[n] == ';');
    }
    return object;
}

static void check_plan(const vv_operation *operation, const vv_field *in, const vv_object *params, const vv_field *out)
{
    vv_field_info planned;
    const vv_field_info *got = vv_field_get_info(out);
    assert_int_equal(operation->plan(&planned, vv_field_get_info(in), 1, params), VV_OK);
    assert_memory_equal(planned.grid.dims, got->grid.dims, sizeof planned.grid.dims);
    assert_memory_equal(&planned.grid.index_to_world, &got->grid.index_to_world, sizeof planned.grid.index_to_world);
    assert_int_equal(planned.type, got->type);
    assert_int_equal(planned.components, got->components);
    assert_int_equal(planned.meaning, got->meaning);
}

vv_status test_apply(vv_field **out, const vv_operation *operation, const vv_field *in, const char *settings,
                     vv_job *job)
{
    *out = NULL;
    vv_object *params = test_params(operation, settings, &vv_field_get_info(in)->grid);
    if (!params)
        return vv_error_last()->status;
    const vv_status st = vv_operation_run(out, operation, &in, 1, params, job);
    if (st == VV_OK)
        check_plan(operation, in, params, *out);
    else
        assert_null(*out);
    vv_object_release(params);
    return st;
}

bool test_same_samples(const vv_field *a, const vv_field *b)
{
    return test_same_samples_by(a, b, NULL);
}

bool test_same_samples_by(const vv_field *a, const vv_field *b, vv_job *job)
{
    const vv_field_info *ia = vv_field_get_info(a), *ib = vv_field_get_info(b);
    if (memcmp(ia->grid.dims, ib->grid.dims, sizeof ia->grid.dims) || ia->type != ib->type ||
        ia->components != ib->components)
        return false;
    const vv_box all = vv_field_box(a);
    const size_t row = (size_t)all.n[0] * vv_type_bytes(ia->type) * (size_t)ia->components;
    vv_brick ba, bb;
    assert_int_equal(vv_field_brick(&ba, a, &all, job), VV_OK);
    assert_int_equal(vv_field_brick(&bb, b, &all, job), VV_OK);
    bool same = true;
    for (int64_t k = 0; k < all.n[2]; k++)
        for (int64_t j = 0; j < all.n[1]; j++)
            same = same && memcmp((const char *)ba.data + j * ba.stride[1] + k * ba.stride[2],
                                  (const char *)bb.data + j * bb.stride[1] + k * bb.stride[2], row) == 0;
    vv_brick_release(&ba);
    vv_brick_release(&bb);
    return same;
}
