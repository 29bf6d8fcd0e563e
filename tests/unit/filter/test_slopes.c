/* Gradients and Laplacians of closed forms, which differences give exactly, on straight and sheared grids; NaN, scales,
 * boxes. */
#include "core/cpu.h"
#include "fields.h"
#include "filter/slopes_kernel.h"
#include "grid/field.h"
#include "operations.h"
#include "registry.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

/* Of degree 2: central differences of it are exact. */
static double quadratic(vv_vec3 p)
{
    return 5 + 2 * p.x - p.y + 3 * p.x * p.x - 2 * p.y * p.y + 0.5 * p.z * p.z + p.x * p.y - 4 * p.y * p.z + p.x * p.z;
}

static vv_vec3 quadratic_gradient(vv_vec3 p)
{
    return (vv_vec3){2 + 6 * p.x + p.y + p.z, -1 - 4 * p.y + p.x - 4 * p.z, p.z - 4 * p.y + p.x};
}

#define QUADRATIC_LAPLACIAN (6 - 4 + 1)

static const test_form form = {.name = "quadratic", .value = quadratic, .gradient = quadratic_gradient};

static vv_field_info sheared(vv_type type)
{
    vv_field_info info = vv_field_info_default();
    info.grid.dims[0] = 9, info.grid.dims[1] = 8, info.grid.dims[2] = 7;
    info.grid.index_to_world = (vv_affine){
        .axis = {{0.7, 0.1, 0}, {0.3, 1.1, 0.2}, {-0.2, 0.4, 1.6}},
        .origin = {1, -2, 3},
    };
    info.type = type;
    strcpy(info.grid.unit, "mm");
    strcpy(info.value_unit, "HU");
    return info;
}

static vv_field *apply(const vv_operation *operation, const vv_field *in, const char *settings)
{
    vv_field *out;
    if (test_apply(&out, operation, in, settings, NULL) != VV_OK)
        fail_msg("%s: %s", operation->name, vv_error_last()->message);
    return out;
}

static vv_vec3 place(const vv_grid *grid, int64_t i, int64_t j, int64_t k)
{
    const vv_affine *m = &grid->index_to_world;
    const double a = (double)i, b = (double)j, c = (double)k;
    return (vv_vec3){m->origin.x + a * m->axis[0].x + b * m->axis[1].x + c * m->axis[2].x,
                     m->origin.y + a * m->axis[0].y + b * m->axis[1].y + c * m->axis[2].y,
                     m->origin.z + a * m->axis[0].z + b * m->axis[1].z + c * m->axis[2].z};
}

static void expect_quadratic(const vv_field_info *info)
{
    vv_field *in = test_field(&form, info, NULL);
    vv_field *length = apply(&vvi_operation_gradient, in, NULL),
             *vector = apply(&vvi_operation_gradient, in, "vector=true");
    vv_field *laplacian = apply(&vvi_operation_laplacian, in, NULL);
    assert_string_equal(vv_field_get_info(length)->value_unit, "HU/mm");
    assert_string_equal(vv_field_get_info(laplacian)->value_unit, "HU/mm^2");
    for (int64_t k = 1; k < 6; k++)
        for (int64_t j = 1; j < 7; j++)
            for (int64_t i = 1; i < 8; i++) {
                const vv_vec3 g = quadratic_gradient(place(&info->grid, i, j, k));
                const double want[3] = {g.x, g.y, g.z};
                for (int c = 0; c < 3; c++)
                    assert_true(fabs(vv_field_value(vector, i, j, k, c) - want[c]) < 2e-4);
                assert_true(fabs(vv_field_value(length, i, j, k, 0) - sqrt(g.x * g.x + g.y * g.y + g.z * g.z)) < 2e-4);
                assert_true(fabs(vv_field_value(laplacian, i, j, k, 0) - QUADRATIC_LAPLACIAN) < 2e-3);
            }
    vv_field *all[] = {in, length, vector, laplacian};
    for (int i = 0; i < 4; i++)
        vv_field_release(all[i]);
}

static void derivatives_are_those_of_the_world(void **state)
{
    (void)state;
    vv_field_info info = sheared(VV_TYPE_F64);
    expect_quadratic(&info);
    info.grid.index_to_world.axis[0] = (vv_vec3){0, 0.5, 0}; /* axes in another order */
    info.grid.index_to_world.axis[1] = (vv_vec3){0, 0, -2};
    info.grid.index_to_world.axis[2] = (vv_vec3){1.5, 0, 0};
    expect_quadratic(&info);
}

static void scales_of_values_are_obeyed(void **state)
{
    (void)state;
    vv_field_info info = sheared(VV_TYPE_I32);
    info.value_scale = -1e-6;
    info.value_offset = 70;
    expect_quadratic(&info);
}

/* At the border, and beside NaN, of a ramp, one-sided differences are as right as central ones. */
static void ramps_are_exact_up_to_the_border_and_beside_nan(void **state)
{
    (void)state;
    vv_field_info info = sheared(VV_TYPE_F32);
    vv_field *ramp = test_field(&test_form_ramp, &info, NULL), *in;
    const vv_box all = vv_field_box(ramp);
    vv_brick from;
    void *data;
    assert_int_equal(vv_field_brick(&from, ramp, &all, NULL), VV_OK);
    assert_int_equal(vv_field_new_empty(&in, &data, &info, NULL), VV_OK);
    memcpy(data, from.data, 9 * 8 * 7 * sizeof(float));
    vv_brick_release(&from);
    ((float *)data)[(3 * 8 + 4) * 9 + 4] = NAN;
    vv_field *out = apply(&vvi_operation_gradient, in, "vector=true");
    static const double want[3] = {2, -1, 0.5};
    for (int64_t k = 0; k < 7; k++)
        for (int64_t j = 0; j < 8; j++)
            for (int64_t i = 0; i < 9; i++)
                for (int c = 0; c < 3; c++)
                    if (i == 4 && j == 4 && k == 3)
                        assert_true(isnan(vv_field_value(out, i, j, k, c)));
                    else
                        assert_true(fabs(vv_field_value(out, i, j, k, c) - want[c]) < 1e-4);
    vv_field *laplacian = apply(&vvi_operation_laplacian, in, NULL);
    assert_true(isnan(vv_field_value(laplacian, 4, 4, 3, 0)));
    assert_true(isfinite(vv_field_value(laplacian, 5, 4, 3, 0)));
    vv_field *fields[] = {ramp, in, out, laplacian};
    for (int i = 0; i < 4; i++)
        vv_field_release(fields[i]);
}

/* Along an axis of one sample nothing changes. */
static void pictures_and_lines_have_slopes(void **state)
{
    (void)state;
    vv_field_info info = sheared(VV_TYPE_F64);
    info.grid.index_to_world = vv_affine_identity();
    info.grid.dims[1] = info.grid.dims[2] = 1;
    vv_field *in = test_field(&test_form_ramp, &info, NULL), *out = apply(&vvi_operation_gradient, in, NULL);
    for (int64_t i = 0; i < 9; i++)
        assert_true(vv_field_value(out, i, 0, 0, 0) == 2);
    vv_field_release(in);
    vv_field_release(out);
}

static void expect_part(const vv_operation *operation, const vv_field *in, const char *settings, const vv_box *box)
{
    vv_field *whole = apply(operation, in, settings), *part;
    vv_object *params = test_params(operation, settings, &vv_field_get_info(in)->grid);
    const vv_field *inputs[] = {in};
    const int components = vv_field_get_info(whole)->components;
    assert_int_equal(operation->run_box(&part, inputs, 1, params, box, NULL), VV_OK);
    for (int64_t k = 0; k < box->n[2]; k++)
        for (int64_t j = 0; j < box->n[1]; j++)
            for (int64_t i = 0; i < box->n[0]; i++)
                for (int c = 0; c < components; c++)
                    assert_true(vv_field_value(part, i, j, k, c) ==
                                vv_field_value(whole, i + box->lo[0], j + box->lo[1], k + box->lo[2], c));
    vv_object_release(params);
    vv_field_release(part);
    vv_field_release(whole);
}

static void any_box_is_a_part_of_the_whole(void **state)
{
    (void)state;
    static const vv_box boxes[] = {{{0, 0, 0}, {9, 8, 3}}, {{2, 3, 4}, {5, 4, 2}}, {{8, 7, 6}, {1, 1, 1}}};
    vv_field_info info = sheared(VV_TYPE_I16);
    info.components = 2;
    vv_field *in = test_field_random(&info, 7, NULL);
    info.components = 1;
    vv_field *one = test_field_random(&info, 7, NULL);
    for (size_t b = 0; b < sizeof boxes / sizeof *boxes; b++) {
        expect_part(&vvi_operation_gradient, in, NULL, &boxes[b]);
        expect_part(&vvi_operation_gradient, in, "sigma=0.5", &boxes[b]);
        expect_part(&vvi_operation_gradient, one, "vector=true;sigma=1", &boxes[b]);
        expect_part(&vvi_operation_laplacian, in, NULL, &boxes[b]);
        expect_part(&vvi_operation_unsharp, in, NULL, &boxes[b]);
    }
    vv_field_release(in);
    vv_field_release(one);
}

/* What a constant is, stays; NaN and infinity stay, and a type's range is not left. */
static void unsharp_keeps_what_has_no_edges(void **state)
{
    (void)state;
    vv_field_info info = sheared(VV_TYPE_U8);
    vv_field *in = test_field(&test_form_constant, &info, NULL), *out = apply(&vvi_operation_unsharp, in, "amount=5");
    assert_true(test_same_samples(in, out));
    vv_field_release(in);
    vv_field_release(out);
    in = test_field_random(&info, 3, NULL);
    out = apply(&vvi_operation_unsharp, in, "sigma=0");
    assert_true(test_same_samples(in, out));
    vv_field_release(out);
    out = apply(&vvi_operation_unsharp, in, "threshold=1000");
    assert_true(test_same_samples(in, out));
    vv_field_release(in);
    vv_field_release(out);
    info.type = VV_TYPE_F32;
    void *data;
    assert_int_equal(vv_field_new_empty(&in, &data, &info, NULL), VV_OK);
    for (int i = 0; i < 9 * 8 * 7; i++)
        ((float *)data)[i] = i == 100 ? NAN : i == 200 ? -INFINITY : 3;
    out = apply(&vvi_operation_unsharp, in, NULL);
    for (int64_t i = 0; i < 9 * 8 * 7; i++) {
        const double v = vv_field_value(out, i % 9, i / 9 % 8, i / 72, 0);
        assert_true(i == 100 ? isnan(v) : i == 200 ? v == -INFINITY : fabs(v - 3) < 1e-5);
    }
    vv_field_release(in);
    vv_field_release(out);
}

/* Random numbers, every fifth of which is missing. */
static void every_instruction_set_gives_the_same(void **state)
{
    (void)state;
    enum { ROW = 40, N = 27 };
    double numbers[5 * 3 * ROW + VVI_SLOPES_GUARD], want[3 * N], got[3 * N];
    vvi_slopes slopes = {.step = {1, ROW, 3 * ROW}, .lone = {NAN, 0, NAN}};
    for (size_t i = 0; i < sizeof numbers / sizeof *numbers; i++)
        numbers[i] = test_random(1, i) % 5 ? test_random_unit(2, i) : NAN;
    for (int a = 0; a < 9; a++) {
        slopes.world[a / 3][a % 3] = test_random_unit(3, (uint64_t)a) - 0.5;
        slopes.second[a / 3][a % 3] = test_random_unit(4, (uint64_t)(a / 3 + a % 3)) - 0.5;
    }
    const double *row = numbers + 2 * 3 * ROW + ROW + 3;
    const vvi_slopes_kernels *base = vvi_slopes_kernels_for(0);
    for (size_t b = 0; vvi_slopes_kernels_nth(b); b++) {
        const vvi_slopes_kernels *kernels = vvi_slopes_kernels_nth(b);
        if (kernels->needs & ~vvi_cpu_detect())
            continue;
        vvi_slopes_row *const rows[3][2] = {
            {base->length, kernels->length}, {base->vector, kernels->vector}, {base->laplacian, kernels->laplacian}};
        for (int r = 0; r < 3; r++) {
            const int n = r == 1 ? 3 * N : N;
            rows[r][0](want, row, &slopes, N);
            rows[r][1](got, row, &slopes, N);
            for (int i = 0; i < n; i++)
                assert_true(want[i] == got[i] || (isnan(want[i]) && isnan(got[i])));
        }
    }
}

static void what_makes_no_sense_is_refused(void **state)
{
    (void)state;
    vv_field_info info = sheared(VV_TYPE_U8);
    info.components = 2;
    vv_field *in = test_field_random(&info, 1, NULL), *out;
    assert_int_equal(test_apply(&out, &vvi_operation_gradient, in, "vector=true", NULL), VV_E_UNSUPPORTED);
    assert_int_equal(test_apply(&out, &vvi_operation_gradient, in, "sigma=5000", NULL), VV_E_ARGUMENT);
    assert_int_equal(test_apply(&out, &vvi_operation_unsharp, in, "sigma=5000", NULL), VV_E_ARGUMENT);
    assert_int_equal(test_apply(&out, &vvi_operation_unsharp, in, "amount=-2", NULL), VV_E_ARGUMENT);
    vv_field_release(in);
    info.meaning = VV_MEANING_LABEL;
    in = test_field_random(&info, 1, NULL);
    static const vv_operation *const operations[] = {&vvi_operation_gradient, &vvi_operation_laplacian,
                                                     &vvi_operation_unsharp};
    for (int i = 0; i < 3; i++)
        assert_int_equal(test_apply(&out, operations[i], in, NULL, NULL), VV_E_UNSUPPORTED);
    vv_field_release(in);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(derivatives_are_those_of_the_world),
        cmocka_unit_test(scales_of_values_are_obeyed),
        cmocka_unit_test(ramps_are_exact_up_to_the_border_and_beside_nan),
        cmocka_unit_test(pictures_and_lines_have_slopes),
        cmocka_unit_test(any_box_is_a_part_of_the_whole),
        cmocka_unit_test(unsharp_keeps_what_has_no_edges),
        cmocka_unit_test(every_instruction_set_gives_the_same),
        cmocka_unit_test(what_makes_no_sense_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
