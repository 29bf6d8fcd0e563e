/** @file
 * What `view` and `serve` share.
 */
#ifndef CLI_SERVING_H
#define CLI_SERVING_H
#include "command.h"
#include "server/server.h"

/** How a session is served. NULL and 0: the default. */
typedef struct cli_serving {
    const char *listen, *token, *certificate, *key, *host, *root, *record, *bindings, *audit;
    int port, clients;
    bool read_only, fresh, opens_browser, prints_bindings;
    double upload_most;
} cli_serving;

/** Serves the World of the command's words, or an empty one, until Ctrl-C. */
vv_status cli_serve(cli_command *command, const cli_serving *serving);
#endif
