/* Times the histogram and statistics of a file in memory: histogram FILE [RUNS]; one JSON line. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <volvis/volvis.h>

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static int compare(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static vv_status run(const char *path, int runs, vv_job *job)
{
    enum { MOST = 100 };
    double seconds[MOST], processor[MOST], mean = 0;
    vv_file *file;
    vv_field *field;
    vv_status st;
    if ((st = vv_file_open(&file, path, NULL, job)) != VV_OK)
        return st;
    st = vv_file_read(&field, file, 0, NULL, job);
    vv_file_close(file);
    if (st != VV_OK)
        return st;
    double n = 0;
    runs = runs < MOST ? runs : MOST;
    for (int i = -1; i < runs && st == VV_OK; i++) {
        vv_values *values = NULL;
        const double before = now();
        const clock_t used = clock();
        if ((st = vv_measure_values(&values, field, NULL, job)) != VV_OK)
            break;
        if (i >= 0) {
            seconds[i] = now() - before;
            processor[i] = (double)(clock() - used) / CLOCKS_PER_SEC;
        }
        mean = values->mean;
        n = (double)values->count;
        vv_values_free(values);
    }
    vv_field_release(field);
    if (st != VV_OK)
        return st;
    qsort(seconds, (size_t)runs, sizeof *seconds, compare);
    qsort(processor, (size_t)runs, sizeof *processor, compare);
    printf(
        "{\"case\": \"values %s\", \"threads\": %d, \"n\": %d, \"median_s\": %.5f, \"min_s\": %.5f, \"cpu_s\": %.5f, "
        "\"gvox_s\": %.2f, \"mean\": %.4f}\n",
        path, vv_runtime_threads(vv_job_runtime(job)), runs, seconds[runs / 2], seconds[0], processor[runs / 2],
        n / seconds[runs / 2] / 1e9, mean);
    return VV_OK;
}

int main(int argc, char **argv)
{
    vv_runtime *runtime = NULL;
    vv_runtime_options options;
    vv_job *job = NULL;
    if (argc < 2) {
        fprintf(stderr, "usage: histogram FILE [RUNS]\n");
        return 2;
    }
    vv_runtime_options_init(&options, sizeof options);
    const char *threads = getenv("VOLVIS_THREADS");
    options.threads = threads ? atoi(threads) : 0;
    vv_status st = vv_runtime_new(&runtime, &options);
    if (st == VV_OK && (st = vv_job_new(&job, runtime, NULL, NULL)) == VV_OK)
        st = run(argv[1], argc > 2 ? atoi(argv[2]) : 9, job);
    if (st != VV_OK)
        fprintf(stderr, "histogram: %s\n", vv_error_last()->message);
    vv_job_release(job);
    vv_runtime_release(runtime);
    return st != VV_OK;
}
