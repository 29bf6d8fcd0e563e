/* Medians against sorting every window, for every type, size, radius and instruction set. */
#include "core/cpu.h"
#include "fields.h"
#include "filter/median_kernel.h"
#include "grid/field.h"
#include "jobs.h"
#include "operations.h"
#include "registry.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static vv_field_info info_of(int64_t x, int64_t y, int64_t z, vv_type type, int components)
{
    vv_field_info info = vv_field_info_default();
    info.grid.dims[0] = x, info.grid.dims[1] = y, info.grid.dims[2] = z;
    info.type = type;
    info.components = components;
    strcpy(info.grid.unit, "mm");
    return info;
}

static vv_field *median_of(const vv_field *in, const char *settings, vv_job *job)
{
    vv_field *out;
    if (test_apply(&out, &vvi_operation_median, in, settings, job) != VV_OK)
        fail_msg("%s: %s", settings ? settings : "no settings", vv_error_last()->message);
    return out;
}

/* Where a sample of packed fields lies, clamped to the grid. */
static size_t index_of(const vv_field_info *info, int64_t i, int64_t j, int64_t k, int c)
{
    const int64_t *d = info->grid.dims;
    const int64_t at[3] = {i < 0       ? 0
                           : i >= d[0] ? d[0] - 1
                                       : i,
                           j < 0       ? 0
                           : j >= d[1] ? d[1] - 1
                                       : j,
                           k < 0       ? 0
                           : k >= d[2] ? d[2] - 1
                                       : k};
    return (size_t)(((at[2] * d[1] + at[1]) * d[0] + at[0]) * info->components + c);
}

#define ONE_TYPE(ctype, name)                                                                                          \
    static int compare_##name(const void *a, const void *b)                                                            \
    {                                                                                                                  \
        const ctype x = *(const ctype *)a, y = *(const ctype *)b;                                                      \
        return (x > y) - (x < y);                                                                                      \
    }                                                                                                                  \
    static bool right_##name(const void *in, const void *out, const vv_field_info *info, const int64_t r[3],           \
                             int64_t i, int64_t j, int64_t k, int c)                                                   \
    {                                                                                                                  \
        static ctype window[4096];                                                                                     \
        const ctype *v = in, got = ((const ctype *)out)[index_of(info, i, j, k, c)];                                   \
        size_t n = 0;                                                                                                  \
        if (isnan((double)v[index_of(info, i, j, k, c)]))                                                              \
            return isnan((double)got);                                                                                 \
        for (int64_t z = -r[2]; z <= r[2]; z++)                                                                        \
            for (int64_t y = -r[1]; y <= r[1]; y++)                                                                    \
                for (int64_t x = -r[0]; x <= r[0]; x++) {                                                              \
                    const ctype w = v[index_of(info, i + x, j + y, k + z, c)];                                         \
                    if (!isnan((double)w))                                                                             \
                        window[n++] = w;                                                                               \
                }                                                                                                      \
        qsort(window, n, sizeof *window, compare_##name);                                                              \
        const ctype a = window[(n - 1) / 2], b = window[n / 2];                                                        \
        return n % 2 ? got == a : got == (ctype)(0.5 * (double)a + 0.5 * (double)b);                                   \
    }
ONE_TYPE(uint8_t, u8)
ONE_TYPE(int8_t, i8)
ONE_TYPE(uint16_t, u16)
ONE_TYPE(int16_t, i16)
ONE_TYPE(uint32_t, u32)
ONE_TYPE(int32_t, i32)
ONE_TYPE(uint64_t, u64)
ONE_TYPE(int64_t, i64)
ONE_TYPE(float, f32)
ONE_TYPE(double, f64)

typedef bool right_fn(const void *in, const void *out, const vv_field_info *info, const int64_t r[3], int64_t i,
                      int64_t j, int64_t k, int c);
static right_fn *const right[VV_TYPE_COUNT] = {
    [VV_TYPE_U8] = right_u8,   [VV_TYPE_I8] = right_i8,   [VV_TYPE_U16] = right_u16, [VV_TYPE_I16] = right_i16,
    [VV_TYPE_U32] = right_u32, [VV_TYPE_I32] = right_i32, [VV_TYPE_U64] = right_u64, [VV_TYPE_I64] = right_i64,
    [VV_TYPE_F32] = right_f32, [VV_TYPE_F64] = right_f64,
};

static void expect_sorted(const vv_field *in, const vv_field *out, const int64_t radius[3])
{
    const vv_field_info *info = vv_field_get_info(in);
    const int64_t *d = info->grid.dims;
    const vv_box all = vv_field_box(in);
    int64_t r[3];
    vv_brick from, to;
    assert_int_equal(vv_field_brick(&from, in, &all, NULL), VV_OK);
    assert_int_equal(vv_field_brick(&to, out, &all, NULL), VV_OK);
    for (int a = 0; a < 3; a++)
        r[a] = d[a] == 1 ? 0 : radius[a];
    for (int64_t k = 0; k < d[2]; k++)
        for (int64_t j = 0; j < d[1]; j++)
            for (int64_t i = 0; i < d[0]; i++)
                for (int c = 0; c < info->components; c++)
                    if (!right[info->type](from.data, to.data, info, r, i, j, k, c))
                        fail_msg("%s (%d %d %d) %d: wrong median", vv_type_name(info->type), (int)i, (int)j, (int)k, c);
    vv_brick_release(&from);
    vv_brick_release(&to);
}

static void try(const int64_t dims[3], vv_type type, int components, const int64_t r[3], uint64_t seed)
{
    const vv_field_info info = info_of(dims[0], dims[1], dims[2], type, components);
    char settings[96];
    snprintf(settings, sizeof settings, "radius_voxels=[%d,%d,%d]", (int)r[0], (int)r[1], (int)r[2]);
    vv_field *in = test_field_random(&info, seed, NULL), *out = median_of(in, settings, NULL);
    expect_sorted(in, out, r);
    vv_field_release(in);
    vv_field_release(out);
}

static void every_type_and_window_equals_a_sorted_window(void **state)
{
    (void)state;
    static const int64_t radii[][3] = {{1, 1, 1}, {1, 1, 0}, {0, 1, 1}, {1, 0, 1}, {1, 0, 0}, {0, 1, 0},
                                       {0, 0, 1}, {2, 1, 1}, {2, 2, 2}, {0, 3, 1}, {0, 0, 0}};
    const uint64_t seed = test_seed();
    for (int t = 0; t < VV_TYPE_COUNT; t++)
        for (size_t r = 0; r < sizeof radii / sizeof *radii; r++)
            try((int64_t[]){13, 5, 4}, (vv_type)t, 1 + t % 3, radii[r], seed + (uint64_t)t);
}

static void all_sizes_equal_a_sorted_window(void **state)
{
    (void)state;
    static const int64_t sizes[][3] = {{1, 1, 1},   {1, 9, 1},   {1, 1, 9},   {2, 3, 1},   {125, 2, 2}, {126, 3, 2},
                                       {127, 2, 3}, {128, 2, 1}, {129, 3, 3}, {257, 3, 2}, {3, 29, 31}};
    for (size_t s = 0; s < sizeof sizes / sizeof *sizes; s++) {
        try(sizes[s], VV_TYPE_U8, 1, (int64_t[]){1, 1, 1}, s);
        try(sizes[s], VV_TYPE_F32, 1, (int64_t[]){1, 1, 1}, s);
        try(sizes[s], VV_TYPE_I16, 1, (int64_t[]){1, 2, 1}, s);
        try(sizes[s], VV_TYPE_F64, 1, (int64_t[]){4, 1, 1}, s);
    }
}

/* Ties, infinities, both zeros, and NaN: those do not count, and stay. */
static void floats_with_holes_equal_a_sorted_window(void **state)
{
    (void)state;
    static const double odd[] = {NAN, INFINITY, -INFINITY, -0.0, 0.0, 1, 1, 2};
    for (int wide = 0; wide < 2; wide++)
        for (int64_t radius = 1; radius < 3; radius++) {
            const vv_field_info info = info_of(17, 9, 5, wide ? VV_TYPE_F64 : VV_TYPE_F32, 1);
            const int64_t r[3] = {radius, 1, radius};
            char settings[96];
            vv_field *in;
            void *data;
            assert_int_equal(vv_field_new_empty(&in, &data, &info, NULL), VV_OK);
            for (size_t i = 0; i < 17 * 9 * 5; i++) {
                const uint64_t random = test_random(3, i);
                const double v = random % 4 ? odd[random / 4 % 3 ? 3 + random / 16 % 5 : random / 16 % 3] : (double)i;
                if (wide)
                    ((double *)data)[i] = isinf(v) && random % 32 ? 7 : v;
                else
                    ((float *)data)[i] = (float)(isinf(v) && random % 32 ? 7 : v);
            }
            snprintf(settings, sizeof settings, "radius_voxels=[%d,1,%d]", (int)radius, (int)radius);
            vv_field *out = median_of(in, settings, NULL);
            expect_sorted(in, out, r);
            vv_field_release(in);
            vv_field_release(out);
        }
}

static void every_instruction_set_gives_the_same(void **state)
{
    (void)state;
    const vv_field_info info = info_of(131, 7, 5, VV_TYPE_U16, 1);
    vv_field *in = test_field_random(&info, 5, NULL), *first = median_of(in, NULL, NULL);
    uint8_t keys[9][VVI_MEDIAN_GUARD + 300], want[300], got[300];
    const void *rows[9];
    for (int r = 0; r < 9; r++) {
        rows[r] = keys[r];
        for (size_t i = 0; i < sizeof keys[r]; i++)
            keys[r][i] = (uint8_t)test_random((uint64_t)r, i);
    }
    vvi_median_kernels_for(0)->of_bytes[0](want, rows, 9, 3, 298);
    for (size_t b = 0; vvi_median_kernels_nth(b); b++) {
        const vvi_median_kernels *kernels = vvi_median_kernels_nth(b);
        if (kernels->needs & ~vvi_cpu_detect())
            continue;
        kernels->of_bytes[0](got, rows, 9, 3, 298);
        assert_memory_equal(got, want, 298);
    }
    expect_sorted(in, first, (int64_t[]){1, 1, 1});
    vv_field_release(in);
    vv_field_release(first);
}

static void radius_is_a_length_and_voxels_are_of_each_axis(void **state)
{
    (void)state;
    vv_field_info info = info_of(9, 9, 9, VV_TYPE_F64, 1);
    info.grid.index_to_world.axis[0].x = 0.5;
    info.grid.index_to_world.axis[2].z = 4;
    vv_field *in = test_field_random(&info, 1, NULL);
    vv_field *mm = median_of(in, "radius=1mm", NULL), *vox = median_of(in, "radius_voxels=[2,1,0]", NULL);
    assert_true(test_same_samples(mm, vox));
    vv_field *plain = median_of(in, NULL, NULL), *ones = median_of(in, "radius_voxels=[1,1,1]", NULL);
    assert_true(test_same_samples(plain, ones));
    vv_field *none = median_of(in, "radius=0", NULL);
    assert_true(test_same_samples(in, none));
    vv_field *all[] = {in, mm, vox, plain, ones, none};
    for (int i = 0; i < 6; i++)
        vv_field_release(all[i]);
}

static void any_box_is_a_part_of_the_whole(void **state)
{
    (void)state;
    const vv_field_info info = info_of(23, 11, 13, VV_TYPE_F32, 2);
    vv_field *in = test_field_random(&info, 7, NULL);
    for (int r = 1; r < 4; r++) {
        char settings[64];
        snprintf(settings, sizeof settings, "radius_voxels=[%d,2,%d]", r, r);
        vv_field *whole = median_of(in, settings, NULL);
        vv_object *params = test_params(&vvi_operation_median, settings, &info.grid);
        static const vv_box boxes[] = {{{0, 0, 0}, {23, 11, 4}}, {{5, 3, 4}, {7, 6, 5}}, {{22, 10, 12}, {1, 1, 1}}};
        for (size_t b = 0; b < sizeof boxes / sizeof *boxes; b++) {
            vv_field *part;
            const vv_field *inputs[] = {in};
            assert_int_equal(vvi_operation_median.run_box(&part, inputs, 1, params, &boxes[b], NULL), VV_OK);
            for (int64_t k = 0; k < boxes[b].n[2]; k++)
                for (int64_t j = 0; j < boxes[b].n[1]; j++)
                    for (int64_t i = 0; i < boxes[b].n[0]; i++)
                        for (int c = 0; c < 2; c++)
                            assert_true(vv_field_value(part, i, j, k, c) == vv_field_value(whole, i + boxes[b].lo[0],
                                                                                           j + boxes[b].lo[1],
                                                                                           k + boxes[b].lo[2], c));
            vv_field_release(part);
        }
        vv_object_release(params);
        vv_field_release(whole);
    }
    vv_field_release(in);
}

static void what_makes_no_sense_is_refused(void **state)
{
    (void)state;
    vv_field_info info = info_of(40, 40, 40, VV_TYPE_U8, 1);
    vv_field *in = test_field_random(&info, 1, NULL), *out;
    static const char *const wrong[] = {"radius_voxels=[16,16,16]", "radius_voxels=[1.5,1,1]", "radius_voxels=[-1,1,1]",
                                        "radius=1;radius_voxels=[1,1,1]"};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++)
        assert_int_equal(test_apply(&out, &vvi_operation_median, in, wrong[i], NULL), VV_E_ARGUMENT);
    vv_field_release(in);
    info.meaning = VV_MEANING_LABEL;
    in = test_field_random(&info, 1, NULL);
    assert_int_equal(test_apply(&out, &vvi_operation_median, in, NULL, NULL), VV_E_UNSUPPORTED);
    vv_field_release(in);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_type_and_window_equals_a_sorted_window),
        cmocka_unit_test(all_sizes_equal_a_sorted_window),
        cmocka_unit_test(floats_with_holes_equal_a_sorted_window),
        cmocka_unit_test(every_instruction_set_gives_the_same),
        cmocka_unit_test(radius_is_a_length_and_voxels_are_of_each_axis),
        cmocka_unit_test(any_box_is_a_part_of_the_whole),
        cmocka_unit_test(what_makes_no_sense_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
