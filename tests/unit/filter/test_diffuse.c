/* Diffusion that stops at edges against the same steps in double precision, and the laws that it keeps. */
#include "fields.h"
#include "grid/field.h"
#include "jobs.h"
#include "operations.h"
#include "registry.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static vv_field_info info_of(int64_t x, int64_t y, int64_t z, vv_type type, int components)
{
    vv_field_info info = vv_field_info_default();
    info.grid.dims[0] = x, info.grid.dims[1] = y, info.grid.dims[2] = z;
    info.type = type;
    info.components = components;
    strcpy(info.grid.unit, "mm");
    return info;
}

static vv_field *diffused(const vv_field *in, const char *settings)
{
    vv_field *out;
    if (test_apply(&out, &vvi_operation_diffuse, in, settings, NULL) != VV_OK)
        fail_msg("%s: %s", settings ? settings : "no settings", vv_error_last()->message);
    return out;
}

/* Values of 0 to 100 at random; every `hole`-th is NaN. */
static vv_field *random_field(const vv_field_info *info, uint64_t hole)
{
    vv_field *field;
    void *data;
    const size_t n = (size_t)(info->grid.dims[0] * info->grid.dims[1] * info->grid.dims[2] * info->components);
    assert_int_equal(vv_field_new_empty(&field, &data, info, NULL), VV_OK);
    for (size_t i = 0; i < n; i++) {
        const double v = hole && test_random(7, i) % hole == 0 ? NAN : 100 * test_random_unit(3, i);
        vvi_samples_from_f64((char *)data + i * vv_type_bytes(info->type), &v, info->type, 1);
    }
    return field;
}

/* One step of one component, of packed doubles. */
static void step(double *out, const double *in, const int64_t dims[3], const double ratio[3], double edge,
                 bool rational, double time)
{
    const int64_t stride[3] = {1, dims[0], dims[0] * dims[1]};
    for (int64_t i = 0; i < dims[0] * dims[1] * dims[2]; i++) {
        const int64_t at[3] = {i % dims[0], i / dims[0] % dims[1], i / stride[2]};
        out[i] = in[i];
        for (int a = 0; a < 3; a++)
            for (int to = -1; to <= 1; to += 2) {
                if (at[a] + to < 0 || at[a] + to >= dims[a])
                    continue;
                const double d = in[i + to * stride[a]] - in[i], u = d / ratio[a] / edge;
                if (isfinite(d))
                    out[i] += time / (ratio[a] * ratio[a]) * d * (rational ? 1 / (1 + u * u) : exp(-u * u));
            }
    }
}

static void expect_steps(const vv_field *in, const vv_field *out, int steps, const double ratio[3], double edge,
                         bool rational, double time)
{
    const vv_field_info *info = vv_field_get_info(in);
    const int64_t *d = info->grid.dims, n = d[0] * d[1] * d[2];
    const double tolerance = vv_type_is_float(info->type) ? 5e-5 : 0.5001;
    double *now = calloc((size_t)n, sizeof *now), *next = calloc((size_t)n, sizeof *next);
    assert_true(now && next);
    for (int c = 0; c < info->components; c++) {
        for (int64_t i = 0; i < n; i++)
            now[i] = vv_field_value(in, i % d[0], i / d[0] % d[1], i / d[0] / d[1], c);
        for (int s = 0; s < steps; s++) {
            step(next, now, d, ratio, edge, rational, time);
            memcpy(now, next, (size_t)n * sizeof *now);
        }
        for (int64_t i = 0; i < n; i++) {
            const double got = vv_field_value(out, i % d[0], i / d[0] % d[1], i / d[0] / d[1], c);
            if (isnan(now[i]) ? !isnan(got) : !(fabs(got - now[i]) <= tolerance))
                fail_msg("%s sample %d: %.9g is not %.9g", vv_type_name(info->type), (int)i, got, now[i]);
        }
    }
    free(now);
    free(next);
}

static void every_type_and_size_takes_the_same_steps(void **state)
{
    (void)state;
    static const int64_t sizes[][3] = {{37, 5, 11}, {1, 1, 1}, {1, 9, 2}, {2, 1, 9}, {131, 3, 1}};
    static const double ones[3] = {1, 1, 1};
    for (int t = 0; t < VV_TYPE_COUNT; t++)
        for (size_t s = 0; s < sizeof sizes / sizeof *sizes; s++) {
            const vv_field_info info = info_of(sizes[s][0], sizes[s][1], sizes[s][2], (vv_type)t, 1 + t % 3);
            vv_field *in = random_field(&info, vv_type_is_float((vv_type)t) ? 9 : 0);
            vv_field *out = diffused(in, "iterations=4;edge=30;step=0.1");
            expect_steps(in, out, 4, ones, 30, false, 0.1);
            vv_field *rational = diffused(in, "iterations=3;edge=20;step=0.15;conductance=\"rational\"");
            expect_steps(in, rational, 3, ones, 20, true, 0.15);
            vv_field_release(in);
            vv_field_release(out);
            vv_field_release(rational);
        }
}

static void uneven_spacing_and_scaled_values_are_heeded(void **state)
{
    (void)state;
    vv_field_info info = info_of(19, 8, 7, VV_TYPE_F64, 1);
    info.grid.index_to_world.axis[0].x = 0.5;
    info.grid.index_to_world.axis[2].z = 2;
    vv_field *in = random_field(&info, 0), *scaled;
    vv_field *out = diffused(in, "iterations=5;edge=30");
    const double ratio[3] = {1, 2, 4}, time = 0.25 / (1 + 1 / 4. + 1 / 16.);
    expect_steps(in, out, 5, ratio, 30, false, time);
    info.value_scale = -10;
    assert_int_equal(vvi_field_relabel(&scaled, in, &info), VV_OK);
    vv_field *tenfold = diffused(scaled, "iterations=5;edge=300");
    assert_true(test_same_samples(out, tenfold));
    vv_field *all[] = {in, out, scaled, tenfold};
    for (int i = 0; i < 4; i++)
        vv_field_release(all[i]);
}

/* The sum of all values stays, none leaves the range of before, and nothing crosses a high step. */
static void sums_ranges_and_edges_stay(void **state)
{
    (void)state;
    const vv_field_info info = info_of(40, 9, 10, VV_TYPE_F64, 1);
    vv_field *in;
    void *data;
    double before = 0, after = 0, spread = 0;
    assert_int_equal(vv_field_new_empty(&in, &data, &info, NULL), VV_OK);
    for (size_t i = 0; i < 40 * 9 * 10; i++)
        ((double *)data)[i] = (i % 40 < 20 ? 0 : 1000) + test_random_unit(1, i);
    vv_field *out = diffused(in, "iterations=200;edge=10");
    for (int64_t i = 0; i < 40 * 9 * 10; i++) {
        const double was = vv_field_value(in, i % 40, i / 40 % 9, i / 360, 0);
        const double v = vv_field_value(out, i % 40, i / 40 % 9, i / 360, 0), side = i % 40 < 20 ? 0 : 1000;
        before += was;
        after += v;
        assert_true(v >= side && v <= side + 1);
        spread = fmax(spread, fabs(v - side - 0.5));
    }
    assert_true(fabs(before - after) < 1e-7 * before && spread < 0.2);
    vv_field *none = diffused(in, "iterations=0"), *nothing = diffused(in, "edge=0");
    assert_true(test_same_samples(in, none));
    assert_true(test_same_samples(in, nothing));
    vv_field *all[] = {in, out, none, nothing};
    for (int i = 0; i < 4; i++)
        vv_field_release(all[i]);
}

static void slabs_are_the_same_for_any_memory_and_threads(void **state)
{
    (void)state;
    const vv_field_info info = info_of(64, 64, 90, VV_TYPE_U8, 1);
    vv_field *in = random_field(&info, 0), *whole = diffused(in, "iterations=6;edge=30");
    for (int threads = 1; threads < 4; threads++) {
        vv_job *job = test_job(threads, 4 << 20);
        vv_field *out;
        assert_int_equal(test_apply(&out, &vvi_operation_diffuse, in, "iterations=6;edge=30", job), VV_OK);
        assert_true(test_same_samples(out, whole));
        vv_field_release(out);
        vv_job_release(job);
    }
    vv_field_release(in);
    vv_field_release(whole);
}

static void what_makes_no_sense_is_refused(void **state)
{
    (void)state;
    vv_field_info info = info_of(8, 8, 8, VV_TYPE_U8, 1);
    vv_field *in = test_field_random(&info, 1, NULL), *out;
    static const char *const wrong[] = {"step=0.17", "step=-1", "iterations=-1", "edge=-1"};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++)
        assert_int_equal(test_apply(&out, &vvi_operation_diffuse, in, wrong[i], NULL), VV_E_ARGUMENT);
    vv_field_release(in);
    info.meaning = VV_MEANING_LABEL;
    in = test_field_random(&info, 1, NULL);
    assert_int_equal(test_apply(&out, &vvi_operation_diffuse, in, NULL, NULL), VV_E_UNSUPPORTED);
    vv_field_release(in);
}

/* Layers across (2, 1, 2) / 3. */
static double layers(vv_vec3 p)
{
    return 100 * sin(0.8 * (2 * p.x + p.y + 2 * p.z) / 3);
}

static double change(const vv_field *in, const char *settings)
{
    vv_field *out = diffused(in, settings);
    const int64_t *n = vv_field_get_info(in)->grid.dims;
    double most = 0;
    for (int64_t k = n[2] / 2 - 2; k < n[2] / 2 + 2; k++)
        for (int64_t j = n[1] / 2 - 2; j < n[1] / 2 + 2; j++)
            for (int64_t i = n[0] / 2 - 2; i < n[0] / 2 + 2; i++)
                most = fmax(most, fabs(vv_field_value(out, i, j, k, 0) - vv_field_value(in, i, j, k, 0)));
    vv_field_release(out);
    return most;
}

/* What is the same everywhere along layers stays so, on sheared grids too; what flows across them smooths. */
static void along_layers_of_the_world_nothing_changes(void **state)
{
    (void)state;
    static const test_form form = {.name = "layers", .value = layers};
    vv_field_info info = info_of(40, 36, 34, VV_TYPE_F32, 1);
    for (int sheared = 0; sheared < 2; sheared++) {
        info.grid.index_to_world = (vv_affine){
            .axis = {{0.5, 0, sheared * 0.1}, {sheared * 0.15, 0.6, 0}, {0, sheared * -0.1, 0.75}},
        };
        vv_field *in = test_field(&form, &info, NULL);
        const double along = change(in, "method=coherence;alpha=0;edge=1;sigma=0.5;rho=1;iterations=2"),
                     everywhere = change(in, "method=coherence;alpha=1;edge=1;sigma=0.5;rho=1;iterations=2");
        if (!(everywhere > 1 && along < 0.06 * everywhere))
            fail_msg("sheared %d: %g along, %g everywhere", sheared, along, everywhere);
        vv_field_release(in);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_type_and_size_takes_the_same_steps),
        cmocka_unit_test(uneven_spacing_and_scaled_values_are_heeded),
        cmocka_unit_test(sums_ranges_and_edges_stay),
        cmocka_unit_test(slabs_are_the_same_for_any_memory_and_threads),
        cmocka_unit_test(what_makes_no_sense_is_refused),
        cmocka_unit_test(along_layers_of_the_world_nothing_changes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
