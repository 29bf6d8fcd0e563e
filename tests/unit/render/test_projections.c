/* The modes that show one value of each ray, and samples that lie elsewhere in each ray's steps, against closed forms.
 */
#include "fields.h"
#include "grid/field.h"
#include "ray_scene.h"
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static void set(test_ray_scene *s, const char *path, const char *json)
{
    vv_object *params = &s->params->base;
    assert_int_equal(vv_path_set(&params, path, json, NULL), VV_OK);
    s->params = (vvi_raycast_params *)params;
    s->scene.params = params;
}

static void grey(test_ray_scene *s, double lo, double hi)
{
    test_ray_scene_color(s, (const double[]){lo, 0, 0, 0, hi, 1, 1, 1}, 2);
}

/* Floats in a grid of unit voxels. */
static vv_field *new_floats(float **data_out, int64_t nx, int64_t ny, int64_t nz)
{
    vv_field_info info = vv_field_info_default();
    vv_field *field;
    void *data;
    info.type = VV_TYPE_F32;
    info.grid.dims[0] = nx, info.grid.dims[1] = ny, info.grid.dims[2] = nz;
    assert_int_equal(vv_field_new_empty(&field, &data, &info, NULL), VV_OK);
    *data_out = data;
    return field;
}

/* Check 2.C6: the integral over the picture is that over the volume, whatever the direction. Both are exact for values
 * that fall to 0 at the border, where each sample stands for one voxel. */
static void the_sum_over_all_pixels_is_the_volume_integral(void **state)
{
    (void)state;
    enum { N = 20, SIZE = 160 };
    float *v;
    vv_field *field = new_floats(&v, N, N, N);
    double integral = 0;
    for (int k = 0; k < N; k++)
        for (int j = 0; j < N; j++)
            for (int i = 0; i < N; i++) {
                const double x = i / (N - 1.0), y = j / (N - 1.0), z = k / (N - 1.0);
                const double value = 40 * sin(M_PI * x) * sin(M_PI * y) * sin(2 * M_PI * z) * sin(M_PI * z);
                v[(k * N + j) * N + i] = (float)fabs(value);
                integral += fabs(value);
            }
    test_ray_scene s;
    const double height = 36, longest = (N - 1) * sqrt(3.0), middle = (N - 1) / 2.0;
    test_ray_scene_init(&s, field, height);
    s.scene.width = s.scene.height = s.scene.rows = SIZE;
    test_ray_scene_look(&s, (vv_vec3){middle + 31, middle - 47, middle + 22}, (vv_vec3){middle, middle, middle}, 0,
                        height);
    grey(&s, 0, s.statistics.max);
    set(&s, "mode", "sum");
    set(&s, "step", "0.25");
    for (const char *const *cpu = test_ray_cpus(); *cpu; cpu++) {
        vv_image *image = test_ray_picture(&s, *cpu, 1);
        double sum = 0;
        for (int i = 0; i < SIZE * SIZE; i++)
            sum += (double)image->rgba[4 * i];
        const double pixel = height / SIZE;
        assert_true(fabs(sum * s.statistics.max * longest * pixel * pixel / integral - 1) < 1e-3);
        vv_image_release(image);
    }
    test_ray_scene_finish(&s);
    vv_field_release(field);
}

/* A row of values along the line of sight (from the viewer on), the same over the whole cross-section. */
static vv_field *profile(const float *values, int64_t n)
{
    float *v;
    vv_field *field = new_floats(&v, 4, 4, n);
    for (int64_t k = 0; k < n; k++)
        for (int i = 0; i < 16; i++)
            v[(n - 1 - k) * 16 + i] = values[k];
    return field;
}

/* The middle pixel's grey over 0..100, and its depth from the first sample. */
static double look_at_profile(double *depth_out, const float *values, int64_t n, const char *mode,
                              const char *threshold)
{
    vv_field *field = profile(values, n);
    test_ray_scene s;
    test_ray_scene_init(&s, field, 4);
    s.scene.width = s.scene.height = s.scene.rows = 4;
    test_ray_scene_look(&s, (vv_vec3){1.5, 1.5, 50}, (vv_vec3){1.5, 1.5, 0}, 0, 2);
    grey(&s, 0, 100);
    set(&s, "mode", mode);
    if (threshold)
        set(&s, "threshold", threshold);
    vv_image *image = test_ray_picture(&s, NULL, 1);
    const double value = 100 * (double)image->rgba[4 * 5];
    if (depth_out)
        *depth_out = (double)image->depth[5] - (50 - (double)(n - 1));
    vv_image_release(image);
    test_ray_scene_finish(&s);
    vv_field_release(field);
    return value;
}

static void each_mode_finds_its_value_of_a_profile(void **state)
{
    (void)state;
    static const float row[] = {5, 30, 20, 60, 40, 40, 90, 10, 70};
    enum { N = sizeof row / sizeof *row };
    double depth;
    assert_true(fabs(look_at_profile(&depth, row, N, "maximum", NULL) - 90) < 0.02 && fabs(depth - 6) < 1e-4);
    assert_true(fabs(look_at_profile(&depth, row, N, "minimum", NULL) - 5) < 0.02 && fabs(depth) < 1e-4);
    /* steps of one voxel from sample to sample: midpoints, which is the trapezoid rule over the samples */
    double mean = -(row[0] + row[N - 1]) / 2.0;
    for (int i = 0; i < N; i++)
        mean += (double)row[i];
    mean /= N - 1;
    assert_true(fabs(look_at_profile(&depth, row, N, "mean", NULL) - mean) < 0.02 && isinf(depth));
    const double longest = sqrt((N - 1.0) * (N - 1.0) + 3 * 3 + 3 * 3);
    assert_true(fabs(look_at_profile(NULL, row, N, "sum", NULL) - mean * (N - 1) / longest) < 0.02);
}

static void the_local_maximum_is_the_first_above_the_threshold(void **state)
{
    (void)state;
    static const float row[] = {5, 30, 20, 60, 60, 40, 90, 10, 70};
    enum { N = sizeof row / sizeof *row };
    static const struct {
        const char *threshold;
        double value, depth;
    } cases[] = {{"0", 30, 1}, {"30", 30, 1}, {"31", 60, 3}, {"60.5", 90, 6}, {"95", 90, 6}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        double depth;
        const double value = look_at_profile(&depth, row, N, "local-maximum", cases[i].threshold);
        assert_true(fabs(value - cases[i].value) < 0.02);
        assert_true(fabs(depth - cases[i].depth) < 1e-4);
    }
}

static void a_negative_scale_turns_extrema_round(void **state)
{
    (void)state;
    vv_field_info info = vv_field_info_default();
    info.grid.dims[0] = info.grid.dims[1] = 4, info.grid.dims[2] = 3;
    info.value_scale = -1;
    info.value_offset = 100;
    vv_field *field;
    void *data;
    assert_int_equal(vv_field_new_empty(&field, &data, &info, NULL), VV_OK);
    memset(data, 20, 16); /* 80, 30, 50 */
    memset((char *)data + 16, 70, 16);
    memset((char *)data + 32, 50, 16);
    test_ray_scene s;
    test_ray_scene_init(&s, field, 2);
    s.scene.width = s.scene.height = s.scene.rows = 4;
    grey(&s, 0, 100);
    static const struct {
        const char *mode;
        double value;
    } cases[] = {{"maximum", 80}, {"minimum", 30}};
    for (int i = 0; i < 2; i++) {
        set(&s, "mode", cases[i].mode);
        vv_image *image = test_ray_picture(&s, NULL, 1);
        assert_true(fabs(100 * (double)image->rgba[4 * 5] - cases[i].value) < 0.02);
        vv_image_release(image);
    }
    test_ray_scene_finish(&s);
    vv_field_release(field);
}

/* However its samples lie in their steps, a uniform slab is as opaque as its length says; and neighbouring rays take
 * different places, spread evenly. */
static void jitter_moves_samples_and_no_light(void **state)
{
    (void)state;
    float *v;
    vv_field *field = new_floats(&v, 4, 4, 9);
    for (int i = 0; i < 4 * 4 * 9; i++)
        v[i] = 1;
    test_ray_scene s;
    test_ray_scene_init(&s, field, 2);
    test_ray_scene_look(&s, (vv_vec3){1.5, 1.5, 50}, (vv_vec3){1.5, 1.5, 0}, 0, 2);
    s.statistics.min = 0, s.statistics.max = 2;
    test_ray_scene_opacity(&s, (const double[]){0, 0.2, 2, 0.2}, 2);
    set(&s, "jitter", "true");
    set(&s, "step", "0.7");
    vv_image *image = test_ray_picture(&s, NULL, 1);
    for (int i = 0; i < 64 * 64; i++)
        assert_true(fabs((double)image->rgba[4 * i + 3] - (1 - pow(0.8, 8))) < 1e-5);
    vv_image_release(image);
    int bins[8] = {0};
    for (int32_t y = 0; y < 64; y++)
        for (int32_t x = 0; x < 64; x++) {
            const float phase = vvi_ray_phase(x, y, 3);
            assert_true(phase >= 0 && phase < 1);
            bins[(int)(phase * 8)]++;
        }
    for (int i = 0; i < 8; i++)
        assert_true(abs(bins[i] - 512) < 40);
    test_ray_scene_finish(&s);
    vv_field_release(field);
}

static uint64_t count_samples(const test_ray_scene *s)
{
    void *state = NULL;
    vv_image *image = NULL;
    vv_render_counts counts = {0};
    const vv_pass pass = {.x = 0.5, .y = 0.5, .stride = 1};
    assert_int_equal(vvi_raycast_prepare(&state, &s->scene, NULL), VV_OK);
    assert_int_equal(vv_image_new(&image, 64, 64, VV_LAYER_DEPTH, NULL), VV_OK);
    assert_int_equal(s->scene.renderer->render(state, &pass, &(vv_tile){0, 0, 64, 64}, image, &counts, NULL), VV_OK);
    vv_image_release(image);
    vvi_raycast_finish(state);
    return counts.samples;
}

/* Random values in two corners of a box of one value, or of none. */
static vv_field *corners_of_a_box(vv_type type, bool hollow, uint64_t seed)
{
    enum { N = 45 };
    static double values[N * N * N];
    vv_field_info info = vv_field_info_default();
    vv_field *field;
    void *data;
    info.type = type;
    info.grid.dims[0] = info.grid.dims[1] = info.grid.dims[2] = N;
    for (int i = 0; i < N * N * N; i++) {
        const int x = i % N, y = i / N % N, z = i / N / N;
        const bool inside = (x < 9 && y < 12 && z < 10) || (x > 35 && y > 33 && z > 30);
        values[i] = inside ? (double)(test_random(seed, (uint64_t)i) % 250) : hollow ? NAN : 40;
    }
    assert_int_equal(vv_field_new_empty(&field, &data, &info, NULL), VV_OK);
    vvi_samples_from_f64(data, values, type, N * N * N);
    return field;
}

/* Means and sums through blocks of one value, or of none, are those of all samples. */
static void blocks_of_one_value_are_taken_at_once(void **state)
{
    static const vv_type types[] = {VV_TYPE_U8,  VV_TYPE_I8,  VV_TYPE_U16, VV_TYPE_I16, VV_TYPE_U32,
                                    VV_TYPE_I32, VV_TYPE_F32, VV_TYPE_F64, VV_TYPE_F32};
    (void)state;
    for (size_t t = 0; t < sizeof types / sizeof *types; t++)
        for (int kind = 0; kind < 4; kind++) {
            const bool hollow = t + 1 == sizeof types / sizeof *types;
            test_ray_scene s;
            vv_field *field = corners_of_a_box(types[t], hollow, test_random(test_seed(), t));
            test_ray_scene_init(&s, field, 70);
            grey(&s, 0, 120);
            s.actor.nearest = kind / 2;
            test_ray_scene_look(&s, (vv_vec3){70, -50, 60}, (vv_vec3){22, 22, 22}, kind == 1 ? 0.7 : 0, 70);
            set(&s, "mode", kind % 2 ? "mean" : "sum");
            set(&s, "step", "0.37");
            double *want = test_ray_reference(&s);
            for (const char *const *cpu = test_ray_cpus(); *cpu; cpu++) {
                vv_image *image = test_ray_picture(&s, *cpu, 1);
                int bad = 0;
                for (int i = 0; i < 64 * 64; i++)
                    bad += !(fabs((double)image->rgba[4 * i] - want[5 * i]) < 1e-3) ||
                           fabs((double)image->rgba[4 * i + 3] - want[5 * i + 3]) > 0;
                if (bad > 64) /* at borders of nearest samples */
                    fail_msg("%s of %s, %d: %d pixels differ", *cpu, vv_type_name(types[t]), kind, bad);
                vv_image_release(image);
            }
            const uint64_t few = count_samples(&s);
            set(&s, "skipping", "false");
            const uint64_t all = count_samples(&s);
            if (few > all / 4)
                fail_msg("%s, %d: %llu samples of %llu", vv_type_name(types[t]), kind, (unsigned long long)few,
                         (unsigned long long)all);
            free(want);
            test_ray_scene_finish(&s);
            vv_field_release(field);
        }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_sum_over_all_pixels_is_the_volume_integral),
        cmocka_unit_test(each_mode_finds_its_value_of_a_profile),
        cmocka_unit_test(the_local_maximum_is_the_first_above_the_threshold),
        cmocka_unit_test(a_negative_scale_turns_extrema_round),
        cmocka_unit_test(blocks_of_one_value_are_taken_at_once),
        cmocka_unit_test(jitter_moves_samples_and_no_light),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
