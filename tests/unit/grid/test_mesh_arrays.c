/* Meshes of arrays that a program has. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <math.h>
#include <string.h>
#include <volvis/measure_mesh.h>
#include <volvis/model.h>
#include <volvis/render.h>

/* A tetrahedron with edges of 2, 3 and 4 along the axes: its volume is 2 * 3 * 4 / 6. */
static float positions[12] = {0, 0, 0, 2, 0, 0, 0, 3, 0, 0, 0, 4};
static uint32_t triangles[12] = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};

static vv_mesh_info tetrahedron(void)
{
    return (vv_mesh_info){
        .n_vertices = 4, .n_triangles = 4, .positions = positions, .triangles = triangles, .unit = "mm"};
}

static void it_is_measured_and_is_a_copy(void **state)
{
    vv_mesh *mesh;
    vv_mesh_measures found;
    vv_mesh_info info = tetrahedron();
    info.origin = (vv_vec3){1e7, 0, 0};
    assert_int_equal(vv_mesh_new(&mesh, &info, NULL), VV_OK);
    positions[3] = 200;
    assert_int_equal(vv_mesh_measure(&found, mesh, NULL, NULL), VV_OK);
    positions[3] = 2;
    assert_true(fabs(found.volume.value - 4) < 1e-6);
    assert_true(fabs(found.area.value - (3 + 4 + 6 + sqrt(61))) < 1e-6); /* |(2,0,0)x(0,3,0)| ...: half of (12, 8, 6) */
    assert_string_equal(found.volume.unit, "mm^3");
    assert_true(found.closed && !found.inside_out);
    assert_true(found.bounds.hi.x == 1e7 + 2);
    vv_mesh_release(mesh);
}

static void what_may_be_left_out_is_there_when_it_is_given(void **state)
{
    const float normals[12] = {0, 0, 5, 0, 0, 0, 3, 0, 4, 0, -2, 0}, values[4] = {1, NAN, 3, 4};
    const uint8_t colors[16] = {9, 8, 7, 6};
    vv_mesh_part parts[2] = {{.name = "lower", .color = {1, 0, 0, 1}, .n_triangles = 1},
                             {.name = "upper", .color.a = -1, .first_triangle = 1, .n_triangles = 3}};
    vv_mesh *mesh;
    vv_mesh_info info = tetrahedron();
    info.normals = normals;
    info.values = values;
    info.colors = colors;
    info.parts = parts;
    info.n_parts = 2;
    info.unit[0] = 0;
    strcpy(info.value_name, "depth");
    assert_int_equal(vv_mesh_new(&mesh, &info, NULL), VV_OK);
    const vv_mesh_info *m = vv_mesh_get_info(mesh);
    const float unit[12] = {0, 0, 1, 0, 0, 0, 0.6f, 0, 0.8f, 0, -1, 0};
    assert_memory_equal(m->normals, unit, sizeof unit);
    assert_memory_equal(m->values, values, sizeof values);
    assert_memory_equal(m->colors, colors, sizeof colors);
    assert_memory_equal(m->parts, parts, sizeof parts);
    assert_string_equal(m->unit, "units");
    assert_string_equal(m->value_name, "depth");
    vv_mesh_release(mesh);
}

static void a_mesh_of_nothing_is_one(void **state)
{
    vv_mesh *mesh;
    assert_int_equal(vv_mesh_new(&mesh, &(vv_mesh_info){0}, NULL), VV_OK);
    assert_int_equal(vv_mesh_get_info(mesh)->n_vertices, 0);
    vv_mesh_release(mesh);
}

static void refuse(const vv_mesh_info *info, vv_status status, const char *sentence)
{
    vv_mesh *mesh = (vv_mesh *)info;
    assert_int_equal(vv_mesh_new(&mesh, info, NULL), status);
    assert_null(mesh);
    if (!strstr(vv_error_last()->message, sentence))
        fail_msg("'%s' does not say '%s'", vv_error_last()->message, sentence);
}

static void arrays_of_no_mesh_are_refused_with_what_is_wrong(void **state)
{
    vv_mesh_info info = tetrahedron();
    info.n_vertices = 3;
    refuse(&info, VV_E_ARGUMENT, "triangle 1 names vertex 3, but there are 3");
    info = tetrahedron();
    info.positions = NULL;
    refuse(&info, VV_E_ARGUMENT, "counts vertices but has no array");
    info = tetrahedron();
    info.triangles = NULL;
    refuse(&info, VV_E_ARGUMENT, "counts triangles but has no array");
    info = tetrahedron();
    info.n_parts = 1;
    refuse(&info, VV_E_ARGUMENT, "counts parts but has no array");
    info = tetrahedron();
    info.origin.y = INFINITY;
    refuse(&info, VV_E_ARGUMENT, "origin");
    info = tetrahedron();
    memset(info.unit, 'm', sizeof info.unit);
    refuse(&info, VV_E_ARGUMENT, "unit of the mesh does not end");
    info = tetrahedron();
    info.n_triangles = (size_t)UINT32_MAX + 1;
    refuse(&info, VV_E_LIMIT, "too large");
    positions[7] = NAN;
    info = tetrahedron();
    refuse(&info, VV_E_ARGUMENT, "position of vertex 2 is not finite");
    positions[7] = 3;
    const float normals[12] = {[11] = INFINITY};
    info.normals = normals;
    refuse(&info, VV_E_ARGUMENT, "normal of vertex 3 is not finite");
}

static void parts_have_all_triangles_in_their_order(void **state)
{
    vv_mesh_part parts[2] = {{.n_triangles = 2}, {.first_triangle = 2, .n_triangles = 1}};
    vv_mesh_info info = tetrahedron();
    info.parts = parts;
    info.n_parts = 2;
    refuse(&info, VV_E_ARGUMENT, "the parts have 3 of the 4 triangles");
    parts[1].first_triangle = 1;
    refuse(&info, VV_E_ARGUMENT, "part 1 has triangles 1 to 2: expected them from 2 on");
    parts[1] = (vv_mesh_part){.first_triangle = 2, .n_triangles = SIZE_MAX};
    refuse(&info, VV_E_ARGUMENT, "part 1 has triangles");
    parts[1] = (vv_mesh_part){.first_triangle = 2, .n_triangles = 2, .color.g = NAN};
    refuse(&info, VV_E_ARGUMENT, "color of part 1");
    parts[1].color.g = 0;
    memset(parts[1].name, 'x', sizeof parts[1].name);
    refuse(&info, VV_E_ARGUMENT, "name of a part");
}

static void images_are_there_with_places_on_them(void **state)
{
    const uint8_t pixels[8] = {1, 2, 3, 255, 4, 5, 6, 255};
    vv_mesh_texture texture = {.name = "a.png", .width = 2, .height = 1, .pixels = pixels};
    float coordinates[10] = {0, 0, 1, 0, 0, 1, 1, 1, 0.5f, 0.5f};
    uint32_t of[12] = {0, 1, 2, 3, 4, 0, 1, 2, 3, 4, 0, 1};
    vv_mesh_part part = {.n_triangles = 4, .color.a = -1, .texture = 1};
    vv_mesh *mesh;
    (void)state;
    vv_mesh_info info = tetrahedron();
    info.n_parts = info.n_textures = 1;
    info.parts = &part;
    info.textures = &texture;
    info.coordinates = coordinates;
    info.n_coordinates = 4;
    assert_int_equal(vv_mesh_new(&mesh, &info, NULL), VV_OK);
    const uint32_t checksum = vv_mesh_checksum(mesh);
    const vv_mesh_info *m = vv_mesh_get_info(mesh);
    assert_true(m->textures[0].pixels != pixels && m->coordinates != coordinates && !m->coordinate_of);
    assert_memory_equal(m->textures[0].pixels, pixels, sizeof pixels);
    vv_mesh_release(mesh);
    info.n_coordinates = 5;
    refuse(&info, VV_E_ARGUMENT, "5 texture coordinates were given for 4 vertices");
    info.coordinate_of = of;
    assert_int_equal(vv_mesh_new(&mesh, &info, NULL), VV_OK);
    assert_true(vv_mesh_checksum(mesh) != checksum);
    vv_mesh_release(mesh);
    of[11] = 5;
    refuse(&info, VV_E_ARGUMENT, "triangle 3 names texture coordinate 5, but there are 5");
    of[11] = 0;
    coordinates[9] = NAN;
    refuse(&info, VV_E_ARGUMENT, "texture coordinate 4 is not finite");
    coordinates[9] = 0;
    info.coordinates = NULL;
    refuse(&info, VV_E_ARGUMENT, "has no array of them");
    info.coordinates = coordinates;
    texture.wrap[1] = 3;
    refuse(&info, VV_E_ARGUMENT, "texture 0");
    texture.wrap[1] = VV_WRAP_CLAMP;
    part.texture = 2;
    refuse(&info, VV_E_ARGUMENT, "part 0 has texture 2, but there are 1");
}

static void a_world_shows_it(void **state)
{
    vv_mesh *mesh, *again;
    vv_world *world;
    vv_model *model;
    vv_image *image;
    const vv_mesh_info info = tetrahedron();
    assert_int_equal(vv_mesh_new(&mesh, &info, NULL), VV_OK);
    assert_int_equal(vv_world_for_mesh(&world, "1", mesh, NULL), VV_E_ARGUMENT);
    assert_int_equal(vv_world_for_mesh(&world, "tetra", mesh, NULL), VV_OK);
    assert_string_equal(world->unit, "mm");
    assert_int_equal(vv_model_new(&model, NULL), VV_OK);
    assert_int_equal(vv_model_replace(model, NULL, world), VV_OK);
    vv_object_release(&world->base);
    assert_int_equal(vv_model_set(model, NULL, "views.main.width", "32"), VV_OK);
    assert_int_equal(vv_model_set(model, NULL, "views.main.height", "32"), VV_OK);
    world = vv_model_snapshot(model);
    assert_int_equal(vv_render(&image, NULL, world, NULL, NULL, NULL), VV_OK);
    const float *middle = image->rgba + 4 * (16 * 32 + 16), *corner = image->rgba;
    assert_true(fabsf(middle[0] - corner[0]) > 0.05f);
    vv_image_release(image);
    vv_object_release(&world->base);
    vv_mesh_release(mesh);

    /* another in its place */
    positions[3] = 8;
    assert_int_equal(vv_mesh_new(&mesh, &info, NULL), VV_OK);
    positions[3] = 2;
    assert_int_equal(vv_model_attach_mesh(model, NULL, "no name", mesh), VV_E_ARGUMENT);
    assert_int_equal(vv_model_attach_mesh(model, NULL, "tetra", mesh), VV_OK);
    world = vv_model_snapshot(model);
    const vv_dataset *dataset = (const vv_dataset *)vv_collection_find(world->datasets, "tetra");
    assert_true(vv_dataset_is_mesh(dataset, NULL));
    assert_int_equal(vv_dataset_mesh(&again, world, dataset, NULL), VV_OK);
    assert_ptr_equal(again, mesh);
    vv_mesh_release(again);
    vv_object_release(&world->base);
    vv_mesh_release(mesh);
    assert_int_equal(vv_model_undo(model, NULL), VV_OK); /* the first one is back */
    vv_model_release(model);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(it_is_measured_and_is_a_copy),
        cmocka_unit_test(what_may_be_left_out_is_there_when_it_is_given),
        cmocka_unit_test(a_mesh_of_nothing_is_one),
        cmocka_unit_test(arrays_of_no_mesh_are_refused_with_what_is_wrong),
        cmocka_unit_test(parts_have_all_triangles_in_their_order),
        cmocka_unit_test(images_are_there_with_places_on_them),
        cmocka_unit_test(a_world_shows_it),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
