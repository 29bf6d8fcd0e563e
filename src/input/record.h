/** @file
 * Recordings of raw events, as text: a first line "volvis input 1", then an event a line (input/event.h); lines that
 * begin with # are remarks.
 */
#ifndef VVI_INPUT_RECORD_H
#define VVI_INPUT_RECORD_H
#include "input/event.h"

/** Appends the first line. */
void vvi_record_begin(vvi_text *out);

/** Called for each event in order; what it returns other than VV_OK ends the replay. */
typedef vv_status vvi_replay_fn(void *user, const vvi_input_event *event);
/** Plays a recording of n bytes. VV_E_FORMAT with the line: no recording, or an event that runs back in time. */
vv_status vvi_replay(const char *text, size_t n, vvi_replay_fn *take, void *user);
#endif
