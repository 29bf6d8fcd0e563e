/* What comes into the World from files and samples, and the World as a file. */
#include "core/job.h"
#include "core/memory.h"
#include "core/text.h"
#include "io/mesh_file.h"
#include "model/context.h"
#include "model/merge.h"
#include "render/recipe.h"
#include "server/demos.h"
#include "server/request.h"

#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* Opening --------------------------------------------------------------------------------------------------------- */

static vv_status world_of_part(vv_world **out, const char *path, const char *part, vv_job *job)
{
    vv_read_options options;
    if (vvi_mesh_is_file(path, job))
        return vvi_world_for_mesh(out, path, NULL, part, job);
    vv_read_options_init(&options, sizeof options);
    options.part = part;
    return vv_world_for_file(out, path, &options, job);
}

static vv_status world_of(vv_world **out, const char *path, const char *part, vv_job *job)
{
    vvi_recipe recipe;
    if (part)
        return world_of_part(out, path, part, job);
    if (vvi_files_is_scene(path))
        return vv_scene_read(out, path, job);
    if (vvi_mesh_is_file(path, job))
        return vvi_world_for_mesh(out, path, NULL, NULL, job);
    if (vvi_recipe_is_there(path, job))
        return vvi_recipe_read(out, &recipe, path, job);
    return vv_world_for_file(out, path, NULL, job);
}

static bool is_ascii(const char *text)
{
    while (*text && !(*text & 0x80))
        text++;
    return !*text;
}

/* Ids are ASCII: a file whose name is not gets that as the title of its data. One that cannot be a title is none. */
static void add_title(vv_world **world, const vv_entry *entry, const char *path, vv_job *job)
{
    const vv_dataset *dataset = (const vv_dataset *)(const void *)entry->object;
    if (!dataset->path || strcmp(dataset->path, path) != 0) /* a scene says itself what its data are called */
        return;
    const char *name = strrchr(path, '/') + 1;
    const vv_property_context context = vvi_registry_context(vvi_job_registry(job));
    vvi_text quoted = {0};
    char *where = vvi_asprintf("datasets.%s.title", entry->id), *stem = vvi_strdup(name);
    if (stem)
        stem[strcspn(stem, ".")] = 0;
    vvi_text_json(&quoted, stem ? stem : "");
    char *title = vvi_text_take(&quoted);
    vv_object *root = &(*world)->base;
    if (where && stem && title && vv_path_set(&root, where, title, &context) == VV_OK)
        *world = (vv_world *)(void *)root;
    free(where);
    free(stem);
    free(title);
}

/* What the log says on the machine of the server alone. */
static vv_status note_schema(vvi_request *r, const vv_world *made)
{
    char newer[128];
    if (!vvi_schema_is_newer(newer, sizeof newer, made->schema))
        return VV_OK;
    r->note = vvi_asprintf("%s: %s", strrchr(r->path, '/') + 1, newer);
    return r->note ? VV_OK : vv_fail_memory(sizeof newer);
}

static vv_status run_open(vvi_task *task, vv_job *job)
{
    vvi_request *r = (vvi_request *)(void *)task;
    vv_world *made = NULL;
    vv_status st = world_of(&made, r->path, r->name, job);
    if (st == VV_OK && !is_ascii(strrchr(r->path, '/')) && made->datasets->n == 1)
        add_title(&made, &made->datasets->entry[0], r->path, job);
    if (st == VV_OK) /* before any of them is opened */
        st = vvi_session_check_files(r->session, made);
    if (st == VV_OK)
        st = note_schema(r, made);
    if (st == VV_OK) {
        vv_object_release(&r->world->base);
        r->world = made;
        made = NULL;
    }
    if (made)
        vv_object_release(&made->base);
    return st;
}

/* What was opened beside what the World has by now: others have gone on while it was read. */
static vv_status add_to_world(vvi_request *r)
{
    vv_world *world = vv_model_snapshot(r->session->model);
    vv_status st = VV_OK;
    if (world->volumes->n > 0 &&
        (st = vvi_world_merge(&world, r->world, vv_runtime_registry(r->session->options.runtime))) == VV_OK) {
        vv_object_release(&r->world->base);
        r->world = (vv_world *)vv_object_retain(&world->base);
    }
    vv_object_release(&world->base);
    return st;
}

static void done_open(vvi_task *task, vv_status st)
{
    vvi_request *r = (vvi_request *)(void *)task;
    vvi_session_note_end(r->session, r->asked, st);
    if (st == VV_OK) {
        r->session->opener = r->serial;
        free(r->session->warnings);
        r->session->warnings = NULL;
    }
    if (st == VV_OK && r->add)
        st = add_to_world(r);
    if (st == VV_OK)
        st = vvi_session_check_files(r->session, r->world);
    if (st == VV_OK)
        st = vvi_session_add_views(&r->world, r->session);
    if (st == VV_OK)
        st = vvi_session_replace(r->session, r->view, r->world);
    if (st == VV_OK && !r->add)
        vvi_session_shows(r->session, r->path);
    vvi_client *client = vvi_session_find(r->session, r->serial);
    if (st == VV_OK && r->note && client)
        vvi_client_notice(client, "warning", r->note);
    vvi_request_done_slowly(task, st);
}

vv_status vvi_request_open(vvi_client *client, int64_t id, const json_t *message)
{
    const char *path = json_string_value(json_object_get(message, "path"));
    vvi_request *r;
    if (!path)
        return vv_fail(VV_E_ARGUMENT, "'open' needs a path");
    const vv_status st = vvi_request_new(&r, client, id, "open", run_open);
    if (st != VV_OK)
        return st;
    r->add = json_is_true(json_object_get(message, "add")) && r->world->volumes->n > 0;
    r->task.done = done_open;
    r->changes = r->task.stays = true;
    return vvi_request_add_slow(r, vvi_files_resolve_part(&r->path, &r->name, client->session, path));
}

enum { SAMPLE_SIDE = 128, SAMPLE_BYTES = 4 * SAMPLE_SIDE * SAMPLE_SIDE * SAMPLE_SIDE };

static vv_status run_sample(vvi_task *task, vv_job *job)
{
    vvi_request *r = (vvi_request *)(void *)task;
    vv_field *field = NULL;
    vv_world *made = NULL;
    const bool is_there = access(r->path, R_OK) == 0; /* and like any other: a scene may show it */
    vv_status st = is_there ? VV_OK : vvi_demo_make(&field, vvi_demo_find(r->name), SAMPLE_SIDE, job);
    if (st == VV_OK && !is_there)
        st = vv_field_write(r->path, (const vv_field *const *)&field, 1, NULL, job);
    vv_field_release(field);
    if (st == VV_OK)
        st = vv_world_for_file(&made, r->path, NULL, job);
    if (st == VV_OK) {
        vv_object_release(&r->world->base);
        r->world = made;
    }
    return st;
}

vv_status vvi_request_sample(vvi_client *client, int64_t id, const json_t *message)
{
    const char *name = json_string_value(json_object_get(message, "name"));
    vvi_request *r;
    if (!vvi_demo_find(name))
        return vv_fail(VV_E_NOT_FOUND, "there is no sample '%.40s'", name ? name : "");
    if (!client->session->uploads)
        return vv_fail(VV_E_UNSUPPORTED, "this server keeps no files, and so has no samples");
    char *folder = NULL;
    vv_status st = vvi_request_new(&r, client, id, "sample", run_sample);
    if (st != VV_OK)
        return st;
    r->task.done = done_open;
    r->changes = r->task.stays = true;
    r->name = vvi_strdup(name);
    st = vvi_files_own_folder(&folder, client->session, "samples");
    r->path = st == VV_OK ? vvi_asprintf("%s/%s.nrrd", folder, name) : NULL;
    free(folder);
    if (r->path && access(r->path, R_OK) != 0)
        st = vvi_session_make_room(client->session, SAMPLE_BYTES);
    return vvi_request_add_slow(r, st == VV_OK && !(r->name && r->path) ? vv_fail_memory(256) : st);
}

/* Saving ---------------------------------------------------------------------------------------------------------- */

static vv_status run_save(vvi_task *task, vv_job *job)
{
    vvi_request *r = (vvi_request *)(void *)task;
    vvi_disk_share share;
    vv_status st = vvi_request_keep_existing(r, job);
    if (st == VV_OK && (st = vvi_disk_share_begin(&share, r->session, r->path, job)) == VV_OK)
        st = vvi_disk_share_end(&share, vv_scene_write(r->path, r->world, job), job);
    if (st != VV_OK)
        return vvi_request_note_exists(r, st);
    vvi_files_keep(r->session, r->world);
    vvi_request_tell_path(r);
    return VV_OK;
}

static void done_save(vvi_task *task, vv_status st)
{
    vvi_request *r = (vvi_request *)(void *)task;
    if (st == VV_OK)
        vvi_session_shows(r->session, r->path);
    vvi_request_answer(r, st);
}

vv_status vvi_request_save(vvi_client *client, int64_t id, const json_t *message)
{
    const char *path = json_string_value(json_object_get(message, "path"));
    vvi_request *r;
    if (!path || !*path)
        return vv_fail(VV_E_ARGUMENT, "'save' needs a path");
    vv_status st = vvi_session_fix_views(client->session);
    if (st != VV_OK || (st = vvi_request_new(&r, client, id, "save", run_save)) != VV_OK)
        return st;
    char *full = vvi_files_is_scene(path) ? vvi_strdup(path) : vvi_asprintf("%s.vv.json", path);
    st = full ? vvi_request_take_place(r, path, full) : vv_fail_memory(strlen(path));
    free(full);
    const char *saved = client->session->saved;
    r->task.done = done_save;
    r->task.alone = true; /* which of two is the first to have a name is settled */
    r->task.stays = true;
    r->replace = json_is_true(json_object_get(message, "replace")) || (st == VV_OK && saved && !strcmp(saved, r->path));
    return vvi_request_add_quick(r, st);
}
