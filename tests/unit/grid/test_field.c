/* Fields: life, bricks, checks. */
#include "core/memory.h"
#include "fields.h"
#include "grid/crc.h"
#include "grid/field.h"
#include "jobs.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static void count_release(void *user)
{
    ++*(int *)user;
}

static void release_is_called_once_when_the_last_reference_goes(void **state)
{
    (void)state;
    static const uint8_t data[1 + 3] = {7};
    const vv_field_info info = vv_field_info_default();
    int released = 0;
    vv_field *field;
    assert_int_equal(vv_field_new(&field, &info, data, 3, count_release, &released, NULL), VV_OK);
    vv_field *again = vv_field_retain(field);
    vv_field_release(field);
    assert_int_equal(released, 0);
    assert_true(vv_field_value(again, 0, 0, 0, 0) == 7);
    vv_field_release(again);
    assert_int_equal(released, 1);
    vv_field_release(NULL);
}

static void release_is_called_also_when_the_info_is_wrong(void **state)
{
    (void)state;
    static const uint8_t data[1] = {7};
    vv_field_info info = vv_field_info_default();
    info.value_scale = 0;
    int released = 0;
    vv_field *field;
    assert_int_equal(vv_field_new(&field, &info, data, 0, count_release, &released, NULL), VV_E_FORMAT);
    assert_null(field);
    assert_int_equal(released, 1);
}

static void every_allocation_may_fail_and_release_is_still_called_once(void **state)
{
    (void)state;
    static const uint8_t data[1] = {7};
    const vv_field_info info = vv_field_info_default();
    for (int n = 1; n < 10; n++) {
        int released = 0;
        vv_field *field;
        vvi_alloc_fail_after(n);
        const vv_status st = vv_field_new(&field, &info, data, 0, count_release, &released, NULL);
        vvi_alloc_fail_after(0);
        vv_field_release(field);
        assert_int_equal(released, 1);
        if (st == VV_OK)
            return;
        assert_int_equal(st, VV_E_MEMORY);
    }
    fail_msg("a field takes more than nine allocations");
}

static void every_field_has_an_identity_of_its_own(void **state)
{
    (void)state;
    vv_field *a = test_field_cube(&test_form_ramp, 2, 0, 1, NULL), *b = test_field_cube(&test_form_ramp, 2, 0, 1, NULL);
    assert_true(vv_field_identity(a) != vv_field_identity(b));
    vv_field_release(a);
    vv_field_release(b);
}

static double brick_value(const vv_brick *b, int64_t i, int64_t j, int64_t k, int c)
{
    double v;
    const char *p = (const char *)b->data + i * b->stride[0] + j * b->stride[1] + k * b->stride[2];
    vvi_samples_to_f64(&v, p + (size_t)c * vv_type_bytes(b->type), b->type, 1);
    return v;
}

static void a_brick_gives_the_samples_of_its_box_for_every_type(void **state)
{
    (void)state;
    const uint64_t seed = test_seed();
    for (int t = 0; t < VV_TYPE_COUNT; t++) {
        vv_field_info info = vv_field_info_default();
        info.type = (vv_type)t;
        info.components = 1 + t % 3;
        info.grid.dims[0] = 7, info.grid.dims[1] = 5, info.grid.dims[2] = 3;
        vv_field *field = test_field_random(&info, seed + (uint64_t)t, NULL);
        const vv_box box = {{2, 1, 1}, {5, 3, 2}};
        vv_brick brick;
        assert_int_equal(vv_field_brick(&brick, field, &box, NULL), VV_OK);
        for (int64_t k = 0; k < 2; k++)
            for (int64_t j = 0; j < 3; j++)
                for (int64_t i = 0; i < 5; i++)
                    for (int c = 0; c < info.components; c++)
                        assert_true(brick_value(&brick, i, j, k, c) == vv_field_value(field, i + 2, j + 1, k + 1, c));
        /* rows j = 4 of slice 2 lies behind the brick, then the guard of the field */
        const size_t row = 7 * vv_type_bytes(info.type) * (size_t)info.components;
        assert_int_equal(brick.guard_bytes, row + VVI_FIELD_GUARD);
        vv_brick_release(&brick);
        vv_field_release(field);
    }
}

static void a_box_outside_the_field_is_refused(void **state)
{
    (void)state;
    vv_field *field = test_field_cube(&test_form_ramp, 4, 0, 3, NULL);
    const vv_box boxes[] = {
        {{0, 0, 0}, {5, 1, 1}},  {{-1, 0, 0}, {1, 1, 1}},        {{0, 4, 0}, {1, 1, 1}},
        {{0, 0, 0}, {1, 1, 0}},  {{3, 3, 3}, {1, 1, INT64_MAX}}, {{INT64_MAX, 0, 0}, {INT64_MAX, 1, 1}},
        {{0, 0, 1}, {1, 1, -1}},
    };
    for (size_t b = 0; b < sizeof boxes / sizeof *boxes; b++) {
        vv_brick brick;
        assert_int_equal(vv_field_brick(&brick, field, &boxes[b], NULL), VV_E_ARGUMENT);
        assert_null(brick.data);
    }
    vv_field_release(field);
}

static void values_are_stored_numbers_scaled_and_indices_are_clamped(void **state)
{
    (void)state;
    static const int16_t data[4] = {-3, 5, 100, 7};
    vv_field_info info = vv_field_info_default();
    info.type = VV_TYPE_I16;
    info.grid.dims[0] = info.grid.dims[1] = 2;
    info.value_scale = 0.5;
    info.value_offset = -1;
    vv_field *field;
    assert_int_equal(vv_field_new(&field, &info, data, 0, NULL, NULL, NULL), VV_OK);
    assert_true(vv_field_value(field, 0, 0, 0, 0) == -2.5);
    assert_true(vv_field_value(field, -9, 5, 2, 3) == 49);
    assert_true(vv_field_value(field, 9, 9, 9, 0) == 2.5);
    vv_field_release(field);
}

static bool damage_flag(const void *user)
{
    return *(const bool *)user;
}

static void a_damaged_file_is_told_by_health_and_bricks(void **state)
{
    (void)state;
    static const uint8_t data[1];
    static bool damaged;
    damaged = false;
    const vv_field_info info = vv_field_info_default();
    vv_field *field;
    assert_int_equal(vvi_field_new_watched(&field, &info, data, 0, NULL, damage_flag, &damaged, NULL), VV_OK);
    assert_int_equal(vv_field_health(field), VV_OK);
    damaged = true;
    const vv_box box = vv_field_box(field);
    vv_brick brick;
    assert_int_equal(vv_field_health(field), VV_E_READ);
    assert_int_equal(vv_field_brick(&brick, field, &box, NULL), VV_E_READ);
    uint32_t crc;
    assert_int_equal(vv_field_checksum(&crc, field, NULL), VV_E_READ);
    vv_field_release(field);
}

static void a_relabelled_field_shares_samples_and_outlives_the_first(void **state)
{
    (void)state;
    vv_job *job = test_job(1, 0);
    vv_field *field = test_field_cube(&test_form_ramp, 3, 0, 2, job);
    vv_field_info info = *vv_field_get_info(field);
    info.value_scale = 10;
    vv_field *other;
    assert_int_equal(vvi_field_relabel(&other, field, &info), VV_OK);
    const double before = vv_field_value(field, 1, 2, 0, 0);
    vv_statistics s;
    assert_int_equal(vv_field_statistics(&s, other, 0, job), VV_OK);
    vv_job_release(job);
    vv_field_release(field);
    assert_true(vv_field_value(other, 1, 2, 0, 0) == 10 * before);
    info.grid.dims[0] = 2;
    vv_field *wrong;
    assert_int_equal(vvi_field_relabel(&wrong, other, &info), VV_E_ARGUMENT);
    assert_null(wrong);
    vv_field_release(other);
}

static void a_volume_beyond_the_memory_limit_is_refused_before_it_is_taken(void **state)
{
    (void)state;
    vv_job *job = test_job(1, 1 << 20);
    vv_field_info info = vv_field_info_default();
    info.grid.dims[0] = info.grid.dims[1] = info.grid.dims[2] = 1 << 9;
    vv_field *field;
    void *data;
    assert_int_equal(vv_field_new_empty(&field, &data, &info, job), VV_E_LIMIT);
    assert_null(field);
    assert_null(data);
    vv_job_release(job);
}

static void crc_of_known_bytes_is_the_published_check_value(void **state)
{
    (void)state;
    static const uint8_t data[9] = "123456789"; /* the check string of every table of CRCs: 0xcbf43926 */
    vv_field_info info = vv_field_info_default();
    info.grid.dims[1] = 9;
    vv_field *field;
    assert_int_equal(vv_field_new(&field, &info, data, 0, NULL, NULL, NULL), VV_OK);
    uint32_t crc;
    assert_int_equal(vv_field_checksum(&crc, field, NULL), VV_OK);
    assert_int_equal(crc, 0xcbf43926u);
    assert_int_equal(vv_field_checksum(&crc, field, NULL), VV_OK);
    assert_int_equal(crc, 0xcbf43926u);
    vv_field_release(field);
}

/* Bit by bit, from the polynomial. */
static uint32_t crc_slowly(const uint8_t *p, size_t n)
{
    uint32_t crc = ~0u;
    for (size_t i = 0; i < n; i++) {
        crc ^= p[i];
        for (int b = 0; b < 8; b++)
            crc = crc >> 1 ^ (crc & 1 ? 0xedb88320u : 0);
    }
    return ~crc;
}

static void folding_gives_the_bitwise_crc_for_every_length_and_alignment(void **state)
{
    (void)state;
    const uint64_t seed = test_seed();
    uint8_t data[400];
    for (size_t i = 0; i < sizeof data; i++)
        data[i] = (uint8_t)test_random(seed, i);
    for (size_t at = 0; at < 17; at++)
        for (size_t n = 0; n < 380; n++) {
            const uint32_t want = crc_slowly(data + at, n);
            assert_int_equal(vvi_crc32(0, data + at, n, false), want);
            if (!vvi_crc_has_fold())
                continue;
            assert_int_equal(vvi_crc32(0, data + at, n, true), want);
            const size_t half = n / 3; /* in two pieces */
            assert_int_equal(vvi_crc32(vvi_crc32(0, data + at, half, true), data + at + half, n - half, true), want);
        }
}

static void crc_of_many_slabs_equals_the_bitwise_one_for_any_thread_count(void **state)
{
    (void)state;
    vv_field_info info = vv_field_info_default();
    info.grid.dims[0] = 257, info.grid.dims[1] = 129, info.grid.dims[2] = 67; /* more than two items */
    for (int threads = 1; threads <= 3; threads++) {
        vv_job *job = test_job(threads, 0);
        vv_field *field = test_field_random(&info, 5, job);
        const vv_box all = vv_field_box(field);
        vv_brick brick;
        assert_int_equal(vv_field_brick(&brick, field, &all, job), VV_OK);
        uint32_t crc;
        assert_int_equal(vv_field_checksum(&crc, field, job), VV_OK);
        assert_int_equal(crc, crc_slowly(brick.data, 257 * 129 * 67));
        vv_brick_release(&brick);
        vv_field_release(field);
        vv_job_release(job);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(release_is_called_once_when_the_last_reference_goes),
        cmocka_unit_test(release_is_called_also_when_the_info_is_wrong),
        cmocka_unit_test(every_allocation_may_fail_and_release_is_still_called_once),
        cmocka_unit_test(every_field_has_an_identity_of_its_own),
        cmocka_unit_test(a_brick_gives_the_samples_of_its_box_for_every_type),
        cmocka_unit_test(a_box_outside_the_field_is_refused),
        cmocka_unit_test(values_are_stored_numbers_scaled_and_indices_are_clamped),
        cmocka_unit_test(a_damaged_file_is_told_by_health_and_bricks),
        cmocka_unit_test(a_relabelled_field_shares_samples_and_outlives_the_first),
        cmocka_unit_test(a_volume_beyond_the_memory_limit_is_refused_before_it_is_taken),
        cmocka_unit_test(crc_of_known_bytes_is_the_published_check_value),
        cmocka_unit_test(folding_gives_the_bitwise_crc_for_every_length_and_alignment),
        cmocka_unit_test(crc_of_many_slabs_equals_the_bitwise_one_for_any_thread_count),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
