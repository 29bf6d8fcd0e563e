#include "bench.h"

#include <stdio.h>
#include <stdlib.h>
#include <time.h>

double bench_now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static double processor_now(void)
{
    return (double)clock() / CLOCKS_PER_SEC;
}

void bench_begin(bench_times *times)
{
    times->used = processor_now();
    times->before = bench_now();
}

void bench_end(bench_times *times)
{
    const double seconds = bench_now() - times->before;
    if (times->first == 0) {
        times->first = seconds;
        return;
    }
    if (times->n == BENCH_RUNS_MOST)
        return;
    times->seconds[times->n] = seconds;
    times->processor[times->n++] = processor_now() - times->used;
}

static int compare(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

void bench_sort(bench_times *times)
{
    qsort(times->seconds, (size_t)times->n, sizeof *times->seconds, compare);
    qsort(times->processor, (size_t)times->n, sizeof *times->processor, compare);
}

int bench_runs(int asked)
{
    return asked < 1 ? 1 : asked < BENCH_RUNS_MOST ? asked : BENCH_RUNS_MOST;
}

vv_status bench_read(vv_field **out, const char *path, vv_job *job)
{
    vv_file *file;
    *out = NULL;
    vv_status st = vv_file_open(&file, path, NULL, job);
    if (st != VV_OK)
        return st;
    st = vv_file_read(out, file, 0, NULL, job);
    vv_file_close(file);
    return st;
}

int bench_main(int argc, char **argv, int least, const char *usage, vv_status (*run)(int, char **, vv_job *))
{
    vv_runtime_options options;
    vv_runtime *runtime = NULL;
    vv_job *job = NULL;
    if (argc <= least) {
        fprintf(stderr, "usage: %s\n", usage);
        return 2;
    }
    vv_runtime_options_init(&options, sizeof options);
    const char *threads = getenv("VOLVIS_THREADS");
    options.threads = threads ? atoi(threads) : 0;
    vv_status st = vv_runtime_new(&runtime, &options);
    if (st == VV_OK && (st = vv_job_new(&job, runtime, NULL, NULL)) == VV_OK)
        st = run(argc, argv, job);
    if (st != VV_OK)
        fprintf(stderr, "%s\n", vv_error_last()->message);
    vv_job_release(job);
    vv_runtime_release(runtime);
    return st != VV_OK;
}
