/* Tiny edges that collapse, surfaces that are cut apart where they touch, vertices at one place told apart. */
#include "core/memory.h"
#include "surface/place_copies.h"
#include "surface/self_contacts.h"
#include "surface/weld.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <string.h>

#include <cmocka.h>

enum { MOST = 256 };

/* Directed edges without exactly one the other way round. */
static size_t bad_edges(const uint32_t *v, size_t n)
{
    size_t bad = 0;
    for (size_t i = 0; i < n; i++) {
        size_t same = 0, turned = 0;
        const uint32_t a = v[i], b = v[i % 3 == 2 ? i - 2 : i + 1];
        for (size_t j = 0; j < n; j++) {
            const uint32_t c = v[j], d = v[j % 3 == 2 ? j - 2 : j + 1];
            same += a == c && b == d;
            turned += a == d && b == c;
        }
        bad += same != 1 || turned != 1;
    }
    return bad;
}

static const uint32_t octahedron[] = {0, 2, 4, 2, 1, 4, 1, 3, 4, 3, 0, 4, 2, 0, 5, 1, 2, 5, 3, 1, 5, 0, 3, 5};

static void place_octahedron(float *out, double radius, double x)
{
    for (size_t v = 0; v < 6; v++)
        for (size_t i = 0; i < 3; i++)
            out[3 * v + i] = (float)((v / 2 == i ? (v % 2 ? -radius : radius) : 0) + (i == 0 ? x : 0));
}

static void a_tip_of_tiny_triangles_becomes_a_point(void **state)
{
    (void)state;
    /* a pyramid over a square, whose tip is a square of 1e-6 */
    float p[3 * 8];
    static const uint32_t triangles[] = {0, 2, 1, 0, 3, 2, 4, 5, 6, 4, 6, 7, 0, 1, 5, 0, 5, 4,
                                         1, 2, 6, 1, 6, 5, 2, 3, 7, 2, 7, 6, 3, 0, 4, 3, 4, 7};
    uint32_t v[MOST];
    for (size_t i = 0; i < 8; i++) {
        const double r = i < 4 ? 1 : 1e-6, angle = M_PI / 2 * (double)(i % 4);
        p[3 * i] = (float)(r * cos(angle));
        p[3 * i + 1] = (float)(r * sin(angle));
        p[3 * i + 2] = i < 4 ? 0 : 1;
    }
    memcpy(v, triangles, sizeof triangles);
    vvi_weld weld = {.indices = v, .n_indices = 36, .positions = p, .n_vertices = 8};
    const double tiny = vvi_tiny_edge(&weld);
    assert_true(tiny > 1e-5 && tiny < 1e-3);
    assert_int_equal(vvi_weld_edges(&weld, tiny, NULL), VV_OK);
    assert_int_equal(weld.n_indices, 3 * 6);
    assert_int_equal(bad_edges(v, weld.n_indices), 0);
    weld.n_indices = 36;
    memcpy(v, triangles, sizeof triangles);
    assert_int_equal(vvi_weld_edges(&weld, 1e-9, NULL), VV_OK);
    assert_int_equal(weld.n_indices, 36);
}

static void a_tiny_piece_goes_and_a_large_one_stays(void **state)
{
    (void)state;
    float p[3 * 12];
    uint32_t v[MOST];
    place_octahedron(p, 1, 0);
    place_octahedron(p + 18, 1e-6, 5);
    for (size_t i = 0; i < 48; i++)
        v[i] = octahedron[i % 24] + (i < 24 ? 0 : 6);
    vvi_weld weld = {.indices = v, .n_indices = 48, .positions = p, .n_vertices = 12};
    assert_int_equal(vvi_weld_edges(&weld, vvi_tiny_edge(&weld), NULL), VV_OK);
    assert_int_equal(weld.n_indices, 24);
    assert_memory_equal(v, octahedron, sizeof octahedron);
}

static void a_thin_neck_is_not_pinched(void **state)
{
    (void)state;
    /* two tips that meet in a ring of four tiny edges */
    float p[3 * 6];
    uint32_t v[MOST];
    place_octahedron(p, 1e-6, 0);
    p[3 * 4 + 2] = 1;
    p[3 * 5 + 2] = -1;
    memcpy(v, octahedron, sizeof octahedron);
    vvi_weld weld = {.indices = v, .n_indices = 24, .positions = p, .n_vertices = 6};
    assert_int_equal(vvi_weld_edges(&weld, 1e-4, NULL), VV_OK);
    assert_int_equal(weld.n_indices, 3 * 6); /* a ring of three is left */
    assert_int_equal(bad_edges(v, weld.n_indices), 0);
}

static void a_locked_border_stays(void **state)
{
    (void)state;
    static const float p[] = {0, 0, 0, 1e-6F, 0, 0, 1, 0, 0, 0, 1, 0};
    static const uint32_t triangles[] = {0, 1, 3, 1, 2, 3};
    for (int lock = 0; lock < 2; lock++) {
        uint32_t v[6];
        memcpy(v, triangles, sizeof v);
        vvi_weld weld = {.indices = v, .n_indices = 6, .positions = p, .n_vertices = 4, .fix_border = lock};
        assert_int_equal(vvi_weld_edges(&weld, 1e-4, NULL), VV_OK);
        assert_int_equal(weld.n_indices, lock ? 6 : 3);
    }
}

/* Two tetrahedra with an edge (0, 1) in common. */
static const float twins[] = {0, 0, -1, 0, 0, 1, 1, 1, 0, 1, -1, 0, -1, 1, 0, -1, -1, 0};
static const uint32_t twin_triangles[] = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3, 0, 1, 4, 0, 5, 1, 0, 4, 5, 1, 5, 4};

static void solids_that_share_an_edge_come_apart(void **state)
{
    (void)state;
    uint32_t v[24];
    memcpy(v, twin_triangles, sizeof v);
    assert_int_equal(bad_edges(v, 24), 4);
    vvi_cut cut = {.indices = v, .n_indices = 24, .positions = twins, .n_vertices = 6};
    assert_int_equal(vvi_cut_apart(&cut, NULL), VV_OK);
    assert_int_equal(cut.n_copies, 2);
    assert_int_equal(cut.n_crowded, 0);
    assert_int_equal(cut.n_indices, 24);
    assert_int_equal(bad_edges(v, 24), 0);
    for (size_t i = 0; i < 24; i++) { /* nothing moves, and each tetrahedron has one of the two edges */
        const uint32_t at = v[i] < 6 ? v[i] : cut.copied[v[i] - 6];
        assert_int_equal(at, twin_triangles[i]);
        if (at < 2)
            assert_int_equal(v[i] == at, i < 12);
    }
    vvi_free(cut.copied);
}

static void solids_that_share_a_vertex_come_apart(void **state)
{
    (void)state;
    static const float p[3 * 7] = {0};
    static const uint32_t triangles[] = {0, 1, 2, 0, 2, 3, 0, 3, 1, 1, 3, 2, 0, 4, 5, 0, 5, 6, 0, 6, 4, 4, 6, 5};
    uint32_t v[24];
    memcpy(v, triangles, sizeof v);
    vvi_cut cut = {.indices = v, .n_indices = 24, .positions = p, .n_vertices = 7};
    assert_int_equal(vvi_cut_apart(&cut, NULL), VV_OK);
    assert_int_equal(cut.n_copies, 1);
    assert_int_equal(cut.copied[0], 0);
    assert_int_equal(v[12], 7);
    vvi_free(cut.copied);
}

static void triangles_back_to_back_go(void **state)
{
    (void)state;
    /* an octahedron with a wing at its edge (0, 2) */
    float p[3 * 7] = {[18] = 2, [19] = 2};
    uint32_t v[30];
    place_octahedron(p, 1, 0);
    memcpy(v, octahedron, sizeof octahedron);
    memcpy(v + 24, (const uint32_t[]){0, 2, 6, 2, 0, 6}, 6 * sizeof *v);
    vvi_cut cut = {.indices = v, .n_indices = 30, .positions = p, .n_vertices = 7};
    assert_int_equal(vvi_cut_apart(&cut, NULL), VV_OK);
    assert_int_equal(cut.n_indices, 24);
    assert_int_equal(cut.n_copies, 0);
    assert_memory_equal(v, octahedron, sizeof octahedron);
    vvi_free(cut.copied);
}

static void open_and_closed_meshes_without_such_places_stay(void **state)
{
    (void)state;
    float p[18];
    uint32_t v[24];
    place_octahedron(p, 1, 0);
    for (size_t n = 0; n <= 24; n += 3) { /* two triangles that only touch at a vertex do not occur in this order */
        if (n == 6 || n == 9)
            continue;
        memcpy(v, octahedron, sizeof v);
        vvi_cut cut = {.indices = v, .n_indices = n, .positions = p, .n_vertices = 6};
        assert_int_equal(vvi_cut_apart(&cut, NULL), VV_OK);
        assert_int_equal(cut.n_indices, n);
        assert_int_equal(cut.n_crowded, 0);
        vvi_free(cut.copied);
    }
}

static void closed_vertices_at_one_place_are_told_apart_and_seams_are_not(void **state)
{
    (void)state;
    float p[3 * 18];
    uint32_t v[MOST];
    for (size_t k = 0; k < 3; k++) { /* three at one place; the third is open: only its first triangle */
        place_octahedron(p + 18 * k, 1, 0);
        for (size_t i = 0; i < 24; i++)
            v[24 * k + i] = octahedron[i] + (uint32_t)(6 * k);
    }
    assert_int_equal(vvi_tell_apart(p, 18, v, 51, NULL), VV_OK);
    for (size_t i = 0; i < 6; i++) {
        const float *a = p + 3 * i, *b = a + 18, *c = b + 18;
        assert_true(a[0] != b[0] && fabs((double)a[0] - (double)b[0]) < 1e-6 && a[1] == b[1] && a[2] == b[2]);
        if (i == 0 || i == 2 || i == 4)
            assert_memory_equal(a, c, 3 * sizeof *a);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_tip_of_tiny_triangles_becomes_a_point),
        cmocka_unit_test(a_tiny_piece_goes_and_a_large_one_stays),
        cmocka_unit_test(a_thin_neck_is_not_pinched),
        cmocka_unit_test(a_locked_border_stays),
        cmocka_unit_test(solids_that_share_an_edge_come_apart),
        cmocka_unit_test(solids_that_share_a_vertex_come_apart),
        cmocka_unit_test(triangles_back_to_back_go),
        cmocka_unit_test(open_and_closed_meshes_without_such_places_stay),
        cmocka_unit_test(closed_vertices_at_one_place_are_told_apart_and_seams_are_not),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
