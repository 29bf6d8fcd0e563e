/* Ids of any size get numbers, and integers that are labels are told from those that are amounts. */
#include "core/cache.h"
#include "fields.h"
#include "render/common/label_ids.h"
#include "render/common/label_sense.h"
#include "render/common/transfer.h"
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { N = 24, CELLS = 40 };

static vv_field *new_field(void **data, vv_type type)
{
    vv_field_info info = vv_field_info_default();
    vv_field *field = NULL;
    info.type = type;
    for (int a = 0; a < 3; a++)
        info.grid.dims[a] = N;
    assert_int_equal(vv_field_new_empty(&field, data, &info, NULL), VV_OK);
    return field;
}

/* The cell of a sample: that of the nearest of CELLS points. */
static int cell_at(int i, int j, int k)
{
    double least = INFINITY;
    int at = 0;
    for (uint64_t c = 0; c < CELLS; c++) {
        double d = 0;
        const int p[3] = {i, j, k};
        for (uint64_t a = 0; a < 3; a++) {
            const double away = N * test_random_unit(1994, 3 * c + a) - p[a];
            d += away * away;
        }
        if (d < least) {
            least = d;
            at = (int)c;
        }
    }
    return at;
}

typedef uint64_t id_fn(int cell);

static uint64_t beyond_doubles(int cell)
{
    return cell ? (UINT64_C(1) << 60) + 3 * (uint64_t)cell : 0;
}

static uint64_t at_the_top(int cell)
{
    return cell ? UINT64_MAX - (uint64_t)cell : 0;
}

static uint64_t below_zero(int cell)
{
    return cell % 2 ? (uint64_t)(INT64_MIN + cell) : (uint64_t)(cell * INT64_C(100000007));
}

static vv_field *cells_of(vv_type type, id_fn *id)
{
    void *data;
    vv_field *field = new_field(&data, type);
    for (int k = 0; k < N; k++)
        for (int j = 0; j < N; j++)
            for (int i = 0; i < N; i++)
                ((uint64_t *)data)[(k * N + j) * N + i] = id(cell_at(i, j, k));
    return field;
}

static void numbers_stand_for_the_ids_of_the_file(void **state)
{
    static const struct {
        vv_type type;
        id_fn *id;
    } cases[] = {{VV_TYPE_U64, beyond_doubles}, {VV_TYPE_U64, at_the_top}, {VV_TYPE_I64, below_zero}};
    for (size_t c = 0; c < 3; c++) {
        vv_field *field = cells_of(cases[c].type, cases[c].id);
        vvi_cached *cached = NULL;
        assert_int_equal(vvi_label_ids_get(&cached, field, 0, NULL), VV_OK);
        const vvi_label_ids *ids = vvi_cached_value(cached);
        assert_true(ids->n > 30 && ids->n <= CELLS);
        assert_true(ids->statistics.min == 0 && ids->statistics.max == (double)ids->n - 1);
        for (size_t i = 1; i < ids->n; i++)
            assert_true(cases[c].type == VV_TYPE_U64 ? (uint64_t)ids->id[i - 1] < (uint64_t)ids->id[i]
                                                     : ids->id[i - 1] < ids->id[i]);
        const vv_box all = vv_field_box(field);
        vv_brick brick;
        assert_int_equal(vv_field_brick(&brick, ids->numbers, &all, NULL), VV_OK);
        for (int i = 0; i < N * N * N; i++)
            assert_true((uint64_t)ids->id[((const uint16_t *)brick.data)[i]] ==
                        cases[c].id(cell_at(i % N, i / N % N, i / N / N)));
        vv_brick_release(&brick);
        vvi_cache_release(cached);
        vv_field_release(field);
    }
}

static void every_id_has_a_color_of_its_own_and_its_row(void **state)
{
    const int64_t ids[] = {0, 7, INT64_C(1) << 60, (INT64_C(1) << 60) + 1, (INT64_C(1) << 60) + 2};
    const double rows[] = {0x1p60, 0.5, 0.25, 0.125, 1};
    const vv_classification c = {.kind = VV_SEGMENT_LABELS,
                                 .labels = rows,
                                 .n_labels = 1,
                                 .label_opacity = 0.5,
                                 .opacity_length = 1,
                                 .opacity_scale = 1,
                                 .ids = ids,
                                 .n_ids = 5};
    double of[5][4], seven[3];
    for (int i = 0; i < 5; i++)
        vvi_transfer_evaluate(of[i], &c, i);
    vvi_transfer_label_color(seven, 7);
    assert_true(of[0][3] == 0 && memcmp(of[1], seven, sizeof seven) == 0);
    assert_true(of[2][0] == 0.5 && of[2][1] == 0.25 && of[2][2] == 0.125 && of[2][3] > of[3][3]);
    assert_true(fabs(of[3][0] - of[4][0]) + fabs(of[3][1] - of[4][1]) + fabs(of[3][2] - of[4][2]) > 0.1);
    assert_false(vvi_transfer_visible(&c, 0, 0));
    assert_true(vvi_transfer_visible(&c, 0, 1));
    /* colours go on where doubles do: the golden angle in turns, in integers */
    double below[3], above[3];
    vvi_transfer_label_color(below, (INT64_C(1) << 31) - 1);
    vvi_transfer_label_color(above, (INT64_C(1) << 31) - 1 + 6765); /* a Fibonacci number: nearly a whole turn */
    for (int i = 0; i < 3; i++)
        assert_true(fabs(below[i] - above[i]) < 1e-3);
}

static void more_labels_than_there_are_rows_are_refused(void **state)
{
    void *data;
    vv_field_info info = vv_field_info_default();
    vv_field *field = NULL;
    info.type = VV_TYPE_U32;
    info.grid.dims[0] = 1024, info.grid.dims[1] = 1024, info.grid.dims[2] = 2;
    assert_int_equal(vv_field_new_empty(&field, &data, &info, NULL), VV_OK);
    for (uint32_t i = 0; i < 2 << 20; i++)
        ((uint32_t *)data)[i] = i;
    vvi_cached *cached = NULL;
    assert_int_equal(vvi_label_ids_get(&cached, field, 0, NULL), VV_E_LIMIT);
    assert_non_null(strstr(vv_error_last()->message, "1048576"));
    vv_field_release(field);
}

/* Integers of many sorts, in 16 bits. */
typedef double sort_fn(int i, int j, int k);

static double a_ball(int i, int j, int k)
{
    const double x = i - 11.5, y = j - 11.5, z = k - 11.5;
    return sqrt(x * x + y * y + z * z);
}

static double noise(int i, int j, int k)
{
    return test_random_unit(3, (uint64_t)((k * N + j) * N + i));
}

static double segments(int i, int j, int k)
{
    return a_ball(i, j, k) < 11 ? 17 * cell_at(i, j, k) + 3 : 0;
}

static double all_segments(int i, int j, int k)
{
    return cell_at(i, j, k);
}

static double a_smooth_ball(int i, int j, int k)
{
    return fmax(0, round(1000 - 90 * a_ball(i, j, k)));
}

static double steps(int i, int j, int k)
{
    return floor(a_ball(i, j, k) / 2); /* an amount in ten steps */
}

static double a_clipped_scan(int i, int j, int k)
{
    return fmin(fmax(round(500 * (9 - a_ball(i, j, k)) + 20 * noise(i, j, k)), 0), 255);
}

static double a_noisy_scan(int i, int j, int k)
{
    return round(20 * cell_at(i, j, k) + 40 * noise(i, j, k));
}

static double a_mask(int i, int j, int k)
{
    return a_ball(i, j, k) < 8 ? 255 : 0;
}

static double points(int i, int j, int k)
{
    return noise(i, j, k) > 0.97 ? 1 + floor(4000 * noise(i, k, j)) : 0;
}

static size_t labels_in(sort_fn *value, double scale, const char *unit)
{
    void *data;
    vv_field_info info = vv_field_info_default();
    vv_field *field = NULL;
    size_t n = 0;
    info.type = VV_TYPE_I16;
    info.value_scale = scale;
    strcpy(info.value_unit, unit);
    for (int a = 0; a < 3; a++)
        info.grid.dims[a] = N;
    assert_int_equal(vv_field_new_empty(&field, &data, &info, NULL), VV_OK);
    for (int i = 0; i < N * N * N; i++)
        ((int16_t *)data)[i] = (int16_t)value(i % N, i / N % N, i / N / N);
    assert_int_equal(vvi_label_sense(&n, field, 0, NULL), VV_OK);
    vv_field_release(field);
    return n;
}

static void labels_are_told_from_amounts(void **state)
{
    assert_true(labels_in(segments, 1, "") > 20);
    assert_true(labels_in(all_segments, 1, "") > 30);
    assert_true(labels_in(segments, 1697.9, "") > 20);
    assert_int_equal(labels_in(segments, 1, "HU"), 0);
    assert_int_equal(labels_in(segments, 0.001, ""), 0);
    sort_fn *const amounts[] = {a_smooth_ball, steps, a_clipped_scan, a_noisy_scan, a_mask, points, noise};
    for (size_t i = 0; i < sizeof amounts / sizeof *amounts; i++)
        if (labels_in(amounts[i], 1, ""))
            fail_msg("amounts %zu are taken for labels", i);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(numbers_stand_for_the_ids_of_the_file),
        cmocka_unit_test(every_id_has_a_color_of_its_own_and_its_row),
        cmocka_unit_test(more_labels_than_there_are_rows_are_refused),
        cmocka_unit_test(labels_are_told_from_amounts),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
