/* Ids of any size get numbers, and integers that are labels are told from those that are amounts. */
#include "core/cache.h"
#include "fields.h"
#include "grid/label_color.h"
#include "grid/label_sense.h"
#include "scene/label_ids.h"
#include "scene/transfer.h"
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
    vvi_label_color(seven, 7);
    assert_true(of[0][3] == 0 && memcmp(of[1], seven, sizeof seven) == 0);
    assert_true(of[2][0] == 0.5 && of[2][1] == 0.25 && of[2][2] == 0.125 && of[2][3] > of[3][3]);
    assert_true(fabs(of[3][0] - of[4][0]) + fabs(of[3][1] - of[4][1]) + fabs(of[3][2] - of[4][2]) > 0.1);
    assert_false(vvi_transfer_visible(&c, 0, 0));
    assert_true(vvi_transfer_visible(&c, 0, 1));
}

/* Linear sRGB to Oklab, after Ottosson's matrices of that direction. */
static void to_oklab(double lab[3], const double rgb[3])
{
    const double l = cbrt(0.4122214708 * rgb[0] + 0.5363325363 * rgb[1] + 0.0514459929 * rgb[2]);
    const double m = cbrt(0.2119034982 * rgb[0] + 0.6806995451 * rgb[1] + 0.1073969566 * rgb[2]);
    const double s = cbrt(0.0883024619 * rgb[0] + 0.2817188376 * rgb[1] + 0.6299787005 * rgb[2]);
    lab[0] = 0.2104542553 * l + 0.7936177850 * m - 0.0040720468 * s;
    lab[1] = 1.9779984951 * l - 2.4285922050 * m + 0.4505937099 * s;
    lab[2] = 0.0259040371 * l + 0.7827717662 * m - 0.8086757660 * s;
}

static double color_distance(int64_t a, int64_t b)
{
    double rgb[2][3], lab[2][3];
    vvi_label_color(rgb[0], a);
    vvi_label_color(rgb[1], b);
    for (int i = 0; i < 2; i++) {
        to_oklab(lab[i], rgb[i]);
        for (int c = 0; c < 3; c++)
            assert_true(rgb[i][c] > 0 && rgb[i][c] < 1); /* not clipped, which would bring others near */
    }
    return sqrt(pow(lab[0][0] - lab[1][0], 2) + pow(lab[0][1] - lab[1][1], 2) + pow(lab[0][2] - lab[1][2], 2));
}

static void colors_of_ids_near_each_other_are_far_apart(void **state)
{
    static const int64_t starts[] = {1, -500, INT32_MAX - 100, INT64_C(1) << 52, INT64_C(1) << 60, INT64_MAX - 1000};
    for (int64_t a = 1; a <= 40; a++)
        for (int64_t b = a + 1; b <= 40; b++)
            if (color_distance(a, b) < (b <= 20 ? 0.075 : 0.04))
                fail_msg("%d and %d are %g apart", (int)a, (int)b, color_distance(a, b));
    for (size_t s = 0; s < sizeof starts / sizeof *starts; s++)
        for (int64_t id = starts[s]; id < starts[s] + 500; id++) {
            assert_true(color_distance(id, id + 1) > 0.15);
            for (int64_t next = 2; next < 12; next++)
                assert_true(color_distance(id, id + next) > 0.07);
        }
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

/* Slabs of a box, the rest 0: a few values that are alike as regions. */
static size_t labels_in_slabs(vv_type type, const int64_t *values, int n_values)
{
    void *data;
    vv_field *field = new_field(&data, type);
    size_t n = 0;
    for (int i = 0; i < N * N * N; i++) {
        const int x = i % N, z = i / N / N;
        const bool inside = x >= 2 && x < N - 2 && z >= 2 && z < N - 2;
        const int64_t value = inside ? values[(z - 2) * n_values / (N - 4)] : 0;
        memcpy((char *)data + (size_t)i * vv_type_bytes(type), &value, vv_type_bytes(type));
    }
    assert_int_equal(vvi_label_sense(&n, field, 0, NULL), VV_OK);
    vv_field_release(field);
    return n;
}

static void a_few_large_ids_are_labels(void **state)
{
    static const int64_t atlas[] = {997, 127201621, INT64_C(4000000000), 312782546, 589508447};
    static const int64_t small[] = {997, 127201621, 2000000000, 312782546, 589508447};
    static const int64_t levels[] = {100000000, 200000000, 300000000, 400000000, 500000000};
    static const int64_t widened[] = {16843009, 33686018, INT64_C(4278124286), 168430090, 1684300900};
    static const int64_t marked[] = {1, 2, INT32_MIN, INT32_MAX, 3};
    static const int64_t masked[] = {1, 2, UINT32_MAX, 20000001, 3};
    static const int64_t mask[] = {1, 2, 3, 4, 5};
    assert_int_equal(labels_in_slabs(VV_TYPE_U32, atlas, 5), 6);
    assert_int_equal(labels_in_slabs(VV_TYPE_I64, atlas, 5), 6);
    assert_int_equal(labels_in_slabs(VV_TYPE_U64, atlas, 5), 6);
    assert_int_equal(labels_in_slabs(VV_TYPE_I32, small, 5), 6);
    assert_int_equal(labels_in_slabs(VV_TYPE_I32, small, 2), 0); /* one of them large: a mask, and a mark */
    assert_int_equal(labels_in_slabs(VV_TYPE_I32, levels, 5), 0);
    assert_int_equal(labels_in_slabs(VV_TYPE_U32, widened, 5), 0);
    assert_int_equal(labels_in_slabs(VV_TYPE_I32, marked, 5), 0);
    assert_int_equal(labels_in_slabs(VV_TYPE_U32, masked, 5), 0);
    assert_int_equal(labels_in_slabs(VV_TYPE_I32, mask, 5), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(numbers_stand_for_the_ids_of_the_file),
        cmocka_unit_test(every_id_has_a_color_of_its_own_and_its_row),
        cmocka_unit_test(more_labels_than_there_are_rows_are_refused),
        cmocka_unit_test(labels_are_told_from_amounts),
        cmocka_unit_test(colors_of_ids_near_each_other_are_far_apart),
        cmocka_unit_test(a_few_large_ids_are_labels),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
