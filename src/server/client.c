/* One who looks: coming and going, and the frames of its view. */
#include "core/json_text.h"
#include "core/memory.h"
#include "server/session_impl.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <volvis/image.h>

#define FRAME_SECONDS 0.033
#define STUCK_SECONDS 25

/* Coming and going ------------------------------------------------------------------------------------------------ */

/* Where the picture of somebody who has left is still worked at, a newcomer would wait for its end. */
static int free_slot(const vvi_session *s)
{
    for (int i = 0; i < VVI_PAINTER_VIEWS; i++)
        if (!s->slots[i] && vvi_painter_is_free(s->painter, i))
            return i;
    return -1;
}

vv_status vvi_client_take_place(vvi_client *client)
{
    vvi_session *s = client->session;
    const int n = vvi_session_looking(s), slot = free_slot(s);
    if (client->slot >= 0)
        return VV_OK;
    if (slot < 0 || n >= s->options.clients_most)
        return vv_fail(VV_E_LIMIT, "%d people already look at this World; try again when one has left", n);
    s->slots[slot] = true;
    client->slot = slot;
    return VV_OK;
}

vv_status vvi_client_join(vvi_client **out, vvi_session *session, void *user)
{
    *out = NULL;
    vvi_client *c = vvi_calloc(1, sizeof *c);
    if (!c)
        return vv_fail_memory(sizeof *c);
    *c = (vvi_client){.session = session, .user = user, .slot = -1, .serial = ++session->serials};
    c->width = 800;
    c->height = 600;
    vvi_pace_init(&c->pace, FRAME_SECONDS);
    c->input = vvi_input_new();
    if (!c->input) {
        free(c);
        return vv_fail_memory(1);
    }
    vvi_recording_note(session->recording, vvi_now(), c->serial, "joins");
    c->next = session->clients;
    session->clients = c;
    *out = c;
    return VV_OK;
}

vvi_actor vvi_client_actor(const vvi_client *client)
{
    return (vvi_actor){client->address, client->serial};
}

void vvi_client_comes_from(vvi_client *client, const char *address)
{
    snprintf(client->address, sizeof client->address, "%s", address);
    vvi_audit_note(client->session->audit, vvi_client_actor(client), "comes", NULL, false);
}

void vvi_client_leave(vvi_client *client)
{
    vvi_session *s = client->session;
    vvi_client **at = &s->clients;
    vvi_recording_note(s->recording, vvi_now(), client->serial, "leaves");
    vvi_audit_note(s->audit, vvi_client_actor(client), "leaves", NULL, false);
    vvi_client_save_camera(client);
    vvi_client_drop_shape(client);
    vvi_client_drop_preview(client);
    vvi_client_drop_jobs(client);
    vvi_made_files_leave(s, client->serial);
    while (*at != client)
        at = &(*at)->next;
    *at = client->next;
    if (client->slot >= 0) {
        s->slots[client->slot] = false;
        vvi_painter_forget(s->painter, client->slot);
    }
    vvi_text_queue_clear(&client->lines);
    vvi_painted_free(&client->sent);
    vvi_painted_free(&client->waiting);
    vvi_input_free(client->input);
    vvi_poses_free(&client->poses);
    free(client->again.paths);
    if (client->known)
        vv_object_release(&client->known->base);
    const bool looked = client->greeted;
    free(client);
    if (looked)
        vvi_session_tell_number(s);
}

bool vvi_client_looks(const vvi_client *client)
{
    return client->greeted;
}

void *vvi_client_user(const vvi_client *client)
{
    return client->user;
}

/* Frames ---------------------------------------------------------------------------------------------------------- */

bool vvi_client_is_final(const vvi_client *client, const vvi_painted *painted)
{
    return painted->final && !painted->reduced && painted->number == client->wishes;
}

void vvi_client_want(vvi_client *client, bool coarse, int64_t now)
{
    vvi_session *s = client->session;
    client->wishes++;
    client->tells_outdated |= client->told_final || client->told_failed;
    client->told_final = client->told_failed = false;
    if (client->frames != VVI_FRAMES_ALL && client->moving && client->turning) {
        vvi_painter_rest(s->painter, client->slot); /* what rests is not looked at now, and is wanted again at rest */
        return;
    }
    client->wants = true;
    client->wants_coarse |= coarse;
    if (!client->greeted || client->box.waiting)
        return; /* nobody would see it before the one that waits */
    vv_world *world = vv_model_snapshot(s->model);
    vvi_wish wish = {.world = world,
                     .commit = s->commit,
                     .scene = s->scene,
                     .number = client->wishes,
                     .has_pose = client->has_stand,
                     .pose = vvi_input_device(client->input)->slot[0].pose,
                     .width = client->width,
                     .height = client->height,
                     .moving = client->moving,
                     .coarse = client->wants_coarse,
                     .unseen = client->frames == VVI_FRAMES_NONE,
                     .event = client->event};
    memcpy(wish.view, client->view, sizeof wish.view);
    wish.plane = vvi_camera_is_plane(world, client->view, vv_runtime_registry(s->options.runtime));
    wish.moving |= wish.plane;
    wish.bytes_most = client->wants_whole ? 0 : vvi_pace_room(&client->pace);
    vvi_pace_size(wish.frame_size, &client->pace, client->width, client->height);
    if (world->volumes->n > 0 || world->views->n > 0)
        vvi_painter_want(s->painter, client->slot, &wish);
    vv_object_release(&world->base);
    client->wants = client->wants_coarse = client->wants_whole = false;
    (void)now;
}

void vvi_client_moved(vvi_client *client, int64_t now)
{
    client->changes = vvi_input_device(client->input)->slot[0].changes;
    client->moved = client->event = now;
    client->moving = client->turning = client->unsaved = client->tells_pose = true;
    client->wants_whole = false;
    vvi_client_want(client, false, now);
}

vv_status vvi_client_save_camera(vvi_client *client)
{
    if (!client->unsaved || !client->has_stand)
        return VV_OK;
    client->unsaved = false;
    char path[3][VVI_VIEW_NAME + 32];
    char *camera = vvi_camera_json(&vvi_input_device(client->input)->slot[0].pose, client->width, client->height);
    json_t *value = camera ? vvi_json_of_own(camera) : NULL;
    free(camera);
    snprintf(path[0], sizeof path[0], "views.%s.width", client->view);
    snprintf(path[1], sizeof path[1], "views.%s.height", client->view);
    snprintf(path[2], sizeof path[2], "views.%s.camera", client->view);
    json_t *edits = json_pack("[{s:s, s:s, s:i}, {s:s, s:s, s:i}, {s:s, s:s, s:o}]", "op", "set", "path", path[0],
                              "value", (int)client->width, "op", "set", "path", path[1], "value", (int)client->height,
                              "op", "set", "path", path[2], "value", value);
    const vv_status st = edits ? vvi_session_edit(client->session, VVI_CAMERA, edits, true) : vv_fail_memory(256);
    json_decref(edits);
    return st;
}

vv_status vvi_client_fix_view(vvi_client *client)
{
    vv_world *world = vv_model_snapshot(client->session->model);
    const vv_view *view = vvi_view_named(world, client->view);
    if (client->has_stand && !(view && view->camera && vv_object_is_set(view->camera, "eye")))
        client->unsaved = true;
    vv_object_release(&world->base);
    return vvi_client_save_camera(client);
}

void vvi_client_stand(vvi_client *client, const vvi_stand *stand)
{
    vvi_slot *slot = &vvi_input_device(client->input)->slot[0];
    vvi_recording_stands(client->session->recording, vvi_now(), client->serial, stand);
    client->stand = *stand;
    client->has_stand = true;
    slot->pose = stand->pose;
    slot->up = stand->up;
    vvi_poses_note(&client->poses, &slot->pose);
    slot->changes++;
    client->changes = slot->changes;
    client->tells_pose = true;
}

void vvi_client_stand_anew(vvi_client *client)
{
    client->has_stand = client->unsaved = false;
    client->stands_since = client->session->commit;
}

static void take_frame(vvi_client *client, vvi_painted *painted)
{
    vvi_painted_free(&client->waiting);
    client->waiting = *painted;
    vvi_outbox_put(&client->box, ++client->numbers);
    client->tells_status = true;
}

static void tell_resolved(vvi_client *client, vvi_painted *painted)
{
    vvi_result r = {.compact = true};
    vvi_result_open(&r, NULL, '{');
    vvi_result_string(&r, "type", "resolved");
    vvi_result_unsigned(&r, "number", painted->commit);
    vvi_result_raw(&r, "world", painted->resolved);
    vvi_result_close(&r, '}');
    vvi_client_tell(client, VVI_LINE_RESOLVED, vvi_text_take(&r.text));
    free(painted->resolved);
    painted->resolved = NULL; /* else it would wait twice */
}

static void tell_failed(vvi_client *client, const vvi_painted *painted)
{
    char *sentence = vvi_files_sentence(client->session, painted->error);
    vvi_result r = {.compact = true};
    vvi_result_open(&r, NULL, '{');
    vvi_result_string(&r, "type", "failed");
    vvi_result_string(&r, "text", sentence);
    vvi_result_string(&r, "where", painted->where);
    vvi_result_unsigned(&r, "frame", client->numbers);
    vvi_result_close(&r, '}');
    free(sentence);
    vvi_client_tell(client, VVI_LINE_FAILED, vvi_text_take(&r.text));
    client->told_failed = true;
}

void vvi_client_serve(vvi_client *client, int64_t now)
{
    vvi_session *s = client->session;
    vvi_painted painted;
    if (client->slot < 0 || !vvi_painter_take(&painted, s->painter, client->slot))
        return;
    const bool current = painted.commit >= client->stands_since; /* one that was made before may be left here still */
    if (painted.has_stand && current && !client->has_stand && !s->is_played)
        vvi_client_stand(client, &painted.stand);
    if (painted.resolved)
        tell_resolved(client, &painted);
    vvi_client *opener = painted.warnings ? vvi_session_find(s, s->opener) : NULL;
    if (painted.warnings)
        vvi_client_warn(opener ? opener : client, painted.warnings);
    free(painted.warnings);
    painted.warnings = NULL; /* else they would wait with the frame */
    if (painted.error)
        tell_failed(client, &painted);
    if (painted.bytes) {
        take_frame(client, &painted);
        return;
    }
    vvi_painted_free(&painted);
    (void)now;
}

int64_t vvi_client_tick(vvi_client *client, int64_t now)
{
    const int64_t world = vvi_client_world_due(client) - now,
                  pause = world > 0 ? world : INT64_MAX; /* what is due is sent */
    if (client->wants && !client->box.waiting)
        vvi_client_want(client, false, now);
    if (!client->moving)
        return pause;
    const int64_t rests = client->moved + VVI_REST - now;
    if (rests > 0)
        return rests < pause ? rests : pause;
    client->moving = false;
    client->tells_pose = true;
    if (client->has_stand)
        vvi_poses_note(&client->poses, &vvi_input_device(client->input)->slot[0].pose);
    if (vvi_client_save_camera(client) != VV_OK)
        vvi_client_notice(client, "warning", vv_error_last()->message);
    vvi_client_want(client, false, now);
    return pause;
}

const char *vvi_client_stuck(const vvi_client *client, int64_t now)
{
    if (client->overrun)
        return "this page reads more slowly than it asks for data";
    return vvi_outbox_is_stuck(&client->box, STUCK_SECONDS, now)
               ? "this page has not confirmed a frame for half a minute"
               : NULL;
}
