/** @file
 * The file of defaults: options that hold where the command line says nothing else.
 *
 *     # a comment
 *     --threads 4                             every verb
 *     render --size 1024 --background white   one verb
 */
#ifndef CLI_DEFAULTS_H
#define CLI_DEFAULTS_H
#include "args.h"
#include "core/text.h"

typedef struct cli_defaults {
    char *path;    /**< of the file; NULL: none is in use */
    char *text;    /**< its text, cut into words */
    char **places; /**< "PATH:LINE" of every line that was taken */
    size_t n_places;
    vvi_text taken; /**< "--size 1024 --background white": what this run has of it */
} cli_defaults;

/** $VOLVIS_DEFAULTS, else volvis/defaults in $XDG_CONFIG_HOME or ~/.config; yours to free(). NULL: "none" was chosen,
 * or nobody knows where home is. *named: somebody chose it, so it has to be there. */
char *cli_defaults_path(bool *named);
/**
 * Put what the file says for the verb before what was given; the command line wins. verb NULL: all lines are checked,
 * and nothing is taken.
 *
 * Errors  VV_E_ARGUMENT with file and line, VV_E_READ
 */
vv_status cli_defaults_take(cli_defaults *out, cli_args *args, const cli_verb *verb, const vv_registry *registry);
/** Leave out what came from the file for one class; `row` NULL: all of it. */
void cli_defaults_drop(cli_args *args, const vv_class *cls, const char *row);
/** "--size 1024 --background white": what `args` has of it. */
void cli_defaults_list(vvi_text *out, const cli_args *args);
/** The same of one option, after others. */
void cli_defaults_spell(vvi_text *out, const cli_given *given);
void cli_defaults_free(cli_defaults *defaults);
#endif
