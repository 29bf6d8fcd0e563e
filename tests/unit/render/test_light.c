/* Shadows and ambient occlusion against closed forms: fog of one density in balls and half-spaces. */
#include "core/cache.h"
#include "fields.h"
#include "jobs.h"
#include "ray_scene.h"
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#define KAPPA 0.12

enum { RADIUS = 24, HALF = 32 };

/* 0 on the ball's surface and the same everywhere but next to it: fog has no gradient. */
static double inside(vv_vec3 p)
{
    return fmin(fmax(RADIUS - vvi_length(p), -1), 1);
}
static const test_form ball = {"ball", inside, NULL};

static void set(test_ray_scene *s, const char *path, const char *json)
{
    vv_object *params = &s->params->base;
    assert_int_equal(vv_path_set(&params, path, json, NULL), VV_OK);
    s->params = (vvi_raycast_params *)params;
    s->scene.params = params;
}

/* A ball of fog about 0, one lamp. */
static vv_field *fog_ball(test_ray_scene *s, vv_vec3 travel)
{
    vv_field *field = test_field_cube(&ball, 2 * HALF + 1, -HALF, HALF, NULL);
    const double through = 1 - exp(-KAPPA);
    assert_non_null(field);
    test_ray_scene_init(s, field, 2.2 * HALF);
    test_ray_scene_opacity(s, (const double[]){0, 0, 0, through}, 2);
    test_ray_scene_color(s, (const double[]){0, 1, 0.5, 0.25}, 1);
    test_ray_scene_light(s);
    s->scene.n_lamps = 1;
    s->lamps[0].direction = travel;
    assert_true(vvi_unit(&s->lamps[0].direction));
    return field;
}

static vvi_raycast_state *prepare(const test_ray_scene *s, vv_job *job)
{
    void *state = NULL;
    assert_int_equal(vvi_raycast_prepare(&state, &s->scene, job), VV_OK);
    return state;
}

/* How much fog a way has from a place in the ball. */
static double chord(vv_vec3 from, vv_vec3 way)
{
    const double b = vvi_dot(from, way), c = vvi_dot(from, from) - (double)RADIUS * RADIUS, d = b * b - c;
    if (d <= 0)
        return 0;
    return fmax(-b + sqrt(d), 0) - fmax(-b - sqrt(d), 0);
}

/* Where a lamp's way is along an axis, and where it is not; the rim of the shadow, which cells blur, is left out. */
static void light_in_a_ball_of_fog_follows_the_chord(void **state)
{
    (void)state;
    static const vv_vec3 ways[] = {{0, 0, -1}, {1, 0, 0}, {0, -1, 0}, {0.3, 0.5, -0.8}, {-0.7, 0.6, 0.4}};
    for (size_t w = 0; w < sizeof ways / sizeof *ways; w++) {
        test_ray_scene s;
        vv_field *field = fog_ball(&s, ways[w]);
        set(&s, "shadows", "true");
        set(&s, "lamp_size", "0");
        vvi_raycast_state *f = prepare(&s, NULL);
        const vv_vec3 to = vvi_scaled(s.lamps[0].direction, -1);
        double worst = 0, sum = 0;
        int n = 0;
        for (int i = 0; i < 4000; i++) {
            const vv_vec3 p = {60 * (test_random_unit(7, 3 * (uint64_t)i) - 0.5),
                               60 * (test_random_unit(7, 3 * (uint64_t)i + 1) - 0.5),
                               60 * (test_random_unit(7, 3 * (uint64_t)i + 2) - 0.5)};
            const double aside = vvi_length(vvi_sub(p, vvi_scaled(to, vvi_dot(p, to))));
            if (fabs(aside - RADIUS) < 4)
                continue;
            double shares[VVI_LIGHT_SHARES];
            vvi_light_volume_at(shares, &f->light, p, vvi_vec(0, 0, 0));
            assert_float_equal(shares[0], 1, 1e-6); /* nobody asked for ambient occlusion */
            const double error = fabs(shares[1] - exp(-KAPPA * chord(p, to)));
            worst = fmax(worst, error);
            sum += error;
            n++;
        }
        if (worst > 0.08 || sum > 0.01 * n)
            fail_msg("way %zu: off by up to %.4f, %.4f in the mean", w, worst, sum / n);
        vvi_raycast_finish(f);
        test_ray_scene_finish(&s);
        vv_field_release(field);
    }
}

/* A point lamp in a ball of thin fog, next to its middle. */
static void a_point_lamp_in_fog_fades_with_distance(void **state)
{
    (void)state;
    test_ray_scene s;
    vv_field *field = fog_ball(&s, vvi_vec(0, 0, -1));
    s.lamps[0] = (vv_lamp){.kind = VV_LIGHT_POINT, .color = {1, 1, 1}, .falloff = {1, 0, 0}, .position = {3, -2, 1}};
    set(&s, "shadows", "true");
    vvi_raycast_state *f = prepare(&s, NULL);
    for (int i = 0; i < 500; i++) {
        const vv_vec3 p = {30 * (test_random_unit(9, 3 * (uint64_t)i) - 0.5),
                           30 * (test_random_unit(9, 3 * (uint64_t)i + 1) - 0.5),
                           30 * (test_random_unit(9, 3 * (uint64_t)i + 2) - 0.5)};
        double shares[VVI_LIGHT_SHARES];
        const double distance = vvi_length(vvi_sub(s.lamps[0].position, p));
        if (distance < 3)
            continue;
        vvi_light_volume_at(shares, &f->light, p, vvi_vec(0, 0, 0));
        assert_float_equal(shares[1], exp(-KAPPA * distance), 0.02);
    }
    vvi_raycast_finish(f);
    test_ray_scene_finish(&s);
    vv_field_release(field);
}

/* The mean over all ways of the ambient light at height h above fog that fills all below 0 (h < 0: inside). */
static double above_fog(double h, double kappa, double radius)
{
    enum { STEPS = 20000 };
    double sum = 0;
    for (int i = 0; i < STEPS; i++) {
        const double c = 2 * (i + 0.5) / STEPS - 1; /* cosine of the way to the vertical: all alike on a sphere */
        const double length = c * h < 0 ? fabs(h / c) : INFINITY, k = kappa + 1 / radius; /* to the border */
        const double in_fog = 1 / (radius * k), in_air = 1;
        const double near = h < 0 ? in_fog : in_air, far = h < 0 ? in_air : in_fog;
        const double left = exp(-length * (h < 0 ? k : 1 / radius));
        sum += near * (1 - left) + far * left;
    }
    return sum / STEPS;
}

static void ambient_light_above_a_half_space_is_the_formula(void **state)
{
    (void)state;
    const double radius = 9, kappas[] = {0.05, 0.4, 3};
    const double side[3] = {1, 1.5, 0.8};
    vvi_light_grid g = {.n = {48, 32, 60}};
    g.cell_to_world = vv_affine_identity();
    g.cell_to_world.axis[0].x = side[0];
    g.cell_to_world.axis[1].y = side[1];
    g.cell_to_world.axis[2].z = side[2];
    const size_t cells = vvi_light_cells(g.n), slice = cells / 60;
    float *out = malloc(cells * sizeof *out);
    g.extinction = malloc(cells * sizeof *g.extinction);
    for (size_t k = 0; k < sizeof kappas / sizeof *kappas; k++) {
        for (size_t i = 0; i < cells; i++)
            g.extinction[i] = i < 30 * slice ? (float)kappas[k] : 0;
        assert_int_equal(vvi_light_ambient(out, &g, radius, NULL), VV_OK);
        for (size_t z = 24; z < 50; z++) { /* in the middle, where walls that let all light in are far */
            const double h = ((double)z - 29.5) * side[2];
            const double got = (double)out[z * slice + 16 * 48 + 24], want = above_fog(h, kappas[k], radius);
            if (fabs(h) > 1.4 * side[2] && fabs(got - want) > 0.04) /* cells at the border are smoothed with it */
                fail_msg("extinction %g, %g above: %.4f, expected %.4f", kappas[k], h, got, want);
        }
    }
    free(out);
    free(g.extinction);
}

static double one(vv_vec3 p)
{
    (void)p;
    return 1;
}
static const test_form constant = {"constant", one, NULL};

/* A cube of fog, lit from one side: unshaded it takes the shares as a factor, each by its brightness. */
static void unshaded_fog_is_dimmed_by_the_share_that_arrives(void **state)
{
    (void)state;
    test_ray_scene s;
    vv_field *ball_of_fog = fog_ball(&s, vvi_vec(1, 0, 0));
    vv_field *field = test_field_cube(&constant, 2 * HALF + 1, -HALF, HALF, NULL);
    s.actor.field = field;
    s.actor.shading_model = VV_SHADING_NONE;
    assert_int_equal(vv_field_statistics(&s.statistics, field, 0, NULL), VV_OK);
    vv_image *plain = test_ray_picture(&s, NULL, 1);
    set(&s, "shadows", "true");
    set(&s, "lamp_size", "0");
    for (const char *const *cpu = test_ray_cpus(); *cpu; cpu++) {
        vv_image *image = test_ray_picture(&s, *cpu, 1);
        const double lamp = 0.2126 * 0.8 + 0.7152 * 0.8 + 0.0722 * 0.7, ambient = (double)0.9f;
        for (int32_t x = 8; x < 56; x++) {
            const double at = ((x + 0.5) / 64 - 0.5) * 2.2 * HALF, share = exp(-KAPPA * (at + HALF));
            const float *a = image->rgba + 4 * (32 * 64 + x), *b = plain->rgba + 4 * (32 * 64 + x);
            for (int c = 0; c < 3; c++)
                assert_float_equal((double)(a[c] / b[c]), (ambient + lamp * share) / (ambient + lamp), 0.015);
            assert_float_equal(a[3], b[3], 1e-6);
        }
        vv_image_release(image);
    }
    vv_image_release(plain);
    test_ray_scene_finish(&s);
    vv_field_release(field);
    vv_field_release(ball_of_fog);
}

/* Root of the light that is left of what is not shaded, in one cell. */
static double root_of_cell(const vvi_light_volume *v, const int32_t at[3])
{
    const size_t cell = (size_t)((at[2] * v->n[1] + at[1]) * v->n[0] + at[0]);
    double sum = (double)v->scatter_rest;
    for (int i = 0; i < v->n_shares; i++) {
        const double root = (v->cells[cell * (size_t)v->n_words + (size_t)i / 4] >> (i % 4 * 8) & 255) / 255.0;
        sum += (double)v->scatter[i] * (i == 0 ? (double)v->ambient : 1) * root * root;
    }
    return sqrt(sum);
}

/* Any number of shares, anywhere: the roots of cells' sums, interpolated linearly, as far as bytes hold them. */
static void unshaded_light_is_the_sum_of_the_shares_between_cells(void **state)
{
    (void)state;
    enum { X = 5, Y = 3, Z = 4, CELLS = X * Y * Z };
    uint32_t cells[2 * CELLS], scattered[CELLS];
    for (size_t i = 0; i < 2 * CELLS; i++)
        cells[i] = (uint32_t)(test_random_unit(3, i) * 4294967295.0);
    for (int n = 1; n <= VVI_LIGHT_SHARES; n++) {
        vvi_light_volume v = {.cells = cells, .scattered = scattered, .n = {X, Y, Z}, .n_words = (n + 3) / 4};
        v.n_shares = n;
        v.ambient = 2;
        v.scatter_rest = 0.1f;
        for (int i = 0; i < n; i++)
            v.scatter[i] = 0.9f / (float)(n + 1);
        for (int a = 0; a < 3; a++)
            v.world_to_cell[a][a] = 1;
        vvi_light_pack_scattered(scattered, &v);
        for (uint64_t i = 0; i < 300; i++) {
            double at[3], root = 0;
            int32_t first[3];
            for (int a = 0; a < 3; a++) {
                at[a] = test_random_unit(5, 3 * i + (uint64_t)a) * (v.n[a] - 1.002);
                first[a] = (int32_t)at[a];
            }
            for (int b = 0; b < 8; b++) {
                double weight = 1;
                int32_t corner[3];
                for (int a = 0; a < 3; a++) {
                    corner[a] = first[a] + (b >> a & 1);
                    weight *= 1 - fabs(at[a] - corner[a]);
                }
                root += weight * root_of_cell(&v, corner);
            }
            const double got = vvi_light_scattered(&v, vvi_vec(at[0], at[1], at[2]), vvi_vec(0, 0, 0));
            assert_float_equal(sqrt(got), root, 0.5001 / 255);
        }
    }
}

static bool same(const vv_image *a, const vv_image *b)
{
    return memcmp(a->rgba, b->rgba, 4 * sizeof(float) * (size_t)a->width * (size_t)a->height) == 0;
}

static void threads_do_not_change_it_and_what_is_off_changes_nothing(void **state)
{
    (void)state;
    test_ray_scene s;
    vv_field *field = fog_ball(&s, vvi_vec(1, 2, -1));
    vv_image *plain = test_ray_picture(&s, NULL, 1);
    set(&s, "lighting", "\"cinematic\"");
    vv_image *lit = test_ray_picture(&s, NULL, 1);
    assert_false(same(plain, lit));
    for (int threads = 2; threads <= 3; threads++) {
        vv_image *again = test_ray_picture(&s, NULL, threads);
        assert_true(same(lit, again));
        vv_image_release(again);
    }
    set(&s, "shadows", "false");
    set(&s, "ambient_occlusion", "false");
    vv_image *off = test_ray_picture(&s, NULL, 1);
    assert_true(same(plain, off));
    vv_image_release(plain);
    vv_image_release(lit);
    vv_image_release(off);
    test_ray_scene_finish(&s);
    vv_field_release(field);
}

static uint64_t misses(vv_job *job)
{
    vvi_cache_counts c;
    vvi_cache_get_counts(&c, vv_job_runtime(job));
    return c.misses;
}

/* Nothing is made again that did not change: the eye alone, nothing; a lamp, its light; opacity, all. */
static void what_did_not_change_is_kept(void **state)
{
    (void)state;
    vv_job *job = test_job(2, 0);
    test_ray_scene s;
    vv_field *field = fog_ball(&s, vvi_vec(1, 2, -1));
    set(&s, "lighting", "\"cinematic\"");
    vvi_raycast_finish(prepare(&s, job));
    uint64_t before = misses(job);
    test_ray_scene_look(&s, (vv_vec3){100, 20, 30}, (vv_vec3){0, 0, 0}, 0.5, 0);
    vvi_raycast_finish(prepare(&s, job));
    assert_int_equal(misses(job) - before, 0);
    s.lamps[0].direction = vvi_vec(0, 0, 1);
    vvi_raycast_finish(prepare(&s, job));
    assert_int_equal(misses(job) - before, 1);
    s.actor.shading_model = VV_SHADING_NONE; /* needs the sum of the shares, but no other shares */
    before = misses(job);
    vvi_raycast_finish(prepare(&s, job));
    assert_int_equal(misses(job) - before, 1);
    s.lamps[0].color[1] = 0.1f;
    vvi_raycast_finish(prepare(&s, job));
    assert_int_equal(misses(job) - before, 2);
    vvi_raycast_finish(prepare(&s, job));
    assert_int_equal(misses(job) - before, 2);
    s.actor.shading_model = VV_SHADING_BLINN;
    before = misses(job);
    s.opacity[3] = 0.5;
    vvi_raycast_finish(prepare(&s, job));
    assert_in_range(misses(job) - before, 3, 5); /* light, ambient, extinction; and what can be jumped */
    test_ray_scene_finish(&s);
    vv_field_release(field);
    vv_job_release(job);
}

static void more_lamps_than_cast_shadows_are_refused(void **state)
{
    (void)state;
    test_ray_scene s;
    vv_lamp lamps[VVI_LIGHT_LAMPS + 1];
    void *prepared = NULL;
    vv_field *field = fog_ball(&s, vvi_vec(0, 0, -1));
    for (int i = 0; i <= VVI_LIGHT_LAMPS; i++)
        lamps[i] = s.lamps[0];
    s.scene.lamps = lamps;
    s.scene.n_lamps = VVI_LIGHT_LAMPS + 1;
    set(&s, "ambient_occlusion", "true");
    vvi_raycast_finish(prepare(&s, NULL));
    set(&s, "shadows", "true");
    assert_int_equal(vvi_raycast_prepare(&prepared, &s.scene, NULL), VV_E_UNSUPPORTED);
    assert_non_null(strstr(vv_error_last()->message, "at most 7"));
    s.scene.n_lamps = VVI_LIGHT_LAMPS;
    vvi_raycast_finish(prepare(&s, NULL));
    test_ray_scene_finish(&s);
    vv_field_release(field);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(light_in_a_ball_of_fog_follows_the_chord),
        cmocka_unit_test(a_point_lamp_in_fog_fades_with_distance),
        cmocka_unit_test(ambient_light_above_a_half_space_is_the_formula),
        cmocka_unit_test(unshaded_fog_is_dimmed_by_the_share_that_arrives),
        cmocka_unit_test(unshaded_light_is_the_sum_of_the_shares_between_cells),
        cmocka_unit_test(threads_do_not_change_it_and_what_is_off_changes_nothing),
        cmocka_unit_test(what_did_not_change_is_kept),
        cmocka_unit_test(more_lamps_than_cast_shadows_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
