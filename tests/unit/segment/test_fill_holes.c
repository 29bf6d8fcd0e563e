/* Holes whose shape is a formula. */
#include "fields.h"
#include "jobs.h"
#include "operations.h"
#include "registry.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { N = 21 };

static int distance(int64_t i, int64_t j, int64_t k)
{
    const int64_t a = llabs(i - N / 2), b = llabs(j - N / 2), c = llabs(k - N / 2);
    return (int)(a > b ? (a > c ? a : c) : (b > c ? b : c));
}

/* Nested boxes: a wall of 5 at distance 8, nothing, a wall of -7 at distance 4, nothing; and with `pipe` a way in along
 * x through all walls. */
static int wall(int64_t i, int64_t j, int64_t k, bool pipe)
{
    const int d = distance(i, j, k);
    if (pipe && j == N / 2 && k == N / 2 && i < N / 2)
        return 0;
    return d == 8 ? 5 : d == 4 ? -7 : 0;
}

static vv_field *boxes(vv_meaning meaning, bool pipe)
{
    static int16_t samples[N * N * N];
    vv_field_info info = vv_field_info_default();
    vv_field *field;
    for (int64_t at = 0; at < (int64_t)N * N * N; at++)
        samples[at] = (int16_t)wall(at % N, at / N % N, at / N / N, pipe);
    info.type = VV_TYPE_I16;
    info.meaning = meaning;
    for (int a = 0; a < 3; a++)
        info.grid.dims[a] = N;
    assert_int_equal(vv_field_new(&field, &info, samples, 0, NULL, NULL, NULL), VV_OK);
    return field;
}

static vv_field *filled(const vv_field *in, const char *settings, vv_job *job)
{
    vv_field *out;
    if (test_apply(&out, &vvi_operation_fill_holes, in, settings, job) != VV_OK)
        fail_msg("%s: %s", settings ? settings : "", vv_error_last()->message);
    return out;
}

/* The room between the walls touches the outer one at more faces. */
static void nested_boxes_become_solid(void **state)
{
    (void)state;
    vv_job *job = test_job(2, 0);
    vv_field *in = boxes(VV_MEANING_LABEL, false), *out = filled(in, NULL, job);
    for (int64_t at = 0; at < (int64_t)N * N * N; at++) {
        const int64_t i = at % N, j = at / N % N, k = at / N / N;
        const int d = distance(i, j, k);
        assert_true(vv_field_value(out, i, j, k, 0) == (d > 8 ? 0 : d > 4 ? 5 : -7));
    }
    vv_field_release(in);
    vv_field_release(out);
    vv_job_release(job);
}

/* A pipe along x opens the boxes, but not in slices across x, in which it is a hole. */
static void what_a_pipe_opens_is_closed_in_slices_across_it(void **state)
{
    (void)state;
    static const char *const settings[] = {"", "slices=axial", "slices=coronal", "slices=sagittal"};
    vv_field *in = boxes(VV_MEANING_SCALAR, true);
    for (int s = 0; s < 4; s++) {
        vv_field *out = filled(in, settings[s], NULL);
        const bool middle_slice_is_open = s < 3;
        assert_true(vv_field_value(out, 5, N / 2, N / 2, 0) == (middle_slice_is_open ? 0 : 5));
        assert_true(vv_field_value(out, 5, N / 2 + 1, N / 2 + 1, 0) == (s == 0 ? 0 : 5));
        assert_true(vv_field_value(out, 0, 0, 0, 0) == 0);
        vv_field_release(out);
    }
    vv_field_release(in);
}

static void what_makes_no_sense_is_refused(void **state)
{
    (void)state;
    vv_field_info info = vv_field_info_default();
    info.type = VV_TYPE_F32;
    vv_field *in = test_field_random(&info, 1, NULL), *out;
    assert_int_equal(test_apply(&out, &vvi_operation_fill_holes, in, NULL, NULL), VV_E_UNSUPPORTED);
    vv_field_release(in);
    info.type = VV_TYPE_U8;
    info.components = 2;
    in = test_field_random(&info, 1, NULL);
    assert_int_equal(test_apply(&out, &vvi_operation_fill_holes, in, NULL, NULL), VV_E_UNSUPPORTED);
    vv_field_release(in);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(nested_boxes_become_solid),
        cmocka_unit_test(what_a_pipe_opens_is_closed_in_slices_across_it),
        cmocka_unit_test(what_makes_no_sense_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
