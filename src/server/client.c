/* One who looks: what waits to be sent, and the frames of its view. */
#include "core/memory.h"
#include "server/session_impl.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <volvis/image.h>

#define QUEUE_MOST ((size_t)8 << 20) /* bytes of text that wait: the World is told anew, not again and again */
#define FRAME_SECONDS 0.033
#define STUCK_SECONDS 30
#define SECOND 1e-9
#define CAMERA_PAUSE INT64_C(1000000000) /* before cameras that came to rest are told, nanoseconds */

static const char *const planes[] = {"axial", "coronal", "sagittal"};

/* Coming and going ------------------------------------------------------------------------------------------------ */

static int free_slot(const vvi_session *s)
{
    for (int i = 0; i < VVI_PAINTER_VIEWS; i++)
        if (!s->slots[i])
            return i;
    return -1;
}

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

vv_status vvi_client_join(vvi_client **out, vvi_session *session, void *user)
{
    const int slot = free_slot(session);
    int n = 0;
    *out = NULL;
    for (const vvi_client *c = session->clients; c; c = c->next)
        n++;
    if (slot < 0 || n >= session->options.clients_most)
        return vv_fail(VV_E_LIMIT, "%d people look at this World already; try again when one has left", n);
    vvi_client *c = vvi_calloc(1, sizeof *c);
    if (!c)
        return vv_fail_memory(sizeof *c);
    *c = (vvi_client){.session = session, .user = user, .slot = slot, .serial = ++session->serials};
    c->width = 800;
    c->height = 600;
    c->last = &c->first;
    vvi_pace_init(&c->pace, FRAME_SECONDS);
    c->input = vvi_input_new();
    vv_status st =
        c->input ? vvi_input_bind(c->input, session->bindings, strlen(session->bindings)) : vv_fail_memory(1);
    if (st != VV_OK) {
        vvi_input_free(c->input);
        free(c);
        return st;
    }
    vvi_recording_note(session->recording, vvi_now(), c->serial, "joins");
    session->slots[slot] = true;
    c->next = session->clients;
    session->clients = c;
    *out = c;
    return VV_OK;
}

static void tell_number(vvi_session *s)
{
    int n = 0;
    for (const vvi_client *c = s->clients; c; c = c->next)
        n++;
    for (vvi_client *c = s->clients; c; c = c->next)
        if (c->greeted)
            vvi_client_say(c, vvi_asprintf("{\"type\": \"clients\", \"n\": %d}", n));
}

void vvi_client_leave(vvi_client *client)
{
    vvi_session *s = client->session;
    vvi_client **at = &s->clients;
    vvi_recording_note(s->recording, vvi_now(), client->serial, "leaves");
    vvi_client_save_camera(client);
    vvi_client_drop_shape(client);
    while (*at != client)
        at = &(*at)->next;
    *at = client->next;
    s->slots[client->slot] = false;
    vvi_painter_forget(s->painter, client->slot);
    for (vvi_line *l = client->first, *next; l; l = next) {
        next = l->next;
        free(l->text);
        free(l);
    }
    vvi_painted_free(&client->sent);
    vvi_painted_free(&client->waiting);
    vvi_input_free(client->input);
    free(client);
    tell_number(s);
}

void *vvi_client_user(const vvi_client *client)
{
    return client->user;
}

/* Saying ---------------------------------------------------------------------------------------------------------- */

void vvi_client_say(vvi_client *client, char *text)
{
    vvi_line *line = text ? vvi_calloc(1, sizeof *line) : NULL;
    const size_t n = text ? strlen(text) : 0;
    if (!line || client->queued + n > QUEUE_MOST) {
        client->overrun = true;
        free(text);
        free(line);
        return;
    }
    *line = (vvi_line){.text = text, .n = n};
    client->queued += n;
    *client->last = line;
    client->last = &line->next;
}

void vvi_client_say_result(vvi_client *client, vvi_result *result)
{
    vvi_client_say(client, vvi_text_take(&result->text));
}

void vvi_client_notice(vvi_client *client, const char *level, const char *text)
{
    vvi_result r = {.compact = true};
    vvi_result_open(&r, NULL, '{');
    vvi_result_string(&r, "type", "notice");
    vvi_result_string(&r, "level", level);
    vvi_result_string(&r, "text", text);
    vvi_result_close(&r, '}');
    vvi_client_say_result(client, &r);
}

void vvi_client_answer(vvi_client *client, int64_t id, const char *value)
{
    vvi_result r = {.compact = true};
    if (!id)
        return;
    vvi_result_open(&r, NULL, '{');
    vvi_result_string(&r, "type", "answer");
    vvi_result_integer(&r, "id", id);
    vvi_result_bool(&r, "ok", true);
    vvi_result_raw(&r, "value", value ? value : "null");
    vvi_result_close(&r, '}');
    vvi_client_say_result(client, &r);
}

void vvi_client_refuse(vvi_client *client, int64_t id)
{
    vvi_result r = {.compact = true};
    if (!id) {
        vvi_client_notice(client, "error", vv_error_last()->message);
        return;
    }
    vvi_result_open(&r, NULL, '{');
    vvi_result_string(&r, "type", "answer");
    vvi_result_integer(&r, "id", id);
    vvi_result_bool(&r, "ok", false);
    vvi_result_string(&r, "error", vv_error_last()->message);
    vvi_result_close(&r, '}');
    vvi_client_say_result(client, &r);
}

/* Frames ---------------------------------------------------------------------------------------------------------- */

void vvi_client_want(vvi_client *client, bool coarse, int64_t now)
{
    vvi_session *s = client->session;
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
    vvi_pace_size(wish.frame_size, &client->pace, client->width, client->height);
    if (world->volumes->n > 0 || world->views->n > 0)
        vvi_painter_want(s->painter, client->slot, &wish);
    vv_object_release(&world->base);
    client->wants = client->wants_coarse = false;
    (void)now;
}

void vvi_client_moved(vvi_client *client, int64_t now)
{
    client->changes = vvi_input_device(client->input)->slot[0].changes;
    client->moved = client->event = now;
    client->moving = client->turning = client->unsaved = client->tells_pose = true;
    vvi_client_want(client, false, now);
}

vv_status vvi_client_save_camera(vvi_client *client)
{
    if (!client->unsaved || !client->has_stand)
        return VV_OK;
    client->unsaved = false;
    char path[3][VVI_VIEW_NAME + 32];
    char *camera = vvi_camera_json(&vvi_input_device(client->input)->slot[0].pose, client->width, client->height);
    json_t *value = camera ? json_loads(camera, 0, NULL) : NULL;
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
    const vv_view *view = (const vv_view *)(const void *)vv_collection_find(world->views, client->view);
    if (client->has_stand && !(view && view->camera && vv_object_is_set(view->camera, "eye")))
        client->unsaved = true;
    vv_object_release(&world->base);
    return vvi_client_save_camera(client);
}

static void take_stand(vvi_client *client, const vvi_painted *painted)
{
    vvi_slot *slot = &vvi_input_device(client->input)->slot[0];
    if (!painted->has_stand || client->has_stand)
        return;
    vvi_recording_note(client->session->recording, vvi_now(), client->serial, "stands");
    client->stand = painted->stand;
    client->has_stand = true;
    slot->pose = painted->stand.pose;
    slot->up = painted->stand.up;
    slot->changes++;
    client->changes = slot->changes;
    client->tells_pose = true;
}

static void take_frame(vvi_client *client, vvi_painted *painted)
{
    vvi_painted_free(&client->waiting);
    client->waiting = *painted;
    vvi_outbox_put(&client->box, ++client->numbers);
    client->tells_status = true;
}

void vvi_client_serve(vvi_client *client, int64_t now)
{
    vvi_session *s = client->session;
    vvi_painted painted;
    if (!vvi_painter_take(&painted, s->painter, client->slot))
        return;
    take_stand(client, &painted);
    if (painted.resolved) {
        vvi_result r = {.compact = true};
        vvi_result_open(&r, NULL, '{');
        vvi_result_string(&r, "type", "resolved");
        vvi_result_unsigned(&r, "number", painted.commit);
        vvi_result_raw(&r, "world", painted.resolved);
        vvi_result_close(&r, '}');
        vvi_client_say_result(client, &r);
    }
    if (painted.error)
        vvi_client_notice(client, "error", painted.error);
    if (painted.bytes) {
        take_frame(client, &painted);
        return;
    }
    vvi_painted_free(&painted);
    (void)now;
}

/* When the World is told next: somebody who commits a thousand times a second costs the others no more than a hand that
 * drags, and a crowd whose cameras come to rest no more than a few Worlds. */
static int64_t world_due(const vvi_client *client)
{
    const int64_t pause = client->session->told_pause;
    if (client->tells_world)
        return client->world_told + pause;
    return client->tells_cameras ? client->world_told + (pause > CAMERA_PAUSE ? pause : CAMERA_PAUSE) : INT64_MAX;
}

int64_t vvi_client_tick(vvi_client *client, int64_t now)
{
    const int64_t world = world_due(client) - now, pause = world > 0 ? world : INT64_MAX; /* what is due is sent */
    if (client->wants && !client->box.waiting)
        vvi_client_want(client, false, now);
    if (!client->moving)
        return pause;
    const int64_t rests = client->moved + VVI_REST - now;
    if (rests > 0)
        return rests < pause ? rests : pause;
    client->moving = false;
    client->tells_pose = true;
    if (vvi_client_save_camera(client) != VV_OK)
        vvi_client_notice(client, "warning", vv_error_last()->message);
    vvi_client_want(client, false, now);
    return pause;
}

/* What is sent ---------------------------------------------------------------------------------------------------- */

static char *pose_text(vvi_client *client)
{
    vvi_result r = {.compact = true};
    vvi_result_open(&r, NULL, '{');
    vvi_result_string(&r, "type", "pose");
    vvi_camera_tell(&r, &vvi_input_device(client->input)->slot[0].pose, client->width, client->height);
    vvi_result_bool(&r, "moving", client->moving);
    vvi_result_close(&r, '}');
    return vvi_text_take(&r.text);
}

static char *world_text(const vvi_client *client)
{
    vvi_session *s = client->session;
    vvi_result r = {.compact = true};
    vv_world *world = vv_model_snapshot(s->model);
    const char *scene = vvi_session_told(s);
    bool undo, redo;
    vv_model_can(&undo, &redo, s->model, client->view);
    if (scene) {
        vvi_result_open(&r, NULL, '{');
        vvi_result_string(&r, "type", "world");
        vvi_result_unsigned(&r, "number", s->commit);
        vvi_result_string(&r, "who", s->who);
        vvi_result_raw(&r, "paths", s->paths ? s->paths : "null");
        vvi_result_bool(&r, "undo", undo);
        vvi_result_bool(&r, "redo", redo);
        vvi_result_string(&r, "title", world->title);
        vvi_result_raw(&r, "world", scene);
        vvi_result_close(&r, '}');
    }
    vv_object_release(&world->base);
    return vvi_text_take(&r.text);
}

static char *status_text(const vvi_client *client)
{
    const vvi_session *s = client->session;
    const vvi_painted *p = client->waiting.bytes ? &client->waiting : &client->sent;
    vvi_result r = {.compact = true};
    vvi_result_open(&r, NULL, '{');
    vvi_result_string(&r, "type", "status");
    vvi_result_number(&r, "frames", round(client->rate * 10) / 10);
    vvi_result_number(&r, "latency", round(client->latency * 1e4) / 10);
    vvi_result_unsigned(&r, "memory", vv_runtime_memory_used(s->options.runtime));
    vvi_result_unsigned(&r, "memory_limit", vv_runtime_memory_limit(s->options.runtime));
    vvi_result_string(&r, "method", p->method);
    vvi_result_integer(&r, "level", p->level);
    vvi_result_integer(&r, "passes", p->passes);
    vvi_result_bool(&r, "final", p->final);
    vvi_result_number(&r, "scale", p->full[0] ? (double)p->size[0] / p->full[0] : 1);
    vvi_result_close(&r, '}');
    return vvi_text_take(&r.text);
}

static void put16(uint8_t *at, uint64_t value)
{
    at[0] = (uint8_t)value;
    at[1] = (uint8_t)(value >> 8);
}

static void put32(uint8_t *at, uint64_t value)
{
    put16(at, value);
    put16(at + 2, value >> 16);
}

static void write_head(uint8_t head[32], const vvi_painted *p, uint64_t number, int64_t now)
{
    const float age = p->event ? (float)((double)(now - p->event) * 1e-6) : 0;
    uint32_t bits;
    memcpy(&bits, &age, sizeof bits);
    memcpy(head, (const uint8_t[4]){'V', 'V', 'F', '1'}, 4);
    put16(head + 4, (uint64_t)p->kind);
    put16(head + 6, (p->final ? 1u : 0u) | (p->moving ? 2u : 0u));
    put32(head + 8, number);
    put16(head + 12, (uint64_t)p->size[0]);
    put16(head + 14, (uint64_t)p->size[1]);
    put16(head + 16, (uint64_t)p->full[0]);
    put16(head + 18, (uint64_t)p->full[1]);
    put16(head + 20, (uint64_t)p->level);
    put16(head + 22, p->passes > 65535 ? 65535 : (uint64_t)p->passes);
    put32(head + 24, p->commit);
    put32(head + 28, bits);
}

static bool send_frame(vvi_outgoing *out, vvi_client *client, int64_t now)
{
    const uint64_t number = vvi_outbox_send(&client->box, now);
    if (!number)
        return false;
    vvi_painted *p = &client->waiting;
    write_head(out->head, p, number, now);
    out->bytes = p->bytes;
    out->n = p->n;
    p->bytes = NULL;
    client->pixels = (int64_t)p->size[0] * p->size[1];
    client->seconds = p->moving ? p->seconds : 0;
    vvi_painted_free(&client->sent);
    client->sent = *p;
    *p = (vvi_painted){.n = 0};
    return true;
}

static char *next_text(vvi_client *client, int64_t now)
{
    if (world_due(client) <= now) {
        client->tells_world = client->tells_cameras = false;
        client->world_told = now;
        return world_text(client);
    }
    if (client->tells_pose && client->has_stand) {
        client->tells_pose = false;
        return pose_text(client);
    }
    if (client->tells_status) {
        client->tells_status = false;
        return status_text(client);
    }
    return NULL;
}

bool vvi_client_has_more(const vvi_client *client, int64_t now)
{
    return client->first ||
           (client->greeted &&
            (world_due(client) <= now || (client->tells_pose && client->has_stand) || client->tells_status)) ||
           (client->box.waiting && !client->box.under_way);
}

bool vvi_client_next(vvi_outgoing *out, vvi_client *client, int64_t now)
{
    *out = (vvi_outgoing){.n = 0};
    if (client->text_was_last && send_frame(out, client, now)) {
        client->text_was_last = false;
        return true;
    }
    client->text_was_last = true;
    vvi_line *line = client->first;
    if (line) {
        client->first = line->next;
        if (!client->first)
            client->last = &client->first;
        client->queued -= line->n;
        out->text = line->text;
        out->n = line->n;
        free(line);
        return true;
    }
    if (client->greeted && (out->text = next_text(client, now)) != NULL) {
        out->n = strlen(out->text);
        return true;
    }
    return send_frame(out, client, now);
}

bool vvi_client_is_stuck(const vvi_client *client, int64_t now)
{
    return client->overrun || vvi_outbox_is_stuck(&client->box, STUCK_SECONDS, now);
}
