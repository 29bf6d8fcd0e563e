/** @file
 * The hand-written verbs: one file each in cli/verbs.
 */
#ifndef CLI_VERBS_H
#define CLI_VERBS_H
#include "verb.h"

extern const cli_verb cli_verb_compare, cli_verb_completions, cli_verb_convert, cli_verb_doctor, cli_verb_formats,
    cli_verb_help, cli_verb_info, cli_verb_man, cli_verb_measure, cli_verb_methods, cli_verb_operations, cli_verb_pipe,
    cli_verb_presets, cli_verb_reference, cli_verb_replay, cli_verb_pick, cli_verb_render, cli_verb_schema,
    cli_verb_serve, cli_verb_split, cli_verb_version, cli_verb_view;

/** The verb that an operation is. */
cli_verb cli_verb_of_operation(const vv_operation *operation);
#endif
