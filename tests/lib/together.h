/** @file
 * Several volumes in one picture: for tests of how they meet.
 */
#ifndef TEST_TOGETHER_H
#define TEST_TOGETHER_H
#include "fields.h"
#include "ray_scene.h"

enum { TEST_TOGETHER_MOST = 4 };

/** Each volume has a test_ray_scene of its own; the first one's is the picture. All zero: none yet. */
typedef struct test_together {
    test_ray_scene part[TEST_TOGETHER_MOST];
    vv_field *field[TEST_TOGETHER_MOST];
    vv_field *extra[TEST_TOGETHER_MOST]; /**< of what actors show beside; NULL: none. Released in the end */
    vv_region regions[TEST_TOGETHER_MOST][2];
    double map[TEST_TOGETHER_MOST][12];
    vv_actor actors[TEST_TOGETHER_MOST];
    size_t n;
    bool own; /**< each volume has the parameters of its own scene, not the first one's */
} test_together;

/** One more, called "a", "b", ...; the field is its own from now on. */
test_ray_scene *test_together_add(test_together *t, vv_field *field);
/** The scene of all volumes, as they are now. */
test_ray_scene *test_together_all(test_together *t);
void test_together_finish(test_together *t);

/** 1 everywhere. */
extern const test_form test_form_one;
/** The opacity of a length of 1 of that extinction. */
double test_opacity_of(double kappa);
/** A box of one value over [lo, hi]^3: extinction kappa, one colour. */
test_ray_scene *test_together_box(test_together *t, double lo, double hi, double kappa, const double rgb[3]);
#endif
