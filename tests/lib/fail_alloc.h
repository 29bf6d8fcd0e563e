/** @file
 * Sweeps in which one allocation after another fails.
 */
#ifndef TEST_FAIL_ALLOC_H
#define TEST_FAIL_ALLOC_H
#include <volvis/status.h>

/**
 * Runs act() with every allocation failing from the first on, then from the second on, and so on until none fails.
 * Each run must succeed, or fail with VV_E_MEMORY or VV_E_LIMIT and a text; act() gives back what it got. Fails the
 * cmocka test otherwise. The number of allocations that act() makes when all goes well.
 */
int64_t test_fail_each_alloc(vv_status (*act)(void *user), void *user);
#endif
