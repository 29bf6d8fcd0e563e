/** @file
 * Help, made from the tables: of one verb, of all, of a property path.
 */
#ifndef CLI_HELP_H
#define CLI_HELP_H
#include "core/text.h"
#include "verb.h"

void cli_help_verb(vvi_text *out, const cli_verb *verb, const vv_registry *registry);
void cli_help_overview(vvi_text *out, const vv_registry *registry);
/** Of a property, or of all properties of an object: "lights.key", "views.main.camera.fov". */
vv_status cli_help_path(vvi_text *out, const char *path, const vv_registry *registry);
/** Two columns: what it is called and what it is. */
void cli_help_entry(vvi_text *out, const char *left, const char *right);
#endif
