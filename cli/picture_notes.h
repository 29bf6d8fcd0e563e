/** @file
 * What is said of a picture beside its numbers.
 */
#ifndef CLI_PICTURE_NOTES_H
#define CLI_PICTURE_NOTES_H
#include "command.h"
#include <volvis/model.h>

/** A failure to read: where the data of a scene or a picture were moved, or have another name now, it says so. */
vv_status cli_fail_moved(const vv_world *world, const char *word, vv_status st);
/** What nobody said and was worked out: camera, transfer functions, windows. `fixed` has all of it. */
void cli_tell_choices(cli_command *command, const vv_world *fixed, const char *view, const char *method);
#endif
