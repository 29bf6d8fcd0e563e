/* What an operation would make of the part of its input that is seen: the newest wish of a page counts. */
#include "core/job.h"
#include "core/json_text.h"
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

/* What is made of a step between others, and shown. */
typedef struct rest {
    bool there, seen; /* else the step is seen by itself: it takes too long in full */
    double seconds;   /* that it takes; NaN: nobody knows */
} rest;

static vv_status put_preview(vvi_result *out, const vvi_preview *p, const rest *after, vv_job *job)
{
    vv_status st = VV_OK;
    const double seconds = isfinite(p->seconds) || after->seen ? p->seconds : after->seconds;
    vvi_result_open(out, NULL, '{');
    if (after->there)
        vvi_result_bool(out, "end", after->seen);
    vvi_result_bool(out, "whole", p->whole);
    vvi_result_bool(out, "full", p->full);
    vvi_result_unsigned(out, "bytes", p->bytes);
    if (isfinite(seconds))
        vvi_result_number(out, "seconds", seconds);
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

/* A step between others, by itself, is compared with what it is made of, and not with what is made of that. */
static vv_status show_input(vv_world **world, const vvi_request *r)
{
    char path[VVI_REQUEST_ID + 32], name[VVI_REQUEST_ID + 32];
    snprintf(path, sizeof path, "volumes.%.*s.data", VVI_REQUEST_ID, r->name);
    snprintf(name, sizeof name, "\"%.*s\"", VVI_REQUEST_ID, r->dataset);
    vv_object *root = &(*world)->base;
    const vv_status st = vv_path_set(&root, path, name, NULL);
    *world = (vv_world *)(void *)root;
    return st;
}

/* What takes the dataset takes what is made of it. */
static vv_status hand_on(vv_world **out, const vv_world *world, const vvi_request *r, const char *id)
{
    char name[VVI_REQUEST_ID + 4];
    size_t i;
    json_t *value, *takers = vvi_json_of_own(r->path);
    vv_object *root = vv_object_retain((vv_object *)(uintptr_t)&world->base);
    vv_status st = takers ? VV_OK : vv_fail_memory(256);
    snprintf(name, sizeof name, "\"%.*s\"", VVI_REQUEST_ID, id);
    json_array_foreach(takers, i, value)
    {
        if (st == VV_OK)
            st = vv_path_set(&root, json_string_value(value), name, NULL);
    }
    json_decref(takers);
    *out = (vv_world *)(void *)root;
    return st;
}

static const vv_volume *volume_of(const vv_world *world, const vvi_request *r)
{
    return (const vv_volume *)(const void *)vv_collection_find(world->volumes, r->name);
}

/* The end of the pipeline is what will be seen, where what comes before it is made in no more time than a part. */
static vv_status look_at_end(vvi_preview_wish *wish, rest *out, vv_world **world, vvi_request *r, vv_job *job)
{
    vv_world *edited = NULL;
    vv_status st = hand_on(&edited, *world, r, wish->made);
    const vv_volume *volume = volume_of(edited, r);
    out->there = st == VV_OK && volume && volume->data && strcmp(volume->data, wish->made) != 0;
    if (out->there && !wish->whole)
        st = vvi_preview_seconds(&out->seconds, *world, wish->made, volume->frame, job);
    out->seen = out->there && st == VV_OK && (wish->whole || out->seconds <= PART_SECONDS);
    if (out->seen) {
        wish->inserted = wish->made;
        wish->made = volume->data;
    }
    vv_object_release(out->seen ? &(*world)->base : &edited->base);
    *world = out->seen ? edited : *world;
    return st;
}

static vv_status choose(vvi_preview_wish *wish, rest *out, vv_world **world, vvi_request *r, vv_job *job)
{
    vv_status st = r->path ? look_at_end(wish, out, world, r, job) : VV_OK;
    const vv_volume *volume = volume_of(*world, r);
    wish->tells_before = !out->seen && volume && volume->data && strcmp(volume->data, r->dataset) != 0;
    if (st == VV_OK && wish->tells_before)
        st = show_input(world, r);
    wish->world = *world;
    return st;
}

static vv_status run(vvi_task *task, vv_job *job)
{
    vvi_request *r = (vvi_request *)(void *)task;
    vv_world *world = NULL;
    char id[VVI_REQUEST_ID];
    vvi_request_free_id(id, r->world, "preview");
    vvi_job_set_modest(job); /* a guess, which no hand that turns a view waits for */
    rest after = {.seconds = NAN};
    vvi_preview_wish wish = {.view = r->view,
                             .volume = r->name,
                             .made = id,
                             .whole = r->whole,
                             .part_s = PART_SECONDS,
                             .whole_most = WHOLE_MOST,
                             .samples_most = SAMPLES_MOST};
    vvi_preview preview = {0};
    vv_status st = vvi_request_make_world(&world, r, id);
    if (st == VV_OK)
        st = choose(&wish, &after, &world, r, job);
    if (st == VV_OK)
        st = vvi_preview_make(&preview, &wish, job);
    st = vvi_request_fail_made(r->operation, id, st);
    if (st == VV_OK)
        st = put_preview(&r->value, &preview, &after, job);
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
    for (size_t i = 0; i < r->world->volumes->n && !name; i++) {
        const vv_volume *volume = vvi_volume_nth(r->world, i);
        const char *id = vvi_volume_dataset_id(r->world, volume);
        if (volume->visible && id && strcmp(id, r->dataset) == 0)
            name = r->world->volumes->entry[i].id;
    }
    if (!name)
        return vv_fail(VV_E_NOT_FOUND, "no visible volume shows '%.64s': show it to see a preview", r->dataset);
    r->name = vvi_strdup(name);
    return r->name ? VV_OK : vv_fail_memory(strlen(name));
}

/* The World with a view from where the page stands, of its size, or a smaller one of the same shape. */
static vv_status size_world(vvi_request *r, const vvi_client *client)
{
    const vv_registry *registry = vv_runtime_registry(r->session->options.runtime);
    const double pixels = (double)client->width * client->height;
    const double scale = vvi_camera_is_plane(r->world, r->view, registry) ? 1 : fmin(sqrt(PIXELS_MOST / pixels), 1);
    const vvi_pose *pose = client->has_stand ? &vvi_input_device(client->input)->slot[0].pose : NULL;
    vv_world *sized = NULL;
    vv_status st = vvi_camera_world(&sized, r->world, r->view, pose, (int32_t)fmax(client->width * scale, 1),
                                    (int32_t)fmax(client->height * scale, 1));
    if (st == VV_OK)
        st = vvi_camera_scale(&sized, r->view, scale);
    vv_object_release(&r->world->base);
    r->world = sized;
    return st;
}

/* Paths of what takes the dataset now, and will take the result. */
static vv_status take_takers(vvi_request *r, const json_t *takers)
{
    size_t i;
    json_t *value;
    if (!takers)
        return VV_OK;
    if (!json_is_array(takers))
        return vv_fail(VV_E_ARGUMENT, "'takers' must be a list of paths: [\"datasets.smooth.inputs.volume\"]");
    json_array_foreach(takers, i, value)
    {
        if (!json_is_string(value))
            return vv_fail(VV_E_ARGUMENT, "'takers': entry %zu must be a path, such as volumes.head.data", i + 1);
    }
    r->path = vvi_json_encode(takers, JSON_COMPACT);
    return r->path ? VV_OK : vv_fail_memory(256);
}

static vv_status take_message(vvi_request *r, const json_t *message, const vvi_client *client)
{
    r->whole = json_is_true(json_object_get(message, "whole"));
    vv_status st = vvi_request_take_operation(r, message);
    if (st == VV_OK)
        st = take_takers(r, json_object_get(message, "takers"));
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
    vvi_request *r;
    vvi_client_drop_preview(client);
    vv_status st = vvi_request_new(&r, client, id, "preview", run);
    if (st != VV_OK)
        return st;
    r->task.done = done;
    if ((st = vvi_request_add_quick(r, take_message(r, message, client))) == VV_OK)
        client->preview = r->task.number;
    return st;
}
