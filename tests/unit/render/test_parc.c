/* PARC: near and far depths against every ray and every box, and pictures that are the same without. */
#include "fail_alloc.h"
#include "fields.h"
#include "jobs.h"
#include "ray_scene.h"
#include "render/march/parc.h"
#include "scene/lens.h"
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

/* Bounds ------------------------------------------------------------------------------------------------------------
 */

/* Some boxes of a grid, kept at random, and a view of them. */
typedef struct situation {
    vvi_minmax minmax;
    float lo[4096], hi[4096];
    vvi_boxes *boxes;
    vv_lens lens;
    vvi_parc_view view;
    vv_affine back;
} situation;

static bool is_one(const void *user, float lo, float hi)
{
    (void)user;
    (void)lo;
    return hi >= 1;
}

static double between(uint64_t seed, uint64_t i, double lo, double hi)
{
    return lo + (hi - lo) * test_random_unit(seed, i);
}

static void place_boxes(situation *s, uint64_t seed)
{
    const double share = between(seed, 1, 0, 0.4);
    size_t n = 1;
    s->minmax = (vvi_minmax){.shift = 3, .lo = s->lo, .hi = s->hi};
    for (int a = 0; a < 3; a++) {
        s->minmax.n[a] = 1 + (int32_t)(test_random(seed, 2 + (uint64_t)a) % 7);
        n *= (size_t)s->minmax.n[a];
    }
    for (size_t i = 0; i < n; i++) {
        s->lo[i] = 0;
        s->hi[i] = test_random_unit(seed, 100 + i) < share ? 1 : 0;
    }
    assert_int_equal(vvi_boxes_build(&s->boxes, &s->minmax, 3, is_one, NULL, NULL), VV_OK);
    vv_affine *m = &s->view.index_to_world;
    m->axis[0] = (vv_vec3){-1.1, 0.1, 0.05};
    m->axis[1] = (vv_vec3){0.2, 0.9, 0.1};
    m->axis[2] = (vv_vec3){0, -0.3, 1.4};
    m->origin = (vv_vec3){4, -7, 2};
    assert_true(vv_affine_invert(&s->back, *m));
    s->view.before = seed % 3 == 0 ? 0.5 : 0;
    for (int a = 0; a < 3; a++) {
        s->view.lo[a] = -s->view.before;
        s->view.hi[a] = s->minmax.n[a] * 8 - between(seed, 5, 0, 7) + s->view.before;
    }
}

/* kind 0: parallel, 1: perspective from outside, 2: perspective from inside, 3: parallel from inside, 4: along an axis
 * of the boxes. */
static void place_lens(situation *s, int kind, uint64_t seed)
{
    vv_vec3 at = {between(seed, 11, s->view.lo[0], s->view.hi[0]), between(seed, 12, s->view.lo[1], s->view.hi[1]),
                  between(seed, 13, s->view.lo[2], s->view.hi[2])};
    at = vv_affine_point(s->view.index_to_world, at);
    vv_lens *l = &s->lens;
    l->forward = (vv_vec3){between(seed, 14, -1, 1), between(seed, 15, -1, 1), between(seed, 16, -1, 1.01)};
    if (kind == 4)
        l->forward = vv_affine_vector(s->view.index_to_world, (vv_vec3){0, seed % 2 ? 1 : -1, 0});
    assert_true(vvi_unit(&l->forward));
    l->right = vvi_cross(l->forward, (vv_vec3){0.3, 0.2, 1});
    assert_true(vvi_unit(&l->right));
    l->up = vvi_cross(l->right, l->forward);
    l->parallel = kind == 0 || kind == 3 || (kind == 4 && seed % 4 < 2);
    const bool inside = kind == 2 || kind == 3;
    l->eye = vvi_sub(at, vvi_scaled(l->forward, inside ? 0 : between(seed, 17, 30, 120)));
    l->half_height = l->parallel ? between(seed, 18, 5, 40) : between(seed, 18, 0.1, inside ? 2 : 0.6);
    l->half_width = l->half_height * 1.2;
    s->view.lens = l;
    s->view.width = 61;
    s->view.height = s->view.rows = 50;
}

/* Where the ray through (px, py) is inside a box: depths along the lens's axis; false where it misses. */
static bool cross_box(double out[2], const situation *s, uint32_t number, double px, double py)
{
    vv_vec3 o, d;
    vvi_lens_ray(&o, &d, &s->lens, s->view.width, s->view.height, px, py);
    const vv_vec3 io = vv_affine_point(s->back, o), id = vv_affine_vector(s->back, d);
    const double from[3] = {io.x, io.y, io.z}, to[3] = {id.x, id.y, id.z};
    int32_t at[3];
    vvi_box_place(at, s->boxes, number);
    double t0 = 0, t1 = INFINITY;
    for (int a = 0; a < 3; a++) {
        const double lo = at[a] == 0 ? s->view.lo[a] : at[a] * 8 - s->view.before;
        const double hi = at[a] + 1 == s->boxes->n[a] ? s->view.hi[a] : (at[a] + 1) * 8 - s->view.before;
        const double x = (lo - from[a]) / to[a], y = (hi - from[a]) / to[a];
        t0 = fmax(t0, fmin(x, y));
        t1 = fmin(t1, fmax(x, y));
    }
    const double depth = vvi_dot(d, s->lens.forward);
    out[0] = t0 * depth;
    out[1] = t1 * depth;
    return t0 < t1;
}

/* How close the bounds are: over cells. */
typedef struct closeness {
    double gap, n_gap;
    int empty, empty_found;
} closeness;

/* Rays all over the pixels of one cell. */
static void check_cell(const situation *s, const vvi_parc *parc, int32_t cx, int32_t cy, uint64_t seed, closeness *c)
{
    const size_t cell = (size_t)cy * (size_t)parc->width + (size_t)cx;
    const double near = parc->origin + (double)parc->near[cell], far = parc->origin + (double)parc->far[cell];
    double first = INFINITY, last = -INFINITY;
    for (uint64_t i = 0; i < 24; i++) {
        const double size = 1 << VVI_PARC_SHIFT;
        const double px = (cx + between(seed, 2 * i, 0, 1)) * size, py = (cy + between(seed, 2 * i + 1, 0, 1)) * size;
        for (size_t b = 0; b < s->boxes->n_kept; b++) {
            double t[2];
            if (!cross_box(t, s, s->boxes->kept[b], px, py))
                continue;
            if (!(near <= t[0] && far >= t[1]))
                fail_msg("a ray is in a box from %.9g to %.9g but bounds are %.9g to %.9g", t[0], t[1], near, far);
            first = fmin(first, t[0]);
            last = fmax(last, t[1]);
        }
    }
    if (first <= last) {
        c->gap += fmin(first - fmax(near, 0), 50) + fmin(far - last, 50);
        c->n_gap += 2;
    } else {
        c->empty++;
        c->empty_found += !(near <= far);
    }
}

static void every_ray_is_in_boxes_only_between_its_bounds(void **state)
{
    (void)state;
    const uint64_t first = test_seed();
    static situation s;
    closeness c = {0};
    for (int round = 0; round < 60; round++) {
        const uint64_t seed = test_random(first, 500 + (uint64_t)round);
        place_boxes(&s, seed);
        place_lens(&s, round % 5, seed);
        vvi_parc parc;
        assert_int_equal(vvi_parc_init(&parc, s.boxes, &s.view, NULL), VV_OK);
        assert_int_equal(parc.width, 16);
        assert_int_equal(parc.height, 13);
        for (int32_t y = 0; y < parc.height; y++)
            for (int32_t x = 0; x < parc.width; x++)
                check_cell(&s, &parc, x, y, test_random(seed, (uint64_t)(y * 100 + x)), &c);
        vvi_parc_finish(&parc);
        vvi_boxes_free(s.boxes);
    }
    /* and no wider than cells make them: boxes have 8 voxels a side */
    assert_true(c.n_gap > 1000 && c.empty > 1000);
    if (!(c.gap / c.n_gap < 3 && c.empty_found > 0.85 * c.empty))
        fail_msg("bounds are %g away on average; %d of %d empty cells are known", c.gap / c.n_gap, c.empty_found,
                 c.empty);
}

static void bounds_are_the_same_for_any_number_of_threads(void **state)
{
    (void)state;
    static situation s;
    place_boxes(&s, test_seed());
    place_lens(&s, 1, test_seed());
    s.view.width = 700;
    s.view.height = s.view.rows = 500;
    vvi_parc one, more;
    assert_int_equal(vvi_parc_init(&one, s.boxes, &s.view, NULL), VV_OK);
    const size_t n = (size_t)one.width * (size_t)one.height;
    for (int threads = 2; threads <= 3; threads++) {
        vv_job *job = test_job(threads, 0);
        assert_int_equal(vvi_parc_init(&more, s.boxes, &s.view, job), VV_OK);
        assert_memory_equal(one.near, more.near, 2 * n * sizeof *one.near);
        vvi_parc_finish(&more);
        vv_job_release(job);
    }
    vvi_parc_finish(&one);
    vvi_boxes_free(s.boxes);
}

static void far_eyes_lose_no_depth(void **state)
{
    (void)state;
    static situation s;
    for (int parallel = 0; parallel < 2; parallel++) {
        place_boxes(&s, 41);
        place_lens(&s, 1, 41);
        s.lens.parallel = parallel;
        s.lens.eye = vvi_sub(s.lens.eye, vvi_scaled(s.lens.forward, 1e7));
        s.lens.half_height = s.lens.half_width = parallel ? 60 : 60 / 1e7;
        vvi_parc parc;
        closeness c = {0};
        assert_int_equal(vvi_parc_init(&parc, s.boxes, &s.view, NULL), VV_OK);
        for (int32_t y = 0; y < parc.height; y++)
            for (int32_t x = 0; x < parc.width; x++)
                check_cell(&s, &parc, x, y, test_random(7, (uint64_t)(y * 100 + x)), &c);
        assert_true(c.n_gap > 10 && c.gap / c.n_gap < 6);
        vvi_parc_finish(&parc);
        vvi_boxes_free(s.boxes);
    }
}

static vv_status init_once(void *user)
{
    const situation *s = user;
    vvi_parc parc;
    const vv_status st = vvi_parc_init(&parc, s->boxes, &s->view, NULL);
    assert_true((st == VV_OK) == (parc.near != NULL));
    vvi_parc_finish(&parc);
    return st;
}

static void bounds_without_memory_are_an_error_and_leave_nothing(void **state)
{
    (void)state;
    static situation s;
    place_boxes(&s, 3);
    place_lens(&s, 0, 3);
    assert_true(test_fail_each_alloc(init_once, &s) >= 1);
    vvi_boxes_free(s.boxes);
}

/* Pictures ----------------------------------------------------------------------------------------------------------
 */

static void set(test_ray_scene *s, const char *path, const char *json)
{
    vv_object *params = &s->params->base;
    assert_int_equal(vv_path_set(&params, path, json, NULL), VV_OK);
    s->params = (vvi_raycast_params *)params;
    s->scene.params = params;
}

/* seed % 9 bright specks and a bright lump in a dark, sheared box. */
static vv_field *make_field(const int64_t dims[3], uint64_t seed)
{
    vv_field_info info = vv_field_info_default();
    memcpy(info.grid.dims, dims, sizeof info.grid.dims);
    info.grid.index_to_world.axis[0] = (vv_vec3){-1.1, 0.1, 0};
    info.grid.index_to_world.axis[2] = (vv_vec3){0, -0.3, 1.4};
    vv_field *field;
    void *data;
    assert_int_equal(vv_field_new_empty(&field, &data, &info, NULL), VV_OK);
    uint8_t *v = data;
    const uint64_t total = (uint64_t)(dims[0] * dims[1] * dims[2]);
    memset(v, 10, total);
    for (uint64_t i = 0; i < seed % 9; i++)
        v[test_random(seed, i) % total] = (uint8_t)(100 + test_random(seed, i + 100) % 156);
    for (int64_t k = dims[2] / 3; k < dims[2] / 2; k++)
        for (int64_t j = dims[1] / 2; j < dims[1] * 2 / 3; j++)
            for (int64_t i = dims[0] / 4; i < dims[0] / 2; i++)
                v[(k * dims[1] + j) * dims[0] + i] = (uint8_t)(120 + test_random(seed, total + (uint64_t)i) % 100);
    return field;
}

/* view 0: parallel, 1: perspective, 2: perspective from inside, 3: along an axis */
static void make_scene(test_ray_scene *s, const vv_field *field, int mode, int view, uint64_t seed)
{
    static const char *const modes[] = {"composite", "isosurface"};
    test_ray_scene_init(s, field, 10);
    s->scene.width = 45;
    s->scene.height = s->scene.rows = 37;
    const vv_bounds b = vv_grid_bounds(&vv_field_get_info(field)->grid);
    const vv_vec3 at = vvi_scaled(vvi_add(b.lo, b.hi), 0.5);
    const double size = vvi_length(vvi_sub(b.hi, b.lo)) + 2;
    vv_vec3 away = {between(seed, 1, -1, 1), between(seed, 2, -1, 1), between(seed, 3, -1, 1.01)};
    assert_true(vvi_unit(&away));
    if (view == 3)
        away = (vv_vec3){0, 1, 0};
    const vv_vec3 eye = vvi_add(at, vvi_scaled(away, size * (view == 2 ? between(seed, 4, 0, 0.2) + 0.01 : 2)));
    test_ray_scene_look(s, eye, at, view == 0 || view == 3 ? 0 : view == 1 ? 0.5 : 1.9, size);
    test_ray_scene_opacity(s, (const double[]){0, 0, 60, 0, 90, 0.3, 255, 0.2}, 4);
    test_ray_scene_color(s, (const double[]){0, 0.1, 0.9, 0.2, 100, 0.9, 0.3, 0.1, 255, 0.2, 0.3, 1}, 3);
    s->actor.iso = 80;
    s->actor.nearest = seed % 4 == 3;
    s->actor.cubic = seed % 4 == 1;
    set(s, "mode", modes[mode]);
    set(s, "step", seed % 2 ? "0.37" : "1.3");
    set(s, "jitter", seed % 3 == 1 ? "true" : "false");
    if (seed % 3)
        test_ray_scene_light(s);
    if (seed % 5 < 2) {
        s->actor.n_planes = 2;
        s->planes[0] = (vv_plane){{0.6, 0, 0.8}, vvi_dot((vv_vec3){0.6, 0, 0.8}, at) - 4};
        s->planes[1] = (vv_plane){{0, -1, 0}, -at.y - 3};
    }
}

/* The picture with all four settings of skipping and parc. */
static void compare_switches(test_ray_scene *s, const char *cpu, bool exact)
{
    static const char *const on[] = {"false", "true"};
    const size_t n = (size_t)s->scene.width * (size_t)s->scene.height;
    vv_image *plain = NULL;
    for (int i = 0; i < 4; i++) {
        set(s, "skipping", on[i & 1]);
        set(s, "parc", on[i >> 1]);
        vv_image *image = test_ray_picture(s, cpu, 1);
        plain = plain ? plain : vv_image_retain(image);
        if (exact) {
            assert_memory_equal(image->rgba, plain->rgba, n * 4 * sizeof(float));
            assert_memory_equal(image->depth, plain->depth, n * sizeof(float));
        }
        for (size_t p = 0; p < n * 4; p++) /* a surface enters cells elsewhere: the same to rounding */
            assert_true(fabsf(image->rgba[p] - plain->rgba[p]) < 2e-3f);
        vv_image_release(image);
    }
    vv_image_release(plain);
}

static void parc_and_skipping_change_no_byte(void **state)
{
    (void)state;
    static const int64_t sizes[][3] = {{41, 37, 45}, {64, 9, 17}, {1, 50, 60}, {30, 1, 1}};
    const uint64_t first = test_seed();
    for (const char *const *cpu = test_ray_cpus(); *cpu; cpu++)
        for (int round = 0; round < 32; round++) {
            const int mode = round >> 2 & 1, view = round & 3;
            const uint64_t seed = test_random(first, 9000 + (uint64_t)round);
            vv_field *field = make_field(sizes[round / 8], seed);
            test_ray_scene s;
            make_scene(&s, field, mode, view, seed);
            compare_switches(&s, *cpu, mode == 0);
            test_ray_scene_finish(&s);
            vv_field_release(field);
        }
}

/* One pass over the whole picture; what it took in *counts_out. */
static vv_image *draw_pass(vv_render_counts *counts_out, const test_ray_scene *s, const vv_pass *pass)
{
    void *prepared;
    vv_image *image;
    const vv_tile all = {0, 0, s->scene.width / pass->stride, s->scene.height / pass->stride};
    *counts_out = (vv_render_counts){0};
    assert_int_equal(vv_image_new(&image, all.x1, all.y1, VV_LAYER_DEPTH, NULL), VV_OK);
    assert_int_equal(vvi_raycast_prepare(&prepared, &s->scene, NULL), VV_OK);
    assert_int_equal(s->scene.renderer->render(prepared, pass, &all, image, counts_out, NULL), VV_OK);
    vvi_raycast_finish(prepared);
    return image;
}

static void rays_anywhere_in_their_pixels_have_bounds(void **state)
{
    (void)state;
    static const vv_pass passes[] = {
        {0.01, 0.99, 1, 0, 0, 7}, {0.93, 0.02, 1, 0, 1, 8}, {-0.4, 1.4, 1, 0, 2, 9}, {2, 2, 4, 0, 0, 5}};
    for (uint64_t round = 0; round < 6; round++) {
        const int64_t dims[3] = {41, 37, 45};
        vv_field *field = make_field(dims, round);
        test_ray_scene s;
        make_scene(&s, field, 0, (int)(round % 3), test_random(test_seed(), round));
        for (size_t i = 0; i < sizeof passes / sizeof *passes; i++) {
            vv_render_counts counts;
            set(&s, "parc", "true");
            vv_image *with = draw_pass(&counts, &s, &passes[i]);
            set(&s, "parc", "false");
            vv_image *without = draw_pass(&counts, &s, &passes[i]);
            const size_t n = (size_t)with->width * (size_t)with->height;
            assert_memory_equal(with->rgba, without->rgba, n * 4 * sizeof(float));
            assert_memory_equal(with->depth, without->depth, n * sizeof(float));
            vv_image_release(with);
            vv_image_release(without);
        }
        test_ray_scene_finish(&s);
        vv_field_release(field);
    }
}

/* What PARC is for: far fewer samples are taken where most of the volume is clear. */
static void rays_march_only_between_their_bounds(void **state)
{
    (void)state;
    const int64_t dims[3] = {90, 90, 90};
    const vv_pass centres = {.x = 0.5, .y = 0.5, .stride = 1};
    vv_field *field = make_field(dims, 0); /* the lump alone */
    vv_render_counts counts[2];
    for (int parc = 0; parc < 2; parc++) {
        test_ray_scene s;
        make_scene(&s, field, 0, 1, 2);
        set(&s, "skipping", "false");
        set(&s, "parc", parc ? "true" : "false");
        vv_image_release(draw_pass(&counts[parc], &s, &centres));
        test_ray_scene_finish(&s);
    }
    assert_true(counts[1].samples * 4 < counts[0].samples && counts[1].samples > 0);
    vv_field_release(field);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_ray_is_in_boxes_only_between_its_bounds),
        cmocka_unit_test(bounds_are_the_same_for_any_number_of_threads),
        cmocka_unit_test(far_eyes_lose_no_depth),
        cmocka_unit_test(bounds_without_memory_are_an_error_and_leave_nothing),
        cmocka_unit_test(parc_and_skipping_change_no_byte),
        cmocka_unit_test(rays_anywhere_in_their_pixels_have_bounds),
        cmocka_unit_test(rays_march_only_between_their_bounds),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
