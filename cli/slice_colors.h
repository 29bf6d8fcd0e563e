/** @file
 * From a sample to its colour on a screen: grey, channels, labels, the data's own colours.
 */
#ifndef CLI_SLICE_COLORS_H
#define CLI_SLICE_COLORS_H
#include "input.h"

typedef struct cli_slice_colors cli_slice_colors;

vv_status cli_slice_colors_new(cli_slice_colors **out, const cli_input *input);
void cli_slice_colors_free(cli_slice_colors *colors); /* NULL is fine */
/** Takes a sample into account for windows that nobody gave. */
void cli_slice_colors_look(cli_slice_colors *colors, const char *sample);
/** After the last one. Errors: VV_E_MEMORY. */
vv_status cli_slice_colors_settle(cli_slice_colors *colors, vv_job *job);
/** Red, green and blue, sRGB encoded, 0..1. */
void cli_slice_color(float rgb_out[3], const cli_slice_colors *colors, const char *sample);
bool cli_slice_colors_nearest(const cli_slice_colors *colors);
#endif
