/* Images read by the import program (--safe): the same as without, and what it says is checked. */
#include "image/image_layer.h"
#include "io_test.h"
#include "jobs.h"
#include <errno.h>
#include <sys/wait.h>
#include <volvis/image.h>
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

static void same(const vv_image *a, const vv_image *b)
{
    const size_t n = (size_t)a->width * (size_t)a->height;
    assert_int_equal(a->width, b->width);
    assert_int_equal(a->height, b->height);
    assert_int_equal(vv_image_layers(a), vv_image_layers(b));
    assert_memory_equal(a->rgba, b->rgba, 4 * n * sizeof *a->rgba);
    for (size_t i = 0; i < VV_LAYER_COUNT; i++)
        if (vvi_image_layer(a, i))
            assert_memory_equal(vvi_image_layer(a, i), vvi_image_layer(b, i),
                                n * vvi_layer_nth(i)->channels * sizeof(float));
}

static void same_texts(const vv_text *a, size_t n_a, const vv_text *b, size_t n_b)
{
    assert_int_equal(n_a, n_b);
    for (size_t i = 0; i < n_a; i++) {
        assert_string_equal(a[i].key, b[i].key);
        assert_string_equal(a[i].value, b[i].value);
    }
}

static void same_both_ways(const char *path)
{
    vv_job *plain = test_job(1, 0), *safe = safe_job(VOLVIS_IMPORT);
    vv_image *a = NULL, *b = NULL;
    vv_text *text_a = NULL, *text_b = NULL;
    size_t n_a = 0, n_b = 0;
    char said[4096] = "";
    const vv_status first = vv_image_read(&a, &text_a, &n_a, path, plain);
    if (first != VV_OK)
        snprintf(said, sizeof said, "%s", vv_error_last()->message);
    const vv_status second = vv_image_read(&b, &text_b, &n_b, path, safe);
    if (first != second || (second != VV_OK && strcmp(said, vv_error_last()->message) != 0))
        fail_msg("%s: %s '%s', but safely %s '%s'", path, vv_status_name(first), said, vv_status_name(second),
                 second == VV_OK ? "" : vv_error_last()->message);
    if (a)
        same(a, b);
    same_texts(text_a, n_a, text_b, n_b);
    vv_text_free(text_a, n_a);
    vv_text_free(text_b, n_b);
    vv_image_release(a);
    vv_image_release(b);
    vv_job_release(plain);
    vv_job_release(safe);
}

static vv_image *picture(unsigned layers)
{
    vv_image *image;
    io_ok(vv_image_new(&image, 37, 21, layers, NULL));
    for (size_t i = 0; i < 37 * 21; i++) {
        for (size_t c = 0; c < 3; c++)
            image->rgba[4 * i + c] = (float)((i * (c + 3)) % 101) / 100;
        image->rgba[4 * i + 3] = 1;
        if (image->depth)
            image->depth[i] = (float)i;
        if (image->normal)
            image->normal[3 * i + 1] = (float)i;
        if (image->id)
            image->id[i] = (uint32_t)i % 5;
    }
    return image;
}

static void every_format_reads_the_same_safely(void **state)
{
    static const vv_text texts[] = {{"volvis", "a text"}, {"other", ""}};
    const vv_registry *registry = vv_registry_builtin();
    size_t n = 0;
    for (size_t f = 0; registry->image_formats[f]; f++) {
        const vv_image_format *format = registry->image_formats[f];
        vv_image_options options;
        char name[32];
        if (!format->write || !format->read)
            continue;
        vv_image_options_init(&options, sizeof options);
        options.layers = strcmp(format->name, "exr") == 0 ? VV_LAYER_DEPTH | VV_LAYER_NORMAL | VV_LAYER_ID : 0;
        options.text = texts;
        options.n_text = 2;
        vv_image *image = picture(options.layers);
        snprintf(name, sizeof name, "a%s", format->suffixes[0]);
        io_ok(vv_image_write(io_path(state, name), image, &options, NULL));
        same_both_ways(io_path(state, name));
        assert_int_equal(truncate(io_path(state, name), 60), 0); /* of whatever: the same sentence */
        same_both_ways(io_path(state, name));
        vv_image_release(image);
        n++;
    }
    assert_true(n >= 2);
    io_put_text(io_path(state, "none.png"), "");
    same_both_ways(io_path(state, "none.png"));
    io_put_text(io_path(state, "other.png"), "not a picture");
    same_both_ways(io_path(state, "other.png"));
    no_process_is_left();
}

static void what_it_says_of_an_image_is_checked(void **state)
{
    static const char *const lies[] = {"width", "wide", "height", "tall", "layers", "rest", "kind", "held", "done"};
    vv_image *image = NULL;
    for (size_t i = 0; i < sizeof lies / sizeof *lies; i++) {
        vv_job *job = safe_job(IMPORT_IMAGE_LIAR);
        const char *path = io_path(state, lies[i]);
        io_put_text(path, "x");
        const vv_status st = vv_image_read(&image, NULL, NULL, path, job);
        if (st != VV_E_READ || !strstr(vv_error_last()->message, "an invalid answer"))
            fail_msg("%s: %s, '%s'", lies[i], vv_status_name(st), st == VV_OK ? "" : vv_error_last()->message);
        assert_null(image);
        vv_job_release(job);
    }
    vv_job *job = safe_job(IMPORT_IMAGE_LIAR);
    io_put_text(io_path(state, "huge"), "x");
    assert_int_equal(vv_image_read(&image, NULL, NULL, io_path(state, "huge"), job), VV_E_LIMIT); /* of --memory */
    io_put_text(io_path(state, "honest"), "x");
    io_ok(vv_image_read(&image, NULL, NULL, io_path(state, "honest"), job));
    for (size_t i = 0; i < 24; i++)
        assert_true(image->rgba[i] == (float)i);
    for (size_t i = 0; i < 6; i++)
        assert_true(image->depth[i] == (float)(24 + i));
    vv_image_release(image);
    vv_job_release(job);
    no_process_is_left();
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(every_format_reads_the_same_safely, io_setup, io_teardown),
        cmocka_unit_test_setup_teardown(what_it_says_of_an_image_is_checked, io_setup, io_teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
