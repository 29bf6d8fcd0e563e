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
/* Where pages change nothing: 3840 x 2160, and a little more. */
#define PIXELS_LOOKING (INT64_C(1) << 23)
/* A larger one takes so much memory that there is only one of them at a time. */
#define PIXELS_BESIDE (INT64_C(1) << 22)

/* On the disk, or, where pages change nothing, in memory. */
static vv_status put_picture(vvi_request *r, const vv_image *image, const vv_image_options *options, vv_job *job)
{
    uint8_t *bytes = NULL;
    size_t n = 0;
    if (!r->session->options.read_only)
        return vv_image_write(r->path, image, options, job);
    vv_status st = vv_image_encode(&bytes, &n, strrchr(r->path, '.'), image, options, job);
    if (st == VV_OK)
        st = vvi_made_memory_new(&r->memory, bytes, n, job);
    vv_image_bytes_free(bytes);
    return st;
}

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
        st = put_picture(r, image, &options, job);
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
        *file = (vvi_made_file){.number = ++s->file_numbers,
                                .path = s->options.read_only ? NULL : r->path,
                                .name = r->name,
                                .memory = r->memory,
                                .serial = r->serial};
        r->path = s->options.read_only ? r->path : NULL;
        r->name = NULL;
        r->memory = (vvi_made_memory){0};
        vvi_made_files_add_picture(s, file);
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
    const vv_status st = path ? vv_path_set(&root, path, VVI_NO_DECORATIONS, NULL) : vv_fail_memory(64);
    free(path);
    *world = (vv_world *)(void *)root;
    return st;
}

static vv_status name_picture(vvi_request *r, vvi_session *s)
{
    char *folder = NULL;
    vv_status st = s->options.read_only ? VV_OK : vvi_files_make_folder(&folder, s, "picture", &s->picture_folders);
    r->own_folder = folder != NULL;
    if (st == VV_OK)
        r->path = folder ? vvi_asprintf("%s/%s", folder, r->name) : vvi_strdup(r->name);
    if (st == VV_OK && !r->path)
        st = vv_fail_memory(256);
    free(folder);
    return st;
}

vv_status vvi_request_picture(vvi_client *client, int64_t id, const json_t *message)
{
    const json_int_t w = json_integer_value(json_object_get(message, "width")),
                     h = json_integer_value(json_object_get(message, "height"));
    vvi_request *r;
    if (w < 1 || h < 1 || w > PICTURE_SIDE_MOST || h > PICTURE_SIDE_MOST)
        return vv_fail(VV_E_ARGUMENT, "a picture is 1 to %d pixels wide and high", PICTURE_SIDE_MOST);
    if (client->session->options.read_only && w * h > PIXELS_LOOKING)
        return vv_fail(VV_E_LIMIT,
                       "a picture has at most %d pixels here, as this World can only be looked at: "
                       "3840 x 2160 for instance",
                       (int)PIXELS_LOOKING);
    if (!client->session->state)
        return vv_fail(VV_E_UNSUPPORTED, "this server keeps no files, and so makes no pictures");
    vv_status st = vvi_client_fix_view(client);
    if (st != VV_OK || (st = vvi_request_new(&r, client, id, "picture", run_picture)) != VV_OK)
        return st;
    r->task.done = done_picture;
    r->task.alone = w * h > PIXELS_BESIDE;
    r->name = plain_name(json_string_value(json_object_get(message, "name")));
    st = r->name ? VV_OK : vv_fail_memory(256);
    if (st == VV_OK && !client->session->options.read_only)
        st = vvi_session_make_room(client->session, 4 * (uint64_t)(w * h));
    if (st == VV_OK)
        st = name_picture(r, client->session);
    if (st == VV_OK)
        st = vv_image_check(r->path, NULL, NULL);
    if (st == VV_OK)
        st = vv_image_check_size(r->path, (int32_t)w, (int32_t)h, NULL);
    if (st == VV_OK)
        st = vvi_request_size(r, (int32_t)w, (int32_t)h);
    if (st == VV_OK && json_is_true(json_object_get(message, "plain")))
        st = take_decorations(&r->world, r->view);
    return vvi_request_add_slow(r, st);
}
