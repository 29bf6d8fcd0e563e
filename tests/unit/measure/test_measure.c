/* Areas and volumes of shapes whose area and volume are known, by both methods. */
#include "fail_alloc.h"
#include "fields.h"
#include "grid/field.h"
#include "jobs.h"
#include "measure/configurations.h"
#include "meshes.h"
#include "surface/marching.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <volvis/measure.h>

#include <cmocka.h>

#define PI 3.14159265358979323846

static vv_measure_options chosen(vv_measure_method method, double lo)
{
    vv_measure_options o;
    vv_measure_options_init(&o, sizeof o);
    o.method = method;
    o.lo = lo;
    return o;
}

static vv_measured measured(const vv_field *field, const vv_measure_options *o)
{
    vv_measured m = {.size = sizeof m};
    assert_int_equal(vv_measure(&m, field, o, NULL), VV_OK);
    return m;
}

static void assert_within(double found, double expected, double tolerance)
{
    if (!(fabs(found - expected) <= tolerance))
        fail_msg("%.9g is not within %g of %.9g", found, tolerance, expected);
}

static vv_field *shape(double (*value)(vv_vec3), const int64_t n[3], vv_affine place, vv_type type)
{
    const test_form form = {.name = "shape", .value = value};
    vv_field_info info = vv_field_info_default();
    memcpy(info.grid.dims, n, sizeof info.grid.dims);
    info.grid.index_to_world = place;
    info.type = type;
    vv_field *f = test_field(&form, &info, NULL);
    assert_non_null(f);
    return f;
}

/* 2 half + 1 samples along each axis, the middle one at 0. */
static vv_field *cube_of(double (*value)(vv_vec3), int64_t half, vv_type type)
{
    const int64_t n[3] = {2 * half + 1, 2 * half + 1, 2 * half + 1};
    vv_affine place = vv_affine_identity();
    place.origin = (vv_vec3){(double)-half, (double)-half, (double)-half};
    return shape(value, n, place, type);
}

static vv_vec3 center = {.13, .27, .41};
static double radius;

static double sphere(vv_vec3 p)
{
    return radius - hypot(hypot(p.x - center.x, p.y - center.y), p.z - center.z);
}

static double ball(vv_vec3 p)
{
    return sphere(p) >= 0;
}

static double torus(vv_vec3 p)
{
    return 5 - hypot(hypot(p.x - center.x, p.y - center.y) - 12, p.z - center.z);
}

static double sphere_area(double r)
{
    return 4 * PI * r * r;
}

static double sphere_volume(double r)
{
    return 4 * PI / 3 * r * r * r;
}

/* Marching Cubes ----------------------------------------------------------------------------------------------------
 */

/* Percent, from an independent program. */
static void spheres_have_the_errors_of_marching_cubes(void **state)
{
    (void)state;
    static const double table[][3] = {
        {3, -3.505, -6.577}, {5, -1.257, -2.383}, {10, -.314, -.596}, {20, -.0783, -.1491}, {30, -.0348, -.0663}};
    for (int i = 0; i < 5; i++) {
        radius = table[i][0];
        vv_field *f = cube_of(sphere, (int64_t)radius + 3, VV_TYPE_F32);
        const vv_measure_options o = chosen(VV_MEASURE_CUBES, 0);
        const vv_measured m = measured(f, &o);
        const double area = sphere_area(radius), volume = sphere_volume(radius);
        assert_within(100 * (m.area / area - 1), table[i][1], 0.05 * fabs(table[i][1]));
        assert_within(100 * (m.volume / volume - 1), table[i][2], 0.05 * fabs(table[i][2]));
        assert_within(m.centroid.x, center.x, 1e-3);
        assert_within(m.centroid.y, center.y, 1e-3);
        assert_within(m.centroid.z, center.z, 1e-3);
        assert_within(m.bounds.hi.x - m.bounds.lo.x, 2 * radius, 0.2);
        assert_true(m.cut_area == 0 && m.unknown == 0 && !m.steps);
        /* the error that is told is three times the error that is there, within a quarter */
        assert_within(m.area_error / 3, area - m.area, 0.1 * m.area_error);
        assert_within(m.volume_error / 3, volume - m.volume, 0.1 * m.volume_error);
        vv_field_release(f);
    }
}

static void a_torus_has_the_errors_of_marching_cubes(void **state)
{
    (void)state;
    vv_field *f = cube_of(torus, 20, VV_TYPE_F64);
    const vv_measure_options o = chosen(VV_MEASURE_CUBES, 0);
    const vv_measured m = measured(f, &o);
    assert_within(100 * (m.area / (4 * PI * PI * 12 * 5) - 1), -.235, .012);
    assert_within(100 * (m.volume / (2 * PI * PI * 12 * 25) - 1), -.826, .04);
    vv_field_release(f);
}

/* It does not converge; how much it is depends a little on how polygons become triangles, ours being the smallest. */
static void steps_make_the_area_8_percent_too_large(void **state)
{
    (void)state;
    static const double radii[] = {5, 10, 20, 30};
    for (int i = 0; i < 4; i++) {
        radius = radii[i];
        vv_field *f = cube_of(ball, (int64_t)radius + 3, VV_TYPE_U8);
        const vv_measure_options o = chosen(VV_MEASURE_CUBES, 0.5);
        const vv_measured m = measured(f, &o);
        assert_within(100 * (m.area / sphere_area(radius) - 1), 8, .4);
        assert_within(m.volume, sphere_volume(radius), 3 * m.volume_error);
        assert_true(m.steps && m.area_error > 0.07 * m.area);
        vv_field_release(f);
    }
}

/* Noise has every case, every decision and pieces of every size. */
static void noise_has_the_area_and_volume_of_its_mesh(void **state)
{
    (void)state;
    static const vv_type types[] = {VV_TYPE_U8, VV_TYPE_I16, VV_TYPE_F32, VV_TYPE_F64};
    for (int t = 0; t < 4; t++) {
        vv_field_info info = vv_field_info_default();
        info.grid.dims[0] = 67, info.grid.dims[1] = 13, info.grid.dims[2] = 19;
        info.grid.index_to_world = (vv_affine){{{0.5, 0, 0}, {0.1, 0.6, 0}, {-0.2, 0.3, 1.5}}, {-23, -31, -24}};
        info.type = types[t];
        vv_field *f;
        void *data;
        assert_int_equal(vv_field_new_empty(&f, &data, &info, NULL), VV_OK);
        for (int64_t i = 0; i < 67 * 13 * 19; i++) {
            const int64_t x = i % 67, y = i / 67 % 13, z = i / 67 / 13;
            const bool border = x == 0 || y == 0 || z == 0 || x == 66 || y == 12 || z == 18;
            const double v = border ? 0 : (double)(test_random(5, (uint64_t)i) % 90);
            vvi_samples_from_f64((char *)data + (size_t)i * vv_type_bytes(info.type), &v, info.type, 1);
        }
        vv_mesh *mesh;
        const vvi_marching_options marching = {.value = 50};
        assert_int_equal(vvi_marching_cubes(&mesh, f, &marching, NULL), VV_OK);
        const vv_measure_options o = chosen(VV_MEASURE_CUBES, 50);
        const vv_measured m = measured(f, &o);
        assert_within(m.area, test_mesh_area(mesh), 1e-5 * m.area);
        assert_within(m.volume, test_mesh_volume(mesh), 1e-5 * m.area);
        vv_mesh_release(mesh);
        vv_field_release(f);
    }
}

static void spacing_and_shear_are_taken_into_account(void **state)
{
    (void)state;
    radius = 20;
    const int64_t n[3] = {96, 81, 33};
    const vv_affine place = {{{0.5, 0, 0}, {0.1, 0.6, 0}, {-0.2, 0.3, 1.5}}, {-23, -31, -24}};
    vv_field *f = shape(sphere, n, place, VV_TYPE_F32);
    const double area = sphere_area(20), volume = sphere_volume(20);
    vv_measure_options o = chosen(VV_MEASURE_CUBES, 0);
    vv_measured m = measured(f, &o);
    assert_within(m.area / area, 1, 3e-3);
    assert_within(m.volume / volume, 1, 4e-3);
    assert_within(m.centroid.z, center.z, 1e-3);
    o.method = VV_MEASURE_COUNT;
    m = measured(f, &o);
    assert_true(isnan(m.lindblad) && m.area == m.crofton);
    assert_within(m.area / area, 1, 0.01);
    assert_within(m.volume / volume, 1, 2e-3);
    assert_within(m.centroid.z, center.z, 0.02);
    vv_field_release(f);
}

/* Parts -------------------------------------------------------------------------------------------------------------
 */

static void a_plane_through_the_middle_leaves_half(void **state)
{
    (void)state;
    radius = 10;
    vv_field *f = cube_of(sphere, 13, VV_TYPE_F32);
    vv_measure_options o = chosen(VV_MEASURE_CUBES, 0);
    const vv_measured all = measured(f, &o);
    static const vv_vec3 normals[] = {{0, 0, 1}, {1, 0, 0}, {1, 2, 3}, {-1, 1, 0}};
    for (int i = 0; i < 4; i++) {
        vv_plane plane[2] = {{normals[i], 0}};
        const vv_vec3 n = normals[i];
        const double length = hypot(hypot(n.x, n.y), n.z);
        plane[0].offset = (n.x * center.x + n.y * center.y + n.z * center.z) / length;
        plane[1] = (vv_plane){{-n.x, -n.y, -n.z}, -plane[0].offset};
        o.planes = plane;
        o.n_planes = 1;
        const vv_measured half = measured(f, &o);
        o.planes = plane + 1;
        const vv_measured other = measured(f, &o);
        assert_within(half.area + other.area, all.area, 1e-9 * all.area);
        assert_within(half.volume + other.volume, all.volume, 1e-9 * all.volume);
        assert_within(half.volume, all.volume / 2, 1e-3 * all.volume);
        assert_within(half.cut_area, PI * 100, 2);
        assert_within(half.cut_area, other.cut_area, 1e-9 * half.cut_area);
        o.method = VV_MEASURE_COUNT;
        const vv_measured counted = measured(f, &o);
        assert_within(counted.volume, all.volume / 2, PI * 100 / 2); /* half a voxel more or less */
        assert_within(counted.area, all.area / 2, 0.03 * all.area);
        o.method = VV_MEASURE_CUBES;
    }
    vv_field_release(f);
}

/* Three planes that meet in the middle of a ball, none along an axis, and a box. */
static void planes_that_meet_cut_out_what_they_should(void **state)
{
    (void)state;
    radius = 10;
    center = (vv_vec3){0, 0, 0};
    vv_field *f = cube_of(sphere, 13, VV_TYPE_F64);
    vv_measure_options o = chosen(VV_MEASURE_CUBES, 0);
    const vv_measured all = measured(f, &o);
    const vv_plane corner[3] = {{{2, 1, 2}, 0}, {{-2, 2, 1}, 0}, {{1, 2, -2}, 0}};
    double volume = 0, area = 0;
    for (int s = 0; s < 8; s++) {
        vv_plane plane[3];
        for (int i = 0; i < 3; i++) {
            const double sign = s >> i & 1 ? 1 : -1;
            const vv_vec3 n = corner[i].normal;
            plane[i] = (vv_plane){{sign * n.x, sign * n.y, sign * n.z}, 0};
        }
        o.planes = plane;
        o.n_planes = 3;
        const vv_measured m = measured(f, &o);
        assert_within(m.volume, all.volume / 8, 2e-3 * all.volume);
        assert_within(m.cut_area, 3 * PI * 100 / 4, 2);
        volume += m.volume;
        area += m.area;
    }
    assert_within(volume, all.volume, 1e-9 * volume);
    assert_within(area, all.area, 1e-9 * area);
    o.n_planes = 0;
    o.box = (vv_box){{10, 11, 12}, {5, 6, 4}}; /* deep inside */
    const vv_measured box = measured(f, &o);
    assert_within(box.volume, 4 * 5 * 3, 1e-9);
    assert_within(box.cut_area, 2 * (4 * 5 + 5 * 3 + 3 * 4), 1e-9);
    assert_true(box.area == 0);
    assert_within(box.bounds.hi.x - box.bounds.lo.x, 4, 1e-9);
    o.method = VV_MEASURE_COUNT;
    const vv_measured counted = measured(f, &o);
    assert_within(counted.volume, 5 * 6 * 4, 1e-9);
    assert_true(counted.area == 0 && counted.voxels == 120);
    o.closed = true;
    assert_within(measured(f, &o).raw_faces, 2 * (5 * 6 + 6 * 4 + 4 * 5), 1e-9);
    center = (vv_vec3){.13, .27, .41};
    vv_field_release(f);
}

static double rod(vv_vec3 p)
{
    return 6.3 - hypot(p.x - center.x, p.y - center.y);
}

static void what_runs_out_of_the_volume_is_not_closed_there(void **state)
{
    (void)state;
    const int64_t n[3] = {21, 21, 31};
    vv_affine place = vv_affine_identity();
    place.origin = (vv_vec3){-10, -10, 0};
    vv_field *f = shape(rod, n, place, VV_TYPE_F32);
    vv_measure_options o = chosen(VV_MEASURE_CUBES, 0);
    const double around = 2 * PI * 6.3, disc = PI * 6.3 * 6.3;
    const vv_measured m = measured(f, &o);
    assert_within(m.area / (30 * around), 1, 0.01);
    assert_within(m.cut_area / (2 * disc), 1, 0.02);
    assert_within(m.volume / (30 * disc), 1, 0.02);
    o.method = VV_MEASURE_COUNT;
    const vv_measured counted = measured(f, &o);
    assert_within(counted.area / (31 * around), 1, 0.03);
    assert_within(counted.volume / (31 * disc), 1, 0.02);
    o.closed = true;
    assert_within(measured(f, &o).raw_faces - counted.raw_faces, 2 * (double)counted.voxels / 31, 1e-6);
    vv_field_release(f);
}

static double two_spheres(vv_vec3 p)
{
    const double a = hypot(hypot(p.x - 8, p.y), p.z), b = hypot(hypot(p.x + 8, p.y), p.z);
    return 6 - fmin(a, b);
}

static double right_sphere(vv_vec3 p)
{
    return 6 - hypot(hypot(p.x - 8, p.y), p.z);
}

static void the_piece_around_a_seed_is_measured_as_if_it_were_alone(void **state)
{
    (void)state;
    vv_field *both = cube_of(two_spheres, 17, VV_TYPE_F32), *alone = cube_of(right_sphere, 17, VV_TYPE_F32);
    for (int method = VV_MEASURE_CUBES; method <= VV_MEASURE_COUNT; method++) {
        vv_measure_options o = chosen((vv_measure_method)method, 0);
        const vv_measured want = measured(alone, &o);
        o.seeded = true;
        o.seed[0] = 17 + 8 + 7, o.seed[1] = 17, o.seed[2] = 17; /* beside it, within two samples */
        const vv_measured found = measured(both, &o);
        assert_true(found.area == want.area && found.volume == want.volume && found.voxels == want.voxels);
        assert_memory_equal(&found.centroid, &want.centroid, sizeof found.centroid);
        assert_memory_equal(&found.bounds, &want.bounds, sizeof found.bounds);
        o.seed[0] = 17; /* between the two */
        vv_measured m = {.size = sizeof m};
        o.seed[1] = 0;
        assert_int_equal(vv_measure(&m, both, &o, NULL), VV_E_ARGUMENT);
    }
    vv_field_release(both);
    vv_field_release(alone);
}

/* A maze: every second row, joined at alternating ends, so that the way through it is long. */
static void a_long_way_is_followed_to_its_end(void **state)
{
    (void)state;
    const int64_t n[3] = {131, 41, 5};
    vv_field_info info = vv_field_info_default();
    memcpy(info.grid.dims, n, sizeof n);
    vv_field *f;
    void *memory;
    assert_int_equal(vv_field_new_empty(&f, &memory, &info, NULL), VV_OK);
    uint8_t *v = memory;
    memset(v, 0, (size_t)(n[0] * n[1] * n[2]));
    uint64_t expected = 0;
    for (int64_t k = 0; k < n[2]; k += 2)
        for (int64_t j = 0; j < n[1]; j++)
            for (int64_t i = 0; i < n[0]; i++) {
                const bool in = j % 2 == 0 || i == (j % 4 == 1 ? n[0] - 1 : 0);
                v[(k * n[1] + j) * n[0] + i] = in;
                expected += in && k == 2;
            }
    vv_measure_options o = chosen(VV_MEASURE_COUNT, 1);
    o.seeded = true;
    o.seed[0] = 5, o.seed[1] = 40, o.seed[2] = 2;
    const vv_measured m = measured(f, &o);
    assert_int_equal(m.voxels, expected);
    vv_field_release(f);
}

/* Counting ----------------------------------------------------------------------------------------------------------
 */

static double brick(vv_vec3 p)
{
    return p.x > 1.2 && p.x < 6.2 && p.y > 2.5 && p.y < 14.5 && p.z > 3 && p.z < 31;
}

static void a_box_of_voxels_is_counted_exactly(void **state)
{
    (void)state;
    const int64_t n[3] = {20, 20, 20};
    vv_affine place = vv_affine_identity();
    place.axis[0].x = 0.5;
    place.axis[2].z = 2;
    place.origin = (vv_vec3){0.25, 0, 0};
    vv_field *f = shape(brick, n, place, VV_TYPE_U16);
    vv_measure_options o = chosen(VV_MEASURE_COUNT, 1);
    const vv_measured m = measured(f, &o);
    assert_int_equal(m.voxels, 10 * 12 * 14);
    assert_within(m.volume, 1680, 1e-9);
    assert_within(m.raw_faces, 2 * (5 * 12 + 12 * 28 + 28 * 5), 1e-9);
    assert_int_equal(m.euler, 1);
    assert_within(m.bounds.hi.x - m.bounds.lo.x, 5, 1e-9);
    assert_within(m.bounds.hi.y - m.bounds.lo.y, 12, 1e-9);
    assert_within(m.bounds.hi.z - m.bounds.lo.z, 28, 1e-9);
    vv_field_release(f);
}

/* Percent: mean and spread over centres, from an independent program. */
static void spheres_have_the_errors_of_counting(void **state)
{
    (void)state;
    static const struct {
        double r, raw, lindblad, lindblad_sd, crofton, crofton_sd, volume, volume_sd;
        int n;
    } table[] = {{3, 52.1, -.46, 1.53, -2.43, 1.50, -.44, 2.24, 40},
                 {5, 51.5, .02, .44, -.63, .44, .01, 1.1, 40},
                 {10, 49.9, -.15, .27, -.30, .25, -.17, .28, 24},
                 {20, 50.0, .02, .09, -.03, .09, 0, .07, 8},
                 {40, 50.0, .015, .03, .005, .03, .013, .015, 2}};
    for (int i = 0; i < 5; i++) {
        double raw = 0, lindblad = 0, crofton = 0, volume = 0;
        const double n = table[i].n, area = sphere_area(table[i].r);
        radius = table[i].r;
        for (int c = 0; c < table[i].n; c++) {
            const uint64_t at = 3 * (uint64_t)(50 * i + c);
            center = (vv_vec3){test_random_unit(9, at), test_random_unit(9, at + 1), test_random_unit(9, at + 2)};
            vv_field *f = cube_of(sphere, (int64_t)radius + 3, VV_TYPE_F32);
            const vv_measure_options o = chosen(VV_MEASURE_COUNT, 0);
            const vv_measured m = measured(f, &o);
            assert_int_equal(m.euler, 1);
            raw += 100 * (m.raw_faces / area - 1) / n;
            lindblad += 100 * (m.lindblad / area - 1) / n;
            crofton += 100 * (m.crofton / area - 1) / n;
            volume += 100 * (m.volume / sphere_volume(radius) - 1) / n;
            assert_true(fabs(m.volume - sphere_volume(radius)) < 5 * m.volume_error);
            assert_true(fabs(m.area - area) < 3 * m.area_error);
            vv_field_release(f);
        }
        const double luck = 4 / sqrt(n); /* of means: four times their spread */
        printf("R %g: raw %.2f, Lindblad %.3f, Crofton %.3f, volume %.3f %%\n", radius, raw, lindblad, crofton, volume);
        assert_within(raw, table[i].raw, 15 / table[i].r);
        assert_within(lindblad, table[i].lindblad, luck * table[i].lindblad_sd + .1);
        assert_within(crofton, table[i].crofton, luck * table[i].crofton_sd + .1);
        assert_within(volume, table[i].volume, luck * table[i].volume_sd + .05);
    }
    center = (vv_vec3){.13, .27, .41};
}

static void weights_of_directions_are_those_of_their_cells_on_the_sphere(void **state)
{
    (void)state;
    double w[VVI_DIRECTIONS], sum = 0;
    vv_affine m = vv_affine_identity();
    vvi_direction_weights(w, &m);
    for (int d = 0; d < VVI_DIRECTIONS; d++) {
        assert_within(w[d], d < 3 ? .09157 : d < 9 ? .07396 : .07037, 3e-5);
        sum += w[d];
    }
    assert_within(sum, 1, 1e-12);
    /* of a sheared grid, against points all over the sphere */
    m = (vv_affine){{{0.5, 0, 0}, {0.2, 1, 0}, {-0.4, 0.3, 2}}, {0, 0, 0}};
    vvi_direction_weights(w, &m);
    double seen[VVI_DIRECTIONS] = {0};
    const int n = 200000;
    for (int i = 0; i < n; i++) {
        const double z = (2 * i + 1.0) / n - 1, a = 2.399963229728653 * i, r = sqrt(1 - z * z);
        const double p[3] = {r * cos(a), r * sin(a), z};
        int best = 0;
        double most = -1;
        for (int d = 0; d < VVI_DIRECTIONS; d++) {
            const int *s = vvi_directions[d];
            const vv_vec3 v = vv_affine_vector(m, (vv_vec3){s[0], s[1], s[2]});
            const double dot = fabs(v.x * p[0] + v.y * p[1] + v.z * p[2]) / hypot(hypot(v.x, v.y), v.z);
            if (dot > most)
                most = dot, best = d;
        }
        seen[best] += 1.0 / n;
    }
    for (int d = 0; d < VVI_DIRECTIONS; d++)
        assert_within(w[d], seen[d], 5e-4);
}

/* Choices -----------------------------------------------------------------------------------------------------------
 */

static void every_type_and_choice_counts_what_a_loop_counts(void **state)
{
    (void)state;
    static const int64_t sizes[][3] = {{1, 1, 1}, {63, 3, 2}, {64, 2, 3}, {65, 5, 2}, {131, 7, 9}, {4, 1, 17}};
    for (int t = 0; t < VV_TYPE_COUNT; t++)
        for (size_t s = 0; s < sizeof sizes / sizeof *sizes; s++) {
            vv_field_info info = vv_field_info_default();
            memcpy(info.grid.dims, sizes[s], sizeof info.grid.dims);
            info.type = (vv_type)t;
            info.components = 1 + (int)(s + (size_t)t) % 2;
            info.value_scale = s % 3 == 2 ? -0.25 : s % 3 == 1 ? 2 : 1;
            info.value_offset = s % 3 ? 3 : 0;
            vv_field *f = test_field_random(&info, test_seed() + s, NULL);
            const double a = vv_field_value(f, 0, 0, 0, info.components - 1);
            const double b = vv_field_value(f, info.grid.dims[0] / 2, 0, 0, info.components - 1);
            vv_measure_options o = chosen(VV_MEASURE_COUNT, fmin(a, b));
            o.hi = fmax(a, b);
            o.component = info.components - 1;
            uint64_t expected = 0;
            for (int64_t k = 0; k < info.grid.dims[2]; k++)
                for (int64_t j = 0; j < info.grid.dims[1]; j++)
                    for (int64_t i = 0; i < info.grid.dims[0]; i++) {
                        const double v = vv_field_value(f, i, j, k, o.component);
                        expected += v >= o.lo && v <= o.hi;
                    }
            assert_int_equal(measured(f, &o).voxels, expected);
            vv_field_release(f);
        }
}

static void labels_and_masks_are_objects_too(void **state)
{
    (void)state;
    static const uint8_t labels[8] = {0, 1, 2, 2, 1, 2, 7, 0};
    static const float values[8] = {1, NAN, 0, 3, -1, 0, 0, 2};
    vv_field_info info = vv_field_info_default();
    info.grid.dims[0] = info.grid.dims[1] = info.grid.dims[2] = 2;
    info.meaning = VV_MEANING_LABEL;
    vv_field *f, *mask;
    assert_int_equal(vv_field_new(&f, &info, labels, 0, NULL, NULL, NULL), VV_OK);
    info.type = VV_TYPE_F32;
    info.meaning = VV_MEANING_SCALAR;
    assert_int_equal(vv_field_new(&mask, &info, values, 0, NULL, NULL, NULL), VV_OK);
    vv_measure_options o = chosen(VV_MEASURE_COUNT, -INFINITY);
    o.object = VV_OBJECT_LABEL;
    o.label = 2;
    assert_int_equal(measured(f, &o).voxels, 3);
    o.label = 300;
    assert_int_equal(measured(f, &o).voxels, 0);
    o.object = VV_OBJECT_MASK;
    o.mask = mask;
    assert_int_equal(measured(f, &o).voxels, 4);
    vv_field_release(f);
    vv_field_release(mask);
}

static void wrong_choices_are_refused(void **state)
{
    (void)state;
    radius = 3;
    vv_field *f = cube_of(sphere, 4, VV_TYPE_F32);
    vv_measured m = {.size = sizeof m};
    vv_measure_options o = chosen(VV_MEASURE_CUBES, 0);
    o.hi = -1;
    assert_int_equal(vv_measure(&m, f, &o, NULL), VV_E_ARGUMENT);
    o.hi = INFINITY;
    o.component = 1;
    assert_int_equal(vv_measure(&m, f, &o, NULL), VV_E_ARGUMENT);
    o.component = 0;
    o.box = (vv_box){{0, 0, 0}, {9, 9, 10}};
    assert_int_equal(vv_measure(&m, f, &o, NULL), VV_E_ARGUMENT);
    o.box = (vv_box){{0, 0, 0}, {0, 0, 0}};
    o.object = VV_OBJECT_MASK;
    assert_int_equal(vv_measure(&m, f, &o, NULL), VV_E_ARGUMENT);
    const vv_plane flat = {{0, 0, 0}, 1};
    o = chosen(VV_MEASURE_CUBES, 0);
    o.planes = &flat;
    o.n_planes = 1;
    assert_int_equal(vv_measure(&m, f, &o, NULL), VV_E_ARGUMENT);
    vv_field_release(f);
}

static void nothing_and_everything_are_measured_too(void **state)
{
    (void)state;
    radius = 3;
    vv_field *f = cube_of(sphere, 4, VV_TYPE_F32);
    for (int method = VV_MEASURE_CUBES; method <= VV_MEASURE_COUNT; method++) {
        vv_measure_options o = chosen((vv_measure_method)method, 1000);
        const vv_measured none = measured(f, &o);
        assert_true(none.area == 0 && none.volume == 0 && isnan(none.centroid.x));
        o.lo = -INFINITY;
        const vv_measured all = measured(f, &o);
        assert_true(all.area == 0);
        assert_within(all.volume, method == VV_MEASURE_COUNT ? 729 : 512, 1e-9);
        assert_within(all.centroid.x, 0, 1e-12);
    }
    vv_field_release(f);
}

static void thread_count_changes_nothing(void **state)
{
    (void)state;
    vv_field *f = cube_of(torus, 20, VV_TYPE_F32);
    for (int method = VV_MEASURE_CUBES; method <= VV_MEASURE_COUNT; method++) {
        const vv_measure_options o = chosen((vv_measure_method)method, 0);
        const vv_measured alone = measured(f, &o);
        for (int threads = 1; threads <= 3; threads++) {
            vv_job *job = test_job(threads, 0);
            vv_measured m = {.size = sizeof m};
            assert_int_equal(vv_measure(&m, f, &o, job), VV_OK);
            assert_true(m.area == alone.area && m.volume == alone.volume && m.area_error == alone.area_error);
            assert_memory_equal(&m.centroid, &alone.centroid, sizeof m.centroid);
            vv_job_release(job);
        }
    }
    vv_field_release(f);
}

static void a_method_that_is_left_open_suits_what_is_measured(void **state)
{
    vv_field_info info = vv_field_info_default();
    info.grid.dims[0] = 7, info.grid.dims[1] = 5, info.grid.dims[2] = 11;
    info.type = VV_TYPE_U8;
    vv_field *f = test_field_random(&info, 3, NULL);
    (void)state;
    double volume = 0;
    for (int label = -1; label < 256; label++) {
        const vv_measure_method same = label < 0 ? VV_MEASURE_CUBES : VV_MEASURE_COUNT;
        vv_measure_options left = chosen(VV_MEASURE_AUTO, 100), said = chosen(same, 100);
        left.object = said.object = label < 0 ? VV_OBJECT_RANGE : VV_OBJECT_LABEL;
        left.label = said.label = (vv_label_id)label;
        const vv_measured a = measured(f, &left), b = measured(f, &said);
        assert_true(a.volume == b.volume && a.area == b.area && (label >= 0 || a.volume > 0));
        volume += label >= 0 ? a.volume : 0;
    }
    assert_within(volume, 7 * 5 * 11, 1e-9);
    vv_field_release(f);
}

static void values_are_the_same_for_any_number_of_threads(void **state)
{
    (void)state;
    static const vv_type types[] = {VV_TYPE_U8, VV_TYPE_I16, VV_TYPE_I32, VV_TYPE_F32};
    for (int t = 0; t < 8; t++) {
        vv_field_info info = vv_field_info_default();
        info.type = types[t % 4];
        info.grid.dims[0] = 127, info.grid.dims[1] = 131, info.grid.dims[2] = 137;
        vv_field *f = test_field_random(&info, 3, NULL);
        vv_measure_options of = chosen(VV_MEASURE_COUNT, -INFINITY);
        of.box = (vv_box){{3, 5, 7}, {100, 90, 80}};
        vv_values_options o;
        vv_values_options_init(&o, sizeof o);
        o.of = t < 4 ? NULL : &of;
        vv_values *alone, *v;
        assert_int_equal(vv_measure_values(&alone, f, &o, NULL), VV_OK);
        assert_int_equal(alone->count, t < 4 ? 127 * 131 * 137 : 100 * 90 * 80);
        for (int threads = 1; threads <= 3; threads++) {
            vv_job *job = test_job(threads, 0);
            assert_int_equal(vv_measure_values(&v, f, &o, job), VV_OK);
            assert_true(v->mean == alone->mean && v->deviation == alone->deviation && v->median == alone->median);
            assert_true(v->n_bins == alone->n_bins && v->entropy == alone->entropy);
            assert_memory_equal(v->bins, alone->bins, v->n_bins * sizeof *v->bins);
            vv_values_free(v);
            vv_job_release(job);
        }
        vv_values_free(alone);
        vv_field_release(f);
    }
}

/* Every number of a range once: bins of whole numbers hold equally many, whatever their number. */
static void bins_of_whole_numbers_hold_equally_many(void **state)
{
    (void)state;
    static const int64_t spans[] = {1, 2, 255, 256, 1000, 100003};
    for (size_t s = 0; s < sizeof spans / sizeof *spans; s++)
        for (int64_t n_bins = 0; n_bins <= 300; n_bins += 60) {
            vv_field_info info = vv_field_info_default();
            info.grid.dims[0] = spans[s];
            info.type = VV_TYPE_I32;
            int32_t *stored = malloc((size_t)spans[s] * sizeof *stored);
            for (int64_t i = 0; i < spans[s]; i++)
                stored[i] = (int32_t)(i - 77);
            vv_field *f;
            vv_values *v;
            vv_values_options o;
            vv_values_options_init(&o, sizeof o);
            o.n_bins = n_bins;
            assert_int_equal(vv_field_new(&f, &info, stored, 0, NULL, NULL, NULL), VV_OK);
            assert_int_equal(vv_measure_values(&v, f, &o, NULL), VV_OK);
            assert_true(v->n_bins <= (size_t)(n_bins ? n_bins : 1024) && v->lo == -77.5);
            const double width = (v->hi - v->lo) / (double)v->n_bins;
            assert_true(width == floor(width));
            for (size_t i = 0; i + 1 < v->n_bins; i++)
                assert_int_equal(v->bins[i], (uint64_t)width);
            vv_values_free(v);
            vv_field_release(f);
            free(stored);
        }
}

typedef struct body {
    vv_vec3 center, size; /* size: radius of a sphere; of a torus large and small; half of a box */
    int kind;
} body;

static double body_at(const body *b, double x, double y, double z)
{
    const double dx = x - b->center.x, dy = y - b->center.y, dz = z - b->center.z;
    if (b->kind == 0)
        return b->size.x - sqrt(dx * dx + dy * dy + dz * dz);
    if (b->kind == 1)
        return b->size.y - hypot(hypot(dx, dy) - b->size.x, dz);
    return fmin(fmin(b->size.x - fabs(dx), b->size.y - fabs(dy)), b->size.z - fabs(dz));
}

static double body_volume(const body *b)
{
    return b->kind == 0   ? 4 / 3.0 * M_PI * pow(b->size.x, 3)
           : b->kind == 1 ? 2 * M_PI * M_PI * b->size.x * b->size.y * b->size.y
                          : 8 * b->size.x * b->size.y * b->size.z;
}

/* Spheres, tori and boxes of random size at random places: the volume is within the error in 95 of 100 cases. */
static void counted_volumes_are_within_their_error(void **state)
{
    (void)state;
    enum { N = 40, TRIES = 120 };
    for (int kind = 0; kind < 3; kind++) {
        int within = 0;
        for (uint64_t i = 0; i < TRIES; i++) {
            double r[6];
            for (uint64_t k = 0; k < 6; k++)
                r[k] = test_random_unit(1994, 1000 * (uint64_t)kind + 6 * i + k);
            body b = {{18 + r[0], 18 + r[1], 18 + r[2]}, {3 + 13 * r[3], 3 + 13 * r[4], 3 + 13 * r[5]}, kind};
            if (kind == 1)
                b.size = (vv_vec3){8 + 4 * r[3], 2.5 + 3 * r[4], 0};
            vv_field_info info = vv_field_info_default();
            info.type = VV_TYPE_F32;
            for (int a = 0; a < 3; a++)
                info.grid.dims[a] = N;
            float *stored = malloc(sizeof *stored * N * N * N);
            for (int64_t v = 0; v < N * N * N; v++)
                stored[v] = (float)body_at(&b, (double)(v % N), (double)(v / N % N), (double)(v / N / N));
            vv_field *f;
            assert_int_equal(vv_field_new(&f, &info, stored, 0, NULL, NULL, NULL), VV_OK);
            const vv_measure_options o = chosen(VV_MEASURE_COUNT, 0);
            const vv_measured m = measured(f, &o);
            within += fabs(m.volume - body_volume(&b)) <= m.volume_error;
            vv_field_release(f);
            free(stored);
        }
        assert_true(within >= TRIES * 95 / 100);
    }
}

static void a_negative_scale_turns_values_round(void **state)
{
    (void)state;
    static const int16_t stored[4] = {1, 2, 2, 10};
    vv_field_info info = vv_field_info_default();
    info.grid.dims[0] = 4;
    info.type = VV_TYPE_I16;
    info.value_scale = -0.5;
    info.value_offset = 7;
    vv_field *f;
    vv_values *v;
    vv_values_options o;
    vv_values_options_init(&o, sizeof o);
    o.lo = 5;
    assert_int_equal(vv_field_new(&f, &info, stored, 0, NULL, NULL, NULL), VV_OK);
    assert_int_equal(vv_measure_values(&v, f, &o, NULL), VV_OK);
    assert_true(v->min == 2 && v->max == 6.5 && v->median == 6 && v->mode == 6);
    assert_true(v->lo == 4.75 && v->hi == 6.75 && v->n_bins == 4 && v->below == 1 && v->above == 0);
    vv_values_free(v);
    vv_field_release(f);
}

static vv_status act_on_values(void *user)
{
    vv_values *v = NULL;
    const vv_status st = vv_measure_values(&v, user, NULL, NULL);
    vv_values_free(v);
    return st;
}

static void the_areas_of_all_labels_are_those_of_each_alone(void **state)
{
    (void)state;
    vv_field_info info = vv_field_info_default();
    uint8_t values[23 * 19 * 17];
    info.grid.dims[0] = 23, info.grid.dims[1] = 19, info.grid.dims[2] = 17;
    info.grid.index_to_world.axis[1] = (vv_vec3){0.3, 1.1, 0};
    for (size_t i = 0; i < sizeof values; i++) { /* slabs, with samples of another label in them */
        const uint32_t r = (uint32_t)(test_random_unit(77, i) * 64);
        values[i] = r < 4 ? (uint8_t)r : (uint8_t)(i / 1900);
    }
    vv_field *f;
    assert_int_equal(vv_field_new(&f, &info, values, 0, NULL, NULL, NULL), VV_OK);
    const vv_box boxes[3] = {{{0, 0, 0}, {0, 0, 0}}, {{2, 0, 3}, {20, 19, 9}}, {{5, 6, 16}, {1, 2, 1}}};
    for (int b = 0; b < 3; b++) {
        const vv_plane plane = {{0.6, 0.8, 0}, 5};
        vv_label_options o;
        vv_label_measures *l;
        size_t n;
        vv_label_options_init(&o, sizeof o);
        o.box = boxes[b];
        o.planes = &plane;
        o.n_planes = b == 1;
        assert_int_equal(vv_measure_labels(&l, &n, f, &o, NULL), VV_OK);
        for (size_t i = 0; i < n; i++) {
            vv_measure_options alone = chosen(VV_MEASURE_COUNT, 0);
            alone.object = VV_OBJECT_LABEL;
            alone.label = l[i].label;
            alone.box = o.box;
            alone.planes = o.planes;
            alone.n_planes = o.n_planes;
            const vv_measured m = measured(f, &alone);
            assert_true(l[i].count == m.voxels && l[i].volume == m.volume && l[i].area == m.area);
            assert_true(l[i].volume_error == m.volume_error);
            assert_true(isnan(m.area_error) ? isnan(l[i].area_error) : l[i].area_error == m.area_error);
            assert_true(l[i].bounds.lo.x == m.bounds.lo.x && l[i].bounds.hi.z == m.bounds.hi.z);
        }
        assert_true(b == 2 || n == 3);
        vv_label_measures *quick;
        size_t n_quick;
        o.no_areas = true;
        assert_int_equal(vv_measure_labels(&quick, &n_quick, f, &o, NULL), VV_OK);
        assert_int_equal(n_quick, n);
        for (size_t i = 0; i < n; i++)
            assert_true(quick[i].label == l[i].label && quick[i].count == l[i].count && isnan(quick[i].area) &&
                        isnan(quick[i].volume_error));
        vv_label_measures_free(quick);
        vv_label_measures_free(l);
    }
    vv_field_release(f);
}

static vv_status act_on_labels(void *user)
{
    vv_label_measures *l = NULL;
    vv_label_options o;
    size_t n;
    vv_label_options_init(&o, sizeof o);
    o.values = user;
    const vv_status st = vv_measure_labels(&l, &n, user, &o, NULL);
    vv_label_measures_free(l);
    return st;
}

static void values_and_labels_survive_failing_allocations(void **state)
{
    (void)state;
    vv_field_info info = vv_field_info_default();
    info.grid.dims[0] = 9, info.grid.dims[1] = 7, info.grid.dims[2] = 5;
    for (int t = 0; t < 2; t++) {
        info.type = t ? VV_TYPE_F32 : VV_TYPE_U8;
        vv_field *f = test_field_random(&info, 3, NULL);
        assert_true(test_fail_each_alloc(act_on_values, f) > 2);
        if (!t)
            assert_true(test_fail_each_alloc(act_on_labels, f) > 2);
        vv_field_release(f);
    }
}

static vv_status act(void *user)
{
    vv_measure_options o = chosen(VV_MEASURE_CUBES, 0);
    vv_measured m = {.size = sizeof m};
    o.seeded = true;
    o.seed[0] = o.seed[1] = o.seed[2] = 5;
    return vv_measure(&m, user, &o, NULL);
}

static void every_failing_allocation_is_survived(void **state)
{
    (void)state;
    radius = 3;
    vv_field *f = cube_of(sphere, 5, VV_TYPE_F32);
    assert_true(test_fail_each_alloc(act, f) > 5);
    vv_field_release(f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(spheres_have_the_errors_of_marching_cubes),
        cmocka_unit_test(a_torus_has_the_errors_of_marching_cubes),
        cmocka_unit_test(steps_make_the_area_8_percent_too_large),
        cmocka_unit_test(noise_has_the_area_and_volume_of_its_mesh),
        cmocka_unit_test(spacing_and_shear_are_taken_into_account),
        cmocka_unit_test(a_plane_through_the_middle_leaves_half),
        cmocka_unit_test(planes_that_meet_cut_out_what_they_should),
        cmocka_unit_test(what_runs_out_of_the_volume_is_not_closed_there),
        cmocka_unit_test(the_piece_around_a_seed_is_measured_as_if_it_were_alone),
        cmocka_unit_test(a_long_way_is_followed_to_its_end),
        cmocka_unit_test(a_box_of_voxels_is_counted_exactly),
        cmocka_unit_test(spheres_have_the_errors_of_counting),
        cmocka_unit_test(weights_of_directions_are_those_of_their_cells_on_the_sphere),
        cmocka_unit_test(every_type_and_choice_counts_what_a_loop_counts),
        cmocka_unit_test(labels_and_masks_are_objects_too),
        cmocka_unit_test(the_areas_of_all_labels_are_those_of_each_alone),
        cmocka_unit_test(wrong_choices_are_refused),
        cmocka_unit_test(nothing_and_everything_are_measured_too),
        cmocka_unit_test(thread_count_changes_nothing),
        cmocka_unit_test(values_are_the_same_for_any_number_of_threads),
        cmocka_unit_test(bins_of_whole_numbers_hold_equally_many),
        cmocka_unit_test(counted_volumes_are_within_their_error),
        cmocka_unit_test(a_negative_scale_turns_values_round),
        cmocka_unit_test(a_method_that_is_left_open_suits_what_is_measured),
        cmocka_unit_test(values_and_labels_survive_failing_allocations),
        cmocka_unit_test(every_failing_allocation_is_survived),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
