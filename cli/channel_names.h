/** @file
 * Channels by their names on the command line.
 */
#ifndef CLI_CHANNEL_NAMES_H
#define CLI_CHANNEL_NAMES_H
#include "input.h"

/** "1,0" of "membrane,nuclei" or "green,red": numbers of channels by the names that the file has, or that colours (red,
 * green, blue, alpha) and vectors (x, y, z) have anyway. VV_E_ARGUMENT with what there is. */
vv_status cli_channel_numbers(vvi_text *out, const cli_input *input, const char *words);
/** cli_args_object() for the parameters of an operation on that input: its option --channel takes names too. labels:
 * the input whose labels options name. */
vv_status cli_channel_params(vv_object **out, cli_command *command, const cli_input *input, const cli_input *labels,
                             const vv_class *cls);
#endif
