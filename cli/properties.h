/** @file
 * Property rows as results: lines for people and entries for programs.
 */
#ifndef CLI_PROPERTIES_H
#define CLI_PROPERTIES_H
#include "command.h"

/** An array `key` of {name, kind, doc, default, ...} for a class's rows. */
void cli_properties_json(vvi_result *json, const char *key, const vv_class *cls);
/** Two-column lines, each name after `prefix`; as_options: "--name VALUE", else "name=VALUE". */
void cli_properties_text(vvi_text *out, const char *prefix, const vv_class *cls, bool as_options);
#endif
