/* Operations as command lines: each makes a file of what it works on, the first one of files that were there. */
#include "core/job.h"
#include "core/memory.h"
#include "io/format.h"
#include "model/merge.h"
#include "run/made.h"
#include "server/command.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

const vv_dataset *vvi_command_dataset(const vv_world *world, const char *id)
{
    return id ? vvi_dataset_named(world, id) : NULL;
}

/* Words ----------------------------------------------------------------------------------------------------------- */

/* How a file was read, where that was said. */
static void put_reading(vvi_text *out, const vv_dataset *dataset)
{
    const char *const option[3] = {"input-format", "part", "raw"};
    const char *const value[3] = {dataset->format, dataset->part, dataset->raw};
    for (int i = 0; i < 3; i++)
        if (value[i]) {
            vvi_text_printf(out, " --%s=", option[i]);
            vvi_command_quote(out, value[i]);
        }
}

/* The file that the lines before have made of a dataset. */
static void put_made(vvi_text *out, const char *id, const char *suffix)
{
    char name[96];
    snprintf(name, sizeof name, "%.63s%.12s", id, suffix);
    vvi_command_quote(out, name);
}

/* Files ----------------------------------------------------------------------------------------------------------- */

vv_status vvi_command_behind(const vv_dataset **out, const char **id, const vv_world *world, vv_job *job)
{
    *out = vvi_command_dataset(world, *id);
    const vv_status st = *out ? vvi_made_behind(out, id, world, job) : VV_OK;
    if (st == VV_OK && (!*out || (!(*out)->path && !vv_dataset_is_made(*out))))
        return vv_fail(VV_E_NOT_FOUND, "the dataset '%.64s' has no file", *id ? *id : "");
    return st;
}

/* Whether lines make it: results that older versions wrote are files that go with their session. *out is for
 * vvi_made_close() in any case. */
static bool open_made(vvi_made *out, const vv_world *world, const vv_dataset *dataset, vv_job *job)
{
    *out = (vvi_made){.n = 0};
    return dataset->operation && !dataset->fields && vvi_made_open(out, world, dataset, job) == VV_OK;
}

static bool is_file(const vv_world *world, const vv_dataset *dataset, vv_job *job)
{
    vvi_made made;
    const bool by_lines = open_made(&made, world, dataset, job);
    vvi_made_close(&made);
    return !by_lines && dataset->path;
}

/* The file that it all began with; NULL: there is none. */
static const vv_dataset *origin_of(const vv_dataset *at, const vv_world *world, vv_job *job)
{
    for (int i = 0; i < VVI_MADE_DEEPEST && at; i++) {
        vvi_made made;
        const bool by_lines = open_made(&made, world, at, job);
        const vv_dataset *before = made.n > 0 ? made.input[0] : NULL;
        vvi_made_close(&made);
        if (!by_lines)
            return at->path ? at : NULL;
        at = before;
    }
    return NULL;
}

/* Samples go back into a format that alone keeps what their file says. */
static const char *suffix_of(const vv_world *world, const vv_dataset *dataset, vv_job *job)
{
    const vv_registry *registry = vvi_job_registry(job);
    const vv_format *format = NULL;
    if (vv_dataset_is_mesh(dataset, job))
        return ".ply";
    if (!(dataset = origin_of(dataset, world, job)))
        return ".nrrd";
    if (dataset->format)
        format = vv_registry_format(registry, dataset->format);
    else if (vvi_format_of_output(&format, dataset->path, registry) != VV_OK)
        format = NULL;
    return format && format->takes_origin && format->write ? format->suffixes[0] : ".nrrd";
}

/* Where a dataset is when its lines have run. first: with the options of how it is read, which are of the first file
 * of a line; else FILE:PART. */
static vv_status put_file(vvi_text *out, const vv_world *world, const char *id, bool first, vv_job *job)
{
    const vv_dataset *dataset;
    const vv_status st = vvi_command_behind(&dataset, &id, world, job);
    if (st != VV_OK)
        return st;
    if (!is_file(world, dataset, job)) {
        put_made(out, id, suffix_of(world, dataset, job));
        return VV_OK;
    }
    vvi_command_quote(out, dataset->path);
    if (first) {
        put_reading(out, dataset);
    } else if (dataset->part) {
        vvi_text_add(out, ":");
        vvi_command_quote(out, dataset->part);
    }
    return VV_OK;
}

vv_status vvi_command_input(vvi_text *out, const vv_world *world, const char *id, vv_job *job)
{
    return put_file(out, world, id, true, job);
}

/* Steps ----------------------------------------------------------------------------------------------------------- */

/* The name that people gave an input, of "a,b". */
static void put_name(vvi_text *out, const char *names, size_t i)
{
    for (; i > 0; i--)
        names += strcspn(names, ",") + 1;
    vvi_text_printf(out, " %.*s=", (int)strcspn(names, ","), names);
}

static vv_status put_inputs(vvi_text *out, const vvi_made *made, vv_job *job)
{
    const vv_operand *operands = made->operation->inputs;
    vv_status st = VV_OK;
    for (size_t i = 0; i < made->n && st == VV_OK; i++) {
        if (!made->input[i])
            continue;
        if (operands[0].names)
            put_name(out, made->names, i);
        else if (i > 0)
            vvi_text_printf(out, " %s=", vv_operation_operand(made->operation, i)->name);
        else
            vvi_text_add(out, " ");
        st = put_file(out, made->world, made->input_id[i], i == 0 && !operands[0].names, job);
    }
    return st;
}

/* As its recipe says it; names of inputs are said by the inputs. */
static vv_status put_step(vvi_text *out, const vvi_made *made, vv_job *job)
{
    vv_object *params = NULL;
    const char *names = made->operation->inputs[0].names;
    vv_status st = vvi_made_params(&params, made, job);
    if (st == VV_OK && names)
        st = vv_path_unset(&params, names, NULL);
    vvi_text_printf(out, "volvis %s", made->operation->name);
    if (st == VV_OK && (st = put_inputs(out, made, job)) == VV_OK && (st = vvi_command_options(out, params)) == VV_OK) {
        vvi_text_add(out, " -o ");
        put_made(out, made->id, suffix_of(made->world, made->dataset, job));
        vvi_text_add(out, "\n");
    }
    vv_object_release(params);
    return st;
}

static bool is_put(const vvi_text *out, const char *id, const char *suffix)
{
    vvi_text line = {0};
    vvi_text_add(&line, " -o ");
    put_made(&line, id, suffix);
    vvi_text_add(&line, "\n");
    const bool there = out->s && line.s && strstr(out->s, line.s);
    vvi_text_free(&line);
    return there;
}

/* What it stands on first; nothing of what is a file. */
static vv_status put_making(vvi_text *out, const vv_world *world, const char *id, int depth, vv_job *job)
{
    vvi_made made;
    const vv_dataset *dataset;
    vv_status st = vvi_command_behind(&dataset, &id, world, job);
    if (st != VV_OK || is_put(out, id, suffix_of(world, dataset, job)))
        return st;
    if (depth == VVI_MADE_DEEPEST) /* a scene may name datasets in a ring */
        return vv_fail(VV_E_LIMIT, "'%.64s' was made by more than %d operations", id, VVI_MADE_DEEPEST);
    if (!open_made(&made, world, dataset, job)) {
        vvi_made_close(&made);
        return dataset->path ? VV_OK : vv_error_last()->status;
    }
    for (size_t i = 0; i < made.n && st == VV_OK; i++)
        if (made.input[i])
            st = put_making(out, world, made.input_id[i], depth + 1, job);
    if (st == VV_OK)
        st = put_step(out, &made, job);
    vvi_made_close(&made);
    return st;
}

vv_status vvi_command_making(vvi_text *out, const vv_world *world, const char *id, vv_job *job)
{
    return put_making(out, world, id, 0, job);
}
