/** @file
 * Completion scripts for shells, made from the tables.
 */
#ifndef CLI_COMPLETIONS_H
#define CLI_COMPLETIONS_H
#include "core/text.h"
#include "verb.h"

void cli_completions_bash(vvi_text *out, const vv_registry *registry);
void cli_completions_zsh(vvi_text *out, const vv_registry *registry);
void cli_completions_fish(vvi_text *out, const vv_registry *registry);

/** The choices of an option's row with spaces between; false when there are none. Property paths end with "=". */
bool cli_completions_choices(vvi_text *out, const vv_registry *registry, const vv_property *row);
/** The same for what stands without dashes; files are no list. */
bool cli_completions_words(vvi_text *out, const vv_registry *registry, const cli_verb *verb);
/** `s` inside single quotes of a POSIX shell, without the quotes themselves. */
void cli_completions_quote(vvi_text *out, const char *s);
#endif
