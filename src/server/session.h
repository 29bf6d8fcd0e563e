/** @file
 * A World and the people who look at it. It knows messages and frames, but no socket: whoever has one hands messages
 * in and takes out what is to be sent. docs/protocol.md has all of them.
 *
 * Threads: one, but what is said of `wake`.
 */
#ifndef VVI_SERVER_SESSION_H
#define VVI_SERVER_SESSION_H
#include "core/status.h"
#include <volvis/model.h>

typedef struct vvi_session vvi_session;
typedef struct vvi_client vvi_client;

typedef struct vvi_session_options {
    vv_runtime *runtime;
    const char *root;     /**< no file outside this folder is opened or written */
    const char *state;    /**< folder for the journal, samples and uploads; made when it is not there */
    bool read_only;       /**< nobody changes the World or writes files */
    const char *record;   /**< a file that is made: what pages do (recording.h); NULL: none */
    const char *bindings; /**< what input does, as JSON of input/bindings.h; NULL: the default */
    bool fresh;           /**< a journal that is there is thrown away */
    const char *audit;    /**< a file that is told who came and what they opened (audit.h); NULL: none */
    int clients_most;
    /** Called on any thread when vvi_session_serve() has something to do. */
    void (*wake)(void *user);
    void *user;
} vvi_session_options;

/** Everything is copied. A journal of a session that broke off in `state` is played again. */
vv_status vvi_session_new(vvi_session **out, const vvi_session_options *options);
/** Ends all threads. keep: the journal, samples and uploads stay, as if the program had broken off; else those samples
 * and uploads alone that a saved scene names. VV_E_WRITE: its recording is not whole. */
vv_status vvi_session_free(vvi_session *session, bool keep); /* NULL is fine */
/** What the World is at first. Nothing of it is checked against `root`. */
vv_status vvi_session_begin(vvi_session *session, vv_world *world);
/** What is shown was read from or written to `path` (NULL: from no file): if it is a scene, saving there again needs no
 * `replace`. */
void vvi_session_shows(vvi_session *session, const char *path);
/** Commits of a session that broke off and that have been played again; 0: there was none. */
uint64_t vvi_session_restored(const vvi_session *session);
/** Commits of it that could not, since what was kept is damaged before them. */
uint64_t vvi_session_lost(const vvi_session *session);
/** A sentence: why the rest could not, and where the journal is kept, unless its last line alone was cut off; NULL:
 * all was played again. */
const char *vvi_session_kept(const vvi_session *session);
/** A copy of the World, with the cameras where they rest. */
vv_world *vvi_session_world(vvi_session *session);
/** Takes what threads have done. */
void vvi_session_serve(vvi_session *session);
/** What is due by now, nanoseconds of a clock that does not run back; how long until it should be called again. */
int64_t vvi_session_tick(vvi_session *session, int64_t now);

/** Who comes; it looks, and takes one of the places, when it has said hello. */
vv_status vvi_client_join(vvi_client **out, vvi_session *session, void *user);
void vvi_client_leave(vvi_client *client);
void *vvi_client_user(const vvi_client *client);
/** Where a client is, as text, for the audit. */
void vvi_client_comes_from(vvi_client *client, const char *address);
/** Whether it has said hello. */
bool vvi_client_looks(const vvi_client *client);
/** A text message. A failure: it is none of ours (VV_E_LIMIT: too many look), and the connection should end with the
 * error's text. */
vv_status vvi_client_message(vvi_client *client, const char *text, size_t n, int64_t now);

/** Something to be sent. */
typedef struct vvi_outgoing {
    char *text; /**< free() it; NULL: a frame */
    uint8_t head[32];
    uint8_t *bytes; /**< n of them, for vv_image_bytes_free() */
    size_t n;
    bool breaks; /**< a picture that may be broken off: how fast the line is will be known by how it leaves */
} vvi_outgoing;

/** Whether there is something to send. */
bool vvi_client_has_more(const vvi_client *client, int64_t now);
/** The next thing; false where there is none. */
bool vvi_client_next(vvi_outgoing *out, vvi_client *client, int64_t now);
/** The frame that is under way was broken off: its last n bytes do not leave. */
void vvi_client_broke(vvi_client *client, size_t n);
/** Why the connection should end, a sentence: it takes nothing any more; NULL: it goes on. */
const char *vvi_client_stuck(const vvi_client *client, int64_t now);
/** Whether nothing more should be taken from it before it has read some of what waits for it. */
bool vvi_client_is_full(const vvi_client *client);
/** The next client after one (NULL: the first); NULL at the end. */
vvi_client *vvi_session_client(vvi_session *session, const vvi_client *after);
/** The folder of uploads and samples; NULL: there is none. */
const char *vvi_session_uploads(const vvi_session *session);
/** A folder for a file that comes from a page, yours to free(): a new one, or that of the files that came with the same
 * `batch` ("": it comes alone). */
vv_status vvi_session_upload_folder(char **out, vvi_session *session, const char *batch);
/** VV_E_LIMIT: there is no room for so many bytes of an upload beside what is there and what has come. Nothing is kept
 * for it: who announces much and brings nothing holds nothing. */
vv_status vvi_session_upload_room(vvi_session *session, uint64_t bytes);
/** Whether the disk has room for so many bytes more. */
bool vvi_session_disk_holds(const vvi_session *session, uint64_t bytes);
/** So many bytes of a file without a name came; or (below 0) they are gone, or (named) in a file that has one. */
void vvi_session_upload_came(vvi_session *session, int64_t bytes, bool named);
/** Takes away a file in such a folder that no saved scene names, or what came of it, and the folder where nothing else
 * is in it. */
void vvi_files_remove(const char *path);
/** Where it is written down who came and what they opened; NULL: nowhere. */
struct vvi_audit *vvi_session_audit(vvi_session *session);
/** A picture that was asked for or a file of a shape, by NUMBER/NAME, opened to be read; -1: there is none. The name is
 * borrowed. */
int vvi_session_open_result(const vvi_session *session, const char *place, const char **name_out);
/** Nanoseconds of a clock that never runs back: what every `now` of a session is. */
int64_t vvi_now(void);
#endif
