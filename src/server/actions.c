/* What is asked for by name. */
#include "core/json_text.h"
#include "core/memory.h"
#include "manipulate/directions.h"
#include "server/session_impl.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* The whole scene, seen from there: the camera's own place is left to be worked out. */
static void look_from(vvi_client *client, double azimuth, double elevation, int64_t now)
{
    const vvi_pose *pose = &client->stand.pose;
    char *path = vvi_asprintf("views.%s.camera", client->view);
    json_t *camera = json_pack("{s:f, s:f}", "azimuth", azimuth, "elevation", elevation);
    if (pose->parallel)
        vvi_json_put(&camera, "projection", json_string("parallel"));
    json_t *edits = json_pack("[{s:s, s:s, s:o}]", "op", "set", "path", path ? path : "", "value", camera);
    if ((edits ? VV_OK : vv_fail_memory(256)) != VV_OK ||
        vvi_session_edit(client->session, VVI_CAMERA, edits, true) != VV_OK)
        vvi_client_notice(client, "error", vv_error_last()->message);
    vvi_client_stand_anew(client);
    client->moved = client->event = now;
    vvi_client_want(client, true, now);
    json_decref(edits);
    free(path);
}

/* What stands at the pivot keeps its size. */
static void change_projection(vvi_client *client, int64_t now)
{
    vvi_slot *slot = &vvi_input_device(client->input)->slot[0];
    vvi_pose *p = &slot->pose;
    const double extent = vvi_pose_extent(p);
    if (p->parallel)
        p->eye = vvi_sub(p->pivot, vvi_scaled(vvi_pose_forward(p), extent / (2 * tan(p->fov / 2))));
    p->parallel = !p->parallel;
    p->height = extent;
    slot->changes++;
    vvi_client_moved(client, now);
}

static void go_back(vvi_client *client, int by, int64_t now)
{
    vvi_slot *slot = &vvi_input_device(client->input)->slot[0];
    if (!vvi_poses_step(&slot->pose, &client->poses, by)) {
        vvi_client_notice(client, "info",
                          by < 0 ? "there is no view before this one" : "there is no view after this one");
        return;
    }
    slot->changes++;
    vvi_client_moved(client, now);
}

static void take_back(vvi_client *client, bool redo)
{
    if (client->session->options.read_only)
        vvi_client_notice(client, "warning", "this World can only be looked at");
    else if (vvi_session_undo(client->session, client->view, redo) != VV_OK)
        vvi_client_notice(client, "info", vv_error_last()->message);
}

bool vvi_client_action(vvi_client *client, const char *name, int64_t now)
{
    double angles[2];
    const vvi_direction *direction = vvi_direction_find(name);
    if (direction) {
        look_from(client, vvi_direction_azimuth(direction, client->stand.anatomical), direction->elevation, now);
        return true;
    }
    if (strcmp(name, "fit") == 0 && client->has_stand) {
        client->stand.pose = vvi_input_device(client->input)->slot[0].pose;
        vvi_camera_angles(angles, &client->stand);
        look_from(client, angles[0], angles[1], now);
    } else if (strcmp(name, "projection") == 0 && client->has_stand) {
        change_projection(client, now);
    } else if ((strcmp(name, "view-back") == 0 || strcmp(name, "view-forward") == 0) && client->has_stand) {
        go_back(client, strcmp(name, "view-back") == 0 ? -1 : 1, now);
    } else if (strcmp(name, "undo") == 0 || strcmp(name, "redo") == 0) {
        take_back(client, *name == 'r');
    } else {
        return strcmp(name, "fit") == 0 || strcmp(name, "projection") == 0 || strncmp(name, "view-", 5) == 0;
    }
    return true;
}
