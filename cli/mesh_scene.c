#include "mesh_scene.h"
#include "core/memory.h"
#include "core/units.h"
#include "grid/field.h"
#include "picture_notes.h"
#include "scene/resolve.h"
#include "scene/transfer.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Labels ---------------------------------------------------------------------------------------------------------- */

static const vv_volume *volume_of(const cli_mesh_scene *s)
{
    return vvi_volume_named(s->scene->world, s->actor->id);
}

/* What a picture does not show is left out. */
static bool look_of_scene(vv_mesh_part *part, vv_label_id label, bool is_unsigned, void *user)
{
    const cli_mesh_scene *s = user;
    double rgbk[4];
    vvi_transfer_label(rgbk, &s->actor->classes, label, is_unsigned);
    part->color = (vv_color){rgbk[0], rgbk[1], rgbk[2], 1};
    const vv_segmentation *segmentation = (const vv_segmentation *)(const void *)volume_of(s)->segmentation;
    const vv_collection *names = ((const vv_labels *)(const void *)segmentation->labels)->names;
    for (size_t i = 0; names && i < names->n; i++) {
        const vv_label_name *entry = (const vv_label_name *)(const void *)names->entry[i].object;
        if (entry->label == label && entry->name)
            snprintf(part->name, sizeof part->name, "%s", entry->name);
    }
    return rgbk[3] > 0;
}

vv_status cli_mesh_scene_labels(vv_label **out, size_t *n_out, const cli_mesh_scene *s)
{
    const vv_segmentation *segmentation = (const vv_segmentation *)(const void *)volume_of(s)->segmentation;
    const vv_collection *names = ((const vv_labels *)(const void *)segmentation->labels)->names;
    *n_out = names ? names->n : 0;
    *out = calloc(*n_out + 1, sizeof **out);
    if (!*out)
        return vv_fail_memory(*n_out * sizeof **out);
    for (size_t i = 0; i < *n_out; i++) {
        const vv_label_name *entry = (const vv_label_name *)(const void *)names->entry[i].object;
        (*out)[i].value = entry->label;
        snprintf((*out)[i].name, sizeof(*out)[i].name, "%s", entry->name ? entry->name : "");
    }
    return VV_OK;
}

void cli_mesh_scene_of_file(cli_mesh_scene *out, const cli_input *input)
{
    out->labels.label = vv_file_labels(input->file, &out->labels.n);
    out->look = vvi_label_look_of_file;
    out->look_user = &out->labels;
}

/* Scenes ---------------------------------------------------------------------------------------------------------- */

/* The samples where the World has them. */
static vv_status place(vv_field **out, const cli_mesh_scene *s)
{
    vv_field_info info = *vv_field_get_info(s->actor->field);
    const char *unit = s->scene->world->unit;
    info.grid.index_to_world = s->actor->index_to_world;
    if (unit && vvi_length_unit_metres(unit) > 0 && vvi_length_unit_metres(info.grid.unit) > 0)
        snprintf(info.grid.unit, sizeof info.grid.unit, "%s", unit);
    if (s->actor->classes.kind == VV_SEGMENT_LABELS)
        info.meaning = VV_MEANING_LABEL;
    else if (info.meaning == VV_MEANING_LABEL)
        info.meaning = VV_MEANING_SCALAR;
    return vvi_field_relabel(out, s->actor->field, &info);
}

static vv_status resolve(cli_mesh_scene *out, cli_command *command, const char *word)
{
    vvi_recipe recipe;
    vv_world *world;
    vv_status st = cli_input_world(&world, &recipe, command, word);
    if (st != VV_OK)
        return st;
    st = vv_scene_resolve(&out->scene, world, recipe.view[0] ? recipe.view : NULL, command->job);
    if (st != VV_OK)
        st = cli_fail_data(command, world, word, st);
    vv_object_release(&world->base);
    if (st != VV_OK)
        return st;
    if (out->scene->n_actors == 0)
        return vv_fail_at(VV_E_NOT_FOUND, word, NULL, "no volume of the scene is visible: there is no surface");
    out->actor = &out->scene->actors[0];
    if (out->scene->n_actors > 1)
        cli_command_note(command, "%s: %zu volumes are visible; the surface is that of '%s', the first", word,
                         out->scene->n_actors, out->actor->id);
    return VV_OK;
}

vv_status cli_mesh_scene_open(cli_mesh_scene *out, vv_field **field_out, cli_command *command, const char *word)
{
    vv_status st = resolve(out, command, word);
    if (st != VV_OK || (st = place(field_out, out)) != VV_OK)
        return st;
    out->more = (vvi_isosurface_more){.planes = out->actor->planes, .n_planes = out->actor->n_planes};
    out->look = look_of_scene;
    out->look_user = out;
    return VV_OK;
}

static bool is_solid(double *lo, double *hi, const cli_mesh_scene *s)
{
    const vv_scene *scene = s->scene;
    *lo = s->actor->classes.lo;
    *hi = s->actor->classes.hi;
    return scene->renderer->solid ? scene->renderer->solid(lo, hi, scene, s->actor)
                                  : s->actor->classes.kind == VV_SEGMENT_THRESHOLD;
}

/* A threshold whose lower end nothing lies below is a surface of the upper one alone. */
static vv_status set_value(cli_mesh_scene *s, vv_object **params)
{
    const vv_statistics *all = s->actor->statistics;
    char number[32];
    double lo, hi;
    if (s->actor->classes.kind == VV_SEGMENT_LABELS || vv_object_is_set(*params, "iso") ||
        vv_object_is_set(*params, "label"))
        return VV_OK;
    if (is_solid(&lo, &hi, s)) {
        s->chosen = ", as in the scene";
        s->top = hi;
        if (hi < all->max)
            s->more.top = &s->top;
    } else {
        s->chosen = ", in a valley of the histogram, since the scene shows a cloud";
        lo = s->actor->iso;
    }
    vvi_print_number(number, isfinite(lo) ? lo : all->min);
    return vv_path_set(params, "iso", number, NULL);
}

static vv_status set_component(const cli_mesh_scene *s, vv_object **params)
{
    char number[32];
    if (vv_object_is_set(*params, "component") || s->actor->component == 0)
        return VV_OK;
    snprintf(number, sizeof number, "%d", s->actor->component);
    return vv_path_set(params, "component", number, NULL);
}

vv_status cli_mesh_scene_apply(cli_mesh_scene *s, const vvi_surface_row *surface, vv_object **params)
{
    vv_status st = VV_OK;
    if (s->scene && ((st = set_component(s, params)) != VV_OK || (st = set_value(s, params)) != VV_OK))
        return st;
    s->more.why = s->chosen;
    surface->add(*params, &s->more);
    return VV_OK;
}

void cli_mesh_scene_close(cli_mesh_scene *scene)
{
    vv_scene_release(scene->scene);
    *scene = (cli_mesh_scene){0};
}
