/* Messages that take time: each is a task, and its answer comes when it has ended. */
#include "core/job.h"
#include "core/memory.h"
#include "io/mesh_file.h"
#include "model/file_path.h"
#include "model/merge.h"
#include "render/recipe.h"
#include "server/request.h"
#include "server/samples.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <volvis/pick.h>
#include <volvis/render.h>

enum { PICTURE_SIDE_MOST = 16384 };

static void drop(vvi_task *task)
{
    vvi_request *r = (vvi_request *)(void *)task;
    if (r->world)
        vv_object_release(&r->world->base);
    vv_object_release(r->params);
    vvi_text_free(&r->value.text);
    vvi_page_shape_finish(&r->shape);
    free(r->path);
    free(r->name);
    free(r->dataset);
    free(r->parameters);
    free(r);
}

/* The answer, to whoever asked and is still there. */
void vvi_request_answer(vvi_request *r, vv_status st)
{
    vvi_client *client = vvi_session_find(r->session, r->serial);
    char *value = vvi_text_take(&r->value.text);
    if (client && st == VV_OK)
        vvi_client_answer(client, r->id, value && *value ? value : NULL);
    else if (client)
        vvi_client_refuse(client, r->id);
    free(value);
}

/* Everybody sees that a job has ended. */
static void tell_end(const vvi_request *r, vv_status st)
{
    vvi_result text = {.compact = true};
    vvi_result_open(&text, NULL, '{');
    vvi_result_string(&text, "type", "job");
    vvi_result_integer(&text, "job", r->task.number);
    vvi_result_string(&text, "name", r->task.name);
    vvi_result_string(&text, "state", st == VV_OK ? "done" : st == VV_E_CANCELLED ? "cancelled" : "failed");
    if (st != VV_OK)
        vvi_result_string(&text, "error", vv_error_last()->message);
    vvi_result_close(&text, '}');
    vvi_session_tell(r->session, VVI_LINE_KEPT, vvi_text_take(&text.text));
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
    *r = (vvi_request){.task = {.name = name, .run = run, .done = done, .drop = drop},
                       .session = client->session,
                       .serial = client->serial,
                       .id = id,
                       .value = {.compact = true}};
    memcpy(r->view, client->view, sizeof r->view);
    r->world = vv_model_snapshot(client->session->model);
    *out = r;
    return VV_OK;
}

vv_status vvi_request_add_quick(vvi_request *r)
{
    int64_t number;
    return vvi_tasks_add(&number, r->session->quick, &r->task);
}

vv_status vvi_request_add_slow(vvi_request *r)
{
    int64_t number;
    return vvi_tasks_add(&number, r->session->slow, &r->task);
}

/* Opening --------------------------------------------------------------------------------------------------------- */

static bool is_scene(const char *path)
{
    const size_t n = strlen(path);
    return n > 8 && strcmp(path + n - 8, ".vv.json") == 0;
}

static vv_status world_of(vv_world **out, const char *path, vv_job *job)
{
    vvi_recipe recipe;
    vv_text *text = NULL;
    size_t n = 0;
    if (is_scene(path))
        return vv_scene_read(out, path, job);
    if (vvi_mesh_is_file(path, vvi_job_registry(job)))
        return vvi_world_for_mesh(out, path, NULL, job);
    if (vv_image_read_text(&text, &n, path, job) == VV_OK) {
        const bool ours = vvi_recipe_is_missing(path, job) == false;
        vv_text_free(text, n);
        if (ours)
            return vvi_recipe_read(out, &recipe, path, job);
    }
    return vv_world_for_file(out, path, NULL, job);
}

static vv_status run_open(vvi_task *task, vv_job *job)
{
    vvi_request *r = (vvi_request *)(void *)task;
    vv_world *made = NULL;
    vv_status st = world_of(&made, r->path, job);
    if (st == VV_OK && r->add)
        st = vvi_world_merge(&r->world, made, job);
    if (st == VV_OK && !r->add) {
        vv_object_release(&r->world->base);
        r->world = made;
        made = NULL;
    }
    if (made)
        vv_object_release(&made->base);
    return st;
}

static void done_open(vvi_task *task, vv_status st)
{
    vvi_request *r = (vvi_request *)(void *)task;
    vvi_session_note_end(r->session);
    if (st == VV_OK)
        st = vvi_session_check_files(r->session, r->world);
    if (st == VV_OK)
        st = vvi_session_replace(r->session, r->view, r->world);
    vvi_request_done_slowly(task, st);
}

vv_status vvi_request_open(vvi_client *client, int64_t id, const json_t *message)
{
    const char *path = json_string_value(json_object_get(message, "path"));
    vvi_request *r;
    if (!path)
        return vv_fail(VV_E_ARGUMENT, "what is to be opened? 'open' needs a path");
    vv_status st = vvi_request_new(&r, client, id, "open", run_open);
    if (st != VV_OK)
        return st;
    r->add = json_is_true(json_object_get(message, "add")) && r->world->volumes->n > 0;
    r->task.done = done_open;
    if ((st = vvi_files_resolve(&r->path, client->session, path, false)) != VV_OK) {
        drop(&r->task);
        return st;
    }
    return vvi_request_add_slow(r);
}

enum { SAMPLE_SIDE = 128 };

static vv_status run_sample(vvi_task *task, vv_job *job)
{
    vvi_request *r = (vvi_request *)(void *)task;
    vv_field *field = NULL;
    vv_world *made = NULL;
    vv_status st = vvi_sample_make(&field, vvi_sample_find(r->name), SAMPLE_SIDE, job);
    if (st == VV_OK)
        st = vv_field_write(r->path, (const vv_field *const *)&field, 1, NULL, job);
    vv_field_release(field);
    if (st == VV_OK)
        st = vv_world_for_file(&made, r->path, NULL, job);
    if (st == VV_OK) {
        vv_object_release(&r->world->base);
        r->world = made;
    }
    return st;
}

vv_status vvi_request_sample(vvi_client *client, int64_t id, const json_t *message)
{
    const char *name = json_string_value(json_object_get(message, "name"));
    vvi_request *r;
    if (!vvi_sample_find(name))
        return vv_fail(VV_E_NOT_FOUND, "there is no sample '%.40s'", name ? name : "");
    if (!client->session->uploads)
        return vv_fail(VV_E_UNSUPPORTED, "this server keeps no files, and so no samples");
    const vv_status st = vvi_request_new(&r, client, id, "sample", run_sample);
    if (st != VV_OK)
        return st;
    r->task.done = done_open;
    r->name = vvi_strdup(name);
    r->path = vvi_asprintf("%s/%s.nrrd", client->session->uploads, name);
    if (r->name && r->path)
        return vvi_request_add_slow(r);
    drop(&r->task);
    return vv_fail_memory(256);
}

/* Saving ---------------------------------------------------------------------------------------------------------- */

static vv_status run_save(vvi_task *task, vv_job *job)
{
    vvi_request *r = (vvi_request *)(void *)task;
    const vv_status st = vv_scene_write(r->path, r->world, job);
    if (st == VV_OK) {
        vvi_files_keep(r->session, r->world);
        vvi_result_open(&r->value, NULL, '{');
        vvi_result_string(&r->value, "path", r->path);
        vvi_result_close(&r->value, '}');
    }
    return st;
}

vv_status vvi_request_save(vvi_client *client, int64_t id, const json_t *message)
{
    const char *path = json_string_value(json_object_get(message, "path"));
    vvi_request *r;
    if (!path || !*path)
        return vv_fail(VV_E_ARGUMENT, "where to? 'save' needs a path");
    vv_status st = VV_OK;
    for (vvi_client *c = client->session->clients; c && st == VV_OK; c = c->next)
        st = vvi_client_fix_view(c);
    if (st != VV_OK || (st = vvi_request_new(&r, client, id, "save", run_save)) != VV_OK)
        return st;
    char *full = is_scene(path) ? vvi_strdup(path) : vvi_asprintf("%s.vv.json", path);
    st = full ? vvi_files_resolve(&r->path, client->session, full, true) : vv_fail_memory(strlen(path));
    free(full);
    if (st != VV_OK) {
        drop(&r->task);
        return st;
    }
    return vvi_request_add_quick(r);
}

/* Pictures -------------------------------------------------------------------------------------------------------- */

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
        return vv_fail(VV_E_UNSUPPORTED, "this server keeps no files, and so no pictures");
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
        st = vvi_camera_world(&sized, r->world, r->view, NULL, (int32_t)w, (int32_t)h);
    if (st == VV_OK && json_is_true(json_object_get(message, "plain")))
        st = take_decorations(&sized, r->view);
    if (st != VV_OK) {
        if (sized)
            vv_object_release(&sized->base);
        drop(&r->task);
        return st;
    }
    vv_object_release(&r->world->base);
    r->world = sized;
    return vvi_request_add_slow(r);
}

/* Questions ------------------------------------------------------------------------------------------------------- */

static void put_vector(vvi_result *out, const char *key, vv_vec3 v)
{
    vvi_result_numbers(out, key, (double[3]){v.x, v.y, v.z}, 3);
}

static vv_status run_pick(vvi_task *task, vv_job *job)
{
    vvi_request *r = (vvi_request *)(void *)task;
    const char *unit = r->world->unit ? r->world->unit : "voxels";
    char text[256] = "nothing there";
    vv_picked p;
    const vv_status st = vv_pick(&p, &r->pixel, 1, r->world, r->view, job);
    if (st != VV_OK)
        return st;
    vvi_result *out = &r->value;
    vvi_result_open(out, NULL, '{');
    vvi_result_bool(out, "hit", p.hit);
    if (p.hit) {
        vvi_result_string(out, "volume", p.volume);
        put_vector(out, "position", p.world);
        put_vector(out, "index", p.index);
        vvi_result_number(out, "value", p.volume ? p.value : (double)NAN);
        vvi_result_string(out, "unit", unit);
        vvi_result_number(out, "depth", p.depth);
        snprintf(text, sizeof text, "%s%.64s at %.5g, %.5g, %.5g %s", p.volume ? "" : "a thing ",
                 p.volume ? p.volume : "", p.world.x, p.world.y, p.world.z, unit);
        const size_t n = strlen(text);
        if (p.volume && isfinite(p.value))
            snprintf(text + n, sizeof text - n, ": %.6g", p.value);
    }
    vvi_result_string(out, "text", text);
    vvi_result_close(out, '}');
    return VV_OK;
}

vv_status vvi_request_pick(vvi_client *client, int64_t id, const json_t *message)
{
    const double x = json_number_value(json_object_get(message, "x")),
                 y = json_number_value(json_object_get(message, "y"));
    vvi_request *r;
    if (!(x >= 0 && x <= 1 && y >= 0 && y <= 1))
        return vv_fail(VV_E_ARGUMENT, "a pick is at x and y from 0 to 1");
    vv_status st = vvi_request_new(&r, client, id, "pick", run_pick);
    if (st != VV_OK)
        return st;
    vv_world *sized = NULL;
    if ((st = vvi_camera_world(&sized, r->world, r->view, NULL, client->width, client->height)) != VV_OK) {
        drop(&r->task);
        return st;
    }
    vv_object_release(&r->world->base);
    r->world = sized;
    r->pixel = (vv_pixel){(int32_t)fmin(x * client->width, client->width - 1),
                          (int32_t)fmin(y * client->height, client->height - 1)};
    return vvi_request_add_quick(r);
}

/* The volume that a message names, else the first; NULL, and an error. */
const vv_volume *vvi_request_volume(const vv_world *world, const char *id, const vv_dataset **dataset_out)
{
    const vv_object *found = id                  ? vv_collection_find(world->volumes, id)
                             : world->volumes->n ? world->volumes->entry[0].object
                                                 : NULL;
    const vv_volume *volume = (const vv_volume *)(const void *)found;
    const vv_collection *all = world->datasets;
    const vv_object *data = !volume        ? NULL
                            : volume->data ? vv_collection_find(all, volume->data)
                            : all->n       ? all->entry[0].object
                                           : NULL;
    *dataset_out = (const vv_dataset *)(const void *)data;
    if (!volume || !data)
        vv_fail(VV_E_NOT_FOUND, "there is no volume '%.64s' with data", id ? id : "");
    return volume && data ? volume : NULL;
}

static void put_statistics(vvi_result *out, const vv_statistics *s, const char *unit)
{
    vvi_result_open(out, NULL, '{');
    vvi_result_number(out, "lo", s->histogram_lo);
    vvi_result_number(out, "hi", s->histogram_hi);
    vvi_result_open(out, "counts", '[');
    for (int i = 0; i < s->n_bins; i++)
        vvi_result_unsigned(out, NULL, s->histogram[i]);
    vvi_result_close(out, ']');
    vvi_result_string(out, "unit", unit);
    vvi_result_number(out, "min", s->min);
    vvi_result_number(out, "max", s->max);
    vvi_result_number(out, "mean", s->mean);
    vvi_result_number(out, "deviation", s->deviation);
    vvi_result_unsigned(out, "n", s->count);
    vvi_result_open(out, "percentiles", '{');
    vvi_result_number(out, "1", s->percentile[1]);
    vvi_result_number(out, "50", s->percentile[2]);
    vvi_result_number(out, "99", s->percentile[3]);
    vvi_result_close(out, '}');
    vvi_result_close(out, '}');
}

static vv_status run_histogram(vvi_task *task, vv_job *job)
{
    vvi_request *r = (vvi_request *)(void *)task;
    const vv_dataset *dataset;
    const vv_volume *volume = vvi_request_volume(r->world, r->name, &dataset);
    vv_field *field = NULL;
    vv_statistics *s = volume ? vvi_calloc(1, sizeof *s) : NULL;
    if (!volume)
        return VV_E_NOT_FOUND;
    if (!s)
        return vv_fail_memory(sizeof *s);
    vv_status st = vv_dataset_field(&field, dataset, volume->attribute, volume->frame, job);
    if (st == VV_OK)
        st = vv_field_statistics(s, field, (int)volume->component, job);
    if (st == VV_OK)
        put_statistics(&r->value, s, vv_field_get_info(field)->value_unit);
    vv_field_release(field);
    free(s);
    return st;
}

vv_status vvi_request_of_volume(vvi_client *client, int64_t id, const json_t *message, const char *name,
                                vv_status (*run)(vvi_task *task, vv_job *job))
{
    const char *volume = json_string_value(json_object_get(message, "volume"));
    vvi_request *r;
    const vv_status st = vvi_request_new(&r, client, id, name, run);
    if (st != VV_OK)
        return st;
    r->name = volume ? vvi_strdup(volume) : NULL;
    return vvi_request_add_quick(r);
}

vv_status vvi_request_histogram(vvi_client *client, int64_t id, const json_t *message)
{
    return vvi_request_of_volume(client, id, message, "histogram", run_histogram);
}

static vv_status run_info(vvi_task *task, vv_job *job)
{
    vvi_request *r = (vvi_request *)(void *)task;
    const vv_dataset *dataset = (const vv_dataset *)(const void *)vv_collection_find(r->world->datasets, r->name);
    vv_field_info info;
    char letters[16];
    uint64_t bytes = 0;
    if (!dataset)
        return vv_fail(VV_E_NOT_FOUND, "there is no dataset '%.64s'", r->name);
    vv_status st = vv_dataset_info(&info, dataset, job);
    if (st == VV_OK)
        st = vv_field_info_bytes(&bytes, &info);
    if (st != VV_OK)
        return st;
    const double dims[3] = {(double)info.grid.dims[0], (double)info.grid.dims[1], (double)info.grid.dims[2]};
    const vv_vec3 *axis = info.grid.index_to_world.axis;
    const double spacing[3] = {vvi_length(axis[0]), vvi_length(axis[1]), vvi_length(axis[2])};
    vv_grid_orientation(letters, &info.grid);
    vvi_result_open(&r->value, NULL, '{');
    vvi_result_numbers(&r->value, "dims", dims, 3);
    vvi_result_numbers(&r->value, "spacing", spacing, 3);
    put_vector(&r->value, "origin", info.grid.index_to_world.origin);
    vvi_result_open(&r->value, "directions", '[');
    for (int a = 0; a < 3; a++)
        put_vector(&r->value, NULL, vvi_scaled(axis[a], 1 / spacing[a]));
    vvi_result_close(&r->value, ']');
    vvi_result_string(&r->value, "unit", info.grid.unit);
    vvi_result_string(&r->value, "type", vv_type_name(info.type));
    vvi_result_integer(&r->value, "components", info.components);
    vvi_result_string(&r->value, "orientation", letters);
    vvi_result_string(&r->value, "path", dataset->path);
    vvi_result_unsigned(&r->value, "memory_bytes", bytes);
    vvi_result_close(&r->value, '}');
    return VV_OK;
}

vv_status vvi_request_info(vvi_client *client, int64_t id, const json_t *message)
{
    const char *dataset = json_string_value(json_object_get(message, "dataset"));
    vvi_request *r;
    if (!dataset)
        return vv_fail(VV_E_ARGUMENT, "'info' needs a dataset");
    const vv_status st = vvi_request_new(&r, client, id, "info", run_info);
    if (st != VV_OK)
        return st;
    r->name = vvi_strdup(dataset);
    return vvi_request_add_quick(r);
}
