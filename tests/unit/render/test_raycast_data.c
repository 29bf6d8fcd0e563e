/* The same volume in any type, at any size in the World, and of any shape makes the same picture. */
#include "fields.h"
#include "grid/field.h"
#include "ray_scene.h"
#include "scene/lens.h"
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static const char *const modes[] = {"composite", "maximum", "isosurface", "mean"};

static void set(test_ray_scene *s, const char *path, const char *json)
{
    vv_object *params = &s->params->base;
    assert_int_equal(vv_path_set(&params, path, json, NULL), VV_OK);
    s->params = (vvi_raycast_params *)params;
    s->scene.params = params;
}

static void set_number(test_ray_scene *s, const char *path, double value)
{
    char text[64];
    snprintf(text, sizeof text, "%.17g", value);
    set(s, path, text);
}

/* Two soft blobs, 0 .. 240: whole numbers of 8 bits. */
static double blobs(int64_t i, int64_t j, int64_t k, const int64_t n[3])
{
    const double x = (double)i - 0.4 * (double)(n[0] - 1), y = (double)j - 0.5 * (double)(n[1] - 1);
    const double z = (double)k - 0.45 * (double)(n[2] - 1), r = 0.3 * (double)(n[0] + n[1] + n[2]) / 3;
    const double far = (x - r) * (x - r) + (y - 0.3 * r) * (y - 0.3 * r) + z * z;
    return floor(160 * exp(-(x * x + y * y + z * z) / (r * r)) + 80 * exp(-far / (0.2 * r * r)));
}

/* Stored = blobs * factor + shift. */
static vv_field *make_blobs(vv_type type, const int64_t n[3], double factor, double shift)
{
    vv_field_info info = vv_field_info_default();
    info.type = type;
    memcpy(info.grid.dims, n, sizeof info.grid.dims);
    vv_field *field;
    void *data;
    assert_int_equal(vv_field_new_empty(&field, &data, &info, NULL), VV_OK);
    char *to = data;
    for (int64_t k = 0; k < n[2]; k++)
        for (int64_t j = 0; j < n[1]; j++)
            for (int64_t i = 0; i < n[0]; i++, to += vv_type_bytes(type)) {
                const double v = blobs(i, j, k, n) * factor + shift;
                vvi_samples_from_f64(to, &v, type, 1);
            }
    return field;
}

/* A shaded picture of blobs whose values are factor times theirs, plus shift. */
static void classify_blobs(test_ray_scene *s, double factor, double shift)
{
    static const double opacity[] = {0, 0, 60, 0, 120, 0.4, 200, 0.1, 240, 0.1};
    static const double color[] = {0, 0.1, 0.9, 0.2, 120, 0.9, 0.3, 0.1, 240, 0.2, 0.3, 1};
    double o[sizeof opacity / sizeof *opacity], c[sizeof color / sizeof *color];
    for (size_t i = 0; i < sizeof o / sizeof *o; i++)
        o[i] = i % 2 ? opacity[i] : opacity[i] * factor + shift;
    for (size_t i = 0; i < sizeof c / sizeof *c; i++)
        c[i] = i % 4 ? color[i] : color[i] * factor + shift;
    test_ray_scene_opacity(s, o, sizeof o / sizeof *o / 2);
    test_ray_scene_color(s, c, sizeof c / sizeof *c / 4);
    test_ray_scene_light(s);
    s->actor.iso = 90 * factor + shift;
}

/* Largest and mean difference of two pictures of one size. */
static void compare(double *worst_out, double *mean_out, const vv_image *a, const vv_image *b)
{
    const int n = a->width * a->height * 4;
    *worst_out = *mean_out = 0;
    for (int i = 0; i < n; i++) {
        const double d = fabs((double)a->rgba[i] - (double)b->rgba[i]);
        assert_true(isfinite(d));
        *worst_out = fmax(*worst_out, d);
        *mean_out += d / n;
    }
}

typedef struct scaled_type {
    vv_type type;
    double factor, shift;
} scaled_type;

static vv_image *picture_of_type(const scaled_type *t, int mode)
{
    vv_field *field = make_blobs(t->type, (const int64_t[3]){27, 24, 30}, t->factor, t->shift);
    test_ray_scene s;
    test_ray_scene_init(&s, field, 34);
    test_ray_scene_look(&s, (vv_vec3){60, 40, 50}, (vv_vec3){13, 12, 15}, 0.5, 0);
    classify_blobs(&s, t->factor, t->shift);
    set(&s, "mode", modes[mode]);
    set(&s, "step", "0.5");
    vv_image *image = test_ray_picture(&s, NULL, 1);
    test_ray_scene_finish(&s);
    vv_field_release(field);
    return image;
}

static void values_scaled_to_other_types_make_the_picture_of_8_bits(void **state)
{
    (void)state;
    static const scaled_type u8 = {VV_TYPE_U8, 1, 0};
    static const scaled_type as[] = {
        {VV_TYPE_U8, 1, 15},         {VV_TYPE_U16, 257, 0},        {VV_TYPE_I16, 1, -120},
        {VV_TYPE_I16, 200, -20000},  {VV_TYPE_F32, 1.0 / 255, 0},  {VV_TYPE_F32, 3.5, 1000},
        {VV_TYPE_F64, 1e-3, 7},      {VV_TYPE_U32, 10000000, 500}, {VV_TYPE_I32, 1000000, -100000000},
        {VV_TYPE_I64, 1e9, -3e10},   {VV_TYPE_F32, 1e-30, 0},      {VV_TYPE_F32, 1e-37, 0},
        {VV_TYPE_F32, 1e-37, 1e-33}, {VV_TYPE_F32, 1e-42, 0},      {VV_TYPE_F32, 1e36, -1e38},
        {VV_TYPE_F64, 1e-300, 0},    {VV_TYPE_F64, 1e300, 0},
    };
    for (int mode = 0; mode < 4; mode++) {
        vv_image *want = picture_of_type(&u8, mode);
        for (size_t i = 0; i < sizeof as / sizeof *as; i++) {
            vv_image *image = picture_of_type(&as[i], mode);
            double worst, mean;
            compare(&worst, &mean, image, want);
            /* rows of the transfer tables lie at other values: a thousandth of the range */
            if (!(worst < 5e-3 && mean < 3e-4))
                fail_msg("%s of %s, times %g plus %g: differs by %g, %g on average", modes[mode],
                         vv_type_name(as[i].type), as[i].factor, as[i].shift, worst, mean);
            vv_image_release(image);
        }
        vv_image_release(want);
    }
}

/* Sizes -------------------------------------------------------------------------------------------------------------
 */

/* Blobs of voxels `size` wide in the World, far from its origin, and a camera whose places scale with them.
 * view 0: parallel, 1: perspective, 2: from inside, 3: parallel from inside. */
static vv_image *picture_of_size(const int64_t n[3], double size, int view, int mode)
{
    vv_field *field = make_blobs(VV_TYPE_U8, n, 1, 0);
    const vv_vec3 middle = {0.5 * (double)(n[0] - 1), 0.5 * (double)(n[1] - 1), 0.5 * (double)(n[2] - 1)};
    const bool inside = view > 1, parallel = view % 3 == 0;
    test_ray_scene s;
    test_ray_scene_init(&s, field, 1);
    vv_affine *m = &s.actor.index_to_world;
    m->axis[0] = vvi_vec(size, 0, 0.1 * size);
    m->axis[1] = vvi_vec(0, 0.8 * size, 0);
    m->axis[2] = vvi_vec(0, 0.2 * size, -1.2 * size);
    m->origin = vvi_vec(50 * size, -20 * size, 10 * size);
    const vv_vec3 at = vv_affine_point(*m, middle);
    const vv_vec3 eye = vvi_add(at, vvi_scaled(vvi_vec(0.6, -0.7, 0.4), (inside ? 1 : 60) * size));
    test_ray_scene_look(&s, eye, at, parallel ? 0 : inside ? 1.4 : 0.6, 36 * size);
    classify_blobs(&s, 1, 0);
    s.lamps[1].position = vvi_add(eye, vvi_scaled(s.scene.lens.right, 3 * size));
    s.actor.classes.opacity_length = size;
    set(&s, "mode", modes[mode]);
    set_number(&s, "step", 0.6 * size);
    vv_image *image = test_ray_picture(&s, NULL, 1);
    test_ray_scene_finish(&s);
    vv_field_release(field);
    return image;
}

static double most_opaque(const vv_image *image)
{
    float most = 0;
    for (int i = 0; i < image->width * image->height; i++)
        most = fmaxf(most, image->rgba[4 * i + 3]);
    return (double)most;
}

static void a_volume_of_any_size_and_shape_makes_the_same_picture_from_anywhere(void **state)
{
    (void)state;
    static const int64_t shapes[][3] = {{27, 24, 30}, {1, 24, 30}, {27, 1, 9}, {40, 30, 1}};
    static const double sizes[] = {1e-6, 1e-3, 1e6, 1e12};
    for (size_t n = 0; n < sizeof shapes / sizeof *shapes; n++)
        for (int view = 0; view < 4; view++)
            for (int mode = 0; mode < 3; mode++) {
                vv_image *want = picture_of_size(shapes[n], 1, view, mode);
                assert_true(most_opaque(want) > 0.05);
                for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
                    vv_image *image = picture_of_size(shapes[n], sizes[i], view, mode);
                    double worst, mean;
                    compare(&worst, &mean, image, want);
                    if (!(worst < 5e-3 && mean < 1e-4)) /* rays along a surface meet it where rounding says */
                        fail_msg("%s of shape %zu, view %d, voxels of %g: differs by %g, %g on average", modes[mode], n,
                                 view, sizes[i], worst, mean);
                    vv_image_release(image);
                }
                vv_image_release(want);
            }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(values_scaled_to_other_types_make_the_picture_of_8_bits),
        cmocka_unit_test(a_volume_of_any_size_and_shape_makes_the_same_picture_from_anywhere),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
