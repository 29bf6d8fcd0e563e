/* What was done, as command lines that do it again: the operations that made the data, then the picture. */
#include "core/job.h"
#include "core/memory.h"
#include "measuring/measuring.h"
#include "model/context.h"
#include "model/merge.h"
#include "run/made.h"
#include "server/command.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { PATH_MOST = 384 };

/* An operation ---------------------------------------------------------------------------------------------------- */

/* A line that would fail is not worth copying: its sentence is. */
static vv_status check_plan(const vv_world *world, const char *id, vv_job *job)
{
    vv_field_info info;
    const vv_dataset *dataset = vvi_command_dataset(world, id);
    return vv_dataset_is_mesh(dataset, job) ? VV_OK : vv_dataset_info(&info, world, dataset, job);
}

/* An operation that is about to be run: the lines of the dataset that it would make. */
static vv_status run_operation_command(vvi_task *task, vv_job *job)
{
    vvi_request *r = (vvi_request *)(void *)task;
    char id[VVI_REQUEST_ID];
    vv_world *world = NULL;
    vvi_text text = {0};
    vvi_request_free_id(id, r->world, "result");
    vv_status st = vvi_request_make_world(&world, r, id);
    if (st == VV_OK)
        st = check_plan(world, id, job);
    if (st == VV_OK)
        st = vvi_command_making(&text, world, id, job);
    if (st == VV_OK && text.n > 0) {
        text.s[--text.n] = 0; /* the last line ends here */
        vvi_request_tell_text(r, &text);
    }
    vvi_text_free(&text);
    vv_object_release(&world->base);
    return vvi_request_fail_made(r->operation, id, st);
}

/* How a dataset came about, in one line or as the text between its quotation marks. */
static vv_status run_chain_command(vvi_task *task, vv_job *job)
{
    vvi_request *r = (vvi_request *)(void *)task;
    const char *source;
    vvi_text text = {0};
    const vv_status st = r->add ? vvi_command_pipe(&text, r->world, r->dataset, job)
                                : vvi_command_chain(&text, &source, r->world, r->dataset, job);
    if (st == VV_OK)
        vvi_request_tell_text(r, &text);
    vvi_text_free(&text);
    return st;
}

/* The picture ----------------------------------------------------------------------------------------------------- */

typedef struct comparing {
    const vv_world *now, *before;
    vvi_text *out;
    char whole[256];  /* a list or map that was set as a whole: what is below it is told already */
    const char *view; /* that the picture is of: the line's main one */
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
    snprintf(typed, PATH_MOST, "volumes.%s%s%s", c->own, strlen(other) < own ? "" : other + own, rest);
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

/* Measurements that the picture draws: no options say them. */
static bool draws_measurements(const vvi_request *r)
{
    const vv_collection *all = r->world->measurements;
    char *path = vvi_asprintf("views.%s.decorations.measurements", r->view), *drawn = NULL;
    bool some = false;
    for (size_t i = 0; i < all->n; i++) {
        const vv_measurement *m = vvi_measurement_nth(r->world, i);
        some |= m->visible && ((m->points && m->points->n >= 3) || m->box || vvi_measurement_has_region(m) ||
                               vv_object_is_set(&m->base, "seed"));
    }
    if (some && path && vv_path_get(&drawn, &r->world->base, path) == VV_OK)
        some = strcmp(drawn, "false") != 0;
    free(drawn);
    free(path);
    return some;
}

/* The dataset that all volumes show; NULL: there are several, or none. */
static const char *only_shown(const vv_world *world)
{
    const char *only = NULL;
    for (size_t i = 0; i < world->volumes->n; i++) {
        const vv_volume *volume = vvi_volume_nth(world, i);
        const char *data = vvi_volume_dataset_id(world, volume);
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
    const vv_dataset *dataset = vvi_command_dataset(world, id);
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
    const vv_dataset *dataset = vvi_command_dataset(r->world, id);
    vv_status st = base_world(&before, r->world, id, job);
    if (st != VV_OK)
        return st;
    comparing c = {.now = r->world, .before = before, .out = text, .view = r->view};
    c.own = vv_dataset_is_made(dataset) ? id : before->datasets->entry[0].id;
    vvi_text_add(text, "volvis render ");
    st = vvi_command_input(text, r->world, id, job);
    vvi_text_add(text, " -o picture.png");
    vv_path_each(&r->world->base, compare, &c);
    vv_object_release(&before->base);
    *beyond_out = c.beyond;
    return st;
}

static vv_status run_command(vvi_task *task, vv_job *job)
{
    vvi_request *r = (vvi_request *)(void *)task;
    const char *id = only_shown(r->world);
    const vv_dataset *dataset;
    vvi_text text = {0};
    vv_status st = vvi_command_behind(&dataset, &id, r->world, job);
    bool beyond = st == VV_E_NOT_FOUND || (st == VV_OK && draws_measurements(r));
    st = beyond ? VV_OK : st;
    if (!beyond && st == VV_OK && (st = vvi_command_making(&text, r->world, id, job)) == VV_OK)
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

static vv_status ask_chain(vvi_client *client, int64_t id, const json_t *message, const char *form)
{
    vvi_request *r;
    vv_status st = vvi_request_new(&r, client, id, "command", run_chain_command);
    if (st != VV_OK)
        return st;
    r->add = form && strcmp(form, "pipe") == 0;
    st = vvi_request_take_text(&r->dataset, message, "dataset");
    if (st == VV_OK && !r->add && (!form || strcmp(form, "chain") != 0))
        st = vv_fail(VV_E_ARGUMENT, "'form' must be \"pipe\" or \"chain\"");
    if (st == VV_OK && !r->dataset)
        st = vv_fail(VV_E_ARGUMENT, "'form' needs a dataset");
    return vvi_request_add_quick(r, st);
}

vv_status vvi_request_command(vvi_client *client, int64_t id, const json_t *message)
{
    const bool one = json_object_get(message, "operation") != NULL;
    if (json_object_get(message, "measurement"))
        return vvi_request_command_measure(client, id, message);
    if (json_object_get(message, "form"))
        return ask_chain(client, id, message, json_string_value(json_object_get(message, "form")));
    vvi_request *r;
    vv_status st = vvi_client_fix_view(client);
    if (st == VV_OK)
        st = vvi_request_new(&r, client, id, "command", one ? run_operation_command : run_command);
    if (st != VV_OK)
        return st;
    st = one ? vvi_request_take_operation(r, message) : vvi_request_size(r, client->width, client->height);
    return vvi_request_add_quick(r, st);
}
