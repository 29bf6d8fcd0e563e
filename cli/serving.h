/** @file
 * What `view` and `serve` share.
 */
#ifndef CLI_SERVING_H
#define CLI_SERVING_H
#include "command.h"
#include "server/server.h"

/** Options that both have. */
typedef struct cli_session_options {
    vv_object base;
    int64_t port;
    bool fresh, print_bindings;
    char *socket, *record, *audit, *bindings;
} cli_session_options;
extern const vv_class cli_session_class;

/** What one of them has by itself. NULL and 0: the default. */
typedef struct cli_serving {
    const char *listen, *token, *certificate, *key, *host, *root;
    int clients;
    bool read_only, opens_browser;
    double upload_most;
    const char *note; /* that is told where all of it can be used; NULL: none */
} cli_serving;

/** The folder of all sessions' states, which need not be there; yours to free(). VV_E_WRITE where there is none that is
 * the user's alone. */
vv_status cli_state_root(char **out);
/** Serves the World of the command's words, or an empty one, until Ctrl-C. The verb has cli_session_class. */
vv_status cli_serve(cli_command *command, const cli_serving *serving);
#endif
