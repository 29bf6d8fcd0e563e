/* What a commit means for those who look, and the World as it is told. */
#include "core/memory.h"
#include "model/changes.h"
#include "server/session_impl.h"

#include <stdlib.h>
#include <string.h>

#define WORLD_PAUSE (INT64_C(30) * 1000000) /* between two Worlds that a client is told, at least */
#define WORLD_BYTES 8e6                     /* a second, that all Worlds which are told may take */
enum { WORLD_SMALL = 16 << 10 };            /* bytes of one that is always told as a whole */

static bool is_own_view(const vvi_client *client, const char *path)
{
    const size_t n = strlen(client->view);
    return strncmp(path, "views.", 6) == 0 && strncmp(path + 6, client->view, n) == 0 &&
           (!path[6 + n] || path[6 + n] == '.');
}

/* Whether the camera of a client may be another one. */
static bool concerns(const vvi_client *client, const vv_commit *commit)
{
    for (size_t i = 0; i < commit->n_paths; i++) {
        const char *path = commit->paths[i];
        if (!*path || strcmp(path, "views") == 0 || is_own_view(client, path))
            return true;
    }
    return false;
}

/* What planes alone are made of. */
static bool is_of_planes(const char *path)
{
    const char *volume = strncmp(path, "volumes.", 8) == 0 ? strchr(path + 8, '.') : NULL;
    return strcmp(path, "cross_hair") == 0 || (volume && strncmp(volume, ".slices", 7) == 0);
}

static bool shows_measurements(const vvi_client *client, const vv_world *world)
{
    const vv_view *view = vvi_view_named(world, client->view);
    return !view || ((const vv_decorations *)(const void *)view->decorations)->measurements;
}

static bool shows_planes(const vvi_client *client, const vv_world *world)
{
    const vv_view *view = vvi_view_named(world, client->view);
    return !view || ((const vv_decorations *)(const void *)view->decorations)->cross_hair ||
           vvi_camera_is_plane(world, client->view, vv_runtime_registry(client->session->options.runtime));
}

/* Whether a client's picture may change: other people's views are not in it, what was measured where its view wants it,
 * and what planes are made of is not in pictures of others. */
static bool is_seen(const vvi_client *client, const vv_commit *commit, const vv_world *world)
{
    for (size_t i = 0; i < commit->n_paths; i++) {
        const char *path = commit->paths[i];
        const bool elsewhere = strncmp(path, "views.", 6) == 0 ||
                               (strncmp(path, "measurements", 12) == 0 && !shows_measurements(client, world)) ||
                               (is_of_planes(path) && !shows_planes(client, world));
        if (!elsewhere || is_own_view(client, path))
            return true;
    }
    return false;
}

/* JSON without brackets: several are joined. NULL: there is no memory, or it would be long. */
static char *paths_json(const vv_commit *commit)
{
    vvi_result r = {.compact = true};
    vvi_result_open(&r, NULL, '[');
    for (size_t i = 0; i < commit->n_paths; i++)
        vvi_result_string(&r, NULL, commit->paths[i]);
    vvi_result_close(&r, ']');
    char *text = vvi_text_take(&r.text), *end = text ? strrchr(text, ']') : NULL;
    if (!end || end - text > VVI_CHANGE_BYTES) {
        free(text);
        return NULL;
    }
    *end = 0;
    memmove(text, text + 1, strlen(text));
    return text;
}

void vvi_session_note_commit(void *user, const vv_commit *commit, const vv_world *world)
{
    vvi_session *s = user;
    const bool camera = strcmp(commit->who, VVI_CAMERA) == 0;
    const int64_t now = vvi_now();
    s->commit = commit->number;
    s->scene = camera ? s->scene : commit->number;
    free(s->who);
    s->who = vvi_strdup(commit->who);
    char **paths = &s->paths[s->n_changes++ % VVI_CHANGES_KEPT];
    free(*paths);
    *paths = paths_json(commit);
    for (vvi_client *c = s->clients; c; c = c->next) {
        if (camera && !concerns(c, commit)) {
            c->tells_cameras = true;
            continue;
        }
        c->tells_world = true;
        if (camera)
            continue;
        if (concerns(c, commit)) {
            vvi_client_stand_anew(c);
        }
        if (is_seen(c, commit, world))
            vvi_client_want(c, true, now);
    }
}

const char *vvi_session_told(vvi_session *s)
{
    if (s->told && s->told_commit == s->commit)
        return s->told;
    vv_world *world = vv_model_snapshot(s->model);
    free(s->told);
    s->told = NULL;
    s->told_commit = s->commit;
    if (vv_scene_print(&s->told, world, NULL) != VV_OK)
        s->told = NULL;
    vv_object_release(&world->base);
    s->told_bytes = s->told ? strlen(s->told) : 0;
    return s->told;
}

void vvi_told_changes_free(vvi_told_changes *changes)
{
    if (changes->from)
        vv_object_release(&changes->from->base);
    if (changes->to)
        vv_object_release(&changes->to->base);
    free(changes->text);
    *changes = (vvi_told_changes){.text = NULL};
}

const char *vvi_session_changes(vvi_session *s, const vv_world *known, const vv_world *world)
{
    vvi_told_changes *c = &s->changes;
    if (s->told_bytes <= WORLD_SMALL)
        return NULL;
    if (c->from == known && c->to == world)
        return c->text;
    vvi_told_changes_free(c);
    c->from = (vv_world *)(void *)vv_object_retain(&known->base);
    c->to = (vv_world *)(void *)vv_object_retain(&world->base);
    if (vvi_world_changes(&c->text, known, world, s->told_bytes / 2) != VV_OK)
        c->text = NULL;
    return c->text;
}

int64_t vvi_session_world_rest(const vvi_session *s, size_t bytes)
{
    int n = 0;
    for (const vvi_client *c = s->clients; c; c = c->next)
        n++;
    const int64_t all = (int64_t)((double)bytes * n / WORLD_BYTES * 1e9);
    return all > WORLD_PAUSE ? all : WORLD_PAUSE;
}
