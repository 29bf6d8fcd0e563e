/** @file
 * Fields whose truth is a formula: values and gradients of closed forms, sampled onto any grid and type.
 */
#ifndef TEST_FIELDS_H
#define TEST_FIELDS_H
#include <volvis/field.h>

/** A closed form over world positions. */
typedef struct test_form {
    const char *name;
    double (*value)(vv_vec3 p);
    vv_vec3 (*gradient)(vv_vec3 p); /* by world length */
} test_form;

/** 42 everywhere. */
extern const test_form test_form_constant;
/** 3 + 2 x - y + 0.5 z. */
extern const test_form test_form_ramp;
/** Distance from the point (7, 8, 9), minus 5: the surface of a sphere at 0. */
extern const test_form test_form_sphere;
/** Of degree 2 in each variable: 1 + x y - 0.25 y z + 0.125 x x z - 0.5 y y. */
extern const test_form test_form_polynomial;
/** Marschner & Lobb 1994, fM = 6, alpha = 0.25, on [-1, 1]^3. */
extern const test_form test_form_marschner_lobb;
extern const test_form *const test_forms[]; /* all of them; ends with NULL */

/** A grid of n^3 samples over the cube [lo, hi]^3. */
vv_grid test_cube(int64_t n, double lo, double hi);
/** The form on the info's grid; stored = (value - offset) / scale, rounded for integers. NULL when out of memory. */
vv_field *test_field(const test_form *form, const vv_field_info *info, vv_job *job);
/** test_field() of n^3 floats over [lo, hi]^3. */
vv_field *test_field_cube(const test_form *form, int64_t n, double lo, double hi, vv_job *job);
/** Random bits (all of a type's range; finite floats in [-1000, 1000]) in every sample. */
vv_field *test_field_random(const vv_field_info *info, uint64_t seed, vv_job *job);
/** Marschner & Lobb on 41^3 floats. */
vv_field *test_field_marschner_lobb(vv_job *job);

/** The seed of this run: VOLVIS_TEST_SEED, else 1994; printed, so that a failure can be repeated. */
uint64_t test_seed(void);
/** The index-th of a sequence of random numbers (splitmix64): no state to share or to forget. */
uint64_t test_random(uint64_t seed, uint64_t index);
/** The same, in [0, 1). */
double test_random_unit(uint64_t seed, uint64_t index);
#endif
