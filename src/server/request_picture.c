/* The view as a file of any size, with its recipe. */
#include "core/memory.h"
#include "render/recipe.h"
#include "server/request.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <volvis/render.h>

enum { PICTURE_SIDE_MOST = 32768 /* as views have */ };

static vv_status write_picture(vvi_request *r, const vv_image *image, vv_job *job)
{
    vvi_recipe recipe = {.bits = 8};
    vv_image_options options;
    vv_world *fixed = NULL;
    vv_text *text = NULL;
    size_t n = 0;
    memcpy(recipe.view, r->view, sizeof r->view);
    vv_status st = vvi_recipe_fix(&fixed, r->world, r->view, job);
    if (st == VV_OK)
        st = vvi_recipe_text(&text, &n, fixed, &recipe, "-");
    if (st == VV_OK) {
        vv_image_options_init(&options, sizeof options);
        options.text = text;
        options.n_text = n;
        st = vv_image_write(r->path, image, &options, job);
        vv_text_free(text, n);
    }
    if (fixed)
        vv_object_release(&fixed->base);
    return st;
}

static vv_status run_picture(vvi_task *task, vv_job *job)
{
    vvi_request *r = (vvi_request *)(void *)task;
    vv_image *image = NULL;
    vv_status st = vv_render(&image, NULL, r->world, r->view, NULL, job);
    if (st == VV_OK)
        st = write_picture(r, image, job);
    vv_image_release(image);
    return st;
}

static void done_picture(vvi_task *task, vv_status st)
{
    vvi_request *r = (vvi_request *)(void *)task;
    vvi_session *s = r->session;
    vvi_made_file *file = st == VV_OK ? vvi_calloc(1, sizeof *file) : NULL;
    if (st == VV_OK && !file)
        st = vv_fail_memory(sizeof *file);
    if (file) {
        *file = (vvi_made_file){.next = s->files, .number = ++s->file_numbers, .path = r->path, .name = r->name};
        s->files = file;
        r->path = r->name = NULL;
        char url[256];
        snprintf(url, sizeof url, "/files/%" PRId64 "/%.200s", file->number, file->name);
        vvi_result_open(&r->value, NULL, '{');
        vvi_result_string(&r->value, "url", url);
        vvi_result_close(&r->value, '}');
    }
    vvi_request_done_slowly(task, st);
}

/* A name without folders and without what addresses would need written otherwise. */
static char *plain_name(const char *name)
{
    const char *slash = name ? strrchr(name, '/') : NULL;
    char *plain = vvi_strdup(slash ? slash + 1 : name && *name ? name : "volvis.png");
    for (char *c = plain; c && *c; c++)
        if (!((*c >= 'a' && *c <= 'z') || (*c >= 'A' && *c <= 'Z') || (*c >= '0' && *c <= '9') || *c == '-' ||
              *c == '_' || (*c == '.' && c != plain)))
            *c = '_';
    return plain;
}

/* The data alone. */
static vv_status take_decorations(vv_world **world, const char *view)
{
    vv_object *root = &(*world)->base;
    char *path = vvi_asprintf("views.%s.decorations", view);
    const vv_status st = path ? vv_path_unset(&root, path, NULL) : vv_fail_memory(64);
    free(path);
    *world = (vv_world *)(void *)root;
    return st;
}

vv_status vvi_request_picture(vvi_client *client, int64_t id, const json_t *message)
{
    const json_int_t w = json_integer_value(json_object_get(message, "width")),
                     h = json_integer_value(json_object_get(message, "height"));
    vvi_request *r;
    if (w < 1 || h < 1 || w > PICTURE_SIDE_MOST || h > PICTURE_SIDE_MOST)
        return vv_fail(VV_E_ARGUMENT, "a picture is 1 to %d pixels wide and high", PICTURE_SIDE_MOST);
    if (!client->session->state)
        return vv_fail(VV_E_UNSUPPORTED, "this server keeps no files, and so makes no pictures");
    vv_status st = vvi_client_fix_view(client);
    if (st != VV_OK || (st = vvi_request_new(&r, client, id, "picture", run_picture)) != VV_OK)
        return st;
    vv_world *sized = NULL;
    r->task.done = done_picture;
    r->name = plain_name(json_string_value(json_object_get(message, "name")));
    r->path =
        r->name ? vvi_asprintf("%s/%" PRId64 "-%s", client->session->uploads, ++client->session->file_numbers, r->name)
                : NULL;
    st = r->path ? vv_image_check(r->path, NULL, NULL) : vv_fail_memory(256);
    if (st == VV_OK)
        st = vv_image_check_size(r->path, (int32_t)w, (int32_t)h, NULL);
    if (st == VV_OK)
        st = vvi_camera_world(&sized, r->world, r->view, NULL, (int32_t)w, (int32_t)h);
    if (st == VV_OK && json_is_true(json_object_get(message, "plain")))
        st = take_decorations(&sized, r->view);
    if (st != VV_OK) {
        if (sized)
            vv_object_release(&sized->base);
        r->task.drop(&r->task);
        return st;
    }
    vv_object_release(&r->world->base);
    r->world = sized;
    return vvi_request_add_slow(r);
}
