/* --view and --size. */
#include "core/names.h"
#include "edits.h"
#include "manipulate/directions.h"
#include "refusal.h"
#include "value.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

enum { MAX_NAMES = 64 };

static vv_status set_number(cli_edits *edits, const char *option, double value, const char *property)
{
    char text[32];
    snprintf(text, sizeof text, "%.17g", value);
    return cli_edit_set(edits, option, text, "views.%s.%s", edits->view, property);
}

/* A direction shows everything from there: an eye given before would win over the angles. */
static vv_status look_from(cli_edits *edits, double azimuth, double elevation, const double *roll)
{
    static const char *const replaced[] = {"eye", "at", "up", "roll"};
    vv_status st = VV_OK;
    for (size_t i = 0; i < sizeof replaced / sizeof replaced[0] && st == VV_OK; i++)
        st = cli_edit_unset(edits, "views.%s.camera.%s", edits->view, replaced[i]);
    if (st != VV_OK || (st = set_number(edits, "view", azimuth, "camera.azimuth")) != VV_OK ||
        (st = set_number(edits, "view", elevation, "camera.elevation")) != VV_OK)
        return st;
    return roll ? set_number(edits, "view", *roll, "camera.roll") : VV_OK;
}

static bool is_anatomical(cli_edits *edits)
{
    vv_world *world = vv_model_snapshot(edits->model);
    vv_field_info info = vv_field_info_default();
    for (size_t i = 0; i < world->datasets->n; i++) {
        const vv_dataset *dataset = vvi_dataset_nth(world, i);
        vv_mesh *mesh = NULL;
        if (vv_dataset_is_mesh(dataset, edits->command->job)) {
            if (vv_dataset_mesh(&mesh, world, dataset, edits->command->job) == VV_OK)
                info.grid.space = vv_mesh_get_info(mesh)->space;
            vv_mesh_release(mesh);
        } else if (vv_dataset_info(&info, world, dataset, edits->command->job) != VV_OK) {
            continue;
        }
        if (info.grid.space == VV_SPACE_RAS)
            break;
    }
    vv_object_release(&world->base);
    return info.grid.space == VV_SPACE_RAS;
}

static vv_status fail_view(const char *typed, const vv_world *world)
{
    const char *names[MAX_NAMES], *aliases[MAX_NAMES + 1];
    const vvi_direction *d;
    size_t n = 0, n_aliases = 0;
    for (size_t i = 0; (d = vvi_direction_nth(i)) != NULL; i++) {
        const char *const too[] = {d->alias, d->alias_too};
        names[n++] = d->name ? d->name : d->alias;
        for (size_t a = 0; a < 2; a++)
            if (too[a] && d->name) {
                aliases[n_aliases++] = too[a];
                aliases[n_aliases++] = d->name;
            }
    }
    aliases[n_aliases] = NULL;
    for (size_t i = 0; i < world->views->n && n < MAX_NAMES; i++)
        names[n++] = world->views->entry[i].id;
    return vvi_fail_name(VV_E_ARGUMENT, NULL, NULL, typed, &(vvi_known){names, n, NULL, aliases},
                         "--view: expected a view or AZIMUTH,ELEVATION[,ROLL], found '%s'", typed);
}

static vv_status edit_direction(cli_edits *edits, const char *typed)
{
    double angles[3];
    const vvi_direction *d = vvi_direction_find(typed);
    if (d)
        return look_from(edits, vvi_direction_azimuth(d, is_anatomical(edits)), d->elevation, NULL);
    if (cli_value_numbers(angles, 2, typed, false) == VV_OK)
        return look_from(edits, angles[0], angles[1], NULL);
    if (cli_value_numbers(angles, 3, typed, false) == VV_OK)
        return look_from(edits, angles[0], angles[1], &angles[2]);
    vv_world *world = vv_model_snapshot(edits->model);
    const vv_status st = fail_view(typed, world);
    vv_object_release(&world->base);
    return st;
}

/* The view that is meant: named by --view, else by the picture, else the first, else a new one. */
static vv_status choose_view(cli_edits *edits, bool *named_out)
{
    vv_world *world = vv_model_snapshot(edits->model);
    const char *wanted = edits->look->view;
    const char *chosen = edits->view;
    vv_status st = VV_OK;
    *named_out = wanted && vv_collection_find(world->views, wanted);
    if (*named_out)
        chosen = wanted;
    else if (!*chosen || !vv_collection_find(world->views, chosen))
        chosen = world->views->n ? world->views->entry[0].id : "main";
    if (!vv_collection_find(world->views, chosen))
        st = vv_model_add(edits->model, NULL, "views", chosen, NULL);
    if (chosen != edits->view)
        snprintf(edits->view, sizeof edits->view, "%s", chosen);
    vv_object_release(&world->base);
    return st;
}

/* "1920x1080", or one number for both sides */
static vv_status edit_size(cli_edits *edits, const char *typed)
{
    double size[2];
    vv_status st = cli_value_numbers(size, 1, typed, false);
    if (st == VV_OK)
        size[1] = size[0];
    else
        st = cli_value_numbers(size, 2, typed, true);
    if (st != VV_OK)
        return vv_fail(
            st, "--size: expected WIDTHxHEIGHT in pixels, as in 1024x768, or one number for both, found '%s'", typed);
    if ((st = set_number(edits, "size", size[0], "width")) != VV_OK)
        return st;
    return set_number(edits, "size", size[1], "height");
}

vv_status cli_edit_view(cli_edits *edits)
{
    bool named;
    vv_status st;
    if (edits->look->fov && edits->look->parallel)
        return cli_refused(
            edits->command, "fov,parallel",
            vv_fail(VV_E_ARGUMENT, "--fov is for perspective and --parallel for none: give one of them"));
    if ((st = choose_view(edits, &named)) != VV_OK)
        return st;
    if (edits->look->view && !named && edits->look->eye)
        return cli_refused(edits->command, "view,eye",
                           vv_fail(VV_E_ARGUMENT,
                                   "--view %s and --eye both say where the camera stands: give one of them",
                                   edits->look->view));
    if (edits->look->view && !named && (st = edit_direction(edits, edits->look->view)) != VV_OK)
        return st;
    return edits->look->size ? edit_size(edits, edits->look->size) : VV_OK;
}
