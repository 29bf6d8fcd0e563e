/* What was worked out, written back as explicit properties: a World that shows the same without working it out. */
#include "core/text.h"
#include "core/units.h"
#include "model/contents.h"
#include "model/context.h"
#include "scene/lights.h"
#include "scene/resolve.h"
#include "scene/two_sided.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* One path at a time; the first failure stays. */
typedef struct writer {
    vv_object *root;
    vv_property_context context;
    char prefix[256]; /* "volumes.head." */
    vv_status status;
} writer;

static void put_json(writer *w, const char *name, const char *json)
{
    char path[512];
    if (w->status != VV_OK)
        return;
    snprintf(path, sizeof path, "%s%s", w->prefix, name);
    w->status = json ? vv_path_set(&w->root, path, json, &w->context) : vv_fail_memory(0);
}

static void put_number(writer *w, const char *name, double value)
{
    char text[32];
    vvi_print_number(text, value);
    put_json(w, name, text);
}

static void put_vec(writer *w, const char *name, vv_vec3 v)
{
    char x[32], y[32], z[32], text[128];
    vvi_print_number(x, v.x);
    vvi_print_number(y, v.y);
    vvi_print_number(z, v.z);
    snprintf(text, sizeof text, "[%s, %s, %s]", x, y, z);
    put_json(w, name, text);
}

static void put_rows(writer *w, const char *name, const double *rows, size_t n_rows, size_t columns)
{
    vvi_text text = {0};
    vvi_text_add(&text, "[");
    for (size_t i = 0; i < n_rows * columns; i++) {
        char number[32];
        vvi_print_number(number, rows[i]);
        vvi_text_printf(&text, "%s%s%s%s", i ? ", " : "", i % columns ? "" : "[", number,
                        i % columns == columns - 1 ? "]" : "");
    }
    vvi_text_add(&text, "]");
    char *json = vvi_text_take(&text);
    put_json(w, name, json);
    free(json);
}

static void put_word(writer *w, const char *name, const char *word)
{
    vvi_text text = {0};
    vvi_text_json(&text, word);
    char *json = vvi_text_take(&text);
    put_json(w, name, json);
    free(json);
}

static void fix_classes(writer *w, const vv_actor *actor)
{
    static const char *const kinds[] = {"transfer", "threshold", "labels"};
    const vv_classification *c = &actor->classes;
    const bool colors = actor->colors && c->kind != VV_SEGMENT_THRESHOLD; /* a solid is of them anyhow */
    put_word(w, "segmentation.kind", colors ? "colors" : kinds[c->kind]);
    if (actor->colors)
        put_word(w, "segmentation.colors.encoding", actor->colors_encoded ? "srgb" : "linear");
    if (c->kind == VV_SEGMENT_THRESHOLD) {
        put_number(w, "segmentation.threshold.lo", c->lo);
        if (isfinite(c->hi))
            put_number(w, "segmentation.threshold.hi", c->hi);
        return;
    }
    put_number(w, "segmentation.transfer.opacity_length", c->opacity_length);
    if (c->kind == VV_SEGMENT_LABELS) {
        put_number(w, "segmentation.labels.opacity", c->label_opacity);
        return;
    }
    if (c->gradient_power > 0)
        put_number(w, "segmentation.transfer.gradient_reference", c->gradient_reference);
    put_rows(w, "segmentation.transfer.opacity", c->opacity, c->n_opacity, 2);
    put_rows(w, "segmentation.transfer.color", c->color, c->n_color, 4);
}

/* A window that is written down would say that what lies below it is clear. */
static void fix_overlay(writer *w, const vv_slice_look *look)
{
    put_json(w, "slices.clear_below", look->clear_below ? "true" : "false");
    put_number(w, "slices.opacity", look->opacity);
}

static void fix_actor(writer *w, const vv_actor *actor, bool first, const vv_world *world)
{
    const vv_volume *volume = vvi_volume_named(world, actor->id);
    snprintf(w->prefix, sizeof w->prefix, "volumes.%s.", actor->id);
    if (!volume->data)
        put_word(w, "data", world->datasets->entry[0].id);
    put_word(w, "interpolation", actor->nearest ? "nearest" : actor->cubic ? "cubic" : "linear");
    fix_classes(w, actor);
    if (actor->paint.field)
        put_rows(w, "paint.color", actor->paint.color, actor->paint.n_color, 4);
    if (!actor->colors && actor->classes.kind != VV_SEGMENT_LABELS && actor->slices.colors == VV_SLICE_WINDOW) {
        put_number(w, "slices.window_lo", actor->slices.lo);
        put_number(w, "slices.window_hi", actor->slices.hi);
        if (vvi_two_sided_map(actor->slices.colormap))
            put_word(w, "slices.colormap", VVI_TWO_SIDED_MAP);
        if (!first && actor->slices.blend == VV_SLICE_OVER)
            fix_overlay(w, &actor->slices);
    }
    if (actor->texture.kind != VV_TEXTURE_NONE)
        put_number(w, "texture.frequency", actor->texture.frequency);
}

/* What was given stays as it was written: worked out once more it could move by a rounding. */
static void fix_camera(writer *w, const vvi_resolved *r)
{
    const vvi_aim *aim = &r->aim;
    const vv_object *camera = r->scene.view->camera;
    snprintf(w->prefix, sizeof w->prefix, "views.%s.camera.", r->view_id);
    if (!vv_object_is_set(camera, "eye") && !r->planar)
        put_vec(w, "eye", aim->lens.eye);
    if (!vv_object_is_set(camera, "at"))
        put_vec(w, "at", aim->at);
    if (!vv_object_is_set(camera, "up") && !r->planar)
        put_vec(w, "up", aim->up);
    if (aim->lens.parallel && !vv_object_is_set(camera, "height"))
        put_number(w, "height", aim->height);
}

static void fix_lights(writer *w)
{
    for (size_t i = 0; vvi_default_light_nth(i) && w->status == VV_OK; i++) {
        const vvi_default_light *light = vvi_default_light_nth(i);
        w->status = vv_path_add(&w->root, "lights", light->id, NULL, &w->context);
        snprintf(w->prefix, sizeof w->prefix, "lights.%s.", light->id);
        put_word(w, "frame", "camera");
        put_vec(w, "direction", light->direction);
        put_number(w, "intensity", light->intensity);
    }
}

/* What the segmentation says stays there: a level beside it would take the place of both of its ends. */
static bool is_threshold(const vv_scene *scene, const vv_actor *actor)
{
    double lo, hi;
    return actor->classes.kind == VV_SEGMENT_THRESHOLD && scene->renderer->solid &&
           scene->renderer->solid(&lo, &hi, scene, actor) && lo == actor->classes.lo && hi == actor->classes.hi;
}

/* A renderer whose surfaces have a level of their own says so by a parameter "iso". */
static void fix_iso(writer *w, const vvi_resolved *r)
{
    const vv_scene *scene = &r->scene;
    if (scene->n_actors != 1 || !scene->params || !vv_class_find(scene->params->cls, "iso") ||
        vv_object_is_set(vv_actor_params(scene, &scene->actors[0]), "iso") || is_threshold(scene, &scene->actors[0]))
        return;
    snprintf(w->prefix, sizeof w->prefix, "views.%s.render.%s.", r->view_id, scene->renderer->name);
    put_number(w, "iso", scene->actors[0].iso);
}

vv_status vv_scene_fix(vv_world **out, const vv_scene *scene)
{
    const vvi_resolved *r = (const vvi_resolved *)scene;
    writer w = {.root = vv_object_retain(&scene->world->base), .context = vvi_registry_context(r->registry)};
    *out = NULL;
    for (size_t i = 0; i < scene->n_actors; i++)
        fix_actor(&w, &scene->actors[i], i == 0, scene->world);
    w.prefix[0] = 0;
    if (scene->n_actors + scene->n_mesh_actors)
        put_vec(&w, "cross_hair", scene->cross_hair);
    if (vvi_scene_up(scene) != VV_UP_Z)
        put_word(&w, "up", "y");
    fix_camera(&w, r);
    fix_iso(&w, r);
    if (!scene->world->lights->n)
        fix_lights(&w);
    if (w.status != VV_OK) {
        vv_object_release(w.root);
        return w.status;
    }
    *out = (vv_world *)w.root;
    return VV_OK;
}
