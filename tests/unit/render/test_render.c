/* The frame driver with a renderer that exists only here: whatever row stands in the registry, it is driven the same.
 */
#include "core/status.h"
#include "fail_alloc.h"
#include "fields.h"
#include "model/context.h"
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include <volvis/file.h>
#include <volvis/render.h>
#include <volvis/sys/scene.h>

#include <cmocka.h>

/* Parameters of the test's renderer. */
typedef struct paint {
    vv_object base;
    int64_t refuse, fail_prepare, fail_from_row, cancel, look; /* 0: no */
} paint;

static const vv_property paint_rows[] = {
    {VV_PROP(paint, refuse), .kind = VV_KIND_I64, .doc = "refuse the scene"},
    {VV_PROP(paint, fail_prepare), .kind = VV_KIND_I64, .doc = "fail before the tiles"},
    {VV_PROP(paint, fail_from_row), .kind = VV_KIND_I64, .doc = "fail in tiles from this row on"},
    {VV_PROP(paint, cancel), .kind = VV_KIND_I64, .doc = "cancel the job in the first tile"},
    {VV_PROP(paint, look), .kind = VV_KIND_I64, .doc = "look at the samples, which is what others do"},
    {0},
};
static const vv_class paint_class = {"paint", "what the test wants", sizeof(paint), paint_rows, NULL, NULL, NULL};

/* How often a state was made and given back; one test runs at a time. */
static atomic_int prepared, finished;
static const vv_field *looked_at;

static vv_status accepts(const vv_scene *scene)
{
    const paint *p = (const paint *)scene->params;
    return p->refuse ? vv_fail(VV_E_UNSUPPORTED, "paint has run out") : VV_OK;
}

static vv_status prepare(void **state_out, const vv_scene *scene, vv_job *job)
{
    const paint *p = (const paint *)scene->params;
    (void)job;
    if (p->fail_prepare)
        return vv_fail(VV_E_LIMIT, "no brush");
    *state_out = (void *)p;
    prepared++;
    return VV_OK;
}

/* Adds to what is there, so that a pixel painted twice is seen: a quarter opaque, its place in the colour. */
static vv_status render(void *state, const vv_pass *pass, const vv_tile *tile, vv_image *image,
                        vv_render_counts *counts, vv_job *job)
{
    const paint *p = state;
    if (p->cancel)
        vv_job_cancel(job);
    if (p->look && vv_field_value(looked_at, 31, 31, 31, 0) != 0)
        return vv_fail(VV_E_INTERNAL, "the file is gone, its samples are not");
    if (p->fail_from_row && tile->y1 > p->fail_from_row)
        return vv_fail(VV_E_INTERNAL, "tile at row %d", tile->y0);
    for (int32_t y = tile->y0; y < tile->y1; y++) {
        for (int32_t x = tile->x0; x < tile->x1; x++) {
            float *pixel = image->rgba + 4 * ((size_t)y * (size_t)image->width + (size_t)x);
            pixel[0] += (float)x / 1024;
            pixel[1] += (float)y / 1024;
            pixel[2] += 0.125f;
            pixel[3] += 0.25f;
            counts->rays++;
            counts->samples += (uint64_t)x;
        }
    }
    return VV_OK;
}

static void finish(void *state)
{
    assert_non_null(state);
    finished++;
}

static const vv_renderer paint_row = {.api = VV_RENDERER_API,
                                      .name = "paint",
                                      .doc = "a test's renderer",
                                      .params = &paint_class,
                                      .takes = VV_CONTENT_SAMPLES,
                                      .accepts = accepts,
                                      .prepare = prepare,
                                      .render = render,
                                      .finish = finish};
static const vv_renderer *const renderers[] = {&paint_row, NULL};

typedef struct setup {
    vv_registry registry;
    vv_job *job;
    vv_object *world;
} setup;

static void set(setup *s, const char *path, const char *json)
{
    const vv_property_context context = vvi_registry_context(&s->registry);
    if (vv_path_set(&s->world, path, json, &context) != VV_OK)
        fail_msg("%s", vv_error_last()->message);
}

static void begin(setup *s, int threads)
{
    vv_runtime_options options;
    vv_runtime *runtime = NULL;
    vv_world *world = NULL;
    *s = (setup){.registry = *vv_registry_builtin()};
    s->registry.renderers = renderers;
    vv_runtime_options_init(&options, sizeof options);
    options.threads = threads;
    options.registry = &s->registry;
    assert_int_equal(vv_runtime_new(&runtime, &options), VV_OK);
    assert_int_equal(vv_job_new(&s->job, runtime, NULL, NULL), VV_OK);
    vv_runtime_release(runtime);
    vv_field *field = test_field_cube(&test_form_ramp, 3, 0, 1, s->job);
    assert_non_null(field);
    assert_int_equal(vv_world_for_field(&world, "a", field, s->job), VV_OK);
    vv_field_release(field);
    s->world = &world->base;
    set(s, "views.main.render.method", "paint");
    set(s, "views.main.render.samples", "1");
    set(s, "views.main.width", "70");
    set(s, "views.main.height", "45");
    prepared = finished = 0;
}

static void end(setup *s)
{
    vv_object_release(s->world);
    vv_job_release(s->job);
}

static vv_image *picture(setup *s, vv_render_report *report)
{
    vv_image *image = NULL;
    if (vv_render(&image, report, (vv_world *)s->world, NULL, NULL, s->job) != VV_OK)
        fail_msg("%s", vv_error_last()->message);
    assert_true(prepared == finished);
    return image;
}

static void every_pixel_is_rendered_once_whatever_the_size(void **state)
{
    static const int sizes[][2] = {{1, 1}, {31, 33}, {32, 32}, {64, 1}, {100, 70}};
    for (int i = 0; i < 5; i++) {
        setup s;
        char text[16];
        begin(&s, 2);
        snprintf(text, sizeof text, "%d", sizes[i][0]);
        set(&s, "views.main.width", text);
        snprintf(text, sizeof text, "%d", sizes[i][1]);
        set(&s, "views.main.height", text);
        set(&s, "background", "transparent");
        vv_render_report report;
        vv_image *image = picture(&s, &report);
        assert_true(image->width == sizes[i][0] && image->height == sizes[i][1]);
        for (int y = 0; y < image->height; y++) {
            for (int x = 0; x < image->width; x++) {
                const float *p = image->rgba + 4 * (y * image->width + x);
                assert_true(p[0] == (float)x / 1024 && p[1] == (float)y / 1024 && p[3] == 0.25f);
            }
        }
        const uint64_t w = (uint64_t)image->width, h = (uint64_t)image->height;
        assert_true(report.rays == w * h && report.samples == h * w * (w - 1) / 2);
        vv_image_release(image);
        end(&s);
    }
}

static void background_shows_through_premultiplied(void **state)
{
    setup s;
    begin(&s, 1);
    set(&s, "background", "[0.5, 0.25, 1, 0.5]");
    vv_image *image = picture(&s, NULL);
    const float *p = image->rgba + 4 * (3 * 70 + 8);
    assert_true(p[0] == 8.0f / 1024 + 0.75f * 0.25f && p[1] == 3.0f / 1024 + 0.75f * 0.125f);
    assert_true(p[2] == 0.125f + 0.75f * 0.5f && p[3] == 0.25f + 0.75f * 0.5f);
    vv_image_release(image);
    set(&s, "background", "black");
    image = picture(&s, NULL);
    assert_true(image->rgba[2] == 0.125f && image->rgba[3] == 1);
    vv_image_release(image);
    end(&s);
}

static void bytes_are_the_same_for_any_number_of_threads(void **state)
{
    vv_image *first = NULL;
    for (int threads = 1; threads <= 3; threads++) {
        setup s;
        vv_render_report report;
        begin(&s, threads);
        vv_image *image = picture(&s, &report);
        assert_int_equal(report.threads, threads);
        assert_true(report.rays == 70 * 45);
        if (first)
            assert_memory_equal(first->rgba, image->rgba, 70 * 45 * 4 * sizeof(float));
        else
            first = vv_image_retain(image);
        vv_image_release(image);
        end(&s);
    }
    vv_image_release(first);
}

static void reports_say_what_was_used_and_how_long_it_took(void **state)
{
    setup s;
    vv_render_report report;
    begin(&s, 2);
    vv_image_release(picture(&s, &report));
    assert_string_equal(report.method, "paint");
    assert_true(report.isa && *report.isa);
    assert_true(report.load_s >= 0 && report.prepare_s >= 0 && report.render_s >= 0);
    end(&s);
}

static void refused(setup *s, vv_status status, const char *text)
{
    vv_image *image = (vv_image *)s;
    assert_int_equal(vv_render(&image, NULL, (vv_world *)s->world, NULL, NULL, s->job), status);
    assert_null(image);
    if (!strstr(vv_error_last()->message, text))
        fail_msg("'%s' does not say '%s'", vv_error_last()->message, text);
    assert_true(prepared == finished);
}

static void failures_of_every_step_come_back_and_leave_nothing(void **state)
{
    setup s;
    begin(&s, 3);
    set(&s, "views.main.render.paint.refuse", "1");
    refused(&s, VV_E_UNSUPPORTED, "run out");
    set(&s, "views.main.render.paint.refuse", "0");
    set(&s, "views.main.render.paint.fail_prepare", "1");
    refused(&s, VV_E_LIMIT, "no brush");
    set(&s, "views.main.render.paint.fail_prepare", "0");
    set(&s, "views.main.render.paint.fail_from_row", "33");
    refused(&s, VV_E_INTERNAL, "tile at row 32");
    assert_int_equal(prepared, 1);
    set(&s, "views.main.render.paint.fail_from_row", "0");
    vv_image_release(picture(&s, NULL));
    end(&s);
}

static void a_cancelled_frame_is_no_image(void **state)
{
    setup s;
    begin(&s, 1);
    set(&s, "views.main.render.paint.cancel", "1");
    refused(&s, VV_E_CANCELLED, "");
    end(&s);
}

static void a_file_that_shrinks_while_it_is_drawn_is_a_sentence(void **state)
{
    enum { SIDE = 32 };
    setup s;
    char path[] = "/tmp/volvis-shrinks-XXXXXX";
    vv_file *file = NULL;
    vv_field *field = NULL;
    vv_world *world = NULL;
    uint8_t samples[SIDE * SIDE];
    begin(&s, 2);
    FILE *out = fdopen(mkstemp(path), "wb");
    assert_non_null(out);
    fprintf(out, "NRRD0004\ntype: uchar\ndimension: 3\nsizes: %d %d %d\nencoding: raw\n\n", SIDE, SIDE, SIDE);
    memset(samples, 7, sizeof samples);
    for (int k = 0; k < SIDE; k++)
        assert_int_equal(fwrite(samples, 1, sizeof samples, out), sizeof samples);
    fclose(out);
    assert_int_equal(vv_file_open(&file, path, NULL, s.job), VV_OK);
    assert_true(vv_file_mappable(file));
    assert_int_equal(vv_file_read(&field, file, 0, NULL, s.job), VV_OK);
    vv_file_close(file);
    assert_int_equal(vv_world_for_field(&world, "a", field, s.job), VV_OK);
    vv_object_release(s.world);
    s.world = &world->base;
    looked_at = field;
    set(&s, "views.main.render.method", "paint");
    set(&s, "views.main.render.paint.look", "1");
    set(&s, "views.main.camera.fit", "data");
    assert_int_equal(truncate(path, 100), 0);
    refused(&s, VV_E_READ, "shrank");
    unlink(path);
    vv_field_release(field);
    end(&s);
}

static void an_unknown_view_is_named(void **state)
{
    setup s;
    vv_image *image = NULL;
    begin(&s, 1);
    assert_int_equal(vv_render(&image, NULL, (vv_world *)s.world, "side", NULL, s.job), VV_E_NOT_FOUND);
    assert_non_null(strstr(vv_error_last()->message, "side"));
    end(&s);
}

static vv_status render_once(void *user)
{
    setup *s = user;
    vv_image *image = NULL;
    const vv_status st = vv_render(&image, NULL, (vv_world *)s->world, NULL, NULL, s->job);
    vv_image_release(image);
    return st;
}

static void any_allocation_may_fail(void **state)
{
    setup s;
    begin(&s, 2);
    assert_true(test_fail_each_alloc(render_once, &s) > 5);
    assert_true(prepared == finished);
    end(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_pixel_is_rendered_once_whatever_the_size),
        cmocka_unit_test(background_shows_through_premultiplied),
        cmocka_unit_test(bytes_are_the_same_for_any_number_of_threads),
        cmocka_unit_test(reports_say_what_was_used_and_how_long_it_took),
        cmocka_unit_test(failures_of_every_step_come_back_and_leave_nothing),
        cmocka_unit_test(a_cancelled_frame_is_no_image),
        cmocka_unit_test(a_file_that_shrinks_while_it_is_drawn_is_a_sentence),
        cmocka_unit_test(an_unknown_view_is_named),
        cmocka_unit_test(any_allocation_may_fail),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
