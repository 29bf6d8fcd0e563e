/* Several volumes along one ray: closed forms, every build against the reference in double precision, and the general
 * kernel against those of one plain volume. */
#include "fields.h"
#include "scene/colors.h"
#include "scene/lens.h"
#include "together.h"
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

extern const vvi_ray_kernels vvi_ray_kernels_scalar;
extern const vv_renderer vvi_renderer_raycast;

static void look_down(test_together *t, double height)
{
    test_ray_scene_look(&t->part[0], vvi_vec(0.21, 0.19, 20), vvi_vec(0.21, 0.19, 0), 0, height);
}

static const float *pixel(const vv_image *image, int32_t x, int32_t y)
{
    return image->rgba + 4 * (y * image->width + x);
}

static const double red[3] = {1, 0, 0}, blue[3] = {0, 0, 1};

static void overlapping_boxes_add_their_extinctions(void **state)
{
    (void)state;
    test_together t = {0};
    test_together_box(&t, 0, 1, 1.5, red);
    test_together_box(&t, -0.3, 0.4, 2.5, blue);
    look_down(&t, 0.5);
    /* from above: red alone over [0.4, 1], both over [0, 0.4], blue alone over [-0.3, 0] */
    const double through_red = exp(-1.5 * 0.6), through_both = through_red * exp(-4 * 0.4);
    const double want_red = 1 - through_red + (through_red - through_both) * 1.5 / 4;
    const double want_blue = (through_red - through_both) * 2.5 / 4 + through_both * (1 - exp(-2.5 * 0.3));
    const double want_alpha = 1 - through_both * exp(-2.5 * 0.3);
    /* opacity for any step; colours once the steps' own mixing is fine, or whole steps fit all parts */
    const char *const steps[] = {"0.1", "0.02", "0.37", "5"};
    for (const char *const *cpu = test_ray_cpus(); *cpu; cpu++)
        for (size_t i = 0; i < 4; i++) {
            test_ray_scene *s = test_together_all(&t);
            test_ray_scene_set(s, "step", steps[i]);
            vv_image *image = test_ray_picture(s, *cpu, 1);
            const float *p = pixel(image, 30, 31);
            assert_true(fabs((double)p[3] - want_alpha) < 1e-5);
            if (i < 2) {
                assert_true(fabs((double)p[0] - want_red) < 1e-5);
                assert_true(fabs((double)p[2] - want_blue) < 1e-5);
            }
            vv_image_release(image);
        }
    test_together_finish(&t);
}

static void boxes_apart_keep_their_own_lengths(void **state)
{
    (void)state;
    test_together t = {0};
    test_together_box(&t, 0, 0.7, 1.1, red);
    test_together_box(&t, 0, 9.17, 0.05, blue)->actor.index_to_world.origin.z -= 9.27; /* begins 0.1 below */
    look_down(&t, 0.3);
    for (const char *const *cpu = test_ray_cpus(); *cpu; cpu++) {
        test_ray_scene *s = test_together_all(&t);
        test_ray_scene_set(s, "step", "0.14"); /* red takes five steps, blue begins within the sixth */
        vv_image *image = test_ray_picture(s, *cpu, 1);
        const float *p = pixel(image, 32, 32);
        const double through = exp(-1.1 * 0.7), all = through * exp(-0.05 * 9.17);
        assert_true(fabs((double)p[0] - (1 - through)) < 2e-6);
        assert_true(fabs((double)p[2] - (through - all)) < 2e-6);
        assert_true(fabs((double)p[3] - (1 - all)) < 2e-6);
        vv_image_release(image);
    }
    test_together_finish(&t);
}

static double half_value(vv_vec3 p)
{
    return 0.55 - p.z; /* 0 at z = 0.55, solid below */
}
static vv_vec3 down(vv_vec3 p)
{
    (void)p;
    return (vv_vec3){0, 0, -1};
}
static const test_form floor_form = {"floor", half_value, down};

/* A solid whose upper face is at z = 0.55, inside a red fog over [0, 1]; and another one hidden below it. */
static void a_solid_ends_the_ray_inside_a_fog(void **state)
{
    (void)state;
    test_together t = {0};
    test_together_box(&t, 0, 1, 2, red);
    for (int i = 0; i < 2; i++) {
        test_ray_scene *s = test_together_add(&t, test_field_cube(&floor_form, 8, 0, 1 - 0.2 * i, NULL));
        s->actor.classes.kind = VV_SEGMENT_THRESHOLD;
        s->actor.classes.lo = 0.1 * i; /* the second one's face is at 0.45 */
        s->actor.classes.hi = 10;
        s->actor.color[0] = s->actor.color[1] = 0;
        s->actor.color[2] = i ? 0 : 1;
    }
    look_down(&t, 0.4);
    for (const char *const *cpu = test_ray_cpus(); *cpu; cpu++)
        for (int order = 0; order < 2; order++) {
            test_ray_scene *s = test_together_all(&t);
            if (order) {
                const vv_actor swap = t.actors[0];
                t.actors[0] = t.actors[2], t.actors[2] = swap;
            }
            test_ray_scene_set(s, "step", "0.13");
            vv_image *image = test_ray_picture(s, *cpu, 1);
            const float *p = pixel(image, 32, 32);
            const double through = exp(-2 * 0.45);
            assert_true(fabs((double)p[0] - (1 - through)) < 1e-5);
            assert_true(fabs((double)p[2] - through) < 1e-5);
            assert_true(p[3] == 1);
            assert_true(fabs((double)image->depth[32 * 64 + 32] - (20 - (1 - log(2) / 2))) < 0.13);
            vv_image_release(image);
        }
    test_together_finish(&t);
}

static void several_isosurfaces_show_the_nearest(void **state)
{
    (void)state;
    test_together t = {0};
    for (int i = 0; i < 3; i++) {
        test_ray_scene *s = test_together_add(&t, test_field_cube(&floor_form, 8, 0, 1, NULL));
        s->actor.iso = i == 1 ? 0.05 : 0.2;
        s->actor.color[0] = (float)i;
    }
    look_down(&t, 0.4);
    test_ray_scene *s = test_together_all(&t);
    test_ray_scene_set(s, "mode", "isosurface");
    vv_image *image = test_ray_picture(s, NULL, 1);
    assert_true(pixel(image, 32, 32)[0] == 1);
    assert_true(fabs((double)image->depth[32 * 64 + 32] - 19.5) < 1e-5);
    vv_image_release(image);
    test_together_finish(&t);
}

/* Pre-integration ---------------------------------------------------------------------------------------------------
 */

static double z_value(vv_vec3 p)
{
    return 1 - p.z;
}
/** 0 where a ray along -z enters, 1 where it leaves. */
static const test_form along_view = {"along view", z_value, down};

/* A spike of extinction 20 between 0.48 and 0.52: midpoints of 4, 8 and 16 steps see nothing of it. */
static void a_spike_is_seen_whole_by_any_number_of_steps(void **state)
{
    (void)state;
    static const char *const steps[] = {"0.25", "0.125", "0.0625", "0.030303030303030304", "0.01", "0.003", "2"};
    test_together t = {0};
    test_ray_scene *s = test_together_add(&t, test_field_cube(&along_view, 5, 0, 1, NULL));
    const double k = test_opacity_of(2); /* for a length of 0.1 */
    s->actor.classes.opacity_length = 0.1;
    test_ray_scene_opacity(s, (const double[]){0, 0, 0.48, 0, 0.48, k, 0.52, k, 0.52, 0, 1, 0}, 6);
    look_down(&t, 0.3);
    test_together_all(&t);
    test_ray_scene_set(s, "preintegrated", "true");
    for (const char *const *cpu = test_ray_cpus(); *cpu; cpu++)
        for (size_t i = 0; i < sizeof steps / sizeof *steps; i++) {
            test_ray_scene_set(s, "step", steps[i]);
            vv_image *image = test_ray_picture(s, *cpu, 1);
            const double got = (double)pixel(image, 32, 32)[3];
            if (!(fabs(got - 0.550671) < 1e-5))
                fail_msg("%s, step %s: %.7f", *cpu, steps[i], got);
            vv_image_release(image);
        }
    test_together_finish(&t);
}

/* Outermost nodes that are jumps: extinction 20 between 0.3 and 0.3 + width, and in nothing else. */
static void a_box_without_outer_nodes_has_its_own_depth_alone(void **state)
{
    (void)state;
    static const double widths[] = {0.04, 0.002};
    static const char *const steps[] = {"0.25", "0.0625", "0.01", "2"};
    const double k = test_opacity_of(2); /* for a length of 0.1 */
    for (size_t w = 0; w < 2; w++) {
        test_together t = {0};
        test_ray_scene *s = test_together_add(&t, test_field_cube(&along_view, 5, 0, 1, NULL));
        s->actor.classes.opacity_length = 0.1;
        test_ray_scene_opacity(s, (const double[]){0.3, 0, 0.3, k, 0.3 + widths[w], k, 0.3 + widths[w], 0}, 4);
        test_ray_scene_color(s, (const double[]){0.3, 1, 1, 1}, 1);
        look_down(&t, 0.3);
        test_together_all(&t);
        test_ray_scene_set(s, "preintegrated", "true");
        for (const char *const *cpu = test_ray_cpus(); *cpu; cpu++)
            for (size_t i = 0; i < sizeof steps / sizeof *steps; i++) {
                test_ray_scene_set(s, "step", steps[i]);
                vv_image *image = test_ray_picture(s, *cpu, 1);
                const double got = -log1p(-(double)pixel(image, 32, 32)[3]), want = 20 * widths[w];
                if (!(fabs(got - want) < 2e-5 * want))
                    fail_msg("%s, width %g, step %s: %.8g is not %.8g", *cpu, widths[w], steps[i], got, want);
                vv_image_release(image);
            }
        test_together_finish(&t);
    }
}

/* All nodes at one value, 0.55: nothing on one side, extinction 2 on the other; up and down, by every classifier. */
static void one_jump_parts_what_is_seen_from_what_is_not(void **state)
{
    (void)state;
    test_together t = {0};
    test_ray_scene *s = test_together_add(&t, test_field_cube(&along_view, 5, 0, 1, NULL));
    const double k = test_opacity_of(2);
    look_down(&t, 0.3);
    test_ray_scene_set(s, "step", "0.1");
    for (int down_too = 0; down_too < 2; down_too++) {
        const double rgb[2][3] = {{1, 0.2, 0}, {0, 0.4, 1}};
        test_ray_scene_opacity(s, (const double[]){0.55, down_too ? k : 0, 0.55, down_too ? 0 : k}, 2);
        test_ray_scene_color(
            s, (const double[]){0.55, rgb[0][0], rgb[0][1], rgb[0][2], 0.55, rgb[1][0], rgb[1][1], rgb[1][2]}, 2);
        test_together_all(&t);
        for (const char *const *cpu = test_ray_cpus(); *cpu; cpu++)
            for (int integrated = 0; integrated < 2; integrated++) {
                test_ray_scene_set(s, "preintegrated", integrated ? "true" : "false");
                vv_image *image = test_ray_picture(s, *cpu, 1);
                const float *p = pixel(image, 32, 32);
                /* midpoints of steps of 0.1 lie on the jump: the upper side holds there */
                const double seen = down_too ? (integrated ? 0.55 : 0.5) : integrated ? 0.45 : 0.5;
                const double alpha = test_opacity_of(2 * seen);
                const double slack = integrated ? 1e-5 : test_opacity_of(0.2) + 1e-5;
                if (!(fabs((double)p[3] - alpha) < slack))
                    fail_msg("%s, %s, %d: %g is not %g", *cpu, down_too ? "down" : "up", integrated, (double)p[3],
                             alpha);
                for (int c = 0; c < 3; c++)
                    assert_true(fabs((double)p[c] - (double)p[3] * rgb[!down_too][c]) < 1e-5);
                vv_image_release(image);
            }
    }
    test_together_finish(&t);
}

static void a_ramp_in_front_of_the_light_has_its_closed_form(void **state)
{
    (void)state;
    test_together t = {0};
    test_ray_scene *s = test_together_add(&t, test_field_cube(&along_view, 101, 0, 1, NULL));
    test_ray_scene_opacity(s, (const double[]){0, test_opacity_of(2), 1, test_opacity_of(2)}, 2);
    test_ray_scene_color(s, (const double[]){0, 0, 0, 0, 1, 1, 1, 1}, 2);
    look_down(&t, 0.3);
    test_together_all(&t);
    test_ray_scene_set(s, "step", "0.01");
    test_ray_scene_set(s, "preintegrated", "true");
    const double exact = (1 - 3 * exp(-2)) / 2;
    for (const char *const *cpu = test_ray_cpus(); *cpu; cpu++) {
        vv_image *image = test_ray_picture(s, *cpu, 1);
        assert_true(fabs((double)pixel(image, 32, 32)[0] - exact) < 2e-5);
        vv_image_release(image);
    }
    test_together_finish(&t);
}

/* From which quality on, for a ramp and for peaks of some widths at half of their height, over values from 0 to 1. */
static void narrow_peaks_are_pre_integrated(void **state)
{
    static const struct {
        double opacity[10];
        size_t n;
        int from;
    } functions[] = {
        {{0, 0, 1, 0.5}, 2, VV_QUALITY_REFERENCE},
        {{0, 0, 0.5, 0.01, 0.51, 0.9, 1, 0.9}, 4, VV_QUALITY_REFERENCE}, /* a jump is no peak */
        {{0, 0, 0.48, 0, 0.5, 0.5, 0.52, 0}, 4, VV_QUALITY_NORMAL},
        {{0, 0, 0.45, 0, 0.46, 0.5, 0.54, 0.5, 0.55, 0}, 5, VV_QUALITY_NORMAL},    /* flat on top */
        {{0, 0, 0.4, 0, 0.5, 0.5, 0.6, 0}, 4, VV_QUALITY_NORMAL},                  /* 0.1 */
        {{0, 0, 0.35, 0, 0.5, 0.5, 0.65, 0}, 4, VV_QUALITY_REFERENCE},             /* 0.15 */
        {{0, 0, 0.45, 0.4, 0.5, 0.5, 0.55, 0.4, 1, 0.4}, 5, VV_QUALITY_REFERENCE}, /* on a shoulder */
        {{0, 0, 0.97, 0, 0.98, 0.5}, 3, VV_QUALITY_REFERENCE},                     /* what is above stays */
    };
    (void)state;
    for (size_t i = 0; i < sizeof functions / sizeof *functions; i++) {
        test_together t = {0};
        test_ray_scene *s = test_together_add(&t, test_field_cube(&along_view, 5, 0, 1, NULL));
        test_ray_scene_opacity(s, functions[i].opacity, functions[i].n);
        for (int quality = VV_QUALITY_DRAFT; quality <= VV_QUALITY_REFERENCE; quality++) {
            void *prepared = NULL;
            s->scene.quality = quality;
            assert_int_equal(vvi_raycast_prepare(&prepared, &s->scene, NULL), VV_OK);
            if (vvi_raycast_is_plain(prepared) != (quality < functions[i].from))
                fail_msg("function %zu at quality %d", i, quality);
            vvi_raycast_finish(prepared);
        }
        test_together_finish(&t);
    }
}

/* Random volumes ----------------------------------------------------------------------------------------------------
 */

static const vv_type types[] = {VV_TYPE_U8, VV_TYPE_U16, VV_TYPE_I16, VV_TYPE_F32};

/* Random samples in a sheared box near the origin, with ramps and a jump. */
static test_ray_scene *add_random(test_together *t, vv_type type, uint64_t seed)
{
    vv_field_info info = vv_field_info_default();
    info.type = type;
    for (uint64_t a = 0; a < 3; a++)
        info.grid.dims[a] = 2 + (int64_t)(test_random(seed, a) % 12);
    info.grid.index_to_world.axis[0] = vvi_vec(-1.1 + 0.6 * test_random_unit(seed, 4), 0.1, 0);
    info.grid.index_to_world.axis[1] = vvi_vec(0.2, 0.9, 0.1);
    info.grid.index_to_world.axis[2] = vvi_vec(0, -0.3, 1.4 - 0.5 * test_random_unit(seed, 5));
    info.grid.index_to_world.origin = vvi_vec(3 * test_random_unit(seed, 6), -2, 4 * test_random_unit(seed, 7) - 4);
    test_ray_scene *s = test_together_add(t, test_field_random(&info, seed, NULL));
    const double lo = s->statistics.min, w = s->statistics.max - lo;
    test_ray_scene_opacity(
        s, (const double[]){lo, 0, lo + 0.4 * w, 0, lo + 0.5 * w, 0.3, lo + 0.7 * w, 0.1, lo + 0.7 * w, 0, lo + w, 0.6},
        6);
    test_ray_scene_color(s, (const double[]){lo, 0.1, 0.9, 0.2, lo + 0.5 * w, 0.9, 0.3, 0.1, lo + w, 0.2, 0.3, 1}, 3);
    s->actor.nearest = seed % 5 == 0;
    s->actor.two_sided = seed % 3 != 0;
    s->actor.cap = seed % 2 == 0;
    s->actor.id = t->n == 1 ? "a" : t->n == 2 ? "b" : "c";
    if (seed % 3 == 2) {
        s->actor.n_planes = 1;
        s->planes[0] = (vv_plane){{0.6, 0, 0.8}, -3 + 2 * test_random_unit(seed, 8)};
    }
    return s;
}

/* The picture's view and light, given to all volumes. */
static void look_at_all(test_together *t, uint64_t seed)
{
    test_ray_scene *s = &t->part[0];
    vv_vec3 away = {test_random_unit(seed, 1) - 0.5, test_random_unit(seed, 2) - 0.5, test_random_unit(seed, 3) - 0.4};
    assert_true(vvi_unit(&away));
    s->scene.width = 23; /* no multiple of a packet or a tile */
    s->scene.height = s->scene.rows = 19;
    const vv_vec3 at = {0, 1, 0};
    test_ray_scene_look(s, vvi_add(at, vvi_scaled(away, 25)), at, seed % 2 ? 0 : 0.5, 14);
    test_ray_scene_set(s, "step", "0.37");
    if (seed % 4 == 0)
        return;
    test_ray_scene_light(s);
    for (size_t i = 1; i < t->n; i++)
        t->part[i].actor.shading_model = i == 1 ? VV_SHADING_PHONG : VV_SHADING_NONE;
}

static void compare_with_reference(const test_ray_scene *s, const char *cpu, const char *what, const double *want)
{
    vv_image *image = cpu ? test_ray_picture(s, cpu, 1) : test_ray_picture_by(s, &vvi_ray_kernels_scalar);
    const int n = s->scene.width * s->scene.height;
    int bad = 0;
    double worst = 0;
    for (int i = 0; i < n; i++) {
        double d = 0;
        for (int c = 0; c < 4; c++)
            d = fmax(d, fabs((double)image->rgba[4 * i + c] - want[5 * i + c]));
        bad += d > 2e-3;
        worst = fmax(worst, d);
    }
    if (bad > 0.03 * n)
        fail_msg("%s, %s: %d of %d pixels differ, by up to %g", cpu ? cpu : "scalar", what, bad, n, worst);
    vv_image_release(image);
}

static void compare_all_builds(test_together *t, const char *what)
{
    const test_ray_scene *s = test_together_all(t);
    double *want = test_ray_reference(s);
    double most = 0;
    for (int i = 0; i < s->scene.width * s->scene.height; i++)
        most = fmax(most, want[5 * i + 3]);
    if (most < 0.1)
        fail_msg("%s: there is nothing to compare", what);
    for (const char *const *cpu = test_ray_cpus(); *cpu; cpu++)
        compare_with_reference(s, *cpu, what, want);
    compare_with_reference(s, NULL, what, want);
    free(want);
}

/* What the volumes of a random picture have beside values. */
typedef enum feature {
    PLAIN,
    INTEGRATED,
    MODULATED,
    PLANE,
    LABELS,
    CUBIC,
    CUBIC_INTEGRATED,
    COLORS,
    MAP,
    FEATURES
} feature;
static const char *const feature_names[] = {"plain", "integrated",        "modulated", "plane", "labels",
                                            "cubic", "cubic, integrated", "colours",   "map"};

static void give_regions(vv_actor *actor, vv_region regions[2])
{
    const double lo = actor->statistics->min, w = actor->statistics->max - lo;
    regions[0] = (vv_region){.value_lo = lo + 0.2 * w,
                             .value_hi = lo + 0.5 * w,
                             .top_lo = lo + 0.4 * w,
                             .top_hi = lo + 0.9 * w,
                             .gradient_hi = INFINITY,
                             .color = {1, 0.5, 0.2},
                             .opacity = 0.6,
                             .edge = 0.5};
    regions[1] = (vv_region){.value_lo = lo + 0.6 * w,
                             .value_hi = lo + 0.6 * w,
                             .top_lo = lo + 0.3 * w,
                             .top_hi = lo + 0.9 * w,
                             .gradient_lo = 0.05 * w,
                             .gradient_hi = 0.3 * w,
                             .color = {0.2, 0.5, 1},
                             .opacity = 0.4,
                             .edge = 1};
    actor->classes.regions = regions;
    actor->classes.n_regions = 2;
    actor->classes.gradient_top = 0.4 * w;
}

/* The samples of a volume become alpha or luminance of random colours on the same grid. */
static void give_colors(test_together *t, size_t i, bool alpha, uint64_t seed)
{
    vv_actor *actor = &t->part[i].actor;
    vv_field_info info = *vv_field_get_info(t->field[i]);
    vv_field *scalar = NULL;
    info.type = seed % 3 ? VV_TYPE_U8 : VV_TYPE_F32;
    info.components = alpha ? 4 : 3;
    info.meaning = alpha ? VV_MEANING_RGBA : VV_MEANING_RGB;
    vv_field *colors = test_field_random(&info, seed, NULL);
    assert_non_null(colors);
    assert_int_equal(vvi_colors_scalar(&scalar, colors, seed % 2, NULL), VV_OK);
    vv_field_release(t->field[i]);
    t->field[i] = scalar;
    t->extra[i] = colors;
    actor->field = scalar;
    actor->colors = colors;
    actor->colors_encoded = seed % 2;
    assert_int_equal(vv_field_statistics(actor->statistics, scalar, 0, NULL), VV_OK);
    test_ray_scene_opacity(&t->part[i], (const double[]){0, 0, 0.3, 0, 1, 0.7}, 3);
}

/* Colours by another field that covers a part of the volume. */
static void give_map(test_together *t, size_t i, uint64_t seed)
{
    vv_actor *actor = &t->part[i].actor;
    vv_field_info info = *vv_field_get_info(t->field[i]);
    info.type = types[seed % 4];
    info.grid.dims[0] = 5, info.grid.dims[1] = 4, info.grid.dims[2] = 6;
    info.grid.index_to_world.axis[1] = vvi_vec(0.1, 1.7, 0.2);
    vv_field *field = test_field_random(&info, seed, NULL);
    assert_non_null(field);
    vv_statistics *s = malloc(sizeof *s);
    assert_non_null(s);
    assert_int_equal(vv_field_statistics(s, field, 0, NULL), VV_OK);
    const double rows[] = {s->min, 1, 0, 0, (s->min + s->max) / 3, 0, 1, 0, s->max, 0, 0, 1};
    memcpy(t->map[i], rows, sizeof rows);
    free(s);
    t->extra[i] = field;
    actor->paint = (vv_paint){.field = field,
                              .index_to_world = info.grid.index_to_world,
                              .nearest = seed % 2,
                              .color = t->map[i],
                              .n_color = 3};
}

static void use_feature(test_together *t, feature f, uint64_t seed)
{
    if (f == INTEGRATED || f == CUBIC_INTEGRATED)
        test_ray_scene_set(&t->part[0], "preintegrated", "true");
    for (size_t i = 0; i < t->n; i++) {
        vv_actor *actor = &t->part[i].actor;
        if (actor->classes.kind == VV_SEGMENT_THRESHOLD)
            continue;
        if (f == MODULATED) {
            actor->classes.gradient_power = i == 0 ? 2 : 0.7;
            actor->classes.gradient_reference = 0.3 * (actor->statistics->max - actor->statistics->min);
        } else if (f == PLANE) {
            give_regions(actor, t->regions[i]);
        } else if (f == LABELS && !vv_type_is_float(vv_field_get_info(actor->field)->type)) {
            actor->nearest = false;
            actor->classes.kind = VV_SEGMENT_LABELS;
            actor->classes.label_opacity = 0.4;
        } else if (f == CUBIC || f == CUBIC_INTEGRATED) {
            actor->nearest = false;
            actor->cubic = true;
        } else if (f == COLORS) {
            give_colors(t, i, seed % 4 < 2, seed + i);
        } else if (f == MAP) {
            give_map(t, i, seed + i);
        }
    }
}

static void one_volume_of_each_kind_equals_the_reference_in_every_build(void **state)
{
    (void)state;
    for (uint64_t round = 0; round < 8; round++)
        for (feature f = INTEGRATED; f < FEATURES; f++) {
            const uint64_t seed = test_random(test_seed(), 3000 + round);
            test_together t = {0};
            char what[64];
            add_random(&t, types[round % 4], seed);
            look_at_all(&t, seed);
            use_feature(&t, f, seed);
            snprintf(what, sizeof what, "%s, round %d, seed %llu", feature_names[f], (int)round,
                     (unsigned long long)seed);
            compare_all_builds(&t, what);
            test_together_finish(&t);
        }
}

static void cubic_surfaces_equal_the_reference_in_every_build(void **state)
{
    (void)state;
    for (uint64_t round = 0; round < 8; round++) {
        const uint64_t seed = test_random(test_seed(), 5000 + round);
        test_together t = {0};
        char what[64];
        vv_actor *actor = &add_random(&t, types[round % 4], seed)->actor;
        look_at_all(&t, seed);
        use_feature(&t, CUBIC, seed);
        const double lo = t.part[0].statistics.min, w = t.part[0].statistics.max - lo;
        actor->iso = lo + 0.7 * w;
        if (round % 2) {
            actor->classes.kind = VV_SEGMENT_THRESHOLD;
            actor->classes.lo = lo + 0.6 * w;
            actor->classes.hi = lo + 0.8 * w;
        } else {
            test_ray_scene_set(&t.part[0], "mode", "isosurface");
        }
        snprintf(what, sizeof what, "round %d, seed %llu", (int)round, (unsigned long long)seed);
        compare_all_builds(&t, what);
        test_together_finish(&t);
    }
}

/* Isosurfaces and solids in the colours of the volume itself and in those of another. */
static void painted_surfaces_equal_the_reference_in_every_build(void **state)
{
    (void)state;
    for (uint64_t round = 0; round < 16; round++) {
        const uint64_t seed = test_random(test_seed(), 5500 + round);
        test_together t = {0};
        char what[64];
        vv_actor *actor = &add_random(&t, types[round % 4], seed)->actor;
        look_at_all(&t, seed);
        use_feature(&t, round & 4 ? MAP : COLORS, seed);
        const double lo = actor->statistics->min, w = actor->statistics->max - lo;
        actor->iso = lo + 0.6 * w;
        if (round & 8) {
            actor->classes.kind = VV_SEGMENT_THRESHOLD;
            actor->classes.lo = lo + 0.5 * w;
            actor->classes.hi = lo + 0.8 * w;
        } else {
            test_ray_scene_set(&t.part[0], "mode", "isosurface");
        }
        snprintf(what, sizeof what, "round %d, seed %llu", (int)round, (unsigned long long)seed);
        compare_all_builds(&t, what);
        test_together_finish(&t);
    }
}

/* A ball of radius 9 by its squared distance, which a spline holds exactly: where it is, and how it is lit. */
static void a_cubic_surface_of_a_ball_is_where_it_is(void **state)
{
    (void)state;
    enum { N = 28 };
    test_together t = {0};
    vv_field_info info = vv_field_info_default();
    vv_field *field;
    void *data;
    info.type = VV_TYPE_F32;
    info.grid.dims[0] = info.grid.dims[1] = info.grid.dims[2] = N;
    assert_int_equal(vv_field_new_empty(&field, &data, &info, NULL), VV_OK);
    const vv_vec3 middle = {13.2, 13.6, 13.9};
    for (int i = 0; i < N * N * N; i++) {
        const vv_vec3 p = vvi_sub(vvi_vec(i % N, i / N % N, i / (N * N)), middle);
        ((float *)data)[i] = (float)-vvi_dot(p, p);
    }
    test_ray_scene *s = test_together_add(&t, field);
    test_ray_scene_look(s, vvi_vec(13.2, 13.6, 60), middle, 0, 16);
    s->actor.cubic = true;
    s->actor.iso = -81;
    test_together_all(&t);
    test_ray_scene_set(s, "mode", "isosurface");
    for (const char *const *cpu = test_ray_cpus(); *cpu; cpu++)
        for (int skipping = 0; skipping < 2; skipping++) {
            test_ray_scene_set(s, "skipping", skipping ? "true" : "false");
            vv_image *image = test_ray_picture(s, *cpu, 1);
            for (int y = 12; y < 52; y++) /* the mirrored border is felt a little everywhere */
                for (int x = 12; x < 52; x++) {
                    const double dx = (x - 31.5) / 4, dy = (y - 31.5) / 4;
                    const double want = 60 - (13.9 + sqrt(81 - dx * dx - dy * dy));
                    assert_true(fabs((double)image->depth[y * 64 + x] - want) < 5e-3);
                }
            vv_image_release(image);
        }
    test_together_finish(&t);
}

static void pixels_of_several_volumes_equal_the_reference_in_every_build(void **state)
{
    (void)state;
    for (uint64_t round = 0; round < 36; round++) {
        const uint64_t seed = test_random(test_seed(), round);
        test_together t = {0};
        char what[64];
        for (uint64_t i = 0; i < 2 + round % 2; i++)
            add_random(&t, types[(round + i) % 4], test_random(seed, 50 + i));
        if (round % 4 == 3) {
            vv_actor *solid = &t.part[1].actor;
            solid->classes.kind = VV_SEGMENT_THRESHOLD;
            solid->classes.lo = t.part[1].statistics.min + 0.8 * (t.part[1].statistics.max - t.part[1].statistics.min);
            solid->classes.hi = t.part[1].statistics.max;
        }
        look_at_all(&t, seed);
        use_feature(&t, (feature)(round / 2 % FEATURES), seed);
        snprintf(what, sizeof what, "round %d, seed %llu", (int)round, (unsigned long long)seed);
        compare_all_builds(&t, what);
        test_together_finish(&t);
    }
}

/* Beside a volume that is all clear, a plain one is drawn by the general kernel. */
static void a_plain_volume_is_the_same_as_by_its_own_kernel(void **state)
{
    (void)state;
    for (uint64_t round = 0; round < 12; round++) {
        test_together t = {0};
        add_random(&t, types[round % 4], test_random(test_seed(), 400 + round));
        add_random(&t, VV_TYPE_U8, 7);
        test_ray_scene_opacity(&t.part[1], (const double[]){0, 0}, 1);
        t.part[1].actor.index_to_world.origin = vvi_vec(1e4, 1e4, 1e4); /* where no ray comes that meets the other */
        look_at_all(&t, round);
        for (const char *const *cpu = test_ray_cpus(); *cpu; cpu++) {
            test_ray_scene *s = test_together_all(&t);
            vv_image *general = test_ray_picture(s, *cpu, 1);
            s->scene.n_actors = 1;
            vv_image *own = test_ray_picture(s, *cpu, 1);
            for (int i = 0; i < 23 * 19 * 4; i++)
                if (fabsf(general->rgba[i] - own->rgba[i]) > 2e-5f)
                    fail_msg("%s round %d: %g for %g", *cpu, (int)round, (double)general->rgba[i],
                             (double)own->rgba[i]);
            for (int i = 0; i < 23 * 19; i++)
                assert_true(general->depth[i] == own->depth[i] || fabsf(general->depth[i] - own->depth[i]) < 1.0f);
            vv_image_release(general);
            vv_image_release(own);
        }
        test_together_finish(&t);
    }
}

/* Bright specks in a dark box. */
static vv_field *specks(uint64_t seed, const vv_vec3 origin)
{
    vv_field_info info = vv_field_info_default();
    info.grid.dims[0] = 37, info.grid.dims[1] = 41, info.grid.dims[2] = 29;
    info.grid.index_to_world.origin = origin;
    vv_field *field;
    void *data;
    assert_int_equal(vv_field_new_empty(&field, &data, &info, NULL), VV_OK);
    uint8_t *v = data;
    memset(v, 10, 37 * 41 * 29);
    for (uint64_t i = 0; i < 60; i++)
        v[test_random(seed, i) % (37 * 41 * 29)] = (uint8_t)(100 + test_random(seed, i + 100) % 156);
    return field;
}

static test_ray_scene *add_specks(test_together *t, uint64_t seed, vv_vec3 origin)
{
    test_ray_scene *s = test_together_add(t, specks(seed, origin));
    test_ray_scene_opacity(s, (const double[]){30, 0, 60, 0.2, 255, 0.9}, 3);
    test_ray_scene_color(s, (const double[]){0, 0.1, 0.9, 0.2, 100, 0.9, 0.3, 0.1, 255, 0.2, 0.3, 1}, 3);
    return s;
}

static void compare_skipping(test_together *t, const char *cpu, uint64_t seed)
{
    test_ray_scene *s = &t->part[0];
    const vv_vec3 at = {20, 20, 15};
    vv_vec3 away = {test_random_unit(seed, 1) - 0.5, test_random_unit(seed, 2) - 0.5, test_random_unit(seed, 3) - 0.4};
    assert_true(vvi_unit(&away));
    test_ray_scene_look(s, vvi_add(at, vvi_scaled(away, 150)), at, seed % 2 ? 0 : 0.5, 60);
    test_ray_scene_light(s);
    s->scene.width = s->scene.height = s->scene.rows = 32;
    test_together_all(t);
    test_ray_scene_set(s, "skipping", "false");
    test_ray_scene_set(s, "parc", "false");
    vv_image *without = test_ray_picture(s, cpu, 1);
    for (int i = 1; i < 4; i++) {
        test_ray_scene_set(s, "skipping", i & 1 ? "true" : "false");
        test_ray_scene_set(s, "parc", i & 2 ? "true" : "false");
        vv_image *with = test_ray_picture(s, cpu, 1);
        assert_memory_equal(with->rgba, without->rgba, 32 * 32 * 4 * sizeof(float));
        assert_memory_equal(with->depth, without->depth, 32 * 32 * sizeof(float));
        vv_image_release(with);
    }
    vv_image_release(without);
}

static void skipping_and_parc_change_no_byte(void **state)
{
    (void)state;
    for (const char *const *cpu = test_ray_cpus(); *cpu; cpu++)
        for (uint64_t round = 0; round < 8; round++) {
            const uint64_t seed = test_random(test_seed(), 900 + round);
            test_together t = {0};
            add_specks(&t, seed, vvi_vec(0, 0, 0));
            add_specks(&t, seed + 1, vvi_vec(11.3, -5.2, 7.7));
            t.part[1].actor.nearest = round % 3 == 2;
            test_ray_scene_set(&t.part[0], "step", round % 2 ? "0.37" : "1.3");
            test_ray_scene_set(&t.part[0], "preintegrated", round > 2 ? "true" : "false");
            t.part[0].actor.classes.gradient_power = round == 4 ? 1 : 0;
            t.part[0].actor.classes.gradient_reference = 50;
            t.part[0].actor.cubic = round == 5 || round == 6;
            t.part[1].actor.cubic = round == 6;
            if (round == 7)
                give_regions(&t.part[0].actor, t.regions[0]);
            if (round == 1) /* all of one is clear: the steps of the other stay where they are */
                test_ray_scene_opacity(&t.part[0], (const double[]){0, 0}, 1);
            compare_skipping(&t, *cpu, seed);
            test_together_finish(&t);
        }
}

static void any_number_of_threads_gives_the_same_bytes(void **state)
{
    (void)state;
    test_together t = {0};
    for (uint64_t i = 0; i < 3; i++)
        add_random(&t, types[i], test_random(test_seed(), i));
    look_at_all(&t, test_seed());
    test_ray_scene *s = test_together_all(&t);
    s->scene.width = 75;
    s->scene.height = s->scene.rows = 61;
    vv_image *single = test_ray_picture(s, NULL, 1);
    for (int threads = 2; threads <= 3; threads++) {
        vv_image *more = test_ray_picture(s, NULL, threads);
        assert_memory_equal(single->rgba, more->rgba, 75 * 61 * 4 * sizeof(float));
        assert_memory_equal(single->depth, more->depth, 75 * 61 * sizeof(float));
        vv_image_release(more);
    }
    vv_image_release(single);
    test_together_finish(&t);
}

static void what_cannot_be_shown_together_is_refused(void **state)
{
    (void)state;
    test_together t = {0};
    test_together_box(&t, 0, 1, 1, red);
    test_together_box(&t, 0, 1, 1, blue);
    test_ray_scene *s = test_together_all(&t);
    assert_int_equal(vvi_renderer_raycast.accepts(&s->scene), VV_OK);
    vv_actor many[VVI_BLEND_VOLUMES + 1];
    for (size_t i = 0; i <= VVI_BLEND_VOLUMES; i++)
        many[i] = t.actors[0];
    s->scene.actors = many;
    s->scene.n_actors = VVI_BLEND_VOLUMES;
    assert_int_equal(vvi_renderer_raycast.accepts(&s->scene), VV_OK);
    s->scene.n_actors = VVI_BLEND_VOLUMES + 1;
    assert_int_equal(vvi_renderer_raycast.accepts(&s->scene), VV_E_UNSUPPORTED);
    assert_non_null(strstr(vv_error_last()->message, "at most 8 volumes"));
    test_together_finish(&t);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(overlapping_boxes_add_their_extinctions),
        cmocka_unit_test(boxes_apart_keep_their_own_lengths),
        cmocka_unit_test(a_solid_ends_the_ray_inside_a_fog),
        cmocka_unit_test(several_isosurfaces_show_the_nearest),
        cmocka_unit_test(a_spike_is_seen_whole_by_any_number_of_steps),
        cmocka_unit_test(a_box_without_outer_nodes_has_its_own_depth_alone),
        cmocka_unit_test(one_jump_parts_what_is_seen_from_what_is_not),
        cmocka_unit_test(a_ramp_in_front_of_the_light_has_its_closed_form),
        cmocka_unit_test(narrow_peaks_are_pre_integrated),
        cmocka_unit_test(one_volume_of_each_kind_equals_the_reference_in_every_build),
        cmocka_unit_test(cubic_surfaces_equal_the_reference_in_every_build),
        cmocka_unit_test(painted_surfaces_equal_the_reference_in_every_build),
        cmocka_unit_test(a_cubic_surface_of_a_ball_is_where_it_is),
        cmocka_unit_test(pixels_of_several_volumes_equal_the_reference_in_every_build),
        cmocka_unit_test(a_plain_volume_is_the_same_as_by_its_own_kernel),
        cmocka_unit_test(skipping_and_parc_change_no_byte),
        cmocka_unit_test(any_number_of_threads_gives_the_same_bytes),
        cmocka_unit_test(what_cannot_be_shown_together_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
