/* Times the histogram and statistics of noise around a ball in memory: histogram N TYPE [RUNS]; one JSON line. */
#include "grid/statistics.h"

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

/* A third air with a little noise, tissue that wavers, and bright spots: as a scan of a head has. */
static double sample(size_t i, size_t n, uint64_t *noise)
{
    *noise = *noise * 6364136223846793005u + 1442695040888963407u;
    const double x = (double)(i % n) / (double)n - 0.5, y = (double)(i / n % n) / (double)n - 0.5;
    const double z = (double)(i / n / n) / (double)n - 0.5, r = 4 * (x * x + y * y + z * z);
    const double grain = (double)(*noise >> 40) / (double)(1 << 24);
    return r > 1 ? 4 * grain : r > 0.8 ? 180 + 40 * grain : 60 + 60 * r + 30 * grain;
}

static vv_field *make(size_t n, vv_type type, vv_job *job)
{
    vv_field_info info = vv_field_info_default();
    vv_field *f;
    void *data;
    uint64_t noise = 1994;
    info.type = type;
    for (int a = 0; a < 3; a++)
        info.grid.dims[a] = (int64_t)n;
    if (vv_field_new_empty(&f, &data, &info, job) != VV_OK)
        return NULL;
    const double scale = vv_type_bytes(type) == 2 ? 16 : 1;
    for (size_t i = 0; i < n * n * n; i++) {
        const double v = scale * sample(i, n, &noise);
        vvi_samples_from_f64((char *)data + i * vv_type_bytes(type), &v, type, 1);
    }
    return f;
}

static vv_status run(size_t n, vv_type type, int runs, vv_runtime *runtime)
{
    enum { MOST = 100 };
    double seconds[MOST], processor[MOST], mean = 0;
    vv_job *job = NULL;
    vv_status st = vv_job_new(&job, runtime, NULL, NULL);
    vv_field *field = st == VV_OK ? make(n, type, job) : NULL;
    runs = runs < MOST ? runs : MOST;
    for (int i = -1; i < runs && field && st == VV_OK; i++) {
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
        vv_values_free(values);
    }
    vv_field_release(field);
    if (st == VV_OK && field) {
        qsort(seconds, (size_t)runs, sizeof *seconds, compare);
        qsort(processor, (size_t)runs, sizeof *processor, compare);
        printf("{\"case\": \"values %zu^3 %s\", \"isa\": \"%s\", \"threads\": %d, \"n\": %d, \"median_s\": %.5f, "
               "\"min_s\": %.5f, \"cpu_s\": %.5f, \"gvox_s\": %.2f, \"mean\": %.6f}\n",
               n, vv_type_name(type), vv_runtime_isa(runtime), vv_runtime_threads(runtime), runs, seconds[runs / 2],
               seconds[0], processor[runs / 2], (double)(n * n * n) / seconds[runs / 2] / 1e9, mean);
    }
    vv_job_release(job);
    return st == VV_OK && !field ? VV_E_MEMORY : st;
}

int main(int argc, char **argv)
{
    vv_runtime *runtime;
    vv_runtime_options options;
    vv_type type;
    if (argc < 3 || !vv_type_parse(&type, argv[2])) {
        fprintf(stderr, "usage: histogram N TYPE [RUNS]\n");
        return 2;
    }
    vv_runtime_options_init(&options, sizeof options);
    options.threads = getenv("VOLVIS_THREADS") ? atoi(getenv("VOLVIS_THREADS")) : 0;
    vv_status st = vv_runtime_new(&runtime, &options);
    if (st == VV_OK)
        st = run((size_t)atoi(argv[1]), type, argc > 3 ? atoi(argv[3]) : 9, runtime);
    if (st != VV_OK)
        fprintf(stderr, "%s\n", vv_error_last()->message);
    else
        vv_runtime_release(runtime);
    return st != VV_OK;
}
