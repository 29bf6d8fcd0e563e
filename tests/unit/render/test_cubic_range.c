/* Ranges of cubic splines in blocks: all values are in them, and they are hardly wider than these. */
#include "core/cache.h"
#include "fields.h"
#include "ray_scene.h"
#include "render/common/cubic_range.h"
#include "render/common/cubic_spline.h"
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

typedef struct situation {
    vv_job *job;
    vvi_lattice_hold spline;
    vvi_cached *cached;
    const vvi_minmax *range;
} situation;

static void open_situation(situation *s, const vv_field *field, int shift, const char *cpu)
{
    vv_runtime_options options;
    vv_runtime *runtime = NULL;
    vv_runtime_options_init(&options, sizeof options);
    options.threads = 2;
    options.cpu = cpu;
    assert_int_equal(vv_runtime_new(&runtime, &options), VV_OK);
    assert_int_equal(vv_job_new(&s->job, runtime, NULL, NULL), VV_OK);
    vv_runtime_release(runtime);
    assert_int_equal(vvi_lattice_open_cubic(&s->spline, field, 0, s->job), VV_OK);
    const vvi_cache_key key = vvi_minmax_key("range cubic", field, 0, shift);
    assert_int_equal(vvi_cubic_range_get(&s->cached, &key, &s->spline.lattice, shift, s->job), VV_OK);
    s->range = vvi_cached_value(s->cached);
}

static void close_situation(situation *s)
{
    vvi_cache_release(s->cached);
    vvi_lattice_close(&s->spline);
    vv_job_release(s->job);
}

static vv_field *random_field(const int64_t dims[3], uint64_t seed)
{
    vv_field_info info = vv_field_info_default();
    memcpy(info.grid.dims, dims, sizeof info.grid.dims);
    info.type = VV_TYPE_U8;
    return test_field_random(&info, seed, NULL);
}

/* The least and the largest value in block b, at quarters of a voxel. */
static void find_values(double range[2], const situation *s, const int32_t b[3])
{
    const vvi_lattice *g = &s->spline.lattice;
    double p[3];
    int steps[3];
    for (int a = 0; a < 3; a++) {
        const int32_t first = b[a] << s->range->shift, cells = g->n[a] > 1 ? g->n[a] - 1 : 0;
        const int32_t side = 1 << s->range->shift, left = cells - first;
        steps[a] = 4 * (left < side ? left : side);
    }
    range[0] = INFINITY;
    range[1] = -INFINITY;
    for (int k = 0; k <= steps[2]; k++)
        for (int j = 0; j <= steps[1]; j++)
            for (int i = 0; i <= steps[0]; i++) {
                const int at[3] = {i, j, k};
                for (int a = 0; a < 3; a++)
                    p[a] = (b[a] << s->range->shift) + at[a] / 4.0;
                const double v = vvi_cubic_at(g, p, -1);
                range[0] = fmin(range[0], v);
                range[1] = fmax(range[1], v);
            }
}

static void check_blocks(const situation *s, double most_beyond)
{
    const vvi_minmax *m = s->range;
    for (int32_t at = 0; at < m->n[0] * m->n[1] * m->n[2]; at++) {
        const int32_t b[3] = {at % m->n[0], at / m->n[0] % m->n[1], at / (m->n[0] * m->n[1])};
        double want[2];
        find_values(want, s, b);
        assert_true((double)m->lo[at] <= want[0] && (double)m->hi[at] >= want[1]);
        assert_true(want[0] - (double)m->lo[at] < most_beyond && (double)m->hi[at] - want[1] < most_beyond);
    }
}

static void every_value_of_noise_is_in_the_range_of_its_block_and_little_more(void **state)
{
    (void)state;
    static const int64_t sizes[][3] = {{23, 11, 9}, {5, 9, 6}, {2, 2, 2}, {1, 1, 1}, {3, 1, 14}, {1, 18, 2}, {4, 3, 1}};
    for (const char *const *cpu = test_ray_cpus(); *cpu; cpu++)
        for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
            vv_field *field = random_field(sizes[i], test_seed() + i);
            situation s = {0};
            open_situation(&s, field, 2 + (int)(i % 2), *cpu);
            for (int a = 0; a < 3; a++)
                assert_int_equal(s.range->n[a], ((sizes[i][a] > 1 ? sizes[i][a] - 1 : 1) + (1 << s.range->shift) - 1) >>
                                                    s.range->shift);
            check_blocks(&s, 0.2 * 255); /* of white noise, whose values overshoot the samples by as much */
            close_situation(&s);
            vv_field_release(field);
        }
}

/* Beside an edge coefficients swing from -200 to 450, by a quarter less from voxel to voxel. */
static void blocks_beside_a_hard_edge_have_its_overshoot_and_no_more(void **state)
{
    (void)state;
    enum { N = 33, EDGE = 16 };
    vv_field_info info = vv_field_info_default();
    vv_field *field;
    void *data;
    info.type = VV_TYPE_U8;
    info.grid.dims[0] = info.grid.dims[1] = info.grid.dims[2] = N;
    assert_int_equal(vv_field_new_empty(&field, &data, &info, NULL), VV_OK);
    for (int i = 0; i < N * N * N; i++)
        ((uint8_t *)data)[i] = i % N < EDGE ? 0 : 255;
    situation s = {0};
    open_situation(&s, field, 2, NULL);
    for (int32_t at = 0; at < 8 * 8 * 8; at++) {
        const double away = fabs(at % 8 - 3.4); /* the edge is at the end of block 3 */
        const double swing = at % 8 == 3 || at % 8 == 4 ? 255 * 0.12 : 255 * 0.12 * pow(0.268, 4 * (away - 1.5));
        assert_true(s.range->lo[at] > (at % 8 > 3 ? 255 : 0) - (float)swing - 0.02f || at % 8 == 3);
        assert_true(s.range->hi[at] < (at % 8 > 3 ? 255 : 0) + (float)swing + 0.02f || at % 8 == 3);
    }
    check_blocks(&s, 0.02 * 255);
    close_situation(&s);
    vv_field_release(field);
}

static void a_constant_has_the_range_of_its_value(void **state)
{
    (void)state;
    vv_field_info info = vv_field_info_default();
    info.type = VV_TYPE_F32;
    info.grid.dims[0] = info.grid.dims[1] = info.grid.dims[2] = 10;
    vv_field *field = test_field(&test_form_constant, &info, NULL);
    situation s = {0};
    open_situation(&s, field, 2, NULL);
    check_blocks(&s, 0.01);
    close_situation(&s);
    vv_field_release(field);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_value_of_noise_is_in_the_range_of_its_block_and_little_more),
        cmocka_unit_test(blocks_beside_a_hard_edge_have_its_overshoot_and_no_more),
        cmocka_unit_test(a_constant_has_the_range_of_its_value),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
