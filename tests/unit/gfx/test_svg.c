/* Figures: valid documents that, drawn by another program, look like the software back end's picture. */
#include "core/memory.h"
#include "core/text.h"
#include "gfx/gfx.h"
#include "io/source.h"
#include "io/xml.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

enum { WIDTH = 320, HEIGHT = 200 };
static const vv_color black = {0, 0, 0, 1}, blue = {0.1, 0.2, 0.8, 1}, paper = {1, 1, 1, 1};

/* A plot and a ball with a line through it. */
static void draw_ball(vvi_gfx *gfx)
{
    enum { N = 24 };
    static float positions[3 * (N + 1) * (2 * N + 1)];
    static uint32_t triangles[12 * N * N];
    static vv_mesh_info info;
    const vv_lens lens = {.eye = {0, -6, 0},
                          .right = {1, 0, 0},
                          .up = {0, 0, 1},
                          .forward = {0, 1, 0},
                          .half_width = 0.48,
                          .half_height = 0.3};
    const vv_lamp lamp = {.kind = VV_LIGHT_DIRECTIONAL, .direction = {0.6, 0.8, 0}, .color = {1, 1, 1}};
    uint32_t t = 0;
    for (uint32_t j = 0, v = 0; j <= N; j++)
        for (uint32_t i = 0; i <= 2 * N; i++, v++) {
            const double p = 3.14159265 * j / N, q = 3.14159265 * i / N;
            positions[3 * v] = (float)(1.6 + sin(p) * cos(q));
            positions[3 * v + 1] = (float)(sin(p) * sin(q));
            positions[3 * v + 2] = (float)cos(p);
            if (j == N || i == 2 * N)
                continue;
            const uint32_t six[6] = {v, v + 2 * N + 1, v + 1, v + 1, v + 2 * N + 1, v + 2 * N + 2};
            memcpy(triangles + t, six, sizeof six);
            t += 6;
        }
    info = (vv_mesh_info){.n_vertices = (size_t)(N + 1) * (2 * N + 1),
                          .n_triangles = t / 3,
                          .positions = positions,
                          .triangles = triangles};
    const vvi_gfx_surface surface = {.mesh = &info, .place = vv_affine_identity(), .color = {0.8, 0.5, 0.3, 1}};
    const vv_vec3 through[2] = {{0, 0, -0.4}, {3.2, 0, 0.4}};
    const vvi_gfx_stroke stroke = {.color = blue, .width = 3};
    vvi_gfx_camera(gfx, &lens);
    assert_int_equal(vvi_gfx_lights(gfx, &lamp, 1, NULL), VV_OK);
    assert_int_equal(vvi_gfx_mesh(gfx, &surface), VV_OK);
    assert_int_equal(vvi_gfx_line(gfx, through, 2, VVI_GFX_STRIP, &stroke), VV_OK);
}

static void draw_figure(vvi_gfx *gfx, bool letters)
{
    assert_int_equal(vvi_gfx_rectangle(gfx, 20, 20, 140, 150, &(vvi_gfx_fill){.color = paper}), VV_OK);
    draw_ball(gfx);
    vvi_gfx_camera(gfx, NULL);
    vvi_gfx_window(gfx, 20, 20, 140, 150);
    vv_vec3 curve[41];
    for (int i = 0; i <= 40; i++)
        curve[i] = (vv_vec3){15 + 3.5 * i, 90 - 75 * sin(i * 0.25), 0};
    assert_int_equal(vvi_gfx_line(gfx, curve, 41, VVI_GFX_STRIP, &(vvi_gfx_stroke){.color = blue, .width = 2.5}),
                     VV_OK);
    assert_int_equal(vvi_gfx_points(gfx, curve, 41, 6, (vv_color){0.8, 0.1, 0.1, 0.5}), VV_OK);
    vvi_gfx_window(gfx, 0, 0, 0, 0);
    const vv_vec3 frame[4] = {{20, 20, 0}, {140, 20, 0}, {140, 150, 0}, {20, 150, 0}};
    assert_int_equal(vvi_gfx_line(gfx, frame, 4, VVI_GFX_LOOP, &(vvi_gfx_stroke){.color = black, .width = 1}), VV_OK);
    const vvi_gfx_stroke dashes = {.color = black, .width = 2, .dash = 8, .space = 6};
    assert_int_equal(vvi_gfx_line(gfx, (vv_vec3[]){{20, 85, 0}, {140, 85, 0}}, 2, VVI_GFX_STRIP, &dashes), VV_OK);
    const vvi_gfx_stop stops[3] = {{0, {0, 0, 0, 1}}, {0.4, {1, 0, 0, 1}}, {1, {1, 1, 0, 0.25}}};
    const vvi_gfx_fill legend = {.stops = stops, .n_stops = 3, .from = {20, 0, 0}, .to = {140, 0, 0}};
    assert_int_equal(vvi_gfx_rectangle(gfx, 20, 165, 140, 180, &legend), VV_OK);
    if (!letters)
        return;
    const vvi_gfx_label label = {.size = 12, .color = black, .anchor = VVI_GFX_MIDDLE, .halo = paper};
    const vvi_gfx_label side = {.size = 12, .color = black, .anchor = VVI_GFX_MIDDLE, .quarters = 1};
    assert_int_equal(vvi_gfx_text(gfx, (vv_vec3){80, 196, 0}, &label, "density <g/cm\302\263> & \"more\""), VV_OK);
    assert_int_equal(vvi_gfx_text(gfx, (vv_vec3){14, 85, 0}, &side, "count"), VV_OK);
}

static char *figure(bool letters)
{
    vvi_text out = {0};
    vvi_gfx *gfx;
    const vvi_gfx_target target = {.width = WIDTH, .height = HEIGHT, .svg = &out, .title = "a < b"};
    assert_int_equal(vvi_gfx_begin(&gfx, &vvi_gfx_svg, &target, NULL), VV_OK);
    draw_figure(gfx, letters);
    assert_int_equal(vvi_gfx_end(gfx), VV_OK);
    char *svg = vvi_text_take(&out);
    assert_non_null(svg);
    return svg;
}

static void write_text(char path[64], const char *text)
{
    snprintf(path, 64, "/tmp/volvis-svg-%ld.svg", (long)getpid());
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    assert_true(fputs(text, file) >= 0);
    assert_int_equal(fclose(file), 0);
}

/* Counts of elements. */
typedef struct counts {
    int texts, paths, images, circles, gradients, clips, all;
} counts;

static vv_status count(void *user, vvi_xml *xml, const char *name, const char *const *attributes)
{
    counts *c = user;
    (void)xml, (void)attributes;
    c->all++;
    c->texts += !strcmp(name, "text");
    c->paths += !strcmp(name, "path");
    c->images += !strcmp(name, "image");
    c->circles += !strcmp(name, "circle");
    c->gradients += !strcmp(name, "linearGradient");
    c->clips += !strcmp(name, "clipPath");
    return VV_OK;
}

static void a_figure_is_a_valid_document_with_its_text(void **state)
{
    (void)state;
    char *svg = figure(true), path[64];
    const vvi_xml_events events = {.open = count};
    counts c = {0};
    bool cut;
    vv_source *source;
    write_text(path, svg);
    assert_int_equal(vvi_source_open(&source, path, NULL), VV_OK);
    assert_int_equal(vvi_xml_parse(&cut, source, &events, &c, NULL), VV_OK);
    vvi_source_close(source);
    unlink(path);
    assert_false(cut);
    assert_int_equal(c.texts, 3); /* one with a halo */
    assert_int_equal(c.images, 1);
    assert_int_equal(c.circles, 41);
    assert_int_equal(c.gradients, 1);
    assert_int_equal(c.clips, 1);
    assert_non_null(strstr(svg, "density &lt;g/cm\302\263&gt; &amp; \"more\"</text>"));
    assert_non_null(strstr(svg, "viewBox=\"0 0 320 200\""));
    assert_non_null(strstr(svg, "width=\"84.67mm\"")); /* 320 pixels at 96 an inch */
    assert_non_null(strstr(svg, "<title>a &lt; b</title>"));
    free(svg);
}

static double mean_difference(const vv_image *a, const vv_image *b)
{
    double sum = 0;
    for (size_t i = 0; i < (size_t)4 * WIDTH * HEIGHT; i++)
        sum += fabs((double)a->rgba[i] - (double)b->rgba[i]);
    return sum / (4.0 * WIDTH * HEIGHT);
}

static void another_program_draws_a_figure_as_the_software_back_end_does(void **state)
{
    (void)state;
    if (system("command -v rsvg-convert >/dev/null 2>&1") != 0) {
        print_message("rsvg-convert is missing (librsvg2-bin): figures are not drawn\n");
        skip();
    }
    char *svg = figure(false), path[64], png[80], command[256];
    vv_image *ours, *theirs;
    vvi_gfx *gfx;
    write_text(path, svg);
    free(svg);
    snprintf(png, sizeof png, "%s.png", path);
    snprintf(command, sizeof command, "rsvg-convert -w %d -h %d -o %s %s", WIDTH, HEIGHT, png, path);
    assert_int_equal(system(command), 0);
    assert_int_equal(vv_image_read(&theirs, NULL, NULL, png, NULL), VV_OK);
    assert_int_equal(vv_image_new(&ours, WIDTH, HEIGHT, VV_LAYER_DEPTH, NULL), VV_OK);
    const vvi_gfx_target target = {.image = ours};
    assert_int_equal(vvi_gfx_begin(&gfx, &vvi_gfx_software, &target, NULL), VV_OK);
    draw_figure(gfx, false);
    assert_int_equal(vvi_gfx_end(gfx), VV_OK);
    if (getenv("VOLVIS_TEST_KEEP")) {
        assert_int_equal(vv_image_write("/tmp/volvis-software.png", ours, NULL, NULL), VV_OK);
        print_message("kept %s, /tmp/volvis-software.png\n", png);
    } else {
        unlink(path);
        unlink(png);
    }
    /* edges are blended in sRGB there, linear here; nothing else differs */
    const double difference = mean_difference(ours, theirs);
    print_message("mean difference %.5f\n", difference);
    assert_true(difference < 0.01);
    vv_image_release(ours);
    vv_image_release(theirs);
}

static void a_figure_that_is_given_up_leaves_nothing(void **state)
{
    (void)state;
    vvi_text out = {0};
    vvi_gfx *gfx;
    const vvi_gfx_target target = {.width = WIDTH, .height = HEIGHT, .svg = &out};
    const vvi_gfx_target nothing = {.width = WIDTH, .height = HEIGHT};
    assert_int_equal(vvi_gfx_begin(&gfx, &vvi_gfx_svg, &nothing, NULL), VV_E_ARGUMENT);
    assert_int_equal(vvi_gfx_begin(&gfx, &vvi_gfx_svg, &target, NULL), VV_OK);
    draw_figure(gfx, true);
    vvi_gfx_picked picked;
    assert_int_equal(vvi_gfx_pick(&picked, gfx, 1, 1, 0), VV_E_UNSUPPORTED);
    vvi_gfx_abandon(gfx);
    assert_int_equal(out.n, 0);
    vvi_text_free(&out);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_figure_is_a_valid_document_with_its_text),
        cmocka_unit_test(another_program_draws_a_figure_as_the_software_back_end_does),
        cmocka_unit_test(a_figure_that_is_given_up_leaves_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
