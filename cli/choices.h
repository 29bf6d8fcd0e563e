/** @file
 * The tables that words of the command line are chosen from: for completion, for help, and for what was typed.
 */
#ifndef CLI_CHOICES_H
#define CLI_CHOICES_H
#include "args.h"

/** Name by number of what a table holds: "verbs", "formats", "renderers", "operations", "presets", "encodings",
 * "types", "modes", "qualities", "directions", "planes", "layers", "colormaps", "lightings"; NULL past the end, and for
 * tables that are no such list. */
const char *cli_choice_nth(const vv_registry *registry, const char *table, size_t index);
/** What an option may be given, by number: names of an enum, or of the table it is chosen from; else NULL. */
const char *cli_choice_of_row(const vv_registry *registry, const vv_property *row, size_t index);
/** The choice that a typed word is: as it is in the table where `typed` differs by the case of letters alone and no
 * other does, an alias's name; `typed` itself where there is none. */
const char *cli_choice_word(const vv_registry *registry, const vv_property *row, const char *typed);
/** The same of every option that was given and takes a word of a table, and of the verb's own words. Files and views of
 * the user's own that are called so go first. */
void cli_choice_settle(cli_args *args, const cli_verb *verb, const vv_registry *registry);
/** A failure that names the nearest of a table, and lists all: "there is no preset 'typed'; ...". */
vv_status cli_choice_fail(vv_status status, const vv_registry *registry, const char *table, const char *sentence,
                          const char *typed);
#endif
