/** @file
 * Channels by their names on the command line.
 */
#ifndef CLI_CHANNEL_NAMES_H
#define CLI_CHANNEL_NAMES_H
#include "label_names.h"

/** "1,0" of "membrane,nuclei" or "green,red": numbers of channels by the names that the file has, or that colours (red,
 * green, blue, alpha) and vectors (x, y, z) have anyway. VV_E_ARGUMENT with what there is. */
vv_status cli_channel_numbers(vvi_text *out, const cli_input *input, const char *words);
/** cli_args_object() for the parameters of an operation: lengths are in the units of `info`, what its input is;
 * --channel takes names too, of a file (NULL: there is none), and options that are labels take `labels`. */
vv_status cli_operation_params(vv_object **out, const cli_command *command, const cli_args *args, const vv_class *cls,
                               const vv_field_info *info, const cli_input *channels, const cli_label_names *labels);
#endif
