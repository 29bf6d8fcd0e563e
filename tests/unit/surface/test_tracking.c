/* Surface tracking: the piece through a place is, bit for bit, a piece of the whole surface. */
#include "fail_alloc.h"
#include "fields.h"
#include "grid/field.h"
#include "jobs.h"
#include "mesh_pieces.h"
#include "meshes.h"
#include "surface/tracking.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static vv_field_info info_of(int64_t nx, int64_t ny, int64_t nz, vv_type type)
{
    vv_field_info info = vv_field_info_default();
    info.grid.dims[0] = nx, info.grid.dims[1] = ny, info.grid.dims[2] = nz;
    info.type = type;
    return info;
}

static vv_mesh *track(const vv_field *f, vv_vec3 seed, const vvi_marching_options *surface, vv_job *job)
{
    const vvi_tracking_options options = {.surface = *surface, .seed = seed};
    vv_mesh *mesh;
    assert_int_equal(vvi_track_surface(&mesh, f, &options, job), VV_OK);
    return mesh;
}

static void assert_same_triangles(const vv_mesh *piece, const vv_mesh *whole, const uint32_t *pieces, uint32_t which)
{
    size_t n, expected;
    test_triangle *a = test_mesh_triangles(piece, NULL, UINT32_MAX, &n);
    test_triangle *b = test_mesh_triangles(whole, pieces, which, &expected);
    assert_int_equal(n, expected);
    assert_memory_equal(a, b, n * sizeof *a);
    free(a);
    free(b);
}

/* Every piece of a surface is found from a vertex of it. */
static size_t assert_all_pieces(const vv_field *f, const vvi_marching_options *surface, size_t most)
{
    vv_mesh *whole;
    size_t n_pieces, tried = 0;
    assert_int_equal(vvi_marching_cubes(&whole, f, surface, NULL), VV_OK);
    uint32_t *pieces = test_mesh_pieces(whole, &n_pieces);
    for (uint32_t v = 0; v < vv_mesh_get_info(whole)->n_vertices && tried < most; v++) {
        size_t n, n_vertices = 0;
        if (pieces[v] != v)
            continue;
        free(test_mesh_triangles(whole, pieces, v, &n));
        if (!n) /* a vertex between missing samples, in no triangle */
            continue;
        vv_mesh *piece = track(f, test_mesh_vertex(whole, v), surface, NULL);
        assert_same_triangles(piece, whole, pieces, v);
        for (uint32_t u = 0; u < vv_mesh_get_info(whole)->n_vertices; u++)
            n_vertices += pieces[u] == v;
        assert_int_equal(vv_mesh_get_info(piece)->n_vertices, n_vertices);
        free(test_mesh_pieces(piece, &n));
        assert_int_equal(n, 1);
        vv_mesh_release(piece);
        tried++;
    }
    free(pieces);
    vv_mesh_release(whole);
    return n_pieces;
}

static void every_piece_of_noise_is_found_bit_for_bit(void **state)
{
    (void)state;
    static const int64_t sizes[][3] = {{17, 19, 23}, {2, 2, 2}, {3, 40, 5}, {67, 4, 9}};
    for (int type = 0; type < VV_TYPE_COUNT; type++)
        for (size_t s = 0; s < sizeof sizes / sizeof *sizes; s++)
            for (int way = 0; way < 4; way++) {
                const vv_field_info info = info_of(sizes[s][0], sizes[s][1], sizes[s][2], (vv_type)type);
                vv_field *f = test_field_random(&info, test_seed() + s, NULL);
                const double ends = vvi_type_min(info.type) * .15 + vvi_type_max(info.type) * .85;
                const double value = vv_type_is_float(info.type) ? 700 : ends;
                const vvi_marching_options o = {
                    .value = value, .topology = (vvi_marching_topology)(way & 1), .cap = way >> 1};
                assert_all_pieces(f, &o, 12);
                vv_field_release(f);
            }
}

/* Falling values turn inside and outside round, a mirrored grid turns triangles over, holes have no cells. */
static void other_placements_and_missing_samples_do_no_harm(void **state)
{
    (void)state;
    static const vv_type types[] = {VV_TYPE_U8, VV_TYPE_I16, VV_TYPE_F32, VV_TYPE_F64};
    for (size_t t = 0; t < sizeof types / sizeof *types; t++) {
        vv_field_info info = info_of(18, 21, 35, types[t]);
        info.value_scale = -.5;
        info.value_offset = 7;
        info.grid.index_to_world = (vv_affine){{{.5, 0, 0}, {.1, .6, 0}, {0, -.1, -.9}}, {-16, 120, 13.5}};
        vv_field *f;
        void *samples;
        double v[18 * 21 * 35];
        assert_int_equal(vv_field_new_empty(&f, &samples, &info, NULL), VV_OK);
        for (size_t i = 0; i < sizeof v / sizeof *v; i++) {
            v[i] = (double)(test_random(test_seed(), i) % 100);
            if (types[t] == VV_TYPE_F32 && i % 37 == 5)
                v[i] = NAN;
        }
        vvi_samples_from_f64(samples, v, info.type, sizeof v / sizeof *v);
        for (int way = 0; way < 2; way++) {
            const vvi_marching_options o = {.value = way ? -30 : 5, .no_normals = way};
            assert_all_pieces(f, &o, 10);
        }
        vv_field_release(f);
    }
}

static double two_spheres(vv_vec3 p)
{
    return fmax(10 - hypot(hypot(p.x - 12, p.y), p.z), 8 - hypot(hypot(p.x + 12, p.y), p.z));
}

static double one_sphere(vv_vec3 p)
{
    return 8 - hypot(hypot(p.x + 12, p.y), p.z);
}

static vv_field *cube_of(double (*value)(vv_vec3), int64_t half)
{
    const test_form form = {.name = "shape", .value = value};
    vv_field_info info = info_of(2 * half + 1, 2 * half + 1, 2 * half + 1, VV_TYPE_F32);
    info.grid.index_to_world.origin = (vv_vec3){(double)-half, (double)-half, (double)-half};
    return test_field(&form, &info, NULL);
}

static void one_of_two_spheres_is_that_sphere_alone(void **state)
{
    (void)state;
    static const vv_vec3 seeds[] = {{-4, 0, 0}, {-12, 8.3, .2}, {-3, -2, 1}, {-12, 0, -8}};
    const vvi_marching_options o = {.value = 0};
    vv_field *two = cube_of(two_spheres, 25), *alone = cube_of(one_sphere, 25);
    vv_mesh *expected, *first = NULL;
    assert_int_equal(vvi_marching_cubes(&expected, alone, &o, NULL), VV_OK);
    for (int i = 0; i < 4; i++) {
        vv_job *job = test_job(1 << i, 0);
        vv_mesh *piece = track(two, seeds[i], &o, job);
        const vv_mesh_info *m = vv_mesh_get_info(piece), *n = first ? vv_mesh_get_info(first) : m;
        assert_int_equal(test_mesh_euler(piece), 2);
        assert_int_equal(test_mesh_bad_edges(piece), 0);
        assert_same_triangles(piece, expected, NULL, UINT32_MAX);
        assert_memory_equal(m->positions, n->positions, 12 * m->n_vertices);
        assert_memory_equal(m->triangles, n->triangles, 12 * m->n_triangles);
        vv_job_release(job);
        if (first)
            vv_mesh_release(piece);
        else
            first = piece;
    }
    vv_mesh_release(first);
    vv_mesh_release(expected);
    vv_field_release(two);
    vv_field_release(alone);
}

/* Two sheets through the same cells: planes of one voxel's thickness. */
static double slab(vv_vec3 p)
{
    return .3 - fabs(p.z - .5);
}

static void two_sheets_in_one_cell_stay_apart(void **state)
{
    (void)state;
    vv_field *f = cube_of(slab, 9);
    float *samples;
    vv_brick b;
    const vv_box all = vv_field_box(f);
    assert_int_equal(vv_field_brick(&b, f, &all, NULL), VV_OK);
    samples = (float *)(uintptr_t)b.data;
    for (size_t i = 0; i < 19 * 19 * 19; i++) /* inside at opposite corners of every second cell of a layer */
        samples[i] = -1;
    for (int64_t j = 2; j < 16; j += 3)
        for (int64_t i = 2; i < 16; i += 3) {
            samples[(9 * 19 + j) * 19 + i] = .2f;
            samples[(10 * 19 + j + 1) * 19 + i + 1] = .3f;
        }
    vv_brick_release(&b);
    const vvi_marching_options o = {.value = 0};
    assert_int_equal(assert_all_pieces(f, &o, 100), 50);
    vv_field_release(f);
}

static void the_nearest_piece_within_reach_is_taken(void **state)
{
    (void)state;
    vv_field *two = cube_of(two_spheres, 25);
    vvi_tracking_options o = {.surface = {.value = 0}, .seed = {-12, 0, 0}, .reach = 3};
    vv_mesh *mesh;
    assert_int_equal(vvi_track_surface(&mesh, two, &o, NULL), VV_E_NOT_FOUND);
    assert_null(mesh);
    o.reach = 0;
    o.seed = (vv_vec3){-300, 2, 1};
    assert_int_equal(vvi_track_surface(&mesh, two, &o, NULL), VV_OK);
    assert_true(vv_mesh_bounds(mesh).hi.x < 0);
    vv_mesh_release(mesh);
    o.seed.y = NAN;
    assert_int_equal(vvi_track_surface(&mesh, two, &o, NULL), VV_E_ARGUMENT);
    o.seed.y = 0;
    o.surface.value = 1e6;
    assert_int_equal(vvi_track_surface(&mesh, two, &o, NULL), VV_E_NOT_FOUND);
    vv_field_release(two);
}

/* The box is a volume of its own. */
static void a_box_is_kept_to(void **state)
{
    (void)state;
    vv_field *two = cube_of(two_spheres, 25);
    vvi_marching_options o = {.value = 0, .cap = true, .box = {{26, 3, 5}, {20, 40, 39}}};
    vv_mesh *mesh;
    assert_int_equal(vvi_marching_cubes(&mesh, two, &o, NULL), VV_OK);
    const vv_bounds b = vv_mesh_bounds(mesh);
    assert_true(b.lo.x >= 1 && b.hi.x <= 20.00001 && b.hi.x > 19.9);
    assert_int_equal(test_mesh_bad_edges(mesh), 0);
    assert_int_equal(test_mesh_euler(mesh), 2);
    vv_mesh *piece = track(two, (vv_vec3){12, 0, 0}, &o, NULL);
    assert_same_triangles(piece, mesh, NULL, UINT32_MAX);
    vv_mesh_release(piece);
    vv_mesh_release(mesh);
    o.box.n[1] = 60;
    assert_int_equal(vvi_marching_cubes(&mesh, two, &o, NULL), VV_E_ARGUMENT);
    vv_field_release(two);
}

/* Of a large volume with a small piece only little is looked at: no more memory than the limit. */
static void memory_follows_the_piece(void **state)
{
    (void)state;
    vv_field *f = cube_of(two_spheres, 60);
    vv_job *job = test_job(1, 2 << 20);
    const vvi_marching_options o = {.value = 0};
    vv_mesh *mesh = track(f, (vv_vec3){-12, 8, 0}, &o, job);
    vv_mesh_release(mesh);
    vv_job_release(job);
    vv_field_release(f);
}

static vv_status track_once(void *user)
{
    const vvi_tracking_options o = {.surface = {.value = 0}, .seed = {-4, 0, 0}};
    vv_mesh *mesh;
    const vv_status st = vvi_track_surface(&mesh, user, &o, NULL);
    vv_mesh_release(mesh);
    return st;
}

static void without_memory_it_fails_cleanly(void **state)
{
    (void)state;
    vv_field *two = cube_of(two_spheres, 25);
    assert_true(test_fail_each_alloc(track_once, two) > 5);
    vv_field_release(two);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_piece_of_noise_is_found_bit_for_bit),
        cmocka_unit_test(other_placements_and_missing_samples_do_no_harm),
        cmocka_unit_test(one_of_two_spheres_is_that_sphere_alone),
        cmocka_unit_test(two_sheets_in_one_cell_stay_apart),
        cmocka_unit_test(the_nearest_piece_within_reach_is_taken),
        cmocka_unit_test(a_box_is_kept_to),
        cmocka_unit_test(memory_follows_the_piece),
        cmocka_unit_test(without_memory_it_fails_cleanly),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
