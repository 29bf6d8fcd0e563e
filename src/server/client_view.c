/* Which view of the World a client gets. */
#include "core/json_text.h"
#include "core/memory.h"
#include "model/context.h"
#include "server/session_impl.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char *const planes[] = {"axial", "coronal", "sagittal"};

static bool is_taken(const vvi_session *s, const char *view)
{
    for (const vvi_client *c = s->clients; c; c = c->next)
        if (strcmp(c->view, view) == 0)
            return true;
    return false;
}

static const vv_registry *registry_of(const vvi_client *client)
{
    return vv_runtime_registry(client->session->options.runtime);
}

/* The plane of a view of slices; NULL: it shows something else. */
static const char *plane_of(const vv_entry *entry, const vv_registry *registry)
{
    const vv_view *view = (const vv_view *)(const void *)entry->object;
    const char *method = ((const vv_render_choice *)(const void *)view->render)->method, *found = NULL;
    const vv_renderer *row = vv_registry_plane_renderer(registry);
    char *plane = NULL, path[96];
    if (!row || !method || strcmp(method, row->name) != 0)
        return NULL;
    snprintf(path, sizeof path, "render.%s.orientation", method);
    if (vv_path_get(&plane, entry->object, path) == VV_OK)
        for (size_t i = 0; i < sizeof planes / sizeof *planes; i++)
            found = strncmp(plane + 1, planes[i], strlen(planes[i])) == 0 ? planes[i] : found;
    free(plane);
    return found;
}

/* One that nobody looks through, of the plane that is asked for; whoever asks for none gets no plane, unless there is
 * nothing else. */
static void find_view(vvi_client *client, const vv_collection *views, const char *plane)
{
    const vv_registry *registry = registry_of(client);
    bool others = false;
    for (size_t i = 0; i < views->n; i++)
        others |= !plane_of(&views->entry[i], registry);
    for (size_t i = 0; i < views->n && !*client->view; i++) {
        const char *id = views->entry[i].id, *shown = plane_of(&views->entry[i], registry);
        const bool wanted = plane ? shown && strcmp(shown, plane) == 0 : !shown || !others;
        if (wanted && !is_taken(client->session, id) && strlen(id) < VVI_VIEW_NAME)
            memcpy(client->view, id, strlen(id) + 1);
    }
}

/* NULL: there is no memory. */
static json_t *new_view(const char *plane, const vv_registry *registry)
{
    const vv_renderer *row = vv_registry_plane_renderer(registry);
    return plane && row ? json_pack("{s:{s:s, s:{s:s}}, s:{s:b, s:b}}", "render", "method", row->name, row->name,
                                    "orientation", plane, "decorations", "sides", 1, "scale_bar", 1)
                        : json_object();
}

static vv_status add_view(vvi_client *client, const vv_collection *views, const char *plane)
{
    char name[32];
    int number = plane ? 1 : (int)views->n;
    snprintf(name, sizeof name, "%s", plane ? plane : "main");
    while (vv_collection_find(views, name))
        snprintf(name, sizeof name, "%s-%d", plane ? plane : "view", ++number);
    json_t *edits = json_pack("[{s:s, s:s, s:s, s:o}]", "op", "add", "path", "views", "id", name, "value",
                              new_view(plane, registry_of(client)));
    const vv_status st = edits ? vvi_session_edit(client->session, VVI_CAMERA, edits, false) : vv_fail_memory(256);
    json_decref(edits);
    memcpy(client->view, name, sizeof name);
    return st;
}

vv_status vvi_client_choose_view(vvi_client *client, const char *plane)
{
    vv_world *world = vv_model_snapshot(client->session->model);
    vv_status st = VV_OK;
    bool known = !plane;
    for (size_t i = 0; !known && i < sizeof planes / sizeof *planes; i++)
        if ((known = strcmp(planes[i], plane) == 0))
            client->plane = planes[i];
    if (!known)
        st = vv_fail(VV_E_FORMAT, "a plane is axial, coronal or sagittal, not '%.40s'", plane);
    else
        find_view(client, world->views, plane);
    if (st == VV_OK && !*client->view)
        st = add_view(client, world->views, plane);
    vv_object_release(&world->base);
    return st;
}

/* The properties of a World's first view that is no plane, as JSON; NULL: it has none, or there is no memory. */
static char *first_view(const vv_world *world, const vv_registry *registry)
{
    char *json = NULL;
    for (size_t i = 0; i < world->views->n && !json; i++) {
        if (plane_of(&world->views->entry[i], registry))
            continue;
        char *path = vvi_asprintf("views.%s", world->views->entry[i].id);
        if (!path || vv_path_get(&json, &world->base, path) != VV_OK)
            json = NULL;
        free(path);
    }
    return json;
}

static vv_status add_view_of(vv_object **root, const vvi_client *client, const char *like,
                             const vv_property_context *context)
{
    json_t *value = new_view(client->plane, registry_of(client));
    char *json = value ? vvi_json_encode(value, JSON_COMPACT) : NULL;
    const vv_status st = json ? vv_path_add(root, "views", client->view, like && !client->plane ? like : json, context)
                              : vv_fail_memory(64);
    free(json);
    json_decref(value);
    return st;
}

vv_status vvi_session_add_views(vv_world **world, const vvi_session *session)
{
    const vv_registry *registry = vv_runtime_registry(session->options.runtime);
    const vv_property_context context = vvi_registry_context(registry);
    char *like = first_view(*world, registry);
    vv_object *root = &(*world)->base;
    vv_status st = VV_OK;
    for (const vvi_client *c = session->clients; c && st == VV_OK; c = c->next)
        if (*c->view && !vv_collection_find(((const vv_world *)(const void *)root)->views, c->view))
            st = add_view_of(&root, c, like, &context);
    *world = (vv_world *)(void *)root;
    free(like);
    return st;
}
