#include "jobs.h"

#include <stdio.h>
#include <stdlib.h>

vv_job *test_job(int threads, uint64_t memory_bytes)
{
    vv_runtime_options options;
    vv_runtime_options_init(&options, sizeof options);
    options.threads = threads;
    options.memory_bytes = memory_bytes;
    vv_runtime *runtime = NULL;
    vv_job *job = NULL;
    if (vv_runtime_new(&runtime, &options) != VV_OK || vv_job_new(&job, runtime, NULL, NULL) != VV_OK) {
        fprintf(stderr, "no runtime for the test: %s\n", vv_error_last()->message);
        exit(1);
    }
    vv_runtime_release(runtime);
    return job;
}
