/* The table of cases of Marching Cubes: every entry, against what a surface must be. */
#include "surface/cases.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>

#include <cmocka.h>

static int edge_low(int e)
{
    const int axis = e / 4, b = axis == 0 ? 1 : 0, c = axis == 2 ? 1 : 2;
    return (e & 1) << b | (e >> 1 & 1) << c;
}

static int edge_high(int e)
{
    return edge_low(e) | 1 << e / 4;
}

/* Bit f: both ends of the edge lie on face f. */
static int faces_of(int e)
{
    int faces = 0;
    for (int a = 0; a < 3; a++)
        for (int side = 0; side < 2; side++)
            if ((edge_low(e) >> a & 1) == side && (edge_high(e) >> a & 1) == side)
                faces |= 1 << (2 * a + side);
    return faces;
}

static int cases_of(int pattern)
{
    return 1 << __builtin_popcount(vvi_case_ambiguous[pattern]);
}

static void there_are_as_many_cases_and_triangles_as_there_should_be(void **state)
{
    (void)state;
    static const int expected[6] = {2, 16, 50, 80, 76, 32}, ambiguous[7] = {136, 72, 30, 16, 0, 0, 2};
    int histogram[13] = {0}, faces[7] = {0}, all = 0, fans = 0;
    for (int p = 0; p < 256; p++) {
        assert_int_equal(vvi_case_first[p], all);
        all += cases_of(p);
        histogram[vvi_cases[vvi_case_first[p]].n_triangles]++;
        faces[__builtin_popcount(vvi_case_ambiguous[p])]++;
    }
    assert_int_equal(all, VVI_CASES);
    assert_memory_equal(histogram, expected, sizeof expected);
    assert_memory_equal(faces, ambiguous, sizeof ambiguous);
    for (int i = 0; i < VVI_CASES; i++) {
        fans += vvi_cases[i].n_interior;
        assert_true(vvi_cases[i].n_interior || vvi_cases[i].n_triangles <= 10);
    }
    assert_int_equal(fans, 116);
}

/* In a cell, a directed edge of a triangle either has its reverse, or lies on a face and is there once. */
static void check_closed(const vvi_case *c)
{
    for (int t = 0; t < c->n_triangles; t++)
        for (int i = 0; i < 3; i++) {
            const int a = c->triangle[3 * t + i], b = c->triangle[3 * t + (i + 1) % 3];
            int same = 0, reverse = 0;
            for (int u = 0; u < c->n_triangles; u++)
                for (int k = 0; k < 3; k++) {
                    const int d = c->triangle[3 * u + k], e = c->triangle[3 * u + (k + 1) % 3];
                    same += d == a && e == b;
                    reverse += d == b && e == a;
                }
            const int shared = a < 12 && b < 12 ? faces_of(a) & faces_of(b) : 0;
            assert_int_equal(same, 1);
            assert_int_equal(reverse, shared ? 0 : 1);
            if (shared)
                assert_true(c->faces[c->loop[t]] & shared);
        }
}

static void check_case(int pattern, const vvi_case *c)
{
    int used = 0;
    for (int e = 0; e < 12; e++) {
        const bool crossed = (pattern >> edge_low(e) & 1) != (pattern >> edge_high(e) & 1);
        assert_int_equal(c->edges >> e & 1, crossed);
    }
    for (int i = 0; i < 3 * c->n_triangles; i++)
        used |= 1 << c->triangle[i];
    assert_int_equal(used, c->edges | (c->n_interior ? 1 << 12 : 0));
    check_closed(c);
}

static void triangles_use_the_crossed_edges_and_close_but_on_faces(void **state)
{
    (void)state;
    for (int p = 0; p < 256; p++)
        for (int d = 0; d < cases_of(p); d++)
            check_case(p, &vvi_cases[vvi_case_first[p] + d]);
}

static bool has_segment(const vvi_case *c, int a, int b)
{
    for (int t = 0; t < c->n_triangles; t++)
        for (int i = 0; i < 3; i++)
            if (c->triangle[3 * t + i] == a && c->triangle[3 * t + (i + 1) % 3] == b)
                return true;
    return false;
}

/* With inside and outside exchanged, and what was joined apart, the same segments lie on the faces, reversed. */
static void the_complement_has_the_same_segments_reversed(void **state)
{
    (void)state;
    for (int p = 0; p < 256; p++)
        for (int d = 0; d < cases_of(p); d++) {
            const vvi_case *c = &vvi_cases[vvi_case_first[p] + d];
            const vvi_case *complement = &vvi_cases[vvi_case_first[255 - p] + (cases_of(p) - 1 - d)];
            for (int a = 0; a < 12; a++)
                for (int b = 0; b < 12; b++)
                    if (a != b && faces_of(a) & faces_of(b))
                        assert_int_equal(has_segment(c, a, b), has_segment(complement, b, a));
        }
}

/* Two cells that share a face draw the same segments there, in opposite directions. */
static void neighbours_fit(void **state)
{
    (void)state;
    for (int axis = 0; axis < 3; axis++) {
        const int low = 2 * axis, high = low + 1;
        for (int p = 0; p < 256; p++)
            for (int q = 0; q < 256; q++) {
                bool fits = true;
                for (int corner = 0; corner < 8 && fits; corner++)
                    if (corner >> axis & 1)
                        fits = (p >> corner & 1) == (q >> (corner ^ 1 << axis) & 1);
                if (!fits)
                    continue;
                const vvi_case *c = &vvi_cases[vvi_case_first[p]], *n = &vvi_cases[vvi_case_first[q]];
                for (int a = 0; a < 12; a++)
                    for (int b = 0; b < 12; b++) {
                        if (a == b || !(faces_of(a) & faces_of(b) & 1 << high))
                            continue;
                        int other[2] = {-1, -1}; /* the same edges as the neighbour numbers them */
                        for (int e = 0; e < 12; e++)
                            if (faces_of(e) >> low & 1)
                                for (int i = 0; i < 2; i++)
                                    if (edge_low(e) == (edge_low(i ? b : a) ^ 1 << axis) &&
                                        edge_high(e) == (edge_high(i ? b : a) ^ 1 << axis))
                                        other[i] = e;
                        assert_int_equal(has_segment(c, a, b), has_segment(n, other[1], other[0]));
                    }
            }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(there_are_as_many_cases_and_triangles_as_there_should_be),
        cmocka_unit_test(triangles_use_the_crossed_edges_and_close_but_on_faces),
        cmocka_unit_test(the_complement_has_the_same_segments_reversed),
        cmocka_unit_test(neighbours_fit),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
