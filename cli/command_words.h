/** @file
 * The words of a command line: inputs, and the output where it is one of them.
 */
#ifndef CLI_COMMAND_WORDS_H
#define CLI_COMMAND_WORDS_H
#include "command.h"

/** The OUT of "convert IN OUT" and "isosurface IN OUT", which no -o names; NULL: there is none. */
const char *cli_command_output_word(const cli_args *args, const cli_verb *verb, const vv_registry *registry);
/** "convert IN OUT": never over a file that exists, which may be an input that somebody forgot a verb for. */
vv_status cli_command_take_output(cli_command *command);
/** VV_E_ARGUMENT: too few words, too many, or options that do not go together. */
vv_status cli_command_check_words(const cli_command *command);
#endif
