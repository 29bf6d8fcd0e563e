/** @file
 * Jobs for tests: a runtime of its own for each.
 */
#ifndef TEST_JOBS_H
#define TEST_JOBS_H
#include <volvis/runtime.h>

/** A job in a new runtime of that many threads (0: as many as there are); the job holds the runtime. memory_bytes 0:
 * the default limit. Fails the test when it cannot be made. Release with vv_job_release(). */
vv_job *test_job(int threads, uint64_t memory_bytes);
#endif
