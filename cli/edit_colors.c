/* --color and --opacity of a volume, whatever shows it. */
#include "core/units.h"
#include "edits.h"
#include "input.h"
#include <stdio.h>
#include <string.h>
#include <volvis/image.h>

bool cli_edit_is_slice(cli_edits *edits)
{
    char method[64];
    cli_edit_method_of(method, edits);
    const vv_renderer *row = vv_registry_renderer(edits->command->registry, method);
    return row && row->plane;
}

static unsigned byte_of(double linear)
{
    const double v = vv_srgb_encode(linear);
    return (unsigned)(255 * (v < 0 ? 0 : v > 1 ? 1 : v) + 0.5);
}

/* Slices go from black to it. */
static vv_status color_slices(cli_edits *edits, const char *id)
{
    char map[8];
    vv_world *world = vv_model_snapshot(edits->model);
    const vv_volume *volume = vvi_volume_named(world, id);
    const vv_color c = volume->color;
    vv_object_release(&world->base);
    snprintf(map, sizeof map, "#%02x%02x%02x", byte_of(c.r), byte_of(c.g), byte_of(c.b));
    return cli_edit_set(edits, "color", map, "volumes.%s.slices.colormap", id);
}

/* Surfaces and meshes have one colour. */
static vv_status edit_color(cli_edits *edits, const char *typed, const char *id, const vv_volume *volume)
{
    const vv_status st = cli_edit_set(edits, "color", typed, "volumes.%s.color", id);
    (void)volume;
    return st == VV_OK && cli_edit_is_slice(edits) ? color_slices(edits, id) : st;
}

/* A mesh's is a part of its colour. */
static vv_status fade_mesh(cli_edits *edits, double opacity, const char *id)
{
    char path[128], color[160];
    vv_world *world = vv_model_snapshot(edits->model);
    const vv_volume *volume = vvi_volume_named(world, id);
    const vv_color c = volume->color;
    snprintf(path, sizeof path, "volumes.%s.color", id);
    snprintf(color, sizeof color, "[%.9g, %.9g, %.9g, %.9g]", c.r, c.g, c.b, opacity);
    vv_object_release(&world->base);
    return cli_edit_set(edits, "opacity", color, "%s", path);
}

static vv_status edit_opacity(cli_edits *edits, const char *typed, const char *id, const vv_volume *volume)
{
    double opacity;
    vv_world *world = vv_model_snapshot(edits->model);
    const bool mesh = vvi_volume_is_mesh(world, volume, edits->command->job);
    vv_status st = vvi_parse_quantity(&opacity, typed, VV_Q_RATIO, NULL, "--opacity");
    vv_object_release(&world->base);
    if (st != VV_OK || !(opacity >= 0 && opacity <= 1))
        return vv_fail(VV_E_ARGUMENT, "--opacity: expected a share from 0 to 1, as in 0.5 or 50%%, found '%s'", typed);
    if (mesh)
        return fade_mesh(edits, opacity, id);
    if (cli_edit_is_slice(edits))
        return cli_edit_set(edits, "opacity", typed, "volumes.%s.slices.opacity", id);
    char number[32];
    vvi_print_number(number, opacity);
    return cli_edit_set(edits, "opacity", number, "volumes.%s.segmentation.transfer.opacity_scale", id);
}

vv_status cli_edit_colors(cli_edits *edits)
{
    const cli_look *o = edits->look;
    vv_status st = o->color ? cli_edit_each(edits, "color", false, edit_color) : VV_OK;
    return st == VV_OK && o->opacity ? cli_edit_each(edits, "opacity", false, edit_opacity) : st;
}
