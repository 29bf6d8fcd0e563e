/** @file
 * What rendering a view would take.
 */
#ifndef CLI_RENDER_PLAN_H
#define CLI_RENDER_PLAN_H
#include "command.h"
#include <volvis/model.h>

/** Reports the plan, as text and JSON; an error when the picture does not fit into the memory limit, unless it is
 * made in parts. What fits is read, and a few tiles are rendered, to tell the time. */
vv_status cli_render_plan(cli_command *command, vv_world *world, const char *view_id, const char *output,
                          bool in_parts);
#endif
