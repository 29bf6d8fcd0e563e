/* What a page draws by itself: the newest wish of a page counts, and files that several of them ask for are made once.
 */
#include "core/memory.h"
#include "server/request.h"

#include <stdlib.h>
#include <string.h>

/* FILES_MOST: that are kept for pages that were told of them and have not come yet. */
enum { BYTES = 4 << 20, BYTES_LEAST = 1 << 14, BYTES_MOST = 64 << 20, FILES_MOST = 32 };

static vv_status run(vvi_task *task, vv_job *job)
{
    vvi_request *r = (vvi_request *)(void *)task;
    return vvi_page_shape_make(&r->shape, r->world, r->view, &r->wish, job);
}

static vvi_made_file **find(vvi_session *s, int64_t number)
{
    vvi_made_file **at = &s->files;
    while (*at && (*at)->number != number)
        at = &(*at)->next;
    return at;
}

/* The newest first. */
static vv_status keep(vvi_session *s, vvi_cached **cached)
{
    const vvi_page_shape_file *made = vvi_cached_value(*cached);
    vvi_made_file **at = find(s, made->number), *file = *at;
    if (file) {
        *at = file->next;
    } else {
        file = vvi_calloc(1, sizeof *file);
        if (!file)
            return vv_fail_memory(sizeof *file);
        *file = (vvi_made_file){.number = made->number, .path = NULL, .name = vvi_strdup(made->name), .shape = *cached};
        file->path = made->path ? vvi_strdup(made->path) : NULL;
        *cached = NULL;
    }
    file->next = s->files;
    s->files = file;
    return file->name && (file->path || !made->path) ? VV_OK : vv_fail_memory(256);
}

static void drop_old(vvi_session *s)
{
    int n = 0;
    for (vvi_made_file **at = &s->files; *at;) {
        vvi_made_file *file = *at;
        if (!file->shape || ++n <= FILES_MOST) {
            at = &file->next;
            continue;
        }
        *at = file->next;
        vvi_made_file_free(file);
    }
}

static void done(vvi_task *task, vv_status st)
{
    vvi_request *r = (vvi_request *)(void *)task;
    vvi_client *client = vvi_session_find(r->session, r->serial);
    if (client && client->shape == task->number)
        client->shape = 0;
    for (size_t i = 0; i < r->shape.n && st == VV_OK; i++)
        st = keep(r->session, &r->shape.files[i]);
    drop_old(r->session);
    r->value = r->shape.text;
    r->shape.text = (vvi_result){.compact = true};
    vvi_request_answer(r, st);
}

void vvi_client_drop_shape(vvi_client *client)
{
    if (client->shape)
        vvi_tasks_cancel(client->session->quick, client->shape, client->serial);
    client->shape = 0;
}

vv_status vvi_request_shape(vvi_client *client, int64_t id, const json_t *message)
{
    const char *method = json_string_value(json_object_get(message, "method"));
    const json_t *bytes = json_object_get(message, "bytes");
    const json_int_t most = bytes ? json_integer_value(bytes) : BYTES;
    const bool boxes = method && strcmp(method, "boxes") == 0;
    const bool is_looking = client->session->options.read_only; /* it writes nothing: its files are in memory */
    vvi_request *r;
    if (!method || (!boxes && strcmp(method, "reduced") != 0))
        return vv_fail(VV_E_ARGUMENT, "a shape is drawn by method 'reduced' or 'boxes'");
    if (most < BYTES_LEAST || most > BYTES_MOST)
        return vv_fail(VV_E_ARGUMENT, "the limit of a shape is 16384 to 67108864 bytes");
    if (!client->session->uploads)
        return vv_fail(VV_E_UNSUPPORTED, "this server keeps no files, and so no shapes");
    vvi_client_drop_shape(client);
    vv_status st = vvi_request_new(&r, client, id, "shape", run);
    if (st != VV_OK)
        return st;
    if (!is_looking)
        st = vvi_files_own_folder(&r->path, client->session, "shapes");
    r->task.done = done;
    r->task.alone = true;
    r->wish = (vvi_page_shape_options){.boxes = boxes,
                                       .bytes = (size_t)(is_looking && most > BYTES ? BYTES : most),
                                       .folder = r->path,
                                       .numbers = &client->session->file_numbers};
    if ((st = vvi_request_add_quick(r, st)) == VV_OK)
        client->shape = r->task.number;
    return st;
}
