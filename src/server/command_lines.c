/* Operations as command lines: each makes a file of what it works on, the first one of files that were there. */
#include "core/job.h"
#include "core/memory.h"
#include "io/format.h"
#include "model/merge.h"
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

static void put_made(vvi_text *out, const char *id, const char *suffix, vvi_command_word *put)
{
    char name[96];
    snprintf(name, sizeof name, "%.63s%.12s", id, suffix);
    put(out, name);
}

void vvi_command_made(vvi_text *out, const char *id, const char *suffix)
{
    put_made(out, id, suffix, vvi_command_quote);
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

/* Results that older versions wrote are files that go with their session. */
bool vvi_command_open_made(vvi_made *out, const vv_world *world, const vv_dataset *dataset, vv_job *job)
{
    *out = (vvi_made){.n = 0};
    return dataset->operation && !dataset->fields && vvi_made_open(out, world, dataset, job) == VV_OK;
}

static bool is_file(const vv_world *world, const vv_dataset *dataset, vv_job *job)
{
    vvi_made made;
    const bool by_lines = vvi_command_open_made(&made, world, dataset, job);
    vvi_made_close(&made);
    return !by_lines && dataset->path;
}

/* The file that it all began with; NULL: there is none. */
static const vv_dataset *origin_of(const vv_dataset *at, const vv_world *world, vv_job *job)
{
    for (int i = 0; i < VVI_MADE_DEEPEST && at; i++) {
        vvi_made made;
        const bool by_lines = vvi_command_open_made(&made, world, at, job);
        const vv_dataset *before = made.n > 0 ? made.input[0] : NULL;
        vvi_made_close(&made);
        if (!by_lines)
            return at->path ? at : NULL;
        at = before;
    }
    return NULL;
}

const char *vvi_command_suffix(const vv_world *world, const vv_dataset *dataset, vv_job *job)
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

bool vvi_command_is_plain(const vv_dataset *dataset)
{
    return !dataset->format && !dataset->raw;
}

vv_status vvi_command_file(vvi_text *out, const vv_world *world, const char *id, bool first, vvi_command_word *put,
                           vv_job *job)
{
    const vv_dataset *dataset;
    const vv_status st = vvi_command_behind(&dataset, &id, world, job);
    if (st != VV_OK)
        return st;
    if (!is_file(world, dataset, job) || (!first && !vvi_command_is_plain(dataset))) {
        put_made(out, id, vvi_command_suffix(world, dataset, job), put);
        return VV_OK;
    }
    put(out, dataset->path);
    if (first) {
        put_reading(out, dataset);
    } else if (dataset->part) {
        vvi_text_add(out, ":");
        put(out, dataset->part);
    }
    return VV_OK;
}

vv_status vvi_command_input(vvi_text *out, const vv_world *world, const char *id, vv_job *job)
{
    return vvi_command_file(out, world, id, true, vvi_command_quote, job);
}

/* Steps ----------------------------------------------------------------------------------------------------------- */

/* The name that people gave an input, of "a,b". */
static void put_name(vvi_text *out, const char *names, size_t i)
{
    for (; i > 0; i--)
        names += strcspn(names, ",") + 1;
    vvi_text_printf(out, " %.*s=", (int)strcspn(names, ","), names);
}

/* Whether input i is the first file of the line. */
static bool is_first(const vvi_made *made, size_t i)
{
    return i == 0 && !made->operation->inputs[0].names;
}

/* named: those that people name as they like are called so; else by --names. */
static vv_status put_inputs(vvi_text *out, const vvi_made *made, bool named, vv_job *job)
{
    vv_status st = VV_OK;
    for (size_t i = 0; i < made->n && st == VV_OK; i++) {
        if (!made->input[i])
            continue;
        if (named)
            put_name(out, made->names, i);
        else if (i > 0 && !made->operation->inputs[0].names)
            vvi_text_printf(out, " %s=", vv_operation_operand(made->operation, i)->name);
        else
            vvi_text_add(out, " ");
        st = vvi_command_file(out, made->world, made->input_id[i], is_first(made, i), vvi_command_quote, job);
    }
    return st;
}

/* As its recipe says it. */
static vv_status put_step(vvi_text *out, const vvi_made *made, vv_job *job)
{
    vv_object *params = NULL;
    const char *names = made->operation->inputs[0].names;
    vv_status st = vvi_made_params(&params, made, job);
    const bool named = st == VV_OK && names && vvi_made_is_named(made, params);
    if (named)
        st = vv_path_unset(&params, names, NULL);
    vvi_text_printf(out, "volvis %s", made->operation->name);
    if (st == VV_OK && (st = put_inputs(out, made, named, job)) == VV_OK &&
        (st = vvi_command_parameters(out, made, params, vvi_command_quote)) == VV_OK) {
        vvi_text_add(out, " -o ");
        vvi_command_made(out, made->id, vvi_command_suffix(made->world, made->dataset, job));
        vvi_text_add(out, "\n");
    }
    vv_object_release(params);
    return st;
}

/* A file that is read in a way that its line cannot say, in another format. */
static void put_copy(vvi_text *out, const vv_dataset *dataset, const char *id, const char *suffix)
{
    vvi_text_add(out, "volvis convert ");
    vvi_command_quote(out, dataset->path);
    put_reading(out, dataset);
    vvi_text_add(out, " -o ");
    vvi_command_made(out, id, suffix);
    vvi_text_add(out, "\n");
}

static bool is_put(const vvi_text *out, const char *id, const char *suffix)
{
    vvi_text line = {0};
    vvi_text_add(&line, " -o ");
    vvi_command_made(&line, id, suffix);
    vvi_text_add(&line, "\n");
    const bool there = out->s && line.s && strstr(out->s, line.s);
    vvi_text_free(&line);
    return there;
}

static vv_status put_making(vvi_text *out, const vv_world *world, const char *id, bool first, int depth, vv_job *job);

/* The recipe of a mesh that another one is made of: no file comes between them, in which places would be rounded. *out
 * is for vvi_made_close() in any case. */
static bool open_mesh(vvi_made *out, const vvi_made *made, vv_job *job)
{
    *out = (vvi_made){.n = 0};
    return made->input[0] && vv_dataset_is_mesh(made->input[0], job) &&
           vvi_command_open_made(out, made->world, made->input[0], job);
}

/* Steps on meshes as one chain; *source: the id of what it begins with. */
static vv_status put_mesh_steps(vvi_text *out, vvi_text *chain, const char **source, const vvi_made *made, int depth,
                                vv_job *job)
{
    vvi_made before;
    vv_status st = VV_OK;
    *source = made->input_id[0];
    if (depth >= VVI_MADE_DEEPEST)
        return vv_fail(VV_E_LIMIT, "'%.64s' was made by more than %d operations", made->id, VVI_MADE_DEEPEST);
    if (open_mesh(&before, made, job))
        st = put_mesh_steps(out, chain, source, &before, depth + 1, job);
    else if (made->input[0])
        st = put_making(out, made->world, made->input_id[0], true, depth + 1, job);
    vvi_made_close(&before);
    for (size_t i = 1; i < made->n && st == VV_OK; i++)
        if (made->input[i])
            st = put_making(out, made->world, made->input_id[i], false, depth + 1, job);
    return st == VV_OK ? vvi_command_chain_step(chain, made, true, job) : st;
}

static vv_status put_mesh_chain(vvi_text *out, const vvi_made *made, int depth, vv_job *job)
{
    const char *source;
    vvi_text chain = {0};
    vv_status st = put_mesh_steps(out, &chain, &source, made, depth, job);
    vvi_text_add(out, "volvis pipe ");
    if (st == VV_OK)
        st = vvi_command_input(out, made->world, source, job);
    vvi_text_add(out, " ");
    vvi_command_quote(out, chain.s ? chain.s : "");
    vvi_text_add(out, " -o ");
    vvi_command_made(out, made->id, vvi_command_suffix(made->world, made->dataset, job));
    vvi_text_add(out, "\n");
    out->bad |= chain.bad;
    vvi_text_free(&chain);
    return st;
}

/* One line, behind those of what it stands on. */
static vv_status put_lines(vvi_text *out, const vvi_made *made, int depth, vv_job *job)
{
    vv_status st = VV_OK;
    vvi_made mesh;
    const bool on_mesh = open_mesh(&mesh, made, job);
    vvi_made_close(&mesh);
    if (on_mesh)
        return put_mesh_chain(out, made, depth, job);
    for (size_t i = 0; i < made->n && st == VV_OK; i++)
        if (made->input[i])
            st = put_making(out, made->world, made->input_id[i], is_first(made, i), depth + 1, job);
    return st == VV_OK ? put_step(out, made, job) : st;
}

/* What it stands on first; nothing of what is a file and can be named. first: as the first file of a line. */
static vv_status put_making(vvi_text *out, const vv_world *world, const char *id, bool first, int depth, vv_job *job)
{
    vvi_made made;
    const vv_dataset *dataset;
    vv_status st = vvi_command_behind(&dataset, &id, world, job);
    if (st != VV_OK || is_put(out, id, vvi_command_suffix(world, dataset, job)))
        return st;
    if (depth == VVI_MADE_DEEPEST) /* a scene may name datasets in a ring */
        return vv_fail(VV_E_LIMIT, "'%.64s' was made by more than %d operations", id, VVI_MADE_DEEPEST);
    if (!vvi_command_open_made(&made, world, dataset, job)) {
        vvi_made_close(&made);
        if (!dataset->path)
            return vv_error_last()->status;
        if (!first && !vvi_command_is_plain(dataset))
            put_copy(out, dataset, id, vvi_command_suffix(world, dataset, job));
        return VV_OK;
    }
    st = put_lines(out, &made, depth, job);
    vvi_made_close(&made);
    return st;
}

vv_status vvi_command_making(vvi_text *out, const vv_world *world, const char *id, vv_job *job)
{
    return put_making(out, world, id, true, 0, job);
}
