/** @file
 * What a look at every sample says, as `info --stats` tells it.
 */
#ifndef CLI_INFO_STATISTICS_H
#define CLI_INFO_STATISTICS_H
#include "input.h"

/** Checksum, statistics of each component (in JSON the first one's stand at the top as well), counts of labels. */
vv_status cli_info_statistics(cli_command *command, const cli_input *input, const vv_field *field);
/** What the header says of numbers that stand for no value, where it does. */
void cli_info_missing(cli_command *command, const cli_input *input);
/** Range and mean of each component, in a line. Samples that cannot be read are told, and are no failure: the header
 * could be. */
vv_status cli_info_range(cli_command *command, const cli_input *input, const vv_field *field);
#endif
