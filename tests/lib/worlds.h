/** @file
 * Random Worlds, values and edits, made by walking the property tables: a new property is tested as soon as it is a
 * row.
 */
#ifndef TEST_WORLDS_H
#define TEST_WORLDS_H
#include <volvis/model.h>

/** A sequence of random numbers. */
typedef struct test_dice {
    uint64_t seed, index;
} test_dice;

uint64_t test_roll(test_dice *dice, uint64_t n); /* 0 .. n - 1 */
/** Any finite double: small, huge, denormal, -0, whole. */
double test_roll_double(test_dice *dice);
/** JSON text of a value that the row allows (a class's own check may still refuse it). Yours to free(). */
char *test_roll_value(test_dice *dice, const vv_property *property, const vv_property_context *context);
/** Sets about `share` of 256 properties in and below an object, and adds entries to its lists and maps. */
void test_roll_object(test_dice *dice, vv_object **root, int share, const vv_property_context *context);
/** A World with all of it. */
vv_object *test_roll_world(test_dice *dice, int share, const vv_property_context *context);
/** The path of some property of the World, yours to free(), and its row. */
char *test_roll_path(test_dice *dice, const vv_property **property_out, const vv_object *world);
#endif
