/* What hands do, and what a page says of its frames. */
#include "server/message_input.h"
#include "core/memory.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define SECOND 1e-9

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

vv_status vvi_message_events(vvi_client *client, int64_t id, const json_t *message, int64_t now)
{
    const char *lines = vvi_message_text(message, "lines");
    if (!lines)
        return vvi_message_fail("events", "lines");
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

vv_status vvi_message_action(vvi_client *client, int64_t id, const json_t *message, int64_t now)
{
    const char *name = vvi_message_text(message, "name");
    (void)id;
    if (!name)
        return vvi_message_fail("action", "a name");
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

vv_status vvi_message_camera(vvi_client *client, int64_t id, const json_t *message, int64_t now)
{
    vvi_slot *slot = &vvi_input_device(client->input)->slot[0];
    vv_vec3 eye, at, up;
    (void)id;
    if (!take_vector(&eye, message, "eye") || !take_vector(&at, message, "at") || !take_vector(&up, message, "up"))
        return vvi_message_fail("camera", "eye, at and up, three numbers each");
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

vv_status vvi_message_ack(vvi_client *client, int64_t id, const json_t *message, int64_t now)
{
    const json_t *frame = json_object_get(message, "frame");
    (void)id;
    if (!json_is_integer(frame))
        return vvi_message_fail("ack", "the number of a frame");
    const double travel = vvi_outbox_acknowledge(&client->box, (uint64_t)json_integer_value(frame), now);
    if (travel < 0)
        return VV_OK;
    const double since = (double)(now - client->last_ack) * SECOND;
    const bool faster = vvi_pace_carried(&client->pace, client->sent.n, travel, since);
    if (client->sent.reduced && !client->moving && vvi_pace_carries(&client->pace, client->sent.whole)) {
        client->wants_whole = true;
        vvi_client_want(client, false, now);
    } else if (client->broke || (faster && client->sent.reduced && !client->moving)) {
        vvi_client_want(client, false, now);
    }
    client->broke = false;
    if (client->seconds > 0) {
        vvi_pace_took(&client->pace, client->pixels, client->seconds, travel);
        const double between = (double)(now - client->last_ack) * SECOND;
        client->rate += 0.2 * ((between > 0 && between < 1 ? 1 / between : client->rate) - client->rate);
        client->latency = client->sent.event ? (double)(now - client->sent.event) * SECOND : client->latency;
    }
    client->last_ack = now;
    return VV_OK;
}

vv_status vvi_message_frames(vvi_client *client, int64_t id, const json_t *message, int64_t now)
{
    static const char *const names[] = {
        [VVI_FRAMES_ALL] = "all", [VVI_FRAMES_RESTING] = "resting", [VVI_FRAMES_NONE] = "none"};
    const char *wanted = vvi_message_text(message, "wanted");
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
    return vvi_message_fail("frames", "wanted: all, resting or none");
}
