/** @file
 * Operations of one input, with parameters in text.
 */
#ifndef TEST_OPERATIONS_H
#define TEST_OPERATIONS_H
#include <volvis/sys/registry.h>

/** Parameters of an operation from "name=json;name=json" ("" or NULL: none). Lengths are in the grid's unit. NULL, and
 * the thread's error, when they are refused. */
vv_object *test_params(const vv_operation *operation, const char *settings, const vv_grid *grid);
/** Runs it. When it succeeds, plan() must have foretold the grid, type, components and meaning of the result: the test
 * fails otherwise. */
vv_status test_apply(vv_field **out, const vv_operation *operation, const vv_field *in, const char *settings,
                     vv_job *job);
/** True when two fields have equal dims, type, components and bytes. */
bool test_same_samples(const vv_field *a, const vv_field *b);
/** The same; a lazy field makes its samples with this job. */
bool test_same_samples_by(const vv_field *a, const vv_field *b, vv_job *job);
/** Runs it on several inputs, of which some may be NULL, and fails the test unless one and three threads make the same
 * bytes, run_box() those of every box that is tried, and plan() foretells all of it. The result; the caller's. */
vv_field *test_apply_all_ways(const vv_operation *operation, const vv_field *const *inputs, size_t n,
                              const char *settings);
#endif
