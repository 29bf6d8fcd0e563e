/* Data that are made, written to a file: a chain of operations as the steps of one run, which streams what memory does
 * not hold. */
#include "core/status.h"
#include "model/dataset.h"
#include "run/made.h"
#include "scene/load.h"
#include <string.h>

/* Chains ----------------------------------------------------------------------------------------------------------- */

/* In front of the others. */
static vv_status add_step(vvi_made_chain *out, const vvi_made *made, vv_job *job)
{
    vv_step step = {made->operation, NULL};
    if (out->n == VVI_MADE_DEEPEST)
        return vv_fail(VV_E_LIMIT, "the chain has more than %d steps", VVI_MADE_DEEPEST);
    const vv_status st = vvi_made_params(&step.params, made, job);
    if (st != VV_OK)
        return st;
    memmove(out->step + 1, out->step, out->n++ * sizeof step);
    out->step[0] = step;
    memcpy(out->input, made->input, sizeof out->input);
    memcpy(out->input_id, made->input_id, sizeof out->input_id);
    out->n_inputs = made->n;
    return VV_OK;
}

static bool goes_on(const vvi_made_chain *chain, const vv_dataset *from, vv_job *job)
{
    const vv_dataset *before = chain->input[0];
    return chain->n_inputs == 1 && before && before != from && vv_dataset_is_made(before) &&
           !vv_dataset_is_mesh(before, job);
}

vv_status vvi_made_chain_open(vvi_made_chain *out, const vv_world *world, const vv_dataset *dataset,
                              const vv_dataset *from, vv_job *job)
{
    const char *id = "";
    vv_status st = vvi_made_behind(&dataset, &id, world, job);
    *out = (vvi_made_chain){.input = {dataset}, .input_id = {id}, .n_inputs = 1};
    while (st == VV_OK && goes_on(out, from, job)) {
        vvi_made made;
        if ((st = vvi_made_open(&made, world, out->input[0], job)) == VV_OK)
            st = add_step(out, &made, job);
        vvi_made_close(&made);
    }
    return st;
}

void vvi_made_chain_close(vvi_made_chain *chain)
{
    for (size_t i = 0; i < chain->n; i++)
        vv_object_release(chain->step[i].params);
    chain->n = 0;
}

/* Files ------------------------------------------------------------------------------------------------------------ */

/* What is made of several inputs on the way is a file as it is: it has the words of what it began with. */
static void take_whole(vvi_made_chain *chain, const vv_dataset *dataset)
{
    bool files = true;
    for (size_t i = 0; i < chain->n_inputs; i++)
        files = files && !(chain->input[i] && vv_dataset_is_made(chain->input[i]));
    if (files)
        return;
    vvi_made_chain_close(chain);
    *chain = (vvi_made_chain){.input = {dataset}, .input_id = {""}, .n_inputs = 1};
}

static vv_status open_input(vv_run_input *out, const vvi_made_chain *chain, size_t index, const vv_world *world,
                            vv_job *job)
{
    const vv_dataset *dataset = chain->input[index];
    vv_field *field = NULL;
    vv_mesh *mesh = NULL;
    vv_status st = VV_OK;
    *out = (vv_run_input){.frame = -1, .name = chain->input_id[index]};
    if (!dataset)
        return VV_OK;
    if (vv_dataset_is_mesh(dataset, job)) {
        st = vv_dataset_mesh(&mesh, world, dataset, job);
        out->mesh = mesh;
    } else if (dataset->fields) {
        st = vv_dataset_field(&field, world, dataset, NULL, 0, job);
        out->field = field;
    } else {
        st = vvi_dataset_open(&out->file, world, dataset, job);
        out->path = dataset->path;
        out->part = dataset->part;
    }
    return st;
}

static void close_input(vv_run_input *input)
{
    vv_field_release((vv_field *)(uintptr_t)input->field);
    vv_mesh_release((vv_mesh *)(uintptr_t)input->mesh);
    vv_file_close(input->file);
}

static vv_status write_chain(const char *path, const vvi_made_chain *chain, const vv_world *world, vv_job *job)
{
    vv_run_input input[VVI_RUN_INPUTS];
    vv_write_options options;
    vv_run *run = NULL;
    size_t n = 0;
    vv_write_options_init(&options, sizeof options);
    options.spare_inputs = true;
    vv_status st = VV_OK;
    while (n < chain->n_inputs && st == VV_OK) {
        st = open_input(&input[n], chain, n, world, job);
        n++;
    }
    if (st == VV_OK)
        st = vv_run_new(&run, input, n, chain->step, chain->n, &(vv_run_output){.path = path, .options = &options},
                        chain->n ? chain->step[chain->n - 1].operation->name : "write", job);
    if (st == VV_OK)
        st = vv_run_write(run);
    vv_run_release(run);
    for (size_t i = 0; i < n; i++)
        close_input(&input[i]);
    return st;
}

static vv_status write_samples(const char *path, const vv_world *world, const vv_dataset *dataset, vv_job *job)
{
    vvi_made_chain chain;
    vv_status st = vvi_made_chain_open(&chain, world, dataset, NULL, job);
    if (st == VV_OK) {
        take_whole(&chain, dataset);
        st = write_chain(path, &chain, world, job);
    }
    vvi_made_chain_close(&chain);
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
