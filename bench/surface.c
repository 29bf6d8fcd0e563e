/* Times Marching Cubes of a file in memory: surface FILE VALUE [RUNS [apart|warm]]; one JSON line. warm: with min-max
 * blocks of the samples, made before. */
#include "bench.h"
#include "core/job.h"
#include "grid/mesh.h"
#include "surface/marching.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static vv_status run(int argc, char **argv, vv_job *job)
{
    const char *how = argc > 4 ? argv[4] : "";
    const int runs = bench_runs(argc > 3 ? atoi(argv[3]) : 15);
    const vvi_marching_options options = {.value = atof(argv[2]),
                                          .topology =
                                              strcmp(how, "apart") == 0 ? VVI_MARCHING_APART : VVI_MARCHING_DECIDED,
                                          .blocks = strcmp(how, "warm") == 0};
    bench_times times = {0};
    size_t vertices = 0, triangles = 0;
    vv_field *field;
    vv_status st = bench_read(&field, argv[1], job);
    for (int i = -1; i < runs && st == VV_OK; i++) {
        vv_mesh *mesh;
        bench_begin(&times);
        if ((st = vvi_marching_cubes(&mesh, field, &options, job)) != VV_OK)
            break;
        bench_end(&times);
        vertices = vv_mesh_get_info(mesh)->n_vertices;
        triangles = vv_mesh_get_info(mesh)->n_triangles;
        vv_mesh_release(mesh);
    }
    vv_field_release(field);
    bench_sort(&times);
    if (st == VV_OK)
        printf("{\"vertices\": %zu, \"triangles\": %zu, \"n\": %d, \"median_s\": %.5f, \"min_s\": %.5f, "
               "\"cpu_s\": %.5f}\n",
               vertices, triangles, runs, times.seconds[runs / 2], times.seconds[0], times.processor[runs / 2]);
    return st;
}

int main(int argc, char **argv)
{
    return bench_main(argc, argv, 2, "surface FILE VALUE [RUNS [apart|warm]]", run);
}
