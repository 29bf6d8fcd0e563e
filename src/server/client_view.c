/* Which view of the World a client gets. */
#include "core/memory.h"
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

/* The plane of a view of slices; NULL: it shows something else. */
static const char *plane_of(const vv_entry *entry)
{
    const vv_object *view = entry->object;
    char *method = NULL, *plane = NULL;
    const char *found = NULL;
    if (vv_path_get(&method, view, "render.method") == VV_OK && method && strcmp(method, "\"slice\"") == 0 &&
        vv_path_get(&plane, view, "render.slice.orientation") == VV_OK)
        for (size_t i = 0; i < sizeof planes / sizeof *planes; i++)
            found = strncmp(plane + 1, planes[i], strlen(planes[i])) == 0 ? planes[i] : found;
    free(method);
    free(plane);
    return found;
}

/* One that nobody looks through, of the plane that is asked for; whoever asks for none gets no plane, unless there is
 * nothing else. */
static void find_view(vvi_client *client, const vv_collection *views, const char *plane)
{
    bool others = false;
    for (size_t i = 0; i < views->n; i++)
        others |= !plane_of(&views->entry[i]);
    for (size_t i = 0; i < views->n && !*client->view; i++) {
        const char *id = views->entry[i].id, *shown = plane_of(&views->entry[i]);
        const bool wanted = plane ? shown && strcmp(shown, plane) == 0 : !shown || !others;
        if (wanted && !is_taken(client->session, id) && strlen(id) < VVI_VIEW_NAME)
            memcpy(client->view, id, strlen(id) + 1);
    }
}

static vv_status add_view(vvi_client *client, const vv_collection *views, const char *plane)
{
    char name[32];
    int number = plane ? 1 : (int)views->n;
    snprintf(name, sizeof name, "%s", plane ? plane : "main");
    while (vv_collection_find(views, name))
        snprintf(name, sizeof name, "%s-%d", plane ? plane : "view", ++number);
    json_t *value = plane ? json_pack("{s:{s:s, s:{s:s}}, s:{s:b, s:b}}", "render", "method", "slice", "slice",
                                      "orientation", plane, "decorations", "sides", 1, "scale_bar", 1)
                          : json_object();
    json_t *edits = json_pack("[{s:s, s:s, s:s, s:o}]", "op", "add", "path", "views", "id", name, "value", value);
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
        known = strcmp(planes[i], plane) == 0;
    if (!known)
        st = vv_fail(VV_E_FORMAT, "a plane is axial, coronal or sagittal, not '%.40s'", plane);
    else
        find_view(client, world->views, plane);
    if (st == VV_OK && !*client->view)
        st = add_view(client, world->views, plane);
    vv_object_release(&world->base);
    return st;
}
