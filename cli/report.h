/** @file
 * What leaves the program: the result on standard output, the error on standard error, and the exit code.
 */
#ifndef CLI_REPORT_H
#define CLI_REPORT_H
#include "command.h"

/** The exit code of a failure. `output` is the file that was to be made, or NULL. */
int cli_report_exit_code(vv_status status, const char *output);
/** This thread's last error: one sentence, and with `json` {"error": {...}} on standard output. Its exit code. */
int cli_report_error(vv_status status, const char *output, bool json, bool quiet);
/** Print the result, or write it to -o. */
vv_status cli_report_result(cli_command *command);
/** A text file that appears whole or not at all. */
vv_status cli_report_file(cli_command *command, const char *path, const char *text, size_t n);
#endif
