/* Integrals of classifications against sums of very many values, and how steep a volume is against its formula. */
#include "core/cache.h"
#include "fields.h"
#include "render/common/minmax_spread.h"
#include "render/common/transfer_integral.h"
#include "scene/gradient_scale.h"
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static const double opacity[] = {0, 0, 0.3, 0, 0.3, 0.9, 0.5, 0.2, 0.7, 0.2, 0.7, 0, 1, 0.95};
static const double color[] = {0.1, 1, 0, 0, 0.6, 0, 1, 0, 0.6, 0, 0, 1, 0.9, 1, 1, 1};
static const vv_classification classes = {.kind = VV_SEGMENT_TRANSFER,
                                          .opacity = opacity,
                                          .n_opacity = 7,
                                          .color = color,
                                          .n_color = 4,
                                          .opacity_length = 2,
                                          .opacity_scale = 1.5};

/* The mean over [a, b] by midpoints. */
static void sum_up(double out[4], double a, double b)
{
    enum { N = 200000 };
    memset(out, 0, 4 * sizeof *out);
    for (int i = 0; i < N; i++) {
        double rgbk[4];
        vvi_transfer_evaluate(rgbk, &classes, a + (b - a) * (i + 0.5) / N);
        for (int c = 0; c < 4; c++)
            out[c] += rgbk[3] * (c < 3 ? rgbk[c] : 1) / N;
    }
}

static void means_equal_sums_of_very_many_values(void **state)
{
    (void)state;
    static const double range[][2] = {{0, 1}, {0.2, 0.31}, {0.3, 0.7}, {0.69, 0.71}, {-1, 2}, {0.45, 0.46}, {1, 0}};
    for (size_t i = 0; i < sizeof range / sizeof *range; i++) {
        double got[4], want[4];
        vvi_transfer_mean(got, &classes, range[i][0], range[i][1]);
        sum_up(want, range[i][0], range[i][1]);
        for (int c = 0; c < 4; c++)
            assert_true(fabs(got[c] - want[c]) < 1e-4 * fmax(1, fabs(want[c])));
    }
}

static void the_mean_over_one_value_is_that_value(void **state)
{
    (void)state;
    double got[4], want[4];
    vvi_transfer_mean(got, &classes, 0.4, 0.4);
    vvi_transfer_evaluate(want, &classes, 0.4);
    assert_true(got[3] == want[3] && got[0] == want[0] * want[3]);
}

static void rows_add_up_to_the_mean_over_them(void **state)
{
    (void)state;
    vvi_transfer_table table;
    vvi_transfer_integral integral;
    assert_int_equal(vvi_transfer_table_init(&table, &classes, 0, 1, 4096, NULL), VV_OK);
    assert_int_equal(vvi_transfer_integral_init(&integral, &table, &classes, NULL), VV_OK);
    assert_int_equal(integral.n, 4095);
    static const size_t rows[][2] = {{0, 4095}, {1000, 3000}, {1200, 1250}, {4000, 4095}, {2867, 4095}};
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        const size_t a = rows[i][0], b = rows[i][1];
        double want[4];
        vvi_transfer_mean(want, &classes, (double)a / 4095, (double)b / 4095);
        for (size_t c = 0; c < 4; c++) {
            const double got = (integral.sum[4 * b + c] - integral.sum[4 * a + c]) * integral.unit[c] / (double)(b - a);
            assert_true(fabs(got - want[c]) < 2e-5 * fmax(1, want[c]));
        }
    }
    /* clear from 0.0 to 0.3: but for the row beside it */
    assert_false(vvi_transfer_occupied(&table, 0, 1225));
    assert_true(vvi_transfer_occupied(&table, 0, 1228));
    vvi_transfer_integral_finish(&integral);
    vvi_transfer_table_finish(&table);
}

static void a_ramp_is_as_steep_as_it_is(void **state)
{
    (void)state;
    vv_field_info info = vv_field_info_default();
    info.type = VV_TYPE_F32;
    info.grid.dims[0] = 90, info.grid.dims[1] = 8, info.grid.dims[2] = 7;
    vv_field *field = test_field(&test_form_ramp, &info, NULL); /* 3 + 2 x - y + 0.5 z */
    vv_actor actor = {.field = field, .index_to_world = info.grid.index_to_world};
    double got = 0;
    assert_int_equal(vvi_gradient_scale(&got, &actor, NULL), VV_OK);
    assert_true(fabs(got - sqrt(4 + 1 + 0.25)) < 1e-4);
    actor.index_to_world.axis[0].x = 2; /* x twice as long: half as steep */
    assert_int_equal(vvi_gradient_scale(&got, &actor, NULL), VV_OK);
    assert_true(fabs(got - sqrt(1 + 1 + 0.25)) < 1e-4);
    vv_field_release(field);
}

static void how_steep_a_volume_is_gets_measured_once_for_a_place(void **state)
{
    (void)state;
    vv_runtime *runtime = NULL;
    vv_job *job = NULL;
    vvi_cache_counts counts;
    vv_field_info info = vv_field_info_default();
    info.type = VV_TYPE_F32;
    info.grid.dims[0] = info.grid.dims[1] = info.grid.dims[2] = 8;
    vv_field *field = test_field(&test_form_ramp, &info, NULL);
    vv_actor actor = {.field = field, .index_to_world = info.grid.index_to_world};
    double scale[4];
    assert_int_equal(vv_runtime_new(&runtime, NULL), VV_OK);
    assert_int_equal(vv_job_new(&job, runtime, NULL, NULL), VV_OK);
    for (int i = 0; i < 4; i++) {
        if (i == 2)
            actor.index_to_world.axis[0].x = 2;
        assert_int_equal(vvi_gradient_scale(&scale[i], &actor, job), VV_OK);
        vvi_cache_get_counts(&counts, runtime);
        assert_int_equal(counts.misses, i < 2 ? 1 : 2);
    }
    assert_true(scale[0] == scale[1] && scale[2] == scale[3] && scale[2] < scale[0]);
    vv_field_release(field);
    vv_job_release(job);
    vv_runtime_release(runtime);
}

static void spread_blocks_hold_the_ranges_of_their_neighbours(void **state)
{
    (void)state;
    enum { NX = 7, NY = 5, NZ = 4, N = NX * NY * NZ };
    float lo[N], hi[N];
    const vvi_minmax from = {.n = {NX, NY, NZ}, .shift = 2, .lo = lo, .hi = hi};
    for (uint64_t i = 0; i < N; i++) {
        lo[i] = (float)test_random_unit(test_seed(), i);
        hi[i] = lo[i] + (float)test_random_unit(test_seed(), i + N);
    }
    for (int reach = 0; reach < 9; reach += 2) {
        vvi_minmax *m = NULL;
        assert_int_equal(vvi_minmax_spread(&m, &from, reach, NULL), VV_OK);
        for (int at = 0; at < N; at++) {
            float least = INFINITY, most = -INFINITY;
            for (int other = 0; other < N; other++) {
                if (abs(at % NX - other % NX) > reach || abs(at / NX % NY - other / NX % NY) > reach ||
                    abs(at / (NX * NY) - other / (NX * NY)) > reach)
                    continue;
                least = fminf(least, lo[other]);
                most = fmaxf(most, hi[other]);
            }
            assert_true(m->lo[at] == least && m->hi[at] == most);
        }
        vvi_minmax_free(m);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(means_equal_sums_of_very_many_values),
        cmocka_unit_test(the_mean_over_one_value_is_that_value),
        cmocka_unit_test(rows_add_up_to_the_mean_over_them),
        cmocka_unit_test(a_ramp_is_as_steep_as_it_is),
        cmocka_unit_test(how_steep_a_volume_is_gets_measured_once_for_a_place),
        cmocka_unit_test(spread_blocks_hold_the_ranges_of_their_neighbours),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
