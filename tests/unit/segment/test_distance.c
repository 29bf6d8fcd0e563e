/* Distances against trying every voxel of the object. */
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

enum { MOST = 3000 };

static vv_field_info info_of(const int64_t n[3], vv_type type, const double spacing[3])
{
    vv_field_info info = vv_field_info_default();
    memcpy(info.grid.dims, n, sizeof info.grid.dims);
    info.type = type;
    info.grid.index_to_world.axis[0] = (vv_vec3){0, spacing[0], 0}; /* turned: x runs along y of the world */
    info.grid.index_to_world.axis[1] = (vv_vec3){-spacing[1], 0, 0};
    info.grid.index_to_world.axis[2] = (vv_vec3){0, 0, spacing[2]};
    strcpy(info.grid.unit, "mm");
    return info;
}

/* Values 0, 1 and 2; sparse ones are far apart. */
static vv_field *speckles(const vv_field_info *info, double share, uint64_t seed)
{
    static double v[MOST];
    vv_field *field;
    void *data;
    const size_t n = (size_t)(info->grid.dims[0] * info->grid.dims[1] * info->grid.dims[2]);
    for (size_t i = 0; i < n; i++)
        v[i] = test_random_unit(seed, i) < share ? 1 + (double)(test_random(seed, i + MOST) % 2) : 0;
    assert_int_equal(vv_field_new_empty(&field, &data, info, NULL), VV_OK);
    vvi_samples_from_f64(data, v, info->type, n);
    return field;
}

static bool is_of(double v, int of)
{
    return of ? v == of : v != 0;
}

/* From a voxel to the nearest one that is of the object, or is not. */
static double nearest(const vv_field *in, const int64_t at[3], int of, bool object, const double spacing[3])
{
    const int64_t *n = vv_field_get_info(in)->grid.dims;
    double best = INFINITY;
    for (int64_t k = 0; k < n[2]; k++)
        for (int64_t j = 0; j < n[1]; j++)
            for (int64_t i = 0; i < n[0]; i++) {
                const double x = (double)(i - at[0]) * spacing[0], y = (double)(j - at[1]) * spacing[1];
                const double z = (double)(k - at[2]) * spacing[2], d = x * x + y * y + z * z;
                if (d < best && is_of(vv_field_value(in, i, j, k, 0), of) == object)
                    best = d;
            }
    return sqrt(best);
}

static void try(const vv_field_info *info, const double spacing[3], double share, int side, int of, vv_job *job)
{
    static const char *const sides[] = {"outside", "inside", "both"};
    char settings[64];
    vv_field *in = speckles(info, share, test_seed() + (uint64_t)side), *out;
    snprintf(settings, sizeof settings, "side=%s%s", sides[side], of == 1 ? ";of=1" : of ? ";range=2..2.5" : "");
    if (test_apply(&out, &vvi_operation_distance, in, settings, job) != VV_OK)
        fail_msg("%s: %s", settings, vv_error_last()->message);
    assert_string_equal(vv_field_get_info(out)->value_unit, "mm");
    for (int64_t v = 0; v < info->grid.dims[0] * info->grid.dims[1] * info->grid.dims[2]; v++) {
        const int64_t at[3] = {v % info->grid.dims[0], v / info->grid.dims[0] % info->grid.dims[1],
                               v / info->grid.dims[0] / info->grid.dims[1]};
        const double to_it = side == 1 ? 0 : nearest(in, at, of, true, spacing);
        const double from_it = side == 0 ? 0 : nearest(in, at, of, false, spacing);
        const double want = side == 1 ? from_it : from_it > 0 ? -from_it : to_it;
        const double got = vv_field_value(out, at[0], at[1], at[2], 0);
        if (!(got == want || fabs(got - want) <= 2e-7 * fabs(want)))
            fail_msg("%s %s: voxel %d: %.9g, not %.9g", vv_type_name(info->type), settings, (int)v, got, want);
    }
    vv_field_release(in);
    vv_field_release(out);
}

static void distances_are_those_of_the_nearest_voxel(void **state)
{
    (void)state;
    static const int64_t sizes[][3] = {{1, 1, 1},   {33, 1, 1}, {1, 31, 1}, {1, 1, 29}, {17, 19, 1},
                                       {1, 13, 17}, {18, 1, 9}, {7, 11, 5}, {67, 3, 4}, {2, 20, 21}};
    static const double spacings[][3] = {{1, 1, 1}, {0.3, 2, 1.1}};
    static const double shares[] = {0, 0.01, 0.3, 0.97, 1};
    vv_job *job = test_job(3, 0);
    int t = 0;
    for (size_t s = 0; s < sizeof sizes / sizeof *sizes; s++)
        for (int share = 0; share < 5; share++)
            for (int side = 0; side < 3; side++, t++) {
                const double *spacing = spacings[t % 2];
                const vv_field_info info = info_of(sizes[s], (vv_type)(t % VV_TYPE_COUNT), spacing);
                try(&info, spacing, shares[share], side, t % 3, job);
            }
    vv_job_release(job);
}

static void nan_is_of_no_object(void **state)
{
    (void)state;
    static const float samples[5] = {NAN, 0, NAN, 1, NAN};
    static const double want[5] = {3, 2, 1, 0, 1};
    vv_field_info info = vv_field_info_default();
    vv_field *in, *out;
    info.type = VV_TYPE_F32;
    info.grid.dims[0] = 5;
    assert_int_equal(vv_field_new(&in, &info, samples, 0, NULL, NULL, NULL), VV_OK);
    assert_int_equal(test_apply(&out, &vvi_operation_distance, in, NULL, NULL), VV_OK);
    for (int i = 0; i < 5; i++)
        assert_true(vv_field_value(out, i, 0, 0, 0) == want[i]);
    vv_field_release(in);
    vv_field_release(out);
}

static void what_makes_no_sense_is_refused(void **state)
{
    (void)state;
    vv_field_info info = vv_field_info_default();
    info.grid.dims[0] = info.grid.dims[1] = 4;
    vv_field *in = test_field_random(&info, 1, NULL), *out;
    static const char *const wrong[] = {"of=1;range=1..2", "range=2..1", "side=top"};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++)
        assert_int_equal(test_apply(&out, &vvi_operation_distance, in, wrong[i], NULL), VV_E_ARGUMENT);
    vv_field_release(in);
    info.grid.index_to_world.axis[1].x = 0.3;
    in = test_field_random(&info, 1, NULL);
    assert_int_equal(test_apply(&out, &vvi_operation_distance, in, NULL, NULL), VV_E_UNSUPPORTED);
    vv_field_release(in);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(distances_are_those_of_the_nearest_voxel),
        cmocka_unit_test(nan_is_of_no_object),
        cmocka_unit_test(what_makes_no_sense_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
