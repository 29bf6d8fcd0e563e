/* --method and --mode. */
#include "core/units.h"
#include "edits.h"
#include "measuring/world_data.h"
#include "refusal.h"
#include "scene/resolve.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* The method that the view has now: its parameters are found under its name. */
void cli_edit_method_of(char out[64], cli_edits *edits)
{
    vv_world *world = vv_model_snapshot(edits->model);
    const vv_view *view = vvi_view_named(world, edits->view);
    snprintf(out, 64, "%s",
             view ? vvi_method_of(world, view, edits->command->job)
                  : vv_registry_renderer_for(edits->command->registry, 0)->name);
    vv_object_release(&world->base);
}

static bool has_param(cli_edits *edits, const char *method, const char *name)
{
    const vv_renderer *row = vv_registry_renderer(edits->command->registry, method);
    return row && row->params && vv_class_find(row->params, name);
}

/* What --method replaces shows a surface of this value; false: none, or nobody has set its value. */
static bool iso_before(double *out, char method[64], cli_edits *edits)
{
    vv_world *world = vv_model_snapshot(edits->model);
    cli_edit_method_of(method, edits);
    const bool found = strcmp(method, edits->look->method) != 0 &&
                       vvi_world_surface_value(out, world, edits->view, edits->command->job);
    vv_object_release(&world->base);
    return found;
}

/* Whether a parameter of the view's method is set. */
static bool is_set(cli_edits *edits, const char *method, const char *name)
{
    char path[256];
    vv_world *world = vv_model_snapshot(edits->model);
    snprintf(path, sizeof path, "views.%s.render.%s", edits->view, method);
    const vv_object *params = vv_path_object(&world->base, path);
    const bool set = params && vv_object_is_set(params, name);
    vv_object_release(&world->base);
    return set;
}

/* The surface stays the same one when another method draws it, unless something says which that draws. */
static vv_status carry_iso(cli_edits *edits, const char *from, double iso)
{
    const cli_look *o = edits->look;
    const bool modes = has_param(edits, o->method, "mode");
    const vv_renderer *row = vv_registry_renderer(edits->command->registry, o->method);
    char number[32];
    vv_status st = VV_OK;
    if (o->iso || !row->params || !vv_class_find(row->params, "iso") || is_set(edits, o->method, "iso") ||
        (modes && (o->mode ? strcmp(o->mode, "isosurface") != 0 : is_set(edits, o->method, "mode"))))
        return VV_OK;
    vvi_print_number(number, iso);
    if (modes)
        st = cli_edit_set(edits, "method", "isosurface", "views.%s.render.%s.mode", edits->view, o->method);
    if (st == VV_OK)
        st = cli_edit_set(edits, "method", number, "views.%s.render.%s.iso", edits->view, o->method);
    if (st == VV_OK)
        cli_command_note(edits->command, "the surface stays at %s, the iso-value of method %s; --iso sets another",
                         number, from);
    return st;
}

/* --method, or what --slice says of it. */
static vv_status choose_method(cli_edits *edits)
{
    const cli_look *o = edits->look;
    const vv_renderer *planes = vv_registry_plane_renderer(edits->command->registry);
    char method[64];
    double iso;
    vv_status st;
    if (o->method && !vv_registry_renderer(edits->command->registry, o->method))
        return vv_fail_in(vv_error_last()->status, "--method");
    if (o->slice && !planes)
        return cli_refused(edits->command, "slice", vv_fail(VV_E_UNSUPPORTED, "--slice: no method shows planes"));
    if (o->slice && o->method && strcmp(o->method, planes->name) != 0)
        return cli_refused(edits->command, "slice,method",
                           vv_fail(VV_E_ARGUMENT, "--slice is of method %s, and --method says '%s': give one of them",
                                   planes->name, o->method));
    if (o->method && iso_before(&iso, method, edits) && (st = carry_iso(edits, method, iso)) != VV_OK)
        return st;
    st = cli_edit_set(edits, "method", o->method, "views.%s.render.method", edits->view);
    return st == VV_OK && o->slice ? cli_edit_set(edits, "slice", planes->name, "views.%s.render.method", edits->view)
                                   : st;
}

/* Of a view that names no method and whose own lacks what is asked for: the first that has it and shows what is seen.
 */
static vv_status choose_for(cli_edits *edits, const char *option, const char *param)
{
    char method[64];
    const char *found = NULL;
    vv_world *world = vv_model_snapshot(edits->model);
    const vv_view *view = vvi_view_named(world, edits->view);
    const vv_render_choice *choice = view ? (const vv_render_choice *)(const void *)view->render : NULL;
    cli_edit_method_of(method, edits);
    if (choice && !choice->method && !has_param(edits, method, param)) {
        const unsigned contents = vvi_contents_of(world, edits->command->job);
        const vv_renderer *const *rows = edits->command->registry->renderers;
        for (size_t i = 0; rows[i] && !found; i++)
            if (has_param(edits, rows[i]->name, param) && (rows[i]->takes & contents) == contents)
                found = rows[i]->name;
    }
    vv_object_release(&world->base);
    return cli_edit_set(edits, option, found, "views.%s.render.method", edits->view);
}

/* Light that only some methods have. */
static vv_status choose_for_light(cli_edits *edits)
{
    const cli_look *o = edits->look;
    const struct {
        bool given;
        const char *option, *param;
    } lights[] = {{o->lighting != NULL, "lighting", "lighting"},
                  {o->shadows, "shadows", "shadows"},
                  {o->ambient_occlusion, "ambient-occlusion", "ambient_occlusion"}};
    vv_status st = VV_OK;
    for (size_t i = 0; i < sizeof lights / sizeof *lights && st == VV_OK; i++)
        st = lights[i].given ? choose_for(edits, lights[i].option, lights[i].param) : VV_OK;
    return st;
}

/* --iso NAME=VALUE is how one would think that one volume of several has its own: the properties that do it. */
static vv_status check_iso(cli_edits *edits)
{
    const char *iso = edits->look->iso, *equals = iso ? strchr(iso, '=') : NULL;
    if (!equals)
        return VV_OK;
    const int n = (int)(equals - iso);
    return cli_refused(edits->command, "iso",
                       vv_fail(VV_E_ARGUMENT,
                               "--iso takes one value for all volumes, not '%s'; one volume has its own by --set "
                               "volumes.%.*s.rays.mode=isosurface --set volumes.%.*s.rays.iso=%s",
                               iso, n, iso, n, iso, equals[1] ? equals + 1 : "VALUE"));
}

vv_status cli_edit_method(cli_edits *edits)
{
    const cli_look *o = edits->look;
    char method[64];
    vv_status st = check_iso(edits);
    if (st == VV_OK)
        st = choose_method(edits);
    if (st == VV_OK)
        st = choose_for_light(edits);
    if (st != VV_OK)
        return st;
    cli_edit_method_of(method, edits);
    const char *mode = o->mode ? o->mode : o->iso ? "isosurface" : NULL;
    const char *option = o->mode ? "mode" : "iso";
    st = cli_edit_set(edits, option, has_param(edits, method, "mode") ? mode : NULL, "views.%s.render.%s.mode",
                      edits->view, method);
    return st == VV_OK ? cli_edit_check_params(edits, method) : st;
}
