/* Messages that take time: each is a task, and its answer comes when it has ended. */
#include "core/memory.h"
#include "server/request.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* How many questions and jobs of one page may wait; LOOKING: where pages can change nothing. */
enum { QUICK = 64, QUICK_LOOKING = 32, SLOW = 16, SLOW_LOOKING = 4 };

static void drop(vvi_task *task)
{
    vvi_request *r = (vvi_request *)(void *)task;
    if (r->world)
        vv_object_release(&r->world->base);
    vv_object_release(r->params);
    vvi_text_free(&r->value.text);
    vvi_page_shape_finish(&r->shape);
    vvi_made_memory_free(&r->memory);
    if (r->own_folder && r->path)
        vvi_files_remove_empty(r->path);
    free(r->path);
    free(r->name);
    free(r->dataset);
    free(r->parameters);
    free(r->inputs);
    free(r->note);
    free(r);
}

/* The answer, to whoever asked and is still there. */
void vvi_request_answer(vvi_request *r, vv_status st)
{
    vvi_client *client = vvi_session_find(r->session, r->serial);
    if (client) {
        vvi_client_warn(client, r->task.warnings);
        vvi_client_answer_result(client, r->id, &r->value, st, r->exists ? "exists" : NULL);
    }
    vvi_text_free(&r->value.text);
}

/* Everybody sees that a job has ended. */
static void tell_end(const vvi_request *r, vv_status st)
{
    vvi_result text = {.compact = true};
    char *error = st != VV_OK ? vvi_files_sentence(r->session, vv_error_last()->message) : NULL;
    vvi_result_open(&text, NULL, '{');
    vvi_result_string(&text, "type", "job");
    vvi_result_integer(&text, "job", r->task.number);
    vvi_result_string(&text, "name", r->task.name);
    vvi_result_string(&text, "state", st == VV_OK ? "done" : st == VV_E_CANCELLED ? "cancelled" : "failed");
    if (st != VV_OK)
        vvi_result_string(&text, "error", error);
    free(error);
    vvi_result_close(&text, '}');
    vvi_session_tell(r->session, VVI_LINE_ENDED, vvi_text_take(&text.text));
}

void vvi_request_done_slowly(vvi_task *task, vv_status st)
{
    vvi_request *r = (vvi_request *)(void *)task;
    tell_end(r, st);
    vvi_request_answer(r, st);
}

static void done(vvi_task *task, vv_status st)
{
    vvi_request_answer((vvi_request *)(void *)task, st);
}

vv_status vvi_request_new(vvi_request **out, vvi_client *client, int64_t id, const char *name,
                          vv_status (*run)(vvi_task *task, vv_job *job))
{
    vvi_request *r = vvi_calloc(1, sizeof *r);
    vv_status st = r ? vvi_client_save_camera(client) : vv_fail_memory(sizeof *r);
    *out = NULL;
    if (st != VV_OK) {
        free(r);
        return st;
    }
    *r = (vvi_request){.task = {.name = name, .run = run, .done = done, .drop = drop, .owner = client->serial},
                       .session = client->session,
                       .serial = client->serial,
                       .id = id,
                       .value = {.compact = true}};
    memcpy(r->view, client->view, sizeof r->view);
    snprintf(r->task.address, sizeof r->task.address, "%s", client->address);
    r->world = vv_model_snapshot(client->session->model);
    *out = r;
    return VV_OK;
}

vv_status vvi_request_take_text(char **out, const json_t *message, const char *member)
{
    const char *text = json_string_value(json_object_get(message, member));
    *out = text ? vvi_strdup(text) : NULL;
    return *out || !text ? VV_OK : vv_fail_memory(strlen(text));
}

vv_status vvi_request_size(vvi_request *r, int32_t width, int32_t height)
{
    vv_world *sized = NULL;
    const vv_status st = vvi_camera_world(&sized, r->world, r->view, NULL, width, height);
    if (st != VV_OK)
        return st;
    vv_object_release(&r->world->base);
    r->world = sized;
    return VV_OK;
}

static vv_status add(vvi_request *r, vvi_tasks *to, int most, vv_status st)
{
    int64_t number;
    if (st == VV_OK)
        return vvi_tasks_add(&number, to, &r->task, (size_t)most);
    r->task.drop(&r->task);
    return st;
}

vv_status vvi_request_add_quick(vvi_request *r, vv_status st)
{
    return add(r, r->session->quick, r->session->options.read_only ? QUICK_LOOKING : QUICK, st);
}

vv_status vvi_request_add_slow(vvi_request *r, vv_status st)
{
    vvi_session *session = r->session;
    const bool changes = r->changes;
    st = add(r, session->slow, session->options.read_only ? SLOW_LOOKING : SLOW, st);
    if (st == VV_OK && changes) /* it is served, and freed, by this thread alone */
        r->asked = ++session->n_asked;
    return st;
}

void vvi_client_drop_jobs(const vvi_client *client)
{
    vvi_tasks_leave(client->session->slow, client->serial, SLOW);
    vvi_tasks_leave(client->session->quick, client->serial, QUICK);
}
