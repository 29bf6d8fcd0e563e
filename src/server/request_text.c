/* The World in words, for people who do not see it. */
#include "core/memory.h"
#include "server/request.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <volvis/sys/scene.h>

void vvi_request_tell_text(vvi_request *r, vvi_text *text)
{
    char *s = vvi_text_take(text);
    vvi_result_open(&r->value, NULL, '{');
    vvi_result_string(&r->value, "text", s);
    r->value.text.bad |= !s;
    vvi_result_close(&r->value, '}');
    free(s);
}

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
        vvi_text_printf(out, "; those from %.6g to %.6g are shown", a->classes.lo, a->classes.hi);
    if (a->n_planes)
        vvi_text_printf(out, "; %zu plane%s cut it", a->n_planes, a->n_planes == 1 ? "" : "s");
    vvi_text_add(out, ".");
}

static void describe_camera(vvi_text *out, const vv_scene *scene, const char *unit)
{
    const vv_lens *l = &scene->lens;
    vvi_text_printf(out, " It is seen in %s from %.5g, %.5g, %.5g %s along %.3g, %.3g, %.3g.",
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
        vvi_request_tell_text(r, &text);
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
    for (size_t i = 0; i < scene->n_mesh_actors; i++)
        vvi_text_printf(&text, " Mesh %s.", scene->mesh_actors[i].look.id);
    describe_camera(&text, scene, unit);
    vv_scene_release(scene);
    vvi_request_tell_text(r, &text);
    return VV_OK;
}

vv_status vvi_request_describe(vvi_client *client, int64_t id, const json_t *message)
{
    vvi_request *r;
    (void)message;
    const vv_status st = vvi_request_new(&r, client, id, "describe", run_describe);
    return st == VV_OK ? vvi_request_add_quick(r, VV_OK) : st;
}
