/* What a page says: each type is a row. */
#include "core/memory.h"
#include "server/samples.h"
#include "server/session_impl.h"
#include "server/tables.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <volvis/base.h>
#include <volvis/volvis.h>

enum { SIDE_MOST = 8192, EDITS_MOST = 1000 };
#define SECOND 1e-9

typedef vv_status handler(vvi_client *client, int64_t id, const json_t *message, int64_t now);

static const char *text_of(const json_t *message, const char *key)
{
    return json_string_value(json_object_get(message, key));
}

static vv_status fail_message(const char *type, const char *what)
{
    return vv_fail(VV_E_FORMAT, "a message '%s' needs %s", type, what);
}

/* Greeting -------------------------------------------------------------------------------------------------------- */

static bool take_size(vvi_client *client, const json_t *message)
{
    const json_int_t w = json_integer_value(json_object_get(message, "width")),
                     h = json_integer_value(json_object_get(message, "height"));
    if (w < 1 || h < 1 || w > SIDE_MOST || h > SIDE_MOST)
        return false;
    client->width = (int32_t)w;
    client->height = (int32_t)h;
    return true;
}

static void tell_samples(vvi_result *out)
{
    const vvi_sample *sample;
    vvi_result_open(out, "samples", '[');
    for (size_t i = 0; (sample = vvi_sample_nth(i)) != NULL; i++) {
        vvi_result_open(out, NULL, '{');
        vvi_result_string(out, "name", sample->name);
        vvi_result_string(out, "doc", sample->doc);
        vvi_result_close(out, '}');
    }
    vvi_result_close(out, ']');
}

static void welcome(vvi_client *client)
{
    const vvi_session *s = client->session;
    vvi_result r = {.compact = true};
    vvi_result_open(&r, NULL, '{');
    vvi_result_string(&r, "type", "welcome");
    vvi_result_string(&r, "version", vv_version());
    vvi_result_string(&r, "client", client->view);
    vvi_result_string(&r, "view", client->view);
    vvi_result_bool(&r, "read_only", s->options.read_only);
    vvi_result_string(&r, "root", s->root);
    char *folder = realpath(".", NULL); /* where people are who have just typed a command */
    vvi_result_string(&r, "folder", folder && vvi_files_inside(s, folder) ? vvi_files_from_root(s, folder) : "");
    free(folder);
    vvi_result_unsigned(&r, "restored", s->restored);
    vvi_result_raw(&r, "bindings", s->bindings);
    vvi_tables_tell(&r, vv_runtime_registry(s->options.runtime));
    tell_samples(&r);
    vvi_result_close(&r, '}');
    vvi_client_say_result(client, &r);
}

static void tell_lost(vvi_client *client)
{
    const vvi_session *session = client->session;
    const char *kept = vvi_session_kept(session);
    char *text = kept ? vvi_asprintf("The interrupted session %s: %" PRIu64 " later changes are given up. %s.",
                                     session->restored ? "continues, but not to its end" : "cannot continue",
                                     session->lost, kept)
                      : NULL;
    if (text)
        vvi_client_notice(client, "warning", text);
    free(text);
}

static vv_status hello(vvi_client *client, int64_t id, const json_t *message, int64_t now)
{
    (void)id;
    if (!take_size(client, message))
        return fail_message("hello", "width and height, 1 to 8192 pixels");
    if (client->greeted)
        return fail_message("hello", "to be the first message");
    vv_status st = vvi_client_take_place(client);
    if (st == VV_OK)
        st = vvi_client_choose_view(client, text_of(message, "plane"));
    if (st != VV_OK)
        return st;
    welcome(client);
    client->greeted = client->tells_world = true;
    tell_lost(client);
    vvi_session_tell_number(client->session);
    vvi_client_want(client, true, now);
    return VV_OK;
}

static vv_status size(vvi_client *client, int64_t id, const json_t *message, int64_t now)
{
    (void)id;
    if (!take_size(client, message))
        return fail_message("size", "width and height, 1 to 8192 pixels");
    client->moved = now;
    client->moving = true;
    client->unsaved = client->has_stand;
    vvi_client_want(client, false, now);
    return VV_OK;
}

/* Input ----------------------------------------------------------------------------------------------------------- */

static vv_status feed_lines(vvi_client *client, char *lines)
{
    vv_status st = VV_OK;
    for (char *line = lines, *end; line && *line && st == VV_OK; line = end) {
        vvi_input_event event;
        end = strchr(line, '\n');
        if (end)
            *end++ = 0;
        if (!*line)
            continue;
        if ((st = vvi_event_parse(&event, line)) == VV_OK)
            st = vvi_input_feed(client->input, &event);
    }
    return st;
}

/* Of a drag also its phase and where it began; places as those of events. */
static void tell_action(vvi_client *client, const vvi_action *action)
{
    static const char *const phases[] = {"begin", "move", "end", "cancel"};
    vvi_result r = {.compact = true};
    vvi_result_open(&r, NULL, '{');
    vvi_result_string(&r, "type", "action");
    vvi_result_string(&r, "name", action->name);
    vvi_result_numbers(&r, "at", action->at, 2);
    if (action->drags) {
        vvi_result_string(&r, "phase", phases[action->phase]);
        vvi_result_numbers(&r, "from", action->from, 2);
    }
    vvi_result_close(&r, '}');
    vvi_client_say_result(client, &r);
}

static void take_actions(vvi_client *client, int64_t now)
{
    vvi_virtual_device *device = vvi_input_device(client->input);
    const int n = device->n_actions;
    vvi_action taken[VVI_INPUT_ACTIONS];
    if (n)
        memcpy(taken, device->action, (size_t)n * sizeof *taken);
    device->n_actions = 0;
    for (int i = 0; i < n; i++)
        if (taken[i].drags || !vvi_client_action(client, taken[i].name, now))
            tell_action(client, &taken[i]);
}

static vv_status events(vvi_client *client, int64_t id, const json_t *message, int64_t now)
{
    const char *lines = text_of(message, "lines");
    if (!lines)
        return fail_message("events", "lines");
    char *copy = vvi_strdup(lines);
    if (!copy)
        return vv_fail_memory(strlen(lines));
    const vv_status st = feed_lines(client, copy);
    free(copy);
    if (client->has_stand && vvi_input_device(client->input)->slot[0].changes != client->changes)
        vvi_client_moved(client, now);
    take_actions(client, now);
    if (st == VV_OK && id) {
        vvi_client_tell_pose(client);
        vvi_client_answer(client, id, NULL);
    }
    return st;
}

static vv_status action(vvi_client *client, int64_t id, const json_t *message, int64_t now)
{
    const char *name = text_of(message, "name");
    (void)id;
    if (!name)
        return fail_message("action", "a name");
    if (!vvi_client_action(client, name, now))
        vvi_client_notice(client, "warning", "there is no such action");
    return VV_OK;
}

static bool take_vector(vv_vec3 *out, const json_t *message, const char *key)
{
    const json_t *v = json_object_get(message, key);
    if (json_array_size(v) != 3)
        return false;
    *out = vvi_vec(json_number_value(json_array_get(v, 0)), json_number_value(json_array_get(v, 1)),
                   json_number_value(json_array_get(v, 2)));
    return vvi_finite(*out);
}

static vv_status camera(vvi_client *client, int64_t id, const json_t *message, int64_t now)
{
    vvi_slot *slot = &vvi_input_device(client->input)->slot[0];
    vv_vec3 eye, at, up;
    (void)id;
    if (!take_vector(&eye, message, "eye") || !take_vector(&at, message, "at") || !take_vector(&up, message, "up"))
        return fail_message("camera", "eye, at and up, three numbers each");
    vv_vec3 back = vvi_sub(eye, at), right = vvi_cross(up, back);
    if (!client->has_stand || !vvi_unit(&back) || !vvi_unit(&right))
        return VV_OK;
    const double least = fmin(client->width, client->height) / client->height;
    const double fov = json_number_value(json_object_get(message, "fov")) * M_PI / 180;
    const double height = json_number_value(json_object_get(message, "height"));
    slot->pose.eye = eye;
    slot->pose.pivot = at;
    slot->pose.turn = vvi_turn_of_axes(right, vvi_cross(back, right), back);
    slot->pose.parallel = json_is_true(json_object_get(message, "parallel"));
    if (fov > 0 && fov < M_PI)
        slot->pose.fov = 2 * atan(tan(fov / 2) * least);
    if (height > 0 && isfinite(height))
        slot->pose.height = height * least;
    slot->changes++;
    vvi_client_moved(client, now);
    return VV_OK;
}

static vv_status ack(vvi_client *client, int64_t id, const json_t *message, int64_t now)
{
    const json_t *frame = json_object_get(message, "frame");
    (void)id;
    if (!json_is_integer(frame))
        return fail_message("ack", "the number of a frame");
    const double travel = vvi_outbox_acknowledge(&client->box, (uint64_t)json_integer_value(frame), now);
    if (travel < 0)
        return VV_OK;
    vvi_pace_carried(&client->pace, client->sent.n, travel);
    if (client->sent.reduced && !client->moving && vvi_pace_carries(&client->pace, client->sent.whole)) {
        client->wants_whole = true;
        vvi_client_want(client, false, now);
    }
    if (client->seconds > 0) {
        vvi_pace_took(&client->pace, client->pixels, client->seconds, travel);
        const double between = (double)(now - client->last_ack) * SECOND;
        client->rate += 0.2 * ((between > 0 && between < 1 ? 1 / between : client->rate) - client->rate);
        client->latency = client->sent.event ? (double)(now - client->sent.event) * SECOND : client->latency;
    }
    client->last_ack = now;
    return VV_OK;
}

static vv_status frames(vvi_client *client, int64_t id, const json_t *message, int64_t now)
{
    static const char *const names[] = {
        [VVI_FRAMES_ALL] = "all", [VVI_FRAMES_RESTING] = "resting", [VVI_FRAMES_NONE] = "none"};
    const char *wanted = text_of(message, "wanted");
    (void)id;
    for (size_t i = 0; wanted && i < sizeof names / sizeof *names; i++) {
        if (strcmp(names[i], wanted) != 0)
            continue;
        const bool more = (vvi_frames)i < client->frames;
        client->frames = (vvi_frames)i;
        if (more)
            vvi_client_want(client, false, now);
        return VV_OK;
    }
    return fail_message("frames", "wanted: all, resting or none");
}

/* Edits ----------------------------------------------------------------------------------------------------------- */

static vv_status check_writable(const vvi_client *client)
{
    return client->session->options.read_only
               ? vv_fail(VV_E_ARGUMENT, "this World can only be looked at: the server was started with --read-only")
               : VV_OK;
}

static vv_status edit(vvi_client *client, int64_t id, const json_t *message, int64_t now)
{
    const json_t *edits = json_object_get(message, "edits");
    const char *gesture = text_of(message, "gesture");
    if (!json_is_array(edits) || json_array_size(edits) > EDITS_MOST)
        return fail_message("edit", "edits: a list of at most 1000");
    const bool again = vvi_client_sets_again(client, edits, now),
               join = gesture && *gesture ? strncmp(gesture, client->gesture, sizeof client->gesture - 1) == 0 : again;
    vv_status st = check_writable(client);
    if (gesture) { /* drawn quickly while the hand moves */
        client->moving = true;
        client->turning = false;
        client->moved = client->event = now;
    }
    if (st == VV_OK)
        st = vvi_session_edit(client->session, client->view, edits, join);
    client->again.commit = st == VV_OK ? client->session->scene : 0;
    snprintf(client->gesture, sizeof client->gesture, "%s", gesture && st == VV_OK ? gesture : "");
    if (st == VV_OK)
        vvi_client_answer(client, id, NULL);
    else
        vvi_client_refuse(client, id);
    return VV_OK;
}

static vv_status undo_or_redo(vvi_client *client, int64_t id, bool redo)
{
    vv_status st = check_writable(client);
    *client->gesture = 0;
    if (st == VV_OK)
        st = vvi_session_undo(client->session, client->view, redo);
    if (st == VV_OK)
        vvi_client_answer(client, id, NULL);
    else
        vvi_client_refuse(client, id);
    return VV_OK;
}

static vv_status undo(vvi_client *client, int64_t id, const json_t *message, int64_t now)
{
    (void)message;
    (void)now;
    return undo_or_redo(client, id, false);
}

static vv_status redo(vvi_client *client, int64_t id, const json_t *message, int64_t now)
{
    (void)message;
    (void)now;
    return undo_or_redo(client, id, true);
}

static vv_status begin_anew(vvi_client *client, int64_t id, const json_t *message, int64_t now)
{
    (void)message;
    (void)now;
    vv_status st = check_writable(client);
    *client->gesture = 0;
    if (st == VV_OK)
        st = vvi_session_empty(client->session, client->view);
    if (st == VV_OK) {
        vvi_session_shows(client->session, NULL);
        vvi_client_answer(client, id, NULL);
    } else {
        vvi_client_refuse(client, id);
    }
    return VV_OK;
}

static vv_status cancel(vvi_client *client, int64_t id, const json_t *message, int64_t now)
{
    const json_t *job = json_object_get(message, "job");
    (void)now;
    if (!json_is_integer(job))
        return fail_message("cancel", "the number of a job");
    const uint64_t owner = client->session->options.read_only ? client->serial : 0; /* of work on the World anybody's */
    const bool found = vvi_tasks_cancel(client->session->slow, json_integer_value(job), owner);
    vvi_client_answer(client, id, found ? "true" : "false");
    return VV_OK;
}

static vv_status browse(vvi_client *client, int64_t id, const json_t *message, int64_t now)
{
    const char *path = text_of(message, "path");
    vvi_result r = {.compact = true};
    (void)now;
    if (!path)
        return fail_message("browse", "a path");
    if (vvi_files_browse(&r, client->session, path) == VV_OK) {
        char *value = vvi_text_take(&r.text);
        vvi_client_answer(client, id, value);
        free(value);
    } else {
        vvi_text_free(&r.text);
        vvi_client_refuse(client, id);
    }
    return VV_OK;
}

/* The table ------------------------------------------------------------------------------------------------------- */

static const struct {
    const char *type;
    handler *take;
} rows[] = {
    {"hello", hello},    {"size", size},     {"events", events}, {"ack", ack},       {"edit", edit},
    {"new", begin_anew}, {"undo", undo},     {"redo", redo},     {"action", action}, {"camera", camera},
    {"browse", browse},  {"cancel", cancel}, {"frames", frames},
};

/* Those whose answer comes later, or is long. A refusal is an answer. */
static const struct {
    const char *type;
    vv_status (*take)(vvi_client *client, int64_t id, const json_t *message);
    bool changes;
} requests[] = {
    {"open", vvi_request_open, true},
    {"sample", vvi_request_sample, true},
    {"save", vvi_request_save, true},
    {"run", vvi_request_run, true},
    {"pick", vvi_request_pick, false},
    {"info", vvi_request_info, false},
    {"histogram", vvi_request_histogram, false},
    {"transfer", vvi_request_transfer, false},
    {"proposals", vvi_request_proposals, false},
    {"thumbnail", vvi_request_thumbnail, false},
    {"picture", vvi_request_picture, false},
    {"command", vvi_request_command, false},
    {"describe", vvi_request_describe, false},
    {"shape", vvi_request_shape, false},
};

static vv_status dispatch(vvi_client *client, const char *type, int64_t id, const json_t *message, int64_t now)
{
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++)
        if (strcmp(rows[i].type, type) == 0)
            return rows[i].take(client, id, message, now);
    for (size_t i = 0; i < sizeof requests / sizeof *requests; i++) {
        if (strcmp(requests[i].type, type) != 0)
            continue;
        vv_status st = requests[i].changes ? check_writable(client) : VV_OK;
        if (st == VV_OK)
            st = requests[i].take(client, id, message);
        if (st != VV_OK)
            vvi_client_refuse(client, id);
        return VV_OK;
    }
    return vv_fail(VV_E_FORMAT, "there is no message '%.40s'", type);
}

static vv_status refuse_flawed(vvi_client *client, int64_t id, const char *flaw)
{
    vv_fail(VV_E_ARGUMENT, "%s", flaw);
    vvi_client_refuse(client, id);
    return VV_OK;
}

vv_status vvi_client_message(vvi_client *client, const char *text, size_t n, int64_t now)
{
    vvi_session_tick(client->session, now); /* what was due comes first, as when it is played again */
    const char *flaw;
    json_t *message = vvi_message_read(&flaw, text, n);
    if (message && !flaw) /* else it does nothing */
        vvi_recording_says(client->session->recording, now, client->serial, message);
    const char *type = text_of(message, "type");
    const json_t *id = json_object_get(message, "id");
    vv_status st;
    client->refused = false;
    if (!type || (id && (!json_is_integer(id) || json_integer_value(id) < 1)))
        st = vv_fail(VV_E_FORMAT, "a message is a JSON object with a type and, if it has one, an id above 0");
    else if (!client->greeted && strcmp(type, "hello") != 0)
        st = vv_fail(VV_E_FORMAT, "the first message must be hello");
    else if (flaw)
        st = refuse_flawed(client, id ? json_integer_value(id) : 0, flaw);
    else
        st = dispatch(client, type, id ? json_integer_value(id) : 0, message, now);
    vvi_audit_message(client->session->audit, vvi_client_actor(client), message, client->refused || st != VV_OK);
    json_decref(message);
    return st;
}
