/* Data that are made, as one run of all the operations that lead to them: what memory does not hold streams through all
 * of them. */
#include "core/status.h"
#include "model/dataset.h"
#include "run/made.h"
#include "scene/load.h"

/* Inputs ---------------------------------------------------------------------------------------------------------- */

/* What is done to data does not depend on the memory of a machine; pictures may. */
static vv_status open_file(vv_run_input *out, const vv_dataset *dataset, vv_job *job)
{
    vv_read_options options;
    vv_read_options_init(&options, sizeof options);
    options.format = dataset->format;
    options.part = dataset->part;
    options.raw = dataset->raw;
    options.finest = true;
    out->path = out->name = dataset->path;
    out->part = dataset->part;
    return vv_file_open(&out->file, dataset->path, &options, job);
}

static vv_status open_input(vv_run_input *out, const vv_world *world, const vv_dataset *dataset, vv_job *job)
{
    vv_field *field = NULL;
    vv_mesh *mesh = NULL;
    vv_status st = VV_OK;
    if (vv_dataset_is_mesh(dataset, job)) {
        st = vv_dataset_mesh(&mesh, world, dataset, job);
        out->mesh = mesh;
    } else if (dataset->fields) {
        st = vv_dataset_field(&field, world, dataset, NULL, 0, job);
        out->field = field;
    } else if (vv_dataset_is_made(dataset)) {
        st = vvi_dataset_open(&out->file, world, dataset, job);
    } else {
        st = open_file(out, dataset, job);
    }
    return st;
}

static vv_status add_input(int *out, vvi_made_run *run, const vv_dataset *dataset, const char *id, vv_job *job)
{
    for (size_t i = 0; i < run->n_inputs; i++)
        if (run->of_input[i] == dataset) {
            *out = (int)i;
            return VV_OK;
        }
    if (run->n_inputs == VVI_RUN_INPUTS)
        return vv_fail(VV_E_LIMIT, "it is made of more than %d files", VVI_RUN_INPUTS);
    vv_run_input *input = &run->input[run->n_inputs];
    *input = (vv_run_input){.frame = -1, .name = id};
    run->of_input[run->n_inputs] = dataset;
    *out = (int)run->n_inputs++;
    return open_input(input, run->world, dataset, job);
}

/* Steps ----------------------------------------------------------------------------------------------------------- */

static vv_status add_node(int *out, vvi_made_run *run, const vv_dataset *dataset, const char *id, vv_job *job);

static bool is_step(const vvi_made_run *run, const vv_dataset *dataset, vv_job *job)
{
    return vv_dataset_is_made(dataset) && !vv_dataset_is_mesh(dataset, job) && run->n_steps < VVI_MADE_DEEPEST;
}

/* Behind those that it takes. */
static vv_status add_step(int *out, vvi_made_run *run, const vvi_made *made, vv_job *job)
{
    vvi_run_takes takes = {.n = made->n};
    vv_status st = VV_OK;
    for (size_t i = 0; i < made->n && st == VV_OK; i++) {
        takes.from[i] = VVI_RUN_GAP;
        if (made->input[i])
            st = add_node(&takes.from[i], run, made->input[i], made->input_id[i], job);
    }
    if (st == VV_OK && run->n_steps == VVI_MADE_DEEPEST)
        st = vv_fail(VV_E_LIMIT, "it is made by more than %d operations", VVI_MADE_DEEPEST);
    if (st != VV_OK)
        return st;
    const size_t n = run->n_steps;
    run->step[n].operation = made->operation;
    run->takes[n] = takes;
    run->of_step[n] = made->dataset;
    *out = VVI_RUN_INPUTS + (int)n;
    if ((st = vvi_made_params(&run->step[n].params, made, job)) == VV_OK)
        run->n_steps++;
    return st;
}

static vv_status add_node(int *out, vvi_made_run *run, const vv_dataset *dataset, const char *id, vv_job *job)
{
    vvi_made made;
    for (size_t s = 0; s < run->n_steps; s++)
        if (run->of_step[s] == dataset) {
            *out = VVI_RUN_INPUTS + (int)s;
            return VV_OK;
        }
    if (!is_step(run, dataset, job))
        return add_input(out, run, dataset, id, job);
    vv_status st = vvi_made_open(&made, run->world, dataset, job);
    if (st == VV_OK)
        st = add_step(out, run, &made, job);
    vvi_made_close(&made);
    return st;
}

vv_status vvi_made_run_open(vvi_made_run *out, const vv_world *world, const vv_dataset *dataset, vv_job *job)
{
    int last;
    uint64_t content; /* nothing is made of itself */
    const char *id = "";
    *out = (vvi_made_run){.world = world};
    vv_status st = vvi_made_behind(&dataset, &id, world, job);
    if (st == VV_OK && vv_dataset_is_made(dataset))
        st = vvi_made_content(&content, world, dataset, job);
    return st == VV_OK ? add_node(&last, out, dataset, id, job) : st;
}

void vvi_made_run_close(vvi_made_run *run)
{
    for (size_t s = 0; s < run->n_steps; s++)
        vv_object_release(run->step[s].params);
    for (size_t i = 0; i < run->n_inputs; i++) {
        vv_field_release((vv_field *)(uintptr_t)run->input[i].field);
        vv_mesh_release((vv_mesh *)(uintptr_t)run->input[i].mesh);
        vv_file_close(run->input[i].file);
    }
    run->n_steps = run->n_inputs = 0;
}

vvi_run_plan vvi_made_run_plan(const vvi_made_run *run, const char *name)
{
    return (vvi_run_plan){.inputs = run->input,
                          .n_inputs = run->n_inputs,
                          .steps = run->step,
                          .takes = run->takes,
                          .n_steps = run->n_steps,
                          .name = run->n_steps ? run->step[run->n_steps - 1].operation->name : name};
}

/* Files ----------------------------------------------------------------------------------------------------------- */

static vv_status write_samples(const char *path, const vv_world *world, const vv_dataset *dataset, vv_job *job)
{
    vvi_made_run all;
    vv_run *run = NULL;
    vv_write_options options;
    vv_write_options_init(&options, sizeof options);
    options.spare_inputs = true;
    vv_status st = vvi_made_run_open(&all, world, dataset, job);
    if (st == VV_OK) {
        const vvi_run_plan plan = vvi_made_run_plan(&all, "write");
        st = vvi_run_new(&run, &plan, &(vv_run_output){.path = path, .options = &options}, job);
    }
    if (st == VV_OK)
        st = vv_run_write(run);
    vv_run_release(run);
    vvi_made_run_close(&all);
    return st;
}

static vv_status write_mesh(const char *path, const vv_world *world, const vv_dataset *dataset, vv_job *job)
{
    vv_mesh *mesh = NULL;
    vv_mesh_write_options options;
    vv_mesh_write_options_init(&options, sizeof options);
    options.spare_inputs = true;
    vv_status st = vv_dataset_mesh(&mesh, world, dataset, job);
    if (st == VV_OK)
        st = vv_mesh_write(path, mesh, &options, job);
    vv_mesh_release(mesh);
    return st;
}

vv_status vvi_made_write(const char *path, const vv_world *world, const vv_dataset *dataset, vv_job *job)
{
    return vv_dataset_is_mesh(dataset, job) ? write_mesh(path, world, dataset, job)
                                            : write_samples(path, world, dataset, job);
}
