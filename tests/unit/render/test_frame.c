/* From fewer rays than pixels to many more: the frame driver with a renderer whose light is a formula of the place in
 * the image, so that what every picture must be is known. */
#include "core/status.h"
#include "fail_alloc.h"
#include "fields.h"
#include "model/context.h"
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <volvis/render.h>
#include <volvis/sys/scene.h>

#include <cmocka.h>

enum { W = 77, H = 53 };

/* Light at a place in pixels, red, green and blue, 0 to 1; alpha is 1 where it is not negative. One test at a time. */
typedef double form(double x, double y);
static form *light;
static vv_job *cancel_in_renderer;

static vv_status render(void *state, const vv_pass *pass, const vv_tile *tile, vv_image *image,
                        vv_render_counts *counts, vv_job *job)
{
    if (cancel_in_renderer)
        vv_job_cancel(cancel_in_renderer);
    for (int32_t y = tile->y0; y < tile->y1; y++) {
        for (int32_t x = tile->x0; x < tile->x1; x++) {
            const double v = light(x * (double)pass->stride + pass->x, y * (double)pass->stride + pass->top + pass->y);
            const size_t at = (size_t)y * (size_t)image->width + (size_t)x;
            assert_true(image->rgba[4 * at + 3] == 0); /* clear before */
            for (size_t c = 0; c < 3; c++)
                image->rgba[4 * at + c] = (float)fmax(v, 0);
            image->rgba[4 * at + 3] = v >= 0;
            if (image->depth && v >= 0)
                image->depth[at] = (float)(1 + v);
            counts->rays++;
        }
    }
    return VV_OK;
}

typedef struct nothing {
    vv_object base;
} nothing;
static const vv_property no_rows[] = {{0}};
static const vv_class formula_class = {"formula", "no parameters", sizeof(nothing), no_rows, NULL, NULL, NULL};
static const vv_renderer formula = {.api = VV_RENDERER_API,
                                    .name = "formula",
                                    .doc = "a test's renderer",
                                    .params = &formula_class,
                                    .takes = VV_CONTENT_SAMPLES,
                                    .render = render};
static const vv_renderer *const renderers[] = {&formula, NULL};

typedef struct setup {
    vv_registry registry;
    vv_job *job;
    vv_object *world;
    const vv_render_options *options;
    vv_render_report report;
} setup;

static void set(setup *s, const char *name, const char *json)
{
    const vv_property_context context = vvi_registry_context(&s->registry);
    char path[64];
    snprintf(path, sizeof path, "views.main.%s", name);
    if (vv_path_set(&s->world, path, json, &context) != VV_OK)
        fail_msg("%s", vv_error_last()->message);
}

static void begin(setup *s, form *what, int threads)
{
    vv_runtime_options options;
    vv_runtime *runtime = NULL;
    vv_world *world = NULL;
    *s = (setup){.registry = *vv_registry_builtin()};
    s->registry.renderers = renderers;
    light = what;
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
    const vv_property_context context = vvi_registry_context(&s->registry);
    assert_int_equal(vv_path_set(&s->world, "background", "[0, 0, 0, 0]", &context), VV_OK);
    set(s, "render.method", "formula");
    set(s, "render.samples", "1");
    set(s, "width", "77");
    set(s, "height", "53");
}

static void end(setup *s)
{
    vv_object_release(s->world);
    vv_job_release(s->job);
}

static vv_image *picture(setup *s)
{
    vv_image *image = NULL;
    if (vv_render(&image, &s->report, (vv_world *)s->world, NULL, s->options, s->job) != VV_OK)
        fail_msg("%s", vv_error_last()->message);
    return image;
}

static float red(const vv_image *image, int32_t x, int32_t y)
{
    return image->rgba[4 * (y * image->width + x)];
}

/* Forms ----------------------------------------------------------------------------------------------------------- */

static double wave_x = 0.9, wave_y = 0.7;

static double wave(double x, double y)
{
    return 0.5 + 0.5 * sin(wave_x * x + wave_y * y);
}

/* What a tent of two pixels' width makes of the wave: each factor is the square of the pixel's own. */
static double filtered_wave(double x, double y)
{
    const double a = sin(wave_x / 2) / (wave_x / 2), b = sin(wave_y / 2) / (wave_y / 2);
    return 0.5 + 0.5 * a * a * b * b * sin(wave_x * x + wave_y * y);
}

static double speckle(double x, double y)
{
    const uint64_t i = (uint64_t)(int64_t)floor(x) * 131 + (uint64_t)(int64_t)floor(y) * 7919;
    return (double)(i * i % 97) / 96;
}

static double slope(double x, double y)
{
    return 0.3 + 0.002 * x + 0.003 * y;
}

static double disc(double x, double y)
{
    return hypot(x - 40, y - 26) < 18 ? 0.8 : -1;
}

/* A thread, 1.5 pixels wide, too thin for a coarse grid to meet it everywhere. */
static double thread(double x, double y)
{
    return fabs(y - 20 - 0.31 * x) < 0.75 ? 0.9 : 0.1;
}

static double left_half(double x, double y)
{
    return x + 0.2 * y < 40 ? 0.9 : 0.1;
}

/* Many rays per pixel -----------------------------------------------------------------------------------------------
 */

/* Mean square of the error over waves of 5 to 8 pixels' length in all directions. */
static double filter_error(const char *samples)
{
    enum { WAVES = 24 };
    double sum = 0;
    for (int i = 0; i < WAVES; i++) {
        setup s;
        const double length = 5 + 3.0 * (i * 7 % WAVES) / WAVES, angle = 2 * M_PI * i / WAVES;
        wave_x = 2 * M_PI / length * cos(angle) + 1e-9;
        wave_y = 2 * M_PI / length * sin(angle) + 1e-9;
        begin(&s, wave, 2);
        set(&s, "render.samples", samples);
        vv_image *image = picture(&s);
        assert_true(s.report.passes == atoi(samples) && s.report.ended_by == VV_END_SAMPLES);
        for (int32_t p = 0; p < W * H; p++) {
            const double e = (double)image->rgba[4 * p] - filtered_wave(p % W + 0.5, p / W + 0.5);
            sum += e * e / (W * H * WAVES);
        }
        vv_image_release(image);
        end(&s);
    }
    wave_x = 0.9, wave_y = 0.7;
    return sum;
}

/* Order in the number of rays along the side of a pixel, the square root of how many there are. */
static void the_mean_of_passes_converges_to_the_tent_filter_with_order_2(void **state)
{
    static const char *const samples[] = {"4", "8", "16", "32", "64", "128", "256"};
    enum { N = sizeof samples / sizeof samples[0] };
    double sx = 0, sy = 0, sxx = 0, sxy = 0;
    for (int i = 0; i < N; i++) {
        const double x = log(atoi(samples[i])) / 2, y = log(filter_error(samples[i])) / 2;
        sx += x, sy += y, sxx += x * x, sxy += x * y;
    }
    const double order = -(N * sxy - sx * sy) / (N * sxx - sx * sx);
    if (fabs(order - 2) > 0.2)
        fail_msg("order %.3f", order);
}

static void four_rays_a_pixel_soften_an_edge_to_a_twentieth(void **state)
{
    setup s;
    begin(&s, left_half, 1);
    set(&s, "render.samples", "1024");
    vv_image *exact = picture(&s);
    static const struct {
        const char *samples;
        double error;
    } cases[] = {{"4", 0.06}, {"16", 0.02}, {"64", 0.008}};
    for (int i = 0; i < 3; i++) {
        double sum = 0;
        int n = 0;
        set(&s, "render.samples", cases[i].samples);
        vv_image *image = picture(&s);
        for (int32_t p = 0; p < W * H; p++) {
            const double e = (double)(image->rgba[4 * p] - exact->rgba[4 * p]) / 0.8;
            n += exact->rgba[4 * p] > 0.11f && exact->rgba[4 * p] < 0.89f;
            sum += e * e;
        }
        if (sqrt(sum / n) > cases[i].error)
            fail_msg("%s: %g", cases[i].samples, sqrt(sum / n));
        vv_image_release(image);
    }
    vv_image_release(exact);
    end(&s);
}

static void depth_is_that_of_the_ray_through_the_centre(void **state)
{
    setup s;
    begin(&s, disc, 2);
    vv_image *one = picture(&s);
    set(&s, "render.samples", "6");
    vv_image *six = picture(&s);
    assert_memory_equal(one->depth, six->depth, W * H * sizeof(float));
    assert_true(s.report.rays == W * H + 5 * (W + 1) * (H + 1));
    vv_image_release(one);
    vv_image_release(six);
    end(&s);
}

static void the_background_is_behind_what_many_rays_leave_of_it(void **state)
{
    setup s;
    begin(&s, disc, 1);
    set(&s, "render.samples", "9");
    vv_image *clear = picture(&s);
    const vv_property_context context = vvi_registry_context(&s.registry);
    assert_int_equal(vv_path_set(&s.world, "background", "[0.5, 0.25, 1, 1]", &context), VV_OK);
    vv_image *over = picture(&s);
    for (int32_t p = 0; p < W * H; p++) {
        assert_true(fabsf(over->rgba[4 * p] - (clear->rgba[4 * p] + (1 - clear->rgba[4 * p + 3]) * 0.5f)) < 1e-6f);
        assert_true(fabsf(over->rgba[4 * p + 3] - 1) < 1e-6f);
    }
    vv_image_release(clear);
    vv_image_release(over);
    end(&s);
}

/* Until it is good enough ----------------------------------------------------------------------------------------- */

static void noise_sends_rays_only_where_there_is_some(void **state)
{
    setup s;
    begin(&s, left_half, 2);
    set(&s, "render.samples", "1024");
    vv_image *exact = picture(&s);
    set(&s, "render.noise", "0.02");
    set(&s, "render.layers.samples", "true");
    vv_image *image = picture(&s);
    assert_true(s.report.ended_by == VV_END_NOISE && s.report.passes > 8 && s.report.passes < 100);
    assert_true(s.report.rays < 0.3 * (double)s.report.passes * W * H);
    assert_int_equal(image->samples[3 * W + 2], 1);
    assert_int_equal(image->samples[3 * W + 75], 1);
    assert_true(image->samples[20 * W + 36] >= 5);
    double sum = 0;
    int n = 0;
    for (int32_t p = 0; p < W * H; p++) {
        const double e = sqrt((double)image->rgba[4 * p]) - sqrt((double)exact->rgba[4 * p]);
        assert_true(fabs(e) < 0.06); /* the bound is one standard error: three are hardly ever reached */
        n += image->samples[p] > 1;
        sum += e * e;
    }
    if (sqrt(sum / n) > 0.02)
        fail_msg("%d passes, error %g", (int)s.report.passes, sqrt(sum / n));
    vv_image_release(image);
    vv_image_release(exact);
    end(&s);
}

static void samples_and_budget_end_it_too(void **state)
{
    setup s;
    begin(&s, speckle, 2);
    set(&s, "render.noise", "0.0001");
    set(&s, "render.samples", "7");
    vv_image_release(picture(&s));
    assert_true(s.report.ended_by == VV_END_SAMPLES && s.report.passes == 7);
    set(&s, "render.budget", "1e6");
    vv_image_release(picture(&s));
    assert_true(s.report.ended_by == VV_END_SAMPLES && s.report.passes == 7);
    set(&s, "render.budget", "1e-9");
    vv_image_release(picture(&s));
    assert_true(s.report.ended_by == VV_END_BUDGET && s.report.passes == 1);
    assert_string_equal(vv_render_end_name(s.report.ended_by), "budget");
    end(&s);
}

/* Fewer rays than pixels ------------------------------------------------------------------------------------------ */

static void where_light_changes_everywhere_adaptive_sampling_is_full_rendering(void **state)
{
    setup s;
    begin(&s, speckle, 2);
    vv_image *full = picture(&s);
    set(&s, "render.adaptive", "true");
    vv_image *adaptive = picture(&s);
    assert_memory_equal(full->rgba, adaptive->rgba, W * H * 4 * sizeof(float));
    assert_memory_equal(full->depth, adaptive->depth, W * H * sizeof(float));
    assert_true(s.report.rays >= W * H);
    vv_image_release(full);
    vv_image_release(adaptive);
    end(&s);
}

static void a_slope_needs_a_sixteenth_of_the_rays(void **state)
{
    setup s;
    begin(&s, slope, 2);
    set(&s, "render.quality", "draft"); /* adaptive by itself */
    vv_image *image = picture(&s);
    assert_true(s.report.rays == 21 * 15);
    for (int32_t y = 0; y < H; y++)
        for (int32_t x = 0; x < W; x++) {
            assert_true(fabs((double)red(image, x, y) - slope(x + 0.5, y + 0.5)) < 1e-6);
            assert_true(fabs((double)image->depth[y * W + x] - 1 - slope(x + 0.5, y + 0.5)) < 1e-5);
        }
    vv_image_release(image);
    end(&s);
}

static void what_is_hit_and_missed_is_right_in_every_pixel(void **state)
{
    setup s;
    begin(&s, disc, 2);
    vv_image *full = picture(&s);
    set(&s, "render.adaptive", "true");
    vv_image *adaptive = picture(&s);
    assert_true(s.report.rays < W * H / 2);
    for (int32_t p = 0; p < W * H; p++) {
        assert_true(fabsf(full->rgba[4 * p] - adaptive->rgba[4 * p]) < 1e-6f);
        assert_true(full->depth[p] == adaptive->depth[p] || fabsf(full->depth[p] - adaptive->depth[p]) < 1e-6f);
    }
    vv_image_release(full);
    vv_image_release(adaptive);
    end(&s);
}

static void a_thread_is_followed_where_no_corner_saw_it(void **state)
{
    setup s;
    begin(&s, thread, 2);
    vv_image *full = picture(&s);
    set(&s, "render.adaptive", "true");
    vv_image *adaptive = picture(&s);
    assert_true(s.report.rays < W * H / 2);
    for (int32_t p = 0; p < W * H; p++)
        assert_true(fabsf(full->rgba[4 * p] - adaptive->rgba[4 * p]) < 1e-6f);
    vv_image_release(full);
    vv_image_release(adaptive);
    end(&s);
}

/* Step by step ---------------------------------------------------------------------------------------------------- */

typedef struct watcher {
    vv_job *job;
    int calls, cancel_at; /* 0: never */
    int level[64];
    int64_t passes[64];
    double error[64]; /* largest difference from the form in red */
    bool final[64];
} watcher;

static void watch(void *user, const vv_refinement *r)
{
    watcher *w = user;
    const int i = w->calls++;
    assert_true(i < 64 && r->image->width == W && r->image->height == H);
    w->level[i] = r->level;
    w->passes[i] = r->passes;
    w->final[i] = r->final;
    for (int32_t p = 0; p < W * H; p++)
        w->error[i] = fmax(w->error[i], fabs((double)r->image->rgba[4 * p] - light(p % W + 0.5, p / W + 0.5)));
    if (w->calls == w->cancel_at)
        vv_job_cancel(w->job);
}

static vv_image *watched(setup *s, watcher *w)
{
    vv_render_options options;
    vv_render_options_init(&options, sizeof options);
    options.on_refined = watch;
    options.user = w;
    s->options = &options;
    vv_image *image = picture(s);
    s->options = NULL;
    return image;
}

static void a_picture_grows_finer_and_ends_as_if_nobody_had_looked(void **state)
{
    setup s;
    begin(&s, wave, 2);
    vv_image *plain = picture(&s);
    watcher w = {0};
    vv_image *image = watched(&s, &w);
    assert_memory_equal(plain->rgba, image->rgba, W * H * 4 * sizeof(float));
    assert_memory_equal(plain->depth, image->depth, W * H * sizeof(float));
    assert_int_equal(w.calls, 3);
    for (int i = 0; i < 3; i++)
        assert_true(w.level[i] == i && w.passes[i] == (i == 2) && w.final[i] == (i == 2));
    assert_true(w.error[0] > 0.2 && w.error[1] < 0.6 * w.error[0] && w.error[2] < 1e-6);
    vv_image_release(plain);
    vv_image_release(image);
    set(&s, "render.samples", "4");
    plain = picture(&s);
    w = (watcher){0};
    image = watched(&s, &w);
    assert_memory_equal(plain->rgba, image->rgba, W * H * 4 * sizeof(float));
    assert_int_equal(w.calls, 6);
    for (int i = 2; i < 6; i++)
        assert_true(w.level[i] == 2 && w.passes[i] == i - 1 && w.final[i] == (i == 5));
    vv_image_release(plain);
    vv_image_release(image);
    end(&s);
}

static void looking_changes_no_byte_of_an_adaptive_picture(void **state)
{
    setup s;
    begin(&s, disc, 2);
    set(&s, "render.adaptive", "true");
    vv_image *plain = picture(&s);
    watcher w = {0};
    vv_image *image = watched(&s, &w);
    assert_memory_equal(plain->rgba, image->rgba, W * H * 4 * sizeof(float));
    assert_int_equal(w.calls, 2);
    assert_true(w.level[0] == 0 && w.level[1] == 2 && w.final[1]);
    vv_image_release(plain);
    vv_image_release(image);
    end(&s);
}

static void a_picture_may_be_stopped_after_any_step(void **state)
{
    for (int at = 1; at <= 5; at++) {
        setup s;
        begin(&s, wave, 2);
        set(&s, "render.samples", "4");
        watcher w = {.job = s.job, .cancel_at = at};
        vv_render_options options;
        vv_image *image = (vv_image *)&s;
        vv_render_options_init(&options, sizeof options);
        options.on_refined = watch;
        options.user = &w;
        assert_int_equal(vv_render(&image, NULL, (vv_world *)s.world, NULL, &options, s.job), VV_E_CANCELLED);
        assert_null(image);
        assert_int_equal(w.calls, at);
        end(&s);
    }
}

/* Always ---------------------------------------------------------------------------------------------------------- */

static const struct {
    const char *name, *value;
} modes[] = {
    {"samples", "5"}, {"noise", "0.03"}, {"adaptive", "true"}, {"quality", "\"high\""}, {"samples", "1"},
};
enum { MODES = sizeof modes / sizeof modes[0] };

static void set_mode(setup *s, int mode)
{
    char name[32];
    snprintf(name, sizeof name, "render.%s", modes[mode].name);
    set(s, name, modes[mode].value);
}

static void bytes_are_the_same_for_any_number_of_threads_in_every_mode(void **state)
{
    for (int mode = 0; mode < 2 * MODES; mode++) {
        vv_image *first = NULL;
        for (int threads = 1; threads <= 3; threads++) {
            setup s;
            watcher w = {0};
            begin(&s, left_half, threads);
            set_mode(&s, mode / 2);
            vv_image *image;
            if (mode % 2 && mode != 3) /* by noise there are more steps than a watcher has room for */
                image = watched(&s, &w);
            else
                image = picture(&s);
            first = first ? first : vv_image_retain(image);
            assert_memory_equal(first->rgba, image->rgba, W * H * 4 * sizeof(float));
            assert_memory_equal(first->depth, image->depth, W * H * sizeof(float));
            vv_image_release(image);
            end(&s);
        }
        vv_image_release(first);
    }
}

static vv_status render_once(void *user)
{
    setup *s = user;
    vv_image *image = NULL;
    const vv_status st = vv_render(&image, NULL, (vv_world *)s->world, NULL, NULL, s->job);
    vv_image_release(image);
    return st;
}

static void any_allocation_may_fail_in_every_mode(void **state)
{
    for (int mode = 0; mode < MODES; mode++) {
        setup s;
        begin(&s, disc, 2);
        set(&s, "width", "9");
        set(&s, "height", "7");
        set_mode(&s, mode);
        assert_true(test_fail_each_alloc(render_once, &s) > 5);
        end(&s);
    }
}

static void a_stop_in_the_middle_is_heard_in_every_mode(void **state)
{
    for (int mode = 0; mode < MODES; mode++) {
        setup s;
        begin(&s, speckle, 2);
        set_mode(&s, mode);
        cancel_in_renderer = s.job;
        assert_int_equal(render_once(&s), VV_E_CANCELLED);
        cancel_in_renderer = NULL;
        end(&s);
    }
}

static void pictures_of_any_size_are_whole(void **state)
{
    static const char *const sides[] = {"1", "2", "4", "5", "31", "32", "33"};
    for (size_t i = 0; i < sizeof sides / sizeof *sides; i++)
        for (size_t j = 0; j < sizeof sides / sizeof *sides; j++)
            for (int mode = 0; mode < MODES; mode++) {
                setup s;
                begin(&s, slope, 1);
                set(&s, "width", sides[i]);
                set(&s, "height", sides[j]);
                set_mode(&s, mode);
                vv_image *image = picture(&s);
                for (int32_t p = 0; p < image->width * image->height; p++) {
                    const double want = slope(p % image->width + 0.5, p / image->width + 0.5);
                    assert_true(fabs((double)image->rgba[4 * p] - want) < 0.004 && image->rgba[4 * p + 3] == 1);
                }
                vv_image_release(image);
                end(&s);
            }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_mean_of_passes_converges_to_the_tent_filter_with_order_2),
        cmocka_unit_test(four_rays_a_pixel_soften_an_edge_to_a_twentieth),
        cmocka_unit_test(depth_is_that_of_the_ray_through_the_centre),
        cmocka_unit_test(the_background_is_behind_what_many_rays_leave_of_it),
        cmocka_unit_test(noise_sends_rays_only_where_there_is_some),
        cmocka_unit_test(samples_and_budget_end_it_too),
        cmocka_unit_test(where_light_changes_everywhere_adaptive_sampling_is_full_rendering),
        cmocka_unit_test(a_slope_needs_a_sixteenth_of_the_rays),
        cmocka_unit_test(what_is_hit_and_missed_is_right_in_every_pixel),
        cmocka_unit_test(a_thread_is_followed_where_no_corner_saw_it),
        cmocka_unit_test(a_picture_grows_finer_and_ends_as_if_nobody_had_looked),
        cmocka_unit_test(looking_changes_no_byte_of_an_adaptive_picture),
        cmocka_unit_test(a_picture_may_be_stopped_after_any_step),
        cmocka_unit_test(bytes_are_the_same_for_any_number_of_threads_in_every_mode),
        cmocka_unit_test(any_allocation_may_fail_in_every_mode),
        cmocka_unit_test(a_stop_in_the_middle_is_heard_in_every_mode),
        cmocka_unit_test(pictures_of_any_size_are_whole),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
