/* What kernels look up, at every value of the range and between, against the nodes in double precision. */
#include "fields.h"
#include "ray_scene.h"
#include "render/raycast/raycast_ref.h"
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { NODES = 6 };

/* Nodes of the stored numbers: value, red, green and blue, opacity; from least to most. */
typedef struct sort {
    vv_type type;
    double least, most, offset;
    int n;
    double node[NODES][3];
} sort;

static const sort sorts[] = {
    /* a steep part between nodes far apart */
    {VV_TYPE_U16,
     0,
     4095,
     0,
     6,
     {{0, 0, 0}, {1999, 0.1, 0}, {2000, 0.9, 0.6}, {2001, 0.2, 0.1}, {3000, 1, 0.4}, {4095, 0, 0.9}}},
    {VV_TYPE_U16, 0, 4095, 0, 4, {{100, 0, 0}, {2000.3, 0.1, 0}, {2001.8, 1, 0.7}, {4000, 0, 0.1}}},
    {VV_TYPE_U16, 0, 4095, 0, 4, {{0, 0, 0}, {2000.4, 1, 0.9}, {2000.4, 0, 0}, {4095, 1, 0.5}}},
    {VV_TYPE_U16, 0, 4095, 0, 4, {{0, 0, 0}, {1000, 1, 0.9}, {1000, 0, 0}, {4095, 1, 0.5}}},
    {VV_TYPE_I16, -1024, 3071, 0, 4, {{-1024, 0, 0}, {-2, 0.1, 0}, {0, 1, 0.7}, {3071, 0.3, 0.9}}},
    {VV_TYPE_U16, 0, 4095, -1024, 4, {{0, 0, 0}, {1022, 0.1, 0}, {1024, 1, 0.7}, {4095, 0.3, 0.9}}},
    {VV_TYPE_U16, 0, 65535, 0, 4, {{0, 0, 0}, {40000, 0.2, 0}, {40040, 1, 0.8}, {65535, 0, 0.3}}},
    {VV_TYPE_U16, 0, 65535, 0, 5, {{0, 0, 0}, {300, 0.2, 0}, {301, 1, 0.8}, {302, 0, 0}, {65535, 0, 0.3}}},
    {VV_TYPE_U8, 0, 255, 0, 4, {{0, 0, 0}, {100, 0.2, 0}, {100.02, 1, 0.8}, {255, 0.1, 0.3}}},
    {VV_TYPE_F32, 0, 1, 0, 4, {{0, 0, 0}, {0.5, 0.2, 0}, {0.5001, 1, 0.8}, {1, 0.1, 0.3}}},
};
enum { SORTS = sizeof sorts / sizeof *sorts };

/* Two samples a side, among them the least and the largest. */
static vv_field *field_of(const sort *s)
{
    vv_field_info info = vv_field_info_default();
    vv_field *f;
    void *v;
    info.type = s->type;
    info.value_offset = s->offset;
    info.grid.dims[0] = info.grid.dims[1] = info.grid.dims[2] = 2;
    assert_int_equal(vv_field_new_empty(&f, &v, &info, NULL), VV_OK);
    for (int i = 0; i < 8; i++) {
        const double value = i % 2 ? s->most : s->least;
        if (s->type == VV_TYPE_U8)
            ((uint8_t *)v)[i] = (uint8_t)value;
        else if (s->type == VV_TYPE_I16)
            ((int16_t *)v)[i] = (int16_t)value;
        else if (s->type == VV_TYPE_U16)
            ((uint16_t *)v)[i] = (uint16_t)value;
        else
            ((float *)v)[i] = (float)value;
    }
    return f;
}

static void put_nodes(test_ray_scene *scene, const sort *s)
{
    double opacity[2 * NODES], color[4 * NODES];
    for (int i = 0; i < s->n; i++) {
        const double *n = s->node[i];
        memcpy(opacity + 2 * i, (double[]){n[0] + s->offset, n[2]}, 2 * sizeof *opacity);
        memcpy(color + 4 * i, (double[]){n[0] + s->offset, n[1], 1 - n[1], n[1] / 2}, 4 * sizeof *color);
    }
    test_ray_scene_opacity(scene, opacity, (size_t)s->n);
    test_ray_scene_color(scene, color, (size_t)s->n);
}

/* Nearer to a jump than a value is told apart there. */
static bool at_jump(const sort *s, double stored)
{
    bool near = false;
    for (int i = 0; i + 1 < s->n; i++)
        near |= s->node[i][0] == s->node[i + 1][0] && stored != s->node[i][0] && fabs(stored - s->node[i][0]) < 0.003;
    return near;
}

static double error_at(const vvi_raycast_state *state, const vv_classification *classes, const sort *s, double stored)
{
    const vvi_march_volume *f = &state->volume[0].ray;
    const float v = (float)stored;
    const int64_t row = vvi_ref_row(f, (double)v);
    double want[4], most = 0;
    vvi_transfer_evaluate(want, classes, stored + s->offset);
    for (int c = 0; c < 3; c++)
        most = fmax(most, fabs((double)f->classifier.color[4 * row + c] - want[c]));
    most = fmax(most, fabs((double)f->classifier.alpha[row] - -expm1(-want[3] * f->step)));
    return fmax(most, fabs(exp(-(double)f->classifier.color[4 * row + 3]) - exp(-want[3] * f->step)));
}

/* Ramps of a few values are met as exactly as ramps of thousands. */
static void colours_are_within_a_thousandth_at_every_value(void **state)
{
    (void)state;
    for (size_t i = 0; i < SORTS; i++) {
        const sort *s = &sorts[i];
        vv_field *field = field_of(s);
        test_ray_scene scene;
        void *prepared;
        double whole = 0, between = 0;
        test_ray_scene_init(&scene, field, 4);
        put_nodes(&scene, s);
        assert_int_equal(vvi_raycast_prepare(&prepared, &scene.scene, NULL), VV_OK);
        const double step = s->type == VV_TYPE_F32 ? 1.0 / 4096 : 1;
        for (double v = s->least; v <= s->most; v += step) {
            whole = fmax(whole, error_at(prepared, &scene.actor.classes, s, v));
            for (int k = 1; k < 16 && v < s->most; k++)
                if (!at_jump(s, v + step * k / 16))
                    between = fmax(between, error_at(prepared, &scene.actor.classes, s, v + step * k / 16));
        }
        print_message("%zu: %.2g at stored values, %.2g between\n", i, whole, between);
        if (whole > 1e-3 || between > 1e-3)
            fail_msg("%zu: off by %g at stored values, by %g between", i, whole, between);
        vvi_raycast_finish(prepared);
        test_ray_scene_finish(&scene);
        vv_field_release(field);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(colours_are_within_a_thousandth_at_every_value),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
