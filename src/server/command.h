/** @file
 * What was done as command lines: what those of pictures, operations and measurements share.
 */
#ifndef VVI_SERVER_COMMAND_H
#define VVI_SERVER_COMMAND_H
#include "server/request.h"

/** A word as a shell takes it, whatever is in it. */
void vvi_command_quote(vvi_text *out, const char *word);
/** What is set of an object, as options of the verb that has its class: " --name=value" each, without those that say
 * nothing beside the others. Errors: VV_E_MEMORY. */
vv_status vvi_command_options(vvi_text *out, const vv_object *params);
/** The file of a dataset, or of what the lines before have made of it, with the options of how it is read. */
void vvi_command_input(vvi_text *out, const vv_world *world, const char *id, vv_job *job);
/** The lines that make a dataset, of what nobody has made here; none where it is such a one itself. */
vv_status vvi_command_making(vvi_text *out, const vv_world *world, const char *id, vv_job *job);

/** The message `command` with a `measurement`: an entry of the World's. */
vv_status vvi_request_command_measure(vvi_client *client, int64_t id, const json_t *message);
#endif
