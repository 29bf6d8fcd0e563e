/* Closed-form and random fields for tests. */
#include "fields.h"

#include "grid/field.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static double constant_value(vv_vec3 p)
{
    (void)p;
    return 42;
}

static vv_vec3 constant_gradient(vv_vec3 p)
{
    (void)p;
    return (vv_vec3){0, 0, 0};
}

static double ramp_value(vv_vec3 p)
{
    return 3 + 2 * p.x - p.y + 0.5 * p.z;
}

static vv_vec3 ramp_gradient(vv_vec3 p)
{
    (void)p;
    return (vv_vec3){2, -1, 0.5};
}

static vv_vec3 from_centre(vv_vec3 p)
{
    return (vv_vec3){p.x - 7, p.y - 8, p.z - 9};
}

static double length(vv_vec3 v)
{
    return sqrt(v.x * v.x + v.y * v.y + v.z * v.z);
}

static double sphere_value(vv_vec3 p)
{
    return length(from_centre(p)) - 5;
}

static vv_vec3 sphere_gradient(vv_vec3 p)
{
    const vv_vec3 v = from_centre(p);
    const double r = length(v);
    return r > 0 ? (vv_vec3){v.x / r, v.y / r, v.z / r} : (vv_vec3){0, 0, 0};
}

static double polynomial_value(vv_vec3 p)
{
    return 1 + p.x * p.y - 0.25 * p.y * p.z + 0.125 * p.x * p.x * p.z - 0.5 * p.y * p.y;
}

static vv_vec3 polynomial_gradient(vv_vec3 p)
{
    return (vv_vec3){p.y + 0.25 * p.x * p.z, p.x - 0.25 * p.z - p.y, -0.25 * p.y + 0.125 * p.x * p.x};
}

static const double pi = 3.14159265358979323846, ml_f = 6, ml_alpha = 0.25;

static double ml_value(vv_vec3 p)
{
    const double r = hypot(p.x, p.y);
    const double rings = cos(2 * pi * ml_f * cos(pi * r / 2));
    return (1 - sin(pi * p.z / 2) + ml_alpha * (1 + rings)) / (2 * (1 + ml_alpha));
}

static vv_vec3 ml_gradient(vv_vec3 p)
{
    const double r = hypot(p.x, p.y), whole = 2 * (1 + ml_alpha);
    const double by_r = ml_alpha * sin(2 * pi * ml_f * cos(pi * r / 2)) * pi * pi * ml_f * sin(pi * r / 2) / whole;
    const double by_z = -pi / 2 * cos(pi * p.z / 2) / whole;
    return r > 0 ? (vv_vec3){by_r * p.x / r, by_r * p.y / r, by_z} : (vv_vec3){0, 0, by_z};
}

const test_form test_form_constant = {"constant", constant_value, constant_gradient};
const test_form test_form_ramp = {"ramp", ramp_value, ramp_gradient};
const test_form test_form_sphere = {"sphere", sphere_value, sphere_gradient};
const test_form test_form_polynomial = {"polynomial", polynomial_value, polynomial_gradient};
const test_form test_form_marschner_lobb = {"Marschner-Lobb", ml_value, ml_gradient};
const test_form *const test_forms[] = {
    &test_form_constant, &test_form_ramp, &test_form_sphere, &test_form_polynomial, &test_form_marschner_lobb, NULL,
};

vv_grid test_cube(int64_t n, double lo, double hi)
{
    vv_grid grid = vv_field_info_default().grid;
    const double step = n > 1 ? (hi - lo) / (double)(n - 1) : 1;
    grid.dims[0] = grid.dims[1] = grid.dims[2] = n;
    grid.index_to_world.axis[0] = (vv_vec3){step, 0, 0};
    grid.index_to_world.axis[1] = (vv_vec3){0, step, 0};
    grid.index_to_world.axis[2] = (vv_vec3){0, 0, step};
    grid.index_to_world.origin = (vv_vec3){lo, lo, lo};
    snprintf(grid.unit, sizeof grid.unit, "mm");
    return grid;
}

vv_field *test_field(const test_form *form, const vv_field_info *info, vv_job *job)
{
    vv_field *field;
    void *data;
    if (vv_field_new_empty(&field, &data, info, job) != VV_OK)
        return NULL;
    char *p = data;
    const int64_t *d = info->grid.dims;
    for (int64_t k = 0; k < d[2]; k++)
        for (int64_t j = 0; j < d[1]; j++)
            for (int64_t i = 0; i < d[0]; i++) {
                const vv_vec3 index = {(double)i, (double)j, (double)k};
                const double v = form->value(vv_affine_point(info->grid.index_to_world, index));
                const double stored = (v - info->value_offset) / info->value_scale;
                for (int c = 0; c < info->components; c++, p += vv_type_bytes(info->type))
                    vvi_samples_from_f64(p, &stored, info->type, 1);
            }
    return field;
}

vv_field *test_field_cube(const test_form *form, int64_t n, double lo, double hi, vv_job *job)
{
    vv_field_info info = vv_field_info_default();
    info.grid = test_cube(n, lo, hi);
    info.type = VV_TYPE_F32;
    return test_field(form, &info, job);
}

vv_field *test_field_random(const vv_field_info *info, uint64_t seed, vv_job *job)
{
    vv_field *field;
    void *data;
    uint64_t bytes;
    if (vv_field_info_bytes(&bytes, info) != VV_OK || vv_field_new_empty(&field, &data, info, job) != VV_OK)
        return NULL;
    const size_t each = vv_type_bytes(info->type);
    for (uint64_t i = 0; i < bytes / each; i++) {
        const uint64_t bits = test_random(seed, i);
        const double real = test_random_unit(seed, i) * 2000 - 1000;
        if (vv_type_is_float(info->type))
            vvi_samples_from_f64((char *)data + i * each, &real, info->type, 1);
        else
            memcpy((char *)data + i * each, &bits, each);
    }
    return field;
}

vv_field *test_field_marschner_lobb(vv_job *job)
{
    return test_field_cube(&test_form_marschner_lobb, 41, -1, 1, job);
}

uint64_t test_seed(void)
{
    const char *given = getenv("VOLVIS_TEST_SEED");
    const uint64_t seed = given ? strtoull(given, NULL, 10) : 1994;
    static bool said;
    if (!said)
        printf("seed %" PRIu64 " (repeat with VOLVIS_TEST_SEED)\n", seed);
    said = true;
    return seed;
}

uint64_t test_random(uint64_t seed, uint64_t index)
{
    uint64_t z = seed * 0xd1342543de82ef95u + (index + 1) * 0x9e3779b97f4a7c15u;
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9u;
    z = (z ^ z >> 27) * 0x94d049bb133111ebu;
    return z ^ z >> 31;
}

double test_random_unit(uint64_t seed, uint64_t index)
{
    return (double)(test_random(seed, index) >> 11) * 0x1p-53;
}
