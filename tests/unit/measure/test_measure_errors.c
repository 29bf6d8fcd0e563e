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

enum kind { SPHERE, TORUS, BOX, CYLINDER, CONE, KINDS };

/* size: radius of a sphere; of a torus large and small; half of a box; radius and half length of a cylinder (x, z);
 * radius of the base and half height of a cone (x, z), which stands on -z. */
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
enum { SORTS = sizeof sorts / sizeof *sorts, TRIES = 60, CONES = 60 };

/* hypot() takes most of the time of a test that asks it at each voxel, for cases that are none here. */
static double diagonal(double x, double y)
{
    return sqrt(x * x + y * y);
}

static double depth(const body *b, vv_vec3 p)
{
    const vv_vec3 d = vvi_sub(p, b->center);
    const double x = vvi_dot(d, b->axis[0]), y = vvi_dot(d, b->axis[1]), z = vvi_dot(d, b->axis[2]);
    switch (b->kind) {
    case SPHERE:
        return b->size.x - vvi_length(d);
    case TORUS:
        return b->size.y - diagonal(diagonal(x, y) - b->size.x, z);
    case BOX:
        return fmin(fmin(b->size.x - fabs(x), b->size.y - fabs(y)), b->size.z - fabs(z));
    case CONE: {
        const double side = diagonal(b->size.x, 2 * b->size.z);
        return fmin((2 * b->size.z * (b->size.x - diagonal(x, y)) - b->size.x * (z + b->size.z)) / side, z + b->size.z);
    }
    default:
        return fmin(b->size.x - diagonal(x, y), b->size.z - fabs(z));
    }
}

static double true_area(const body *b)
{
    const double x = b->size.x, y = b->size.y, z = b->size.z;
    return b->kind == SPHERE  ? 4 * M_PI * x * x
           : b->kind == TORUS ? 4 * M_PI * M_PI * x * y
           : b->kind == BOX   ? 8 * (x * y + y * z + z * x)
           : b->kind == CONE  ? M_PI * x * (x + diagonal(x, 2 * z))
                              : 2 * M_PI * x * (x + 2 * z);
}

static double true_volume(const body *b)
{
    const double x = b->size.x, y = b->size.y, z = b->size.z;
    return b->kind == SPHERE  ? 4 / 3.0 * M_PI * x * x * x
           : b->kind == TORUS ? 2 * M_PI * M_PI * x * y * y
           : b->kind == BOX   ? 8 * x * y * z
           : b->kind == CONE  ? 2 / 3.0 * M_PI * x * x * z
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

/* Distances; *samples is its memory. */
static vv_field *sampled(float **samples, const body *b, const vv_vec3 spacing, vv_vec3 room)
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
    float *v = *samples = memory;
    for (int64_t k = 0; k < info.grid.dims[2]; k++)
        for (int64_t j = 0; j < info.grid.dims[1]; j++)
            for (int64_t i = 0; i < info.grid.dims[0]; i++)
                *v++ = (float)depth(b, (vv_vec3){(double)i * spacing.x, (double)j * spacing.y, (double)k * spacing.z});
    return f;
}

/* 0, and `step` where the distance is not below 0. */
static vv_field *stepped(const vv_field *distances, const float *samples, double step)
{
    const vv_field_info *info = vv_field_get_info(distances);
    vv_field *f;
    void *memory;
    assert_int_equal(vv_field_new_empty(&f, &memory, info, NULL), VV_OK);
    for (int64_t i = 0; i < info->grid.dims[0] * info->grid.dims[1] * info->grid.dims[2]; i++)
        ((float *)memory)[i] = samples[i] >= 0 ? (float)step : 0;
    return f;
}

/* The ways to measure: marching cubes in distances, and in steps of 1 and 7, where a surface at 0.5 is far from the
 * middle; counts. */
static const struct {
    vv_measure_method method;
    double step;
} ways[] = {{VV_MEASURE_CUBES, 0}, {VV_MEASURE_COUNT, 0}, {VV_MEASURE_CUBES, 1}, {VV_MEASURE_CUBES, 7}};
enum { CUBES, COUNTS, STEPS, WAYS = sizeof ways / sizeof *ways, BANDS = WAYS, TALLIES };

typedef struct tally {
    int tries;
    int area, volume, centroid, box; /* within their errors; of 3 and 6 numbers each */
    double error[2], told[2];
} tally;

static void add_one(tally *t, const body *b, const vv_field *f, vv_measure_method method, double step)
{
    vv_measured m = {.size = sizeof m};
    vv_measure_options o;
    vv_measure_options_init(&o, sizeof o);
    o.method = method;
    o.lo = step > 0 ? 0.5 : 0;
    assert_int_equal(vv_measure(&m, f, &o, NULL), VV_OK);
    assert_int_equal(m.steps, step > 0 && method == VV_MEASURE_CUBES);
    const double error[2] = {fabs(m.area - true_area(b)), fabs(m.volume - true_volume(b))};
    t->tries++;
    t->area += error[0] <= m.area_error;
    t->volume += error[1] <= m.volume_error;
    for (int a = 0; a < 3; a++) {
        const double c = (&b->center.x)[a], reach = true_reach(b, a), side_error = (&m.bounds_error.x)[a];
        t->centroid += fabs((&m.centroid.x)[a] - c) <= (&m.centroid_error.x)[a];
        t->box += fabs((&m.bounds.lo.x)[a] - (c - reach)) <= side_error;
        t->box += fabs((&m.bounds.hi.x)[a] - (c + reach)) <= side_error;
    }
    for (int k = 0; k < 2; k++)
        t->error[k] += error[k];
    t->told[0] += m.area_error;
    t->told[1] += m.volume_error;
}

/* A shell of the body, of 0.05 to 3 voxels: its samples are few, or none. */
static void add_band(tally *t, const body *b, const vv_field *f, double width)
{
    body hollow = *b;
    vv_measured m = {.size = sizeof m};
    vv_measure_options o;
    vv_measure_options_init(&o, sizeof o);
    width = fmin(width, 0.6 * (b->kind == TORUS ? b->size.y : b->size.x));
    if (b->kind == BOX || b->kind == CYLINDER)
        width = fmin(width, 0.6 * fmin(b->size.y, b->size.z));
    hollow.size = vvi_sub(b->size, b->kind == TORUS ? vvi_vec(0, width, 0) : vvi_vec(width, width, width));
    o.lo = 0;
    o.hi = width;
    assert_int_equal(vv_measure(&m, f, &o, NULL), VV_OK);
    const double error[2] = {fabs(m.area - true_area(b) - true_area(&hollow)),
                             fabs(m.volume - true_volume(b) + true_volume(&hollow))};
    t->tries++;
    t->area += error[0] <= m.area_error;
    t->volume += error[1] <= m.volume_error;
    for (int a = 0; a < 3; a++) {
        const double c = (&b->center.x)[a], reach = true_reach(b, a), side_error = (&m.bounds_error.x)[a];
        t->centroid += fabs((&m.centroid.x)[a] - c) <= (&m.centroid_error.x)[a];
        t->box += fabs((&m.bounds.lo.x)[a] - (c - reach)) <= side_error;
        t->box += fabs((&m.bounds.hi.x)[a] - (c + reach)) <= side_error;
    }
    for (int k = 0; k < 2; k++)
        t->error[k] += error[k];
    t->told[0] += m.area_error;
    t->told[1] += m.volume_error;
}

static void add_body(tally t[TALLIES], const sort *s, uint64_t at, bool steps)
{
    const double side = cbrt(s->spacing.x * s->spacing.y * s->spacing.z), edge = (s->kind == BOX ? 48 : 40) * side;
    const vv_vec3 room = {edge, edge, edge};
    const body b = random_body(s, room, side, at);
    float *samples;
    vv_field *distances = sampled(&samples, &b, s->spacing, room);
    add_one(&t[CUBES], &b, distances, ways[CUBES].method, 0);
    add_one(&t[COUNTS], &b, distances, ways[COUNTS].method, 0);
    add_band(&t[BANDS], &b, distances, side * 0.05 * exp(log(60) * test_random_unit(1994, at + 90)));
    for (int w = STEPS; w < WAYS && steps; w++) {
        vv_field *f = stepped(distances, samples, ways[w].step);
        add_one(&t[w], &b, f, ways[w].method, ways[w].step);
        vv_field_release(f);
    }
    vv_field_release(distances);
}

/* Each body is sampled once and measured in all ways; the tests look at the tallies, [sort][way]. */
static int measure_all(void **state)
{
    tally(*all)[TALLIES] = calloc(SORTS, sizeof *all);
    assert_non_null(all);
    for (int s = 0; s < SORTS; s++)
        for (int i = 0; i < TRIES; i++)
            add_body(all[s], &sorts[s], 100 * (uint64_t)i, s % 2 == 0);
    *state = all;
    return 0;
}

static int forget_all(void **state)
{
    free(*state);
    return 0;
}

static void check_errors(void **state, int number, int way)
{
    const sort *s = &sorts[number];
    const tally(*all)[TALLIES] = *state, t = all[number][way];
    printf("kind %d%s, spacing %g %g %g: within %d, %d, %d, %d; told %.2f, %.2f times the mean error\n", s->kind,
           s->turned ? " turned" : "", s->spacing.x, s->spacing.y, s->spacing.z, t.area, t.volume, t.centroid / 3,
           t.box / 6, t.told[0] / t.error[0], t.told[1] / t.error[1]);
    assert_int_equal(t.tries, TRIES);
    assert_true(t.area >= 95 * TRIES / 100 && t.volume >= 95 * TRIES / 100);
    assert_true(t.centroid / 3 >= 95 * TRIES / 100 && t.box / 6 >= 95 * TRIES / 100);
    assert_true(way != CUBES || (t.told[0] < 5 * t.error[0] && t.told[1] < 5 * t.error[1]));
}

static void marching_cubes_is_within_its_error(void **state)
{
    for (int s = 0; s < SORTS; s++)
        check_errors(state, s, CUBES);
}

static void bands_are_within_their_error(void **state)
{
    for (int s = 0; s < SORTS; s++)
        check_errors(state, s, BANDS);
}

static void steps_are_within_their_error(void **state)
{
    for (int s = 0; s < SORTS; s += 2)
        for (int way = STEPS; way < WAYS; way++)
            check_errors(state, s, way);
}

static void counts_are_within_their_error(void **state)
{
    for (int s = 0; s < SORTS; s++)
        check_errors(state, s, COUNTS);
}

/* Upright and turned, from half as high as the radius of the base to two and a half times; small, and less so. */
static body random_cone(const sort *s, vv_vec3 room, double side, double least, double most, uint64_t at)
{
    body b = random_body(s, room, side, at + 50);
    const double radius = from(least, most, &at) * side;
    b.size = vvi_vec(radius, 0, radius / 2 * exp(from(log(0.5), log(2.5), &at)));
    return b;
}

static void counts_of_cones_are_within_their_error(void **state)
{
    (void)state;
    static const vv_vec3 spacings[] = {{1, 1, 1}, {0.5, 1, 2}, {1, 1, 3}};
    static const double sizes[][2] = {{5, 10}, {8, 13}};
    for (int i = 0; i < 12; i++) {
        const sort s = {CONE, i % 2 == 1, spacings[i / 4]};
        const double *size = sizes[i / 2 % 2], side = cbrt(s.spacing.x * s.spacing.y * s.spacing.z);
        const double edge = 48 * side;
        int area = 0, volume = 0;
        double error = 0, told = 0;
        for (int k = 0; k < CONES; k++) {
            const vv_vec3 room = {edge, edge, edge};
            const body b =
                random_cone(&s, room, side, size[0], size[1], 100000 + 1000 * (uint64_t)i + 100 * (uint64_t)k);
            vv_measured m = {.size = sizeof m};
            vv_measure_options o;
            vv_measure_options_init(&o, sizeof o);
            o.method = VV_MEASURE_COUNT;
            o.lo = 0;
            float *samples;
            vv_field *f = sampled(&samples, &b, s.spacing, room);
            assert_int_equal(vv_measure(&m, f, &o, NULL), VV_OK);
            vv_field_release(f);
            area += fabs(m.area - true_area(&b)) <= m.area_error;
            volume += fabs(m.volume - true_volume(&b)) <= m.volume_error;
            error += fabs(m.area - true_area(&b));
            told += m.area_error;
        }
        printf("cones%s, spacing %g %g %g, radius %g to %g: within %d, %d; told %.2f times the mean error\n",
               s.turned ? " turned" : "", s.spacing.x, s.spacing.y, s.spacing.z, size[0], size[1], area, volume,
               told / error);
        assert_true(area >= 95 * CONES / 100 && volume >= 95 * CONES / 100 && told < 5 * error);
    }
}

/* The field of bodies apart from each other, each in a cube of its own of EDGE samples. */
enum { HEAP = 4, EDGE = 18 };

static vv_field *heap_of(double *area, double *volume, enum kind kind, uint64_t at)
{
    const sort s = {kind, true, {1, 1, 1}};
    vv_field_info info = vv_field_info_default();
    vv_field *f;
    void *memory;
    info.type = VV_TYPE_F32;
    info.grid.dims[0] = info.grid.dims[1] = info.grid.dims[2] = HEAP * EDGE;
    assert_int_equal(vv_field_new_empty(&f, &memory, &info, NULL), VV_OK);
    *area = *volume = 0;
    for (int c = 0; c < HEAP * HEAP * HEAP; c++) {
        const int x = c % HEAP * EDGE, y = c / HEAP % HEAP * EDGE, z = c / HEAP / HEAP * EDGE;
        body b = random_body(&s, vvi_vec(EDGE, EDGE, EDGE), 1, at + 100 * (uint64_t)c);
        b.center = vvi_sub(b.center, vvi_vec(0.5, 0.5, 0.5));
        b.size = vvi_add(vvi_scaled(b.size, 0.15), vvi_vec(2.5, 2.5, 2.5));
        *area += true_area(&b);
        *volume += true_volume(&b);
        for (int i = 0; i < EDGE * EDGE * EDGE; i++) {
            const int p[3] = {i % EDGE, i / EDGE % EDGE, i / EDGE / EDGE};
            ((float *)memory)[x + p[0] + HEAP * EDGE * (y + p[1] + HEAP * EDGE * (z + p[2]))] =
                (float)depth(&b, vvi_vec(p[0], p[1], p[2]));
        }
    }
    return f;
}

/* Edges that lie every way are bevelled by now more, now less: the error of many is much less than that of each. */
static void many_edges_have_the_error_of_their_mean(void **state)
{
    (void)state;
    for (enum kind kind = BOX; kind <= CONE; kind++) {
        vv_measured m = {.size = sizeof m};
        double area, volume;
        vv_measure_options o;
        vv_measure_options_init(&o, sizeof o);
        o.lo = 0;
        vv_field *f = heap_of(&area, &volume, kind, 700000 + 10000 * (uint64_t)kind);
        assert_int_equal(vv_measure(&m, f, &o, NULL), VV_OK);
        vv_field_release(f);
        printf("heap of kind %d: area off by %+.2f %%, told %.2f; volume by %+.2f %%, told %.2f\n", kind,
               100 * (m.area / area - 1), 100 * m.area_error / area, 100 * (m.volume / volume - 1),
               100 * m.volume_error / volume);
        assert_true(fabs(m.area - area) <= m.area_error && fabs(m.volume - volume) <= m.volume_error);
        assert_true(m.area_error < 1.75 * fabs(m.area - area) && m.volume_error < 3.5 * fabs(m.volume - volume));
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
        cmocka_unit_test(bands_are_within_their_error),
        cmocka_unit_test(steps_are_within_their_error),
        cmocka_unit_test(counts_are_within_their_error),
        cmocka_unit_test(counts_of_cones_are_within_their_error),
        cmocka_unit_test(many_edges_have_the_error_of_their_mean),
        cmocka_unit_test(a_slab_that_leaves_the_volume_is_one_piece),
    };
    return cmocka_run_group_tests(tests, measure_all, forget_all);
}
