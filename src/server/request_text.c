/* The World in words, for people who do not see it and for those who repeat it. */
#include "core/memory.h"
#include "model/merge.h"
#include "server/request.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <volvis/sys/scene.h>

static void put_text(vvi_request *r, vvi_text *text)
{
    char *s = vvi_text_take(text);
    vvi_result_open(&r->value, NULL, '{');
    vvi_result_string(&r->value, "text", s ? s : "");
    vvi_result_close(&r->value, '}');
    free(s);
}

static vv_status ask(vvi_client *client, int64_t id, const char *name, vv_status (*run)(vvi_task *task, vv_job *job))
{
    vvi_request *r;
    const vv_status st = vvi_request_new(&r, client, id, name, run);
    return st == VV_OK ? vvi_request_add_quick(r) : st;
}

/* In words -------------------------------------------------------------------------------------------------------- */

static void describe_actor(vvi_text *out, const vv_actor *a, const char *unit)
{
    const vv_grid *g = &vv_field_get_info(a->field)->grid;
    const vv_statistics *s = a->statistics;
    vvi_text_printf(out, " Volume %s has %lld by %lld by %lld samples", a->id, (long long)g->dims[0],
                    (long long)g->dims[1], (long long)g->dims[2]);
    vvi_text_printf(out, " over %.4g by %.4g by %.4g %s",
                    vvi_length(a->index_to_world.axis[0]) * (double)(g->dims[0] - 1),
                    vvi_length(a->index_to_world.axis[1]) * (double)(g->dims[1] - 1),
                    vvi_length(a->index_to_world.axis[2]) * (double)(g->dims[2] - 1), unit);
    if (s)
        vvi_text_printf(out, "; its values go from %.6g to %.6g, their mean is %.6g", s->min, s->max, s->mean);
    if (a->classes.kind == VV_SEGMENT_THRESHOLD)
        vvi_text_printf(out, "; shown are those from %.6g to %.6g", a->classes.lo, a->classes.hi);
    if (a->n_planes)
        vvi_text_printf(out, "; %zu plane%s cut it", a->n_planes, a->n_planes == 1 ? "" : "s");
    vvi_text_add(out, ".");
}

static void describe_camera(vvi_text *out, const vv_scene *scene, const char *unit)
{
    const vv_lens *l = &scene->lens;
    vvi_text_printf(out, " One looks in %s from %.5g, %.5g, %.5g %s along %.3g, %.3g, %.3g.",
                    l->parallel ? "parallel projection" : "perspective", l->eye.x, l->eye.y, l->eye.z, unit,
                    l->forward.x, l->forward.y, l->forward.z);
}

static vv_status run_describe(vvi_task *task, vv_job *job)
{
    vvi_request *r = (vvi_request *)(void *)task;
    const char *unit = r->world->unit ? r->world->unit : "voxels";
    vv_scene *scene = NULL;
    vvi_text text = {0};
    vvi_text_printf(&text, "%s%s%zu volume%s, drawn by ", r->world->title ? r->world->title : "",
                    r->world->title ? ": " : "", r->world->volumes->n, r->world->volumes->n == 1 ? "" : "s");
    if (r->world->volumes->n == 0) {
        vvi_text_free(&text);
        vvi_text_add(&text, "The World is empty.");
        put_text(r, &text);
        return VV_OK;
    }
    const vv_status st = vv_scene_resolve(&scene, r->world, r->view, job);
    if (st != VV_OK) {
        vvi_text_free(&text);
        return st;
    }
    vvi_text_printf(&text, "%s.", scene->renderer->name);
    for (size_t i = 0; i < scene->n_actors; i++)
        describe_actor(&text, &scene->actors[i], unit);
    for (size_t i = 0; i < scene->n_shapes; i++)
        vvi_text_printf(&text, " Mesh %s.", scene->shapes[i].look.id);
    describe_camera(&text, scene, unit);
    vv_scene_release(scene);
    put_text(r, &text);
    return VV_OK;
}

vv_status vvi_request_describe(vvi_client *client, int64_t id, const json_t *message)
{
    (void)message;
    return ask(client, id, "describe", run_describe);
}

/* As a command line ----------------------------------------------------------------------------------------------- */

typedef struct comparing {
    const vv_object *now, *before;
    vvi_text *out;
    char whole[256]; /* a list or map that was set as a whole: what is below it is told already */
} comparing;

static void quote(vvi_text *out, const char *s)
{
    vvi_text_add(out, "'");
    for (; *s; s++)
        vvi_text_add(out, *s == '\'' ? "'\\''" : (char[2]){*s, 0});
    vvi_text_add(out, "'");
}

static void put_set(comparing *c, const char *path, const char *json)
{
    vvi_text assignment = {0};
    vvi_text_printf(&assignment, "%s=%s", path, json);
    vvi_text_add(c->out, " --set ");
    quote(c->out, assignment.bad || !assignment.s ? "" : assignment.s);
    vvi_text_free(&assignment);
}

static bool compare(void *user, const char *path, const vv_property *row, const vv_object *owner)
{
    comparing *c = user;
    const size_t n = strlen(c->whole);
    char *now = NULL, *before = NULL;
    const bool holds = row->kind == VV_KIND_OBJECT || row->kind == VV_KIND_VARIANTS || row->kind == VV_KIND_MAP;
    if (strncmp(path, "datasets", 8) == 0 || strncmp(path, "measurements", 12) == 0 || holds ||
        (n && strncmp(path, c->whole, n) == 0 && path[n] == '.') || !vv_object_is_set(owner, row->name))
        return true;
    if (vv_path_get(&now, c->now, path) == VV_OK &&
        (vv_path_get(&before, c->before, path) != VV_OK || strcmp(now, before) != 0)) {
        put_set(c, path, now);
        if (row->kind == VV_KIND_LIST && strlen(path) < sizeof c->whole)
            memcpy(c->whole, path, strlen(path) + 1);
    }
    free(now);
    free(before);
    return true;
}

static vv_status base_world(vv_world **out, const vv_dataset *dataset, vv_job *job)
{
    vv_read_options options;
    if (vv_dataset_is_mesh(dataset, job))
        return vvi_world_for_mesh(out, dataset->path, dataset->format, job);
    vv_read_options_init(&options, sizeof options);
    options.format = dataset->format;
    options.part = dataset->part;
    options.raw = dataset->raw;
    return vv_world_for_file(out, dataset->path, &options, job);
}

static vv_status run_command(vvi_task *task, vv_job *job)
{
    vvi_request *r = (vvi_request *)(void *)task;
    const vv_collection *all = r->world->datasets;
    const vv_dataset *dataset = all->n == 1 ? (const vv_dataset *)(const void *)all->entry[0].object : NULL;
    vv_world *before = NULL;
    vvi_text text = {0};
    if (!dataset || !dataset->path) {
        vvi_text_add(&text, "volvis render scene.vv.json -o picture.png # after saving the World as scene.vv.json");
        put_text(r, &text);
        return VV_OK;
    }
    const vv_status st = base_world(&before, dataset, job);
    if (st != VV_OK)
        return st;
    comparing c = {.now = &r->world->base, .before = &before->base, .out = &text};
    vvi_text_add(&text, "volvis render ");
    quote(&text, dataset->path);
    vvi_text_add(&text, " -o picture.png");
    if (strcmp(r->view, "main") != 0) {
        vvi_text_add(&text, " --view ");
        quote(&text, r->view);
    }
    vv_path_each(&r->world->base, compare, &c);
    vv_object_release(&before->base);
    put_text(r, &text);
    return VV_OK;
}

vv_status vvi_request_command(vvi_client *client, int64_t id, const json_t *message)
{
    (void)message;
    return ask(client, id, "command", run_command);
}
