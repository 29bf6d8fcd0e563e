/** @file
 * How a property row reads as an option: its spelling, what it takes, its default. One source for help, man pages,
 * completions and the reference.
 */
#ifndef CLI_USAGE_H
#define CLI_USAGE_H
#include "core/text.h"
#include "verb.h"

/** "FILE", "N", "auto|bar|json|none"; "" for switches. */
void cli_usage_value(vvi_text *out, const vv_property *row);
/** "-o, --output FILE"; switches that are on by default read "--no-name". */
void cli_usage_option(vvi_text *out, const vv_property *row);
/** "what it is; 1 to 9; default 3, or how it is worked out" */
void cli_usage_doc(vvi_text *out, const vv_property *row);
/** The same of an option: "--no-name" says what it takes away. */
void cli_usage_option_doc(vvi_text *out, const vv_property *row);
/** Without limits and default. */
void cli_usage_about(vvi_text *out, const vv_property *row);
/** "volvis gaussian [options] INPUT -o FILE" */
void cli_usage_line(vvi_text *out, const cli_verb *verb);
/** Every input of an operation that takes more than one, with what it is; `heading` before the first. */
typedef void cli_usage_entry_fn(vvi_text *out, const char *left, const char *right);
void cli_usage_inputs(vvi_text *out, const cli_verb *verb, const char *heading, cli_usage_entry_fn *fn);
/** Example by number, of a hand-written verb or of an operation; NULL past the end. */
const char *cli_usage_example(const cli_verb *verb, size_t index);
/** Option class of a verb by number, its own first and that of all verbs last; NULL past the end. */
const vv_class *cli_usage_class(const cli_verb *verb, size_t index);
/** The same for help, manuals and completions: options that do nothing are left out. */
const vv_class *cli_usage_shown(const cli_verb *verb, size_t index);

/** Every property path of a World with one of each thing: volumes.ID.visible, lights.ID.intensity, ... */
typedef void cli_usage_path_fn(void *user, const char *path, const vv_property *row);
void cli_usage_paths(const vv_registry *registry, cli_usage_path_fn *fn, void *user);
#endif
