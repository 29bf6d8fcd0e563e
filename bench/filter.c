/* Times an operation on a file in memory: filter NAME FILE RUNS [PROPERTY=JSON]...; one JSON line. A file of markers,
 * where the operation takes a second input, is `+FILE`. */
#include "bench.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <volvis/sys/registry.h>

enum { INPUTS_MOST = 4 };

typedef struct filtering {
    const vv_operation *operation;
    vv_object *params;
    vv_field *inputs[INPUTS_MOST];
    size_t n;
} filtering;

static vv_status take_word(filtering *f, const char *word, vv_job *job)
{
    char name[64];
    const char *value = strchr(word, '=');
    const vv_grid *grid = &vv_field_get_info(f->inputs[0])->grid;
    const vv_property_context context = {.length_unit = grid->unit, .voxel = vv_grid_voxel(grid)};
    if (word[0] == '+' && f->n < INPUTS_MOST)
        return bench_read(&f->inputs[f->n++], word + 1, job);
    if (!value || (size_t)(value - word) >= sizeof name)
        return VV_E_ARGUMENT;
    snprintf(name, sizeof name, "%.*s", (int)(value - word), word);
    return vv_path_set(&f->params, name, value + 1, &context);
}

static vv_status prepare(filtering *f, int argc, char **argv, vv_job *job)
{
    f->operation = vv_registry_operation(vv_registry_builtin(), argv[1]);
    if (!f->operation)
        return VV_E_ARGUMENT;
    vv_status st = bench_read(&f->inputs[0], argv[2], job);
    f->n = st == VV_OK;
    if (st == VV_OK)
        st = vv_object_new(&f->params, f->operation->params, NULL);
    for (int i = 4; i < argc && st == VV_OK; i++)
        st = take_word(f, argv[i], job);
    return st;
}

static vv_status run(int argc, char **argv, vv_job *job)
{
    const int runs = bench_runs(atoi(argv[3]));
    bench_times times = {0};
    filtering f = {0};
    uint64_t in_bytes = 0, out_bytes = 0;
    vv_status st = prepare(&f, argc, argv, job);
    for (int i = -1; i < runs && st == VV_OK; i++) {
        vv_field *out = NULL;
        bench_begin(&times);
        st = vv_operation_run(&out, f.operation, (const vv_field *const *)f.inputs, f.n, f.params, job);
        bench_end(&times);
        if (st == VV_OK && (st = vv_field_info_bytes(&in_bytes, vv_field_get_info(f.inputs[0]))) == VV_OK)
            st = vv_field_info_bytes(&out_bytes, vv_field_get_info(out));
        vv_field_release(out);
    }
    bench_sort(&times);
    if (st == VV_OK)
        printf("{\"case\": \"%s\", \"threads\": %d, \"n\": %d, \"median_s\": %.8f, \"min_s\": %.8f, \"cpu_s\": %.8f, "
               "\"bytes\": %llu}\n",
               argv[1], vv_runtime_threads(vv_job_runtime(job)), runs, times.seconds[runs / 2], times.seconds[0],
               times.processor[runs / 2], (unsigned long long)(in_bytes + out_bytes));
    for (size_t i = 0; i < f.n; i++)
        vv_field_release(f.inputs[i]);
    vv_object_release(f.params);
    return st;
}

int main(int argc, char **argv)
{
    return bench_main(argc, argv, 3, "filter NAME FILE RUNS [PROPERTY=JSON]... [+INPUT]...", run);
}
