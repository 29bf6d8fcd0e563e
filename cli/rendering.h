/** @file
 * What `render` has in hand, for its verb and for what writes and tells of the picture.
 */
#ifndef CLI_RENDERING_H
#define CLI_RENDERING_H
#include "command.h"
#include "render/recipe.h"
#include <volvis/render.h>

typedef struct cli_render_options {
    vv_object base;
    int64_t bits, image_quality, repeat;
    double dpi;
    char *save_scene, *output_format, *resume;
} cli_render_options;

/** A picture on its way, from the World that is edited to its file. */
typedef struct cli_rendering {
    cli_command *command;
    const cli_render_options *options;
    const char *output;
    char suffix[16]; /* of the format that standard output gets; "": none was asked for */
    char named[24];  /* a file of that format, to ask what it can hold; else "" */
    vv_world *world; /* after the edits */
    vvi_recipe recipe;
    vv_image_options image_options; /* without text */
    vv_image *image;
    bool at_once;   /* memory has room for all of it */
    bool in_parts;  /* it is larger than memory, and made as it is written */
    bool is_figure; /* SVG */
    char *figure;
    vv_render_report first, last;
    char *checkpoint; /* of --resume; NULL: none */
    bool resumed, saved;
    double done; /* share of the picture, 0..1, where it was stopped */
    double load_s, first_s, render_s, write_s;
    vv_field **fields; /* of the volumes, kept so that loading is timed apart and happens once */
    vv_mesh **meshes;  /* the same */
    size_t n_fields, n_meshes;
} cli_rendering;

/** The view that is rendered. */
const vv_view *cli_rendering_view(const cli_rendering *rendering);
/** The picture or figure, and the scene that was asked for, with all that was chosen. */
vv_status cli_rendering_write(cli_rendering *rendering);
/** What was made of what, in which time. */
void cli_rendering_report(cli_rendering *rendering);
#endif
