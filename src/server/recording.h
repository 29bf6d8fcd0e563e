/** @file
 * Recordings of sessions: what pages said, and when what takes time was there, so that it can be played again to the
 * same World. A line of JSON each:
 *
 *     {"volvis session": 1, "world": {...}, "bindings": {...},  the World at first, what is bound,
 *      "files": "..."}                                          where samples are written
 *     {"t": 1000, "page": 1, "joins": true}                     nanoseconds of the server's clock
 *     {"t": 1200, "page": 1, "says": {"type": "hello", ...}}
 *     {"t": 9000, "page": 1, "stands": {"eye": [...], ...}}      its camera was worked out
 *     {"t": 9500, "ends": true, "job": 1}                       the first job that changes the World was done; false:
 * failed
 *     {"t": 9900, "page": 1, "leaves": true}
 *     {"t": 9950, "page": 0, "lost": 3}                          so many lines could not be written (a full disk): it
 * is played up to here
 */
#ifndef VVI_SERVER_RECORDING_H
#define VVI_SERVER_RECORDING_H
#include "core/status.h"
#include "server/camera.h"
#include "server/session.h"
#include <jansson.h>

typedef struct vvi_recording vvi_recording;

/** The file is made; nothing may be there. */
vv_status vvi_recording_open(vvi_recording **out, const char *path);
/** What could not be written is an error here. NULL is fine. */
vv_status vvi_recording_close(vvi_recording *recording);
/** A sentence why the last lines are not there, yours to free(); NULL: all are. The file tells how many are missing as
 * soon as it can be written again. */
char *vvi_recording_problem(const vvi_recording *recording);
/** bindings: JSON of input/bindings.h; files: the folder of samples (NULL: none). */
void vvi_recording_begin(vvi_recording *recording, const vv_world *world, const char *bindings, const char *files);
/** what: "joins" or "leaves". Recording NULL: nothing. */
void vvi_recording_note(vvi_recording *recording, int64_t t, uint64_t page, const char *what);
/** A job that changes the World, the `job`-th that was asked for, has ended. */
void vvi_recording_ends(vvi_recording *recording, int64_t t, uint64_t job, bool done);
/** A camera was worked out: when that was done by a thread of its own is told by no message. */
void vvi_recording_stands(vvi_recording *recording, int64_t t, uint64_t page, const vvi_stand *stand);
/** A message that could be read. */
void vvi_recording_says(vvi_recording *recording, int64_t t, uint64_t page, json_t *message);

/** The World that a recording leads to. options: of the session that plays it, without a state folder; wake is its own.
 * files_root: in a new folder below it samples are written again; NULL: nowhere. keeps: those that the World shows stay
 * there, else none. Errors: VV_E_FORMAT with the line. */
vv_status vvi_recording_play(vv_world **out, const char *path, const vvi_session_options *options,
                             const char *files_root, bool keeps, vv_job *job);
#endif
