/* What a client is told: texts that wait, and those that are made when they can be sent. */
#include "core/memory.h"
#include "server/session_impl.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define CAMERA_PAUSE INT64_C(1000000000) /* before cameras that came to rest are told, nanoseconds */
#define PATIENCE INT64_C(250000000)      /* after a frame was sent: then the page is behind */

/* Saying ---------------------------------------------------------------------------------------------------------- */

void vvi_client_tell(vvi_client *client, vvi_line_kind kind, char *text)
{
    if (!vvi_text_queue_put(&client->lines, kind, text))
        client->overrun = true;
}

void vvi_client_say(vvi_client *client, char *text)
{
    vvi_client_tell(client, VVI_LINE_KEPT, text);
}

void vvi_session_tell(const vvi_session *s, vvi_line_kind kind, char *text)
{
    for (vvi_client *c = s->clients; c && text; c = c->next)
        if (c->greeted)
            vvi_client_tell(c, kind, vvi_strdup(text));
    free(text);
}

int vvi_session_looking(const vvi_session *s)
{
    int n = 0;
    for (const vvi_client *c = s->clients; c; c = c->next)
        n += c->greeted;
    return n;
}

void vvi_session_tell_number(const vvi_session *s)
{
    vvi_session_tell(s, VVI_LINE_CLIENTS, vvi_asprintf("{\"type\": \"clients\", \"n\": %d}", vvi_session_looking(s)));
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
    vvi_client_tell(client, VVI_LINE_NOTICE, vvi_text_take(&r.text));
}

void vvi_client_warn(vvi_client *client, const char *warnings)
{
    vvi_session *s = client->session;
    for (const char *at = warnings; at && *at; at += strcspn(at, "\n") + 1) {
        char *line = strndup(at, strcspn(at, "\n") + 1);
        const size_t before = s->warnings ? strlen(s->warnings) : 0;
        vvi_warnings_add(&s->warnings, line);
        if (!line || !s->warnings || strlen(s->warnings) == before)
            continue; /* it was told */
        char *text = vvi_files_sentence(s, s->warnings + before);
        if (text) {
            text[strcspn(text, "\n")] = 0;
            vvi_client_notice(client, "warning", text);
        }
        free(text);
    }
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

void vvi_client_refuse_for(vvi_client *client, int64_t id, const char *reason)
{
    vvi_result r = {.compact = true};
    client->refused = true;
    if (!id) {
        vvi_client_notice(client, "error", vv_error_last()->message);
        return;
    }
    char *sentence = vvi_files_sentence(client->session, vv_error_last()->message);
    vvi_result_open(&r, NULL, '{');
    vvi_result_string(&r, "type", "answer");
    vvi_result_integer(&r, "id", id);
    vvi_result_bool(&r, "ok", false);
    vvi_result_string(&r, "error", sentence);
    free(sentence);
    if (reason)
        vvi_result_string(&r, "reason", reason);
    vvi_result_close(&r, '}');
    vvi_client_say_result(client, &r);
}

void vvi_client_answer_result(vvi_client *client, int64_t id, vvi_result *value, vv_status st, const char *reason)
{
    const size_t n = value->text.n;
    char *text = vvi_text_take(&value->text);
    if (st == VV_OK && !text)
        st = vv_fail_memory(n);
    if (st == VV_OK)
        vvi_client_answer(client, id, *text ? text : NULL);
    else
        vvi_client_refuse_for(client, id, reason);
    free(text);
}

void vvi_client_refuse(vvi_client *client, int64_t id)
{
    vvi_client_refuse_for(client, id, NULL);
}

/* When the World is told next: somebody who commits a thousand times a second costs the others no more than a hand that
 * drags, and a crowd whose cameras come to rest no more than a few Worlds. */
int64_t vvi_client_world_due(const vvi_client *client)
{
    const int64_t pause = client->world_rest;
    if (client->tells_world)
        return client->world_told + pause;
    return client->tells_cameras ? client->world_told + (pause > CAMERA_PAUSE ? pause : CAMERA_PAUSE) : INT64_MAX;
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

void vvi_client_tell_pose(vvi_client *client)
{
    if (!client->tells_pose || !client->has_stand)
        return;
    client->tells_pose = false;
    vvi_client_say(client, pose_text(client));
}

/* What was changed since the client was told the World, by all commits. */
static void tell_paths(vvi_result *out, const vvi_client *client)
{
    const vvi_session *s = client->session;
    vvi_text text = {.n = 0};
    const char *before = "";
    bool known = client->changes_told && s->n_changes - client->changes_told <= VVI_CHANGES_KEPT;
    for (uint64_t i = client->changes_told; known && i < s->n_changes; i++) {
        const char *paths = s->paths[i % VVI_CHANGES_KEPT];
        known = paths != NULL;
        if (known && *paths && strcmp(paths, before) != 0) /* a drag changes the same again and again */
            vvi_text_printf(&text, "%s%s", *before ? "," : "[", paths);
        before = known && *paths ? paths : before;
    }
    vvi_text_add(&text, *before ? "]" : "[]");
    char *list = vvi_text_take(&text);
    vvi_result_raw(out, "paths", known && list ? list : "null");
    free(list);
}

/* The client knows this World from now on. */
static void know(vvi_client *client, vv_world *world)
{
    if (client->known)
        vv_object_release(&client->known->base);
    client->known = world;
    client->known_commit = client->session->commit;
}

/* As a whole, or what has changed since the client was told the last one. */
static char *world_text(vvi_client *client)
{
    vvi_session *s = client->session;
    vvi_result r = {.compact = true};
    vv_world *world = vv_model_snapshot(s->model);
    const char *changes = client->known ? vvi_session_changes(s, client->known, world) : NULL,
               *scene = changes ? NULL : vvi_session_told(s);
    bool undo, redo;
    vv_model_can(&undo, &redo, s->model, client->view);
    if (scene || changes) {
        vvi_result_open(&r, NULL, '{');
        vvi_result_string(&r, "type", "world");
        vvi_result_unsigned(&r, "number", s->commit);
        vvi_result_string(&r, "who", s->who);
        tell_paths(&r, client);
        vvi_result_bool(&r, "undo", undo);
        vvi_result_bool(&r, "redo", redo);
        vvi_result_string(&r, "title", world->title);
        if (changes)
            vvi_result_unsigned(&r, "since", client->known_commit);
        vvi_result_raw(&r, changes ? "changes" : "world", changes ? changes : scene);
        vvi_result_close(&r, '}');
    }
    char *text = scene || changes ? vvi_text_take(&r.text) : NULL;
    client->world_rest = vvi_session_world_rest(s, text ? strlen(text) : 0);
    if (!text) { /* it is told all of the next one */
        vv_object_release(&world->base);
        world = NULL;
    }
    know(client, world);
    return text;
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
    vvi_result_bool(&r, "final", vvi_client_is_final(client, p));
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

static void write_head(uint8_t head[32], const vvi_painted *p, bool final, uint64_t number, int64_t now)
{
    const float age = p->event ? (float)((double)(now - p->event) * 1e-6) : 0;
    uint32_t bits;
    memcpy(&bits, &age, sizeof bits);
    memcpy(head, (const uint8_t[4]){'V', 'V', 'F', '1'}, 4);
    put16(head + 4, (uint64_t)p->kind);
    put16(head + 6, (final ? 1u : 0u) | (p->moving ? 2u : 0u) | (p->reduced ? 4u : 0u));
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

/* It was made when less was known of the line, or the line is not what it was: one that has less is made in its place.
 */
static bool is_too_large(const vvi_client *client)
{
    const vvi_painted *p = &client->waiting;
    return client->box.waiting && !client->box.under_way && !p->moving && !p->reduced &&
           vvi_pace_is_known(&client->pace) && p->n > vvi_pace_room(&client->pace) &&
           !vvi_pace_carries(&client->pace, p->n);
}

static bool send_frame(vvi_outgoing *out, vvi_client *client, int64_t now)
{
    if (is_too_large(client)) {
        vvi_painted_free(&client->waiting);
        client->waiting = (vvi_painted){.n = 0};
        client->box.waiting = 0;
        vvi_client_want(client, false, now);
        return false;
    }
    const uint64_t number = vvi_outbox_send(&client->box, now);
    if (!number)
        return false;
    vvi_painted *p = &client->waiting;
    client->told_final = vvi_client_is_final(client, p);
    client->tells_outdated = false; /* after the newer frame it would be said of that one */
    write_head(out->head, p, client->told_final, number, now);
    out->bytes = p->bytes;
    out->n = p->n;
    out->breaks = !p->moving && !vvi_pace_is_known(&client->pace);
    p->bytes = NULL;
    client->pixels = (int64_t)p->size[0] * p->size[1];
    client->seconds = p->moving ? p->seconds : 0;
    vvi_painted_free(&client->sent);
    client->sent = *p;
    *p = (vvi_painted){.n = 0};
    return true;
}

/* The page has less than a final picture, and will not show it; how long it took tells what the line carries. */
void vvi_client_broke(vvi_client *client, size_t n)
{
    client->broke = client->sent.reduced = true;
    client->told_final = false;
    client->sent.n -= n;
    vvi_outbox_broke(&client->box, n);
}

/* How things stand, as far as it has changed; NULL: as it was told. */
static char *next_text(vvi_client *client, int64_t now)
{
    if (vvi_client_world_due(client) <= now) {
        client->tells_world = client->tells_cameras = false;
        client->world_told = now;
        char *text = world_text(client);
        client->tells_world = !text; /* there was no memory: soon again */
        if (text)
            client->changes_told = client->session->n_changes;
        return text;
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

/* A page that is behind is told what only it can know; how things stand, when it has seen its frame. Else its line
 * would fill with news that are old when they arrive, and frames would wait behind them. */
static bool is_behind(const vvi_client *client, int64_t now)
{
    return client->box.under_way && now - client->box.sent_at > PATIENCE;
}

static bool has_news(const vvi_client *client, int64_t now)
{
    return client->greeted && !is_behind(client, now) &&
           (vvi_client_world_due(client) <= now || (client->tells_pose && client->has_stand) || client->tells_status);
}

bool vvi_client_has_more(const vvi_client *client, int64_t now)
{
    return client->tells_outdated || vvi_text_queue_any(&client->lines, is_behind(client, now)) ||
           has_news(client, now) || (client->box.waiting && !client->box.under_way);
}

static bool send_text(vvi_outgoing *out, vvi_client *client, int64_t now)
{
    if (client->tells_outdated && (out->text = vvi_strdup("{\"type\": \"outdated\"}")) != NULL) {
        client->tells_outdated = false;
        out->n = strlen(out->text);
        return true;
    }
    out->text = vvi_text_queue_take(&out->n, &client->lines, is_behind(client, now));
    if (!out->text && has_news(client, now) && (out->text = next_text(client, now)) != NULL)
        out->n = strlen(out->text);
    return out->text != NULL;
}

bool vvi_client_next(vvi_outgoing *out, vvi_client *client, int64_t now)
{
    *out = (vvi_outgoing){.n = 0};
    const bool frame_first = client->text_was_last && send_frame(out, client, now),
               text = !frame_first && send_text(out, client, now);
    if (!frame_first && !text && !send_frame(out, client, now))
        return false;
    client->text_was_last = text; /* the welcome comes before all */
    vvi_outbox_wrote(&client->box, out->n);
    return true;
}

/* News that newer ones replace do not count: they wait for a page that is behind, and it is behind until what it says
 * of its frame is read. */
bool vvi_client_is_full(const vvi_client *client)
{
    size_t n = 0;
    for (const vvi_line *line = client->lines.first; line; line = line->next)
        n += line->kind <= VVI_LINE_NOTICE ? sizeof *line + line->n : 0;
    return n > VVI_LINES_MOST / 4;
}
