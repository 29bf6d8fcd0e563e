/** @file
 * A message whose answer takes time: a task, what it needs and what it makes.
 */
#ifndef VVI_SERVER_REQUEST_H
#define VVI_SERVER_REQUEST_H
#include "server/page_shape.h"
#include "server/session_impl.h"
#include <volvis/pick.h>
#include <volvis/sys/registry.h>

typedef struct vvi_request_task {
    vvi_task task; /**< first */
    vvi_session *session;
    uint64_t serial; /**< of the client that asked */
    int64_t id;
    uint64_t asked; /**< its number among the jobs that change the World */
    char view[VVI_VIEW_NAME];
    vv_world *world;   /**< as it was when it was asked; or what was made */
    char *path, *name; /**< whatever the request needs of these */
    bool add;          /**< beside what is there; of measurements: a plot beside the answer */
    bool own_folder;   /**< its path is in one that is its alone */
    bool changes;      /**< the World, when it has ended */
    bool replace;      /**< a file that is there may be written over */
    bool whole;        /**< of a preview: all of the data, however large */
    bool exists;       /**< it was there, and is left as it was */
    vv_pixel pixel;
    const vv_operation *operation;
    vv_object *params; /**< of a measurement */
    char *dataset, *parameters;
    char *inputs;           /**< of the operation, beside the dataset: {"values": "ct"}; NULL: none */
    char *note;             /**< what whoever asked should know of what was done; NULL: nothing */
    vvi_made_memory memory; /**< a picture where nothing is written */
    vvi_page_shape_options wish;
    vvi_page_shape shape;
    vvi_result value; /**< of the answer */
} vvi_request;

/** A request with the World as its client sees it, cameras and all; done() answers, drop() frees it. */
vv_status vvi_request_new(vvi_request **out, vvi_client *client, int64_t id, const char *name,
                          vv_status (*run)(vvi_task *task, vv_job *job));
/** A text of a message, copied; NULL: it has none of that name. */
vv_status vvi_request_take_text(char **out, const json_t *message, const char *member);
/** Its view gets so many pixels. */
vv_status vvi_request_size(vvi_request *request, int32_t width, int32_t height);
/** Takes the request in any case: where something has failed since it is new, `status`, it is dropped. Quick ones do
 * not wait for slow ones. */
vv_status vvi_request_add_quick(vvi_request *request, vv_status status);
vv_status vvi_request_add_slow(vvi_request *request, vv_status status);
/** The answer of a quick one. */
void vvi_request_answer(vvi_request *request, vv_status st);
/** A member "data:TYPE;base64,...". */
vv_status vvi_request_put_bytes(vvi_result *out, const char *key, const char *type, const uint8_t *bytes, size_t n);
/** {"text": ...} as the value of the answer; takes the text. */
void vvi_request_tell_text(vvi_request *request, vvi_text *text);
/** What a message says of an operation: its row, its inputs (the dataset, and others by operand) and its parameters.
 * VV_E_NOT_FOUND, VV_E_ARGUMENT (not as they must be), VV_E_LIMIT. */
vv_status vvi_request_take_operation(vvi_request *request, const json_t *message);

/** The decorations of a view that shows the data alone: without those that are there by themselves. */
#define VVI_NO_DECORATIONS "{\"measurements\": false}"

enum { VVI_REQUEST_ID = 64 };

/** The dataset that r->operation would make: {"operation": ..., "inputs": ..., "parameters": ...}, yours; NULL: no
 * memory. */
json_t *vvi_request_recipe(const vvi_request *request);
/** The request's World with that dataset, as `id`; *out is yours, also on failure. */
vv_status vvi_request_make_world(vv_world **out, const vvi_request *request, const char *id);
/** An id of a dataset that is not there yet: "wanted", "wanted-2". */
void vvi_request_free_id(char out[VVI_REQUEST_ID], const vv_world *world, const char *wanted);
/** An error of that dataset, which nobody has heard of, as one of what was asked, in the words of a page. */
vv_status vvi_request_fail_made(const vv_operation *operation, const char *id, vv_status status);
/** A sentence in the words of a page: options of a class, as command lines have them, are its controls, but in
 * `commands`. */
void vvi_request_words(vvi_text *out, const char *text, const vv_class *cls);
/** What the job was told of its work, for whoever asked. */
void vvi_request_take_notes(vvi_request *request, const vv_job *job);
/** Where a page wants a file, as the request's path: a name that may be new in a folder below the root, and not among
 * what the session writes. said: as the page has it; path: with the suffix, where that is added. VV_E_ARGUMENT,
 * VV_E_NOT_FOUND. */
vv_status vvi_request_take_place(vvi_request *request, const char *said, const char *path);
/** Where the request does not say that the file may be replaced: the job keeps what exists. VV_E_WRITE, and
 * request->exists: there is such a file already. */
vv_status vvi_request_keep_existing(vvi_request *request, vv_job *job);
/** The status of what was written then; request->exists where somebody else has taken the name meanwhile. */
vv_status vvi_request_note_exists(vvi_request *request, vv_status status);
/** {"path": ...} as the value of the answer: where the file is, from the root; with the note, where there is one. */
void vvi_request_tell_path(vvi_request *request);
/** done() of slow ones: everybody sees that a job has ended, and who asked has the answer. */
void vvi_request_done_slowly(vvi_task *task, vv_status st);
/** The volume of that id (NULL: the first) and its dataset; NULL, and the thread's error. */
const vv_volume *vvi_request_volume(const vv_world *world, const char *id, const vv_dataset **dataset_out);
/** A quick request whose message names a volume, which is r->name then (NULL: the first). */
vv_status vvi_request_of_volume(vvi_client *client, int64_t id, const json_t *message, const char *name,
                                vv_status (*run)(vvi_task *task, vv_job *job));
#endif
