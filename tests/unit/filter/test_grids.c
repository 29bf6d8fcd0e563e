/* Filters that change the grid: the same bytes for any number of threads and any box, whose truth tests/cli has. */
#include "core/cpu.h"
#include "fields.h"
#include "filter/project_kernel.h"
#include "operations.h"
#include "registry.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

static vv_field *random_field(vv_type type, int64_t x, int64_t y, int64_t z, int components)
{
    vv_field_info info = vv_field_info_default();
    info.type = type;
    info.grid.dims[0] = x, info.grid.dims[1] = y, info.grid.dims[2] = z;
    info.grid.index_to_world = (vv_affine){{{0.5, 0, 0.1}, {0, 2, 0}, {-0.1, 0, 3}}, {10, -20, 30}};
    info.components = components;
    strcpy(info.grid.unit, "mm");
    return test_field_random(&info, 8, NULL);
}

static void all_ways(const vv_operation *operation, const char *const *settings, vv_type type, int64_t x, int64_t y,
                     int64_t z)
{
    vv_field *in = random_field(type, x, y, z, 2);
    const vv_field *inputs[] = {in};
    for (; *settings; settings++)
        vv_field_release(test_apply_all_ways(operation, inputs, 1, *settings));
    vv_field_release(in);
}

static void padding_is_the_same_in_all_ways(void **state)
{
    static const char *const settings[] = {"all=\"3\"",
                                           "x=\"2,5\";z=\"4,0\";border=\"mirror\"",
                                           "y=\"9\";border=\"wrap\"",
                                           "all=\"20,1\";border=\"nearest\"",
                                           "size=[40,30,20];value=1",
                                           NULL};
    for (vv_type type = 0; type < VV_TYPE_COUNT; type++)
        all_ways(&vvi_operation_pad, settings, type, 13, 11, 7);
    all_ways(&vvi_operation_pad, settings, VV_TYPE_U16, 1, 9, 1);
}

static void projecting_is_the_same_in_all_ways(void **state)
{
    static const char *const axes[] = {"x", "y", "z"};
    static const char *const methods[] = {"maximum", "minimum", "mean", "sum", "deviation", "median"};
    for (vv_type type = 0; type < VV_TYPE_COUNT; type++)
        for (int a = 0; a < 3; a++)
            for (int m = 0; m < 6; m++) {
                char all[60], some[80], each[100];
                snprintf(all, sizeof all, "axis=\"%s\";method=\"%s\"", axes[a], methods[m]);
                snprintf(some, sizeof some, "%s;slab=\"4\"", all);
                snprintf(each, sizeof each, "%s;slab=\"3\";sliding=true", all);
                const char *const settings[] = {all, some, each, NULL};
                all_ways(&vvi_operation_project, settings, type, 13, 11, 7);
            }
}

/* Of random bits, which floats among them are NaN and infinite, too; lengths about those of blocks. */
static void projecting_is_the_same_with_every_instruction_set(void **state)
{
    enum { MOST = 200 };
    static const int64_t sizes[] = {1, 7, 63, 64, 65, 127, 199};
    static uint64_t row[MOST], states[2][3][MOST];
    for (size_t b = 0; vvi_project_kernels_nth(b); b++)
        for (size_t i = 0; i < 7 * VV_TYPE_COUNT * 8; i++) {
            const int64_t n = sizes[i % 7];
            const vv_type type = (vv_type)(i / 7 % VV_TYPE_COUNT);
            if (vvi_project_kernels_nth(b)->needs & ~vvi_cpu_detect())
                continue;
            for (size_t k = 0; k < MOST; k++)
                row[k] = test_random(i, k);
            for (int which = 0; which < 2; which++) {
                const vvi_project_loops *l =
                    &(which ? vvi_project_kernels_nth(b) : vvi_project_kernels_for(0))->of[type];
                double(*v)[MOST] = (void *)states[which];
                const vvi_project_sums sums = {v[0], v[1], v[2]};
                memset(states[which], 0, sizeof states[which]);
                switch (i / 7 / VV_TYPE_COUNT) {
                case 0:
                case 1:
                    l->extreme[i % 2](v, (char *)row, n);
                    break;
                case 2:
                case 3:
                    l->extreme_of[i % 2](v, (char *)row, n);
                    break;
                case 4:
                    l->sum(&sums, (char *)row, 1 + n % 3, 8, n - 2 > 0 ? n - 2 : n);
                    break;
                case 5:
                    l->square(&sums, (char *)row, n);
                    break;
                case 6:
                    l->sum_of(&sums, (char *)row, n);
                    break;
                default:
                    l->square_of(&sums, (char *)row, n);
                }
            }
            for (size_t k = 0; k < sizeof states[0] / 8; k++) {
                const double got = ((double *)states[1])[k], want = ((double *)states[0])[k];
                if (((uint64_t *)states[1])[k] != ((uint64_t *)states[0])[k] && !(isnan(got) && isnan(want)))
                    fail_msg("%s, loop %d, %d samples: %.17g, not %.17g", vv_type_name(type),
                             (int)(i / 7 / VV_TYPE_COUNT), (int)n, got, want);
            }
        }
}

static void padding_is_where_it_was(void **state)
{
    vv_field *in = random_field(VV_TYPE_F32, 5, 4, 3, 1), *out;
    assert_int_equal(test_apply(&out, &vvi_operation_pad, in, "x=\"2,5\";y=\"1\";z=\"6mm,0\"", NULL), VV_OK);
    const vv_grid *from = &vv_field_get_info(in)->grid, *to = &vv_field_get_info(out)->grid;
    const vv_vec3 a = vv_affine_point(from->index_to_world, (vv_vec3){3, 2, 1});
    const vv_vec3 b = vv_affine_point(to->index_to_world, (vv_vec3){5, 3, 3});
    assert_true(fabs(a.x - b.x) < 1e-12 && fabs(a.y - b.y) < 1e-12 && fabs(a.z - b.z) < 1e-12);
    assert_true(to->dims[0] == 12 && to->dims[1] == 6 && to->dims[2] == 5);
    assert_true(vv_field_value(out, 5, 3, 3, 0) == vv_field_value(in, 3, 2, 1, 0));
    vv_field_release(out);
    vv_field_release(in);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(padding_is_the_same_in_all_ways),
        cmocka_unit_test(projecting_is_the_same_in_all_ways),
        cmocka_unit_test(projecting_is_the_same_with_every_instruction_set),
        cmocka_unit_test(padding_is_where_it_was),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
