/* What a camera that nobody placed looks at: what is seen, and not the box that it lies in. */
#include "core/vec.h"
#include "fields.h"
#include "jobs.h"
#include "scene/visible_volume.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>
#include <volvis/render.h>

enum { N = 96 };

typedef struct ball {
    double x, y, z, r;
} ball;

/* 200 inside the balls, 0 outside. */
static vv_field *balls(const ball *of, size_t n, vv_job *job)
{
    vv_field_info info = vv_field_info_default();
    void *data;
    vv_field *field;
    for (int a = 0; a < 3; a++)
        info.grid.dims[a] = N;
    assert_int_equal(vv_field_new_empty(&field, &data, &info, job), VV_OK);
    uint8_t *out = data;
    memset(out, 0, (size_t)N * N * N);
    for (size_t b = 0; b < n; b++)
        for (int i = 0; i < N * N * N; i++) {
            const double x = i % N - of[b].x, y = i / N % N - of[b].y, z = i / N / N - of[b].z;
            if (x * x + y * y + z * z <= of[b].r * of[b].r)
                out[i] = 200;
        }
    return field;
}

/* The box around the points. */
static void box_of(double lo[3], double hi[3], const ball *of, size_t n, const char *json)
{
    vv_job *job = test_job(1, 0);
    vv_field *field = balls(of, n, job);
    vv_world *world = NULL;
    vv_scene *scene = NULL;
    vv_vec3 points[VVI_VISIBLE_POINTS];
    const vv_property_context context = {0};
    assert_int_equal(vv_world_for_field(&world, "v", field, job), VV_OK);
    vv_object *object = &world->base;
    if (json)
        assert_int_equal(vv_path_set(&object, "volumes.v.segmentation.transfer.opacity", json, &context), VV_OK);
    assert_int_equal(vv_scene_resolve(&scene, (vv_world *)object, NULL, job), VV_OK);
    assert_int_equal(vvi_visible_points(points, scene, &scene->actors[0], job), VV_OK);
    for (int a = 0; a < 3; a++) {
        lo[a] = INFINITY;
        hi[a] = -INFINITY;
    }
    for (int i = 0; i < VVI_VISIBLE_POINTS; i++) {
        const double p[3] = {points[i].x, points[i].y, points[i].z};
        for (int a = 0; a < 3; a++) {
            lo[a] = fmin(lo[a], p[a]);
            hi[a] = fmax(hi[a], p[a]);
        }
    }
    vv_scene_release(scene);
    vv_object_release(object);
    vv_field_release(field);
    vv_job_release(job);
}

/* Blocks have 4 voxels, and hold the samples on their borders: within 5 beyond what is seen. */
static void assert_around(const double lo[3], const double hi[3], double from, double to)
{
    for (int a = 0; a < 3; a++) {
        assert_true(lo[a] <= from && lo[a] > from - 9);
        assert_true(hi[a] >= to && hi[a] < to + 9);
    }
}

static void it_is_what_is_seen_and_not_the_box(void **state)
{
    (void)state;
    double lo[3], hi[3];
    box_of(lo, hi, &(ball){30, 30, 30, 10}, 1, NULL);
    assert_around(lo, hi, 20, 40);
}

static void a_speck_far_away_is_left_out_and_a_second_piece_is_not(void **state)
{
    (void)state;
    double lo[3], hi[3];
    box_of(lo, hi, (ball[]){{30, 30, 30, 10}, {85, 85, 85, 1}}, 2, NULL);
    assert_around(lo, hi, 20, 40);
    box_of(lo, hi, (ball[]){{30, 30, 30, 10}, {80, 80, 80, 8}}, 2, NULL);
    assert_around(lo, hi, 20, 88);
}

static void all_is_looked_at_where_all_or_nothing_is_seen(void **state)
{
    (void)state;
    double lo[3], hi[3];
    for (int i = 0; i < 2; i++) {
        box_of(lo, hi, &(ball){30, 30, 30, 10}, 1, i ? "[[0, 0.1]]" : "[[0, 0]]");
        assert_around(lo, hi, 0, N - 1);
    }
}

static void a_camera_without_a_place_has_it_in_the_middle(void **state)
{
    (void)state;
    vv_job *job = test_job(1, 0);
    vv_field *field = balls(&(ball){30, 40, 50, 10}, 1, job);
    vv_world *world = NULL;
    vv_scene *scene = NULL;
    assert_int_equal(vv_world_for_field(&world, "v", field, job), VV_OK);
    assert_int_equal(vv_scene_resolve(&scene, world, NULL, job), VV_OK);
    const vv_vec3 to = vvi_sub(vvi_vec(30, 40, 50), scene->lens.eye);
    const double off = vvi_length(vvi_cross(to, scene->lens.forward));
    assert_true(off < 4);
    assert_true(vvi_length(to) * scene->lens.half_height < 19); /* blocks lie around it */
    vv_scene_release(scene);
    vv_object_release(&world->base);
    vv_field_release(field);
    vv_job_release(job);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(it_is_what_is_seen_and_not_the_box),
        cmocka_unit_test(a_speck_far_away_is_left_out_and_a_second_piece_is_not),
        cmocka_unit_test(all_is_looked_at_where_all_or_nothing_is_seen),
        cmocka_unit_test(a_camera_without_a_place_has_it_in_the_middle),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
