/** @file
 * Man pages and the reference in Markdown, made from the tables.
 */
#ifndef CLI_MANUAL_H
#define CLI_MANUAL_H
#include "core/text.h"
#include "verb.h"

/** volvis-VERB.1 in roff. */
void cli_manual_verb(vvi_text *out, const cli_verb *verb);
/** volvis.1. */
void cli_manual_program(vvi_text *out, const vv_registry *registry);
/** Verbs, formats, methods, presets and every property of a World, in Markdown. */
void cli_manual_reference(vvi_text *out, const vv_registry *registry);
#endif
