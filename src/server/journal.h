/** @file
 * What has been done to a World, a line of JSON each, so that a session that breaks off goes on where it was. The first
 * line is the World at first.
 */
#ifndef VVI_SERVER_JOURNAL_H
#define VVI_SERVER_JOURNAL_H
#include "core/status.h"
#include <jansson.h>

typedef struct vvi_journal vvi_journal;

/** More lines than so many bytes are not added. */
enum { VVI_JOURNAL_MOST = 64 << 20 };

/** The journal in a folder, for this process alone: VV_E_ARGUMENT when another has it. */
vv_status vvi_journal_open(vvi_journal **out, const char *folder);
/** keep: it stays to be played again. NULL is fine. */
void vvi_journal_close(vvi_journal *journal, bool keep);
/** Called for each whole line in order; a line that was cut off by a crash ends it, and is cut off the file. n_out: how
 * many there were. A line that cannot be read or played ends it as well: the journal goes on with those before it, and
 * the whole old one stays in the folder under another name (vvi_journal_kept()). */
vv_status vvi_journal_replay(uint64_t *n_out, vvi_journal *journal, vv_status (*play)(void *user, const json_t *line),
                             void *user);
/** Lines that the last vvi_journal_replay() gave up since one before them, or they themselves, could not be read or
 * played; one that was cut off at the end does not count. */
uint64_t vvi_journal_lost(const vvi_journal *journal);
/** A sentence: why the last vvi_journal_replay() went no further, and where the old journal is, or that its last line
 * was cut off; NULL: it went all the way. */
const char *vvi_journal_kept(const vvi_journal *journal);
/** Appends; takes the reference. On failure (a full disk, VVI_JOURNAL_MOST) nothing was appended, and the next may
 * succeed. */
vv_status vvi_journal_add(vvi_journal *journal, json_t *line);
/** The line that was added last was not done after all. */
void vvi_journal_take_back(vvi_journal *journal);
/** Something was done that could not be added: no line is taken before vvi_journal_begin(). */
void vvi_journal_miss(vvi_journal *journal);
/** Whether its file is not there any more: what is added would be lost with the program. */
bool vvi_journal_is_gone(const vvi_journal *journal);
/** Whether the World as it is should take the place of the lines: something is missing, or they have grown long. must:
 * the first of these. */
bool vvi_journal_wants_world(const vvi_journal *journal, bool *must);
/** The World as it is, instead of all lines; takes the reference. What went before cannot be undone by lines that are
 * played: vvi_journal_is_cut(). On failure all stays as it was. */
vv_status vvi_journal_begin(vvi_journal *journal, json_t *world);
bool vvi_journal_is_cut(const vvi_journal *journal);
/** Forgets all lines: a World was opened. */
vv_status vvi_journal_clear(vvi_journal *journal);
/** To the disk. Cheap where nothing was added since. NULL is fine. */
vv_status vvi_journal_sync(vvi_journal *journal);
#endif
