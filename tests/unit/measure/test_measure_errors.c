/* Bodies of known area and volume, of random size, at random places and turned at random: the truth is within the error
 * that is told. */
#include "core/vec.h"
#include "fields.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <volvis/measure.h>

#include <cmocka.h>

enum kind { SPHERE, TORUS, BOX, CYLINDER, KINDS };

/* size: radius of a sphere; of a torus large and small; half of a box; radius and half length of a cylinder (x, z). */
typedef struct body {
    enum kind kind;
    vv_vec3 center, size, axis[3];
} body;

typedef struct sort {
    enum kind kind;
    bool turned;
    vv_vec3 spacing;
} sort;

static const sort sorts[] = {
    {SPHERE, false, {1, 1, 1}},   {SPHERE, false, {0.5, 1, 2}}, {SPHERE, false, {1, 1, 3}},
    {TORUS, true, {1, 1, 1}},     {TORUS, true, {0.5, 1, 2}},   {BOX, false, {1, 1, 1}},
    {BOX, false, {0.5, 1, 2}},    {BOX, true, {1, 1, 1}},       {BOX, true, {0.5, 1, 2}},
    {CYLINDER, false, {1, 1, 1}}, {CYLINDER, true, {1, 1, 1}},  {CYLINDER, true, {0.5, 1, 2}},
};
enum { SORTS = sizeof sorts / sizeof *sorts, TRIES = 100 };

static double depth(const body *b, vv_vec3 p)
{
    const vv_vec3 d = vvi_sub(p, b->center);
    const double x = vvi_dot(d, b->axis[0]), y = vvi_dot(d, b->axis[1]), z = vvi_dot(d, b->axis[2]);
    switch (b->kind) {
    case SPHERE:
        return b->size.x - vvi_length(d);
    case TORUS:
        return b->size.y - hypot(hypot(x, y) - b->size.x, z);
    case BOX:
        return fmin(fmin(b->size.x - fabs(x), b->size.y - fabs(y)), b->size.z - fabs(z));
    default:
        return fmin(b->size.x - hypot(x, y), b->size.z - fabs(z));
    }
}

static double true_area(const body *b)
{
    const double x = b->size.x, y = b->size.y, z = b->size.z;
    return b->kind == SPHERE  ? 4 * M_PI * x * x
           : b->kind == TORUS ? 4 * M_PI * M_PI * x * y
           : b->kind == BOX   ? 8 * (x * y + y * z + z * x)
                              : 2 * M_PI * x * (x + 2 * z);
}

static double true_volume(const body *b)
{
    const double x = b->size.x, y = b->size.y, z = b->size.z;
    return b->kind == SPHERE  ? 4 / 3.0 * M_PI * x * x * x
           : b->kind == TORUS ? 2 * M_PI * M_PI * x * y * y
           : b->kind == BOX   ? 8 * x * y * z
                              : 2 * M_PI * x * x * z;
}

/* How far it reaches from its middle along a world axis. */
static double true_reach(const body *b, int axis)
{
    const double n[3] = {(&b->axis[0].x)[axis], (&b->axis[1].x)[axis], (&b->axis[2].x)[axis]};
    const double across = sqrt(fmax(1 - n[2] * n[2], 0));
    return b->kind == SPHERE  ? b->size.x
           : b->kind == TORUS ? b->size.x * across + b->size.y
           : b->kind == BOX   ? fabs(n[0]) * b->size.x + fabs(n[1]) * b->size.y + fabs(n[2]) * b->size.z
                              : fabs(n[2]) * b->size.z + b->size.x * across;
}

static double from(double lo, double hi, uint64_t *at)
{
    return lo + (hi - lo) * test_random_unit(1994, (*at)++);
}

/* Sizes of 3 to 12 voxels' mean sides. */
static body random_body(const sort *s, const vv_vec3 room, double side, uint64_t at)
{
    static const vv_vec3 along[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    body b = {.kind = s->kind};
    const int first = (int)from(0, 3, &at);
    for (int a = 0; a < 3; a++)
        b.axis[a] = along[(a + first) % 3];
    if (s->turned) {
        b.axis[0] = vvi_vec(from(-1, 1, &at), from(-1, 1, &at), from(-1, 1, &at));
        b.axis[1] = vvi_cross(b.axis[0], vvi_vec(from(-1, 1, &at), from(-1, 1, &at), from(-1, 1, &at)));
        vvi_unit(&b.axis[0]);
        vvi_unit(&b.axis[1]);
        b.axis[2] = vvi_cross(b.axis[0], b.axis[1]);
    }
    b.size = vvi_vec(from(3, 12, &at), from(3, 12, &at), from(3, 12, &at));
    if (s->kind == TORUS)
        b.size = vvi_vec(from(8, 12, &at), from(2.5, 5.5, &at), 0);
    b.size = vvi_scaled(b.size, side);
    b.center = vvi_vec(room.x / 2 + from(0, s->spacing.x, &at), room.y / 2 + from(0, s->spacing.y, &at),
                       room.z / 2 + from(0, s->spacing.z, &at));
    return b;
}

/* Distances, or 0 and `step` where that is not 0. */
static vv_field *sampled(const body *b, const vv_vec3 spacing, vv_vec3 room, double step)
{
    vv_field_info info = vv_field_info_default();
    vv_field *f;
    void *memory;
    info.type = VV_TYPE_F32;
    info.grid.dims[0] = (int64_t)(room.x / spacing.x) + 2;
    info.grid.dims[1] = (int64_t)(room.y / spacing.y) + 2;
    info.grid.dims[2] = (int64_t)(room.z / spacing.z) + 2;
    info.grid.index_to_world = (vv_affine){{{spacing.x, 0, 0}, {0, spacing.y, 0}, {0, 0, spacing.z}}, {0, 0, 0}};
    assert_int_equal(vv_field_new_empty(&f, &memory, &info, NULL), VV_OK);
    float *v = memory;
    for (int64_t k = 0; k < info.grid.dims[2]; k++)
        for (int64_t j = 0; j < info.grid.dims[1]; j++)
            for (int64_t i = 0; i < info.grid.dims[0]; i++) {
                const vv_vec3 p = {(double)i * spacing.x, (double)j * spacing.y, (double)k * spacing.z};
                const double d = depth(b, p);
                *v++ = (float)(step > 0 ? (d >= 0 ? step : 0) : d);
            }
    return f;
}

typedef struct tally {
    int area, volume, centroid, box; /* within their errors; of 3 and 6 numbers each */
    double error[2], told[2];
} tally;

static tally tally_of(const sort *s, vv_measure_method method, double step)
{
    const double side = cbrt(s->spacing.x * s->spacing.y * s->spacing.z), edge = (s->kind == BOX ? 48 : 40) * side;
    const vv_vec3 room = {edge, edge, edge};
    tally t = {0};
    for (int i = 0; i < TRIES; i++) {
        const body b = random_body(s, room, side, 100 * (uint64_t)i);
        vv_field *f = sampled(&b, s->spacing, room, step);
        vv_measured m = {.size = sizeof m};
        vv_measure_options o;
        vv_measure_options_init(&o, sizeof o);
        o.method = method;
        o.lo = step > 0 ? 0.5 : 0;
        assert_int_equal(vv_measure(&m, f, &o, NULL), VV_OK);
        assert_int_equal(m.steps, step > 0 && method == VV_MEASURE_CUBES);
        const double error[2] = {fabs(m.area - true_area(&b)), fabs(m.volume - true_volume(&b))};
        t.area += error[0] <= m.area_error;
        t.volume += error[1] <= m.volume_error;
        for (int a = 0; a < 3; a++) {
            const double c = (&b.center.x)[a], reach = true_reach(&b, a), side_error = (&m.bounds_error.x)[a];
            t.centroid += fabs((&m.centroid.x)[a] - c) <= (&m.centroid_error.x)[a];
            t.box += fabs((&m.bounds.lo.x)[a] - (c - reach)) <= side_error;
            t.box += fabs((&m.bounds.hi.x)[a] - (c + reach)) <= side_error;
        }
        for (int k = 0; k < 2; k++)
            t.error[k] += error[k];
        t.told[0] += m.area_error;
        t.told[1] += m.volume_error;
        vv_field_release(f);
    }
    t.centroid /= 3;
    t.box /= 6;
    printf("kind %d%s, spacing %g %g %g: within %d, %d, %d, %d; told %.2f, %.2f times the mean error\n", s->kind,
           s->turned ? " turned" : "", s->spacing.x, s->spacing.y, s->spacing.z, t.area, t.volume, t.centroid, t.box,
           t.told[0] / t.error[0], t.told[1] / t.error[1]);
    return t;
}

static void marching_cubes_is_within_its_error(void **state)
{
    (void)state;
    for (int s = 0; s < SORTS; s++) {
        const tally t = tally_of(&sorts[s], VV_MEASURE_CUBES, 0);
        assert_true(t.area >= 95 * TRIES / 100 && t.volume >= 95 * TRIES / 100);
        assert_true(t.centroid >= 95 * TRIES / 100 && t.box >= 95 * TRIES / 100);
        assert_true(t.told[0] < 5 * t.error[0] && t.told[1] < 5 * t.error[1]);
    }
}

/* Of 0 and 1, and of 0 and 7, where a surface at 0.5 is far from the middle. */
static void steps_are_within_their_error(void **state)
{
    (void)state;
    for (int s = 0; s < SORTS; s += 2)
        for (double step = 1; step <= 7; step += 6) {
            const tally t = tally_of(&sorts[s], VV_MEASURE_CUBES, step);
            assert_true(t.area >= 95 * TRIES / 100 && t.volume >= 95 * TRIES / 100);
            assert_true(t.centroid >= 95 * TRIES / 100 && t.box >= 95 * TRIES / 100);
        }
}

static void counts_are_within_their_error(void **state)
{
    (void)state;
    for (int s = 0; s < SORTS; s++) {
        const tally t = tally_of(&sorts[s], VV_MEASURE_COUNT, 0);
        assert_true(t.area >= 95 * TRIES / 100 && t.volume >= 95 * TRIES / 100);
        assert_true(t.centroid >= 95 * TRIES / 100 && t.box >= 95 * TRIES / 100);
    }
}

/* Nine by nine voxels through the volume, three high: its sides are cut off by the border. */
static void a_slab_that_leaves_the_volume_is_one_piece(void **state)
{
    (void)state;
    vv_field_info info = vv_field_info_default();
    vv_field *f;
    void *memory;
    for (int a = 0; a < 3; a++)
        info.grid.dims[a] = 9;
    assert_int_equal(vv_field_new_empty(&f, &memory, &info, NULL), VV_OK);
    memset(memory, 0, 9 * 9 * 9);
    memset(memory, 1, 9 * 9 * 3);
    for (int closed = 0; closed < 2; closed++) {
        vv_measured m = {.size = sizeof m};
        vv_measure_options o;
        vv_measure_options_init(&o, sizeof o);
        o.method = VV_MEASURE_COUNT;
        o.lo = 1;
        o.closed = closed;
        assert_int_equal(vv_measure(&m, f, &o, NULL), VV_OK);
        assert_true(m.euler == 1 && m.voxels == 9 * 9 * 3);
        assert_true(fabs(m.cut_area - (9 * 9 + 4 * 9 * 3)) < 1e-9);
        assert_true(closed || fabs(m.area - 9 * 9) <= m.area_error);
    }
    vv_field_release(f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(marching_cubes_is_within_its_error),
        cmocka_unit_test(steps_are_within_their_error),
        cmocka_unit_test(counts_are_within_their_error),
        cmocka_unit_test(a_slab_that_leaves_the_volume_is_one_piece),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
