/* Min-max cells against brute force, and the distance to the nearest block of the other sort. */
#include "fields.h"
#include "grid/field.h"
#include "grid/minmax.h"
#include "jobs.h"
#include "render/march/skip.h"
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

/* Stored value of a sample, NaN where it is one. */
static double stored(const vv_brick *b, int component, int64_t i, int64_t j, int64_t k)
{
    const char *at = (const char *)b->data + i * b->stride[0] + j * b->stride[1] + k * b->stride[2];
    double v;
    vvi_samples_to_f64(&v, at + (size_t)component * vv_type_bytes(b->type), b->type, 1);
    return v;
}

static void check_block(const vvi_minmax *m, const vv_brick *b, int component, const int32_t at[3])
{
    double lo = INFINITY, hi = -INFINITY;
    const int64_t side = (int64_t)1 << m->shift;
    for (int64_t k = at[2] * side; k <= (at[2] + 1) * side && k < b->box.n[2]; k++)
        for (int64_t j = at[1] * side; j <= (at[1] + 1) * side && j < b->box.n[1]; j++)
            for (int64_t i = at[0] * side; i <= (at[0] + 1) * side && i < b->box.n[0]; i++) {
                const double v = stored(b, component, i, j, k);
                lo = v < lo ? v : lo;
                hi = v > hi ? v : hi;
            }
    const size_t index = ((size_t)at[2] * (size_t)m->n[1] + (size_t)at[1]) * (size_t)m->n[0] + (size_t)at[0];
    const bool wide = vv_type_bytes(b->type) > 2 && b->type != VV_TYPE_F32; /* floats do not have all of its values */
    const double below = wide ? fabs(lo) * 2e-7 : 0, above = wide ? fabs(hi) * 2e-7 : 0;
    assert_true((double)m->lo[index] <= lo && (double)m->lo[index] >= lo - below);
    assert_true((double)m->hi[index] >= hi && (double)m->hi[index] <= hi + above);
}

static void check_field(vv_type type, const int64_t dims[3], int components, int shift, bool nans)
{
    vv_field_info info = vv_field_info_default();
    info.type = type;
    info.components = components;
    memcpy(info.grid.dims, dims, sizeof info.grid.dims);
    vv_field *field = test_field_random(&info, test_seed() + (uint64_t)shift, NULL);
    const vv_box box = vv_field_box(field);
    vv_brick b;
    assert_int_equal(vv_field_brick(&b, field, &box, NULL), VV_OK);
    if (nans)
        for (int64_t i = 0; i < dims[0] * dims[1] * dims[2]; i += 3)
            ((float *)(uintptr_t)b.data)[i] = NAN;
    for (int threads = 1; threads <= 3; threads++) {
        vv_job *job = test_job(threads, 0);
        for (int c = 0; c < components; c++) {
            vvi_minmax *m;
            assert_int_equal(vvi_minmax_build(&m, &b, c, shift, job), VV_OK);
            for (int32_t z = 0; z < m->n[2]; z++)
                for (int32_t y = 0; y < m->n[1]; y++)
                    for (int32_t x = 0; x < m->n[0]; x++)
                        check_block(m, &b, c, (const int32_t[]){x, y, z});
            vvi_minmax_free(m);
        }
        vv_job_release(job);
    }
    vv_brick_release(&b);
    vv_field_release(field);
}

static void blocks_hold_the_range_of_their_samples_and_of_the_faces_they_share(void **state)
{
    (void)state;
    static const int64_t sizes[][3] = {{17, 9, 5}, {16, 8, 4}, {1, 1, 1}, {2, 13, 1}, {33, 3, 2}};
    for (int type = 0; type < VV_TYPE_COUNT; type++)
        for (size_t s = 0; s < sizeof sizes / sizeof *sizes; s++)
            for (int shift = 1; shift <= 3; shift++) {
                check_field((vv_type)type, sizes[s], 1, shift, false);
                check_field((vv_type)type, sizes[s], 3, shift, false);
            }
}

static void samples_that_are_no_number_are_left_out(void **state)
{
    (void)state;
    check_field(VV_TYPE_F32, (const int64_t[]){11, 7, 6}, 1, 2, true);
    check_field(VV_TYPE_F32, (const int64_t[]){1, 1, 1}, 1, 2, true); /* nothing else there: the empty range */
}

/* Skipping --------------------------------------------------------------------------------------------------------- */

static bool above(const void *user, float lo, float hi)
{
    (void)lo;
    return hi > *(const float *)user;
}

static bool occupied(const vvi_minmax *m, float limit, int32_t i, int32_t j, int32_t k)
{
    return m->hi[((size_t)k * (size_t)m->n[1] + (size_t)j) * (size_t)m->n[0] + (size_t)i] > limit;
}

static int reach_by_all_pairs(const vvi_minmax *m, float limit, int32_t x, int32_t y, int32_t z)
{
    const bool here = occupied(m, limit, x, y, z);
    int best = VVI_SKIP_DISTANCE;
    for (int32_t k = 0; k < m->n[2]; k++)
        for (int32_t j = 0; j < m->n[1]; j++)
            for (int32_t i = 0; i < m->n[0]; i++) {
                if (occupied(m, limit, i, j, k) == here)
                    continue;
                const int d = (int)fmax(fmax(abs(i - x), abs(j - y)), abs(k - z));
                best = d < best ? d : best;
            }
    return best | (here ? VVI_SKIP_OCCUPIED : 0);
}

static void distances_are_those_of_all_pairs(void **state)
{
    (void)state;
    static const int32_t sizes[][3] = {{11, 9, 7}, {1, 1, 1}, {40, 1, 1}, {2, 30, 3}, {300, 1, 2}};
    for (size_t s = 0; s < sizeof sizes / sizeof *sizes; s++)
        for (int round = 0; round < 6; round++) { /* from nothing visible to all */
            float lo[1000] = {0}, hi[1000] = {0};
            vvi_minmax m = {.shift = 2, .lo = lo, .hi = hi};
            memcpy(m.n, sizes[s], sizeof m.n);
            const size_t n = (size_t)m.n[0] * (size_t)m.n[1] * (size_t)m.n[2];
            assert_true(n <= 1000);
            for (size_t i = 0; i < n; i++)
                hi[i] = test_random_unit(test_seed(), i + (uint64_t)round * 5000) <
                        (double[]){0, 0.01, 0.03, 0.5, 0.97, 1}[round];
            const float limit = 0.5f;
            vvi_skip *skip;
            assert_int_equal(vvi_skip_build(&skip, &m, above, &limit, NULL), VV_OK);
            for (int32_t z = 0; z < m.n[2]; z++)
                for (int32_t y = 0; y < m.n[1]; y++)
                    for (int32_t x = 0; x < m.n[0]; x++)
                        assert_int_equal(
                            skip->reach[((size_t)z * (size_t)m.n[1] + (size_t)y) * (size_t)m.n[0] + (size_t)x],
                            reach_by_all_pairs(&m, limit, x, y, z));
            vvi_skip_free(skip);
        }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(blocks_hold_the_range_of_their_samples_and_of_the_faces_they_share),
        cmocka_unit_test(samples_that_are_no_number_are_left_out),
        cmocka_unit_test(distances_are_those_of_all_pairs),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
