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
/** The failure itself, of the scene or measurement `word`. checksum: of what was there; may be NULL. remedy: what to
 * do, as the end of the sentence. */
vv_status cli_fail_moved(const char *word, const char *was, const char *checksum, const char *remedy);
/** The same as a note, for each file of the World that is not there. */
void cli_note_moved(cli_command *command, const vv_world *world, const char *word);
/** What nobody said and was worked out: camera, transfer functions, windows. `fixed` has all of it. */
void cli_tell_choices(cli_command *command, const vv_world *fixed, const char *view, const char *method);
#endif
