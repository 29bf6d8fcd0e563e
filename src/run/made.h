/** @file
 * Datasets that are made of others: what such a dataset takes, and how it is worked out.
 */
#ifndef VVI_RUN_MADE_H
#define VVI_RUN_MADE_H
#include "model/made_data.h"
#include "run/run_impl.h"

/** One after the other, and with all that they stand on: what a scene may ask for. */
enum { VVI_MADE_DEEPEST = 64, VVI_MADE_MOST = 4096 };

/** A dataset that is made: its row and what it works on. All but `names` is borrowed from the World. */
typedef struct vvi_made {
    const vv_world *world;
    const vv_dataset *dataset;
    const char *id; /**< of the dataset */
    const vv_operation *operation;
    size_t n;                                /**< inputs, in the order of the row's operands */
    const vv_dataset *input[VVI_RUN_INPUTS]; /**< NULL: it is left out. What stands for one that is switched off */
    const char *input_id[VVI_RUN_INPUTS];
    char *names; /**< of inputs that are named as people like, "a,b"; NULL: of none */
} vvi_made;

/** Its row and inputs, found in the World. Errors name the property. *out is for vvi_made_close(), also on failure. */
vv_status vvi_made_open(vvi_made *out, const vv_world *world, const vv_dataset *dataset, vv_job *job);
/** The same without a look at whether inputs are switched off. */
vv_status vvi_made_open_as_is(vvi_made *out, const vv_world *world, const vv_dataset *dataset, vv_job *job);
void vvi_made_close(vvi_made *made);
/** The error that datasets, each made of the next, come back to the first of them: "a -> b -> a", of many the first and
 * the last ones. id: n of them, the first is its own. */
vv_status vvi_made_fail_ring(const vvi_made *made, const char *const *id, size_t n);
/** What a dataset stands for: itself, or its first input where its operation is switched off, as far back as that is
 * so; in the place of *dataset and *id. Errors: VV_E_ARGUMENT (an operation that makes another kind than its first
 * input is, made of itself), those of vvi_made_open(). */
vv_status vvi_made_behind(const vv_dataset **dataset, const char **id, const vv_world *world, vv_job *job);
/** Hash of all that decides what it is. Errors: VV_E_ARGUMENT (made of itself), VV_E_LIMIT (of too much), those of
 * vvi_made_open() for all that it stands on. */
vv_status vvi_made_content(uint64_t *out, const vv_world *world, const vv_dataset *dataset, vv_job *job);
/** Its parameters, read against the row's class with the lengths of its first input; yours to release. */
vv_status vvi_made_params(vv_object **out, const vvi_made *made, vv_job *job);
/** Whether inputs that people name as they like are called as the recipe has them, and not as a parameter says. */
bool vvi_made_is_named(const vvi_made *made, const vv_object *params);
/** What its samples will be, as planned, within the limits of what comes from outside. */
vv_status vvi_made_plan(vv_field_info *out, const vvi_made *made, const vv_object *params, vv_job *job);
/** Its parameters with what samples decide, of all time steps together, kept in the cache; yours to release. */
vv_status vvi_made_settled(vv_object **out, const vvi_made *made, vv_job *job);
/** The sentence of an operation, with the dataset, or its property, that it is about; one that names a file or a
 * property of the World already stays. */
vv_status vvi_made_fail(const vvi_made *made, const char *property, vv_status status);

/** Whether samples of one box can be made without all others: with these parameters a sample depends on those around it
 * alone, or on what the operation looks at by itself, which is quick. n_frames: of the result; what is looked at for
 * all time steps together is not local. */
bool vvi_made_is_local(const vvi_made *made, const vv_object *params, int64_t n_frames);

/** A dataset that is made is worked out, unless it is kept: its samples of a time step, or its mesh, yours to release.
 * The job is told what was found when it was worked out (vv_job_finding()), and nothing else. Errors: those of
 * vv_dataset_field() and vv_dataset_mesh(). */
vv_status vvi_made_work_out(vv_data *out, const vv_world *world, const vv_dataset *dataset, int64_t frame, vv_job *job);

/** How a dataset comes about, as a run: its steps, and the files and data in memory that they begin with. What cannot
 * be a step of it (a mesh on the way, say) is worked out by itself and is an input. */
typedef struct vvi_made_run {
    const vv_world *world;
    int64_t
        frame; /**< the only time step: one step, of inputs that are kept in the cache; -1: all, from the files on */
    vv_run_input input[VVI_RUN_INPUTS]; /**< the first is what its first inputs lead back to */
    const vv_dataset *of_input[VVI_RUN_INPUTS];
    size_t n_inputs;
    vv_step step[VVI_MADE_DEEPEST];
    vvi_run_takes takes[VVI_MADE_DEEPEST];
    const vv_dataset *of_step[VVI_MADE_DEEPEST];
    size_t n_steps;
} vvi_made_run;

/** Of all time steps parameters are as people gave them, and what samples decide is left to the run; of one they are
 * settled. *out is for vvi_made_run_close(), also on failure. */
vv_status vvi_made_run_open(vvi_made_run *out, const vv_world *world, const vv_dataset *dataset, int64_t frame,
                            vv_job *job);
void vvi_made_run_close(vvi_made_run *run);
/** It as what vvi_run_new() takes; name: for errors of what has no steps. Borrowed of it. */
vvi_run_plan vvi_made_run_plan(const vvi_made_run *run, const char *name);
/** The samples of a box of the result, in a grid of their own: the same bytes that vv_dataset_field() has there. *out
 * is yours. run: of one time step. VV_E_UNSUPPORTED: not vvi_made_is_local(); otherwise errors of the operation. */
vv_status vvi_made_box(vv_field **out, const vvi_made *made, const vvi_made_run *run, const vv_box *box, vv_job *job);
/** A dataset as a file, in the format of its suffix: all time steps, with what its file says as it still holds. The
 * bytes are those that `volvis NAME` and `volvis pipe` write. Errors: VV_E_ARGUMENT (no format for such data),
 * those of vv_run_write() and vv_mesh_write(). */
vv_status vvi_made_write(const char *path, const vv_world *world, const vv_dataset *dataset, vv_job *job);

/** What files say of data beyond their info, as it holds after the operations that they were made by. */
typedef struct vvi_words {
    vv_file *file; /**< NULL: there is none */
    vv_carry carry;
    vv_write_options options; /**< channels, labels: what is known of them, borrowed from the file and `carry` */
    vv_object *params[VVI_MADE_DEEPEST];
    size_t n;
} vvi_words;

/** Of a dataset of samples. *out is for vvi_words_close(), also on failure. */
vv_status vvi_words_open(vvi_words *out, const vv_world *world, const vv_dataset *dataset, vv_job *job);
void vvi_words_close(vvi_words *words);

/** Made samples as if a file held them, with what is known of channels and labels; it holds the World. */
vv_status vvi_made_open_file(vv_file **out, const vv_world *world, const vv_dataset *dataset, vv_job *job);
#endif
