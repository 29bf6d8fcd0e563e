/* Changes of the World: by people, by cameras that come to rest, and out of the journal. */
#include "core/memory.h"
#include "server/session_impl.h"

#include <stdlib.h>
#include <string.h>

static const char *text_of(const json_t *object, const char *key)
{
    return json_string_value(json_object_get(object, key));
}

/* The value as the property engine takes it; NULL without a value or memory. */
static char *value_of(const json_t *edit)
{
    const json_t *value = json_object_get(edit, "value");
    return value ? json_dumps(value, JSON_COMPACT | JSON_ENCODE_ANY | JSON_REAL_PRECISION(17)) : NULL;
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

/* Why a path may not be read, NULL: it may. What is not there yet is judged by the nearest folder that is: it may come
 * to be there later. */
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
    if (!given && (!real || strcmp(path, "-") == 0 || !vvi_files_inside(session, real)))
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
    if (!real || vvi_files_inside(g->session, real)) {
        free(real);
        return true;
    }
    char **more = vvi_realloc_plain(g->session->given, (g->session->n_given + 1) * sizeof *more);
    if (more) {
        g->session->given = more;
        more[g->session->n_given++] = real;
    } else {
        free(real);
    }
    g->full = !more;
    return !g->full;
}

vv_status vvi_session_give_files(vvi_session *session, const vv_world *world)
{
    giving g = {.session = session};
    vv_path_each(&world->base, give_file, &g);
    return g.full ? vv_fail_memory(sizeof(char *)) : VV_OK;
}

static vv_status check_now(vvi_session *session, const vv_world *before)
{
    vv_world *world = vv_model_snapshot(session->model);
    vv_status st = vvi_session_check_files(session, world);
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

vv_status vvi_session_edit(vvi_session *session, const char *who, const json_t *edits, bool join)
{
    vv_model *model = session->model;
    vv_status st = vv_model_begin(model, who);
    if (st != VV_OK)
        return st;
    if ((st = apply_all(session, who, edits)) != VV_OK) {
        vv_model_end(model, false);
        return st;
    }
    if ((st = vv_model_end(model, true)) == VV_OK && join)
        st = vv_model_join(model, who);
    if (st == VV_OK)
        st = vvi_journal_add(session->journal,
                             json_pack("{s:s, s:O, s:b}", "who", who, "edits", (json_t *)edits, "join", (int)join));
    return st;
}

vv_status vvi_session_undo(vvi_session *session, const char *who, bool redo)
{
    const vv_status st = redo ? vv_model_redo(session->model, who) : vv_model_undo(session->model, who);
    return st == VV_OK ? vvi_journal_add(session->journal, json_pack("{s:s}", redo ? "redo" : "undo", who)) : st;
}

vv_status vvi_session_replace(vvi_session *session, const char *who, vv_world *world)
{
    char *scene = NULL;
    vv_status st = vv_model_replace(session->model, who, world);
    if (st == VV_OK && session->journal && (st = vv_scene_print(&scene, world, NULL)) == VV_OK)
        st =
            vvi_journal_add(session->journal, json_pack("{s:s, s:o}", "who", who, "scene", json_loads(scene, 0, NULL)));
    free(scene);
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

static vv_status replay_scene(vvi_session *session, const char *who, const json_t *scene)
{
    vv_world *world = NULL;
    vv_job *job = NULL;
    char *text = json_dumps(scene, JSON_REAL_PRECISION(17));
    if (!text)
        return vv_fail_memory(1024);
    vv_status st = vv_job_new(&job, session->options.runtime, NULL, NULL);
    if (st == VV_OK)
        st = vv_scene_parse(&world, text, strlen(text), "journal", NULL, job);
    if (st == VV_OK && !*who) /* what it was begun with */
        st = vvi_session_give_files(session, world);
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
        return replay_scene(session, who, scene);
    if (!edits || !who)
        return vv_fail(VV_E_FORMAT, "a line of the journal is not an edit");
    return vvi_session_edit(session, who, edits, json_is_true(json_object_get(line, "join")));
}
