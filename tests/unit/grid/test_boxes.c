/* The list of boxes in which something is visible, against brute force. */
#include "fail_alloc.h"
#include "fields.h"
#include "grid/boxes.h"
#include "grid/field.h"
#include "jobs.h"
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

enum { BRIGHT = 200 };

static bool bright(const void *user, float lo, float hi)
{
    (void)user;
    (void)lo;
    return hi >= BRIGHT;
}

/* A dark field with some bright samples, and its min-max blocks. */
typedef struct specks {
    vv_field *field;
    vv_brick brick;
    vvi_minmax *minmax;
} specks;

static void make_specks(specks *s, const int64_t dims[3], int shift, int n, uint64_t seed)
{
    vv_field_info info = vv_field_info_default();
    memcpy(info.grid.dims, dims, sizeof info.grid.dims);
    void *data;
    assert_int_equal(vv_field_new_empty(&s->field, &data, &info, NULL), VV_OK);
    const uint64_t total = (uint64_t)(dims[0] * dims[1] * dims[2]);
    memset(data, 10, total);
    for (int i = 0; i < n; i++)
        ((uint8_t *)data)[test_random(seed, (uint64_t)i) % total] = BRIGHT;
    const vv_box box = vv_field_box(s->field);
    assert_int_equal(vv_field_brick(&s->brick, s->field, &box, NULL), VV_OK);
    assert_int_equal(vvi_minmax_build(&s->minmax, &s->brick, 0, shift, NULL), VV_OK);
}

static void free_specks(specks *s)
{
    vvi_minmax_free(s->minmax);
    vv_brick_release(&s->brick);
    vv_field_release(s->field);
}

/* Whether a sample of box (i, j, k), its far faces included, is bright. */
static bool has_bright(const specks *s, int shift, int64_t i, int64_t j, int64_t k)
{
    const int64_t *n = s->brick.box.n, side = (int64_t)1 << shift, from[3] = {i * side, j * side, k * side};
    for (int64_t z = from[2]; z <= from[2] + side && z < n[2]; z++)
        for (int64_t y = from[1]; y <= from[1] + side && y < n[1]; y++)
            for (int64_t x = from[0]; x <= from[0] + side && x < n[0]; x++)
                if (((const uint8_t *)s->brick.data)[(z * n[1] + y) * n[0] + x] >= BRIGHT)
                    return true;
    return false;
}

static void check_list(const specks *s, const vvi_boxes *b)
{
    static const int step[6][3] = {{-1, 0, 0}, {1, 0, 0}, {0, -1, 0}, {0, 1, 0}, {0, 0, -1}, {0, 0, 1}};
    size_t kept = 0, faces = 0;
    for (int32_t k = 0; k < b->n[2]; k++)
        for (int32_t j = 0; j < b->n[1]; j++)
            for (int32_t i = 0; i < b->n[0]; i++) {
                const bool want = has_bright(s, b->shift, i, j, k);
                assert_int_equal(vvi_boxes_has(b, i, j, k), want);
                if (!want)
                    continue;
                int32_t place[3];
                vvi_box_place(place, b, b->kept[kept]); /* in ascending order: this one is next */
                assert_true(place[0] == i && place[1] == j && place[2] == k);
                unsigned outer = 0;
                for (int f = 0; f < 6; f++)
                    outer |= (unsigned)!vvi_boxes_has(b, i + step[f][0], j + step[f][1], k + step[f][2]) << f;
                assert_int_equal(b->outer[kept++], outer);
                faces += (size_t)__builtin_popcount(outer);
            }
    assert_int_equal(kept, b->n_kept);
    assert_int_equal(faces, b->n_outer);
    assert_false(vvi_boxes_has(b, -1, 0, 0) || vvi_boxes_has(b, 0, b->n[1], 0) || vvi_boxes_has(b, 0, 0, b->n[2]));
}

static void the_list_holds_the_visible_boxes_and_their_outer_faces(void **state)
{
    (void)state;
    static const int64_t dims[][3] = {{33, 33, 33}, {40, 17, 9}, {1, 1, 1}, {1, 50, 2}, {9, 8, 100}};
    for (size_t d = 0; d < sizeof dims / sizeof *dims; d++)
        for (int n = 0; n < 40; n += 13)
            for (int shift = 2; shift <= 5; shift++) {
                specks s;
                make_specks(&s, dims[d], 2, n, test_random(test_seed(), d));
                vvi_boxes *b;
                assert_int_equal(vvi_boxes_build(&b, s.minmax, shift, bright, NULL, NULL), VV_OK);
                assert_int_equal(b->shift, shift);
                check_list(&s, b);
                assert_true(n > 0 || b->n_kept == 0);
                vvi_boxes_free(b);
                free_specks(&s);
            }
}

static void the_list_is_the_same_for_any_number_of_threads(void **state)
{
    (void)state;
    specks s;
    make_specks(&s, (const int64_t[3]){70, 60, 90}, 2, 400, test_seed());
    vvi_boxes *one, *more;
    assert_int_equal(vvi_boxes_build(&one, s.minmax, 3, bright, NULL, NULL), VV_OK);
    for (int threads = 2; threads <= 3; threads++) {
        vv_job *job = test_job(threads, 0);
        assert_int_equal(vvi_boxes_build(&more, s.minmax, 3, bright, NULL, job), VV_OK);
        assert_int_equal(one->n_kept, more->n_kept);
        assert_int_equal(one->n_outer, more->n_outer);
        assert_memory_equal(one->kept, more->kept, one->n_kept * sizeof *one->kept);
        assert_memory_equal(one->outer, more->outer, one->n_kept);
        vvi_boxes_free(more);
        vv_job_release(job);
    }
    vvi_boxes_free(one);
    free_specks(&s);
}

static vv_status build_once(void *user)
{
    const specks *s = user;
    vvi_boxes *b;
    const vv_status st = vvi_boxes_build(&b, s->minmax, 3, bright, NULL, NULL);
    assert_true((st == VV_OK) == (b != NULL));
    vvi_boxes_free(b);
    return st;
}

static void a_list_without_memory_is_an_error_and_leaves_nothing(void **state)
{
    (void)state;
    specks s;
    make_specks(&s, (const int64_t[3]){20, 20, 20}, 2, 5, test_seed());
    assert_true(test_fail_each_alloc(build_once, &s) >= 4);
    free_specks(&s);
}

static void more_boxes_than_32_bits_count_are_refused(void **state)
{
    (void)state;
    const vvi_minmax huge = {.n = {2048, 2048, 2048}, .shift = 2}; /* refused before a block is looked at */
    vvi_boxes *b;
    assert_int_equal(vvi_boxes_build(&b, &huge, 2, bright, NULL, NULL), VV_E_LIMIT);
    assert_null(b);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_list_holds_the_visible_boxes_and_their_outer_faces),
        cmocka_unit_test(the_list_is_the_same_for_any_number_of_threads),
        cmocka_unit_test(a_list_without_memory_is_an_error_and_leaves_nothing),
        cmocka_unit_test(more_boxes_than_32_bits_count_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
