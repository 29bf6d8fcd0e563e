/** @file
 * Inside a session, between its files.
 */
#ifndef VVI_SERVER_SESSION_IMPL_H
#define VVI_SERVER_SESSION_IMPL_H
#include "core/cache.h"
#include "core/result.h"
#include "input/input.h"
#include "model/contents.h"
#include "server/audit.h"
#include "server/journal.h"
#include "server/pace.h"
#include "server/painter.h"
#include "server/poses.h"
#include "server/recording.h"
#include "server/session.h"
#include "server/tasks.h"
#include "server/text_queue.h"
#include <jansson.h>
#include <stdatomic.h>

/** How long after its last motion a view is at rest, nanoseconds. */
#define VVI_REST (INT64_C(150) * 1000000)
#define VVI_CAMERA "camera" /* who commits cameras: undo of people passes them by */

/** Which frames a client is sent. */
typedef enum vvi_frames {
    VVI_FRAMES_ALL,
    VVI_FRAMES_RESTING, /* none while a hand moves the view: the page draws that itself */
    VVI_FRAMES_NONE     /* it draws everything itself; poses and what was worked out are told all the same */
} vvi_frames;

/* Characters of the World as it is told: some 20000 labels with names and colours. */
enum { VVI_WORLD_MOST = 4 << 20 };

/* A client that was told the World before these, or before one with longer paths, is told that all of it may have
 * changed. */
enum { VVI_CHANGES_KEPT = 64, VVI_CHANGE_BYTES = 8192 };

/* What a client has set last. */
typedef struct vvi_again {
    char *paths; /* NULL: it did something else */
    int64_t at;
    int times; /* in a row */
    uint64_t commit;
} vvi_again;

struct vvi_client {
    vvi_session *session;
    vvi_client *next;
    void *user;
    uint64_t serial; /* of all clients that ever were */
    int slot;        /* of the painter; -1: it has not said hello */
    char view[VVI_VIEW_NAME];
    const char *plane; /* that it asked for; NULL: none */
    char address[48];  /* where it is, for the audit */
    bool greeted;
    bool refused; /* the last message was */
    int32_t width, height;

    vvi_input *input;
    uint64_t changes; /* of the pose, that were seen */
    bool has_stand;
    vvi_stand stand;       /* its pose is the virtual device's at times of change */
    uint64_t stands_since; /* the commit that gave its view the camera which is worked out */
    int64_t moved, event;
    bool moving, unsaved; /* unsaved: the pose is not yet the World's */
    vvi_poses poses;      /* where it came to rest */

    vvi_pace pace;
    vvi_outbox box;
    uint64_t numbers;    /* of frames */
    uint64_t wishes;     /* so often was the view to be drawn again */
    bool tells_outdated; /* that frame is final no more, and was not said to be */
    bool broke;          /* the frame that is under way was broken off */
    bool told_final;     /* nothing better than the frame that was sent last would come, it was told */
    bool told_failed;    /* no frame would come, it was told */
    vvi_painted sent, waiting;
    int64_t pixels; /* of the frame under way */
    double seconds;
    bool wants, wants_coarse;
    bool wants_whole; /* however many bytes it has */
    double rate;      /* frames a second, of late */
    int64_t last_ack;
    double latency;

    vvi_text_queue lines;
    bool overrun; /* more waited than may */
    bool tells_world, tells_cameras, tells_pose, tells_status;
    int64_t world_told; /* when it was told last */
    int64_t world_rest; /* until it is told again at the earliest, nanoseconds */
    vv_world *known;    /* what it was told, held; NULL: it is to be told all of it */
    uint64_t known_commit;
    uint64_t changes_told;
    bool text_was_last; /* of what was sent: a frame that waits comes next */
    char gesture[64];
    vvi_again again;
    vvi_frames frames;
    bool turning;    /* it is moved by hand, not edited */
    int64_t shape;   /* the task that makes the newest one that was asked for; 0: none */
    int64_t preview; /* the same of a preview */
};

/* A file that is on no disk. */
typedef struct vvi_made_memory {
    int fd; /* 0: none */
    size_t n;
    vv_runtime *counted_in;
} vvi_made_memory;

typedef struct vvi_made_file {
    struct vvi_made_file *next;
    int64_t number;
    char *path, *name;
    vvi_cached *shape;      /* whose file it is, pinned; NULL: a picture */
    vvi_made_memory memory; /* where it is, if nothing is written */
    uint64_t serial;        /* of pictures: of the client that asked */
} vvi_made_file;

enum { VVI_BATCHES = 64, VVI_BATCH_NAME = 65 };

/* Uploads that came together. */
typedef struct vvi_batch {
    char name[VVI_BATCH_NAME]; /* "": none */
    int64_t folder;
} vvi_batch;

/* What makes one World of another, as text: many clients know the same one. Zeroed is valid. */
typedef struct vvi_told_changes {
    vv_world *from, *to; /* held */
    char *text;          /* NULL: the whole is shorter */
} vvi_told_changes;

struct vvi_session {
    vvi_session_options options;
    char *root, *state, *uploads;
    char *saved;    /* real path of the scene that was opened or saved last, if it is what is shown; NULL: none */
    char *bindings; /* JSON */
    char **given;   /* real paths of files that the World had at first, wherever they are */
    size_t n_given;
    vv_model *model;
    vvi_painter *painter;
    vvi_tasks *slow, *quick;
    vvi_client *clients;
    uint64_t serials;
    bool slots[VVI_PAINTER_VIEWS];
    uint64_t commit;
    uint64_t scene;                /* the last commit that was more than a camera */
    char *told;                    /* the World as it is told, printed once for each commit */
    uint64_t told_commit;          /* NULL: of none */
    size_t told_bytes;             /* of the last one that was printed */
    vvi_told_changes changes;      /* that were told last */
    char *who;                     /* of the last commit */
    char *paths[VVI_CHANGES_KEPT]; /* of the last commits, the newest at n_changes - 1: JSON without brackets */
    uint64_t n_changes;
    vvi_journal *journal;
    vvi_audit *audit;         /* NULL: none */
    vvi_recording *recording; /* NULL: none */
    bool is_played;           /* by a recording, which says where pages stand */
    uint64_t n_asked;         /* jobs that change the World; their numbers, which do not count other jobs */
    uint64_t n_ended;         /* of them, done or failed */
    uint64_t awaited;         /* of a recording: the one that ended next then; 0: any */
    vv_status last_ended;     /* how the last of them did */
    uint64_t restored, lost;  /* commits of a session that broke off */
    char *unkept, *unaudited, *unrecorded; /* why the last change, or what was done last, could not be written down, as
                                              all were told; NULL: it was */
    bool mended;         /* all were told that the journal is written anew, which has not been done yet */
    bool told_forgotten; /* that the oldest changes can be undone no more */
    vvi_made_file *files;
    _Atomic int64_t file_numbers; /* of shapes they are taken by another thread */
    int64_t upload_folders, picture_folders;
    uint64_t kept_before;           /* bytes in its folder that scenes of earlier sessions name */
    _Atomic uint64_t coming;        /* bytes that are there of uploads without a name, and of what is being written */
    _Atomic uint64_t written;       /* bytes of files outside that pages have written, beyond those in their place */
    uint64_t weighed, named;        /* bytes: of all when they were weighed for an upload; of uploads named since */
    int64_t weighed_at;             /* 0: never */
    int64_t cleared;                /* when files that nobody can see were last looked for; 0: never */
    vvi_batch batches[VVI_BATCHES]; /* the last ones */
    size_t n_batches;
    uint64_t opener;       /* serial of who opened last what is shown; 0: nobody */
    vvi_warnings warnings; /* of files, that were told since */
    int64_t told_job;      /* whose progress was told last */
    int64_t next_job_notice;
};

/* client.c ------------------------------------------------------------------------------------------------------- */

/** One of the places of those who look; they give it back when they leave. VV_E_LIMIT: there is none. */
vv_status vvi_client_take_place(vvi_client *client);
/** The view should be drawn again: a picture that was told to be final is so no more, and the page hears of that before
 * anything that is said from now on. */
void vvi_client_want(vvi_client *client, bool coarse, int64_t now);
void vvi_client_serve(vvi_client *client, int64_t now);
int64_t vvi_client_tick(vvi_client *client, int64_t now);
/** As the audit names it. */
vvi_actor vvi_client_actor(const vvi_client *client);
/** Whether nothing better than what was painted will come. */
bool vvi_client_is_final(const vvi_client *client, const vvi_painted *painted);
/** The pose has moved. */
void vvi_client_moved(vvi_client *client, int64_t now);
/** The camera of its view was worked out. */
void vvi_client_stand(vvi_client *client, const vvi_stand *stand);
/** The World has another camera for its view: it is worked out of that, and of no older World. */
void vvi_client_stand_anew(vvi_client *client);
/** The pose becomes the World's camera, where it is not. */
vv_status vvi_client_save_camera(vvi_client *client);
/** The same where it was never moved too: what would fit anew, or to another size, stays as it is seen. */
vv_status vvi_client_fix_view(vvi_client *client);

/* client_view.c -------------------------------------------------------------------------------------------------- */

/** At its greeting: a view of the World that nobody else looks through, made where there is none. plane: "axial",
 * "coronal" or "sagittal", NULL: no slice. VV_E_FORMAT: there is no such plane. */
vv_status vvi_client_choose_view(vvi_client *client, const char *plane);
/** A World that is about to take the place of what there is gets the views that people look through: where it has none
 * of that name, one like its first, or the plane that was asked for. */
vv_status vvi_session_add_views(vv_world **world, const vvi_session *session);
/* client_texts.c ------------------------------------------------------------------------------------------------- */

/** Queues a text; takes it. NULL: there was no memory, and the client is overrun. */
void vvi_client_say(vvi_client *client, char *text);
/** The same for news that newer ones of their kind replace. */
void vvi_client_tell(vvi_client *client, vvi_line_kind kind, char *text);
/** Everybody who was greeted is told; takes the text, NULL is fine. */
void vvi_session_tell(const vvi_session *session, vvi_line_kind kind, char *text);
/** How many look, and to tell it to all of them. */
int vvi_session_looking(const vvi_session *session);
void vvi_session_tell_number(const vvi_session *session);
void vvi_client_say_result(vvi_client *client, vvi_result *result);
void vvi_client_notice(vvi_client *client, const char *level, const char *text);
/** Where it stands, if that is news: whoever hears the next answer knows it. */
void vvi_client_tell_pose(vvi_client *client);
/** Warnings of files that are read, which were not told since something was opened. */
void vvi_client_warn(vvi_client *client, const char *warnings);
/** Answers a message: value is JSON text, NULL: null. id 0: nobody waits for it. */
void vvi_client_answer(vvi_client *client, int64_t id, const char *value);
/** The thread's error as the answer. */
void vvi_client_refuse(vvi_client *client, int64_t id);
/** The same with a `reason`, a word by which the page knows what to offer. */
void vvi_client_refuse_for(vvi_client *client, int64_t id, const char *reason);
/** What was put into `value`, which is taken; null where that is nothing. Refused where st says so (reason may be
 * NULL), or where there was no memory for it. */
void vvi_client_answer_result(vvi_client *client, int64_t id, vvi_result *value, vv_status st, const char *reason);
/** When it is told the World, nanoseconds; INT64_MAX: it knows it. */
int64_t vvi_client_world_due(const vvi_client *client);

/* session_commits.c ---------------------------------------------------------------------------------------------- */

/** Of the model: whom a commit concerns is told, and gets another frame where it is seen. user: the session. */
void vvi_session_note_commit(void *user, const vv_commit *commit, const vv_world *world);
/** The World as JSON text; NULL: there is no memory. The session's, until the next commit. */
const char *vvi_session_told(vvi_session *session);
/** What makes `world`, the one that there is, of one that was told before, as JSON text. NULL: all of it is told, since
 * it is small, or not much larger than its changes. The session's, until it is asked again. */
const char *vvi_session_changes(vvi_session *session, const vv_world *known, const vv_world *world);
/** How long a client that was told so many bytes of the World waits for the next ones, nanoseconds. */
int64_t vvi_session_world_rest(const vvi_session *session, size_t bytes);
void vvi_told_changes_free(vvi_told_changes *changes);

/* session.c ------------------------------------------------------------------------------------------------------ */

/** Every view stays as it is seen. */
vv_status vvi_session_fix_views(vvi_session *session);
/** Of a session without a state folder: what it writes goes there. */
vv_status vvi_session_write_below(vvi_session *session, const char *folder);
vvi_client *vvi_session_find(const vvi_session *session, uint64_t serial);
/** What input of those who join from now on does, as JSON; NULL: the default. On failure nothing changes. */
vv_status vvi_session_bind(vvi_session *session, const char *bindings);
/** A job that changes the World has ended, the `asked`-th that was asked for. */
void vvi_session_note_end(vvi_session *session, uint64_t asked, vv_status status);

/* made_files.c --------------------------------------------------------------------------------------------------- */

void vvi_made_file_free(vvi_made_file *file);
/** The bytes are copied, and counted in the job's runtime. */
vv_status vvi_made_memory_new(vvi_made_memory *out, const uint8_t *bytes, size_t n, vv_job *job);
void vvi_made_memory_free(vvi_made_memory *memory); /* zeroed is fine */
/** Takes it; the oldest pictures go where there are many. */
void vvi_made_files_add_picture(vvi_session *session, vvi_made_file *file);
/** Whoever asked has left: what is in memory goes. */
void vvi_made_files_leave(vvi_session *session, uint64_t serial);

/* edits.c -------------------------------------------------------------------------------------------------------- */

/** One commit of `edits` (docs/protocol.md); of a gesture that was there before, joined to the last one. */
vv_status vvi_session_edit(vvi_session *session, const char *who, const json_t *edits, bool join);
vv_status vvi_session_undo(vvi_session *session, const char *who, bool redo);
vv_status vvi_session_replace(vvi_session *session, const char *who, vv_world *world);
/** Nothing is there any more but the views that people look through; a commit like any other. */
vv_status vvi_session_empty(vvi_session *session, const char *who);
/** A line of the journal, played again. */
vv_status vvi_session_replay(vvi_session *session, const json_t *line);
/** VV_E_ARGUMENT: the World names a file outside the root. */
vv_status vvi_session_check_files(const vvi_session *session, const vv_world *world);
/** VV_E_LIMIT: it is longer than VVI_WORLD_MOST as it is told. */
vv_status vvi_session_check_size(const vv_world *world);
/** The files of a World that was begun with may be read, wherever they are. */
vv_status vvi_session_give_files(vvi_session *session, const vv_world *world);

/* kept_edits.c
 * --------------------------------------------------------------------------------------------------------- */

/** Before each change, outside of a commit: where the journal has grown long or lacks something, the World as it is
 * takes the place of its lines. A failure: the change is not to be made, but for those of cameras. */
vv_status vvi_session_keep_begin(vvi_session *session);
/** Before a change is made: its line; takes the reference. A failure (a full disk) is told to all: it is not to be
 * made. vvi_journal_take_back() if it then fails. */
vv_status vvi_session_keep(vvi_session *session, const char *who, json_t *line);
/** The same of a World that takes the place of what there is. */
vv_status vvi_session_keep_world(vvi_session *session, const char *who, const vv_world *world);
/** What was written down goes to the disk, and what could not be is told. */
void vvi_session_keep_sync(vvi_session *session);
/** One who comes is told what all were told, as far as it is still so. */
void vvi_session_tell_problems(vvi_client *client);

/* message_text.c ------------------------------------------------------------------------------------------------------
 */

/** A page's message, yours to json_decref(); NULL: no JSON, or there is no memory for it. Whole numbers beyond 2^63 are
 * real ones. `flaw`: NULL, or a sentence why it cannot be taken though its type and id can be read. */
json_t *vvi_message_read(const char **flaw, bool *no_memory, const char *text, size_t n);

/* edit_again.c --------------------------------------------------------------------------------------------------- */

/** Whether these edits set what the client has set twice a moment ago, and nothing was committed since; they are what
 * it sets last from here on, and client->again.commit is to be the commit that they become. */
bool vvi_client_sets_again(vvi_client *client, const json_t *edits, int64_t now);

/* edit_names.c
 * ---------------------------------------------------------------------------------------------------------- */

/** Names of presets and colour maps that `before` had not at the same place are of those there are: VV_E_NOT_FOUND with
 * the nearest. Those of files may be of a newer VolVis, and hinder no edit. */
vv_status vvi_session_check_names(const vv_world *world, const vv_world *before);

/* files.c -------------------------------------------------------------------------------------------------------- */

/** The real path of a file or folder that a page names, inside the root; yours to free(). VV_E_NOT_FOUND,
 * VV_E_ARGUMENT where reading it might not end. `fresh`: it need not be there, but its folder. */
vv_status vvi_files_resolve(char **out, const vvi_session *session, const char *path, bool fresh);
/** The same of "FILE:PART" too, where nothing has that name: the part behind the longest name of something, yours to
 * free(); NULL: none. */
vv_status vvi_files_resolve_part(char **out, char **part_out, const vvi_session *session, const char *name);
/** Whether a real path is inside the root or the state folder. */
bool vvi_files_inside(const vvi_session *session, const char *real);
/** Whether a real path is a file or folder that reading comes to the end of: no pipe, no device, nothing that the
 * kernel writes (/proc/kmsg). It is not opened. */
bool vvi_files_plain(const char *real);
/* state_files.c -------------------------------------------------------------------------------------------------- */

/** A folder with all that it lies in, where they are not there. */
vv_status vvi_files_make_path(const char *path);
/** A new folder "KIND-NUMBER" for what the session writes, with the next number that nothing has; yours to free(). */
vv_status vvi_files_make_folder(char **out, const vvi_session *session, const char *kind, int64_t *number);
/** Takes the folder of a path away, if nothing came to be in it. */
void vvi_files_remove_empty(const char *path);
/** The folder "KIND", made where it is not there. */
vv_status vvi_files_own_folder(char **out, const vvi_session *session, const char *kind);
/** Uploads and samples, and results of older versions, that a scene names stay when the session ends, with all that
 * came with them: they are made read-only. Any thread. */
void vvi_files_keep(const vvi_session *session, const vv_world *world);
/** Takes away all uploads and samples that no saved scene names. */
void vvi_files_clear(const vvi_session *session);
/** A real path inside as a page names it: from the root. A part of the text. */
const char *vvi_files_from_root(const vvi_session *session, const char *real);
vv_status vvi_files_browse(vvi_result *out, const vvi_session *session, const char *path);
/** A sentence without the folder of uploads and samples, which is nobody's but the server's; yours to free(). NULL: no
 * memory. */
char *vvi_files_sentence(const vvi_session *session, const char *sentence);
/** By its name. */
bool vvi_files_is_scene(const char *path);
/** Whether a folder of that name is a volume. By suffix: a folder of thousands of files is not opened file by file. */
bool vvi_files_is_data_folder(const char *name, const vv_registry *registry);

/* disk_room.c ---------------------------------------------------------------------------------------------------------
 */

/** What earlier sessions have left is not counted. */
void vvi_session_begin_room(vvi_session *session);
/** VV_E_LIMIT: so many bytes more would be more than uploads, samples, pictures and what pages write may take
 * (session_bytes), or than the disk has for them. Any thread. */
vv_status vvi_session_has_room(const vvi_session *session, uint64_t bytes);
/** The same, and files that nobody can see any more go before it is refused. Of the thread that edits. */
vv_status vvi_session_make_room(vvi_session *session, uint64_t bytes);

/** What a page writes below the root: it comes out of the same room, all that is beyond what it replaces. */
typedef struct vvi_disk_share {
    vvi_session *session;
    uint64_t others;   /* bytes in the session's folder when it began */
    uint64_t disk;     /* that its disk had for it then */
    uint64_t replaced; /* that are there under its name */
    _Atomic uint64_t taken;
} vvi_disk_share;
/** Before the file or folder is written by the job; VV_E_LIMIT: there is no room for any. Any thread. */
vv_status vvi_disk_share_begin(vvi_disk_share *out, vvi_session *session, const char *path, vv_job *job);
/** When it is written, or has failed. The status. */
vv_status vvi_disk_share_end(vvi_disk_share *share, vv_status status, vv_job *job);

/* request_*.c: messages that take time ----------------------------------------------------------------------------- */

/** It leaves: what it alone asked for is cancelled; what changes the World goes on. */
void vvi_client_drop_jobs(const vvi_client *client);
vv_status vvi_request_open(vvi_client *client, int64_t id, const json_t *message);
vv_status vvi_request_sample(vvi_client *client, int64_t id, const json_t *message);
vv_status vvi_request_save(vvi_client *client, int64_t id, const json_t *message);
vv_status vvi_request_pick(vvi_client *client, int64_t id, const json_t *message);
vv_status vvi_request_info(vvi_client *client, int64_t id, const json_t *message);
vv_status vvi_request_histogram(vvi_client *client, int64_t id, const json_t *message);
vv_status vvi_request_transfer(vvi_client *client, int64_t id, const json_t *message);
vv_status vvi_request_proposals(vvi_client *client, int64_t id, const json_t *message);
vv_status vvi_request_thumbnail(vvi_client *client, int64_t id, const json_t *message);
vv_status vvi_request_picture(vvi_client *client, int64_t id, const json_t *message);
vv_status vvi_request_run(vvi_client *client, int64_t id, const json_t *message);
vv_status vvi_request_write(vvi_client *client, int64_t id, const json_t *message);
vv_status vvi_request_measure(vvi_client *client, int64_t id, const json_t *message);
vv_status vvi_request_describe(vvi_client *client, int64_t id, const json_t *message);
vv_status vvi_request_command(vvi_client *client, int64_t id, const json_t *message);

/* request_shape.c ------------------------------------------------------------------------------------------------ */

vv_status vvi_request_shape(vvi_client *client, int64_t id, const json_t *message);
/** Nobody waits for the shape that a client has asked for. */
void vvi_client_drop_shape(vvi_client *client);

/* request_preview.c ---------------------------------------------------------------------------------------------- */

vv_status vvi_request_preview(vvi_client *client, int64_t id, const json_t *message);
/** The same of a preview. */
void vvi_client_drop_preview(vvi_client *client);

/* actions.c ------------------------------------------------------------------------------------------------------ */

/** What a binding or the page asks for by name; false: it is the page's own. */
bool vvi_client_action(vvi_client *client, const char *name, int64_t now);
#endif
