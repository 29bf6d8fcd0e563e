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
/** NULL: there is none of that id. */
const vv_dataset *vvi_command_dataset(const vv_world *world, const char *id);
/** The one that lines take for it, and its id: of one whose operation is switched off its first input. VV_E_NOT_FOUND:
 * there is neither a file of it nor an operation. */
vv_status vvi_command_behind(const vv_dataset **out, const char **id, const vv_world *world, vv_job *job);
/** The file of a dataset, or of what the lines before have made of it, with the options of how it is read. Errors: as
 * above. */
vv_status vvi_command_input(vvi_text *out, const vv_world *world, const char *id, vv_job *job);
/** The lines that make a dataset, of what nobody has made here; none where it is such a one itself. Errors: those of
 * its recipe. */
vv_status vvi_command_making(vvi_text *out, const vv_world *world, const char *id, vv_job *job);

/** The message `command` with a `measurement`: an entry of the World's. */
vv_status vvi_request_command_measure(vvi_client *client, int64_t id, const json_t *message);
#endif
