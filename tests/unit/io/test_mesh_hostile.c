/* Mesh files that are cut, changed or lie about their counts: refused in one sentence, or read as a sound mesh, within
 * little memory; every failing allocation too. */
#include "fail_alloc.h"
#include "io/notes.h"
#include "io/source.h"
#include "io_test.h"
#include "jobs.h"
#include "meshes.h"
#include <volvis/sys/registry.h>

enum { MUTANTS = 1500, ALL = TEST_MESH_NORMALS | TEST_MESH_VALUES | TEST_MESH_COLORS | TEST_MESH_PARTS };

static void check_mesh(const vv_mesh *mesh)
{
    const vv_mesh_info *m = vv_mesh_get_info(mesh);
    size_t next = 0;
    for (size_t i = 0; i < 3 * m->n_triangles; i++)
        assert_true(m->triangles[i] < m->n_vertices);
    for (size_t i = 0; i < 3 * m->n_vertices; i++)
        assert_true(isfinite(m->positions[i]));
    for (size_t i = 0; i < m->n_parts; i++) {
        assert_int_equal(m->parts[i].first_triangle, next);
        next += m->parts[i].n_triangles;
    }
    if (m->n_parts)
        assert_int_equal(next, m->n_triangles);
}

/* A sound mesh, or one sentence. */
static vv_status read_bytes(const vv_mesh_format *format, const void *data, size_t n, vv_job *job)
{
    vv_source *source;
    vv_notes *notes = NULL;
    vv_mesh *mesh = NULL;
    vv_mesh_read_options options;
    vv_mesh_read_options_init(&options, sizeof options);
    options.unit = "mm";
    vv_status st = vvi_source_memory(&source, data, n, "bytes", job);
    if (st != VV_OK)
        return st;
    if ((st = vvi_notes_new(&notes, job)) == VV_OK)
        st = format->read(&mesh, source, &options, notes, job);
    if (st == VV_OK) {
        check_mesh(mesh);
    } else {
        assert_null(mesh);
        assert_true(vv_error_last()->message[0] && !strchr(vv_error_last()->message, '\n'));
    }
    vv_mesh_release(mesh);
    vvi_notes_free(notes);
    vvi_source_close(source);
    return st;
}

static uint8_t *seed_of(void **state, const vv_mesh_format *format, const char *encoding, size_t *n)
{
    vv_mesh *mesh = test_mesh_strip(7, ALL);
    vv_mesh_write_options options;
    vv_mesh_write_options_init(&options, sizeof options);
    options.format = format->name;
    options.encoding = encoding;
    assert_int_equal(vv_mesh_write(io_path(state, "seed"), mesh, &options, NULL), VV_OK);
    vv_mesh_release(mesh);
    return io_get(io_path(state, "seed"), n);
}

typedef void each_seed(const vv_mesh_format *format, const uint8_t *data, size_t n, vv_job *job);

static void for_each_seed(void **state, each_seed *act)
{
    const vv_mesh_format *const *formats = vv_registry_builtin()->mesh_formats;
    vv_job *job = test_job(1, (uint64_t)64 << 20);
    for (size_t f = 0; formats[f]; f++)
        for (size_t k = 0; k == 0 || (formats[f]->encodings && formats[f]->encodings[k]); k++) {
            size_t n;
            uint8_t *data = seed_of(state, formats[f], formats[f]->encodings ? formats[f]->encodings[k] : NULL, &n);
            const vv_status st = read_bytes(formats[f], data, n, job);
            if (st != VV_E_READ) { /* its numbers lie in another file */
                assert_int_equal(st, VV_OK);
                act(formats[f], data, n, job);
            }
            free(data);
        }
    vv_job_release(job);
}

/* What is cut may still be a mesh: text has no end of its own. The bytes end where the memory does. */
static void cut_everywhere(const vv_mesh_format *format, const uint8_t *data, size_t n, vv_job *job)
{
    for (size_t cut = 0; cut < n; cut++) {
        uint8_t *part = malloc(cut ? cut : 1);
        memcpy(part, data, cut);
        const vv_status st = read_bytes(format, part, cut, job);
        assert_true(st == VV_OK || st == VV_E_FORMAT || st == VV_E_UNSUPPORTED || st == VV_E_LIMIT);
        free(part);
    }
}

static void files_that_are_cut_are_refused_or_read(void **state)
{
    for_each_seed(state, cut_everywhere);
}

static uint32_t next_random(uint32_t *seed)
{
    *seed ^= *seed << 13;
    *seed ^= *seed >> 17;
    *seed ^= *seed << 5;
    return *seed;
}

/* A few bytes become others: digits in text, extremes, anything. */
static void mutate(const vv_mesh_format *format, const uint8_t *data, size_t n, vv_job *job)
{
    static const uint8_t chosen[] = {0, 255, 127, 128, '9', '-', ' ', '\n', '"', '<', '{', '.', 'e', '0'};
    uint32_t seed = 1234567u;
    uint8_t *copy = malloc(n);
    for (int i = 0; i < MUTANTS; i++) {
        memcpy(copy, data, n);
        for (uint32_t k = 1 + next_random(&seed) % 4; k > 0; k--) {
            const uint32_t how = next_random(&seed), at = next_random(&seed) % (how % 2 && n > 256 ? 256 : (uint32_t)n);
            copy[at] = how % 3 ? chosen[next_random(&seed) % sizeof chosen] : (uint8_t)next_random(&seed);
        }
        read_bytes(format, copy, n, job);
    }
    free(copy);
}

static void files_that_are_changed_are_refused_or_read(void **state)
{
    for_each_seed(state, mutate);
}

typedef struct attempt {
    const vv_mesh_format *format;
    const uint8_t *data;
    size_t n;
} attempt;

static vv_status try_to_read(void *user)
{
    const attempt *a = user;
    return read_bytes(a->format, a->data, a->n, NULL);
}

static void fail_each(const vv_mesh_format *format, const uint8_t *data, size_t n, vv_job *job)
{
    (void)job;
    attempt a = {format, data, n};
    assert_true(test_fail_each_alloc(try_to_read, &a) > 0);
}

static void failing_allocations_are_told(void **state)
{
    for_each_seed(state, fail_each);
}

static const struct {
    const char *format, *text, *said;
} refused[] = {
    {"ply",
     "ply\nformat ascii 1.0\nelement vertex 99999999999\nproperty float x\nproperty float y\nproperty float z\n"
     "end_header\n",
     "99999999999 of 'vertex' take at least"},
    {"ply",
     "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\nend_header\n"
     "1 2 3\n",
     "point clouds"},
    {"ply",
     "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face "
     "1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n",
     "names vertex 3, but the file has only 3"},
    {"ply",
     "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face "
     "1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 nan 0\n0 1 0\n3 0 1 2\n",
     "vertex 1 has a position that is not a number"},
    {"ply",
     "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face "
     "1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n2 0 1\n",
     "has 2 corners"},
    {"stl", "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nendloop\nendfacet\n",
     "ends with 2 vertices"},
    {"stl", "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 x\n", "found 'x' where a coordinate"},
    {"off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 7\n", "a vertex of a face is 7"},
    {"off", "OFF\n2000000000 1 0\n0 0 0\n", "take at least"},
    {"obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n", "4: a face names vertex '4', but 3 came before it, counted from 1"},
    {"obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2\n", "a face has 2 corners"},
    {"obj", "v 0 0\n", "a vertex has 2 numbers"},
    {"gltf", "{\"asset\":{}}", "its 'asset' has no version"},
    {"gltf", "{\"asset\":{\"version\":\"2.0\"},\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"children\":[0]}]}",
     "has two parents"},
    {"gltf",
     "{\"asset\":{\"version\":\"2.0\"},\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"mesh\":0}],\"meshes\":[{"
     "\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}],\"accessors\":[{\"bufferView\":0,\"componentType\":5126,"
     "\"count\":1000000000,\"type\":\"VEC3\"}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":12}],\"buffers\":[{"
     "\"byteLength\":12,\"uri\":\"data:;base64,AAAAAAAAAAAAAAAA\"}]}",
     "1000000000 records of 12 bytes do not fit"},
};

static void what_is_wrong_is_said(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof refused / sizeof *refused; i++) {
        const vv_mesh_format *const *f = vv_registry_builtin()->mesh_formats;
        while (*f && strcmp((*f)->name, refused[i].format) != 0)
            f++;
        assert_non_null(*f);
        assert_int_equal(read_bytes(*f, refused[i].text, strlen(refused[i].text), NULL), VV_E_FORMAT);
        if (!strstr(vv_error_last()->message, refused[i].said))
            fail_msg("'%s' is not in '%s'", refused[i].said, vv_error_last()->message);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(files_that_are_cut_are_refused_or_read, io_setup, io_teardown),
        cmocka_unit_test_setup_teardown(files_that_are_changed_are_refused_or_read, io_setup, io_teardown),
        cmocka_unit_test_setup_teardown(failing_allocations_are_told, io_setup, io_teardown),
        cmocka_unit_test_setup_teardown(what_is_wrong_is_said, io_setup, io_teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
