/* Every build of the ray-casting kernels against the reference in double precision, on random volumes of every sample
 * type, smooth and nearest, in every mode; and against itself: skipping, threads. */
#include "core/cpu.h"
#include "fields.h"
#include "ray_scene.h"
#include "scene/lens.h"
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

/* The same source one lane wide, plain C: built for this test alone. */
extern const vvi_ray_kernels vvi_ray_kernels_scalar;

static const vv_type types[] = {VV_TYPE_U8, VV_TYPE_U16, VV_TYPE_I16, VV_TYPE_F32, VV_TYPE_I8, VV_TYPE_F64};
enum { TYPES = sizeof types / sizeof *types };

static void set(test_ray_scene *s, const char *path, const char *json)
{
    vv_object *params = &s->params->base;
    assert_int_equal(vv_path_set(&params, path, json, NULL), VV_OK);
    s->params = (vvi_raycast_params *)params;
    s->scene.params = params;
}

/* Random samples, smoothed by being few: dims from 1 to 13, a sheared and mirrored placement, a scale and offset. */
static vv_field *random_field(vv_type type, const int64_t dims[3], uint64_t seed)
{
    vv_field_info info = vv_field_info_default();
    info.type = type;
    memcpy(info.grid.dims, dims, sizeof info.grid.dims);
    info.grid.index_to_world.axis[0] = (vv_vec3){-1.1, 0.1, 0};
    info.grid.index_to_world.axis[1] = (vv_vec3){0.2, 0.9, 0.1};
    info.grid.index_to_world.axis[2] = (vv_vec3){0, -0.3, 1.4};
    info.grid.index_to_world.origin = (vv_vec3){4, -7, 2};
    info.value_scale = seed % 2 ? 1 : -0.5;
    info.value_offset = seed % 3 ? 0 : 10;
    vv_field *field = test_field_random(&info, seed, NULL);
    assert_non_null(field);
    return field;
}

static const char *const modes[] = {[VV_RAY_COMPOSITE] = "composite",
                                    [VV_RAY_MAXIMUM] = "maximum",
                                    [VV_RAY_MINIMUM] = "minimum",
                                    [VV_RAY_MEAN] = "mean",
                                    [VV_RAY_SUM] = "sum",
                                    [VV_RAY_LOCAL_MAXIMUM] = "local-maximum",
                                    [VV_RAY_ISOSURFACE] = "isosurface"};
enum { MODES = sizeof modes / sizeof *modes };

/* A scene of the field seen from an oblique direction, with a transfer function of ramps and jumps. */
static void random_scene(test_ray_scene *s, const vv_field *field, int mode, uint64_t seed)
{
    test_ray_scene_init(s, field, 10);
    s->scene.width = 23; /* no multiple of a packet or a tile */
    s->scene.height = s->scene.rows = 19;
    const vv_grid *grid = &vv_field_get_info(field)->grid;
    const vv_bounds b = vv_grid_bounds(grid);
    const vv_vec3 at = vvi_scaled(vvi_add(b.lo, b.hi), 0.5);
    const double size = vvi_length(vvi_sub(b.hi, b.lo)) + 2;
    const vv_vec3 away = {test_random_unit(seed, 1) - 0.5, test_random_unit(seed, 2) - 0.5,
                          test_random_unit(seed, 3) - 0.4};
    vv_vec3 from = away;
    assert_true(vvi_unit(&from));
    const bool parallel = seed % 2;
    test_ray_scene_look(s, vvi_add(at, vvi_scaled(from, 2 * size)), at, parallel ? 0 : 0.5, size);
    const double lo = s->statistics.min, w = s->statistics.max - lo;
    test_ray_scene_opacity(
        s, (const double[]){lo, 0, lo + 0.3 * w, 0, lo + 0.5 * w, 0.6, lo + 0.6 * w, 0.1, lo + 0.6 * w, 0, lo + w, 0.9},
        6);
    test_ray_scene_color(s, (const double[]){lo, 0.1, 0.9, 0.2, lo + 0.5 * w, 0.9, 0.3, 0.1, lo + w, 0.2, 0.3, 1}, 3);
    s->actor.iso = lo + 0.7 * w;
    set(s, "mode", modes[mode]);
    set(s, "step", "0.37");
    if (seed % 5 != 0)
        test_ray_scene_light(s);
    if (seed % 4 == 1)
        s->actor.shading_model = VV_SHADING_PHONG;
    if (seed % 4 == 2)
        set(s, "lighting", "\"cinematic\"");
    s->actor.two_sided = seed % 3 != 0;
    s->actor.cap = seed % 2 == 0;
    set(s, "gradient", seed % 7 < 2 ? "cell" : "central");
    if (seed % 3 == 2) {
        s->actor.n_planes = 2;
        s->planes[0] = (vv_plane){{0.6, 0, 0.8}, vvi_dot((vv_vec3){0.6, 0, 0.8}, at) - 1};
        s->planes[1] = (vv_plane){{0, -1, 0}, -at.y - 2};
    }
}

/* Share of pixels that may differ by more than the tolerance: where a sample falls on a jump of the transfer function
 * or of the nearest sample, rounding decides. */
static void compare_with_reference(const test_ray_scene *s, const char *cpu, const char *what, double share,
                                   const double *want)
{
    vv_image *image = cpu ? test_ray_picture(s, cpu, 1) : test_ray_picture_by(s, &vvi_ray_kernels_scalar);
    const int n = s->scene.width * s->scene.height;
    int bad = 0;
    double worst = 0;
    for (int i = 0; i < n; i++) {
        double d = 0;
        for (int c = 0; c < 4; c++)
            d = fmax(d, fabs((double)image->rgba[4 * i + c] - want[5 * i + c]));
        bad += d > 2e-3;
        worst = fmax(worst, d);
    }
    if (bad > share * n)
        fail_msg("%s, %s: %d of %d pixels differ, by up to %g", cpu ? cpu : "scalar", what, bad, n, worst);
    vv_image_release(image);
}

static void compare_builds(vv_type type, const int64_t size[3], int mode, bool nearest, uint64_t seed)
{
    vv_field *field = random_field(type, size, seed);
    test_ray_scene s;
    random_scene(&s, field, mode, seed);
    s.actor.nearest = nearest;
    char what[128];
    snprintf(what, sizeof what, "%s %s %s %lldx%lldx%lld, seed %llu", vv_type_name(type), modes[mode],
             nearest ? "nearest" : "linear", (long long)size[0], (long long)size[1], (long long)size[2],
             (unsigned long long)seed);
    double *want = test_ray_reference(&s);
    for (const char *const *cpu = test_ray_cpus(); *cpu; cpu++)
        compare_with_reference(&s, *cpu, what, 0.03, want);
    compare_with_reference(&s, NULL, what, 0.03, want);
    free(want);
    test_ray_scene_finish(&s);
    vv_field_release(field);
}

static void pixels_equal_the_reference_in_every_build(void **state)
{
    (void)state;
    static const int64_t sizes[][3] = {{13, 11, 7}, {2, 2, 2}, {1, 5, 6}, {7, 1, 1}, {1, 1, 1}, {5, 17, 2}};
    const uint64_t first = test_seed();
    for (int t = 0; t < TYPES; t++)
        for (int mode = 0; mode < MODES; mode++)
            for (int nearest = 0; nearest < 2; nearest++)
                for (size_t z = 0; z < sizeof sizes / sizeof *sizes; z++)
                    compare_builds(types[t], sizes[z], mode, nearest,
                                   test_random(first, (uint64_t)(t * 1000 + mode * 100 + nearest * 10) + z));
}

static void skipping_changes_no_byte(void **state)
{
    (void)state;
    const uint64_t first = test_seed();
    for (const char *const *cpu = test_ray_cpus(); *cpu; cpu++)
        for (int round = 0; round < 4; round++)
            for (int mode = 0; mode < MODES; mode++) {
                const uint64_t seed = test_random(first, 7000 + (uint64_t)round);
                vv_field_info info = vv_field_info_default();
                info.grid.dims[0] = 37, info.grid.dims[1] = 41, info.grid.dims[2] = 29;
                vv_field *field;
                void *data;
                assert_int_equal(vv_field_new_empty(&field, &data, &info, NULL), VV_OK);
                uint8_t *v = data;
                memset(v, 10, 37 * 41 * 29);
                for (uint64_t i = 0; i < 60; i++) /* bright specks in a dark box */
                    v[test_random(seed, i) % (37 * 41 * 29)] = (uint8_t)(100 + test_random(seed, i + 100) % 156);
                test_ray_scene s;
                random_scene(&s, field, mode, seed);
                s.scene.width = s.scene.height = s.scene.rows = 32;
                s.actor.nearest = round % 4 == 3;
                set(&s, "skipping", "true");
                vv_image *with = test_ray_picture(&s, *cpu, 1);
                set(&s, "skipping", "false");
                vv_image *without = test_ray_picture(&s, *cpu, 1);
                const size_t n = 32 * 32;
                if (mode != VV_RAY_ISOSURFACE) {
                    assert_memory_equal(with->rgba, without->rgba, n * 4 * sizeof(float));
                    assert_memory_equal(with->depth, without->depth, n * sizeof(float));
                }
                for (size_t i = 0; i < n * 4; i++) /* a surface enters cells elsewhere: the same to rounding */
                    assert_true(fabsf(with->rgba[i] - without->rgba[i]) < 2e-3f);
                vv_image_release(with);
                vv_image_release(without);
                test_ray_scene_finish(&s);
                vv_field_release(field);
            }
}

static void any_number_of_threads_gives_the_same_bytes(void **state)
{
    (void)state;
    const int64_t dims[3] = {31, 29, 23};
    for (int mode = 0; mode < MODES; mode++) {
        vv_field *field = random_field(VV_TYPE_U8, dims, test_seed());
        test_ray_scene s;
        random_scene(&s, field, mode, test_seed());
        s.scene.width = 75;
        s.scene.height = s.scene.rows = 61;
        vv_image *one = test_ray_picture(&s, NULL, 1);
        for (int threads = 2; threads <= 3; threads++) {
            vv_image *more = test_ray_picture(&s, NULL, threads);
            assert_memory_equal(one->rgba, more->rgba, 75 * 61 * 4 * sizeof(float));
            assert_memory_equal(one->depth, more->depth, 75 * 61 * sizeof(float));
            vv_image_release(more);
        }
        vv_image_release(one);
        test_ray_scene_finish(&s);
        vv_field_release(field);
    }
}

/* Point sampling --------------------------------------------------------------------------------------------------- */

static const vvi_ray_kernels *build_of(const char *cpu)
{
    for (size_t i = 0; vvi_ray_kernels_nth(i); i++)
        if (strcmp(vvi_ray_kernels_nth(i)->isa, cpu) == 0)
            return vvi_ray_kernels_nth(i);
    fail_msg("no build %s", cpu);
    return NULL;
}

static void samples_of_a_trilinear_field_and_its_gradient_are_exact(void **state)
{
    (void)state;
    /* 3 + 2 x - y + 0.5 z on index coordinates */
    vv_field_info info = vv_field_info_default();
    info.type = VV_TYPE_F32;
    info.grid.dims[0] = 9, info.grid.dims[1] = 8, info.grid.dims[2] = 7;
    vv_field *field = test_field(&test_form_ramp, &info, NULL);
    vvi_lattice_hold hold;
    assert_int_equal(vvi_lattice_open(&hold, field, 0, NULL), VV_OK);
    static const size_t lengths[] = {0, 1, 3, 4, 5, 7, 8, 9, 15, 16, 17, 37};
    for (const char *const *cpu = test_ray_cpus(); *cpu; cpu++)
        for (size_t l = 0; l < sizeof lengths / sizeof *lengths; l++) {
            enum { ROOM = 40 };
            float p[3][ROOM], value[ROOM], g[3][ROOM];
            float *gradient[3] = {g[0], g[1], g[2]};
            const size_t n = lengths[l];
            for (size_t i = 0; i < ROOM; i++) {
                value[i] = g[0][i] = g[1][i] = g[2][i] = 12345; /* canaries */
                for (int a = 0; a < 3; a++)
                    p[a][i] =
                        (float)(test_random_unit(test_seed(), i * 3 + (uint64_t)a) * (double)(info.grid.dims[a] - 1));
            }
            p[0][0] = 8, p[1][0] = 7, p[2][0] = 6; /* the last corner */
            build_of(*cpu)->sample(value, gradient, &hold.lattice, false, p[0], p[1], p[2], n);
            for (size_t i = 0; i < n; i++) {
                assert_true(fabsf(value[i] - (3 + 2 * p[0][i] - p[1][i] + 0.5f * p[2][i])) < 1e-5f);
                assert_true(fabsf(g[0][i] - 2) < 1e-5f && fabsf(g[1][i] + 1) < 1e-5f && fabsf(g[2][i] - 0.5f) < 1e-5f);
            }
            for (size_t i = n; i < ROOM; i++)
                assert_true(value[i] == 12345 && g[0][i] == 12345 && g[1][i] == 12345 && g[2][i] == 12345);
        }
    vvi_lattice_close(&hold);
    vv_field_release(field);
}

static void normals_of_a_ball_of_radius_20_are_right_to_a_twentieth_of_a_degree(void **state)
{
    (void)state;
    vv_field_info info = vv_field_info_default();
    info.type = VV_TYPE_F32;
    vv_field *field;
    void *data;
    enum { N = 48, POINTS = 500 };
    info.grid.dims[0] = info.grid.dims[1] = info.grid.dims[2] = N;
    assert_int_equal(vv_field_new_empty(&field, &data, &info, NULL), VV_OK);
    const vv_vec3 middle = {23.13, 23.27, 23.41};
    for (int i = 0; i < N * N * N; i++)
        ((float *)data)[i] = (float)vvi_length(vvi_sub((vv_vec3){i % N, i / N % N, i / (N * N)}, middle));
    vvi_lattice_hold hold;
    assert_int_equal(vvi_lattice_open(&hold, field, 0, NULL), VV_OK);
    for (const char *const *cpu = test_ray_cpus(); *cpu; cpu++) {
        float p[3][POINTS], v[POINTS], g[3][POINTS];
        float *gradient[3] = {g[0], g[1], g[2]};
        vv_vec3 out[POINTS];
        for (uint64_t i = 0; i < POINTS; i++) {
            out[i] =
                (vv_vec3){test_random_unit(test_seed(), 3 * i) - 0.5, test_random_unit(test_seed(), 3 * i + 1) - 0.5,
                          test_random_unit(test_seed(), 3 * i + 2) - 0.5};
            assert_true(vvi_unit(&out[i]));
            const vv_vec3 at = vvi_add(middle, vvi_scaled(out[i], 20));
            p[0][i] = (float)at.x, p[1][i] = (float)at.y, p[2][i] = (float)at.z;
        }
        build_of(*cpu)->sample(v, gradient, &hold.lattice, false, p[0], p[1], p[2], POINTS);
        for (int i = 0; i < POINTS; i++) {
            vv_vec3 n = {(double)g[0][i], (double)g[1][i], (double)g[2][i]};
            assert_true(vvi_unit(&n));
            assert_true(vvi_length(vvi_cross(n, out[i])) < sin(0.05 * M_PI / 180));
        }
    }
    vvi_lattice_close(&hold);
    vv_field_release(field);
}

static void a_lattice_too_wide_for_32_bits_gives_the_same_samples(void **state)
{
    (void)state;
    const int64_t dims[3] = {11, 13, 9};
    for (int t = 0; t < 4; t++) {
        vv_field *field = random_field(types[t], dims, test_seed());
        vvi_lattice_hold hold;
        assert_int_equal(vvi_lattice_open(&hold, field, 0, NULL), VV_OK);
        vvi_lattice wide = hold.lattice;
        wide.fetch = VVI_FETCH_WIDE;
        for (const char *const *cpu = test_ray_cpus(); *cpu; cpu++) {
            enum { N = 200 };
            float p[3][N], a[4][N], b[4][N];
            float *ga[3] = {a[1], a[2], a[3]}, *gb[3] = {b[1], b[2], b[3]};
            for (uint64_t i = 0; i < N; i++)
                for (uint64_t x = 0; x < 3; x++)
                    p[x][i] = (float)(test_random_unit(test_seed(), i * 3 + x) * (double)(dims[x] - 1));
            build_of(*cpu)->sample(a[0], ga, &hold.lattice, false, p[0], p[1], p[2], N);
            build_of(*cpu)->sample(b[0], gb, &wide, false, p[0], p[1], p[2], N);
            for (int i = 0; i < 4; i++)
                assert_memory_equal(a[i], b[i], sizeof a[i]);
        }
        vvi_lattice_close(&hold);
        vv_field_release(field);
    }
}

static void powers_and_logarithms_are_right_to_single_precision(void **state)
{
    (void)state;
    enum { N = 4001 };
    static float x[N], e[N], l[N];
    for (const char *const *cpu = test_ray_cpus(); *cpu; cpu++) {
        for (int i = 0; i < N; i++)
            x[i] = (float)((i - 2000) * 0.05);
        build_of(*cpu)->exp2(e, x, N);
        for (int i = 0; i < N; i++)
            assert_true(fabs((double)e[i] / exp2((double)x[i]) - 1) < 1e-6);
        for (int i = 0; i < N; i++)
            x[i] = (float)exp((i - 2000) * 0.04);
        build_of(*cpu)->log2(l, x, N);
        for (int i = 0; i < N; i++)
            assert_true(fabs((double)l[i] - log2((double)x[i])) < 4e-7 * fmax(1, fabs(log2((double)x[i]))));
        build_of(*cpu)->rsqrt(l, x, N);
        for (int i = 0; i < N; i++)
            assert_true(fabs((double)l[i] * sqrt((double)x[i]) - 1) < 3e-7);
    }
}

static void what_is_no_number_is_clear_and_an_outlier_has_the_last_colour(void **state)
{
    (void)state;
    vv_field_info info = vv_field_info_default();
    info.type = VV_TYPE_F32;
    info.grid.dims[0] = info.grid.dims[1] = info.grid.dims[2] = 4;
    static const float values[] = {NAN, INFINITY, -INFINITY, 1e30f};
    for (int v = 0; v < 4; v++) {
        vv_field *field;
        void *data;
        assert_int_equal(vv_field_new_empty(&field, &data, &info, NULL), VV_OK);
        for (int i = 0; i < 64; i++)
            ((float *)data)[i] = values[v];
        test_ray_scene s;
        test_ray_scene_init(&s, field, 2);
        test_ray_scene_opacity(&s, (const double[]){0, 0, 1, 0.5}, 2);
        test_ray_scene_color(&s, (const double[]){0, 1, 0, 0, 1, 0, 1, 0}, 2);
        for (const char *const *cpu = test_ray_cpus(); *cpu; cpu++)
            for (int mode = 0; mode < MODES; mode++) {
                set(&s, "mode", modes[mode]);
                vv_image *image = test_ray_picture(&s, *cpu, 1);
                for (int i = 0; i < 64 * 64 * 4; i++)
                    assert_true(isfinite(image->rgba[i]));
                const float *middle = image->rgba + 4 * (32 * 64 + 32);
                if (v == 0 || (v < 3 && mode == 0))
                    assert_true(middle[3] == 0);
                if (v == 3 && mode == 0)
                    assert_true(middle[3] > 0.8f && middle[0] == 0 && middle[1] > 0.8f);
                vv_image_release(image);
            }
        test_ray_scene_finish(&s);
        vv_field_release(field);
    }
}

/* A ball of radius 9 voxels, values (16 - distance) * scale + offset. */
static vv_field *scaled_ball(vv_type type, double scale, double offset)
{
    vv_field_info info = vv_field_info_default();
    info.type = type;
    info.grid.dims[0] = info.grid.dims[1] = info.grid.dims[2] = 24;
    vv_field *field;
    void *data;
    assert_int_equal(vv_field_new_empty(&field, &data, &info, NULL), VV_OK);
    for (int i = 0; i < 24 * 24 * 24; i++) {
        const double x = i % 24 - 11.5, y = i / 24 % 24 - 11.5, z = i / 576 - 11.5;
        const double v = (16 - sqrt(x * x + y * y + z * z)) * scale + offset;
        if (type == VV_TYPE_F64)
            ((double *)data)[i] = v;
        else if (type == VV_TYPE_F32)
            ((float *)data)[i] = (float)v;
        else
            ((int32_t *)data)[i] = (int32_t)lround(v);
    }
    return field;
}

static void values_of_any_size_make_the_same_picture(void **state)
{
    (void)state;
    static const struct {
        vv_type type;
        double scale, offset;
    } cases[] = {{VV_TYPE_F64, 1, 0},       {VV_TYPE_F32, 1e20, 0},   {VV_TYPE_F32, 1e30, 0},  {VV_TYPE_F32, 1e-20, 0},
                 {VV_TYPE_F32, 1e-30, 0},   {VV_TYPE_F64, 1e-200, 0}, {VV_TYPE_F64, 1e200, 0}, {VV_TYPE_F64, 1, 1e9},
                 {VV_TYPE_I32, 1e5, 1.9e9}, {VV_TYPE_F64, -1, 0}};
    for (int mode = 0; mode < MODES; mode += VV_RAY_ISOSURFACE) {
        vv_image *first = NULL;
        for (size_t i = 0; i < sizeof cases / sizeof *cases - (mode ? 1 : 0); i++) {
            const double a = cases[i].scale, b = cases[i].offset;
            vv_field *field = scaled_ball(cases[i].type, a, b);
            test_ray_scene s;
            test_ray_scene_init(&s, field, 22);
            const double rows[] = {7 * a + b, 0, 8 * a + b, 0.6};
            test_ray_scene_opacity(&s, a > 0 ? rows : (const double[]){-8, 0.6, -7, 0}, 2);
            test_ray_scene_light(&s);
            s.actor.iso = 7 * a + b;
            set(&s, "mode", modes[mode]);
            vv_image *image = test_ray_picture(&s, NULL, 1);
            first = first ? first : vv_image_retain(image);
            for (int p = 0; p < 64 * 64 * 4; p++)
                if (fabsf(image->rgba[p] - first->rgba[p]) > 5e-3f)
                    fail_msg("%s: values times %g plus %g differ at %d: %g for %g", modes[mode], a, b, p / 4,
                             (double)image->rgba[p], (double)first->rgba[p]);
            assert_true(image->rgba[4 * (32 * 64 + 32) + 3] > 0.5f);
            vv_image_release(image);
            test_ray_scene_finish(&s);
            vv_field_release(field);
        }
        vv_image_release(first);
    }
}

static void more_steps_than_anybody_waits_for_are_refused(void **state)
{
    (void)state;
    vv_field *field = scaled_ball(VV_TYPE_F32, 1, 0);
    test_ray_scene s;
    test_ray_scene_init(&s, field, 22);
    set(&s, "step", "1e-9");
    void *prepared;
    assert_int_equal(vvi_raycast_prepare(&prepared, &s.scene, NULL), VV_E_ARGUMENT);
    assert_non_null(strstr(vv_error_last()->message, "set at least"));
    test_ray_scene_finish(&s);
    vv_field_release(field);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pixels_equal_the_reference_in_every_build),
        cmocka_unit_test(skipping_changes_no_byte),
        cmocka_unit_test(any_number_of_threads_gives_the_same_bytes),
        cmocka_unit_test(samples_of_a_trilinear_field_and_its_gradient_are_exact),
        cmocka_unit_test(normals_of_a_ball_of_radius_20_are_right_to_a_twentieth_of_a_degree),
        cmocka_unit_test(a_lattice_too_wide_for_32_bits_gives_the_same_samples),
        cmocka_unit_test(powers_and_logarithms_are_right_to_single_precision),
        cmocka_unit_test(values_of_any_size_make_the_same_picture),
        cmocka_unit_test(more_steps_than_anybody_waits_for_are_refused),
        cmocka_unit_test(what_is_no_number_is_clear_and_an_outlier_has_the_last_colour),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
