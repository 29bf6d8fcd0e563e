/* The reference traversal of regular grids against closed forms. */
#include "fields.h"
#include "registry.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#define MOST 4096

static vv_segment found[MOST];

static size_t segments(const vv_field *f, vv_vec3 o, vv_vec3 d, double t0, double t1)
{
    return vvi_data_kind_regular.segments(found, MOST, f, 0, o, d, t0, t1);
}

static vv_vec3 at(vv_vec3 o, vv_vec3 d, double t)
{
    return (vv_vec3){o.x + t * d.x, o.y + t * d.y, o.z + t * d.z};
}

static vv_vec3 unit(vv_vec3 v)
{
    const double n = sqrt(v.x * v.x + v.y * v.y + v.z * v.z);
    return (vv_vec3){v.x / n, v.y / n, v.z / n};
}

static vv_field *oblique(const test_form *form, vv_type type)
{
    vv_field_info info = vv_field_info_default();
    info.type = type;
    info.grid.dims[0] = 7, info.grid.dims[1] = 11, info.grid.dims[2] = 5;
    info.grid.index_to_world.axis[0] = (vv_vec3){1.5, 0.3, 0};
    info.grid.index_to_world.axis[1] = (vv_vec3){-0.2, -0.7, 0.1}; /* mirrored and sheared */
    info.grid.index_to_world.axis[2] = (vv_vec3){0.1, 0, 2};
    info.grid.index_to_world.origin = (vv_vec3){-3, 2, 5};
    return test_field(form, &info, NULL);
}

/* Trilinear interpolation reproduces a linear function, so every segment end must have the ramp's value; segments
 * must touch, and each must lie in one cell. */
static void a_ramp_is_exact_along_random_rays_through_an_oblique_grid(void **state)
{
    (void)state;
    const uint64_t seed = test_seed();
    vv_field *f = oblique(&test_form_ramp, VV_TYPE_F64);
    const vv_bounds b = vvi_data_kind_regular.bounds(vv_field_get_info(f));
    vv_affine inverse;
    assert_true(vv_affine_invert(&inverse, vv_field_get_info(f)->grid.index_to_world));
    size_t hits = 0;
    for (uint64_t i = 0; i < 2000; i++) {
        double r[6];
        for (uint64_t c = 0; c < 6; c++)
            r[c] = test_random_unit(seed, 6 * i + c);
        const vv_vec3 in = {b.lo.x + r[0] * (b.hi.x - b.lo.x), b.lo.y + r[1] * (b.hi.y - b.lo.y),
                            b.lo.z + r[2] * (b.hi.z - b.lo.z)};
        const vv_vec3 d = unit((vv_vec3){r[3] - 0.5, r[4] - 0.5, r[5] - 0.5});
        const vv_vec3 o = at(in, d, -50);
        const size_t n = segments(f, o, d, 0, 100);
        hits += n > 0;
        for (size_t s = 0; s < n; s++) {
            assert_true(found[s].t0 < found[s].t1);
            assert_true(s == 0 || found[s].t0 == found[s - 1].t1);
            assert_true(fabs(found[s].value0 - test_form_ramp.value(at(o, d, found[s].t0))) < 1e-5);
            assert_true(fabs(found[s].value1 - test_form_ramp.value(at(o, d, found[s].t1))) < 1e-5);
            const vv_vec3 p = vv_affine_point(inverse, at(o, d, found[s].t0 + 1e-9));
            const vv_vec3 q = vv_affine_point(inverse, at(o, d, found[s].t1 - 1e-9));
            if (found[s].t1 - found[s].t0 > 1e-6)
                assert_true(floor(p.x) == floor(q.x) && floor(p.y) == floor(q.y) && floor(p.z) == floor(q.z));
        }
        if (n) { /* the ends are on the border of the domain */
            const vv_vec3 e = vv_affine_point(inverse, at(o, d, found[n - 1].t1));
            const double out = fmin(fmin(fmin(e.x, 6 - e.x), fmin(e.y, 10 - e.y)), fmin(e.z, 4 - e.z));
            assert_true(fabs(out) < 1e-9);
        }
    }
    assert_true(hits > 1000);
    vv_field_release(f);
}

static void rays_along_axes_through_samples_edges_and_faces_pass_every_cell_once(void **state)
{
    (void)state;
    vv_field *f = test_field_cube(&test_form_ramp, 5, 0, 4, NULL);
    for (int axis = 0; axis < 3; axis++)
        for (int sign = -1; sign <= 1; sign += 2)
            for (int place = 0; place < 25; place++) {
                const double u = place % 5, v = place / 5; /* 0 and 4 are the border itself */
                const double start = sign > 0 ? -3 : 7;
                const vv_vec3 o = axis == 0   ? (vv_vec3){start, u, v}
                                  : axis == 1 ? (vv_vec3){u, start, v}
                                              : (vv_vec3){u, v, start};
                const vv_vec3 d = {axis == 0 ? sign : 0.0, axis == 1 ? sign : 0.0, axis == 2 ? sign : 0.0};
                assert_int_equal(segments(f, o, d, 0, INFINITY), 4);
                for (int s = 0; s < 4; s++) {
                    assert_true(found[s].t0 == 3 + s && found[s].t1 == 4 + s);
                    assert_true(fabs(found[s].value1 - test_form_ramp.value(at(o, d, 4 + s))) < 1e-5);
                }
            }
    vv_field_release(f);
}

static void the_diagonal_through_corners_has_no_empty_segments(void **state)
{
    (void)state;
    vv_field *f = test_field_cube(&test_form_ramp, 4, 0, 3, NULL);
    const vv_vec3 d = unit((vv_vec3){1, 1, 1});
    assert_int_equal(segments(f, (vv_vec3){0, 0, 0}, d, 0, INFINITY), 3);
    for (int s = 0; s < 3; s++)
        assert_true(fabs(found[s].t1 - (s + 1) * sqrt(3)) < 1e-12);
    const vv_vec3 back = {-d.x, -d.y, -d.z};
    assert_int_equal(segments(f, (vv_vec3){3, 3, 3}, back, 0, INFINITY), 3);
    vv_field_release(f);
}

static void a_ray_is_cut_to_the_asked_interval(void **state)
{
    (void)state;
    vv_field *f = test_field_cube(&test_form_ramp, 5, 0, 4, NULL);
    const vv_vec3 o = {-1, 1.5, 1.5}, d = {1, 0, 0};
    assert_int_equal(segments(f, o, d, 1.25, 2.5), 2);
    assert_true(found[0].t0 == 1.25 && found[0].t1 == 2 && found[1].t1 == 2.5);
    assert_int_equal(segments(f, o, d, 7, 9), 0);
    assert_int_equal(segments(f, o, d, 3, 3), 0);
    assert_int_equal(segments(f, (vv_vec3){-1, 4.01, 1}, d, 0, INFINITY), 0);
    vv_segment few[2];
    assert_int_equal(vvi_data_kind_regular.segments(few, 2, f, 0, o, d, 0, INFINITY), 4);
    assert_int_equal(vvi_data_kind_regular.segments(NULL, 0, f, 0, o, d, 0, INFINITY), 4);
    vv_field_release(f);
}

static void a_missing_sample_does_not_reach_beyond_its_cells(void **state)
{
    (void)state;
    static const float v[4] = {1, 2, 3, NAN};
    vv_field_info info = vv_field_info_default();
    info.type = VV_TYPE_F32;
    info.grid.dims[0] = 4;
    vv_field *f;
    assert_int_equal(vv_field_new(&f, &info, v, 0, NULL, NULL, NULL), VV_OK);
    assert_int_equal(segments(f, (vv_vec3){-1, 0, 0}, (vv_vec3){1, 0, 0}, 0, INFINITY), 3);
    assert_true(found[1].value1 == 3 && found[2].value0 == 3 && isnan(found[2].value1));
    assert_true(found[0].value0 == 1);
    vv_field_release(f);
}

static void labels_fill_boxes_around_their_samples(void **state)
{
    (void)state;
    static const uint8_t v[3] = {4, 9, 2};
    vv_field_info info = vv_field_info_default();
    info.grid.dims[0] = 3;
    info.meaning = VV_MEANING_LABEL;
    vv_field *f;
    assert_int_equal(vv_field_new(&f, &info, v, 0, NULL, NULL, NULL), VV_OK);
    const vv_bounds b = vvi_data_kind_regular.bounds(&info);
    assert_true(b.lo.x == -0.5 && b.hi.x == 2.5 && b.lo.z == -0.5 && b.hi.z == 0.5);
    assert_int_equal(segments(f, (vv_vec3){5, 0.2, -0.3}, (vv_vec3){-1, 0, 0}, 0, INFINITY), 3);
    assert_true(found[0].t0 == 2.5 && found[0].t1 == 3.5 && found[2].t1 == 5.5);
    assert_true(found[0].value0 == 2 && found[0].value1 == 2 && found[1].value0 == 9 && found[2].value1 == 4);
    assert_int_equal(segments(f, (vv_vec3){1, 0, -4}, (vv_vec3){0, 0, 1}, 0, INFINITY), 1);
    vv_field_release(f);
}

static void values_are_scaled(void **state)
{
    (void)state;
    static const uint8_t v[2] = {10, 20};
    vv_field_info info = vv_field_info_default();
    info.grid.dims[0] = 2;
    info.value_scale = 2;
    info.value_offset = -5;
    vv_field *f;
    assert_int_equal(vv_field_new(&f, &info, v, 0, NULL, NULL, NULL), VV_OK);
    assert_int_equal(segments(f, (vv_vec3){0.5, 0, 0}, (vv_vec3){1, 0, 0}, 0, INFINITY), 1);
    assert_true(found[0].value0 == 25 && found[0].value1 == 35);
    vv_field_release(f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_ramp_is_exact_along_random_rays_through_an_oblique_grid),
        cmocka_unit_test(rays_along_axes_through_samples_edges_and_faces_pass_every_cell_once),
        cmocka_unit_test(the_diagonal_through_corners_has_no_empty_segments),
        cmocka_unit_test(a_ray_is_cut_to_the_asked_interval),
        cmocka_unit_test(a_missing_sample_does_not_reach_beyond_its_cells),
        cmocka_unit_test(labels_fill_boxes_around_their_samples),
        cmocka_unit_test(values_are_scaled),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
