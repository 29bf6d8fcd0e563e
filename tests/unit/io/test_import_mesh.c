/* Meshes read by the import program (--safe): the same as without, and what it says is checked. */
#include "io_test.h"
#include "jobs.h"
#include "meshes.h"
#include <errno.h>
#include <sys/wait.h>
#include <volvis/mesh_file.h>
#include <volvis/sys/registry.h>

static vv_job *safe_job(const char *program)
{
    vv_runtime_options options;
    vv_limits limits;
    vv_runtime *runtime;
    vv_job *job;
    vv_limits_init(&limits, sizeof limits);
    limits.import_seconds = 5;
    vv_runtime_options_init(&options, sizeof options);
    options.threads = 1;
    options.memory_bytes = (uint64_t)256 << 20;
    options.safe = true;
    options.limits = &limits;
    options.import_program = program;
    io_ok(vv_runtime_new(&runtime, &options));
    io_ok(vv_job_new(&job, runtime, NULL, NULL));
    vv_runtime_release(runtime);
    return job;
}

static void no_process_is_left(void)
{
    int how;
    assert_int_equal(waitpid(-1, &how, WNOHANG), -1);
    assert_int_equal(errno, ECHILD);
}

static void same(const vv_mesh *a, const vv_mesh *b)
{
    const vv_mesh_info *x = vv_mesh_get_info(a), *y = vv_mesh_get_info(b);
    assert_int_equal(x->n_vertices, y->n_vertices);
    assert_int_equal(x->n_triangles, y->n_triangles);
    assert_int_equal(x->n_parts, y->n_parts);
    assert_int_equal(vv_mesh_checksum(a), vv_mesh_checksum(b));
    assert_int_equal(x->space, y->space);
    assert_memory_equal(&x->origin, &y->origin, sizeof x->origin);
    assert_string_equal(x->unit, y->unit);
    assert_string_equal(x->value_name, y->value_name);
    assert_string_equal(x->value_unit, y->value_unit);
    for (size_t i = 0; i < x->n_parts; i++)
        assert_memory_equal(&x->parts[i], &y->parts[i], sizeof *x->parts);
}

static void same_both_ways(const char *path, const vv_mesh_read_options *options)
{
    vv_job *plain = test_job(1, 0), *safe = safe_job(VOLVIS_IMPORT);
    vv_mesh *a = NULL, *b = NULL;
    char said[4096] = "";
    const vv_status first = vv_mesh_read(&a, path, options, plain);
    if (first != VV_OK)
        snprintf(said, sizeof said, "%s", vv_error_last()->message);
    const vv_status second = vv_mesh_read(&b, path, options, safe);
    if (first != second || (second != VV_OK && strcmp(said, vv_error_last()->message) != 0))
        fail_msg("%s: %s '%s', but safely %s '%s'", path, vv_status_name(first), said, vv_status_name(second),
                 second == VV_OK ? "" : vv_error_last()->message);
    if (a)
        same(a, b);
    vv_mesh_release(a);
    vv_mesh_release(b);
    vv_job_release(plain);
    vv_job_release(safe);
}

static void every_format_reads_the_same_safely(void **state)
{
    const vv_registry *registry = vv_registry_builtin();
    size_t n = 0;
    for (size_t f = 0; registry->mesh_formats[f]; f++) {
        const vv_mesh_format *format = registry->mesh_formats[f];
        vv_mesh *mesh = test_mesh_strip(1021, TEST_MESH_NORMALS | TEST_MESH_VALUES | TEST_MESH_COLORS |
                                                  TEST_MESH_PARTS | (f % 2 ? TEST_MESH_FAR : 0));
        vv_mesh_read_options options;
        char name[32];
        snprintf(name, sizeof name, "a%s", format->suffixes[0]);
        const char *path = io_path(state, name);
        vv_mesh_read_options_init(&options, sizeof options);
        if (format->write) {
            io_ok(vv_mesh_write(path, mesh, NULL, NULL));
            options.unit = f % 2 ? "cm" : NULL;
            same_both_ways(path, &options);
            options.part = "1";
            same_both_ways(path, &options);
            options.part = NULL;
            options.format = "obj";
            same_both_ways(path, &options);
            n++;
        }
        vv_mesh_release(mesh);
    }
    assert_true(n >= 5);
    io_put_text(io_path(state, "broken.ply"), "ply\nformat ascii 1.0\nelement vertex 3\n");
    same_both_ways(io_path(state, "broken.ply"), NULL);
    same_both_ways(io_path(state, "absent.ply"), NULL);
    io_put_text(io_path(state, "none.stl"), "");
    same_both_ways(io_path(state, "none.stl"), NULL);
    no_process_is_left();
}

static void what_it_says_of_a_mesh_is_checked(void **state)
{
    static const char *const lies[] = {"vertices", "negative", "space", "unit",   "format", "with", "rest",
                                       "kind",     "index",    "nan",   "normal", "gap",    "long", "short",
                                       "name",     "color",    "held",  "done",   "image",  "wrap", "texture"};
    vv_mesh *mesh = NULL;
    for (size_t i = 0; i < sizeof lies / sizeof *lies; i++) {
        vv_job *job = safe_job(IMPORT_MESH_LIAR);
        const char *path = io_path(state, lies[i]);
        io_put_text(path, "x");
        const vv_status st = vv_mesh_read(&mesh, path, NULL, job);
        if (st != VV_E_READ || !strstr(vv_error_last()->message, "an invalid answer"))
            fail_msg("%s: %s, '%s'", lies[i], vv_status_name(st), st == VV_OK ? "" : vv_error_last()->message);
        assert_null(mesh);
        vv_job_release(job);
    }
    vv_job *job = safe_job(IMPORT_MESH_LIAR);
    io_put_text(io_path(state, "huge"), "x");
    assert_int_equal(vv_mesh_read(&mesh, io_path(state, "huge"), NULL, job), VV_E_LIMIT); /* more than --memory */
    io_put_text(io_path(state, "honest"), "x");
    io_ok(vv_mesh_read(&mesh, io_path(state, "honest"), NULL, job));
    assert_true(fabs(test_mesh_volume(mesh) - 1.0 / 6) < 1e-6);
    vv_mesh_release(mesh);
    vv_job_release(job);
    no_process_is_left();
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(every_format_reads_the_same_safely, io_setup, io_teardown),
        cmocka_unit_test_setup_teardown(what_it_says_of_a_mesh_is_checked, io_setup, io_teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
