/* Which methods and modes have a use for an option: their rows say it, and options without any use are refused. */
#include "core/names.h"
#include "core/text.h"
#include "edits.h"
#include "model/context.h"
#include "refusal.h"
#include "scene/resolve.h"
#include "serving.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <volvis/sys/scene.h>

/* What an option is about: a parameter of methods, or an aspect of the World. */
typedef struct use {
    const char *option, *given;
    const char *param; /* NULL: an aspect */
    vv_aspect aspect;
} use;

static const vv_property *mode_row(const vv_renderer *renderer)
{
    const vv_property *row = renderer->params ? vv_class_find(renderer->params, "mode") : NULL;
    return row && row->kind == VV_KIND_ENUM ? row : NULL;
}

static bool heeds(const vv_renderer *renderer, const vv_object *params, vv_aspect aspect)
{
    if (!renderer->heeds)
        return aspect != VV_ASPECT_WINDOW && aspect != VV_ASPECT_CROSS_HAIR;
    return renderer->heeds(params, aspect);
}

/* Whether a method in this mode (NULL: it has none) has a use for the option; params: of any other setting. */
static bool is_used(const use *u, const vv_renderer *renderer, const char *mode, const vv_object *params)
{
    const vv_property *row = u->param && renderer->params ? vv_class_find(renderer->params, u->param) : NULL;
    return u->param ? row && (!mode || vvi_property_acts_with(row, mode)) : heeds(renderer, params, u->aspect);
}

/* Who takes the option ------------------------------------------------------------------------------------------- */

/* The choice that says most of a method: the first of its parameters that has names. */
static const vv_property *choice_row(const vv_renderer *renderer)
{
    const vv_property *row = renderer->params ? renderer->params->properties : NULL;
    while (row && row->name && row->kind != VV_KIND_ENUM)
        row++;
    return row && row->name ? row : NULL;
}

static void add_names(vvi_text *out, const char *const *names, size_t n)
{
    for (size_t i = 0; i < n; i++)
        vvi_text_printf(out, "%s%s", i == 0 ? "" : i + 1 < n ? ", " : " and ", names[i]);
}

/* "mode isosurface", "all modes but isosurface", "orientation camera": the choices with which it is of use; false: all
 * of them, or none. */
static bool list_modes(vvi_text *out, const use *u, const vv_renderer *renderer, const vv_property_context *context)
{
    const vv_property *row = choice_row(renderer);
    const char *used[32], *others[32];
    size_t n = 0, n_others = 0;
    for (size_t i = 0; row && row->names[i] && i < 32; i++) {
        vv_object *params = NULL;
        const bool helps = vv_object_new(&params, renderer->params, context) == VV_OK &&
                           vv_path_set(&params, row->name, row->names[i], context) == VV_OK &&
                           is_used(u, renderer, row->names[i], params);
        if (helps)
            used[n++] = row->names[i];
        else
            others[n_others++] = row->names[i];
        vv_object_release(params);
    }
    if (n == 0 || n_others == 0)
        return false;
    const bool most = n > n_others + 1;
    vvi_text_printf(out, "%s%s%s%s", most ? "all " : "", row->name, most || n > 1 ? "s" : "", most ? " but " : " ");
    add_names(out, most ? others : used, most ? n_others : n);
    return true;
}

/* Whether any setting of the method has a use for it: a plane at right angles to the line of sight has for the camera.
 */
static bool ever_used(const use *u, const vv_renderer *renderer, const vv_property_context *context)
{
    bool used = false;
    vv_object *params = NULL;
    if (!renderer->params)
        return is_used(u, renderer, NULL, NULL);
    if (vv_object_new(&params, renderer->params, context) == VV_OK)
        used = is_used(u, renderer, NULL, params);
    vv_object_release(params);
    return used;
}

/* "modes composite and isosurface of method raycast, and of methods surface, reduced and boxes" */
static void list_methods(vvi_text *out, const use *u, const cli_edits *edits)
{
    const vv_registry *registry = edits->command->registry;
    const vv_property_context context = vvi_registry_context(registry);
    const char *whole[32];
    size_t n = 0, parts = 0;
    for (size_t i = 0; registry->renderers[i] && n < 32; i++) {
        vvi_text modes = {0};
        if (list_modes(&modes, u, registry->renderers[i], &context))
            vvi_text_printf(out, "%s%s of method %s", parts++ ? ", and of " : "", modes.s,
                            registry->renderers[i]->name);
        else if (ever_used(u, registry->renderers[i], &context))
            whole[n++] = registry->renderers[i]->name;
        vvi_text_free(&modes);
    }
    if (n)
        vvi_text_printf(out, "%smethod%s ", parts ? ", and of " : "", n > 1 ? "s" : "");
    add_names(out, whole, n);
}

static vv_status refuse(const use *u, const cli_edits *edits, const vv_renderer *renderer, const char *mode)
{
    vvi_text takers = {0};
    vv_status st;
    list_methods(&takers, u, edits);
    if (takers.bad)
        st = vv_fail_memory(takers.n);
    else if (mode && mode_row(renderer))
        st = vv_fail(VV_E_ARGUMENT, "--%s does nothing in mode %s of method %s: it is of %s", u->option, mode,
                     renderer->name, takers.s);
    else
        st = vv_fail(VV_E_ARGUMENT, "--%s does nothing with method %s: it is of %s", u->option, renderer->name,
                     takers.s);
    vvi_text_free(&takers);
    /* it, or what chose the method and the mode */
    char options[128];
    snprintf(options, sizeof options, "%s,mode,iso,slice,threshold,method", u->option);
    return cli_refused(edits->command, options, st);
}

/* Checks --------------------------------------------------------------------------------------------------------- */

/* The view's method, and its parameters, which `world` has. */
static const vv_object *params_of(const vv_world *world, const char *view, const char *method)
{
    char path[256];
    snprintf(path, sizeof path, "views.%s.render.%s", view, method);
    return vv_path_object(&world->base, path);
}

static const char *mode_of(const vv_renderer *renderer, const vv_object *params)
{
    const vv_property *row = mode_row(renderer);
    return row && params ? row->names[*(const int *)(const void *)((const char *)params + row->offset)] : NULL;
}

bool cli_edit_heeds(cli_edits *edits, const vv_world *world, vv_aspect aspect)
{
    char method[64];
    cli_edit_method_of(method, edits);
    const vv_renderer *renderer = vv_registry_renderer(edits->command->registry, method);
    return renderer && heeds(renderer, params_of(world, edits->view, method), aspect);
}

/* Whether a volume that is shown in a mode of its own has a use for it. */
static bool is_used_by_volume(const use *u, const vv_renderer *renderer, const vv_object *params, const vv_world *world)
{
    bool used = false;
    for (size_t i = 0; i < world->volumes->n && !used; i++) {
        const vv_volume *volume = vvi_volume_nth(world, i);
        vv_object *own = NULL;
        if (!volume->visible || !vv_object_is_set(volume->rays, "mode") ||
            vvi_volume_params(&own, params, volume) != VV_OK)
            continue;
        used = is_used(u, renderer, mode_of(renderer, own), own);
        vv_object_release(own);
    }
    return used;
}

static vv_status check(cli_edits *edits, const vv_world *world, const char *method, const use *uses, size_t n)
{
    const vv_renderer *renderer = vv_registry_renderer(edits->command->registry, method);
    const vv_object *params = params_of(world, edits->view, method);
    const char *mode = renderer ? mode_of(renderer, params) : NULL;
    vv_status st = VV_OK;
    for (size_t i = 0; renderer && i < n && st == VV_OK; i++)
        if (uses[i].given && !is_used(&uses[i], renderer, mode, params) &&
            !(params && is_used_by_volume(&uses[i], renderer, params, world)))
            st = refuse(&uses[i], edits, renderer, mode);
    return st;
}

enum { PARAM_USES = 6 };

static void list_params(use out[PARAM_USES], const cli_look *o)
{
    const use uses[PARAM_USES] = {
        {.option = "mode", .given = o->mode, .param = "mode"},
        {.option = "iso", .given = o->iso, .param = "iso"},
        {.option = "step", .given = o->step, .param = "step"},
        {.option = "lighting", .given = o->lighting, .param = "lighting"},
        {.option = "shadows", .given = o->shadows ? "" : NULL, .param = "shadows"},
        {.option = "ambient-occlusion", .given = o->ambient_occlusion ? "" : NULL, .param = "ambient_occlusion"},
    };
    memcpy(out, uses, sizeof uses);
}

vv_status cli_edit_check_params(cli_edits *edits, const char *method)
{
    const vv_renderer *renderer = vv_registry_renderer(edits->command->registry, method);
    use uses[PARAM_USES];
    vv_status st = VV_OK;
    list_params(uses, edits->look);
    for (size_t i = 0; renderer && i < PARAM_USES && st == VV_OK; i++)
        if (uses[i].given && !(renderer->params && vv_class_find(renderer->params, uses[i].param)))
            st = refuse(&uses[i], edits, renderer, NULL);
    return st;
}

static bool shows_meshes(const vv_world *world, vv_job *job)
{
    for (size_t i = 0; i < world->datasets->n; i++)
        if (vv_dataset_is_mesh(vvi_dataset_nth(world, i), job))
            return true;
    return false;
}

/* Whether rays show it as a cloud. */
static bool is_cloud(const vv_volume *volume, const vv_renderer *renderer, const vv_object *params)
{
    const vv_segmentation *segmentation = (const vv_segmentation *)(const void *)volume->segmentation;
    vv_object *own = NULL;
    if (segmentation->kind == VV_SEGMENT_THRESHOLD || vvi_volume_params(&own, params, volume) != VV_OK)
        return false;
    const char *mode = mode_of(renderer, own);
    const bool cloud = mode && strcmp(mode, "composite") == 0;
    vv_object_release(own);
    return cloud;
}

/* Whether what is seen is nothing but clouds. */
static bool shows_clouds(const vv_world *world, const cli_edits *edits, const char *method)
{
    const vv_renderer *renderer = vv_registry_renderer(edits->command->registry, method);
    const vv_object *params = params_of(world, edits->view, method);
    bool clouds = renderer != NULL;
    for (size_t i = 0; i < world->volumes->n && clouds; i++) {
        const vv_volume *volume = vvi_volume_nth(world, i);
        clouds = !volume->visible || is_cloud(volume, renderer, params);
    }
    return clouds;
}

/* Verbs that open the page show a World in all ways. */
static bool makes_one_picture(const cli_command *command)
{
    for (size_t i = 0; i < CLI_VERB_CLASSES; i++)
        if (command->verb.options[i] == &cli_session_class)
            return false;
    return true;
}

/* Parameters of methods by the mode, which a volume may have of its own. */
static vv_status check_modes(cli_edits *edits, const vv_world *world)
{
    char method[64];
    use uses[PARAM_USES];
    list_params(uses, edits->look);
    cli_edit_method_of(method, edits);
    return check(edits, world, method, uses, PARAM_USES);
}

static vv_status check_aspects(cli_edits *edits, const vv_world *world)
{
    const cli_look *o = edits->look;
    char method[64];
    const vv_view *view = vvi_view_named(world, edits->view);
    const vv_decorations *drawn = view ? (const vv_decorations *)(const void *)view->decorations : NULL;
    const bool meshes = shows_meshes(world, edits->command->job);
    const bool direction = o->view && !vv_collection_find(world->views, o->view);
    const use uses[] = {
        {.option = "tf", .given = meshes ? NULL : o->tf, .aspect = VV_ASPECT_TRANSFER},
        {.option = "range", .given = meshes ? NULL : o->range, .aspect = VV_ASPECT_TRANSFER},
        {.option = "percentile", .given = meshes ? NULL : o->percentile, .aspect = VV_ASPECT_TRANSFER},
        {.option = "opacity", .given = meshes ? NULL : o->opacity, .aspect = VV_ASPECT_OPACITY},
        {.option = "color", .given = meshes ? NULL : o->color, .aspect = VV_ASPECT_COLOR},
        {.option = "threshold", .given = o->threshold, .aspect = VV_ASPECT_THRESHOLD},
        {.option = "no-shading", .given = o->no_shading ? "" : NULL, .aspect = VV_ASPECT_SHADING},
        {.option = "clip", .given = cli_word_nth(o->clip, 0), .aspect = VV_ASPECT_CUTS},
        {.option = "window", .given = o->window, .aspect = VV_ASPECT_WINDOW},
        {.option = "cross-hair",
         .given = drawn && drawn->cross_hair ? NULL : o->cross_hair,
         .aspect = VV_ASPECT_CROSS_HAIR},
        {.option = "view", .given = direction ? o->view : NULL, .aspect = VV_ASPECT_DIRECTION},
        {.option = "eye", .given = o->eye, .aspect = VV_ASPECT_DIRECTION},
        {.option = "up", .given = o->up, .aspect = VV_ASPECT_DIRECTION},
        {.option = "fov", .given = o->fov, .aspect = VV_ASPECT_DIRECTION},
    };
    cli_edit_method_of(method, edits);
    vv_status st = check(edits, world, method, uses, sizeof uses / sizeof uses[0]);
    if (st == VV_OK && o->iso && o->threshold)
        st = cli_refused(edits->command, "iso,threshold",
                         vv_fail(VV_E_ARGUMENT,
                                 "--iso shows the surface at one value, and --threshold makes values solid: give one "
                                 "of them"));
    if (st == VV_OK && o->color && !meshes && shows_clouds(world, edits, method))
        st = cli_refused(edits->command, "color,mode",
                         vv_fail(VV_E_ARGUMENT,
                                 "--color does nothing to clouds, which --tf colours: it is of surfaces and solids, "
                                 "so give --iso or --threshold too"));
    return st == VV_OK ? cli_edit_check_contents(edits, world) : st;
}

vv_status cli_edit_check_aspects(cli_edits *edits)
{
    vv_world *world = vv_model_snapshot(edits->model);
    vv_status st = check_modes(edits, world);
    if (st == VV_OK && makes_one_picture(edits->command))
        st = check_aspects(edits, world);
    vv_object_release(&world->base);
    return st;
}

static const char *const of_rays[] = {"mode", "iso", "threshold", "step", "blend", "opacity"};
enum { RAYS = sizeof of_rays / sizeof *of_rays };

/* Of the first that is set of a volume that no rays can show so. */
static void note_all_rays(cli_edits *edits, const char *id, const vv_volume *volume, const char *method, bool mesh)
{
    size_t k = 0;
    while (k < RAYS && !vv_object_is_set(volume->rays, of_rays[k]))
        k++;
    if (k < RAYS && mesh)
        cli_command_note(edits->command,
                         "volumes.%s.rays.%s does nothing: '%s' is a mesh, which is a surface for all rays; its own "
                         "look is volumes.%s.opacity, color and shading",
                         id, of_rays[k], id, id);
    else if (k < RAYS)
        cli_command_note(edits->command,
                         "volumes.%s.rays.%s does nothing: method %s casts no rays; --method raycast does", id,
                         of_rays[k], method);
}

/* Of each that the mode of its rays has no use for. */
static void note_idle_rays(cli_edits *edits, const char *id, const vv_volume *volume, const vv_renderer *renderer,
                           const vv_object *params)
{
    vv_object *own = NULL;
    if (vvi_volume_params(&own, params, volume) != VV_OK)
        return;
    const char *mode = mode_of(renderer, own);
    const bool layer = vvi_renderer_projects(renderer, own) != VV_PROJECTS_NOTHING;
    for (size_t k = 0; k < RAYS && mode; k++) {
        const vv_property *row = vv_class_find(renderer->params, of_rays[k]);
        if (vv_object_is_set(volume->rays, of_rays[k]) && !(row ? vvi_property_acts_with(row, mode) : layer))
            cli_command_note(edits->command, "volumes.%s.rays.%s does nothing in mode %s: it is of %s", id, of_rays[k],
                             mode, row ? row->when : "modes that show one value of each ray");
    }
    vv_object_release(own);
}

/* What volumes' own `rays` ask for that this picture cannot do. */
static void note_rays(cli_edits *edits, const vv_world *world, const char *method)
{
    const vv_renderer *renderer = vv_registry_renderer(edits->command->registry, method);
    const vv_object *params = params_of(world, edits->view, method);
    const bool casts = renderer && renderer->params && params && vv_class_find(renderer->params, "mode");
    for (size_t i = 0; i < world->volumes->n; i++) {
        const vv_volume *volume = vvi_volume_nth(world, i);
        const char *id = world->volumes->entry[i].id;
        const bool mesh = volume->visible && vvi_volume_is_mesh(world, volume, edits->command->job);
        if (volume->visible && casts && !mesh)
            note_idle_rays(edits, id, volume, renderer, params);
        else if (volume->visible)
            note_all_rays(edits, id, volume, method, mesh);
    }
}

vv_status cli_edit_tell_rays(cli_edits *edits)
{
    char method[64];
    if (!makes_one_picture(edits->command))
        return VV_OK;
    vv_world *world = vv_model_snapshot(edits->model);
    cli_edit_method_of(method, edits);
    note_rays(edits, world, method);
    vv_object_release(&world->base);
    return VV_OK;
}
