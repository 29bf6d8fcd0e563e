/* Times Marching Cubes of a file in memory: surface FILE VALUE [RUNS [apart|warm]]; one JSON line. warm: with min-max
 * blocks of the samples, made before. */
#include "core/job.h"
#include "grid/mesh.h"
#include "surface/marching.h"

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

static vv_status run(const char *path, double value, int runs, const char *how, vv_job *job)
{
    enum { MOST = 100 };
    const vvi_marching_options options = {.value = value,
                                          .topology = how && strcmp(how, "apart") == 0 ? VVI_MARCHING_APART
                                                                                       : VVI_MARCHING_DECIDED,
                                          .blocks = how && strcmp(how, "warm") == 0};
    double seconds[MOST], processor[MOST];
    vv_file *file;
    vv_field *field;
    vv_status st;
    if ((st = vv_file_open(&file, path, NULL, job)) != VV_OK)
        return st;
    st = vv_file_read(&field, file, 0, NULL, job);
    vv_file_close(file);
    if (st != VV_OK)
        return st;
    size_t vertices = 0, triangles = 0;
    runs = runs < MOST ? runs : MOST;
    for (int i = -1; i < runs && st == VV_OK; i++) {
        const double before = now();
        const clock_t used = clock();
        vv_mesh *mesh;
        if ((st = vvi_marching_cubes(&mesh, field, &options, job)) != VV_OK)
            break;
        if (i >= 0) {
            seconds[i] = now() - before;
            processor[i] = (double)(clock() - used) / CLOCKS_PER_SEC;
        }
        vertices = vv_mesh_get_info(mesh)->n_vertices;
        triangles = vv_mesh_get_info(mesh)->n_triangles;
        vv_mesh_release(mesh);
    }
    vv_field_release(field);
    if (st != VV_OK)
        return st;
    qsort(seconds, (size_t)runs, sizeof *seconds, compare);
    qsort(processor, (size_t)runs, sizeof *processor, compare);
    printf("{\"vertices\": %zu, \"triangles\": %zu, \"n\": %d, \"median_s\": %.5f, \"min_s\": %.5f, "
           "\"cpu_s\": %.5f}\n",
           vertices, triangles, runs, seconds[runs / 2], seconds[0], processor[runs / 2]);
    return VV_OK;
}

int main(int argc, char **argv)
{
    vv_runtime_options options;
    vv_runtime *runtime;
    vv_job *job;
    if (argc < 3) {
        fprintf(stderr, "usage: surface FILE VALUE [RUNS [apart|warm]]\n");
        return 2;
    }
    vv_runtime_options_init(&options, sizeof options);
    if (vv_runtime_new(&runtime, &options) != VV_OK || vv_job_new(&job, runtime, NULL, NULL) != VV_OK)
        return 1;
    const vv_status st = run(argv[1], atof(argv[2]), argc > 3 ? atoi(argv[3]) : 15, argc > 4 ? argv[4] : NULL, job);
    if (st != VV_OK)
        fprintf(stderr, "%s\n", vv_error_last()->message);
    vv_job_release(job);
    vv_runtime_release(runtime);
    return st != VV_OK;
}
