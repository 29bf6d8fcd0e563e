#include "operations.h"
#include "fields.h"
#include "jobs.h"

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

static void check_plan(const vv_operation *operation, const vv_field *const *inputs, size_t n, const vv_object *params,
                       const vv_field *out)
{
    vv_field_info planned, infos[16] = {0};
    const vv_field_info *got = vv_field_get_info(out);
    for (size_t i = 0; i < n; i++)
        if (inputs[i])
            infos[i] = *vv_field_get_info(inputs[i]);
    assert_int_equal(operation->plan(&planned, infos, n, params), VV_OK);
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
        check_plan(operation, &in, 1, params, *out);
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

static vv_field *run_with(const vv_operation *operation, const vv_field *const *inputs, size_t n, const char *settings,
                          int threads)
{
    vv_job *job = test_job(threads, 0);
    vv_field *out = NULL;
    vv_object *params = test_params(operation, settings, &vv_field_get_info(inputs[0])->grid);
    if (!params || vv_operation_run(&out, operation, inputs, n, params, job) != VV_OK)
        fail_msg("%s %s: %s", operation->name, settings, vv_error_last()->message);
    check_plan(operation, inputs, n, params, out);
    vv_object_release(params);
    vv_job_release(job);
    return out;
}

/* A box that depends on `seed`, somewhere in the grid. */
static vv_box some_box(const int64_t dims[3], uint64_t seed)
{
    vv_box box;
    for (int a = 0; a < 3; a++) {
        box.lo[a] = (int64_t)(test_random(seed, (uint64_t)a) % (uint64_t)dims[a]);
        box.n[a] = 1 + (int64_t)(test_random(seed, 3 + (uint64_t)a) % (uint64_t)(dims[a] - box.lo[a]));
    }
    return box;
}

static void check_box(const vv_field *part, const vv_field *whole, const vv_box *box)
{
    const vv_field_info *info = vv_field_get_info(whole);
    const size_t row = (size_t)box->n[0] * vv_type_bytes(info->type) * (size_t)info->components;
    const vv_box all = vv_field_box(part);
    vv_brick a, b;
    assert_memory_equal(all.n, box->n, sizeof all.n);
    assert_int_equal(vv_field_brick(&a, part, &all, NULL), VV_OK);
    assert_int_equal(vv_field_brick(&b, whole, box, NULL), VV_OK);
    for (int64_t k = 0; k < box->n[2]; k++)
        for (int64_t j = 0; j < box->n[1]; j++)
            assert_memory_equal((const char *)a.data + j * a.stride[1] + k * a.stride[2],
                                (const char *)b.data + j * b.stride[1] + k * b.stride[2], row);
    vv_brick_release(&a);
    vv_brick_release(&b);
}

vv_field *test_apply_all_ways(const vv_operation *operation, const vv_field *const *inputs, size_t n,
                              const char *settings)
{
    vv_field *out = run_with(operation, inputs, n, settings, 1), *again = run_with(operation, inputs, n, settings, 3);
    if (!test_same_samples(out, again))
        fail_msg("%s %s: three threads make other bytes than one", operation->name, settings);
    vv_field_release(again);
    vv_object *params = test_params(operation, settings, &vv_field_get_info(inputs[0])->grid);
    for (uint64_t i = 0; i < 5 && operation->run_box; i++) {
        const vv_box box = some_box(vv_field_get_info(out)->grid.dims, i + 1);
        vv_field *part = NULL;
        if (operation->run_box(&part, inputs, n, params, &box, NULL) != VV_OK)
            fail_msg("%s %s: %s", operation->name, settings, vv_error_last()->message);
        check_box(part, out, &box);
        vv_field_release(part);
    }
    vv_object_release(params);
    return out;
}
