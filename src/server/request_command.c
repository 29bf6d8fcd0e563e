/* What was done, as command lines that do it again: the operations that made the data, then the picture. */
#include "core/job.h"
#include "core/memory.h"
#include "io/format.h"
#include "model/context.h"
#include "model/merge.h"
#include "run/made.h"
#include "server/command.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { STEPS_MOST = 64, PATH_MOST = 384 };

static const vv_dataset *find_dataset(const vv_world *world, const char *id)
{
    return id ? (const vv_dataset *)(const void *)vv_collection_find(world->datasets, id) : NULL;
}

/* Operations ------------------------------------------------------------------------------------------------------ */

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

/* The id, as the World has it, of the first input: as `source` says it, or among the inputs by name. NULL: none. */
static const char *source_of(const vv_world *world, const vv_dataset *d, const vv_operation *operation)
{
    const char *id = d->source;
    json_t *inputs = d->inputs ? json_loads(d->inputs, 0, NULL) : NULL;
    if (!id && operation->inputs[0].names)
        id = json_string_value(json_object_iter_value(json_object_iter(inputs)));
    else if (!id)
        id = json_string_value(json_object_get(inputs, operation->inputs[0].name));
    const char *own = NULL;
    for (size_t i = 0; id && i < world->datasets->n && !own; i++)
        own = strcmp(world->datasets->entry[i].id, id) == 0 ? world->datasets->entry[i].id : NULL;
    json_decref(inputs);
    return own;
}

static bool has_data(const vv_dataset *dataset)
{
    return dataset && (dataset->path || vv_dataset_is_made(dataset));
}

/* Whether lines can make it again: which operation, and of what. */
static const vv_operation *made_by(const vv_world *world, const vv_dataset *dataset, const vv_registry *registry)
{
    const vv_operation *operation = dataset->operation ? vv_registry_operation(registry, dataset->operation) : NULL;
    const char *source = operation ? source_of(world, dataset, operation) : NULL;
    return has_data(find_dataset(world, source)) ? operation : NULL;
}

/* What lines take for a dataset: of one whose operation is switched off its first input. */
static const char *behind(const vv_world *world, const char *id, const vv_registry *registry)
{
    for (int i = 0; i < STEPS_MOST; i++) {
        const vv_dataset *dataset = find_dataset(world, id);
        const vv_operation *operation =
            dataset && vv_dataset_is_made(dataset) && !dataset->on ? made_by(world, dataset, registry) : NULL;
        if (!operation)
            break;
        id = source_of(world, dataset, operation);
    }
    return id;
}

/* The file that it all began with; NULL: there is none. */
static const vv_dataset *origin_of(const vv_world *world, const vv_dataset *dataset, const vv_registry *registry)
{
    for (int i = 0; i < STEPS_MOST && dataset && !dataset->path; i++) {
        const vv_operation *operation = made_by(world, dataset, registry);
        dataset = operation ? find_dataset(world, source_of(world, dataset, operation)) : NULL;
    }
    return dataset && dataset->path ? dataset : NULL;
}

/* Samples go back into a format that alone keeps what their file says. */
static const char *suffix_of(const vv_world *world, const vv_dataset *dataset, vv_job *job)
{
    const char *path = dataset->path, *slash = path ? strrchr(path, '/') : NULL;
    const char *dot = path ? strrchr(slash ? slash : path, '.') : NULL;
    const vv_format *format = NULL;
    if (dot)
        return dot;
    if (!path && vv_dataset_is_mesh(dataset, job))
        return ".ply";
    const vv_registry *registry = vvi_job_registry(job);
    const vv_dataset *origin = origin_of(world, dataset, registry);
    if (origin && origin->format)
        format = vv_registry_format(registry, origin->format);
    else if (origin && vvi_format_of_output(&format, origin->path, registry) != VV_OK)
        format = NULL;
    return format && format->takes_origin && format->write ? format->suffixes[0] : ".nrrd";
}

/* The file of a dataset as a word of the line that comes now. */
void vvi_command_input(vvi_text *out, const vv_world *world, const char *id, vv_job *job)
{
    id = behind(world, id, vvi_job_registry(job));
    const vv_dataset *dataset = find_dataset(world, id);
    if (made_by(world, dataset, vvi_job_registry(job))) {
        put_made(out, id, suffix_of(world, dataset, job));
        return;
    }
    vvi_command_quote(out, dataset->path ? dataset->path : id);
    put_reading(out, dataset);
}

/* NAME=FILE:PART, since options of reading are of the first. */
static void put_other(vvi_text *out, const vv_world *world, const char *name, const char *id, vv_job *job)
{
    id = behind(world, id, vvi_job_registry(job));
    const vv_dataset *dataset = find_dataset(world, id);
    vvi_text_printf(out, " %s=", name);
    if (made_by(world, dataset, vvi_job_registry(job))) {
        put_made(out, id, suffix_of(world, dataset, job));
        return;
    }
    vvi_command_quote(out, dataset->path ? dataset->path : id);
    if (dataset->part) {
        vvi_text_add(out, ":");
        vvi_command_quote(out, dataset->part);
    }
}

typedef vv_status visit_fn(void *user, const char *name, const char *id);

static vv_status for_others(const char *inputs, visit_fn *visit, void *user)
{
    const char *name;
    json_t *id, *others = inputs ? json_loads(inputs, 0, NULL) : NULL;
    vv_status st = VV_OK;
    json_object_foreach(others, name, id) if (st == VV_OK && json_is_string(id)) st =
        visit(user, name, json_string_value(id));
    json_decref(others);
    return st;
}

typedef struct making {
    vvi_text *out;
    const vv_world *world;
    int depth;
    vv_job *job;
    const vv_operation *operation; /* whose inputs are gone through; NULL: all of them are */
} making;

static vv_status visit_other(void *user, const char *name, const char *id)
{
    const making *m = user;
    const vv_dataset *dataset = find_dataset(m->world, id);
    const vv_operand *first = m->operation ? m->operation->inputs : NULL;
    if (first && !first->names && !strcmp(name, first->name)) /* it stands without its name */
        return VV_OK;
    if (!has_data(dataset))
        return vv_fail(VV_E_NOT_FOUND, "the dataset '%.64s' has no file", id);
    put_other(m->out, m->world, name, id, m->job);
    return VV_OK;
}

/* As its recipe says it; names of inputs are said by the inputs. */
static vv_status step_params(vv_object **out, const vv_world *world, const vv_dataset *dataset, vv_job *job)
{
    vvi_made made;
    vv_status st = vvi_made_open(&made, world, dataset, job);
    if (st == VV_OK && (st = vvi_made_params(out, &made, job)) == VV_OK && made.operation->inputs[0].names)
        st = vv_path_unset(out, made.operation->inputs[0].names, NULL);
    vvi_made_close(&made);
    return st;
}

/* The line that makes a dataset. */
static vv_status put_step(const making *m, const vv_operation *operation, const vv_dataset *dataset, const char *id)
{
    vv_object *params = NULL;
    vv_status st = step_params(&params, m->world, dataset, m->job);
    if (st == VV_OK) {
        vvi_text_printf(m->out, "volvis %s ", operation->name);
        if (!operation->inputs[0].names || !dataset->inputs)
            vvi_command_input(m->out, m->world, source_of(m->world, dataset, operation), m->job);
        st = for_others(dataset->inputs, visit_other, &(making){m->out, m->world, 0, m->job, operation});
    }
    if (st == VV_OK && (st = vvi_command_options(m->out, params)) == VV_OK) {
        vvi_text_add(m->out, " -o ");
        put_made(m->out, id, suffix_of(m->world, dataset, m->job));
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

static vv_status put_making_of(making *m, const char *id);

static vv_status visit_making(void *user, const char *name, const char *id)
{
    return put_making_of(user, id);
}

/* The lines that make a dataset of those that were not made here, the first one first; none where it is such a one. */
static vv_status put_making_of(making *m, const char *id)
{
    id = behind(m->world, id, vvi_job_registry(m->job));
    const vv_dataset *d = find_dataset(m->world, id);
    const vv_operation *operation = d ? made_by(m->world, d, vvi_job_registry(m->job)) : NULL;
    if (!operation || is_put(m->out, id, suffix_of(m->world, d, m->job)))
        return VV_OK;
    if (m->depth == STEPS_MOST) /* a scene may name datasets in a ring */
        return vv_fail(VV_E_LIMIT, "'%.64s' was made by more than %d operations", id, STEPS_MOST);
    m->depth++;
    vv_status st = put_making_of(m, source_of(m->world, d, operation));
    if (st == VV_OK)
        st = for_others(d->inputs, visit_making, m);
    m->depth--;
    if (st != VV_OK || (st = put_step(m, operation, d, id)) != VV_OK)
        return st;
    vvi_text_add(m->out, "\n");
    return VV_OK;
}

vv_status vvi_command_making(vvi_text *out, const vv_world *world, const char *id, vv_job *job)
{
    return put_making_of(&(making){out, world, 0, job, NULL}, id);
}

/* An operation that is about to be run: the lines of the dataset that it would make. */
static vv_status run_operation_command(vvi_task *task, vv_job *job)
{
    vvi_request *r = (vvi_request *)(void *)task;
    char id[VVI_REQUEST_ID];
    vv_world *world = NULL;
    vvi_text text = {0};
    if (!has_data(find_dataset(r->world, r->dataset)))
        return vv_fail(VV_E_NOT_FOUND, "the dataset '%.64s' has no file", r->dataset);
    vvi_request_free_id(id, r->world, "result");
    vv_status st = vvi_request_make_world(&world, r, id);
    if (st == VV_OK)
        st = vvi_command_making(&text, world, id, job);
    if (st == VV_OK && text.n > 0) {
        text.s[--text.n] = 0; /* the last line ends here */
        vvi_request_tell_text(r, &text);
    }
    vvi_text_free(&text);
    vv_object_release(&world->base);
    return vvi_request_fail_made(id, st);
}

/* The picture ----------------------------------------------------------------------------------------------------- */

typedef struct comparing {
    const vv_world *now, *before;
    vvi_text *out;
    char whole[256];  /* a list or map that was set as a whole: what is below it is told already */
    const char *view; /* that the picture is of: the line's main one */
    const char *file; /* what the file's name makes of the dataset's id */
    const char *own;  /* what the dataset is called in `before` */
    bool beyond;      /* something that no options of this line say */
} comparing;

static void put_set(comparing *c, const char *path, const char *json)
{
    vvi_text assignment = {0};
    vvi_text_printf(&assignment, "%s=%s", path, json);
    vvi_text_add(c->out, " --set ");
    vvi_command_quote(c->out, assignment.bad || !assignment.s ? "" : assignment.s);
    vvi_text_free(&assignment);
}

/* Volumes are named after the file: where a path of this World is in the one that the line begins with, before this
 * and as it is typed. false: nowhere. */
static bool path_there(char there[PATH_MOST], char typed[PATH_MOST], const comparing *c, const char *path)
{
    const vv_collection *mine = c->now->volumes, *theirs = c->before->volumes;
    size_t at = 0;
    if (strncmp(path, "views.", 6) == 0) { /* the line's only one */
        snprintf(there, PATH_MOST, "views.main%s", path + 6 + strcspn(path + 6, "."));
        memcpy(typed, there, PATH_MOST);
        return true;
    }
    if (strncmp(path, "volumes.", 8) != 0) {
        snprintf(there, PATH_MOST, "%s", path);
        snprintf(typed, PATH_MOST, "%s", path);
        return true;
    }
    const char *id = path + 8, *rest = id + strcspn(id, ".");
    const size_t n = (size_t)(rest - id), own = strlen(c->own);
    while (at < mine->n && (strncmp(mine->entry[at].id, id, n) != 0 || mine->entry[at].id[n] != 0))
        at++;
    if (at >= theirs->n)
        return false;
    const char *other = theirs->entry[at].id; /* "name" or "name_0" */
    snprintf(there, PATH_MOST, "volumes.%s%s", other, rest);
    snprintf(typed, PATH_MOST, "volumes.%s%s%s", c->file, strlen(other) < own ? "" : other + own, rest);
    return true;
}

static bool is_other_view(const comparing *c, const char *path)
{
    const size_t n = strlen(c->view);
    return strncmp(path, "views.", 6) == 0 && (strncmp(path + 6, c->view, n) != 0 || path[6 + n] != '.');
}

static bool is_told(const comparing *c, const char *path)
{
    const size_t n = strlen(c->whole);
    return n && strncmp(path, c->whole, n) == 0 && path[n] == '.';
}

static bool compare(void *user, const char *path, const vv_property *row, const vv_object *owner)
{
    comparing *c = user;
    char there[PATH_MOST], typed[PATH_MOST];
    char *now = NULL, *before = NULL;
    const bool holds = row->kind == VV_KIND_OBJECT || row->kind == VV_KIND_VARIANTS || row->kind == VV_KIND_MAP;
    if (strncmp(path, "datasets", 8) == 0 || strncmp(path, "measurements", 12) == 0 || holds || is_told(c, path) ||
        is_other_view(c, path) || !vv_object_is_set(owner, row->name))
        return true;
    if (owner->cls == &vv_volume_class && strcmp(row->name, "data") == 0)
        return true; /* the line's file */
    if (row->kind == VV_KIND_REF || !path_there(there, typed, c, path)) {
        c->beyond = true;
        return false;
    }
    if (vv_path_get(&now, &c->now->base, path) == VV_OK &&
        (vv_path_get(&before, &c->before->base, there) != VV_OK || strcmp(now, before) != 0)) {
        put_set(c, typed, now);
        if (row->kind == VV_KIND_LIST && strlen(path) < sizeof c->whole)
            memcpy(c->whole, path, strlen(path) + 1);
    }
    free(now);
    free(before);
    return true;
}

/* The dataset that all volumes show; NULL: there are several, or none. */
static const char *only_shown(const vv_world *world)
{
    const char *only = NULL;
    for (size_t i = 0; i < world->volumes->n; i++) {
        const vv_volume *volume = (const vv_volume *)(const void *)world->volumes->entry[i].object;
        const char *data = volume->data ? volume->data : world->datasets->n ? world->datasets->entry[0].id : NULL;
        if (!data || (only && strcmp(only, data) != 0))
            return NULL;
        only = data;
    }
    return only;
}

/* What the line's file is without options. */
static vv_status base_world(vv_world **out, const vv_world *world, const char *id, vv_job *job)
{
    vv_read_options options;
    const vv_dataset *dataset = find_dataset(world, id);
    if (vv_dataset_is_made(dataset))
        return vvi_world_for_dataset(out, world, id, job);
    if (vv_dataset_is_mesh(dataset, job))
        return vvi_world_for_mesh(out, dataset->path, dataset->format, dataset->part, job);
    vv_read_options_init(&options, sizeof options);
    options.format = dataset->format;
    options.part = dataset->part;
    options.raw = dataset->raw;
    return vv_world_for_file(out, dataset->path, &options, job);
}

static vv_status put_picture(vvi_text *text, bool *beyond_out, const vvi_request *r, const char *id, vv_job *job)
{
    vv_world *before = NULL;
    const vv_dataset *dataset = find_dataset(r->world, id);
    const vv_status st = base_world(&before, r->world, id, job);
    if (st != VV_OK)
        return st;
    comparing c = {.now = r->world, .before = before, .out = text, .view = r->view};
    c.own = vv_dataset_is_made(dataset) ? id : before->datasets->entry[0].id;
    c.file = made_by(r->world, dataset, vvi_job_registry(job)) ? id : c.own;
    vvi_text_add(text, "volvis render ");
    vvi_command_input(text, r->world, id, job);
    vvi_text_add(text, " -o picture.png");
    vv_path_each(&r->world->base, compare, &c);
    vv_object_release(&before->base);
    *beyond_out = c.beyond;
    return VV_OK;
}

static vv_status run_command(vvi_task *task, vv_job *job)
{
    vvi_request *r = (vvi_request *)(void *)task;
    const char *id = behind(r->world, only_shown(r->world), vvi_job_registry(job));
    const vv_dataset *dataset = find_dataset(r->world, id);
    vvi_text text = {0};
    bool beyond = !has_data(dataset);
    vv_status st = beyond ? VV_OK : vvi_command_making(&text, r->world, id, job);
    if (!beyond && st == VV_OK)
        st = put_picture(&text, &beyond, r, id, job);
    if (beyond) {
        vvi_text_free(&text);
        vvi_text_add(&text, "volvis render scene.vv.json -o picture.png # after saving the World as scene.vv.json");
    }
    if (st == VV_OK)
        vvi_request_tell_text(r, &text);
    vvi_text_free(&text);
    return st;
}

/* Asking ---------------------------------------------------------------------------------------------------------- */

/* The line has the picture's size. */
static vv_status size_world(vvi_request *r, const vvi_client *client)
{
    vv_world *sized = NULL;
    const vv_status st = vvi_camera_world(&sized, r->world, r->view, NULL, client->width, client->height);
    if (st == VV_OK) {
        vv_object_release(&r->world->base);
        r->world = sized;
    }
    return st;
}

static vv_status take_operation(vvi_request *r, const json_t *message)
{
    const char *name = json_string_value(json_object_get(message, "operation"));
    if (!name)
        return vv_fail(VV_E_ARGUMENT, "'command' of an operation needs an operation and a dataset");
    r->operation = vv_registry_operation(vv_runtime_registry(r->session->options.runtime), name);
    if (!r->operation)
        return VV_E_NOT_FOUND;
    const vv_status st = vvi_request_take_parameters(r, message);
    return st == VV_OK ? vvi_request_take_inputs(r, message) : st;
}

vv_status vvi_request_command(vvi_client *client, int64_t id, const json_t *message)
{
    const bool one = json_object_get(message, "operation") != NULL;
    if (json_object_get(message, "measurement"))
        return vvi_request_command_measure(client, id, message);
    vvi_request *r;
    vv_status st = vvi_client_fix_view(client);
    if (st == VV_OK)
        st = vvi_request_new(&r, client, id, "command", one ? run_operation_command : run_command);
    if (st != VV_OK)
        return st;
    st = one ? take_operation(r, message) : size_world(r, client);
    if (st == VV_OK)
        return vvi_request_add_quick(r);
    r->task.drop(&r->task);
    return st;
}
