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
#include <strings.h>

static const vv_property rows[] = {
    {VV_PROP(cli_look, method), .kind = VV_KIND_STRING, .unit = "NAME", .table = "renderers",
     .automatic = "raycast; surface for meshes alone without shadows; or what the scene says",
     .doc = "rendering method ('volvis methods' lists them)"},
    {VV_PROP(cli_look, apply), .kind = VV_KIND_STRING, .unit = "CHAIN", .automatic = "nothing: the data as they are",
     .doc = "operations on the data of the first input before they are shown, as in 'gaussian --sigma 1mm | threshold "
            "--range 80..'; the World keeps how they were made ('volvis help pipe')"},
    {VV_PROP(cli_look, mode), .kind = VV_KIND_STRING, .unit = "MODE", .table = "modes", .automatic = "composite",
     .doc = "what a ray computes from the values along it ('volvis methods raycast' lists the modes)"},
    {VV_PROP(cli_look, quality), .kind = VV_KIND_STRING, .unit = "QUALITY", .table = "qualities", .automatic = "normal",
     .doc = "draft, normal, high or reference"},
    {VV_PROP(cli_look, spp), .kind = VV_KIND_STRING, .unit = "N",
     .automatic =
         "by quality: 1, 2, 4 or 16; where more than clouds are seen 1, 4, 8 or 16; for slices, and with --aov, "
         "1, 1, 4 or 16",
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
    {VV_PROP(cli_look, lighting), .kind = VV_KIND_STRING, .unit = "LIGHTING", .table = "lightings",
     .automatic = "local", .doc = "local, or cinematic: shadows, ambient occlusion and more ambient light"},
    {VV_PROP(cli_look, shadows), .kind = VV_KIND_BOOL, .doc = "let clouds, surfaces and meshes cast soft shadows"},
    {VV_PROP(cli_look, ambient_occlusion), .kind = VV_KIND_BOOL,
     .doc = "less ambient light in hollows and between what is close together"},
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
    if (vv_path_row(&row, &cls, &vv_world_class, path, &context) != VV_OK || !row || cls)
        return typed;
    return cli_choice_word(edits->command->registry, row, typed);
}

const char *cli_look_text(const cli_look *look, const char *option)
{
    const vv_property *row = vv_class_find(&cli_look_class, option);
    return *(const char *const *)(const void *)((const char *)look + row->offset);
}

static vv_status set_path(cli_edits *edits, const char *option, const char *value, const char *path)
{
    const vv_status st = vv_model_set(edits->model, NULL, path, word_of(edits, path, value));
    return st == VV_OK ? VV_OK : vv_fail_in(st, "--%s", option);
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
    return set_path(edits, option, value, path);
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
    for (size_t i = 0; i < world->volumes->n && st == VV_OK; i++)
        st = fn(edits, world->volumes->entry[i].id, vvi_volume_nth(world, i));
    vv_object_release(&world->base);
    return st;
}

static vv_status unshade(cli_edits *edits, const char *id, const vv_volume *volume)
{
    (void)volume;
    return cli_edit_unset(edits, "volumes.%s.shading.model", id);
}

static vv_status edit_shading(cli_edits *edits)
{
    if (!edits->look->no_shading)
        return VV_OK;
    const vv_status st = cli_edit_set(edits, "no-shading", "none", "shading.model");
    return st == VV_OK ? cli_edit_volumes(edits, unshade) : st;
}

/* Options that are one property each ------------------------------------------------------------------------------ */

/* How words become a value. */
typedef enum form {
    FORM_WORD,  /* as the property takes them */
    FORM_POINT, /* lengths with units, "10mm,2cm,0" */
    FORM_TEXT,  /* free text, which is never read as JSON */
    FORM_LIMIT  /* more than 0, or none */
} form;

typedef struct one {
    const char *option, *path; /* %1$s stands for the view, %2$s for its method */
    form form;
    const char *value;   /* what the property is whatever was typed; NULL: that */
    const char *example; /* of a limit */
} one;

static const one ones[] = {
    {"eye", "views.%1$s.camera.eye", FORM_POINT},
    {"at", "views.%1$s.camera.at", FORM_POINT},
    {"up", "views.%1$s.camera.up", FORM_POINT},
    {"fov", "views.%1$s.camera.projection", .value = "perspective"},
    {"fov", "views.%1$s.camera.fov"},
    {"parallel", "views.%1$s.camera.projection", .value = "parallel"},
    {"parallel", "views.%1$s.camera.height"},
    {"zoom", "views.%1$s.camera.zoom"},
    {"quality", "views.%1$s.render.quality"},
    {"spp", "views.%1$s.render.samples"},
    {"noise", "views.%1$s.render.noise", FORM_LIMIT, .example = "1%"},
    {"budget", "views.%1$s.render.budget", FORM_LIMIT, .example = "10s"},
    {"iso", "views.%1$s.render.%2$s.iso"},
    {"step", "views.%1$s.render.%2$s.step"},
    {"lighting", "views.%1$s.render.%2$s.lighting"},
    {"shadows", "views.%1$s.render.%2$s.shadows"},
    {"ambient_occlusion", "views.%1$s.render.%2$s.ambient_occlusion"},
    {"slice", "views.%1$s.render.%2$s.orientation"}, /* --slice has chosen the method */
    {"title", "views.%1$s.decorations.title", FORM_TEXT},
    {"caption", "views.%1$s.decorations.caption", FORM_TEXT},
    {"cross_hair", "cross_hair", FORM_POINT},
    {"background", "background"},
};

/* A limit that is 0 would be none, which has a word of its own. */
static vv_status check_limit(cli_edits *edits, const one *o, const char *typed, const char *path)
{
    char *json = NULL;
    vv_world *world = vv_model_snapshot(edits->model);
    vv_status st = vv_path_get(&json, &world->base, path);
    if (st == VV_OK && strcmp(json, "0") == 0)
        st = vv_fail(VV_E_ARGUMENT, "--%s: '%s' would be no limit; expected more than 0, as in %s, or none", o->option,
                     typed, o->example);
    free(json);
    vv_object_release(&world->base);
    return st;
}

static vv_status edit_one(cli_edits *edits, const one *o, const char *typed, const char *method)
{
    char path[256], option[64];
    vvi_text json = {0};
    vv_status st = VV_OK;
    snprintf(path, sizeof path, o->path, edits->view, method);
    cli_option_name(option, vv_class_find(&cli_look_class, o->option));
    if (o->form == FORM_LIMIT && strcasecmp(typed, "none") == 0)
        return vv_model_unset(edits->model, NULL, path);
    if (o->form == FORM_POINT)
        st = cli_value_point(&json, option, typed);
    else if (o->form == FORM_TEXT)
        vvi_text_json(&json, typed);
    if (st == VV_OK && json.bad)
        st = vv_fail_memory(json.n);
    if (st == VV_OK)
        st = set_path(edits, option, o->value ? o->value : json.n ? json.s : typed, path);
    vvi_text_free(&json);
    return st == VV_OK && o->form == FORM_LIMIT ? check_limit(edits, o, typed, path) : st;
}

/* What was typed for an option; of a switch what the property becomes. */
static const char *typed_for(const cli_look *look, const char *option)
{
    const vv_property *row = vv_class_find(&cli_look_class, option);
    if (row->kind != VV_KIND_BOOL)
        return cli_look_text(look, option);
    return *(const bool *)(const void *)((const char *)look + row->offset) ? "true" : NULL;
}

static vv_status edit_ones(cli_edits *edits)
{
    char method[64];
    vv_status st = VV_OK;
    cli_edit_method_of(method, edits);
    for (size_t i = 0; i < sizeof ones / sizeof *ones && st == VV_OK; i++) {
        const char *typed = typed_for(edits->look, ones[i].option);
        if (typed)
            st = edit_one(edits, &ones[i], typed, method);
    }
    return st;
}

/* Paths ----------------------------------------------------------------------------------------------------------- */

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
    const vv_status st = vv_path_expand(&world->base, path, set_one, &(path_edit){edits, equals + 1});
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
    typedef vv_status step(cli_edits * edits);
    static step *const steps[] = {cli_edit_view,     cli_edit_method, cli_edit_switches,      edit_ones,
                                  cli_edit_channels, edit_shading,    cli_edit_transfer,      cli_edit_colors,
                                  cli_edit_clip,     cli_edit_paths,  cli_edit_check_aspects, cli_edit_tell_rays};
    vv_status st = VV_OK;
    for (size_t i = 0; i < sizeof steps / sizeof *steps && st == VV_OK; i++)
        st = steps[i](edits);
    return st;
}
