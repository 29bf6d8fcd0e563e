/** @file
 * What was done as command lines: what those of pictures, operations and measurements share.
 */
#ifndef VVI_SERVER_COMMAND_H
#define VVI_SERVER_COMMAND_H
#include "run/made.h"
#include "server/request.h"

/** A word as a shell takes it, whatever is in it. */
void vvi_command_quote(vvi_text *out, const char *word);
typedef void vvi_command_word(vvi_text *out, const char *word);
/** What is set of an object, as options of the verb that has its class: " --name=value" each, without those that say
 * nothing beside the others. put: writes a value, as vvi_command_quote() does for a shell. Errors: VV_E_MEMORY. */
vv_status vvi_command_options(vvi_text *out, const vv_object *params, vvi_command_word *put);
/** Of a recipe, whose lengths keep the units that they were written with. params: what it says, or a part of that. */
vv_status vvi_command_parameters(vvi_text *out, const vvi_made *made, const vv_object *params, vvi_command_word *put);
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

/** The steps from a file to a dataset as one text, "gaussian --sigma=1 | median", without those that are switched off:
 * as `volvis pipe` reads it; *source_out: the id of the dataset that it begins with. Errors: VV_E_ARGUMENT (there is no
 * step, one takes another input that is no plain file), those of its recipe. */
vv_status vvi_command_chain(vvi_text *out, const char **source_out, const vv_world *world, const char *id, vv_job *job);
/** The chain as a whole line of `volvis pipe`. */
vv_status vvi_command_pipe(vvi_text *out, const vv_world *world, const char *id, vv_job *job);

/** One step of a chain behind those that are there, " | simplify --share=0.5". lines: inputs beside the first one are
 * made by lines before; else VV_E_ARGUMENT where one is no file. */
vv_status vvi_command_chain_step(vvi_text *out, const vvi_made *made, bool lines, vv_job *job);
/** Where a dataset is when its lines have run. first: with the options of how it is read, else as FILE:PART; put:
 * writes names of files. */
vv_status vvi_command_file(vvi_text *out, const vv_world *world, const char *id, bool first, vvi_command_word *put,
                           vv_job *job);

/** A recipe that is open: false: a file, or what older versions wrote. *out is for vvi_made_close() in any case. */
bool vvi_command_open_made(vvi_made *out, const vv_world *world, const vv_dataset *dataset, vv_job *job);
/** Of the files that lines make: samples go back into a format that alone keeps what their file says. */
const char *vvi_command_suffix(const vv_world *world, const vv_dataset *dataset, vv_job *job);
/** The file that the lines before have made of a dataset. */
void vvi_command_made(vvi_text *out, const char *id, const char *suffix);
/** Whether a line names it without options of how it is read, as FILE:PART. */
bool vvi_command_is_plain(const vv_dataset *dataset);

/** The message `command` with a `measurement`: an entry of the World's. */
vv_status vvi_request_command_measure(vvi_client *client, int64_t id, const json_t *message);
#endif
