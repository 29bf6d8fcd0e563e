#include "edits.h"
#include "choices.h"
#include "core/allowed_places.h"
#include "core/units.h"
#include "model/context.h"
#include "options.h"
#include "value.h"
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const vv_property rows[] = {
    {VV_PROP(cli_look, method), .kind = VV_KIND_STRING, .unit = "NAME", .table = "renderers",
     .automatic = "raycast; surface for meshes; or what the scene says",
     .doc = "rendering method ('volvis methods' lists them)"},
    {VV_PROP(cli_look, apply), .kind = VV_KIND_STRING, .unit = "CHAIN", .automatic = "nothing: the data as they are",
     .doc = "operations on the data of the first input before they are shown, as in 'gaussian --sigma 1mm | threshold "
            "--range 80..'; the World keeps how they were made ('volvis help pipe')"},
    {VV_PROP(cli_look, mode), .kind = VV_KIND_STRING, .unit = "MODE", .table = "modes", .automatic = "composite",
     .doc = "what a ray computes from the values along it ('volvis methods raycast' lists the modes)"},
    {VV_PROP(cli_look, quality), .kind = VV_KIND_STRING, .unit = "QUALITY", .table = "qualities", .automatic = "normal",
     .doc = "draft, normal, high or reference"},
    {VV_PROP(cli_look, spp), .kind = VV_KIND_STRING, .unit = "N",
     .automatic = "by quality: 1, 4, 4 or 16; for triangles 1, 4, 8 or 16; for slices, and with --aov, 1, 1, 4 or 16",
     .doc = "rays per pixel; with --noise or --budget the maximum"},
    {VV_PROP(cli_look, noise), .kind = VV_KIND_STRING, .unit = "SHARE",
     .automatic = "not estimated: all pixels get the same",
     .doc = "more rays only where the estimated error is above this share of the range from black to white: 1%; none: "
            "no limit"},
    {VV_PROP(cli_look, budget), .kind = VV_KIND_STRING, .unit = "TIME", .automatic = "no limit",
     .doc = "more rays until this time has passed: 10s; the picture records how many there were; none: no limit"},
    {VV_PROP(cli_look, size), .kind = VV_KIND_STRING, .unit = "WxH", .automatic = "800x800",
     .doc = "of the picture, as in 1920x1080; one number for both sides"},
    {VV_PROP(cli_look, view), .kind = VV_KIND_STRING, .unit = "VIEW", .table = "directions",
     .automatic = "the first view of the World",
     .doc =
         "front, back, left, right, top, bottom, iso, AZIMUTH,ELEVATION[,ROLL] in degrees, or a view of the scene by "
         "name; anterior, posterior, superior, inferior, isometric, +x, -x, +y, -y, +z and -z "
         "are read too"},
    {VV_PROP(cli_look, tf), .kind = VV_KIND_STRING, .unit = "TF", .table = "presets",
     .automatic = "fitted to the histogram",
     .doc = "transfer function: a preset, a colour map, a JSON file, or nodes VALUE:OPACITY[#COLOUR] with the opacity "
            "per unit of length, as in '0:0 300:0.1#e0b090 1200:0.9#fff'; VOLUME=TF is for that volume. If an option "
            "about values stands between two inputs, each such option is for the input before it; otherwise they are "
            "for all inputs"},
    {VV_PROP(cli_look, color), .kind = VV_KIND_STRING, .unit = "COLOUR", .automatic = "#e6dcc8, or what the file says",
     .doc = "of surfaces and meshes: #rrggbb or a CSS name; in slices, the bright end of the greys"},
    {VV_PROP(cli_look, opacity), .kind = VV_KIND_STRING, .unit = "SHARE",
     .automatic = "unchanged; 50% for overlays in slices that would hide everything",
     .doc = "of clouds, meshes and slices, from 0 to 1"},
    {VV_PROP(cli_look, range), .kind = VV_KIND_STRING, .unit = "LO..HI", .automatic = "from the histogram",
     .doc = "values over which presets and colour maps are stretched"},
    {VV_PROP(cli_look, percentile), .kind = VV_KIND_STRING, .unit = "LO..HI", .automatic = "from the histogram",
     .doc = "the same as percentiles of the samples: 1..99.8"},
    {VV_PROP(cli_look, iso), .kind = VV_KIND_STRING, .unit = "VALUE", .automatic = "no surface",
     .doc = "show the surface at this value; sets the mode isosurface"},
    {VV_PROP(cli_look, threshold), .kind = VV_KIND_STRING, .unit = "LO..HI", .automatic = "no threshold",
     .doc = "values from LO to HI are solid; either may be omitted: 80.. is 80 and more"},
    {VV_PROP(cli_look, step), .kind = VV_KIND_STRING, .unit = "LENGTH", .automatic = "by quality",
     .doc = "distance between samples along a ray: 0.5vox, 1mm"},
    {VV_PROP(cli_look, clip), .kind = VV_KIND_LIST, .cls = &cli_word_class, .unit = "CLIP",
     .doc = "keep x:10mm..60mm (either end may be omitted), or 'plane(n=1,0,1 d=20mm)': the side that n points to, "
            "from d on; in world space; may be repeated"},
    {VV_PROP(cli_look, background), .kind = VV_KIND_STRING, .unit = "COLOUR", .automatic = "black",
     .doc = "#rrggbb, a name of CSS such as darkorange, or transparent"},
    {VV_PROP(cli_look, aov), .kind = VV_KIND_STRING, .unit = "LAYERS", .table = "layers", .automatic = "none",
     .doc =
         "layers to store in addition to colours, as in depth,normal,id: in the file if it is an EXR, else in PFM "
         "files next to it; also samples and value. With layers other than depth a pixel has 1 ray at quality normal, "
         "so that they tell of one place; --spp sets it"},
    {VV_PROP(cli_look, decorate), .kind = VV_KIND_STRING, .unit = "WHAT", .table = "decorations",
     .automatic = "nothing",
     .doc = "what to draw on top of the picture, as in cube,scale-bar,legend: any of cube, axes, scale-bar, box, "
            "cut-planes, legend, sides and cross-hair; all or none"},
    {VV_PROP(cli_look, title), .kind = VV_KIND_STRING, .unit = "TEXT", .automatic = "none",
     .doc = "a line at the upper left of the picture, with placeholders as in --caption"},
    {VV_PROP(cli_look, caption), .kind = VV_KIND_STRING, .unit = "TEXT", .automatic = "none",
     .doc = "text below the title; {file}, {title}, {dims}, {spacing}, {unit}, {range}, {method}, {iso}, {view}, "
            "{azimuth}, {elevation} and {version} are replaced by what they name"},
    {VV_PROP(cli_look, slice), .kind = VV_KIND_STRING, .unit = "PLANE", .table = "planes", .automatic = "no slice",
     .doc = "show a plane through the cross-hair: axial, coronal, sagittal or camera; sets the method slice"},
    {VV_PROP(cli_look, cross_hair), .kind = VV_KIND_STRING, .unit = "X,Y,Z",
     .automatic = "the middle sample of the first volume", .doc = "where the slices meet, in world space: 10mm,0,-4mm"},
    {VV_PROP(cli_look, window), .kind = VV_KIND_STRING, .unit = "LO..HI",
     .automatic = "what the file says, else the 1st and 99.9th percentiles",
     .doc = "values shown as black and white in slices"},
    {VV_PROP(cli_look, no_shading), .kind = VV_KIND_BOOL, .doc = "show colours unlit"},
    {VV_PROP(cli_look, eye), .kind = VV_KIND_STRING, .unit = "X,Y,Z",
     .automatic = "from the view, far enough to see everything", .doc = "the position of the camera, in world space"},
    {VV_PROP(cli_look, at), .kind = VV_KIND_STRING, .unit = "X,Y,Z", .automatic = "the middle of what is shown",
     .doc = "the point that the camera looks at"},
    {VV_PROP(cli_look, up), .kind = VV_KIND_STRING, .unit = "X,Y,Z", .automatic = "0,0,1",
     .doc = "the direction that points up in the picture"},
    {VV_PROP(cli_look, fov), .kind = VV_KIND_STRING, .unit = "ANGLE", .automatic = "20deg",
     .doc = "vertical field of view, in perspective"},
    {VV_PROP(cli_look, zoom), .kind = VV_KIND_STRING, .unit = "FACTOR", .automatic = "1: everything is in the picture",
     .doc = "magnification, as in 1.5"},
    {VV_PROP(cli_look, parallel), .kind = VV_KIND_STRING, .unit = "HEIGHT", .automatic = "perspective",
     .doc = "parallel projection of this height"},
    {0},
};

const vv_class cli_look_class = {
    .name = "look",
    .doc = "look of the picture",
    .size = sizeof(cli_look),
    .properties = rows,
};

/* A word of the table that a property is chosen from, as the table has it: only scene files are strict about case. */
static const char *word_of(const cli_edits *edits, const char *path, const char *typed)
{
    const vv_property_context context = vvi_registry_context(edits->command->registry);
    const vv_property *row = NULL;
    const vv_class *cls;
    if (cli_path_row(&row, &cls, &vv_world_class, path, &context) != VV_OK || !row || cls)
        return typed;
    return cli_choice_word(edits->command->registry, row, typed);
}

vv_status cli_edit_set(cli_edits *edits, const char *option, const char *value, const char *path_format, ...)
{
    char path[256];
    va_list arguments;
    if (!value)
        return VV_OK;
    va_start(arguments, path_format);
    vsnprintf(path, sizeof path, path_format, arguments);
    va_end(arguments);
    const vv_status st = vv_model_set(edits->model, NULL, path, word_of(edits, path, value));
    return st == VV_OK ? VV_OK : vv_fail_in(st, "--%s", option);
}

vv_status cli_edit_unset(cli_edits *edits, const char *path_format, ...)
{
    char path[256];
    va_list arguments;
    va_start(arguments, path_format);
    vsnprintf(path, sizeof path, path_format, arguments);
    va_end(arguments);
    return vv_model_unset(edits->model, NULL, path);
}

vv_status cli_edit_volumes(cli_edits *edits, cli_edit_volume_fn *fn)
{
    vv_world *world = vv_model_snapshot(edits->model);
    vv_status st = VV_OK;
    for (size_t i = 0; i < world->volumes->n && st == VV_OK; i++) {
        const vv_entry *entry = &world->volumes->entry[i];
        st = fn(edits, entry->id, (const vv_volume *)(const void *)entry->object);
    }
    vv_object_release(&world->base);
    return st;
}

static vv_status unshade(cli_edits *edits, const char *id, const vv_volume *volume)
{
    (void)volume;
    return cli_edit_unset(edits, "volumes.%s.shading.model", id);
}

static vv_status edit_light(cli_edits *edits)
{
    vv_status st = cli_edit_set(edits, "background", edits->look->background, "background");
    if (st != VV_OK || !edits->look->no_shading)
        return st;
    if ((st = cli_edit_set(edits, "no-shading", "none", "shading.model")) != VV_OK)
        return st;
    return cli_edit_volumes(edits, unshade);
}

typedef struct path_edit {
    cli_edits *edits;
    const char *value;
} path_edit;

typedef struct named_file {
    const char *property;
    vv_runtime *runtime;
    vv_status status;
} named_file;

static bool trust_file(void *user, const char *path, const vv_property *row, const vv_object *owner)
{
    named_file *named = user;
    const char *file;
    if (row->kind != VV_KIND_PATH || strcmp(path, named->property) != 0)
        return true;
    memcpy(&file, (const char *)owner + row->offset, sizeof file);
    char *real = file ? realpath(file, NULL) : NULL;
    if (real)
        named->status = vvi_runtime_trust(named->runtime, real);
    free(real);
    return false;
}

/* A file that is named here is named by who runs the program, not by a scene. */
static vv_status set_one(void *user, const char *path)
{
    const path_edit *edit = user;
    const vv_status st = vv_model_set(edit->edits->model, NULL, path, word_of(edit->edits, path, edit->value));
    if (st != VV_OK || !edit->edits->command->runtime)
        return st;
    named_file named = {path, edit->edits->command->runtime, VV_OK};
    vv_world *world = vv_model_snapshot(edit->edits->model);
    vv_path_each(&world->base, trust_file, &named);
    vv_object_release(&world->base);
    return named.status;
}

static vv_status edit_by_path(cli_edits *edits, const char *text)
{
    const char *equals = strchr(text, '=');
    char path[512];
    const size_t n = equals ? (size_t)(equals - text) : 0;
    if (n == 0 || n >= sizeof path)
        return vv_fail(VV_E_ARGUMENT, "--set %s: expected PATH=VALUE, as in lights.key.intensity=2", text);
    memcpy(path, text, n);
    path[n] = 0;
    vv_world *world = vv_model_snapshot(edits->model);
    const vv_status st = cli_path_each(&world->base, path, set_one, &(path_edit){edits, equals + 1});
    vv_object_release(&world->base);
    return st == VV_OK ? VV_OK : vv_fail_in(st, "--set");
}

vv_status cli_edit_paths(cli_edits *edits)
{
    const char *text;
    vv_status st = VV_OK;
    for (size_t i = 0; (text = cli_word_nth(edits->command->common->set, i)) && st == VV_OK; i++)
        st = edit_by_path(edits, text);
    return st;
}

vv_status cli_edits_apply(cli_edits *edits)
{
    vv_status st;
    if ((st = cli_edit_view(edits)) != VV_OK || (st = cli_edit_method(edits)) != VV_OK ||
        (st = cli_edit_slices(edits)) != VV_OK || (st = cli_edit_channels(edits)) != VV_OK ||
        (st = edit_light(edits)) != VV_OK || (st = cli_edit_transfer(edits)) != VV_OK ||
        (st = cli_edit_colors(edits)) != VV_OK || (st = cli_edit_clip(edits)) != VV_OK ||
        (st = cli_edit_layers(edits)) != VV_OK || (st = cli_edit_decorations(edits)) != VV_OK ||
        (st = cli_edit_check_aspects(edits)) != VV_OK)
        return st;
    return cli_edit_paths(edits);
}
