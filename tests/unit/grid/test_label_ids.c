/* Ids of labels: read, printed, parsed and numbered with all of their 64 bits. */
#include "core/memory.h"
#include "fields.h"
#include "grid/field.h"
#include "grid/label_set.h"

#include <inttypes.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#define FAR INT64_C(864691135000000001) /* FAR and FAR + 1 are one double */

static void ids_are_printed_and_parsed_with_all_digits(void **state)
{
    (void)state;
    static const struct {
        const char *typed, *printed; /* NULL: refused */
        bool is_unsigned;
    } table[] = {
        {"864691135000000001", "864691135000000001", false},
        {"-864691135000000001", "-864691135000000001", false},
        {"9223372036854775807", "9223372036854775807", false},
        {"9223372036854775808", NULL, false},
        {"-9223372036854775808", "-9223372036854775808", false},
        {"-9223372036854775809", NULL, false},
        {"9223372036854775808", "9223372036854775808", true},
        {"18446744073709551615", "18446744073709551615", true},
        {"18446744073709551616", NULL, true},
        {"-1", "18446744073709551615", true}, /* as programs without such integers write it */
        {"+7", "7", false},
        {"7.0", "7", false},
        {"1e3", "1000", true},
        {"1e18", NULL, false},
        {"7.5", NULL, false},
        {"7x", NULL, false},
        {"", NULL, false},
        {"-", NULL, false},
        {"nan", NULL, false},
    };
    for (size_t i = 0; i < sizeof table / sizeof *table; i++) {
        vv_label_id id;
        char digits[VVI_LABEL_DIGITS];
        const bool taken = vvi_label_parse(&id, table[i].typed, table[i].is_unsigned);
        if (taken != (table[i].printed != NULL))
            fail_msg("'%s' is %s", table[i].typed, taken ? "taken" : "refused");
        if (taken)
            assert_string_equal(vvi_label_print(digits, id, table[i].is_unsigned), table[i].printed);
    }
    assert_true(vvi_label_compare(-1, 1, false) < 0 && vvi_label_compare(-1, 1, true) > 0);
    assert_true(vvi_label_compare(FAR, FAR + 1, false) < 0 && vvi_label_compare(FAR, FAR, true) == 0);
    assert_true(vvi_label_value(-1, false) == -1 && vvi_label_value(-1, true) == 0x1p64);
}

static void samples_of_every_type_are_read(void **state)
{
    (void)state;
    for (vv_type type = 0; type < VV_TYPE_COUNT; type++) {
        vv_field_info info = vv_field_info_default();
        vv_field *field;
        void *samples;
        vv_label_id row[6], truth[6] = {0, 1, 100, 5, 6, 7};
        info.type = type;
        info.grid.dims[0] = 6, info.grid.dims[1] = 2, info.grid.dims[2] = 2;
        assert_int_equal(vv_field_new_empty(&field, &samples, &info, NULL), VV_OK);
        char *last = (char *)samples + 18 * vv_type_bytes(type); /* row (1, 1) */
        for (int i = 0; i < 6; i++) {
            const double v = (double)truth[i];
            vvi_samples_from_f64(last + (size_t)i * vv_type_bytes(type), &v, type, 1);
        }
        if (type == VV_TYPE_I64 || type == VV_TYPE_U64) {
            truth[4] = FAR;
            truth[5] = type == VV_TYPE_I64 ? -FAR : -1;
            memcpy(last + 32, &truth[4], 16);
        }
        const vv_box all = vv_field_box(field);
        vv_brick brick;
        assert_int_equal(vv_field_brick(&brick, field, &all, NULL), VV_OK);
        vvi_label_read(row, &brick, 0, NULL, 1, 1);
        assert_memory_equal(row, truth, sizeof row);
        for (int i = 0; i < 6; i++)
            assert_true(vvi_label_of(last + (size_t)i * vv_type_bytes(type), type) == truth[i]);
        info.value_scale = 2;
        vvi_label_read(row, &brick, 0, &info, 1, 1);
        assert_true(row[2] == 200);
        vv_brick_release(&brick);
        vv_field_release(field);
    }
}

static int by_bits(const void *a, const void *b)
{
    const uint64_t x = *(const uint64_t *)a, y = *(const uint64_t *)b;
    return (x > y) - (x < y);
}

/* Against a sorted list. */
static void a_set_numbers_what_a_sorted_list_has(void **state)
{
    (void)state;
    enum { N = 5000 };
    static vv_label_id added[N], sorted[N];
    vvi_label_set set = {0}, all = {0};
    size_t n = 0;
    assert_int_equal(vvi_label_set_find(&set, 0), VVI_NO_LABEL);
    for (size_t i = 0; i < N; i++) {
        const uint64_t step = (uint64_t)(test_random_unit(11, i) * 2000);
        added[i] = (vv_label_id)((i % 3 ? (uint64_t)FAR : UINT64_MAX - 4000) + step);
        uint32_t number = 77;
        const uint32_t before = vvi_label_set_find(&set, added[i]);
        assert_int_equal(vvi_label_set_add(&number, &set, added[i], NULL), VV_OK);
        assert_true(number == (before == VVI_NO_LABEL ? set.n - 1 : before));
    }
    memcpy(sorted, added, sizeof sorted);
    qsort(sorted, N, sizeof *sorted, by_bits);
    for (size_t i = 0; i < N; i++)
        if (i == 0 || sorted[i] != sorted[i - 1])
            sorted[n++] = sorted[i];
    vv_label_id *ids = NULL;
    assert_int_equal(vvi_label_set_add(NULL, &all, FAR, NULL), VV_OK);
    assert_int_equal(vvi_label_set_join(&all, &set, NULL), VV_OK);
    assert_int_equal(vvi_label_set_sort(&ids, &all, true, NULL), VV_OK);
    assert_true(set.n == n && all.n == n + (vvi_label_set_find(&set, FAR) == VVI_NO_LABEL));
    vvi_free(ids);
    assert_int_equal(vvi_label_set_sort(&ids, &set, true, NULL), VV_OK);
    assert_memory_equal(ids, sorted, n * sizeof *ids);
    for (size_t i = 0; i < n; i++)
        assert_int_equal(vvi_label_set_find(&set, sorted[i]), i);
    assert_int_equal(vvi_label_set_find(&set, FAR - 1), VVI_NO_LABEL);
    vvi_free(ids);
    vvi_label_set_finish(&set);
    vvi_label_set_finish(&all);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(ids_are_printed_and_parsed_with_all_digits),
        cmocka_unit_test(samples_of_every_type_are_read),
        cmocka_unit_test(a_set_numbers_what_a_sorted_list_has),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
