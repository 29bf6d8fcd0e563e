/* What an operation would make of the part of its input that is seen: the newest wish of a page counts. */
#include "core/job.h"
#include "core/memory.h"
#include "server/preview.h"
#include "server/request.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* WHOLE_MOST: voxels that are worked on without being asked, where parts cannot be made: 64 x 64 x 64. SAMPLES_MOST: of
 * a box of a view that is no slice. PIXELS_MOST: of a picture of such a view, which takes a ray for each. */
enum { WHOLE_MOST = 1 << 18, SAMPLES_MOST = 1 << 23, PIXELS_MOST = 1 << 18 };
#define PART_SECONDS 2.0

/* Answer ----------------------------------------------------------------------------------------------------------- */

static void put_three(vvi_result *out, const char *key, const int64_t v[3])
{
    vvi_result_numbers(out, key, (double[3]){(double)v[0], (double)v[1], (double)v[2]}, 3);
}

static vv_status put_picture(vvi_result *out, const char *key, const vv_image *image, vv_job *job)
{
    vv_image_options options;
    uint8_t *bytes = NULL;
    size_t n = 0;
    vv_image_options_init(&options, sizeof options);
    options.fast = true;
    vv_status st = vv_image_encode(&bytes, &n, ".png", image, &options, job);
    if (st == VV_OK)
        st = vvi_request_put_bytes(out, key, "image/png", bytes, n);
    vv_image_bytes_free(bytes);
    return st;
}

static vv_status put_preview(vvi_result *out, const vvi_preview *p, vv_job *job)
{
    vv_status st = VV_OK;
    vvi_result_open(out, NULL, '{');
    vvi_result_bool(out, "whole", p->whole);
    vvi_result_bool(out, "full", p->full);
    vvi_result_unsigned(out, "bytes", p->bytes);
    if (isfinite(p->seconds))
        vvi_result_number(out, "seconds", p->seconds);
    if (p->image && p->box.n[0] > 0) {
        put_three(out, "lo", p->box.lo);
        put_three(out, "n", p->box.n);
        put_three(out, "dims", p->info.grid.dims);
    }
    if (p->has_window)
        vvi_result_numbers(out, "window", p->window, 2);
    if (p->has_value) {
        vvi_result_number(out, "before", p->before);
        vvi_result_number(out, "after", p->after);
    }
    if (p->image)
        st = put_picture(out, "picture", p->image, job);
    if (p->image && p->input && st == VV_OK)
        st = put_picture(out, "input", p->input, job);
    vvi_result_close(out, '}');
    return st;
}

/* A step between others is compared with what it is made of, and not with what is made of that. */
static vv_status show_input(bool *changed_out, vv_world **world, const vvi_request *r)
{
    char path[VVI_REQUEST_ID + 32], name[VVI_REQUEST_ID + 32];
    const vv_volume *volume = (const vv_volume *)(const void *)vv_collection_find((*world)->volumes, r->name);
    *changed_out = volume && volume->data && strcmp(volume->data, r->dataset) != 0;
    if (!*changed_out)
        return VV_OK;
    snprintf(path, sizeof path, "volumes.%.*s.data", VVI_REQUEST_ID, r->name);
    snprintf(name, sizeof name, "\"%.*s\"", VVI_REQUEST_ID, r->dataset);
    vv_object *root = &(*world)->base;
    const vv_status st = vv_path_set(&root, path, name, NULL);
    *world = (vv_world *)(void *)root;
    return st;
}

static vv_status run(vvi_task *task, vv_job *job)
{
    vvi_request *r = (vvi_request *)(void *)task;
    vv_world *world = NULL;
    char id[VVI_REQUEST_ID];
    vvi_request_free_id(id, r->world, "preview");
    bool tells_before = false;
    vvi_job_set_modest(job); /* a guess, which no hand that turns a view waits for */
    vv_status st = vvi_request_make_world(&world, r, id);
    if (st == VV_OK)
        st = show_input(&tells_before, &world, r);
    const vvi_preview_wish wish = {.world = world,
                                   .view = r->view,
                                   .volume = r->name,
                                   .tells_before = tells_before,
                                   .made = id,
                                   .whole = r->whole,
                                   .part_s = PART_SECONDS,
                                   .whole_most = WHOLE_MOST,
                                   .samples_most = SAMPLES_MOST};
    vvi_preview preview = {0};
    if (st == VV_OK)
        st = vvi_request_fail_made(r->operation, id, vvi_preview_make(&preview, &wish, job));
    if (st == VV_OK)
        st = put_preview(&r->value, &preview, job);
    vvi_preview_finish(&preview);
    vv_object_release(&world->base);
    return st;
}

static void done(vvi_task *task, vv_status st)
{
    vvi_request *r = (vvi_request *)(void *)task;
    vvi_client *client = vvi_session_find(r->session, r->serial);
    if (client && client->preview == task->number)
        client->preview = 0;
    vvi_request_answer(r, st);
}

/* Question --------------------------------------------------------------------------------------------------------- */

/* The volume that is named, else the first visible one of these data. */
static vv_status take_volume(vvi_request *r, const char *name)
{
    const vv_collection *all = r->world->volumes;
    const char *first = r->world->datasets->n ? r->world->datasets->entry[0].id : "";
    for (size_t i = 0; i < all->n && !name; i++) {
        const vv_volume *volume = (const vv_volume *)(const void *)all->entry[i].object;
        if (volume->visible && strcmp(volume->data ? volume->data : first, r->dataset) == 0)
            name = all->entry[i].id;
    }
    if (!name)
        return vv_fail(VV_E_NOT_FOUND, "no visible volume shows '%.64s': show it to see a preview", r->dataset);
    r->name = vvi_strdup(name);
    return r->name ? VV_OK : vv_fail_memory(strlen(name));
}

/* The World with a view of the size of the page's, or a smaller one of the same shape. */
static vv_status size_world(vvi_request *r, const vvi_client *client)
{
    const vv_registry *registry = vv_runtime_registry(r->session->options.runtime);
    const double pixels = (double)client->width * client->height;
    const double scale = vvi_camera_is_plane(r->world, r->view, registry) ? 1 : fmin(sqrt(PIXELS_MOST / pixels), 1);
    vv_world *sized = NULL;
    vv_status st = vvi_camera_world(&sized, r->world, r->view, NULL, (int32_t)fmax(client->width * scale, 1),
                                    (int32_t)fmax(client->height * scale, 1));
    if (st == VV_OK)
        st = vvi_camera_scale(&sized, r->view, scale);
    vv_object_release(&r->world->base);
    r->world = sized;
    return st;
}

static vv_status take_message(vvi_request *r, const json_t *message, const vvi_client *client)
{
    r->whole = json_is_true(json_object_get(message, "whole"));
    vv_status st = vvi_request_take_inputs(r, message);
    if (st == VV_OK)
        st = vvi_request_take_parameters(r, message);
    if (st == VV_OK)
        st = take_volume(r, json_string_value(json_object_get(message, "volume")));
    return st == VV_OK ? size_world(r, client) : st;
}

void vvi_client_drop_preview(vvi_client *client)
{
    if (client->preview)
        vvi_tasks_cancel(client->session->quick, client->preview, client->serial);
    client->preview = 0;
}

vv_status vvi_request_preview(vvi_client *client, int64_t id, const json_t *message)
{
    const char *operation = json_string_value(json_object_get(message, "operation"));
    vvi_request *r;
    vvi_client_drop_preview(client);
    if (!operation)
        return vv_fail(VV_E_ARGUMENT, "'preview' needs an operation and a dataset");
    const vv_operation *row = vv_registry_operation(vv_runtime_registry(client->session->options.runtime), operation);
    if (!row)
        return VV_E_NOT_FOUND;
    vv_status st = vvi_request_new(&r, client, id, "preview", run);
    if (st != VV_OK)
        return st;
    r->operation = row;
    r->task.done = done;
    if ((st = take_message(r, message, client)) != VV_OK) {
        r->task.drop(&r->task);
        return st;
    }
    if ((st = vvi_request_add_quick(r)) == VV_OK)
        client->preview = r->task.number;
    return st;
}
