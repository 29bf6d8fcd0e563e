/* Filters of values: the same bytes for any number of threads and any box, whose truth tests/cli has. */
#include "core/cpu.h"
#include "fields.h"
#include "filter/normals_kernel.h"
#include "operations.h"
#include "registry.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

static vv_field *random_field(vv_type type, int components, double scale, uint64_t seed)
{
    vv_field_info info = vv_field_info_default();
    info.type = type;
    info.grid.dims[0] = 301, info.grid.dims[1] = 11, info.grid.dims[2] = 5;
    info.components = components;
    info.value_scale = scale;
    return test_field_random(&info, seed, NULL);
}

static void all_ways(const vv_operation *operation, const char *const *settings, vv_type type, int second)
{
    vv_field *in = random_field(type, 2, type == VV_TYPE_I16 ? -0.5 : 1, 8);
    vv_field *other = second ? random_field(type, second, 2, 9) : NULL;
    const vv_field *inputs[] = {in, other};
    for (; *settings; settings++)
        vv_field_release(test_apply_all_ways(operation, inputs, second ? 2 : 1, *settings));
    vv_field_release(in);
    vv_field_release(other);
}

static void clamping_is_the_same_in_all_ways(void **state)
{
    static const char *const settings[] = {"range=\"-20..50\"", "range=\"3..\";below=0", NULL};
    for (vv_type type = 0; type < VV_TYPE_COUNT; type++)
        all_ways(&vvi_operation_clamp, settings, type, 0);
}

static void masking_is_the_same_in_all_ways(void **state)
{
    static const char *const settings[] = {"", "invert=true;fill=9", "label=[2,4,6]", NULL};
    for (vv_type type = 0; type < VV_TYPE_COUNT; type++) {
        all_ways(&vvi_operation_mask, settings, type, 1);
        all_ways(&vvi_operation_mask, settings, type, 2);
    }
}

static void merging_is_the_same_in_all_ways(void **state)
{
    static const char *const settings[] = {"", "names=\"a,b,c\"", NULL};
    for (vv_type type = 0; type < VV_TYPE_COUNT; type++)
        all_ways(&vvi_operation_merge, settings, type, 1);
}

static uint64_t mixed(uint64_t v)
{
    v = (v ^ v >> 30) * 0xbf58476d1ce4e5b9;
    v = (v ^ v >> 27) * 0x94d049bb133111eb;
    return v ^ v >> 31;
}

/* Box & Muller's formula with the C library's functions; every build gives the same bits. */
static void normal_numbers_are_those_of_the_formula(void **state)
{
    enum { MOST = 5000 };
    static double a[2][MOST + VVI_NORMALS_GUARD], b[2][MOST + VVI_NORMALS_GUARD];
    static const int64_t sizes[] = {MOST, 1, 7, 8, 9, 257};
    for (size_t k = 0; vvi_normals_kernels_nth(k); k++)
        for (uint64_t c = 0; c < sizeof sizes / sizeof *sizes; c++) {
            const uint64_t seed = mixed(c), first = c * 1000003;
            const int64_t n = sizes[c];
            if (vvi_normals_kernels_nth(k)->needs & ~vvi_cpu_detect())
                continue;
            vvi_normals_kernels_for(0)->make(a[0], b[0], seed, first, n);
            vvi_normals_kernels_nth(k)->make(a[1], b[1], seed, first, n);
            assert_memory_equal(a[0], a[1], (size_t)n * sizeof *a[0]);
            assert_memory_equal(b[0], b[1], (size_t)n * sizeof *b[0]);
            for (uint64_t i = 0; i < (uint64_t)n; i++) {
                const uint64_t key = mixed(seed + (first + i + 1) * VVI_NORMALS_STEP);
                const double u = (double)((mixed(key + VVI_NORMALS_STEP) >> 11) + 1) * 0x1p-53;
                const double v = (double)((mixed(key + 2 * VVI_NORMALS_STEP) >> 11) + 1) * 0x1p-53;
                const double length = sqrt(-2 * log(u)), angle = 6.283185307179586 * v;
                assert_true(fabs(a[1][i] - length * cos(angle)) < 1e-14);
                assert_true(fabs(b[1][i] - length * sin(angle)) < 1e-14);
            }
        }
}

static void noise_is_the_same_in_all_ways(void **state)
{
    static const char *const settings[] = {"sigma=3", "kind=\"poisson\"", "kind=\"rician\";seed=9",
                                           "kind=\"salt-and-pepper\"", NULL};
    for (vv_type type = 0; type < VV_TYPE_COUNT; type++)
        all_ways(&vvi_operation_add_noise, settings, type, 0);
}

static void histograms_are_changed_the_same_in_all_ways(void **state)
{
    static const char *const settings[] = {"", NULL};
    static const char *const tiles[] = {"", "method=\"adaptive\"", "method=\"adaptive\";tile=\"3\";clip=1.5", NULL};
    for (vv_type type = 0; type < VV_TYPE_COUNT; type++) {
        all_ways(&vvi_operation_equalize, tiles, type, 0);
        if (type != VV_TYPE_I16) /* whose values fall */
            all_ways(&vvi_operation_match, settings, type, 2);
    }
}

/* Each channel has its own, or all have the one. */
static void channels_of_a_mask_go_each_with_its_own(void **state)
{
    for (int channels = 1; channels < 3; channels++) {
        vv_field *in = random_field(VV_TYPE_U8, 2, 1, 1), *mask = random_field(VV_TYPE_I8, channels, 3, 2);
        const vv_field *inputs[] = {in, mask};
        vv_field *out = test_apply_all_ways(&vvi_operation_mask, inputs, 2, "label=[6,-9,0]");
        for (int64_t n = 0; n < 2 * 301 * 55; n++) {
            const int64_t i = n / 2 % 301, j = n / 602 % 11, k = n / 6622;
            const int c = (int)(n % 2);
            const double label = vv_field_value(mask, i, j, k, channels > 1 ? c : 0);
            const bool kept = label == 6 || label == -9 || label == 0;
            assert_true(vv_field_value(out, i, j, k, c) == (kept ? vv_field_value(in, i, j, k, c) : 0));
        }
        vv_field_release(out);
        vv_field_release(in);
        vv_field_release(mask);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(clamping_is_the_same_in_all_ways),
        cmocka_unit_test(masking_is_the_same_in_all_ways),
        cmocka_unit_test(merging_is_the_same_in_all_ways),
        cmocka_unit_test(normal_numbers_are_those_of_the_formula),
        cmocka_unit_test(noise_is_the_same_in_all_ways),
        cmocka_unit_test(histograms_are_changed_the_same_in_all_ways),
        cmocka_unit_test(channels_of_a_mask_go_each_with_its_own),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
