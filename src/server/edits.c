/* Changes of the World: by people, by cameras that come to rest, and out of the journal. */
#include "core/allowed_places.h"
#include "core/json_text.h"
#include "core/memory.h"
#include "core/property_size.h"
#include "core/units.h"
#include "model/classes.h"
#include "model/history.h"
#include "server/session_impl.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

static const char *text_of(const json_t *object, const char *key)
{
    return json_string_value(json_object_get(object, key));
}

/* The value as the property engine takes it; NULL without a value or memory. */
static char *value_of(const json_t *edit)
{
    const json_t *value = json_object_get(edit, "value");
    return value ? vvi_json_encode(value, JSON_COMPACT | JSON_ENCODE_ANY | JSON_REAL_PRECISION(17)) : NULL;
}

static vv_status apply(vv_model *model, const char *who, const json_t *edit)
{
    const char *op = text_of(edit, "op"), *path = text_of(edit, "path");
    char *value = value_of(edit);
    vv_status st;
    if (!op || !path)
        st = vv_fail(VV_E_ARGUMENT, "an edit needs op and path");
    else if (strcmp(op, "set") == 0 && value)
        st = vv_model_set(model, who, path, value);
    else if (strcmp(op, "unset") == 0)
        st = vv_model_unset(model, who, path);
    else if (strcmp(op, "add") == 0)
        st = vv_model_add(model, who, path, text_of(edit, "id"), value);
    else if (strcmp(op, "remove") == 0)
        st = vv_model_remove(model, who, path);
    else
        st = vv_fail(VV_E_ARGUMENT, "an edit is set (with a value), unset, add or remove, not '%.40s'", op);
    free(value);
    return st;
}

/* Files ----------------------------------------------------------------------------------------------------------- */

typedef struct checking {
    const vvi_session *session;
    vv_status status;
} checking;

static bool leads_back(const char *path)
{
    for (const char *at = path; (at = strstr(at, "..")) != NULL; at += 2)
        if ((at == path || at[-1] == '/') && (at[2] == '/' || !at[2]))
            return true;
    return false;
}

/* Why a path may not be read, NULL: it may. What is not there yet is judged by the nearest folder that is: it may come
 * to be there later, and then `..` in it may lead anywhere. */
static const char *objection(const vvi_session *session, const char *path)
{
    char *part = *path == '/' ? vvi_strdup(path) : vvi_asprintf("./%s", path);
    char *real = part ? realpath(part, NULL) : NULL;
    for (char *slash; part && !real && (slash = strrchr(part, '/')) != NULL;) {
        *slash = 0;
        real = realpath(*part ? part : "/", NULL);
    }
    bool given = false;
    for (size_t i = 0; real && i < session->n_given; i++)
        given |= strcmp(real, session->given[i]) == 0;
    const char *why = NULL;
    struct stat info;
    if (!given && leads_back(path) && stat(path, &info) != 0)
        why = "does not exist, and its '..' may lead outside";
    else if (!given && (!real || strcmp(path, "-") == 0 || !vvi_files_inside(session, real)))
        why = "is outside the folder that this server may read";
    else if (!given && !vvi_files_plain(real)) /* of a given one the command line has decided */
        why = "is neither a file nor a folder with files";
    free(real);
    free(part);
    return why;
}

static bool check_file(void *user, const char *path, const vv_property *row, const vv_object *owner)
{
    checking *c = user;
    const char *file;
    if (row->kind != VV_KIND_PATH)
        return true;
    memcpy(&file, (const char *)owner + row->offset, sizeof file);
    const char *why = file && *file ? objection(c->session, file) : NULL;
    if (why)
        c->status = vv_fail(VV_E_ARGUMENT, "%s: '%.200s' %s", path, file, why);
    return c->status == VV_OK;
}

vv_status vvi_session_check_files(const vvi_session *session, const vv_world *world)
{
    checking c = {.session = session};
    vv_path_each(&world->base, check_file, &c);
    return c.status;
}

typedef struct giving {
    vvi_session *session;
    bool full;
} giving;

static bool give_file(void *user, const char *path, const vv_property *row, const vv_object *owner)
{
    giving *g = user;
    const char *file;
    (void)path;
    if (row->kind != VV_KIND_PATH)
        return true;
    memcpy(&file, (const char *)owner + row->offset, sizeof file);
    char *real = file ? realpath(file, NULL) : NULL;
    const bool font =
        owner->cls == &vvi_decorations_class; /* below the root they are read only where they were given */
    if (!real || (!font && vvi_files_inside(g->session, real))) {
        free(real);
        return true;
    }
    char **more = vvi_realloc_plain(g->session->given, (g->session->n_given + 1) * sizeof *more);
    if (more) {
        g->session->given = more;
        more[g->session->n_given++] = real;
        g->full = vvi_runtime_give(g->session->options.runtime, real) != VV_OK;
    } else {
        free(real);
        g->full = true;
    }
    return !g->full;
}

vv_status vvi_session_give_files(vvi_session *session, const vv_world *world)
{
    giving g = {.session = session};
    vv_path_each(&world->base, give_file, &g);
    return g.full ? vv_fail_memory(sizeof(char *)) : VV_OK;
}

vv_status vvi_session_check_size(const vv_world *world)
{
    char *text = NULL, size[32], most[32];
    if (vvi_object_text_most(&world->base) <= VVI_WORLD_MOST)
        return VV_OK;
    const vv_status st = vv_scene_print(&text, world, NULL);
    const size_t n = st == VV_OK ? strlen(text) : 0;
    free(text);
    if (st != VV_OK || n <= VVI_WORLD_MOST)
        return st;
    vvi_print_bytes(size, n);
    vvi_print_bytes(most, VVI_WORLD_MOST);
    return vv_fail(VV_E_LIMIT,
                   "the World would be %s of text, which is told to everybody who looks at it: at most %s "
                   "are allowed; make its texts and tables shorter",
                   size, most);
}

static vv_status check_now(vvi_session *session, const vv_world *before)
{
    vv_world *world = vv_model_snapshot(session->model);
    vv_status st = vvi_session_check_files(session, world);
    if (st == VV_OK)
        st = vvi_session_check_size(world);
    if (st == VV_OK)
        st = vvi_session_check_names(world, before);
    vv_object_release(&world->base);
    return st;
}

/* Commits --------------------------------------------------------------------------------------------------------- */

/* All of them, or none. */
static vv_status apply_all(vvi_session *session, const char *who, const json_t *edits)
{
    vv_model *model = session->model;
    vv_world *before = vv_model_snapshot(model);
    vv_status st = VV_OK;
    for (size_t i = 0; i < json_array_size(edits) && st == VV_OK; i++)
        st = apply(model, who, json_array_get(edits, i));
    if (st == VV_OK && strcmp(who, VVI_CAMERA) != 0) /* those name no files */
        st = check_now(session, before);
    vv_object_release(&before->base);
    return st;
}

/* Once: the oldest go one by one from here on. */
static void tell_forgotten(vvi_session *session)
{
    uint64_t bytes;
    char most[32], text[160];
    if (session->told_forgotten || vvi_model_forgotten(session->model, &bytes) == 0)
        return;
    session->told_forgotten = true;
    vvi_print_bytes(most, bytes);
    snprintf(text, sizeof text,
             "The oldest changes can no longer be undone: %s of them are kept (--limit undo_bytes=N keeps more).",
             most);
    for (vvi_client *c = session->clients; c; c = c->next)
        if (c->greeted)
            vvi_client_notice(c, "info", text);
}

vv_status vvi_session_edit(vvi_session *session, const char *who, const json_t *edits, bool join)
{
    vv_model *model = session->model;
    vv_status st = vvi_session_keep_begin(session);
    if (st != VV_OK && strcmp(who, VVI_CAMERA) != 0)
        return st;
    if ((st = vv_model_begin(model, who)) != VV_OK)
        return st;
    if ((st = apply_all(session, who, edits)) == VV_OK)
        st = vvi_session_keep(session, who,
                              json_pack("{s:s, s:O, s:b}", "who", who, "edits", (json_t *)edits, "join", (int)join));
    if (st != VV_OK) {
        vv_model_end(model, false);
        return st;
    }
    if ((st = vv_model_end(model, true)) != VV_OK)
        vvi_journal_take_back(session->journal);
    if (st == VV_OK && join)
        st = vv_model_join(model, who);
    tell_forgotten(session);
    return st;
}

/* What was taken out comes back beside what has come meanwhile: together they may be too large. */
static vv_status go_back(vvi_session *session, const char *who, bool redo)
{
    vv_status st = redo ? vv_model_redo(session->model, who) : vv_model_undo(session->model, who);
    if (st != VV_OK)
        return st;
    vv_world *world = vv_model_snapshot(session->model);
    if ((st = vvi_session_check_size(world)) != VV_OK) {
        vvi_error_copy why;
        vvi_error_take(&why);
        if (redo)
            vv_model_undo(session->model, who);
        else
            vv_model_redo(session->model, who);
        vvi_error_put(&why);
    }
    vv_object_release(&world->base);
    return st;
}

/* What the lines do not have cannot be taken back by one: there the World that comes of it is kept. */
static vv_status undo_to_world(vvi_session *session, const char *who, bool redo)
{
    vv_status st = go_back(session, who, redo);
    if (st != VV_OK)
        return st;
    vv_world *world = vv_model_snapshot(session->model);
    if ((st = vvi_session_keep_world(session, who, world)) != VV_OK) {
        vvi_error_copy why;
        vvi_error_take(&why);
        go_back(session, who, !redo);
        vvi_error_put(&why);
    }
    vv_object_release(&world->base);
    return st;
}

vv_status vvi_session_undo(vvi_session *session, const char *who, bool redo)
{
    vv_status st = vvi_session_keep_begin(session);
    if (st != VV_OK)
        return st;
    if (vvi_journal_is_cut(session->journal))
        return undo_to_world(session, who, redo);
    if ((st = vvi_session_keep(session, who, json_pack("{s:s}", redo ? "redo" : "undo", who))) == VV_OK &&
        (st = go_back(session, who, redo)) != VV_OK)
        vvi_journal_take_back(session->journal);
    return st;
}

vv_status vvi_session_replace(vvi_session *session, const char *who, vv_world *world)
{
    vv_status st = vvi_session_check_size(world);
    if (st == VV_OK)
        st = vvi_session_keep_begin(session);
    if (st == VV_OK && (st = vvi_session_keep_world(session, who, world)) == VV_OK &&
        (st = vv_model_replace(session->model, who, world)) != VV_OK)
        vvi_journal_take_back(session->journal);
    return st;
}

/* The views of a World without what they looked at. */
static vv_status keep_views(vv_object **root, const vv_world *from)
{
    vv_status st = vv_path_copy(root, &from->base, "views", NULL);
    for (size_t i = 0; i < from->views->n && st == VV_OK; i++) {
        char *path = vvi_asprintf("views.%s.camera", from->views->entry[i].id);
        st = path ? vv_path_unset(root, path, NULL) : vv_fail_memory(64);
        free(path);
    }
    return st;
}

vv_status vvi_session_empty(vvi_session *session, const char *who)
{
    vv_world *old = vv_model_snapshot(session->model);
    vv_object *empty = NULL;
    vv_status st = vv_object_new(&empty, &vv_world_class, NULL);
    if (st == VV_OK)
        st = keep_views(&empty, old);
    if (st == VV_OK)
        st = vvi_session_replace(session, who, (vv_world *)(void *)empty);
    vv_object_release(empty);
    vv_object_release(&old->base);
    return st;
}

/* Real paths that a World which takes the place of lines may name. */
static vv_status take_given(vvi_session *session, const json_t *given)
{
    size_t i;
    json_t *path;
    json_array_foreach(given, i, path)
    {
        char *copy = json_is_string(path) ? vvi_strdup(json_string_value(path)) : NULL;
        char **more = copy ? vvi_realloc_plain(session->given, (session->n_given + 1) * sizeof *more) : NULL;
        if (!more) {
            free(copy);
            return vv_fail_memory(256);
        }
        session->given = more;
        more[session->n_given++] = copy;
        const vv_status st = vvi_runtime_give(session->options.runtime, copy);
        if (st != VV_OK)
            return st;
    }
    return VV_OK;
}

static vv_status replay_scene(vvi_session *session, const char *who, const json_t *scene, const json_t *given)
{
    vv_world *world = NULL;
    vv_job *job = NULL;
    char *text = vvi_json_encode(scene, JSON_ENCODE_ANY | JSON_REAL_PRECISION(17));
    if (!text)
        return vv_fail_memory(1024);
    vv_status st = vv_job_new(&job, session->options.runtime, NULL, NULL);
    if (st == VV_OK)
        st = vv_scene_parse(&world, text, strlen(text), "journal", NULL, job);
    if (st == VV_OK && given)
        st = take_given(session, given);
    else if (st == VV_OK && !*who) /* what it was begun with */
        st = vvi_session_give_files(session, world);
    if (st == VV_OK)
        st = vvi_session_check_files(session, world);
    if (st == VV_OK)
        st = vv_model_replace(session->model, who, world);
    if (world)
        vv_object_release(&world->base);
    vv_job_release(job);
    free(text);
    return st;
}

vv_status vvi_session_replay(vvi_session *session, const json_t *line)
{
    const char *undo = text_of(line, "undo"), *redo = text_of(line, "redo"), *who = text_of(line, "who");
    const json_t *scene = json_object_get(line, "scene"), *edits = json_object_get(line, "edits");
    if (undo)
        return vv_model_undo(session->model, undo);
    if (redo)
        return vv_model_redo(session->model, redo);
    if (scene && who)
        return replay_scene(session, who, scene, json_object_get(line, "given"));
    if (!edits || !who)
        return vv_fail(VV_E_FORMAT, "a line of the journal is not an edit");
    return vvi_session_edit(session, who, edits, json_is_true(json_object_get(line, "join")));
}
