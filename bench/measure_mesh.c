/* Times measures of the Marching Cubes surface of a file in memory: measure_mesh FILE VALUE [RUNS]; one JSON line each.
 */
#include "core/job.h"
#include "surface/marching.h"

#include <stdio.h>
#include <stdlib.h>
#include <time.h>
#include <volvis/volvis.h>

enum { MOST = 100 };

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

static vv_status time_mass(const vv_mesh *mesh, bool sampled, int runs, vv_job *job)
{
    double seconds[MOST], processor[MOST];
    vv_mesh_measures m = {0};
    vv_mesh_measure_options o;
    vv_mesh_measure_options_init(&o, sizeof o);
    o.sampled = sampled;
    o.open = true;
    for (int i = -1; i < runs; i++) {
        const double before = now();
        const clock_t used = clock();
        const vv_status st = vv_mesh_measure(&m, mesh, &o, job);
        if (st != VV_OK)
            return st;
        if (i >= 0) {
            seconds[i] = now() - before;
            processor[i] = (double)(clock() - used) / CLOCKS_PER_SEC;
        }
    }
    qsort(seconds, (size_t)runs, sizeof *seconds, compare);
    qsort(processor, (size_t)runs, sizeof *processor, compare);
    printf("{\"what\": \"area and volume%s\", \"triangles\": %zu, \"n\": %d, \"median_s\": %.5f, \"min_s\": %.5f, "
           "\"cpu_s\": %.5f, "
           "\"area\": %.1f, \"volume\": %.1f, \"open_edges\": %zu}\n",
           sampled ? " with the chords' errors" : "", m.n_triangles, runs, seconds[runs / 2], seconds[0],
           processor[runs / 2], m.area.value, m.volume.value, m.n_open_edges);
    return VV_OK;
}

static vv_status run(const char *path, double value, int runs, vv_job *job)
{
    const vvi_marching_options options = {.value = value, .cap = true};
    vv_file *file;
    vv_field *field;
    vv_mesh *mesh;
    vv_status st;
    if ((st = vv_file_open(&file, path, NULL, job)) != VV_OK)
        return st;
    st = vv_file_read(&field, file, 0, NULL, job);
    vv_file_close(file);
    if (st != VV_OK)
        return st;
    st = vvi_marching_cubes(&mesh, field, &options, job);
    vv_field_release(field);
    if (st != VV_OK)
        return st;
    if ((st = time_mass(mesh, false, runs, job)) == VV_OK)
        st = time_mass(mesh, true, runs, job);
    vv_mesh_release(mesh);
    return st;
}

int main(int argc, char **argv)
{
    vv_runtime_options options;
    vv_runtime *runtime;
    vv_job *job;
    if (argc < 3) {
        fprintf(stderr, "usage: measure_mesh FILE VALUE [RUNS]\n");
        return 2;
    }
    vv_runtime_options_init(&options, sizeof options);
    if (vv_runtime_new(&runtime, &options) != VV_OK || vv_job_new(&job, runtime, NULL, NULL) != VV_OK)
        return 1;
    const int runs = argc > 3 ? atoi(argv[3]) : 15;
    const vv_status st = run(argv[1], atof(argv[2]), runs < 1 ? 1 : runs < MOST ? runs : MOST, job);
    if (st != VV_OK)
        fprintf(stderr, "%s\n", vv_error_last()->message);
    vv_job_release(job);
    vv_runtime_release(runtime);
    return st != VV_OK;
}
