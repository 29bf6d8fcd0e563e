/** @file
 * --missing: which values stand for none.
 */
#ifndef CLI_MISSING_H
#define CLI_MISSING_H
#include "input.h"

enum { CLI_MISSING_MOST = 64 };

typedef struct cli_missing {
    bool given;
    double value[CLI_MISSING_MOST]; /**< n of them; none: every value is one */
    size_t n;
} cli_missing;

/** What the command says. VV_E_ARGUMENT: no numbers, or too many. */
vv_status cli_missing_read(cli_missing *out, const cli_command *command);
/** It in the input, whose samples are NaN there from now on; else what a scene says of its volume, or nothing (NULL).
 */
vv_status cli_missing_take(cli_input *input, cli_command *command, const vv_volume *volume);
/** It in all volumes of a World. VV_E_ARGUMENT where there are meshes alone. */
vv_status cli_missing_set(vv_world **world, cli_command *command);
#endif
