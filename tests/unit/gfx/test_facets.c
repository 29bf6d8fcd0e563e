/* Areas of figures: painted one over the other they show what is nearest, whatever goes through or around what. */
#include "core/memory.h"
#include "core/text.h"
#include "gfx/facets.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { SIDE = 200, TRIANGLES_MOST = 64 };

/* Looks down from z = 10 at [-1, 1]^2; perspective, so that nearness is no linear function of z. */
static const vv_lens lens = {.eye = {0, 0, 10},
                             .right = {1, 0, 0},
                             .up = {0, 1, 0},
                             .forward = {0, 0, -1},
                             .half_width = 0.1,
                             .half_height = 0.1};

typedef struct soup {
    float positions[9 * TRIANGLES_MOST];
    uint8_t colors[12 * TRIANGLES_MOST];
    uint32_t triangles[3 * TRIANGLES_MOST];
    size_t n;
} soup;

static void add(soup *s, double corner[3][3])
{
    const size_t t = s->n++;
    for (size_t k = 0; k < 3; k++) {
        for (size_t c = 0; c < 3; c++)
            s->positions[9 * t + 3 * k + c] = (float)corner[k][c];
        const uint8_t color[4] = {(uint8_t)(10 + 3 * t), (uint8_t)(250 - 3 * t), (uint8_t)(17 * t), 255};
        memcpy(s->colors + 12 * t + 4 * k, color, 4);
        s->triangles[3 * t + k] = (uint32_t)(3 * t + k);
    }
}

/* Number of the nearest triangle along the ray to a place on the picture: Moeller & Trumbore; -1: none. */
static int nearest(const soup *s, double px, double py)
{
    const double dx = (px / SIDE * 2 - 1) * lens.half_width, dy = (1 - py / SIDE * 2) * lens.half_height;
    double best = INFINITY;
    int found = -1;
    for (size_t t = 0; t < s->n; t++) {
        const float *p = s->positions + 9 * t;
        const vv_vec3 a = {(double)p[0], (double)p[1], (double)p[2]}, d = {dx, dy, -1};
        const vv_vec3 u = {(double)p[3] - a.x, (double)p[4] - a.y, (double)p[5] - a.z},
                      v = {(double)p[6] - a.x, (double)p[7] - a.y, (double)p[8] - a.z}, q = vvi_cross(d, v),
                      from = {-a.x, -a.y, 10 - a.z};
        const double det = vvi_dot(u, q), i = vvi_dot(from, q) / det, j = vvi_dot(d, vvi_cross(from, u)) / det,
                     way = vvi_dot(v, vvi_cross(from, u)) / det;
        if (i >= 0 && j >= 0 && i + j <= 1 && way < best) {
            best = way;
            found = (int)t;
        }
    }
    return found;
}

static bool covers(const vvi_gfx_facet *f, double x, double y)
{
    bool inside = false;
    for (size_t i = 0, j = f->n - 1u; i < f->n; j = i++)
        if ((f->spot[i].y > y) != (f->spot[j].y > y) &&
            x < (f->spot[j].x - f->spot[i].x) * (y - f->spot[i].y) / (f->spot[j].y - f->spot[i].y) + f->spot[i].x)
            inside = !inside;
    return inside;
}

/* Number of the triangle that is painted last at a place. */
static int painted(const vvi_gfx_facets *f, double x, double y)
{
    for (size_t i = f->n; i-- > 0;)
        if (covers(&f->facet[i], x, y))
            return (int)f->facet[i].triangle;
    return -1;
}

static vv_status make_facets(vvi_gfx_facets *out, vvi_gfx **gfx_out, vvi_text *text, const soup *s, size_t most)
{
    static vv_mesh_info info;
    const vvi_gfx_target target = {.width = SIDE, .height = SIDE, .svg = text, .triangles = most};
    const vvi_gfx_material plain = {.model = VV_SHADING_NONE};
    info = (vv_mesh_info){.n_vertices = 3 * s->n,
                          .n_triangles = s->n,
                          .positions = s->positions,
                          .colors = s->colors,
                          .triangles = s->triangles};
    const vvi_gfx_surface surface = {.mesh = &info, .place = vv_affine_identity(), .color = {1, 1, 1, 1}};
    assert_int_equal(vvi_gfx_begin(gfx_out, &vvi_gfx_svg, &target, NULL), VV_OK);
    vvi_gfx_camera(*gfx_out, &lens);
    vvi_gfx_set_material(*gfx_out, &plain);
    *out = (vvi_gfx_facets){0};
    const vv_status st = vvi_gfx_facets_add(out, *gfx_out, &surface);
    return st == VV_OK ? vvi_gfx_facets_finish(out, *gfx_out) : st;
}

/* Share of places of the picture that show another triangle than the nearest. */
static double wrong(const soup *s, size_t *n_out)
{
    vvi_gfx_facets f;
    vvi_gfx *gfx;
    vvi_text text = {0};
    size_t bad = 0;
    assert_int_equal(make_facets(&f, &gfx, &text, s, 20000), VV_OK);
    for (int y = 0; y < SIDE; y++)
        for (int x = 0; x < SIDE; x++)
            bad += painted(&f, x + 0.503, y + 0.497) != nearest(s, x + 0.503, y + 0.497);
    *n_out = f.n;
    vvi_gfx_facets_free(&f);
    vvi_gfx_abandon(gfx);
    return (double)bad / (SIDE * SIDE);
}

static void bars_that_cover_each_other_in_a_circle_are_painted_right(void **state)
{
    soup s = {0};
    size_t n;
    (void)state;
    for (int k = 0; k < 3; k++) {
        const double c = cos(2.0943951 * k), w = sin(2.0943951 * k);
        double bar[3][3] = {{-0.9, 0.2, -0.3}, {0.9, 0.3, 0.3}, {-0.9, 0.4, -0.3}};
        double turned[3][3];
        for (int i = 0; i < 3; i++) {
            turned[i][0] = c * bar[i][0] - w * bar[i][1];
            turned[i][1] = w * bar[i][0] + c * bar[i][1];
            turned[i][2] = bar[i][2];
        }
        add(&s, turned);
    }
    const double share = wrong(&s, &n);
    assert_true(share < 0.0002);
    assert_in_range(n, 4, 20);
}

static void triangles_that_go_through_each_other_are_painted_right(void **state)
{
    soup s = {0};
    size_t n;
    (void)state;
    add(&s, (double[3][3]){{-0.8, -0.8, -1}, {0.8, 0, 1}, {-0.8, 0.8, -1}});
    add(&s, (double[3][3]){{0.8, -0.8, -1}, {-0.8, 0, 1}, {0.8, 0.8, -1}});
    const double share = wrong(&s, &n);
    assert_true(share < 0.0002);
    assert_in_range(n, 3, 8);
}

static double any(uint32_t *seed, double from, double to)
{
    *seed = *seed * 1664525u + 1013904223u;
    return from + (to - from) * (*seed >> 8) / 16777216.0;
}

static void any_triangles_are_painted_right(void **state)
{
    (void)state;
    for (uint32_t run = 1; run <= 12; run++) {
        soup s = {0};
        uint32_t seed = 977 * run;
        size_t n;
        for (int t = 0; t < (run == 1 ? 1 : 5 * (int)run); t++) {
            double corner[3][3];
            for (int k = 0; k < 9; k++)
                corner[k / 3][k % 3] = any(&seed, -1.2, 1.2); /* some are partly outside */
            add(&s, corner);
        }
        const double share = wrong(&s, &n);
        if (share >= 0.002)
            print_message("run %u: %g of the places are wrong, %zu areas\n", run, share, n);
        assert_true(share < 0.002);
    }
}

static void colours_that_differ_within_a_triangle_are_cut_apart(void **state)
{
    soup s = {0};
    vvi_gfx_facets f;
    vvi_gfx *gfx;
    vvi_text text = {0};
    (void)state;
    add(&s, (double[3][3]){{-0.8, -0.8, 0}, {0.8, -0.8, 0}, {-0.8, 0.8, 0}});
    const uint8_t colors[12] = {255, 0, 0, 255, 0, 255, 0, 255, 0, 0, 255, 255};
    memcpy(s.colors, colors, sizeof colors);
    assert_int_equal(make_facets(&f, &gfx, &text, &s, 20000), VV_OK);
    assert_true(f.n > 500);
    double far = 0, area = 0;
    for (size_t i = 0; i < f.n; i++) {
        const vvi_gfx_facet *a = &f.facet[i];
        for (size_t k = 0; k < a->n; k++) {
            /* green is linear along x from 0 at -0.8 to 1 at 0.8; 0.1 of the height is 1 of the world */
            const double green = fmin(1, fmax(0, ((a->spot[k].x / SIDE * 2 - 1) + 0.8) / 1.6));
            far = fmax(far, fabs(vv_srgb_encode(green) - vv_srgb_encode(a->color.g)));
        }
        area += vvi_gfx_facet_area(a->spot, a->n);
    }
    assert_true(far < 0.16); /* 3 pixels where the encoding is steepest; else 8 of 255 */
    assert_true(fabs(area - 0.5 * 160 * 160) < 1);
    vvi_gfx_facets_free(&f);
    vvi_gfx_abandon(gfx);
}

static void too_many_are_refused_with_their_number(void **state)
{
    soup s = {0};
    vvi_gfx_facets f;
    vvi_gfx *gfx;
    vvi_text text = {0};
    (void)state;
    for (int i = 0; i < 30; i++)
        add(&s, (double[3][3]){{-0.8, -0.8, 0.01 * i}, {0.8, -0.8, 0.01 * i}, {-0.8, 0.8, 0.01 * i}});
    assert_int_equal(make_facets(&f, &gfx, &text, &s, 20), VV_E_LIMIT);
    assert_non_null(strstr(vv_error_last()->message, "30 triangles"));
    assert_int_equal(f.n, 0);
    vvi_gfx_facets_free(&f);
    vvi_gfx_abandon(gfx);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bars_that_cover_each_other_in_a_circle_are_painted_right),
        cmocka_unit_test(triangles_that_go_through_each_other_are_painted_right),
        cmocka_unit_test(any_triangles_are_painted_right),
        cmocka_unit_test(colours_that_differ_within_a_triangle_are_cut_apart),
        cmocka_unit_test(too_many_are_refused_with_their_number),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
