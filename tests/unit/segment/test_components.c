/* Connected parts against a flood fill, for every type, connectivity, size of rows and instruction set. */
#include "core/cpu.h"
#include "fields.h"
#include "grid/field.h"
#include "jobs.h"
#include "operations.h"
#include "registry.h"
#include "segment/runs_kernel.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { MOST = 20000 };

typedef struct volume {
    int64_t n[3];
    double v[MOST];
    uint32_t want[MOST];
    uint32_t n_parts;
} volume;

static bool touches(int64_t dx, int64_t dy, int64_t dz, int connectivity)
{
    const int64_t axes = llabs(dx) + llabs(dy) + llabs(dz);
    return axes > 0 && axes <= (connectivity == 6 ? 1 : connectivity == 18 ? 2 : 3);
}

static void flood(volume *v, int64_t from, uint32_t label, int connectivity, bool merge)
{
    static int64_t stack[MOST];
    size_t n = 0;
    stack[n++] = from;
    v->want[from] = label;
    while (n > 0) {
        const int64_t at = stack[--n], i = at % v->n[0], j = at / v->n[0] % v->n[1], k = at / v->n[0] / v->n[1];
        for (int64_t dz = -1; dz <= 1; dz++)
            for (int64_t dy = -1; dy <= 1; dy++)
                for (int64_t dx = -1; dx <= 1; dx++) {
                    const int64_t x = i + dx, y = j + dy, z = k + dz;
                    if (!touches(dx, dy, dz, connectivity) || x < 0 || y < 0 || z < 0 || x >= v->n[0] || y >= v->n[1] ||
                        z >= v->n[2])
                        continue;
                    const int64_t to = (z * v->n[1] + y) * v->n[0] + x;
                    if (v->want[to] || v->v[to] == 0 || isnan(v->v[to]) || (!merge && v->v[to] != v->v[at]))
                        continue;
                    v->want[to] = label;
                    stack[n++] = to;
                }
    }
}

/* Numbered by their first voxel, then by size. */
static void label_slowly(volume *v, int connectivity, bool merge)
{
    static uint32_t size[MOST + 1], rank[MOST + 1];
    const int64_t all = v->n[0] * v->n[1] * v->n[2];
    memset(v->want, 0, sizeof v->want);
    memset(size, 0, sizeof size);
    v->n_parts = 0;
    for (int64_t at = 0; at < all; at++)
        if (!v->want[at] && v->v[at] != 0 && !isnan(v->v[at]))
            flood(v, at, ++v->n_parts, connectivity, merge);
    for (int64_t at = 0; at < all; at++)
        size[v->want[at]]++;
    for (uint32_t a = 1; a <= v->n_parts; a++) {
        rank[a] = 1;
        for (uint32_t b = 1; b <= v->n_parts; b++)
            rank[a] += size[b] > size[a] || (size[b] == size[a] && b < a);
    }
    rank[0] = 0;
    for (int64_t at = 0; at < all; at++)
        v->want[at] = rank[v->want[at]];
}

static vv_field *field_of(const volume *v, vv_type type)
{
    vv_field_info info = vv_field_info_default();
    vv_field *field;
    void *data;
    memcpy(info.grid.dims, v->n, sizeof v->n);
    info.type = type;
    strcpy(info.grid.unit, "mm");
    assert_int_equal(vv_field_new_empty(&field, &data, &info, NULL), VV_OK);
    vvi_samples_from_f64(data, v->v, type, (size_t)(v->n[0] * v->n[1] * v->n[2]));
    return field;
}

static const uint32_t *labels_of(vv_brick *brick, const vv_field *field)
{
    const vv_box all = vv_field_box(field);
    assert_int_equal(vv_field_brick(brick, field, &all, NULL), VV_OK);
    return brick->data;
}

static void expect(const volume *v, const vv_field *got, const char *what)
{
    vv_brick brick;
    const uint32_t *label = labels_of(&brick, got);
    for (int64_t at = 0; at < v->n[0] * v->n[1] * v->n[2]; at++)
        if (label[at] != v->want[at])
            fail_msg("%s: voxel %d of %dx%dx%d is %u, not %u", what, (int)at, (int)v->n[0], (int)v->n[1], (int)v->n[2],
                     label[at], v->want[at]);
    vv_brick_release(&brick);
}

static void try(volume *v, vv_type type, int connectivity, bool merge, vv_job *job)
{
    char settings[96];
    vv_field *in = field_of(v, type), *out;
    snprintf(settings, sizeof settings, "connectivity=%d;merge=%s", connectivity, merge ? "true" : "false");
    label_slowly(v, connectivity, merge);
    if (test_apply(&out, &vvi_operation_components, in, settings, job) != VV_OK)
        fail_msg("%s", vv_error_last()->message);
    assert_int_equal(vv_field_get_info(out)->meaning, VV_MEANING_LABEL);
    expect(v, out, settings);
    vv_field_release(in);
    vv_field_release(out);
}

static void fill(volume *v, const int64_t n[3], int values, double share, uint64_t seed)
{
    memcpy(v->n, n, sizeof v->n);
    for (int64_t at = 0; at < n[0] * n[1] * n[2]; at++) {
        const double u = test_random_unit(seed, (uint64_t)at);
        v->v[at] = u < share ? 1 + (double)(test_random(seed + 1, (uint64_t)at) % (uint64_t)values) : 0;
    }
}

static void parts_are_those_of_a_flood_fill(void **state)
{
    (void)state;
    static const int64_t sizes[][3] = {{1, 1, 1},  {7, 1, 1},   {1, 9, 1},   {1, 1, 9},   {64, 5, 4},  {63, 4, 5},
                                       {65, 3, 7}, {130, 9, 1}, {17, 1, 23}, {1, 19, 21}, {9, 40, 17}, {5, 3, 101}};
    static const int connectivity[] = {6, 18, 26};
    static volume v;
    vv_job *job = test_job(3, 0);
    const uint64_t seed = test_seed();
    for (size_t s = 0; s < sizeof sizes / sizeof *sizes; s++)
        for (int c = 0; c < 3; c++)
            for (int t = 0; t < 24; t++) {
                const vv_type type = (vv_type)(t % VV_TYPE_COUNT);
                fill(&v, sizes[s], t % 3 + 1, 0.15 + 0.1 * (t % 8), seed + (uint64_t)t);
                try(&v, type, connectivity[c], vv_type_is_float(type) || t % 2, job);
            }
    vv_job_release(job);
}

static void every_instruction_set_finds_the_same_runs(void **state)
{
    (void)state;
    enum { N = 200, WORDS = 4 };
    static int16_t keys[N + VVI_RUNS_GUARD];
    uint64_t inside[2][WORDS], differs[WORDS], starts[2][WORDS];
    uint32_t a[2][2 * N + 64], b[2][2 * N + 64];
    int32_t ends[2][2][N + 1];
    for (uint64_t seed = 0; seed < 50; seed++) {
        const int64_t n = 1 + (int64_t)(test_random(seed, 9999) % N);
        const size_t words = (size_t)(n + 63) / 64;
        for (int64_t i = 0; i < n; i++)
            keys[i] = (int16_t)(test_random(seed, (uint64_t)i) % 5);
        for (size_t k = 0; vvi_runs_kernels_nth(k); k++) {
            const vvi_runs_kernels *own = vvi_runs_kernels_nth(k), *base = vvi_runs_kernels_for(0);
            if (own->needs & ~vvi_cpu_detect())
                continue;
            const vvi_runs_kernels *both[2] = {base, own};
            size_t pairs[2];
            for (int w = 0; w < 2; w++) {
                both[w]->inside[1](inside[w], keys, n, 1, 3);
                both[w]->differ[1](differs, keys, n);
                const uint32_t runs = both[w]->starts(starts[w], inside[w], differs, words);
                both[w]->ends(ends[w][0], ends[w][1], inside[w], starts[w], n);
                const vvi_run_bits row = {inside[w], starts[w], 7};
                pairs[w] = both[w]->touch[1](&(vvi_run_pairs){a[w], b[w]}, &row, &row, words);
                for (uint32_t r = 0; r < runs; r++)
                    assert_true(ends[w][0][r] < ends[w][1][r] && ends[w][1][r] <= n);
                assert_memory_equal(ends[w][0], ends[0][0], runs * sizeof(int32_t));
                assert_memory_equal(ends[w][1], ends[0][1], runs * sizeof(int32_t));
            }
            assert_int_equal(pairs[0], pairs[1]);
            assert_memory_equal(inside[0], inside[1], words * sizeof(uint64_t));
            assert_memory_equal(a[0], a[1], pairs[0] * sizeof **a);
            assert_memory_equal(b[0], b[1], pairs[0] * sizeof **b);
        }
    }
}

/* Three bars of 5, 3 and 1 voxels of 8 mm3 each. */
static vv_field *bars(void)
{
    static volume v = {.n = {5, 5, 1}, .v = {1, 1, 1, 0, 1, 0, 0, 0, 0, 0, 2, 2, 2, 2, 2}};
    vv_field *field = field_of(&v, VV_TYPE_U8), *out;
    vv_field_info info = *vv_field_get_info(field);
    for (int c = 0; c < 3; c++)
        *(&info.grid.index_to_world.axis[c].x + c) = 2;
    assert_int_equal(vvi_field_relabel(&out, field, &info), VV_OK);
    vv_field_release(field);
    return out;
}

static double sum_of(const vv_field *field, const char *settings)
{
    double sum = 0;
    vv_field *out;
    vv_brick brick;
    if (test_apply(&out, &vvi_operation_components, field, settings, NULL) != VV_OK)
        fail_msg("%s: %s", settings, vv_error_last()->message);
    const uint32_t *label = labels_of(&brick, out);
    for (int i = 0; i < 25; i++)
        sum += label[i];
    vv_brick_release(&brick);
    vv_field_release(out);
    return sum;
}

static void small_parts_are_left_out(void **state)
{
    (void)state;
    vv_field *field = bars();
    assert_true(sum_of(field, "") == 5 * 1 + 3 * 2 + 1 * 3);
    assert_true(sum_of(field, "min_size=3") == 5 * 1 + 3 * 2);
    assert_true(sum_of(field, "min_size=4vox") == 5);
    assert_true(sum_of(field, "min_size=24mm3") == 5 * 1 + 3 * 2);
    assert_true(sum_of(field, "min_size=0.0241cm^3") == 5);
    assert_true(sum_of(field, "keep=1") == 5);
    assert_true(sum_of(field, "range=2..") == 5);
    vv_field_release(field);
}

/* Ids that doubles take for one another are two labels. */
static void neighbours_beyond_2_to_53_are_two_parts(void **state)
{
    (void)state;
    static const uint64_t ids[4] = {9007199254740993, 9007199254740992, 9007199254740992, 9007199254740993};
    vv_field_info info = vv_field_info_default();
    vv_field *field, *out;
    info.type = VV_TYPE_U64;
    info.grid.dims[0] = 4;
    assert_int_equal(vv_field_new(&field, &info, ids, 0, NULL, NULL, NULL), VV_OK);
    assert_int_equal(test_apply(&out, &vvi_operation_components, field, NULL, NULL), VV_OK);
    static const double want[4] = {2, 1, 1, 3};
    for (int i = 0; i < 4; i++)
        assert_true(vv_field_value(out, i, 0, 0, 0) == want[i]);
    vv_field_release(out);
    vv_field_release(field);
}

static void what_makes_no_sense_is_refused(void **state)
{
    (void)state;
    static volume v = {.n = {3, 2, 1}, .v = {1, 2}};
    vv_field *whole = field_of(&v, VV_TYPE_U8), *real = field_of(&v, VV_TYPE_F32), *out;
    static const char *const wrong[] = {"connectivity=7", "range=5..1",         "range=x", "min_size=2mm",
                                        "min_size=-1",    "min_size=3furlong3", "keep=0"};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++)
        assert_int_equal(test_apply(&out, &vvi_operation_components, whole, wrong[i], NULL), VV_E_ARGUMENT);
    assert_int_equal(test_apply(&out, &vvi_operation_components, real, NULL, NULL), VV_E_ARGUMENT);
    vv_field_release(whole);
    vv_field_release(real);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(parts_are_those_of_a_flood_fill), cmocka_unit_test(every_instruction_set_finds_the_same_runs),
        cmocka_unit_test(small_parts_are_left_out),        cmocka_unit_test(neighbours_beyond_2_to_53_are_two_parts),
        cmocka_unit_test(what_makes_no_sense_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
