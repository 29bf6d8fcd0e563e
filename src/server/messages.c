/* What a page says: each type is a row. */
#include "core/memory.h"
#include "server/demos.h"
#include "server/message_input.h"
#include "server/tables.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <volvis/base.h>
#include <volvis/volvis.h>

enum { SIDE_MOST = 8192, EDITS_MOST = 1000 };

typedef vv_status handler(vvi_client *client, int64_t id, const json_t *message, int64_t now);

const char *vvi_message_text(const json_t *message, const char *key)
{
    return json_string_value(json_object_get(message, key));
}

vv_status vvi_message_fail(const char *type, const char *what)
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
    const vvi_demo *sample;
    vvi_result_open(out, "samples", '[');
    for (size_t i = 0; (sample = vvi_demo_nth(i)) != NULL; i++) {
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
    char lost[64] = "";
    if (session->lost)
        snprintf(lost, sizeof lost, "%" PRIu64 " later change%s given up. ", session->lost,
                 session->lost == 1 ? " is" : "s are");
    char *text = kept
                     ? vvi_asprintf("The interrupted session %s: %s%s.",
                                    session->restored ? "continues, but not to its end" : "cannot continue", lost, kept)
                     : NULL;
    if (text)
        vvi_client_notice(client, "warning", text);
    free(text);
}

static vv_status hello(vvi_client *client, int64_t id, const json_t *message, int64_t now)
{
    (void)id;
    if (!take_size(client, message))
        return vvi_message_fail("hello", "width and height, 1 to 8192 pixels");
    if (client->greeted)
        return vvi_message_fail("hello", "to be the first message");
    vv_status st = vvi_client_take_place(client);
    if (st == VV_OK)
        st = vvi_client_choose_view(client, vvi_message_text(message, "plane"));
    if (st == VV_OK) /* not before: many come and go that say no hello */
        st = vvi_input_bind(client->input, client->session->bindings, strlen(client->session->bindings));
    if (st != VV_OK)
        return st;
    welcome(client);
    client->greeted = client->tells_world = true;
    tell_lost(client);
    vvi_session_tell_problems(client);
    vvi_session_tell_number(client->session);
    vvi_client_want(client, true, now);
    return VV_OK;
}

static vv_status size(vvi_client *client, int64_t id, const json_t *message, int64_t now)
{
    (void)id;
    if (!take_size(client, message))
        return vvi_message_fail("size", "width and height, 1 to 8192 pixels");
    client->moved = now;
    client->moving = true;
    client->unsaved = client->has_stand;
    vvi_client_want(client, false, now);
    return VV_OK;
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
    const char *gesture = vvi_message_text(message, "gesture");
    if (!json_is_array(edits) || json_array_size(edits) > EDITS_MOST)
        return vvi_message_fail("edit", "edits: a list of at most 1000");
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

/* A page that lost what it was told. */
static vv_status whole_world(vvi_client *client, int64_t id, const json_t *message, int64_t now)
{
    (void)id;
    (void)message;
    (void)now;
    client->tells_world = true;
    if (client->known)
        vv_object_release(&client->known->base);
    client->known = NULL;
    return VV_OK;
}

static vv_status cancel(vvi_client *client, int64_t id, const json_t *message, int64_t now)
{
    const json_t *job = json_object_get(message, "job");
    (void)now;
    if (!json_is_integer(job))
        return vvi_message_fail("cancel", "the number of a job");
    const uint64_t owner = client->session->options.read_only ? client->serial : 0; /* of work on the World anybody's */
    const bool found = vvi_tasks_cancel(client->session->slow, json_integer_value(job), owner);
    vvi_client_answer(client, id, found ? "true" : "false");
    return VV_OK;
}

static vv_status browse(vvi_client *client, int64_t id, const json_t *message, int64_t now)
{
    const char *path = vvi_message_text(message, "path");
    vvi_result r = {.compact = true};
    (void)now;
    if (!path)
        return vvi_message_fail("browse", "a path");
    vvi_client_answer_result(client, id, &r, vvi_files_browse(&r, client->session, path), NULL);
    return VV_OK;
}

/* The table ------------------------------------------------------------------------------------------------------- */

static const struct {
    const char *type;
    handler *take;
    bool answers; /* itself; for others an answer says that it was taken, where one is wanted */
} rows[] = {
    {"hello", hello, false},
    {"size", size, false},
    {"events", vvi_message_events, true},
    {"ack", vvi_message_ack, false},
    {"edit", edit, true},
    {"new", begin_anew, true},
    {"undo", undo, true},
    {"redo", redo, true},
    {"action", vvi_message_action, false},
    {"camera", vvi_message_camera, false},
    {"browse", browse, true},
    {"cancel", cancel, true},
    {"frames", vvi_message_frames, false},
    {"world", whole_world, false},
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
    {"write", vvi_request_write, true},
    {"measure", vvi_request_measure, false},
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
    {"preview", vvi_request_preview, false},
};

static vv_status dispatch(vvi_client *client, const char *type, int64_t id, const json_t *message, int64_t now)
{
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++)
        if (strcmp(rows[i].type, type) == 0) {
            const vv_status st = rows[i].take(client, id, message, now);
            if (st == VV_OK && !rows[i].answers)
                vvi_client_answer(client, id, NULL);
            return st;
        }
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
    bool no_memory;
    json_t *message = vvi_message_read(&flaw, &no_memory, text, n);
    if (message && !flaw) /* else it does nothing */
        vvi_recording_says(client->session->recording, now, client->serial, message);
    const char *type = vvi_message_text(message, "type");
    const json_t *id = json_object_get(message, "id");
    vv_status st;
    client->refused = false;
    if (no_memory)
        st = vv_fail_memory(n);
    else if (!type || (id && (!json_is_integer(id) || json_integer_value(id) < 1)))
        st = vv_fail(VV_E_FORMAT, "a message is a JSON object with a type and, if it has one, an id above 0");
    else if (!client->greeted && strcmp(type, "hello") != 0)
        st = vv_fail(VV_E_FORMAT, "the first message must be hello");
    else if (!client->greeted && flaw)
        st = vv_fail(VV_E_FORMAT, "%s", flaw);
    else if (flaw)
        st = refuse_flawed(client, id ? json_integer_value(id) : 0, flaw);
    else
        st = dispatch(client, type, id ? json_integer_value(id) : 0, message, now);
    vvi_audit_message(client->session->audit, vvi_client_actor(client), message, client->refused || st != VV_OK);
    json_decref(message);
    return st;
}
