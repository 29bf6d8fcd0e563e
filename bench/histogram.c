/* Times the histogram and statistics of a file in memory: histogram FILE [RUNS]; one JSON line. */
#include "bench.h"

#include <stdio.h>
#include <stdlib.h>

static vv_status run(int argc, char **argv, vv_job *job)
{
    const int runs = bench_runs(argc > 2 ? atoi(argv[2]) : 9);
    bench_times times = {0};
    double n = 0, mean = 0;
    vv_field *field;
    vv_status st = bench_read(&field, argv[1], job);
    for (int i = -1; i < runs && st == VV_OK; i++) {
        vv_values *values = NULL;
        bench_begin(&times);
        if ((st = vv_measure_values(&values, field, NULL, job)) != VV_OK)
            break;
        bench_end(&times);
        mean = values->mean;
        n = (double)values->count;
        vv_values_free(values);
    }
    vv_field_release(field);
    bench_sort(&times);
    if (st == VV_OK)
        printf("{\"case\": \"values %s\", \"threads\": %d, \"n\": %d, \"median_s\": %.5f, \"min_s\": %.5f, "
               "\"cpu_s\": %.5f, \"gvox_s\": %.2f, \"mean\": %.4f}\n",
               argv[1], vv_runtime_threads(vv_job_runtime(job)), runs, times.seconds[runs / 2], times.seconds[0],
               times.processor[runs / 2], n / times.seconds[runs / 2] / 1e9, mean);
    return st;
}

int main(int argc, char **argv)
{
    return bench_main(argc, argv, 1, "histogram FILE [RUNS]", run);
}
