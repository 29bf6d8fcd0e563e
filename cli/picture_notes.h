/** @file
 * What is said of a picture beside its numbers.
 */
#ifndef CLI_PICTURE_NOTES_H
#define CLI_PICTURE_NOTES_H
#include "command.h"
#include <volvis/model.h>

/** A failure to read: where the data of a scene or a picture were moved, have another name now, or have changed, it
 * says so, and what to do. */
vv_status cli_fail_data(const cli_command *command, const vv_world *world, const char *word, vv_status st);
/** What nobody said and was worked out: camera, transfer functions, windows. `fixed` has all of it. */
void cli_tell_choices(cli_command *command, const vv_world *fixed, const char *view, const char *method);
#endif
