/** @file
 * What rendering a view would take.
 */
#ifndef CLI_RENDER_PLAN_H
#define CLI_RENDER_PLAN_H
#include "command.h"
#include <volvis/model.h>

/** Reports the plan, as text and JSON; an error when the picture does not fit into the memory limit. Samples are not
 * read, meshes are. */
vv_status cli_render_plan(cli_command *command, const vv_world *world, const vv_view *view, const char *output);
#endif
