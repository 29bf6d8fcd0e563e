/** @file
 * A message whose answer takes time: a task, what it needs and what it makes.
 */
#ifndef VVI_SERVER_REQUEST_H
#define VVI_SERVER_REQUEST_H
#include "server/session_impl.h"
#include "server/shape.h"
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
    bool replace;      /**< a file that is there may be written over */
    bool exists;       /**< it was there, and is left as it was */
    vv_pixel pixel;
    const vv_operation *operation;
    vv_object *params;
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
/** One of its texts, copied (NULL: none). Without memory the request is dropped. */
vv_status vvi_request_copy(char **out, vvi_request *request, const char *text);
/** Takes the request in any case. Quick ones do not wait for slow ones. */
vv_status vvi_request_add_quick(vvi_request *request);
/** The answer of a quick one. */
void vvi_request_answer(vvi_request *request, vv_status st);
vv_status vvi_request_add_slow(vvi_request *request);
/** {"text": ...} as the value of the answer; takes the text. */
void vvi_request_tell_text(vvi_request *request, vvi_text *text);
/** Of the file that an operation's result is written to: ".nrrd" and ".ply", or that of the dataset's own format, where
 * that alone keeps what the file says. */
vv_status vvi_request_suffix(const char **out, const vv_operation *operation, const vv_world *world,
                             const vv_dataset *dataset, vv_job *job);
/** The parameters of an operation on a dataset, read as its files say what a length or a voxel is. *out is yours;
 * VV_E_FORMAT, VV_E_ARGUMENT: they are not what the operation takes. */
vv_status vvi_request_parameters(vv_object **out, const vv_operation *operation, const char *json,
                                 const vv_world *world, const vv_dataset *dataset, const vv_registry *registry,
                                 vv_job *job);
/** What a message says of the inputs of r->operation: the dataset, and others by operand. VV_E_ARGUMENT: not as they
 * must be. */
vv_status vvi_request_take_inputs(vvi_request *request, const json_t *message);
/** Names that people gave inputs become the parameter of them (vv_operand.names). */
vv_status vvi_request_name_inputs(vvi_request *request);

/** The decorations of a view that shows the data alone: without those that are there by themselves. */
#define VVI_NO_DECORATIONS "{\"measurements\": false}"

enum { VVI_REQUEST_INPUTS = 16 };

/** Inputs of an operation, opened; zeroed is valid to close. */
typedef struct vvi_request_inputs {
    vv_run_input input[VVI_REQUEST_INPUTS];
    size_t n;
} vvi_request_inputs;

/** Those that the request names, of its World, in the order of the row's operands. */
vv_status vvi_request_open_inputs(vvi_request_inputs *out, const vvi_request *request, vv_job *job);
void vvi_request_close_inputs(vvi_request_inputs *inputs);
/** The file that a volume comes from, with what it says of its samples. *out stays NULL where there is none. */
vv_status vvi_request_open_origin(vv_file **out, const vv_world *world, const vv_dataset *dataset, vv_job *job);
/** done() of slow ones: everybody sees that a job has ended, and who asked has the answer. */
void vvi_request_done_slowly(vvi_task *task, vv_status st);
/** The volume of that id (NULL: the first) and its dataset; NULL, and the thread's error. */
const vv_volume *vvi_request_volume(const vv_world *world, const char *id, const vv_dataset **dataset_out);
/** A quick request whose message names a volume, which is r->name then (NULL: the first). */
vv_status vvi_request_of_volume(vvi_client *client, int64_t id, const json_t *message, const char *name,
                                vv_status (*run)(vvi_task *task, vv_job *job));
#endif
