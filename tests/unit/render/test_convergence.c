/* How errors shrink: with the step along a ray, with the spacing of the grid, and how far a surface seen through a
 * filter lies from that of the signal itself (Marschner and Lobb 1994). Truth is a formula or a double-precision sum.
 */
#include "core/cpu.h"
#include "core/job.h"
#include "fields.h"
#include "ray_scene.h"
#include "render/common/cubic_spline.h"
#include "render/raycast/raycast_ref.h"
#include "scene/lens.h"
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static void set(test_ray_scene *s, const char *path, const char *json)
{
    vv_object *params = &s->params->base;
    assert_int_equal(vv_path_set(&params, path, json, NULL), VV_OK);
    s->params = (vvi_raycast_params *)params;
    s->scene.params = params;
}

/* Slope of log(error) over log(h) by least squares: the order of convergence. */
static double observed_order(const double *h, const double *error, int n)
{
    double mx = 0, my = 0, sxx = 0, sxy = 0;
    for (int i = 0; i < n; i++) {
        mx += log(h[i]) / n;
        my += log(error[i]) / n;
    }
    for (int i = 0; i < n; i++) {
        sxx += (log(h[i]) - mx) * (log(h[i]) - mx);
        sxy += (log(h[i]) - mx) * (log(error[i]) - my);
    }
    return sxy / sxx;
}

static double report_order(const char *what, const double *h, const double *error, int n)
{
    const double order = observed_order(h, error, n);
    print_message("%s: order %.3f, errors", what, order);
    for (int i = 0; i < n; i++)
        print_message(" %.3g", error[i]);
    print_message("\n");
    return order;
}

static void check_order(const char *what, const double *h, const double *error, int n, double want)
{
    const double order = report_order(what, h, error, n);
    if (!(fabs(order - want) <= 0.1))
        fail_msg("%s: order %g where %g is expected", what, order, want);
}

/* Steps -------------------------------------------------------------------------------------------------------------
 */

/* 0 at z = 1, where a ray enters, to 1 at z = 0, and linear in every variable: trilinear samples of it are exact. */
static double twisted_value(vv_vec3 p)
{
    return (1 - p.z) * (1 - 0.2 * p.x * p.y);
}
static vv_vec3 twisted_gradient(vv_vec3 p)
{
    return (vv_vec3){-0.2 * p.y * (1 - p.z), -0.2 * p.x * (1 - p.z), 0.2 * p.x * p.y - 1};
}
static const test_form twisted = {"twisted", twisted_value, twisted_gradient};

/* Light of one ray with opacity 0.9 v per length and red v, by midpoints of 40000 parts in double. */
static double light_along(double x, double y)
{
    enum { N = 40000 };
    double clear = 1, light = 0;
    for (int i = 0; i < N; i++) {
        const double v = twisted_value((vv_vec3){x, y, 1 - (i + 0.5) / N}), through = exp(log(1 - 0.9 * v) / N);
        light += clear * (1 - through) * v;
        clear *= through;
    }
    return light;
}

/* The mean over pixels averages out where values fall between the rows of the transfer table. */
static double step_error(test_ray_scene *s, int parts, const double *want)
{
    char text[64];
    snprintf(text, sizeof text, "%.17g", 1.0 / parts);
    set(s, "step", text);
    vv_image *image = test_ray_picture(s, NULL, 2);
    const int n = s->scene.width * s->scene.height;
    double sum = 0;
    for (int i = 0; i < n; i++)
        sum += (double)image->rgba[4 * i] - want[i];
    vv_image_release(image);
    return fabs(sum / n);
}

static void check_steps(const char *what, const char *preintegrated)
{
    enum { SIZE = 32, LEVELS = 6 };
    vv_field *field = test_field_cube(&twisted, 9, 0, 1, NULL);
    test_ray_scene s;
    test_ray_scene_init(&s, field, 0.9);
    s.scene.width = s.scene.height = s.scene.rows = SIZE;
    test_ray_scene_opacity(&s, (const double[]){0, 0, 1, 0.9}, 2);
    test_ray_scene_color(&s, (const double[]){0, 0, 0, 0, 1, 1, 1, 1}, 2);
    set(&s, "preintegrated", preintegrated);
    static double want[SIZE * SIZE];
    double h[LEVELS], error[LEVELS];
    for (int y = 0; y < SIZE; y++)
        for (int x = 0; x < SIZE; x++)
            want[y * SIZE + x] =
                light_along(0.5 + ((x + 0.5) / SIZE - 0.5) * 0.9, 0.5 - ((y + 0.5) / SIZE - 0.5) * 0.9);
    for (int i = 0; i < LEVELS; i++) {
        h[i] = 1.0 / (2 << i);
        error[i] = step_error(&s, 2 << i, want);
    }
    check_order(what, h, error, LEVELS, 2);
    test_ray_scene_finish(&s);
    vv_field_release(field);
}

static void halving_the_step_quarters_the_error(void **state)
{
    (void)state;
    check_steps("midpoint steps", "false");
    check_steps("integrated steps", "true");
}

/* Grids -------------------------------------------------------------------------------------------------------------
 */

static double waves_value(vv_vec3 p)
{
    return sin(2 * p.x + 0.3) * cos(1.5 * p.y) + 0.5 * sin(p.z * 2.5 + p.x);
}
static vv_vec3 waves_gradient(vv_vec3 p)
{
    const double z = 0.5 * cos(p.z * 2.5 + p.x);
    return (vv_vec3){2 * cos(2 * p.x + 0.3) * cos(1.5 * p.y) + z, -1.5 * sin(2 * p.x + 0.3) * sin(1.5 * p.y), 2.5 * z};
}
static const test_form waves = {"waves", waves_value, waves_gradient};

enum { POINTS = 4000 };

/* Values and gradients (by world length) of a field at world points, as kernels see them. */
typedef struct probe {
    vv_vec3 at[POINTS];
    double value[POINTS];
    vv_vec3 gradient[POINTS];
} probe;

static void take_samples(probe *p, const vv_field *field, bool nearest)
{
    static float in[3][POINTS], out[4][POINTS];
    float *gradient[3] = {out[1], out[2], out[3]};
    const vv_affine m = vv_field_get_info(field)->grid.index_to_world;
    vv_affine back;
    vvi_lattice_hold hold;
    assert_true(vv_affine_invert(&back, m));
    assert_int_equal(vvi_lattice_open(&hold, field, 0, NULL), VV_OK);
    for (int i = 0; i < POINTS; i++) {
        const vv_vec3 index = vv_affine_point(back, p->at[i]);
        in[0][i] = (float)index.x, in[1][i] = (float)index.y, in[2][i] = (float)index.z;
    }
    vvi_ray_kernels_for(vvi_job_cpu(NULL))
        ->sample(out[0], gradient, &hold.lattice, nearest, in[0], in[1], in[2], POINTS);
    for (int i = 0; i < POINTS; i++) { /* grids of these tests are cubes along the axes */
        p->value[i] = (double)out[0][i];
        p->gradient[i] =
            vvi_scaled((vv_vec3){(double)out[1][i], (double)out[2][i], (double)out[3][i]}, 1 / m.axis[0].x);
    }
    vvi_lattice_close(&hold);
}

static void place_points(probe *p, double lo, double hi)
{
    for (uint64_t i = 0; i < POINTS; i++) {
        double c[3];
        for (uint64_t a = 0; a < 3; a++)
            c[a] = lo + (hi - lo) * test_random_unit(1994, 3 * i + a);
        p->at[i] = (vv_vec3){c[0], c[1], c[2]};
    }
}

static double value_rms(const probe *p, const test_form *form)
{
    double sum = 0;
    for (int i = 0; i < POINTS; i++)
        sum += pow(p->value[i] - form->value(p->at[i]), 2);
    return sqrt(sum / POINTS);
}

static double gradient_rms(const probe *p, const test_form *form)
{
    double sum = 0;
    for (int i = 0; i < POINTS; i++) {
        const vv_vec3 d = vvi_sub(p->gradient[i], form->gradient(p->at[i]));
        sum += vvi_dot(d, d);
    }
    return sqrt(sum / POINTS);
}

static void halving_the_spacing_quarters_the_error_of_values_and_gradients(void **state)
{
    (void)state;
    enum { LEVELS = 5 };
    static probe p;
    double h[LEVELS], value[LEVELS], gradient[LEVELS], nearest[LEVELS];
    place_points(&p, -0.7, 0.7); /* inside: differences at the border are one-sided, of order 1 */
    for (int i = 0; i < LEVELS; i++) {
        const int64_t cells = 8 << i;
        vv_field *field = test_field_cube(&waves, cells + 1, -1, 1, NULL);
        assert_non_null(field);
        h[i] = 2.0 / (double)cells;
        take_samples(&p, field, true);
        nearest[i] = value_rms(&p, &waves);
        take_samples(&p, field, false);
        value[i] = value_rms(&p, &waves);
        gradient[i] = gradient_rms(&p, &waves);
        vv_field_release(field);
    }
    check_order("nearest values", h, nearest, LEVELS, 1);
    check_order("trilinear values", h, value, LEVELS, 2);
    check_order("central-difference gradients", h, gradient, LEVELS, 2);
}

/* Marschner and Lobb ------------------------------------------------------------------------------------------------
 */

enum { ML_SIZE = 96 };
static const double ml_iso = 0.5, ml_width = 1.8;

/* Along -z the signal only rises: each ray meets the surface once. */
static double signal_root(double x, double y)
{
    double low = 1, high = -1;
    for (int i = 0; i < 60; i++) {
        const double z = (low + high) / 2;
        if (test_form_marschner_lobb.value((vv_vec3){x, y, z}) >= ml_iso)
            high = z;
        else
            low = z;
    }
    return high;
}

/* The trilinear filter as its formula, in double, on the samples of a field over [-1, 1]^3. */
static double trilinear_at(const vv_brick *b, double x, double y, double z)
{
    const int64_t n = b->box.n[0];
    const double at[3] = {(x + 1) / 2 * (double)(n - 1), (y + 1) / 2 * (double)(n - 1), (z + 1) / 2 * (double)(n - 1)};
    const float *v = b->data;
    double sum = 0;
    int64_t from[3];
    for (int a = 0; a < 3; a++)
        from[a] = (int64_t)fmin(fmax(floor(at[a]), 0), (double)n - 2);
    for (int c = 0; c < 8; c++) {
        double w = 1;
        int64_t p[3];
        for (int a = 0; a < 3; a++) {
            const double part = at[a] - (double)from[a];
            p[a] = from[a] + (c >> a & 1);
            w *= c >> a & 1 ? part : 1 - part;
        }
        sum += w * (double)v[(p[2] * n + p[1]) * n + p[0]];
    }
    return sum;
}

/* Where a ray along -z first meets the surface seen through that filter: by 400 steps and bisection. */
static double trilinear_root(const vv_brick *b, double x, double y)
{
    enum { STEPS = 400 };
    double before = 1, z = 1;
    for (int i = 1; i <= STEPS; i++) {
        z = 1 - 2.0 * i / STEPS;
        if (trilinear_at(b, x, y, z) >= ml_iso)
            break;
        before = z;
    }
    for (int i = 0; i < 50; i++) {
        const double mid = (before + z) / 2;
        if (trilinear_at(b, x, y, mid) >= ml_iso)
            z = mid;
        else
            before = mid;
    }
    return z;
}

static double pixel_place(int32_t i)
{
    return ((i + 0.5) / ML_SIZE - 0.5) * ml_width;
}

/* Places z of the surface along -z through the pixels of a picture of a field over [-1, 1]^3. */
typedef struct heights {
    double x[ML_SIZE * ML_SIZE], y[ML_SIZE * ML_SIZE], z[ML_SIZE * ML_SIZE];
} heights;

static void find_heights(heights *h, const vv_field *field, bool nearest)
{
    test_ray_scene s;
    test_ray_scene_init(&s, field, ml_width);
    s.scene.width = s.scene.height = s.scene.rows = ML_SIZE;
    s.actor.nearest = nearest;
    test_ray_scene_look(&s, (vv_vec3){0, 0, 3}, (vv_vec3){0, 0, 0}, 0, ml_width);
    set(&s, "mode", "isosurface");
    set(&s, "iso", "0.5");
    vv_image *image = test_ray_picture(&s, NULL, 2);
    for (int32_t i = 0; i < ML_SIZE * ML_SIZE; i++) {
        const vv_vec3 p = vvi_add(vvi_scaled(s.scene.lens.right, pixel_place(i % ML_SIZE)),
                                  vvi_scaled(s.scene.lens.up, -pixel_place(i / ML_SIZE)));
        h->x[i] = p.x;
        h->y[i] = p.y;
        h->z[i] = 3 - (double)image->depth[i];
        assert_true(isfinite(h->z[i]));
    }
    vv_image_release(image);
    test_ray_scene_finish(&s);
}

/* RMS distance along the rays from the surface of the signal. */
static double place_rms(const heights *h)
{
    double sum = 0;
    for (int i = 0; i < ML_SIZE * ML_SIZE; i++)
        sum += pow(h->z[i] - signal_root(h->x[i], h->y[i]), 2);
    return sqrt(sum / (ML_SIZE * ML_SIZE));
}

/* The kernels show the surface of the trilinear filter, to single precision. */
static void check_filter(const heights *h, const vv_field *field)
{
    const vv_box box = vv_field_box(field);
    vv_brick b;
    assert_int_equal(vv_field_brick(&b, field, &box, NULL), VV_OK);
    for (int i = 0; i < ML_SIZE * ML_SIZE; i += 7)
        if (!(fabs(h->z[i] - trilinear_root(&b, h->x[i], h->y[i])) < 1e-5))
            fail_msg("ray (%g, %g) meets the surface at %g instead of %g", h->x[i], h->y[i], h->z[i],
                     trilinear_root(&b, h->x[i], h->y[i]));
    vv_brick_release(&b);
}

/* Mean angle in degrees between normals at points on the signal's surface and the signal's own. */
static double normal_angle(const probe *p)
{
    double sum = 0;
    for (int i = 0; i < POINTS; i++) {
        vv_vec3 got = p->gradient[i], want = test_form_marschner_lobb.gradient(p->at[i]);
        assert_true(vvi_unit(&got) && vvi_unit(&want));
        sum += acos(fmin(fmax(vvi_dot(got, want), -1), 1)) * 180 / M_PI;
    }
    return sum / POINTS;
}

typedef struct ml_row {
    int64_t n;
    bool nearest;
    /* limits: RMS of values (over [0, 1]) and of the surface's place (world; a voxel is 2 / (n - 1)), mean angle */
    double value, place, degrees;
} ml_row;

/* What the filters' formulas make of the signal's own samples, and 1 % for the choice of points. The signal is near
 * what such a grid can hold at all, so the errors are large: they tell filters apart. */
static const ml_row ml_rows[] = {
    {41, true, 0.0491, 0.0806, 41.9},
    {41, false, 0.0353, 0.0557, 34.0},
    {40, true, 0.0497, 0.0807, 43.3},
    {40, false, 0.0361, 0.0573, 35.9},
};

static void check_row(const ml_row *row)
{
    static probe p;
    static heights h;
    vv_field *field = test_field_cube(&test_form_marschner_lobb, row->n, -1, 1, NULL);
    place_points(&p, -0.9, 0.9);
    take_samples(&p, field, row->nearest);
    const double value = value_rms(&p, &test_form_marschner_lobb);
    for (int i = 0; i < POINTS; i++)
        p.at[i].z = signal_root(p.at[i].x, p.at[i].y);
    take_samples(&p, field, row->nearest);
    const double degrees = normal_angle(&p);
    find_heights(&h, field, row->nearest);
    const double place = place_rms(&h);
    print_message("Marschner-Lobb %d^3 %-9s: values %.4f, surface %.4f, normals %.1f degrees\n", (int)row->n,
                  row->nearest ? "nearest" : "trilinear", value, place, degrees);
    assert_true(value <= row->value && place <= row->place && degrees <= row->degrees);
    if (!row->nearest)
        check_filter(&h, field);
    vv_field_release(field);
}

static void the_marschner_lobb_signal_is_seen_as_well_as_each_filter_can(void **state)
{
    (void)state;
    for (size_t r = 0; r < sizeof ml_rows / sizeof *ml_rows; r++)
        check_row(&ml_rows[r]);
}

/* The place of a surface has the order of its filter. */
static void halving_the_spacing_quarters_the_error_of_a_surface(void **state)
{
    (void)state;
    enum { LEVELS = 5 };
    static heights seen;
    double h[LEVELS], error[LEVELS];
    for (int i = 0; i < LEVELS; i++) { /* from 97 samples on: about twelve to a wave */
        const int64_t cells = (int64_t)(96 * pow(1.2, i));
        vv_field *field = test_field_cube(&test_form_marschner_lobb, cells + 1, -1, 1, NULL);
        h[i] = 2.0 / (double)cells;
        find_heights(&seen, field, false);
        error[i] = place_rms(&seen);
        vv_field_release(field);
    }
    check_order("surface of Marschner-Lobb", h, error, LEVELS, 2);
}

/* Cubic interpolation -------------------------------------------------------------------------------------------------
 */

/* A field as the reference sees it through the cubic filter, in double, by world places of a cube over [-1, 1]^3. */
typedef struct spline {
    vvi_raycast_volume volume;
    vv_actor actor;
    vv_statistics unused;
    vvi_ref_ray ray;
} spline;

static void open_spline(spline *s, const vv_field *field)
{
    memset(s, 0, sizeof *s);
    vvi_march_volume *f = &s->volume.ray;
    const int64_t n = vv_field_get_info(field)->grid.dims[0];
    assert_int_equal(vvi_lattice_open_cubic(&s->volume.hold, field, 0, NULL), VV_OK);
    f->sampler.lattice = s->volume.hold.lattice;
    for (int a = 0; a < 3; a++)
        f->sampler.world_to_index[a][a] = f->sampler.world_to_index[a][3] = (double)(n - 1) / 2;
    s->volume.ray.sampler.cubic = true;
    s->actor.statistics = &s->unused;
    s->volume.actor = &s->actor;
    s->ray.volume = &s->volume;
}

static double spline_value(spline *s, vv_vec3 at)
{
    s->ray.origin = at;
    return vvi_ref_value(&s->ray, 0);
}

static void take_spline_samples(probe *p, spline *s)
{
    for (int i = 0; i < POINTS; i++) {
        p->value[i] = spline_value(s, p->at[i]);
        p->gradient[i] = vvi_ref_gradient(&s->ray, 0);
    }
}

static void halving_the_spacing_takes_a_sixteenth_of_the_error_of_cubic_values(void **state)
{
    (void)state;
    enum { LEVELS = 5 };
    static const int64_t cells[LEVELS] = {16, 22, 30, 42, 58};
    static probe p;
    double h[LEVELS], value[LEVELS], gradient[LEVELS];
    place_points(&p, -0.4, 0.4); /* the mirror at the border is felt some samples inwards */
    for (int i = 0; i < LEVELS; i++) {
        spline s;
        vv_field *field = test_field_cube(&waves, cells[i] + 1, -1, 1, NULL);
        open_spline(&s, field);
        take_spline_samples(&p, &s);
        h[i] = 2.0 / (double)cells[i];
        value[i] = value_rms(&p, &waves);
        gradient[i] = gradient_rms(&p, &waves);
        vvi_lattice_close(&s.volume.hold);
        vv_field_release(field);
    }
    /* 4 and 3, and more while what the border does wrong dies away */
    assert_true(report_order("cubic values", h, value, LEVELS) >= 3.5);
    assert_true(report_order("cubic gradients", h, gradient, LEVELS) >= 2.5);
}

/* Where a ray along -z first meets the surface seen through the cubic filter. */
static double spline_root(spline *s, double x, double y)
{
    enum { STEPS = 200 };
    double before = 1, z = 1;
    for (int i = 1; i <= STEPS; i++) {
        z = 1 - 2.0 * i / STEPS;
        if (spline_value(s, (vv_vec3){x, y, z}) >= ml_iso)
            break;
        before = z;
    }
    for (int i = 0; i < 40; i++) {
        const double mid = (before + z) / 2;
        if (spline_value(s, (vv_vec3){x, y, mid}) >= ml_iso)
            z = mid;
        else
            before = mid;
    }
    return z;
}

/* Depths of a cloud that is clear below the surface's value and opaque from it on are those of the surface. */
static void check_cloud(spline *s, const vv_field *field)
{
    enum { SIZE = 16 };
    const double step = 1.0 / 1024;
    test_ray_scene scene;
    test_ray_scene_init(&scene, field, ml_width);
    scene.scene.width = scene.scene.height = scene.scene.rows = SIZE;
    scene.actor.cubic = true;
    test_ray_scene_look(&scene, (vv_vec3){0, 0, 3}, (vv_vec3){0, 0, 0}, 0, ml_width);
    test_ray_scene_opacity(&scene, (const double[]){0, 0, ml_iso, 0, ml_iso, 0.999, 1, 0.999}, 4);
    scene.actor.classes.opacity_length = step;
    set(&scene, "step", "0.0009765625");
    set(&scene, "preintegrated", "false");
    vv_image *image = test_ray_picture(&scene, NULL, 2);
    const vv_lens *l = &scene.scene.lens;
    for (int i = 0; i < SIZE * SIZE; i++) {
        const double u = ((i % SIZE + 0.5) / SIZE - 0.5) * ml_width, v = (0.5 - (i / SIZE + 0.5) / SIZE) * ml_width;
        const vv_vec3 p = vvi_add(vvi_scaled(l->right, u), vvi_scaled(l->up, v));
        const double got = 3 - (double)image->depth[i], want = spline_root(s, p.x, p.y);
        if (!(fabs(got - want) < 2 * step)) /* half a step, and a row of the transfer table */
            fail_msg("ray (%g, %g) meets the surface at %g instead of %g", p.x, p.y, got, want);
    }
    vv_image_release(image);
    test_ray_scene_finish(&scene);
}

static double spline_place_rms(spline *s)
{
    enum { SIZE = 40 };
    double sum = 0;
    for (int i = 0; i < SIZE * SIZE; i++) {
        const double x = ((i % SIZE + 0.5) / SIZE - 0.5) * ml_width, y = ((i / SIZE + 0.5) / SIZE - 0.5) * ml_width;
        sum += pow(spline_root(s, x, y) - signal_root(x, y), 2);
    }
    return sqrt(sum / (SIZE * SIZE));
}

typedef struct cubic_row {
    int64_t n;
    double value, place, degrees; /* limits, as of ml_row */
    double share;                 /* of the place's error of the trilinear filter */
} cubic_row;

/* At 41^3 the signal is so near to what the grid can hold that no cubic filter does better than half of the trilinear
 * one's error; with a fifth more samples a side it is a sixth. */
static const cubic_row cubic_rows[] = {
    {40, 0.0181, 0.0275, 14.0, 0.5},
    {41, 0.0166, 0.0278, 12.4, 0.5},
    {49, 0.0061, 0.0066, 5.3, 0.25},
};

static void check_cubic_row(const cubic_row *row)
{
    static probe p;
    static spline s;
    static heights trilinear;
    vv_field *field = test_field_cube(&test_form_marschner_lobb, row->n, -1, 1, NULL);
    open_spline(&s, field);
    place_points(&p, -0.9, 0.9);
    take_spline_samples(&p, &s);
    const double value = value_rms(&p, &test_form_marschner_lobb), place = spline_place_rms(&s);
    for (int i = 0; i < POINTS; i++)
        p.at[i].z = signal_root(p.at[i].x, p.at[i].y);
    take_spline_samples(&p, &s);
    const double degrees = normal_angle(&p);
    print_message("Marschner-Lobb %d^3 cubic    : values %.4f, surface %.4f, normals %.1f degrees\n", (int)row->n,
                  value, place, degrees);
    assert_true(value <= row->value && place <= row->place && degrees <= row->degrees);
    find_heights(&trilinear, field, false);
    assert_true(place <= row->share * place_rms(&trilinear));
    check_cloud(&s, field);
    vvi_lattice_close(&s.volume.hold);
    vv_field_release(field);
}

static void a_cubic_curve_sees_the_marschner_lobb_signal_better(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof cubic_rows / sizeof *cubic_rows; i++)
        check_cubic_row(&cubic_rows[i]);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(halving_the_step_quarters_the_error),
        cmocka_unit_test(halving_the_spacing_quarters_the_error_of_values_and_gradients),
        cmocka_unit_test(the_marschner_lobb_signal_is_seen_as_well_as_each_filter_can),
        cmocka_unit_test(halving_the_spacing_quarters_the_error_of_a_surface),
        cmocka_unit_test(halving_the_spacing_takes_a_sixteenth_of_the_error_of_cubic_values),
        cmocka_unit_test(a_cubic_curve_sees_the_marschner_lobb_signal_better),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
