/** @file
 * Limits on what comes from outside, as the environment and the command line say them.
 */
#ifndef CLI_LIMIT_WORDS_H
#define CLI_LIMIT_WORDS_H
#include "options.h"
#include <volvis/runtime.h>

/** The defaults, then VOLVIS_LIMITS="NAME=VALUE,...", then each --limit NAME=VALUE. */
vv_status cli_limits_read(vv_limits *out, const cli_common *common);
#endif
