/** @file
 * Parts, channels and labels of a file, as `info` says them.
 */
#ifndef CLI_INFO_NAMES_H
#define CLI_INFO_NAMES_H
#include "input.h"

/** "#rrggbb", or "#rrggbbaa" where it is not opaque. */
void cli_print_color(char out[16], vv_color color);
/** Every data set of the file, the one that is read marked. */
void cli_info_parts(cli_command *command, const cli_input *input);
/** Name, colour and window of a channel as keys of the object that is open. */
void cli_info_channel_json(vvi_result *json, const vv_channel *channel);
/** "1 DAPI #0000ff, window 0 to 4095"; channel NULL: only its number. */
void cli_info_channel_text(cli_command *command, int component, const vv_channel *channel);
/** Channels without statistics. */
void cli_info_channels(cli_command *command, const cli_input *input);
/** Labels without counts. */
void cli_info_labels(cli_command *command, const cli_input *input);
/** With how often each stands in the field, named or not, and the volume that it takes. */
vv_status cli_info_label_counts(cli_command *command, const cli_input *input, const vv_field *field);
/** How many lines of a list are shown: all with --verbose. */
size_t cli_info_lines(const cli_command *command);
/** What follows a list of n that was cut. */
void cli_info_more(cli_command *command, size_t n);
#endif
