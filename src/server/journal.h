/** @file
 * What has been done to a World, a line of JSON each, so that a session that breaks off goes on where it was. The first
 * line is the World at first.
 */
#ifndef VVI_SERVER_JOURNAL_H
#define VVI_SERVER_JOURNAL_H
#include "core/status.h"
#include <jansson.h>

typedef struct vvi_journal vvi_journal;

/** The journal in a folder, for this process alone: VV_E_ARGUMENT when another has it. */
vv_status vvi_journal_open(vvi_journal **out, const char *folder);
/** keep: it stays to be played again. NULL is fine. */
void vvi_journal_close(vvi_journal *journal, bool keep);
/** Called for each whole line in order; a line that was cut off by a crash ends it, and is cut off the file. n_out: how
 * many there were. What play() returns other than VV_OK is passed on, and the journal begins anew. */
vv_status vvi_journal_replay(uint64_t *n_out, vvi_journal *journal, vv_status (*play)(void *user, const json_t *line),
                             void *user);
/** Lines that the last vvi_journal_replay() gave up since one before them, or they themselves, were damaged; one that
 * was cut off at the end does not count. */
uint64_t vvi_journal_lost(const vvi_journal *journal);
/** Appends; takes the reference. What cannot be written is said once, and the session goes on without. */
vv_status vvi_journal_add(vvi_journal *journal, json_t *line);
/** Forgets all lines: a World was opened. */
vv_status vvi_journal_clear(vvi_journal *journal);
/** To the disk. Cheap where nothing was added since. */
void vvi_journal_sync(vvi_journal *journal);
#endif
