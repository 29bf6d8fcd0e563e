/* Surfaces as runs of bytes: read as compact.h says it, by a reader that shares nothing with what writes them, they are
 * the same triangles. */
#include "core/memory.h"
#include "fields.h"
#include "meshes.h"
#include "surface/boxes.h"
#include "surface/compact.h"
#include "surface/reduced.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static uint64_t whole(const uint8_t *at, int bytes)
{
    uint64_t value = 0;
    for (int i = bytes - 1; i >= 0; i--)
        value = value << 8 | at[i];
    return value;
}

static void read_place(double out[12], const vvi_compact *c)
{
    for (int i = 0; i < 12; i++) {
        const uint64_t bits = whole(c->bytes + 8 + 8 * i, 8);
        memcpy(&out[i], &bits, sizeof bits);
    }
}

typedef struct triangle {
    int64_t corner[3][3]; /* sixteenths of what the affine map is of */
} triangle;

static int by_bytes(const void *a, const void *b)
{
    return memcmp(a, b, sizeof(triangle));
}

/* The same corner first, whichever it was. */
static void turn(triangle *t)
{
    int first = 0;
    for (int v = 1; v < 3; v++)
        if (memcmp(t->corner[v], t->corner[first], sizeof t->corner[0]) < 0)
            first = v;
    const triangle old = *t;
    for (int v = 0; v < 3; v++)
        memcpy(t->corner[v], old.corner[(v + first) % 3], sizeof t->corner[v]);
}

/* A reader of bits, one at a time. */
static unsigned bits(const uint8_t *bytes, size_t *at, int n)
{
    unsigned value = 0;
    for (int i = 0; i < n; i++, (*at)++)
        value |= (unsigned)(bytes[*at / 8] >> *at % 8 & 1) << i;
    return value;
}

static void crossing(int64_t out[3], const unsigned cell[3], unsigned edge, unsigned q)
{
    static const int across[3][2] = {{1, 2}, {0, 2}, {0, 1}};
    const unsigned axis = edge / 4;
    for (int a = 0; a < 3; a++)
        out[a] = 16 * (int64_t)cell[a];
    out[axis] += 4 * q + 2;
    out[across[axis][0]] += 16 * (edge & 1);
    out[across[axis][1]] += 16 * (edge >> 1 & 1);
}

/* All triangles of records; free() them. */
static triangle *decode(size_t *n_out, const vvi_compact *c)
{
    const uint8_t *head = c->bytes, *counts = head + 132, *cases = head + 392;
    const size_t n_cases = whole(head + 388, 4), n_bricks = whole(head + 116, 4), n = whole(head + 124, 4);
    const uint8_t *bricks = cases + (n_cases + 3) / 4 * 4, *records = bricks + 12 * n_bricks;
    triangle *out = calloc(n + 1, sizeof *out), *to = out;
    size_t n_cells = 0;
    assert_memory_equal(head, "VVS1", 4);
    assert_int_equal(whole(head + 4, 2), 1);
    assert_int_equal(records + whole(head + 128, 4) - head, c->n);
    for (size_t b = 0; b < n_bricks; b++) {
        const uint8_t *brick = bricks + 12 * b;
        size_t bit = 8 * whole(brick + 8, 4);
        n_cells += whole(brick + 6, 2);
        for (size_t i = 0; i < whole(brick + 6, 2); i++) {
            const unsigned at = bits(records, &bit, 12), pattern = bits(records, &bit, 8);
            unsigned cell[3], q[12], first = 0;
            for (int a = 0; a < 3; a++)
                cell[a] = 16 * (unsigned)whole(brick + 2 * a, 2) + (at >> 4 * a & 15);
            for (unsigned e = 0; e < 12; e++) {
                static const int shift[3][2] = {{1, 2}, {0, 2}, {0, 1}};
                const unsigned axis = e / 4, low = (e & 1) << shift[axis][0] | (e >> 1 & 1) << shift[axis][1];
                const bool crossed = (pattern >> low & 1) != (pattern >> (low | 1u << axis) & 1);
                q[e] = crossed ? bits(records, &bit, 2) : 0;
            }
            for (unsigned p = 0; p < pattern; p++)
                first += 3u * counts[p];
            for (unsigned t = 0; t < counts[pattern]; t++, to++) {
                assert_true((size_t)(to - out) < n);
                for (unsigned v = 0; v < 3; v++) {
                    const unsigned e = cases[first + 3 * t + v];
                    crossing(to->corner[v], cell, e, q[e]);
                }
                turn(to);
            }
        }
    }
    assert_int_equal(to - out, n);
    assert_int_equal(n_cells, whole(head + 120, 4));
    *n_out = n;
    return out;
}

static triangle *of_mesh(const vv_mesh_info *m)
{
    triangle *out = calloc(m->n_triangles + 1, sizeof *out);
    for (size_t t = 0; t < m->n_triangles; t++) {
        for (size_t v = 0; v < 3; v++)
            for (size_t a = 0; a < 3; a++)
                out[t].corner[v][a] = llround(16 * (double)m->positions[3 * m->triangles[3 * t + v] + a]);
        turn(&out[t]);
    }
    return out;
}

static void check(const vv_field *f, int step, double value)
{
    const vvi_reduced_options o = {.step = step, .value = value};
    vvi_reduced *r;
    vv_mesh *mesh;
    vvi_compact c;
    double place[12];
    size_t n;
    assert_int_equal(vvi_reduced_make(&r, f, &o, NULL), VV_OK);
    for (int a = 0; a < 3; a++) { /* of a grid of its own, so that places of the mesh are whole */
        r->grid.index_to_world.axis[a] = (vv_vec3){a == 0, a == 1, a == 2};
        assert_true(r->grid.dims[a] > 0);
    }
    r->grid.index_to_world.origin = (vv_vec3){3, -4, 5};
    assert_int_equal(vvi_reduced_mesh(&mesh, r, NULL), VV_OK);
    assert_int_equal(vvi_compact_reduced(&c, r, 0xa5, true, NULL), VV_OK);
    assert_int_equal(whole(c.bytes + 6, 2), 0x1a5);
    read_place(place, &c);
    assert_true(place[0] == 1 && place[4] == 1 && place[8] == 1 && place[1] == 0);
    assert_true(place[9] == 3 && place[10] == -4 && place[11] == 5);
    for (int a = 0; a < 3; a++)
        assert_int_equal(whole(c.bytes + 104 + 4 * a, 4), r->grid.dims[a]);
    triangle *read = decode(&n, &c), *known = of_mesh(vv_mesh_get_info(mesh));
    assert_int_equal(n, vv_mesh_get_info(mesh)->n_triangles);
    qsort(read, n, sizeof *read, by_bytes);
    qsort(known, n, sizeof *known, by_bytes);
    assert_memory_equal(read, known, n * sizeof *read);
    free(read);
    free(known);
    vvi_free(c.bytes);
    vv_mesh_release(mesh);
    vvi_reduced_free(r);
}

static void records_are_read_as_the_same_triangles(void **state)
{
    (void)state;
    vv_field *sphere = test_field_cube(&test_form_sphere, 41, 0, 20, NULL);
    for (int step = 1; step <= 4; step *= 2)
        check(sphere, step, 0);
    check(sphere, 1, 1e6); /* nothing */
    vv_field_release(sphere);
    static const int64_t sizes[][3] = {{2, 2, 2}, {3, 40, 5}, {17, 33, 18}, {37, 19, 23}};
    for (size_t s = 0; s < sizeof sizes / sizeof *sizes; s++) {
        vv_field_info info = vv_field_info_default();
        memcpy(info.grid.dims, sizes[s], sizeof info.grid.dims);
        info.type = VV_TYPE_U8;
        vv_field *f = test_field_random(&info, test_seed() + s, NULL);
        check(f, 1, 180);
        vv_field_release(f);
    }
}

static void normal_of(double n[3], const uint8_t *at)
{
    const double x = (double)(int16_t)whole(at, 2) / 32767, y = (double)(int16_t)whole(at + 2, 2) / 32767;
    n[2] = 1 - fabs(x) - fabs(y);
    n[0] = n[2] < 0 ? copysign(1 - fabs(y), x) : x;
    n[1] = n[2] < 0 ? copysign(1 - fabs(x), y) : y;
    const double length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    for (int a = 0; a < 3; a++)
        n[a] /= length;
}

static void check_mesh(unsigned with)
{
    vv_mesh *mesh = test_mesh_strip(300, with);
    const vv_mesh_info *m = vv_mesh_get_info(mesh);
    const vv_bounds box = vv_mesh_bounds(mesh);
    const double side = fmax(fmax(box.hi.x - box.lo.x, box.hi.y - box.lo.y), box.hi.z - box.lo.z);
    vvi_compact c;
    double place[12];
    assert_int_equal(vvi_compact_mesh(&c, m, m->colors, NULL), VV_OK);
    assert_int_equal(c.n, vvi_compact_mesh_bytes(m->n_vertices, m->n_triangles, m->colors != NULL));
    assert_int_equal(whole(c.bytes + 4, 2), 2);
    assert_int_equal(whole(c.bytes + 6, 2), m->colors != NULL);
    assert_int_equal(whole(c.bytes + 104, 4), m->n_vertices);
    assert_int_equal(whole(c.bytes + 108, 4), m->n_triangles);
    read_place(place, &c);
    const uint8_t *at = c.bytes + 112;
    for (size_t i = 0; i < 3 * m->n_triangles; i++, at += 4)
        assert_int_equal(whole(at, 4), m->triangles[i]);
    if (m->colors)
        assert_memory_equal(at, m->colors, 4 * m->n_vertices);
    at += m->colors ? 4 * m->n_vertices : 0;
    for (size_t v = 0; v < m->n_vertices; v++, at += 10) {
        const vv_vec3 p = test_mesh_vertex(mesh, v);
        for (int a = 0; a < 3; a++) {
            const double read = place[9 + a] + place[4 * a] * (double)whole(at + 2 * a, 2);
            assert_true(fabs(read - (&p.x)[a]) <= 0.6 * side / 65535);
        }
        if (m->normals) {
            double n[3], dot = 0;
            normal_of(n, at + 6);
            for (size_t a = 0; a < 3; a++)
                dot += n[a] * (double)m->normals[3 * v + a];
            assert_true(dot > 1 - 1e-7);
        }
    }
    vvi_free(c.bytes);
    vv_mesh_release(mesh);
}

static void meshes_are_read_with_what_their_vertices_have(void **state)
{
    (void)state;
    check_mesh(0);
    check_mesh(TEST_MESH_NORMALS);
    check_mesh(TEST_MESH_NORMALS | TEST_MESH_COLORS | TEST_MESH_FAR);
    vv_mesh *none = test_mesh_strip(0, 0);
    vvi_compact c;
    assert_int_equal(vvi_compact_mesh(&c, vv_mesh_get_info(none), NULL, NULL), VV_OK);
    assert_int_equal(c.n, 112);
    vvi_free(c.bytes);
    vv_mesh_release(none);
}

/* Of a corner without a normal: no direction at all. */
static void normals_may_be_missing(void **state)
{
    (void)state;
    const float positions[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0}, normals[9] = {0, 0, 0, 0, 0, -1, 0, 0, 1};
    const uint32_t triangles[3] = {0, 1, 2};
    const vv_mesh_info mesh = {
        .n_vertices = 3, .n_triangles = 1, .positions = positions, .normals = normals, .triangles = triangles};
    vvi_compact c;
    assert_int_equal(vvi_compact_mesh(&c, &mesh, NULL, NULL), VV_OK);
    const uint8_t *at = c.bytes + 112 + 12 + 6;
    assert_int_equal(whole(at, 4), 0x80008000);
    assert_int_equal(whole(at + 10, 4), 0x7fff7fff);
    assert_int_equal(whole(at + 20, 4), 0);
    vvi_free(c.bytes);
}

static void check_boxes(const vv_field *f, int shift, int least)
{
    const vvi_surface_boxes_options o = {.value = 0, .shift = shift, .merged = true};
    const vv_grid *grid = &vv_field_get_info(f)->grid;
    vv_mesh *mesh;
    vv_field *solid;
    vvi_compact c;
    double place[12];
    size_t triangles, at = 0, faces = 0;
    assert_int_equal(vvi_surface_boxes_solid(&mesh, &solid, f, &o, NULL), VV_OK);
    assert_int_equal(vvi_compact_boxes(&c, &triangles, solid, grid, least, NULL), VV_OK);
    assert_int_equal(c.n, vvi_compact_boxes_bytes(solid));
    assert_int_equal(whole(c.bytes + 4, 4), 3);
    read_place(place, &c);
    assert_true(place[0] == grid->index_to_world.axis[0].x && place[10] == grid->index_to_world.origin.y);
    const int64_t *n = vv_field_get_info(solid)->grid.dims;
    for (int a = 0; a < 3; a++) {
        assert_int_equal(whole(c.bytes + 104 + 4 * a, 4), grid->dims[a]);
        assert_int_equal(whole(c.bytes + 120 + 4 * a, 4), n[a]);
    }
    assert_int_equal(whole(c.bytes + 116, 4), 1 << shift);
    assert_int_equal(whole(c.bytes + 132, 4), triangles);
    for (int64_t k = 0; k < n[2]; k++)
        for (int64_t j = 0; j < n[1]; j++)
            for (int64_t i = 0; i < n[0]; i++) {
                const bool is = vv_field_value(solid, i, j, k, 0) >= least;
                assert_int_equal(bits(c.bytes + 136, &at, 1), is);
                for (int d = 0; d < 6 && is; d++) {
                    int64_t q[3] = {i, j, k};
                    q[d / 2] += d & 1 ? 1 : -1;
                    faces += q[d / 2] < 0 || q[d / 2] >= n[d / 2] || vv_field_value(solid, q[0], q[1], q[2], 0) < least;
                }
            }
    assert_true(faces > 0);
    assert_int_equal(triangles, 2 * faces);
    vvi_free(c.bytes);
    vv_mesh_release(mesh);
    vv_field_release(solid);
}

static void boxes_are_a_bit_each(void **state)
{
    (void)state;
    vv_field *sphere = test_field_cube(&test_form_sphere, 41, 0, 20, NULL);
    for (int shift = 2; shift <= 3; shift++)
        for (int least = 1; least <= 2; least++)
            check_boxes(sphere, shift, least);
    vv_field_release(sphere);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(records_are_read_as_the_same_triangles),
        cmocka_unit_test(meshes_are_read_with_what_their_vertices_have),
        cmocka_unit_test(normals_may_be_missing),
        cmocka_unit_test(boxes_are_a_bit_each),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
