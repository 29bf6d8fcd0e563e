/* Colours that nobody gave, where several objects of one colour meet. */
#include "core/memory.h"
#include "grid/label_color.h"
#include "model/contents.h"
#include "scene/resolve.h"
#include <string.h>

static vv_color next_color(int64_t *n_given)
{
    double rgb[3];
    vvi_label_color(rgb, ++*n_given);
    return (vv_color){rgb[0], rgb[1], rgb[2], 1};
}

/* Meshes ---------------------------------------------------------------------------------------------------------- */

/* Parts that are shown in the colour that all have: those of several, or the whole. */
static size_t count_plain(const vv_mesh_actor *shape)
{
    const vv_mesh_info *m = vv_mesh_get_info(shape->mesh);
    size_t n = 0;
    if (shape->one_color || shape->colors || m->colors)
        return 0;
    for (size_t i = 0; i < m->n_parts; i++)
        n += m->parts[i].color.a < 0 && !m->parts[i].texture;
    return m->n_parts ? n : 1;
}

static vv_status color_parts(vv_mesh_actor *shape, int64_t *n_given, vv_job *job)
{
    const vv_mesh_info *m = vv_mesh_get_info(shape->mesh);
    const size_t bytes = m->n_parts * sizeof *m->parts;
    vv_mesh_part *parts = vvi_alloc(job, bytes, VVI_MEM_DERIVED);
    shape->parts = parts;
    if (!parts)
        return vv_fail_memory(bytes);
    memcpy(parts, m->parts, bytes);
    for (size_t i = 0; i < m->n_parts; i++)
        if (parts[i].color.a < 0 && !parts[i].texture)
            parts[i].color = next_color(n_given);
    return VV_OK;
}

static vv_status color_mesh(vv_mesh_actor *shape, int64_t *n_given, vv_job *job)
{
    if (!count_plain(shape))
        return VV_OK;
    if (vv_mesh_get_info(shape->mesh)->n_parts > 1)
        return color_parts(shape, n_given, job);
    const vv_color c = next_color(n_given);
    shape->look.color[0] = (float)c.r, shape->look.color[1] = (float)c.g, shape->look.color[2] = (float)c.b;
    return VV_OK;
}

/* Volumes --------------------------------------------------------------------------------------------------------- */

/* Whether its surface is shown in the colour that all have. */
static bool is_plain(const vv_scene *scene, const vv_actor *actor)
{
    double lo, hi;
    const vv_volume *volume = vvi_volume_named(scene->world, actor->id);
    return scene->renderer->solid && scene->renderer->solid(&lo, &hi, scene, actor) && !actor->colors &&
           !actor->paint.field && !vv_object_is_set(&volume->base, "color");
}

static void color_volume(vv_actor *actor, int64_t *n_given)
{
    const vv_color c = next_color(n_given);
    vv_classification *k = &actor->classes;
    actor->color[0] = (float)c.r, actor->color[1] = (float)c.g, actor->color[2] = (float)c.b;
    if (k->kind == VV_SEGMENT_THRESHOLD)
        memcpy((double *)(uintptr_t)k->color + 1, (double[]){c.r, c.g, c.b}, 3 * sizeof(double)); /* the actor's own */
}

vv_status vvi_tell_actors_apart(vv_scene *scene, vv_job *job)
{
    vv_status st = VV_OK;
    size_t n = 0;
    int64_t n_given = 0;
    bool first = true;
    for (size_t i = 0; i < scene->n_mesh_actors; i++)
        n += count_plain(&scene->mesh_actors[i]);
    for (size_t i = 0; i < scene->n_actors; i++)
        n += is_plain(scene, &scene->actors[i]);
    for (size_t i = 0; i < scene->n_mesh_actors && n > 1 && st == VV_OK; i++)
        st = color_mesh(&scene->mesh_actors[i], &n_given, job);
    for (size_t i = 0; i < scene->n_actors && n > 1; i++) {
        if (!is_plain(scene, &scene->actors[i]))
            continue;
        if (!first)
            color_volume(&scene->actors[i], &n_given);
        first = false;
    }
    return st;
}
