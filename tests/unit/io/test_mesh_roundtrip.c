/* Every mesh format of the table, in each of its encodings: what is written is read back, as far as the row says that
 * it can be held. */
#include "core/vec.h"
#include "io_test.h"
#include "jobs.h"
#include "meshes.h"
#include <volvis/sys/registry.h>

enum {
    NORMALS = TEST_MESH_NORMALS,
    VALUES = TEST_MESH_VALUES,
    COLORS = TEST_MESH_COLORS,
    PARTS = TEST_MESH_PARTS,
    TEXTURES = TEST_MESH_PARTS | TEST_MESH_TEXTURES
};

static const size_t sizes[] = {1, 2, 7, 1021, 4099};
static const unsigned contents[] = {0,        NORMALS,
                                    VALUES,   COLORS,
                                    PARTS,    NORMALS | VALUES | COLORS | PARTS,
                                    TEXTURES, TEXTURES | NORMALS | VALUES | COLORS};

typedef struct expectation {
    const vv_mesh_format *format;
    const char *encoding;
    const vv_mesh_info *want, *got;
} expectation;

static void check_places(const expectation *e)
{
    assert_int_equal(e->got->n_vertices, e->want->n_vertices);
    assert_int_equal(e->got->n_triangles, e->want->n_triangles);
    for (size_t i = 0; i < 3 * e->want->n_vertices; i++) {
        const double want = e->want->positions[i] + (&e->want->origin.x)[i % 3];
        const double got = e->got->positions[i] + (&e->got->origin.x)[i % 3];
        if (fabs(want - got) > 2e-7 * fabs(want))
            fail_msg("%s %s: coordinate %zu is %.17g, not %.17g", e->format->name, e->encoding, i, got, want);
    }
    assert_memory_equal(e->got->triangles, e->want->triangles, 3 * e->want->n_triangles * sizeof *e->want->triangles);
}

static void check_vertices(const expectation *e)
{
    const size_t n = e->want->n_vertices;
    assert_int_equal(e->got->normals != NULL, e->want->normals && e->format->holds & VV_MESH_HOLDS_NORMALS);
    for (size_t i = 0; e->got->normals && i < 3 * n; i++)
        assert_true(fabsf(e->got->normals[i] - e->want->normals[i]) < 1e-6f);
    assert_int_equal(e->got->values != NULL, e->want->values && e->format->holds & VV_MESH_HOLDS_VALUES);
    if (e->got->values)
        assert_memory_equal(e->got->values, e->want->values, n * sizeof(float));
    assert_int_equal(e->got->colors != NULL, e->want->colors && e->format->holds & VV_MESH_HOLDS_COLORS);
    if (e->got->colors)
        assert_memory_equal(e->got->colors, e->want->colors, 4 * n);
}

static void check_parts(const expectation *e)
{
    if (!e->want->n_parts || !(e->format->holds & VV_MESH_HOLDS_PARTS))
        return;
    assert_int_equal(e->got->n_parts, e->want->n_parts);
    for (size_t i = 0; i < e->want->n_parts; i++) {
        const vv_mesh_part *got = &e->got->parts[i], *want = &e->want->parts[i];
        assert_int_equal(got->first_triangle, want->first_triangle);
        assert_int_equal(got->n_triangles, want->n_triangles);
        assert_string_equal(got->name, want->name);
        for (int c = 0; c < 3 && e->format->holds & VV_MESH_HOLDS_PART_COLORS; c++)
            assert_true(fabs((&got->color.r)[c] - (&want->color.r)[c]) < 1e-6);
    }
}

static const float *coordinate(const vv_mesh_info *m, size_t corner)
{
    return m->coordinates + 2 * (size_t)(m->coordinate_of ? m->coordinate_of : m->triangles)[corner];
}

/* Of triangles that have an image: where each corner lies on it, and its pixels. */
static void check_textures(const expectation *e)
{
    if (!e->want->n_textures || !(e->format->holds & VV_MESH_HOLDS_TEXTURES))
        return;
    assert_true(e->got->coordinates && e->got->n_textures == e->want->n_textures);
    for (size_t i = 0; i < e->want->n_parts; i++) {
        const vv_mesh_part *got = &e->got->parts[i], *want = &e->want->parts[i];
        assert_int_equal(got->texture != 0, want->texture != 0);
        if (!want->texture)
            continue;
        const vv_mesh_texture *a = &e->got->textures[got->texture - 1], *b = &e->want->textures[want->texture - 1];
        assert_true(a->width == b->width && a->height == b->height && a->wrap[0] == b->wrap[0]);
        for (size_t p = 0; p < (size_t)a->width * (size_t)a->height; p++) {
            assert_int_equal(a->pixels[4 * p + 3], b->pixels[4 * p + 3]);
            assert_true(b->pixels[4 * p + 3] == 0 || memcmp(a->pixels + 4 * p, b->pixels + 4 * p, 4) == 0);
        }
        for (size_t k = 3 * want->first_triangle; k < 3 * (want->first_triangle + want->n_triangles); k++)
            for (int c = 0; c < 2; c++)
                assert_true(fabsf(coordinate(e->got, k)[c] - coordinate(e->want, k)[c]) < 1e-6f);
    }
}

static bool is(const expectation *e, const char *format, const char *encoding)
{
    return strcmp(e->format->name, format) == 0 && strcmp(e->encoding, encoding) == 0;
}

static void check(const expectation *e)
{
    /* colours of triangles alone, as parts; text has names of parts and no colours */
    const bool stl = strcmp(e->format->name, "stl") == 0;
    assert_int_equal(e->got->n_triangles, e->want->n_triangles);
    if (!(stl && (e->want->colors || e->want->n_parts)))
        check_places(e);
    if (!stl) {
        check_vertices(e);
        check_parts(e);
        check_textures(e);
    } else if (is(e, "stl", "ascii") && e->want->n_parts) {
        assert_int_equal(e->got->n_parts, e->want->n_parts);
    }
    if (e->format->holds & VV_MESH_HOLDS_UNIT && !is(e, "stl", "ascii") && !is(e, "off", "binary"))
        assert_string_equal(e->got->unit, e->want->unit);
    assert_int_equal(e->got->up, e->want->up);
}

static void round_trip(void **state, const vv_mesh_format *format, const char *encoding, size_t n, unsigned with)
{
    char name[64];
    vv_mesh *mesh = test_mesh_strip(n, with), *back = NULL;
    vv_mesh_write_options options;
    vv_mesh_write_options_init(&options, sizeof options);
    options.encoding = encoding;
    snprintf(name, sizeof name, "a%s", format->suffixes[0]);
    if (vv_mesh_write(io_path(state, name), mesh, &options, NULL) != VV_OK ||
        vv_mesh_read(&back, io_path(state, name), NULL, NULL) != VV_OK)
        fail_msg("%s %s, %zu triangles, contents %u: %s", format->name, encoding, n, with, vv_error_last()->message);
    const expectation e = {format, encoding ? encoding : "", vv_mesh_get_info(mesh), vv_mesh_get_info(back)};
    check(&e);
    vv_mesh_release(mesh);
    vv_mesh_release(back);
}

static void every_format_reads_back_what_it_wrote(void **state)
{
    const vv_mesh_format *const *formats = vv_registry_builtin()->mesh_formats;
    for (size_t f = 0; formats[f]; f++)
        for (size_t k = 0; k == 0 || (formats[f]->encodings && formats[f]->encodings[k]); k++)
            for (size_t s = 0; s < sizeof sizes / sizeof *sizes; s++)
                for (size_t w = 0; w < sizeof contents / sizeof *contents; w++)
                    round_trip(state, formats[f], formats[f]->encodings ? formats[f]->encodings[k] : NULL, sizes[s],
                               contents[w]);
}

static void a_mesh_without_triangles_is_written_and_read(void **state)
{
    const vv_mesh_format *const *formats = vv_registry_builtin()->mesh_formats;
    for (size_t f = 0; formats[f]; f++)
        round_trip(state, formats[f], NULL, 0, 0);
}

static void places_far_from_zero_keep_their_differences(void **state)
{
    const vv_mesh_format *const *formats = vv_registry_builtin()->mesh_formats;
    for (size_t f = 0; formats[f]; f++) {
        char name[64];
        vv_mesh *mesh = test_mesh_strip(101, TEST_MESH_FAR), *back;
        if (!(formats[f]->holds & VV_MESH_HOLDS_DOUBLES)) {
            vv_mesh_release(mesh);
            continue;
        }
        snprintf(name, sizeof name, "far%s", formats[f]->suffixes[0]);
        assert_int_equal(vv_mesh_write(io_path(state, name), mesh, NULL, NULL), VV_OK);
        assert_int_equal(vv_mesh_read(&back, io_path(state, name), NULL, NULL), VV_OK);
        for (size_t v = 0; v < 103; v++) {
            const vv_vec3 a = test_mesh_vertex(mesh, v), b = test_mesh_vertex(back, v);
            assert_true(fabs(a.x - b.x) < 1e-5 && fabs(a.y - b.y) < 1e-5 && fabs(a.z - b.z) < 1e-5);
        }
        vv_mesh_release(mesh);
        vv_mesh_release(back);
    }
}

static void lengths_are_written_in_the_unit_that_is_asked_for(void **state)
{
    vv_mesh *mesh = test_mesh_strip(7, 0), *back;
    vv_mesh_write_options options;
    vv_mesh_write_options_init(&options, sizeof options);
    options.unit = "um";
    assert_int_equal(vv_mesh_write(io_path(state, "u.ply"), mesh, &options, NULL), VV_OK);
    assert_int_equal(vv_mesh_read(&back, io_path(state, "u.ply"), NULL, NULL), VV_OK);
    assert_string_equal(vv_mesh_get_info(back)->unit, "um");
    assert_true(fabs(test_mesh_area(back) / test_mesh_area(mesh) - 1e6) < 1);
    options.unit = "furlong";
    assert_int_equal(vv_mesh_write(io_path(state, "u.ply"), mesh, &options, NULL), VV_E_ARGUMENT);
    vv_mesh_release(mesh);
    vv_mesh_release(back);
}

static vv_mesh *read_text(void **state, const char *name, const char *text)
{
    vv_mesh *mesh = NULL;
    FILE *file = fopen(io_path(state, name), "w");
    assert_non_null(file);
    fputs(text, file);
    fclose(file);
    if (vv_mesh_read(&mesh, io_path(state, name), NULL, NULL) != VV_OK)
        fail_msg("%s: %s", name, vv_error_last()->message);
    return mesh;
}

/* Files of other programs have y up in OBJ, PLY and OFF; that goes with the mesh, and its places stay as they are. */
static void what_is_up_goes_with_a_mesh(void **state)
{
    static const char obj[] = "v 0 0 0\nv 1 0 0\nv 0 2 0.5\nf 1 2 3\n", own[] = "# written by VolVis\n",
                      slicer[] = "# 3D Slicer output. SPACE=LPS\n";
    const vv_mesh_format *const *formats = vv_registry_builtin()->mesh_formats;
    char text[256];
    vv_mesh *mesh = read_text(state, "up.obj", obj);
    assert_int_equal(vv_mesh_get_info(mesh)->up, VV_UP_Y);
    for (size_t f = 0; formats[f]; f++) {
        char name[64];
        vv_mesh *back;
        snprintf(name, sizeof name, "up-again%s", formats[f]->suffixes[0]);
        assert_int_equal(vv_mesh_write(io_path(state, name), mesh, NULL, NULL), VV_OK);
        assert_int_equal(vv_mesh_read(&back, io_path(state, name), NULL, NULL), VV_OK);
        if (strcmp(formats[f]->name, "stl") != 0)
            assert_int_equal(vv_mesh_get_info(back)->up, VV_UP_Y);
        for (size_t v = 0; v < 3; v++)
            assert_true(vvi_length(vvi_sub(test_mesh_vertex(mesh, v), test_mesh_vertex(back, v))) < 1e-6);
        vv_mesh_release(back);
    }
    vv_mesh_release(mesh);
    static const char up_z[] = "# up: z\n", sentence[] = "# up to here, space for more, unit of work\n";
    const struct {
        const char *comment;
        vv_up up;
    } of[] = {{slicer, VV_UP_Z}, {own, VV_UP_Z}, {up_z, VV_UP_Z}, {sentence, VV_UP_Y}};
    for (size_t i = 0; i < sizeof of / sizeof *of; i++) {
        snprintf(text, sizeof text, "%s%s", of[i].comment, obj);
        mesh = read_text(state, "up.obj", text);
        assert_int_equal(vv_mesh_get_info(mesh)->up, of[i].up);
        assert_string_equal(vv_mesh_get_info(mesh)->unit, "units");
        vv_mesh_release(mesh);
        snprintf(text, sizeof text,
                 "ply\nformat ascii 1.0\ncomment%selement vertex 0\n"
                 "property float x\nproperty float y\nproperty float z\nend_header\n",
                 of[i].comment + 1);
        mesh = read_text(state, "up.ply", text);
        assert_int_equal(vv_mesh_get_info(mesh)->up, of[i].up);
        assert_string_equal(vv_mesh_get_info(mesh)->unit, "units");
        vv_mesh_release(mesh);
    }
    for (size_t f = 0; formats[f]; f++) /* the row says it */
        assert_int_equal(formats[f]->up, strcmp(formats[f]->name, "obj") == 0 || strcmp(formats[f]->name, "ply") == 0 ||
                                             strcmp(formats[f]->name, "off") == 0);
    mesh = read_text(state, "up.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 2 0.5\n3 0 1 2\n");
    assert_int_equal(vv_mesh_get_info(mesh)->up, VV_UP_Y);
    vv_mesh_release(mesh);
    static const char *const encodings[] = {"ascii", "binary"};
    snprintf(text, sizeof text, "%s%s", own, obj);
    mesh = read_text(state, "up.obj", text);
    for (int i = 0; i < 2; i++) {
        vv_mesh_write_options options;
        vv_mesh *back;
        vv_mesh_write_options_init(&options, sizeof options);
        options.encoding = encodings[i];
        assert_int_equal(vv_mesh_write(io_path(state, "up.off"), mesh, &options, NULL), VV_OK);
        assert_int_equal(vv_mesh_read(&back, io_path(state, "up.off"), NULL, NULL), VV_OK);
        assert_int_equal(vv_mesh_get_info(back)->up, VV_UP_Z);
        vv_mesh_release(back);
    }
    vv_mesh_release(mesh);
}

/* Words are words, wherever lines end: two triangles of a square, with what the keyword says of each vertex. */
static void off_is_read_however_its_lines_end(void **state)
{
    static const struct {
        const char *keyword, *behind; /* what stands behind each place */
        bool normals, colors;
    } kinds[] = {{"OFF", "", false, false},
                 {"COFF", " 255 0 128 255", false, true},
                 {"NOFF", " 0 0 1", true, false},
                 {"STOFF", " 0.25 0.75", false, false},
                 {"CNOFF", " 0 0 1 255 0 128 255", true, true},
                 {"NCOFF", " 0 0 1 255 0 128 255", true, true},
                 {"STCNOFF", " 0 0 1 255 0 128 255 0.25 0.75", true, true}};
    /* behind the keyword, the counts, each vertex, all of them, each face */
    static const char *const ends[][5] = {{"\n", "\n", "\n", "", "\n"},
                                          {" ", "\n", "\n", "", "\n"},
                                          {" ", " ", " ", "", " "},
                                          {"\n", " ", " ", "", " "},
                                          {"\n", "\n", " ", "\n", "\n"},
                                          {" ", " ", " ", "\n", "\n"},
                                          {" # c\n", " # c\n", " ", "# c\n\n", "\n"}};
    static const char places[4][8] = {"0 0 0", "1 0 0", "1 1 0", "0 1 0.5"};
    for (size_t k = 0; k < sizeof kinds / sizeof *kinds; k++)
        for (size_t e = 0; e < sizeof ends / sizeof *ends; e++) {
            char text[1024];
            int n = snprintf(text, sizeof text, "%s%s4 2 0%s", kinds[k].keyword, ends[e][0], ends[e][1]);
            for (int v = 0; v < 4; v++)
                n += snprintf(text + n, sizeof text - (size_t)n, "%s%s%s", places[v], kinds[k].behind, ends[e][2]);
            snprintf(text + n, sizeof text - (size_t)n, "%s3 0 1 2%s3 0 2 3%s", ends[e][3], ends[e][4], ends[e][4]);
            vv_mesh *mesh = read_text(state, "lines.off", text);
            const vv_mesh_info *m = vv_mesh_get_info(mesh);
            assert_int_equal(m->n_vertices, 4);
            assert_int_equal(m->n_triangles, 2);
            assert_true(m->positions[3] == 1 && m->positions[11] == 0.5F);
            assert_int_equal(m->triangles[5], 3);
            assert_true(!m->normals == !kinds[k].normals && !m->colors == !kinds[k].colors);
            assert_true(!m->normals || m->normals[11] == 1);
            assert_true(!m->colors || (m->colors[12] == 255 && m->colors[14] == 128));
            vv_mesh_release(mesh);
        }
}

static void compressed_files_are_written_and_read(void **state)
{
    vv_mesh *mesh = test_mesh_strip(101, NORMALS), *back;
    assert_int_equal(vv_mesh_write(io_path(state, "a.ply.gz"), mesh, NULL, NULL), VV_OK);
    assert_int_equal(vv_mesh_read(&back, io_path(state, "a.ply.gz"), NULL, NULL), VV_OK);
    assert_memory_equal(vv_mesh_get_info(back)->positions, vv_mesh_get_info(mesh)->positions, 103 * 3 * sizeof(float));
    vv_mesh_release(mesh);
    vv_mesh_release(back);
}

static void vertices_of_stl_are_joined_bit_for_bit(void **state)
{
    /* a tetrahedron, one of whose corners is at a negative zero in one triangle */
    static const char text[] =
        "solid t\nfacet normal 0 0 0\nouter loop\nvertex 0 0 0\nvertex 0 1 0\nvertex 1 0 0\nendloop\nendfacet\n"
        "facet normal 0 0 0\nouter loop\nvertex -0 0 0\nvertex 1 0 0\nvertex 0 0 1\nendloop\nendfacet\n"
        "facet normal 0 0 0\nouter loop\nvertex 0 0 0\nvertex 0 0 1\nvertex 0 1 0\nendloop\nendfacet\n"
        "facet normal 0 0 0\nouter loop\nvertex 1 0 0\nvertex 0 1 0\nvertex 0 0 1\nendloop\nendfacet\nendsolid t\n";
    vv_mesh *mesh;
    vv_mesh_topology t;
    io_put_text(io_path(state, "t.stl"), text);
    assert_int_equal(vv_mesh_read(&mesh, io_path(state, "t.stl"), NULL, NULL), VV_OK);
    assert_int_equal(vv_mesh_get_info(mesh)->n_vertices, 4);
    assert_int_equal(vv_mesh_count_topology(&t, mesh, NULL), VV_OK);
    assert_int_equal(t.n_open_edges + t.n_crowded_edges + t.n_turned_edges + t.n_degenerate + t.n_unused, 0);
    assert_int_equal(t.n_edges, 6);
    assert_int_equal(t.n_pieces, 1);
    assert_true(fabs(test_mesh_volume(mesh) - 1.0 / 6) < 1e-12);
    vv_mesh_release(mesh);
}

static void a_concave_polygon_keeps_its_area(void **state)
{
    /* an arrow head of area 2 - 1 = 1 seen from above; a fan from its first corner would be larger */
    io_put_text(io_path(state, "p.ply"),
                "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
                "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n2 1 0\n0 2 0\n1 1 0\n"
                "4 0 1 2 3\n");
    vv_mesh *mesh;
    assert_int_equal(vv_mesh_read(&mesh, io_path(state, "p.ply"), NULL, NULL), VV_OK);
    assert_int_equal(vv_mesh_get_info(mesh)->n_triangles, 2);
    assert_true(fabs(test_mesh_area(mesh) - 1) < 1e-12);
    vv_mesh_release(mesh);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(every_format_reads_back_what_it_wrote, io_setup, io_teardown),
        cmocka_unit_test_setup_teardown(a_mesh_without_triangles_is_written_and_read, io_setup, io_teardown),
        cmocka_unit_test_setup_teardown(places_far_from_zero_keep_their_differences, io_setup, io_teardown),
        cmocka_unit_test_setup_teardown(lengths_are_written_in_the_unit_that_is_asked_for, io_setup, io_teardown),
        cmocka_unit_test_setup_teardown(what_is_up_goes_with_a_mesh, io_setup, io_teardown),
        cmocka_unit_test_setup_teardown(off_is_read_however_its_lines_end, io_setup, io_teardown),
        cmocka_unit_test_setup_teardown(compressed_files_are_written_and_read, io_setup, io_teardown),
        cmocka_unit_test_setup_teardown(vertices_of_stl_are_joined_bit_for_bit, io_setup, io_teardown),
        cmocka_unit_test_setup_teardown(a_concave_polygon_keeps_its_area, io_setup, io_teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
