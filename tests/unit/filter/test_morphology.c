/* Dilation, erosion and what is made of them against looking at every sample of the element, for every type, shape,
 * radius and instruction set. */
#include "core/cpu.h"
#include "fields.h"
#include "filter/dilate_kernel.h"
#include "filter/element.h"
#include "grid/field.h"
#include "jobs.h"
#include "operations.h"
#include "registry.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

typedef struct offset {
    int64_t i, j, k;
    double away;
} offset;

/* The offsets of an element in a grid that lies along the axes, by its formula. */
static size_t element_of(offset *out, const vv_grid *grid, const int64_t r[3], vvi_element_shape shape)
{
    size_t n = 0;
    for (int64_t k = -r[2]; k <= r[2]; k++)
        for (int64_t j = -r[1]; j <= r[1]; j++)
            for (int64_t i = -r[0]; i <= r[0]; i++) {
                const int64_t o[3] = {i, j, k};
                double ball = 0, away = 0;
                int along = 0;
                for (int a = 0; a < 3; a++) {
                    const double world = (double)o[a] * vv_grid_spacing(grid, a);
                    ball += o[a] ? (double)(o[a] * o[a]) / (double)(r[a] * r[a]) : 0;
                    away += world * world;
                    along += o[a] != 0;
                }
                if (shape == VVI_ELEMENT_BOX || (shape == VVI_ELEMENT_BALL ? ball <= 1 + 1e-9 : along <= 1))
                    out[n++] = (offset){i, j, k, away};
            }
    return n;
}

static bool is_inside(const vv_field_info *info, int64_t i, int64_t j, int64_t k)
{
    const int64_t *d = info->grid.dims;
    return i >= 0 && j >= 0 && k >= 0 && i < d[0] && j < d[1] && k < d[2];
}

/* The least or the greatest number within the element, of those that are in the grid; NaN stay. */
static double extreme(const vv_field *in, const offset *o, size_t n, bool least, int64_t i, int64_t j, int64_t k, int c)
{
    double best = vv_field_value(in, i, j, k, c);
    if (isnan(best))
        return best;
    for (size_t e = 0; e < n; e++) {
        if (!is_inside(vv_field_get_info(in), i + o[e].i, j + o[e].j, k + o[e].k))
            continue;
        const double v = vv_field_value(in, i + o[e].i, j + o[e].j, k + o[e].k, c);
        if (least ? v < best : v > best)
            best = v;
    }
    return best;
}

static vv_field *apply(const vv_operation *operation, const vv_field *in, const char *settings)
{
    vv_field *out;
    if (test_apply(&out, operation, in, settings, NULL) != VV_OK)
        fail_msg("%s: %s: %s", operation->name, settings ? settings : "no settings", vv_error_last()->message);
    return out;
}

static vv_field_info info_of(const int64_t dims[3], vv_type type, int components)
{
    vv_field_info info = vv_field_info_default();
    memcpy(info.grid.dims, dims, sizeof info.grid.dims);
    info.type = type;
    info.components = components;
    strcpy(info.grid.unit, "mm");
    return info;
}

static bool same(double a, double b)
{
    return a == b || (isnan(a) && isnan(b));
}

static void expect_extremes(const vv_field *in, const vv_field *out, const offset *o, size_t n, bool least)
{
    const vv_field_info *info = vv_field_get_info(in);
    for (int64_t k = 0; k < info->grid.dims[2]; k++)
        for (int64_t j = 0; j < info->grid.dims[1]; j++)
            for (int64_t i = 0; i < info->grid.dims[0]; i++)
                for (int c = 0; c < info->components; c++)
                    if (!same(vv_field_value(out, i, j, k, c), extreme(in, o, n, least, i, j, k, c)))
                        fail_msg("%s (%d %d %d) %d: not the %s", vv_type_name(info->type), (int)i, (int)j, (int)k, c,
                                 least ? "least" : "greatest");
}

static void try(const int64_t dims[3], vv_type type, int components, const int64_t radius[3], vvi_element_shape shape,
                uint64_t seed)
{
    static offset o[50000];
    const vv_field_info info = info_of(dims, type, components);
    vv_field *in = test_field_random(&info, seed, NULL);
    int64_t r[3];
    char settings[96];
    for (int a = 0; a < 3; a++)
        r[a] = dims[a] == 1 ? 0 : radius[a];
    const size_t n = element_of(o, &info.grid, r, shape);
    snprintf(settings, sizeof settings, "radius_voxels=[%d,%d,%d];shape=%s", (int)radius[0], (int)radius[1],
             (int)radius[2], vvi_element_shape_names[shape]);
    for (int least = 0; least < 2; least++) {
        vv_field *out = apply(least ? &vvi_operation_erode : &vvi_operation_dilate, in, settings);
        expect_extremes(in, out, o, n, least);
        vv_field_release(out);
    }
    vv_field_release(in);
}

static void every_type_and_element_equals_a_look_at_all_of_it(void **state)
{
    (void)state;
    static const int64_t radii[][3] = {{1, 1, 1}, {2, 1, 0}, {0, 2, 1}, {3, 3, 3}, {1, 0, 4}, {0, 0, 0}};
    const uint64_t seed = test_seed();
    for (int t = 0; t < VV_TYPE_COUNT; t++)
        for (size_t r = 0; r < sizeof radii / sizeof *radii; r++)
            for (int shape = 0; shape < 3; shape++)
                try((int64_t[]){13, 5, 4}, (vv_type)t, 1 + t % 3, radii[r], (vvi_element_shape)shape,
                    seed + (uint64_t)t);
}

static void all_sizes_equal_a_look_at_all_of_it(void **state)
{
    (void)state;
    static const int64_t sizes[][3] = {{1, 1, 1},   {1, 9, 1},   {1, 1, 9},  {2, 3, 1},
                                       {131, 3, 2}, {257, 2, 1}, {3, 39, 41}};
    static const int64_t radii[][3] = {{1, 1, 1}, {5, 2, 7}, {20, 1, 1}, {17, 18, 0}};
    for (size_t s = 0; s < sizeof sizes / sizeof *sizes; s++)
        for (size_t r = 0; r < sizeof radii / sizeof *radii; r++)
            for (int shape = 0; shape < 3; shape++)
                try(sizes[s], s % 2 ? VV_TYPE_U8 : VV_TYPE_F32, 1, radii[r], (vvi_element_shape)shape, s);
}

static void nan_do_not_count_and_stay(void **state)
{
    (void)state;
    static const double odd[] = {NAN, INFINITY, -INFINITY, -1, 0, 1, 1, 2};
    static const char *const shapes[] = {"radius_voxels=[1,1,1];shape=ball", "radius_voxels=[1,1,1];shape=box"};
    for (int wide = 0; wide < 2; wide++)
        for (int shape = 0; shape < 2; shape++) {
            const vv_field_info info = info_of((int64_t[]){17, 9, 5}, wide ? VV_TYPE_F64 : VV_TYPE_F32, 1);
            offset o[27];
            const size_t n = element_of(o, &info.grid, (int64_t[]){1, 1, 1}, (vvi_element_shape)shape);
            vv_field *in;
            void *data;
            assert_int_equal(vv_field_new_empty(&in, &data, &info, NULL), VV_OK);
            for (size_t i = 0; i < 17 * 9 * 5; i++) {
                const uint64_t random = test_random(3, i);
                const double v = odd[random % 3 ? 0 : random / 3 % 8];
                if (wide)
                    ((double *)data)[i] = v;
                else
                    ((float *)data)[i] = (float)v;
            }
            for (int least = 0; least < 2; least++) {
                vv_field *out = apply(least ? &vvi_operation_erode : &vvi_operation_dilate, in, shapes[shape]);
                expect_extremes(in, out, o, n, least);
                vv_field_release(out);
            }
            vv_field_release(in);
        }
}

/* A scale below 0 turns the order of what is stored round. */
static void values_count_and_not_what_is_stored(void **state)
{
    (void)state;
    vv_field_info info = info_of((int64_t[]){9, 8, 7}, VV_TYPE_I16, 1);
    offset o[27];
    const size_t n = element_of(o, &info.grid, (int64_t[]){1, 1, 1}, VVI_ELEMENT_BALL);
    info.value_scale = -0.5;
    info.value_offset = 3;
    vv_field *in = test_field_random(&info, 4, NULL), *out = apply(&vvi_operation_dilate, in, NULL);
    expect_extremes(in, out, o, n, false);
    vv_field *opened = apply(&vvi_operation_open, in, NULL), *hat = apply(&vvi_operation_top_hat, in, NULL);
    for (int64_t i = 0; i < 9; i++)
        assert_true(vv_field_value(hat, i, 3, 3, 0) ==
                    vv_field_value(in, i, 3, 3, 0) - vv_field_value(opened, i, 3, 3, 0));
    vv_field *all[] = {in, out, opened, hat};
    for (int i = 0; i < 4; i++)
        vv_field_release(all[i]);
}

/* The difference of any two samples of a type, in full. */
static void top_hats_hold_every_difference(void **state)
{
    (void)state;
    const vv_field_info info = info_of((int64_t[]){9, 8, 7}, VV_TYPE_I8, 2);
    vv_field *in = test_field_random(&info, 4, NULL);
    for (int dark = 0; dark < 2; dark++) {
        vv_field *steps = apply(dark ? &vvi_operation_close : &vvi_operation_open, in, "radius_voxels=[2,2,2]");
        vv_field *hat =
            apply(&vvi_operation_top_hat, in, dark ? "radius_voxels=[2,2,2];dark=true" : "radius_voxels=[2,2,2]");
        assert_int_equal(vv_field_get_info(hat)->type, VV_TYPE_U8);
        for (int64_t k = 0; k < 7; k++)
            for (int64_t j = 0; j < 8; j++)
                for (int64_t i = 0; i < 9; i++)
                    for (int c = 0; c < 2; c++)
                        assert_true(vv_field_value(hat, i, j, k, c) ==
                                    fabs(vv_field_value(in, i, j, k, c) - vv_field_value(steps, i, j, k, c)));
        vv_field_release(steps);
        vv_field_release(hat);
    }
    vv_field_release(in);
}

/* A ball of a length, in a grid that is sheared: what lies no farther away in the world. */
static void a_ball_is_one_in_the_world(void **state)
{
    (void)state;
    vv_field_info info = info_of((int64_t[]){21, 19, 17}, VV_TYPE_U8, 1);
    vv_affine *m = &info.grid.index_to_world;
    m->axis[0] = (vv_vec3){0.7, 0.1, 0};
    m->axis[1] = (vv_vec3){0.3, 1.1, 0.2};
    m->axis[2] = (vv_vec3){-0.2, 0.4, 1.6};
    vv_field *in;
    void *data;
    assert_int_equal(vv_field_new_empty(&in, &data, &info, NULL), VV_OK);
    memset(data, 0, 21 * 19 * 17);
    ((uint8_t *)data)[(8 * 19 + 9) * 21 + 10] = 1;
    vv_field *out = apply(&vvi_operation_dilate, in, "radius=3.3mm");
    for (int64_t k = 0; k < 17; k++)
        for (int64_t j = 0; j < 19; j++)
            for (int64_t i = 0; i < 21; i++) {
                const double a = (double)(i - 10), b = (double)(j - 9), c = (double)(k - 8);
                const double x = a * 0.7 + b * 0.3 - c * 0.2, y = a * 0.1 + b * 1.1 + c * 0.4, z = b * 0.2 + c * 1.6;
                assert_true((vv_field_value(out, i, j, k, 0) == 1) == (x * x + y * y + z * z <= 3.3 * 3.3));
            }
    vv_field_release(in);
    vv_field_release(out);
}

/* Labels ------------------------------------------------------------------------------------------------------- */

static vv_field *some_labels(const int64_t dims[3], vv_type type, int density, uint64_t seed)
{
    vv_field_info info = info_of(dims, type, 1);
    info.meaning = VV_MEANING_LABEL;
    info.grid.index_to_world.axis[2].z = 1.5;
    vv_field *out;
    void *data;
    assert_int_equal(vv_field_new_empty(&out, &data, &info, NULL), VV_OK);
    for (size_t i = 0; i < (size_t)(dims[0] * dims[1] * dims[2]); i++) {
        const uint64_t random = test_random(seed, i / 2);
        const double id = random % (uint64_t)density ? 0 : (double)(1 + random / 64 % 5 * 25);
        vvi_samples_from_f64((char *)data + i * vv_type_bytes(type), &id, type, 1);
    }
    return out;
}

typedef struct looked {
    const vv_field *in;
    const offset *o;
    size_t n;
    double only; /* 0: all */
} looked;

static double label_at(const looked *l, int64_t i, int64_t j, int64_t k)
{
    return vv_field_value(l->in, i, j, k, 0);
}

/* Whether the label fills the element around a place; whether it is in it. */
static bool fills(const looked *l, double id, int64_t i, int64_t j, int64_t k)
{
    for (size_t e = 0; e < l->n; e++)
        if (is_inside(vv_field_get_info(l->in), i + l->o[e].i, j + l->o[e].j, k + l->o[e].k) &&
            label_at(l, i + l->o[e].i, j + l->o[e].j, k + l->o[e].k) != id)
            return false;
    return true;
}

static bool touches(const looked *l, double id, int64_t i, int64_t j, int64_t k)
{
    for (size_t e = 0; e < l->n; e++)
        if (is_inside(vv_field_get_info(l->in), i + l->o[e].i, j + l->o[e].j, k + l->o[e].k) &&
            label_at(l, i + l->o[e].i, j + l->o[e].j, k + l->o[e].k) == id)
            return true;
    return false;
}

static double dilated(const looked *l, int64_t i, int64_t j, int64_t k)
{
    double best = 0, away = INFINITY;
    for (size_t e = 0; e < l->n; e++) {
        const offset *o = &l->o[e];
        if (!is_inside(vv_field_get_info(l->in), i + o->i, j + o->j, k + o->k))
            continue;
        const double id = label_at(l, i + o->i, j + o->j, k + o->k);
        if (id == 0 || (l->only != 0 && id != l->only))
            continue;
        if (o->away < away - 1e-9 || (o->away < away + 1e-9 && id < best)) {
            best = id;
            away = o->away;
        }
    }
    return best;
}

typedef bool around_fn(const looked *l, double id, int64_t i, int64_t j, int64_t k);

/* Whether the element has a place in it of which that is true; of which it is not. */
static bool any_around(const looked *l, around_fn *is, bool value, double id, int64_t i, int64_t j, int64_t k)
{
    for (size_t e = 0; e < l->n; e++) {
        const int64_t x = i + l->o[e].i, y = j + l->o[e].j, z = k + l->o[e].k;
        if (is_inside(vv_field_get_info(l->in), x, y, z) && is(l, id, x, y, z) == value)
            return true;
    }
    return false;
}

static double expected(const looked *l, const vv_operation *operation, int64_t i, int64_t j, int64_t k)
{
    const double own = label_at(l, i, j, k);
    const bool kept = own != 0 && l->only != 0 && own != l->only;
    if (operation == &vvi_operation_erode)
        return kept || fills(l, own, i, j, k) ? own : 0;
    if (operation == &vvi_operation_open)
        return kept || any_around(l, fills, true, own, i, j, k) ? own : 0;
    if (own != 0)
        return own;
    if (operation == &vvi_operation_dilate)
        return dilated(l, i, j, k);
    for (double id = 1; id <= 101; id += 25)
        if ((l->only == 0 || id == l->only) && !any_around(l, touches, false, id, i, j, k))
            return id;
    return 0;
}

static void labels_equal_a_look_at_all_of_the_element(void **state)
{
    (void)state;
    static const vv_operation *const operations[] = {&vvi_operation_dilate, &vvi_operation_erode, &vvi_operation_open,
                                                     &vvi_operation_close};
    static const int64_t sizes[][3] = {{11, 7, 6}, {1, 9, 8}, {140, 4, 1}};
    static const int densities[] = {2, 6, 40};
    offset o[125];
    for (int t = 0; t < 36; t++) {
        const int64_t *dims = sizes[t / 4 % 3];
        const vv_type type = (vv_type)(t % 8);
        vv_field *in = some_labels(dims, type, densities[t / 12], (uint64_t)t);
        for (int shape = 0; shape < 3; shape++)
            for (int only = 0; only < 2; only++) {
                looked l = {.in = in, .o = o, .only = only ? 26 : 0};
                char settings[96];
                l.n = element_of(o, &vv_field_get_info(in)->grid, (int64_t[]){dims[0] > 1 ? 2 : 0, 1, dims[2] > 1},
                                 (vvi_element_shape)shape);
                snprintf(settings, sizeof settings, "radius_voxels=[2,1,1];shape=%s%s", vvi_element_shape_names[shape],
                         only ? ";label=26" : "");
                vv_field *out = apply(operations[t % 4], in, settings);
                for (int64_t k = 0; k < dims[2]; k++)
                    for (int64_t j = 0; j < dims[1]; j++)
                        for (int64_t i = 0; i < dims[0]; i++)
                            if (vv_field_value(out, i, j, k, 0) != expected(&l, operations[t % 4], i, j, k))
                                fail_msg("%s %s %s (%d %d %d): %g, not %g", operations[t % 4]->name, settings,
                                         vv_type_name(type), (int)i, (int)j, (int)k, vv_field_value(out, i, j, k, 0),
                                         expected(&l, operations[t % 4], i, j, k));
                vv_field_release(out);
            }
        vv_field_release(in);
    }
}

static void any_box_is_a_part_of_the_whole(void **state)
{
    (void)state;
    static const vv_operation *const operations[] = {&vvi_operation_dilate, &vvi_operation_open, &vvi_operation_close,
                                                     &vvi_operation_top_hat};
    static const char *const settings[] = {"radius_voxels=[3,2,1]", "radius_voxels=[2,2,17];shape=box"};
    static const vv_box boxes[] = {{{0, 0, 0}, {23, 11, 4}}, {{5, 3, 4}, {7, 6, 5}}, {{22, 10, 18}, {1, 1, 1}}};
    const int64_t dims[3] = {23, 11, 19};
    const vv_field_info info = info_of(dims, VV_TYPE_F32, 2);
    for (int labels = 0; labels < 2; labels++)
        for (int t = 0; t < 4 - labels; t++)
            for (int s = 0; s < 2; s++) {
                vv_field *in = labels ? some_labels(dims, VV_TYPE_U16, 3, 5) : test_field_random(&info, 7, NULL);
                vv_field *whole = apply(operations[t], in, settings[s]);
                vv_object *params = test_params(operations[t], settings[s], &info.grid);
                for (size_t b = 0; b < sizeof boxes / sizeof *boxes; b++) {
                    const vv_field *inputs[] = {in};
                    vv_field *part;
                    assert_int_equal(operations[t]->run_box(&part, inputs, 1, params, &boxes[b], NULL), VV_OK);
                    for (int64_t k = 0; k < boxes[b].n[2]; k++)
                        for (int64_t j = 0; j < boxes[b].n[1]; j++)
                            for (int64_t i = 0; i < boxes[b].n[0]; i++)
                                assert_true(vv_field_value(part, i, j, k, 0) ==
                                            vv_field_value(whole, i + boxes[b].lo[0], j + boxes[b].lo[1],
                                                           k + boxes[b].lo[2], 0));
                    vv_field_release(part);
                }
                vv_object_release(params);
                vv_field_release(whole);
                vv_field_release(in);
            }
}

#define COMPARE(ctype)                                                                                                 \
    for (int i = 0; i < 300; i++) {                                                                                    \
        ctype most = ((const ctype *)rows[0])[i];                                                                      \
        for (int r = 1; r < n; r++)                                                                                    \
            most = ((const ctype *)rows[r])[i] > most ? ((const ctype *)rows[r])[i] : most;                            \
        assert_true(((const ctype *)(const void *)got)[i] == most);                                                    \
    }                                                                                                                  \
    break

static void every_instruction_set_gives_the_same(void **state)
{
    (void)state;
    static uint64_t data[11][300 + VVI_DILATE_GUARD], got[300 + VVI_DILATE_GUARD];
    const void *rows[11];
    for (int r = 0; r < 11; r++) {
        rows[r] = data[r];
        for (size_t i = 0; i < 300; i++)
            data[r][i] = test_random((uint64_t)r, i);
    }
    for (size_t b = 0; vvi_dilate_kernels_nth(b); b++) {
        const vvi_dilate_kernels *kernels = vvi_dilate_kernels_nth(b);
        if (kernels->needs & ~vvi_cpu_detect())
            continue;
        for (int n = 1; n <= 11; n++)
            for (int of = 0; of < 4; of++) {
                kernels->most[of](got, rows, n, 300);
                switch (of) {
                case 0:
                    COMPARE(uint8_t);
                case 1:
                    COMPARE(int16_t);
                case 2:
                    COMPARE(int32_t);
                default:
                    COMPARE(int64_t);
                }
            }
        int16_t odd[5] = {-7, 5, 12, INT16_MIN, 100};
        assert_true(kernels->prepare[1](odd, 5, -1, -10, 50));
        const int16_t want[5] = {6, -6, -13, INT16_MIN, INT16_MIN};
        assert_memory_equal(odd, want, sizeof want);
        assert_false(kernels->prepare[1](odd, 3, 0, INT64_MIN, INT64_MAX));
    }
}

static void what_makes_no_sense_is_refused(void **state)
{
    (void)state;
    vv_field *in = some_labels((int64_t[]){300, 2, 2}, VV_TYPE_U8, 2, 1), *out;
    static const char *const wrong[] = {"radius_voxels=[101,1,1]", "radius_voxels=[1.5,1,1]", "radius_voxels=[-1,1,1]",
                                        "radius=1;radius_voxels=[1,1,1]", "label=0"};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++)
        assert_int_equal(test_apply(&out, &vvi_operation_dilate, in, wrong[i], NULL), VV_E_ARGUMENT);
    assert_int_equal(test_apply(&out, &vvi_operation_top_hat, in, NULL, NULL), VV_E_UNSUPPORTED);
    vv_field_release(in);
    const vv_field_info info = info_of((int64_t[]){4, 4, 4}, VV_TYPE_U8, 1);
    in = test_field_random(&info, 1, NULL);
    assert_int_equal(test_apply(&out, &vvi_operation_dilate, in, "label=3", NULL), VV_E_ARGUMENT);
    vv_field_release(in);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_type_and_element_equals_a_look_at_all_of_it),
        cmocka_unit_test(all_sizes_equal_a_look_at_all_of_it),
        cmocka_unit_test(nan_do_not_count_and_stay),
        cmocka_unit_test(values_count_and_not_what_is_stored),
        cmocka_unit_test(top_hats_hold_every_difference),
        cmocka_unit_test(a_ball_is_one_in_the_world),
        cmocka_unit_test(labels_equal_a_look_at_all_of_the_element),
        cmocka_unit_test(any_box_is_a_part_of_the_whole),
        cmocka_unit_test(every_instruction_set_gives_the_same),
        cmocka_unit_test(what_makes_no_sense_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
