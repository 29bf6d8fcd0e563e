/** @file
 * The words of an operation's command line: its formula, where it has one, and its inputs by their names.
 */
#ifndef CLI_OPERANDS_H
#define CLI_OPERANDS_H
#include "args.h"
#include "core/text.h"

/** Where the verb is an operation: gives the first word to the parameter that stands without dashes, puts inputs that
 * are named (NAME=FILE) in their places, and gives names that people chose to the parameter that takes them. Errors:
 * VV_E_ARGUMENT. */
vv_status cli_operands_take(cli_args *args, const cli_verb *verb);
/** An input as the help shows it: "INPUT", "[NAME=]INPUT...", "markers=FILE". */
void cli_operand_usage(vvi_text *out, const vv_operation *operation, const vv_operand *operand);
/** All that stands without dashes, as the usage line shows it: " INPUT [markers=FILE] [mask=FILE]". */
void cli_operands_line(vvi_text *out, const vv_operation *operation);
/** The same in short, as errors say it. */
const char *cli_operands_usage(const vv_operation *operation);
#endif
