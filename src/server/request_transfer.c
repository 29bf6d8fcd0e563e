/* What a volume is shown with, what it could be shown with, and how that would look. */
#include "core/memory.h"
#include "io/base64.h"
#include "server/request.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <volvis/image.h>
#include <volvis/render.h>
#include <volvis/sys/scene.h>

enum { THUMBNAIL_MOST = 512, THUMBNAIL_WIDTH = 128, THUMBNAIL_HEIGHT = 96, THUMBNAIL_QUALITY = 85 };

static void put_rows(vvi_result *out, const char *key, const double *rows, size_t n, size_t columns)
{
    vvi_result_open(out, key, '[');
    for (size_t i = 0; i < n; i++)
        vvi_result_numbers(out, NULL, rows + i * columns, columns);
    vvi_result_close(out, ']');
}

/* Members "opacity", "color", "opacity_length" of a volume of the World. */
static vv_status put_transfer(vvi_result *out, vv_world *world, const char *view, const char *volume, vv_job *job)
{
    vv_scene *scene = NULL;
    vv_status st = vv_scene_resolve(&scene, world, view, job);
    if (st != VV_OK)
        return st;
    const vv_actor *actor = NULL;
    for (size_t i = 0; i < scene->n_actors && !actor; i++)
        if (!volume || strcmp(scene->actors[i].id, volume) == 0)
            actor = &scene->actors[i];
    if (actor) {
        put_rows(out, "opacity", actor->classes.opacity, actor->classes.n_opacity, 2);
        put_rows(out, "color", actor->classes.color, actor->classes.n_color, 4);
        vvi_result_number(out, "opacity_length", actor->classes.opacity_length);
    } else {
        st = vv_fail(VV_E_NOT_FOUND, "no volume '%.64s' of samples is shown", volume ? volume : "");
    }
    vv_scene_release(scene);
    return st;
}

static vv_status run_transfer(vvi_task *task, vv_job *job)
{
    vvi_request *r = (vvi_request *)(void *)task;
    vvi_result_open(&r->value, NULL, '{');
    const vv_status st = put_transfer(&r->value, r->world, r->view, r->name, job);
    vvi_result_close(&r->value, '}');
    return st;
}

vv_status vvi_request_transfer(vvi_client *client, int64_t id, const json_t *message)
{
    return vvi_request_of_volume(client, id, message, "transfer", run_transfer);
}

/* Presets on a copy ----------------------------------------------------------------------------------------------- */

static vv_status edit(vv_object **root, const char *volume, const char *property, const char *json)
{
    char path[256];
    snprintf(path, sizeof path, "volumes.%.128s.segmentation.%s", volume, property);
    return json ? vv_path_set(root, path, json, NULL) : vv_path_unset(root, path, NULL);
}

/* The id of the volume that a message names, else of the first; NULL, and an error. Borrowed of the World. */
static const char *volume_id(const vv_world *world, const char *name)
{
    const vv_dataset *dataset;
    if (!vvi_request_volume(world, name, &dataset))
        return NULL;
    return name ? name : world->volumes->entry[0].id;
}

/* The World with a preset in the place of all that says what of the volume is seen. */
static vv_status with_preset(vv_world **out, const vv_world *world, const char *volume, const vv_preset *preset)
{
    static const char *const replaced[] = {"color", "colormap", "opacity", "opacity_length", "preset"};
    const bool colors = strcmp(preset->kind, "colormap") == 0;
    vv_object *root = vv_object_retain((vv_object *)(uintptr_t)&world->base);
    char name[96], property[32];
    vv_status st = colors ? VV_OK : edit(&root, volume, "kind", "\"transfer\"");
    for (size_t i = 0; i < (colors ? 2u : 5u) && st == VV_OK; i++) {
        snprintf(property, sizeof property, "transfer.%s", replaced[i]);
        st = edit(&root, volume, property, NULL);
    }
    snprintf(name, sizeof name, "\"%.80s\"", preset->name);
    if (st == VV_OK)
        st = edit(&root, volume, colors ? "transfer.colormap" : "transfer.preset", name);
    if (st != VV_OK) {
        vv_object_release(root);
        root = NULL;
    }
    *out = (vv_world *)(void *)root;
    return st;
}

static vv_status run_proposals(vvi_task *task, vv_job *job)
{
    vvi_request *r = (vvi_request *)(void *)task;
    const char *volume = volume_id(r->world, r->name);
    const vv_preset *preset;
    vv_status st = volume ? VV_OK : VV_E_NOT_FOUND;
    vvi_result_open(&r->value, NULL, '[');
    for (size_t i = 0; st == VV_OK && (preset = vv_preset_nth(i)) != NULL; i++) {
        vv_world *world = NULL;
        if (strcmp(preset->kind, "proposal") != 0)
            continue;
        vvi_result_open(&r->value, NULL, '{');
        vvi_result_string(&r->value, "name", preset->name);
        vvi_result_string(&r->value, "doc", preset->doc);
        if ((st = with_preset(&world, r->world, volume, preset)) == VV_OK) {
            st = put_transfer(&r->value, world, r->view, volume, job);
            vv_object_release(&world->base);
        }
        vvi_result_close(&r->value, '}');
    }
    vvi_result_close(&r->value, ']');
    return st;
}

vv_status vvi_request_proposals(vvi_client *client, int64_t id, const json_t *message)
{
    return vvi_request_of_volume(client, id, message, "proposals", run_proposals);
}

/* Thumbnails ------------------------------------------------------------------------------------------------------ */

vv_status vvi_request_put_bytes(vvi_result *out, const char *key, const char *type, const uint8_t *bytes, size_t n)
{
    vvi_text text = {0};
    vvi_text_printf(&text, "data:%s;base64,", type);
    for (size_t i = 0; i < n; i += 3) {
        char group[5] = {0};
        vvi_base64_group(group, bytes + i, n - i < 3 ? n - i : 3);
        vvi_text_add(&text, group);
    }
    char *data = vvi_text_take(&text);
    if (!data)
        return vv_fail_memory(2 * n);
    vvi_result_string(out, key, data);
    free(data);
    return VV_OK;
}

static vv_status draw(vvi_request *r, vv_world *world, vv_job *job)
{
    vv_image_options options;
    vv_image *image = NULL;
    uint8_t *bytes = NULL;
    size_t n = 0;
    vv_image_options_init(&options, sizeof options);
    options.quality = THUMBNAIL_QUALITY;
    options.fast = true;
    vv_status st = vv_render(&image, NULL, world, r->view, NULL, job);
    if (st == VV_OK)
        st = vv_image_encode(&bytes, &n, ".jpg", image, &options, job);
    vvi_result_open(&r->value, NULL, '{');
    if (st == VV_OK)
        st = vvi_request_put_bytes(&r->value, "picture", "image/jpeg", bytes, n);
    vvi_result_close(&r->value, '}');
    vv_image_bytes_free(bytes);
    vv_image_release(image);
    return st;
}

/* A small picture, as moving frames are drawn, without decorations. */
static vv_status run_thumbnail(vvi_task *task, vv_job *job)
{
    vvi_request *r = (vvi_request *)(void *)task;
    const char *volume = volume_id(r->world, r->name);
    const vv_preset *preset;
    size_t i = 0;
    char path[128];
    vv_world *shown = NULL, *sized = NULL;
    if (!volume)
        return VV_E_NOT_FOUND;
    while ((preset = vv_preset_nth(i)) != NULL && strcmp(preset->name, r->parameters) != 0)
        i++;
    if (!preset)
        return vv_fail(VV_E_NOT_FOUND, "there is no preset '%.40s'", r->parameters);
    vv_status st = with_preset(&shown, r->world, volume, preset);
    if (st == VV_OK)
        st = vvi_camera_world(&sized, shown, r->view, NULL, r->pixel.x, r->pixel.y);
    if (st == VV_OK)
        st = vvi_camera_quick(&sized, r->view, 1);
    if (st == VV_OK) {
        vv_object *root = &sized->base;
        snprintf(path, sizeof path, "views.%s.decorations", r->view);
        st = vv_path_set(&root, path, VVI_NO_DECORATIONS, NULL);
        snprintf(path, sizeof path, "views.%s.render.adaptive", r->view);
        if (st == VV_OK) /* so few pixels deserve a ray each */
            st = vv_path_set(&root, path, "false", NULL);
        sized = (vv_world *)(void *)root;
    }
    if (st == VV_OK)
        st = draw(r, sized, job);
    if (shown)
        vv_object_release(&shown->base);
    if (sized)
        vv_object_release(&sized->base);
    return st;
}

vv_status vvi_request_thumbnail(vvi_client *client, int64_t id, const json_t *message)
{
    const json_t *width = json_object_get(message, "width"), *height = json_object_get(message, "height");
    const json_int_t w = width ? json_integer_value(width) : THUMBNAIL_WIDTH,
                     h = height ? json_integer_value(height) : THUMBNAIL_HEIGHT;
    vvi_request *r;
    if (!json_is_string(json_object_get(message, "preset")))
        return vv_fail(VV_E_ARGUMENT, "'thumbnail' needs a preset");
    if (w < 1 || h < 1 || w > THUMBNAIL_MOST || h > THUMBNAIL_MOST)
        return vv_fail(VV_E_ARGUMENT, "a thumbnail is 1 to %d pixels wide and high", THUMBNAIL_MOST);
    vv_status st = vvi_request_new(&r, client, id, "thumbnail", run_thumbnail);
    if (st != VV_OK)
        return st;
    r->pixel = (vv_pixel){(int32_t)w, (int32_t)h};
    if ((st = vvi_request_take_text(&r->name, message, "volume")) == VV_OK)
        st = vvi_request_take_text(&r->parameters, message, "preset");
    return vvi_request_add_quick(r, st);
}
