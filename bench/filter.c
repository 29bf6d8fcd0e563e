/* Times an operation on a file in memory: filter FILE OPERATION "name=json;name=json" [RUNS]; one JSON line. */
#include "bench.h"
#include <volvis/sys/registry.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static vv_status set_all(vv_object **params, const char *settings, const vv_property_context *context)
{
    char one[200];
    vv_status st = VV_OK;
    for (const char *s = settings; *s && st == VV_OK;) {
        const size_t n = strcspn(s, ";");
        snprintf(one, sizeof one, "%.*s", (int)n, s);
        char *value = strchr(one, '=');
        if (value)
            *value++ = 0;
        st = vv_path_set(params, one, value ? value : "", context);
        s += n + (s[n] == ';');
    }
    return st;
}

static vv_status time_runs(const vv_operation *operation, const vv_field *field, const vv_object *params, int runs,
                           const char *name, vv_job *job)
{
    bench_times times = {0};
    double bytes = 0;
    vv_status st = VV_OK;
    for (int i = -1; i < runs && st == VV_OK; i++) {
        vv_field *out = NULL;
        uint64_t in_bytes = 0, out_bytes = 0;
        bench_begin(&times);
        if ((st = vv_operation_run(&out, operation, &field, 1, params, job)) != VV_OK)
            break;
        bench_end(&times);
        if ((st = vv_field_info_bytes(&in_bytes, vv_field_get_info(field))) == VV_OK)
            st = vv_field_info_bytes(&out_bytes, vv_field_get_info(out));
        bytes = (double)in_bytes + (double)out_bytes;
        vv_field_release(out);
    }
    bench_sort(&times);
    if (st == VV_OK)
        printf("{\"case\": \"%s\", \"threads\": %d, \"n\": %d, \"median_s\": %.6f, \"min_s\": %.6f, "
               "\"cpu_s\": %.6f, \"bytes\": %.0f}\n",
               name, vv_runtime_threads(vv_job_runtime(job)), runs, times.seconds[runs / 2], times.seconds[0],
               times.processor[runs / 2], bytes);
    return st;
}

static vv_status run(int argc, char **argv, vv_job *job)
{
    const vv_operation *operation = vv_registry_operation(vv_registry_builtin(), argv[2]);
    const int runs = bench_runs(argc > 4 ? atoi(argv[4]) : 5);
    vv_field *field = NULL;
    vv_object *params = NULL;
    if (!operation)
        return vv_error_last()->status;
    vv_status st = bench_read(&field, argv[1], job);
    if (st != VV_OK)
        return st;
    const vv_grid *grid = &vv_field_get_info(field)->grid;
    const vv_property_context context = {.length_unit = grid->unit, .voxel = vv_grid_voxel(grid)};
    if ((st = vv_object_new(&params, operation->params, &context)) == VV_OK &&
        (st = set_all(&params, argv[3], &context)) == VV_OK)
        st = time_runs(operation, field, params, runs, argv[2], job);
    vv_object_release(params);
    vv_field_release(field);
    return st;
}

int main(int argc, char **argv)
{
    return bench_main(argc, argv, 3, "filter FILE OPERATION SETTINGS [RUNS]", run);
}
