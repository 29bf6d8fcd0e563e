/** @file
 * Operations, one after the other, on the samples of files: every time step, slab by slab where memory does not hold
 * them, into a file that keeps what the first one said; and operations that make meshes. What `volvis NAME`,
 * `volvis convert` and the page do.
 */
#ifndef VOLVIS_RUN_H
#define VOLVIS_RUN_H
#include <volvis/file.h>
#include <volvis/mesh_file.h>
#include <volvis/property.h>
VV_BEGIN_DECLS

struct vv_operation; /* a row: <volvis/sys/registry.h> */
struct vv_data;      /* <volvis/sys/registry.h> */

/** Fields of equal type and scale whose samples are taken together: the time steps of a file, say. Each is opened and
 * released as often as its reader goes through them, so that only one needs to be in memory. */
typedef struct vv_field_series {
    vv_status (*open)(vv_field **out, void *user, size_t index, vv_job *job);
    void *user;
    size_t n;
} vv_field_series;

/** One operation with its parameters. */
typedef struct vv_step {
    const struct vv_operation *operation;
    vv_object *params; /**< of the operation's class; what samples decide for all time steps is settled in them */
} vv_step;

/** What a file says of its samples beyond their info, on the way through operations to what is written. */
typedef struct vv_carry {
    vv_channel *channels; /**< one for each component; NULL: nothing is known of them */
    size_t n_channels;
    bool new_values; /**< samples no longer have the values of the file: windows, intents, ... hold no more */
} vv_carry;

/**
 * Before vv_field_write(): into `options`, where they say nothing of it, what the file says that the samples came from,
 * as it still holds after the steps: the file itself, for what only its header knows, channels as the steps picked
 * them, labels where the result is still one of labels. vv_run_write() does this; it is for those who run operations
 * themselves.
 *
 * origin  what the first step had as its first input; it and `out` must live until the file is written. NULL: none
 * result  of the last step
 * Owns    *out is for vv_carry_finish(), also when this fails
 * Errors  VV_E_ARGUMENT (parameters that the operation refuses), VV_E_MEMORY
 */
VV_API vv_status vv_carry_begin(vv_carry *out, vv_write_options *options, const vv_file *origin, const vv_step *steps,
                                size_t n_steps, const vv_field_info *result);
VV_API void vv_carry_finish(vv_carry *carry);

/** What a label is called and which colour it has, as part of a mesh. is_unsigned: the label is the bits of uint64_t.
 * False: it is not wanted. */
typedef bool vv_label_look(vv_mesh_part *part, vv_label_id label, bool is_unsigned, void *user);

/** One input of a run; all of it borrowed. One without file, field and mesh is an optional one that is left out. */
typedef struct vv_run_input {
    vv_file *file;         /**< NULL: there is only `field` */
    int64_t frame;         /**< the only time step that is taken; -1: all of them */
    const vv_field *field; /**< its samples, where they are in memory already and are of one time step; else NULL */
    const vv_mesh *mesh;   /**< in the place of the two above */
    const char *name;      /**< for errors */
    const char *path;      /**< that `file` was opened by: where the output holds all layers of a segmentation
                              (vv_format.labels_only), the others are opened by it; NULL: what is open is all */
    const char *part;      /**< of the file, as it was asked for; a layer that was is taken alone. NULL: none was */
    vv_label_look *look;   /**< of labels, in what is made of them; NULL: as the file says */
    void *look_user;
} vv_run_input;

/** Where the result of a run goes; all of it borrowed. */
typedef struct vv_run_output {
    const char *path;                /**< NULL: nothing is written, and what is made is asked for */
    const vv_write_options *options; /**< as of vv_field_write(); what the first file says is added to them. NULL: the
                                        defaults */
    const vv_mesh_write_options *mesh_options; /**< the same of vv_mesh_write() */
    /** Of a run that makes a mesh: called once the samples have settled the parameters, before the first step; what
     * fails here fails the run. NULL: nothing is looked at. */
    vv_status (*check)(void *user, const vv_step *step, const struct vv_data *input);
    void *check_user;
} vv_run_output;

/** What a run will make and has made. */
typedef struct vv_run_about {
    int makes;          /**< VV_IS_FIELD or VV_IS_MESH; of a mesh nothing more is planned than `bytes` of the inputs */
    vv_field_info info; /**< of the result, as planned */
    int64_t n_frames;   /**< time steps */
    size_t n_layers;    /**< of a segmentation, each of all samples, which go into one file; 0: it has none */
    uint64_t bytes;     /**< that samples and results take */
    uint64_t working;   /**< that steps hold beside them, about: the one that holds most; 0: no more than tiles */
    bool streamed;      /**< they are more than should be held at once: slab by slab */
    bool finds_type;    /**< all samples are looked at for the smallest type that holds their values, before they are
                           written */
    /* once it has run */
    vv_field_info result;          /**< as it was made */
    vv_field_info written;         /**< and as it is in the file */
    double load_s, run_s, write_s; /**< seconds; streamed: all is in the last */
    uint64_t scratch;              /**< bytes of temporary files, as planned: of steps that stream in several passes,
                                        and between steps that look around samples */
} vv_run_about;

typedef struct vv_run vv_run;

/**
 * Plan the steps, the first on all inputs, the others on its result: headers alone are looked at. Time steps of the
 * inputs go through one by one: series have as many as each other, and what has one goes with all of theirs; where one
 * of the first input is chosen, others give theirs of that number. Where the output is of a format that holds labels
 * alone, whole numbers of the first input are labels from the start, and all layers of a segmentation go through.
 *
 * name    stands in errors
 * Owns    *out is for vv_run_release(); inputs, steps and output are copied, what they point to is borrowed until then
 * Errors  VV_E_ARGUMENT (numbers of inputs or time steps, parameters, no format of the output), VV_E_LIMIT,
 *         VV_E_MEMORY, those of vv_file_open() for layers
 */
VV_API vv_status vv_run_new(vv_run **out, const vv_run_input *inputs, size_t n_inputs, const vv_step *steps,
                            size_t n_steps, const vv_run_output *output, const char *name, vv_job *job);
VV_API const vv_run_about *vv_run_get_about(const vv_run *run);
/** Run the steps, once: where memory turns out not to hold what was planned as a whole, slab by slab if they can. What
 * they find is told by vv_job_finding(). Errors: VV_E_LIMIT says how much memory would be enough. */
VV_API vv_status vv_run_make(vv_run *run);
/** The mesh that was made; NULL: there is none. Borrowed. */
VV_API const vv_mesh *vv_run_mesh(const vv_run *run);
/** Time step `index` of the samples that were made, of a streamed run in parts as they are asked for, while the run
 * lives; NULL: there is none. Borrowed. */
VV_API const vv_field *vv_run_field(const vv_run *run, int64_t index);
/** Run the steps, unless they have run, and write the result. */
VV_API vv_status vv_run_write(vv_run *run);
VV_API void vv_run_release(vv_run *run); /* NULL is fine */

VV_END_DECLS
#endif
