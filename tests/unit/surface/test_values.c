/* Surfaces of several values, and values of another field at vertices, which a formula knows. */
#include "fail_alloc.h"
#include "fields.h"
#include "jobs.h"
#include "meshes.h"
#include "surface/joined_mesh.h"
#include "surface/marching.h"
#include "surface/values.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <string.h>

#include <cmocka.h>

static vv_field *sphere(void)
{
    vv_field_info info = vv_field_info_default();
    info.type = VV_TYPE_F32;
    info.grid.dims[0] = 29, info.grid.dims[1] = 31, info.grid.dims[2] = 27;
    info.grid.index_to_world = (vv_affine){{{.6, 0, 0}, {0, .6, 0}, {0, 0, .8}}, {-1, -1, -1}};
    strcpy(info.grid.unit, "mm");
    return test_field(&test_form_sphere, &info, NULL);
}

static void each_value_is_a_part(void **state)
{
    (void)state;
    static const double values[] = {0, -1.5, 100, .25};
    static const char *const names[] = {"0", "-1.5", "100", "0.25"};
    vv_field *f = sphere();
    vv_job *job = test_job(3, 0);
    vvi_marching_options o = {.value = NAN};
    vv_mesh *all, *one;
    assert_int_equal(vvi_marching_values(&all, f, values, 4, &o, job), VV_OK);
    const vv_mesh_info *m = vv_mesh_get_info(all);
    assert_int_equal(m->n_parts, 4);
    size_t vertex = 0, triangle = 0;
    for (size_t i = 0; i < 4; i++) {
        o.value = values[i];
        assert_int_equal(vvi_marching_cubes(&one, f, &o, NULL), VV_OK);
        const vv_mesh_info *n = vv_mesh_get_info(one);
        assert_string_equal(m->parts[i].name, names[i]);
        assert_true(m->parts[i].color.a < 0);
        assert_int_equal(m->parts[i].first_triangle, triangle);
        assert_int_equal(m->parts[i].n_triangles, n->n_triangles);
        assert_memory_equal(m->positions + 3 * vertex, n->positions, 12 * n->n_vertices);
        assert_memory_equal(m->normals + 3 * vertex, n->normals, 12 * n->n_vertices);
        for (size_t t = 0; t < 3 * n->n_triangles; t++)
            assert_int_equal(m->triangles[3 * triangle + t], n->triangles[t] + vertex);
        vertex += n->n_vertices;
        triangle += n->n_triangles;
        vv_mesh_release(one);
    }
    assert_int_equal(m->n_vertices, vertex);
    assert_int_equal(m->n_triangles, triangle);
    assert_int_equal(vvi_marching_values(&one, f, values, 0, &o, job), VV_E_ARGUMENT);
    assert_int_equal(vvi_marching_values(&one, f, (const double[]){0, NAN}, 2, &o, job), VV_E_ARGUMENT);
    assert_null(one);
    vv_mesh_release(all);
    vv_job_release(job);
    vv_field_release(f);
}

/* Meshes with other origins lie where they lay. */
static void joined_meshes_stay_in_place(void **state)
{
    (void)state;
    vv_field *f = sphere();
    vv_mesh *meshes[2], *both;
    vv_mesh_part parts[2] = {{.name = "a", .color = {1, 0, 0, 1}}, {.name = "b", .color.a = -1}};
    vvi_marching_options o = {.value = -1};
    assert_int_equal(vvi_marching_cubes(&meshes[0], f, &o, NULL), VV_OK);
    o.box = (vv_box){{9, 10, 3}, {15, 14, 20}};
    o.no_normals = true;
    assert_int_equal(vvi_marching_cubes(&meshes[1], f, &o, NULL), VV_OK);
    assert_int_equal(vvi_mesh_join(&both, meshes, parts, 2, NULL), VV_OK);
    const vv_mesh_info *m = vv_mesh_get_info(both);
    const size_t first = vv_mesh_get_info(meshes[0])->n_vertices;
    assert_null(m->normals);
    assert_true(m->parts[0].color.r == 1);
    for (size_t v = 0; v < m->n_vertices; v++) {
        const vv_vec3 p = test_mesh_vertex(both, v);
        const vv_vec3 q = v < first ? test_mesh_vertex(meshes[0], v) : test_mesh_vertex(meshes[1], v - first);
        assert_true(hypot(hypot(p.x - q.x, p.y - q.y), p.z - q.z) < 1e-5);
    }
    vv_mesh_release(both);
    vv_mesh_release(meshes[0]);
    vv_mesh_release(meshes[1]);
    vv_field_release(f);
}

/* A ramp on another grid is exact between samples; beyond it there is nothing. */
static void another_field_gives_its_values(void **state)
{
    (void)state;
    vv_field *f = sphere();
    vv_field_info info = vv_field_info_default();
    info.type = VV_TYPE_F64;
    info.grid.dims[0] = 9, info.grid.dims[1] = 20, info.grid.dims[2] = 30;
    info.grid.index_to_world = (vv_affine){{{.9, .3, 0}, {-.2, 1.1, .1}, {0, 0, 1.3}}, {5, -3, -4}};
    strcpy(info.grid.unit, "mm");
    strcpy(info.name, "ramp");
    strcpy(info.value_unit, "K");
    vv_field *ramp = test_field(&test_form_ramp, &info, NULL);
    const vvi_marching_options o = {.value = 0};
    vv_affine to_index;
    vv_mesh *mesh;
    size_t inside = 0, outside = 0;
    assert_true(vv_affine_invert(&to_index, info.grid.index_to_world));
    assert_int_equal(vvi_marching_cubes(&mesh, f, &o, NULL), VV_OK);
    assert_int_equal(vvi_mesh_sample(mesh, ramp, 0, NULL), VV_OK);
    const vv_mesh_info *m = vv_mesh_get_info(mesh);
    assert_string_equal(m->value_name, "ramp");
    assert_string_equal(m->value_unit, "K");
    for (size_t v = 0; v < m->n_vertices; v++) {
        const vv_vec3 p = test_mesh_vertex(mesh, v), i = vv_affine_point(to_index, p);
        const double at[3] = {i.x, i.y, i.z};
        double beyond = 0;
        for (int a = 0; a < 3; a++)
            beyond = fmax(beyond, fmax(-at[a], at[a] - (double)(info.grid.dims[a] - 1)));
        if (beyond <= 0) {
            assert_true(fabs((double)m->values[v] - test_form_ramp.value(p)) < 1e-5);
            inside++;
        } else if (beyond > .5) {
            assert_true(isnan(m->values[v]));
            outside++;
        }
    }
    assert_true(inside > 100 && outside > 100);
    assert_int_equal(vvi_mesh_sample(mesh, ramp, 1, NULL), VV_E_ARGUMENT);
    strcpy(info.grid.unit, "um");
    vv_field *other = test_field(&test_form_ramp, &info, NULL);
    assert_int_equal(vvi_mesh_sample(mesh, other, 0, NULL), VV_E_ARGUMENT);
    vv_field_release(other);
    vv_mesh_release(mesh);
    vv_field_release(ramp);
    vv_field_release(f);
}

static vv_status make_once(void *user)
{
    static const double values[] = {0, -1};
    const vvi_marching_options o = {.value = 0};
    vv_mesh *mesh;
    vv_status st = vvi_marching_values(&mesh, user, values, 2, &o, NULL);
    if (st == VV_OK)
        st = vvi_mesh_sample(mesh, user, 0, NULL);
    vv_mesh_release(mesh);
    return st;
}

static void without_memory_it_fails_cleanly(void **state)
{
    (void)state;
    vv_field *f = sphere();
    assert_true(test_fail_each_alloc(make_once, f) > 10);
    vv_field_release(f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(each_value_is_a_part),
        cmocka_unit_test(joined_meshes_stay_in_place),
        cmocka_unit_test(another_field_gives_its_values),
        cmocka_unit_test(without_memory_it_fails_cleanly),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
