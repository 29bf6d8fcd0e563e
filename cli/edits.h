/** @file
 * What people type most about a picture, as edits of the World: each short form is one or a few properties.
 */
#ifndef CLI_EDITS_H
#define CLI_EDITS_H
#include "command.h"
#include "model/contents.h"
#include "render/recipe.h"
#include <volvis/model.h>

/** Short forms of `render`. Unset ones change nothing. */
typedef struct cli_look {
    vv_object base;
    char *method, *mode, *quality, *spp, *noise, *budget, *size, *view;
    char *tf, *range, *percentile, *iso, *threshold, *step, *color, *opacity;
    char *background, *eye, *at, *up, *fov, *parallel, *zoom, *aov;
    char *decorate, *title, *caption;
    char *slice, *window, *cross_hair;
    char *apply;
    vv_collection *clip; /**< of cli_word */
    char *lighting;
    bool no_shading, shadows, ambient_occlusion;
} cli_look;
extern const vv_class cli_look_class;

/** What was typed for an option with a value, by the name of its row; NULL: nothing. */
const char *cli_look_text(const cli_look *look, const char *option);

/** One World being edited. */
typedef struct cli_edits {
    cli_command *command;
    vv_model *model;
    const cli_look *look;
    char view[64];      /**< id of the view that is meant */
    const size_t *ends; /**< volumes of the World up to each of its inputs; NULL: there is one input */
    size_t n_inputs;
} cli_edits;

/**
 * Apply the short forms, then every --set, to the model's World.
 *
 * view     in: id of the view that a picture named, or ""; out: the one to render
 * Errors   VV_E_ARGUMENT, VV_E_NOT_FOUND, each with the option that was at fault
 */
vv_status cli_edits_apply(cli_edits *edits);

/**
 * The World of the command's first word (data, scene, picture) with the short forms and every --set applied; yours to
 * release. recipe_out: what a picture says of itself, and the view that is meant, which the World has.
 */
vv_status cli_edited_world(vv_world **out, vvi_recipe *recipe_out, cli_command *command);

/* Between the files that make the edits ------------------------------------------------------------------------- */

/** Set one property because of an option: a failure names it. value NULL: nothing happens. */
vv_status cli_edit_set(cli_edits *edits, const char *option, const char *value, const char *path_format, ...)
    VV_PRINTF(4, 5);
/** Back to unset. */
vv_status cli_edit_unset(cli_edits *edits, const char *path_format, ...) VV_PRINTF(2, 3);
/** Call for every volume of the World. */
typedef vv_status cli_edit_volume_fn(cli_edits *edits, const char *id, const vv_volume *volume);
vv_status cli_edit_volumes(cli_edits *edits, cli_edit_volume_fn *fn);

/** Call for every volume that a value of an option is for, each time it is given: `typed` is what stands after ID=.
 *
 * ID=VALUE is for the volume of that name. With several inputs a value that is given between two is for the one before,
 * and so is one after the last where others were given before; all others are for every volume. of_values: what the
 * option says is about values, so that one for several volumes passes by meshes that have none. */
typedef vv_status cli_edit_value_fn(cli_edits *edits, const char *typed, const char *id, const vv_volume *volume);
vv_status cli_edit_each(cli_edits *edits, const char *option, bool of_values, cli_edit_value_fn *fn);
/** Whether an option is one of those: --tf, --range, ... */
bool cli_edit_is_each(const cli_given *given);
/** Whether one of them stands between two inputs. */
bool cli_edit_given_between(const cli_args *args, size_t n_inputs);
/** Whether the view's method shows slices. */
bool cli_edit_is_slice(cli_edits *edits);
vv_status cli_edit_colors(cli_edits *edits); /* --color, --opacity */

vv_status cli_edit_method(cli_edits *edits); /* --method, --mode */
/** The method that the view has now: its parameters are found under its name. */
void cli_edit_method_of(char out[64], cli_edits *edits);
/** Options that are parameters of methods: refused where the view's method has none such. */
vv_status cli_edit_check_params(cli_edits *edits, const char *method);
/** Of the World as it is in the end: those are refused where the method's mode has no use for them; where one picture
 * is made of it, so are options about the World. */
vv_status cli_edit_check_aspects(cli_edits *edits);
/** Notes what volumes' own `rays` ask for in vain: of meshes, or of a method that casts none. */
vv_status cli_edit_tell_rays(cli_edits *edits);
/** Whether the view's method, as it is set, shows an aspect of volumes. */
bool cli_edit_heeds(cli_edits *edits, const vv_world *world, vv_aspect aspect);
/** The same of what is seen, whatever the method: --range of labels, --iso of meshes. */
vv_status cli_edit_check_contents(cli_edits *edits, const vv_world *world);
vv_status cli_edit_view(cli_edits *edits);     /* --view, --size */
vv_status cli_edit_transfer(cli_edits *edits); /* --tf, --range, --percentile, --threshold, --window */
vv_status cli_edit_channels(cli_edits *edits);
vv_status cli_edit_clip(cli_edits *edits);     /* --clip */
vv_status cli_edit_switches(cli_edits *edits); /* --aov, --decorate */
vv_status cli_edit_paths(cli_edits *edits);    /* --set */
/** "cube", "scale-bar", ... by number: what --decorate takes, and after them "all" and "none"; NULL past the last. */
const char *cli_decoration_word(size_t index);
/** The layers that a view asks for: vv_layer. */
unsigned cli_layers_of(const vv_view *view);
#endif
