/* Non-local means against a direct sum over all patches in double precision, on every type and size. */
#include "fields.h"
#include "grid/field.h"
#include "jobs.h"
#include "operations.h"
#include "registry.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
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

static vv_field *denoised(const vv_field *in, const char *settings)
{
    vv_field *out;
    if (test_apply(&out, &vvi_operation_denoise, in, settings, NULL) != VV_OK)
        fail_msg("%s: %s", settings ? settings : "no settings", vv_error_last()->message);
    return out;
}

/* A step of 60 along x under noise of +-10, in the range of every type. */
static vv_field *noisy_step(const vv_field_info *info, uint64_t seed)
{
    vv_field *field;
    void *data;
    const size_t row = (size_t)(info->grid.dims[0] * info->components);
    const size_t n = row * (size_t)(info->grid.dims[1] * info->grid.dims[2]), each = vv_type_bytes(info->type);
    assert_int_equal(vv_field_new_empty(&field, &data, info, NULL), VV_OK);
    for (size_t i = 0; i < n; i++) {
        const double v = (i % row > row / 2 ? 90 : 30) + 20 * test_random_unit(seed, i);
        vvi_samples_from_f64((char *)data + i * each, &v, info->type, 1);
    }
    return field;
}

/* What the samples at two places and around them differ by; pairs with one that is not finite differ by noise. */
static double distance(const vv_field *f, const int64_t a[3], const int64_t b[3], int c, const int64_t patch[3],
                       double noise)
{
    double sum = 0, n = 0;
    for (int64_t k = -patch[2]; k <= patch[2]; k++)
        for (int64_t j = -patch[1]; j <= patch[1]; j++)
            for (int64_t i = -patch[0]; i <= patch[0]; i++, n++) {
                const double d = vv_field_value(f, b[0] + i, b[1] + j, b[2] + k, c) -
                                 vv_field_value(f, a[0] + i, a[1] + j, a[2] + k, c);
                sum += isfinite(d) ? d * d : 2 * noise * noise;
            }
    return sum / n;
}

typedef struct setting {
    int64_t search[3], patch[3];
    double noise, strength;
} setting;

/* Places beyond the border are those of the border, and so are the patches around them. */
static double direct(const vv_field *f, const int64_t at[3], int c, const setting *s)
{
    const int64_t *dims = vv_field_get_info(f)->grid.dims;
    double sum = 0, weights = 0;
    int64_t r[3], patch[3];
    for (int a = 0; a < 3; a++) {
        r[a] = dims[a] == 1 ? 0 : s->search[a];
        patch[a] = dims[a] == 1 ? 0 : s->patch[a];
    }
    for (int64_t k = -r[2]; k <= r[2]; k++)
        for (int64_t j = -r[1]; j <= r[1]; j++)
            for (int64_t i = -r[0]; i <= r[0]; i++) {
                const int64_t to[3] = {at[0] + i, at[1] + j, at[2] + k};
                const double u = vv_field_value(f, to[0], to[1], to[2], c);
                if (!isfinite(u))
                    continue;
                const double far = distance(f, at, to, c, patch, s->noise) - 2 * s->noise * s->noise;
                const double w = exp(-fmax(far, 0) / (s->strength * s->strength * s->noise * s->noise));
                sum += w * u;
                weights += w;
            }
    return sum / weights;
}

static void expect_direct(const vv_field *in, const vv_field *out, const setting *s)
{
    const vv_field_info *info = vv_field_get_info(in);
    const int64_t *d = info->grid.dims;
    const double tolerance = (vv_type_is_float(info->type) ? 2e-4 : 0.5002) * fabs(info->value_scale);
    for (int64_t k = 0; k < d[2]; k++)
        for (int64_t j = 0; j < d[1]; j++)
            for (int64_t i = 0; i < d[0]; i++)
                for (int c = 0; c < info->components; c++) {
                    const int64_t at[3] = {i, j, k};
                    const double was = vv_field_value(in, i, j, k, c), got = vv_field_value(out, i, j, k, c);
                    if (!isfinite(was)) {
                        assert_true(isnan(was) ? isnan(got) : got == was);
                        continue;
                    }
                    const double want = direct(in, at, c, s);
                    if (!(fabs(got - want) <= tolerance))
                        fail_msg("%s (%d %d %d): %.9g is not %.9g", vv_type_name(info->type), (int)i, (int)j, (int)k,
                                 got, want);
                }
}

static void every_type_and_size_equals_a_direct_sum(void **state)
{
    (void)state;
    static const int64_t sizes[][3] = {{37, 5, 4}, {1, 1, 1}, {1, 9, 2}, {2, 1, 9}, {131, 3, 1}};
    static const setting s = {{2, 1, 1}, {1, 2, 1}, 6, 1.5};
    const uint64_t seed = test_seed();
    for (int t = 0; t < VV_TYPE_COUNT; t++)
        for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
            const vv_field_info info = info_of(sizes[i][0], sizes[i][1], sizes[i][2], (vv_type)t, 1 + t % 3);
            vv_field *in = noisy_step(&info, seed + i);
            vv_field *out = denoised(in, "search_voxels=[2,1,1];patch_voxels=[1,2,1];noise=6;strength=1.5");
            expect_direct(in, out, &s);
            vv_field_release(in);
            vv_field_release(out);
        }
}

static void what_is_missing_does_not_count_and_stays(void **state)
{
    (void)state;
    static const setting s = {{3, 3, 3}, {1, 1, 1}, 20, 0.8};
    for (int wide = 0; wide < 2; wide++) {
        const vv_field_info info = info_of(19, 7, 5, wide ? VV_TYPE_F64 : VV_TYPE_F32, 1);
        vv_field *in;
        void *data;
        assert_int_equal(vv_field_new_empty(&in, &data, &info, NULL), VV_OK);
        for (size_t i = 0; i < 19 * 7 * 5; i++) {
            const uint64_t random = test_random(3, i);
            const double v = random % 9   ? (double)(random / 8 % 100)
                             : random % 2 ? NAN
                             : random % 4 ? INFINITY
                                          : -INFINITY;
            vvi_samples_from_f64((char *)data + i * vv_type_bytes(info.type), &v, info.type, 1);
        }
        vv_field *out = denoised(in, "noise=20");
        expect_direct(in, out, &s);
        vv_field_release(in);
        vv_field_release(out);
    }
}

static void lengths_and_values_are_those_of_the_world(void **state)
{
    (void)state;
    static const setting s = {{4, 2, 1}, {2, 1, 1}, 1.5, 0.8};
    vv_field_info info = info_of(23, 9, 7, VV_TYPE_I16, 1);
    info.grid.index_to_world.axis[0].x = 0.5;
    info.grid.index_to_world.axis[2].z = 2;
    info.value_scale = -0.25;
    info.value_offset = 1000;
    vv_field *in = noisy_step(&info, 9), *out = denoised(in, "search=2mm;patch=1.1mm;noise=1.5");
    expect_direct(in, out, &s);
    vv_field *none = denoised(in, "noise=0"), *weak = denoised(in, "strength=0"), *here = denoised(in, "search=0");
    assert_true(test_same_samples(in, none));
    assert_true(test_same_samples(in, weak));
    assert_true(test_same_samples(in, here));
    vv_field *all[] = {in, out, none, weak, here};
    for (int i = 0; i < 5; i++)
        vv_field_release(all[i]);
}

static void of_a_noisy_step_most_noise_goes_and_the_step_stays(void **state)
{
    (void)state;
    const vv_field_info info = info_of(40, 31, 30, VV_TYPE_F32, 1);
    vv_field *in = noisy_step(&info, 4), *out = denoised(in, NULL);
    double before = 0, after = 0;
    for (int64_t i = 0; i < 40 * 31 * 30; i++) {
        const double truth = i % 40 > 20 ? 100 : 40;
        const double was = vv_field_value(in, i % 40, i / 40 % 31, i / 1240, 0) - truth;
        const double is = vv_field_value(out, i % 40, i / 40 % 31, i / 1240, 0) - truth;
        before += was * was;
        after += is * is;
    }
    assert_true(after < before / 9);
    vv_field_release(in);
    vv_field_release(out);
}

static void what_makes_no_sense_is_refused(void **state)
{
    (void)state;
    vv_field_info info = info_of(40, 40, 40, VV_TYPE_U8, 1);
    vv_field *in = test_field_random(&info, 1, NULL), *out;
    static const char *const wrong[] = {"search_voxels=[31,1,1]", "patch_voxels=[17,1,1]", "noise=-1",
                                        "search=1;search_voxels=[1,1,1]", "patch_voxels=[0.5,1,1]"};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++)
        assert_int_equal(test_apply(&out, &vvi_operation_denoise, in, wrong[i], NULL), VV_E_ARGUMENT);
    vv_field_release(in);
    info.meaning = VV_MEANING_LABEL;
    in = test_field_random(&info, 1, NULL);
    assert_int_equal(test_apply(&out, &vvi_operation_denoise, in, NULL, NULL), VV_E_UNSUPPORTED);
    vv_field_release(in);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_type_and_size_equals_a_direct_sum),
        cmocka_unit_test(what_is_missing_does_not_count_and_stays),
        cmocka_unit_test(lengths_and_values_are_those_of_the_world),
        cmocka_unit_test(of_a_noisy_step_most_noise_goes_and_the_step_stays),
        cmocka_unit_test(what_makes_no_sense_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
