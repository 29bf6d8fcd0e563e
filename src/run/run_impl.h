/** @file
 * What a run is made of: for src/run alone.
 */
#ifndef VVI_RUN_IMPL_H
#define VVI_RUN_IMPL_H
#include "run/label_look.h"
#include "run/layers.h"
#include "run/stream.h"
#include <volvis/run.h>
#include <volvis/sys/registry.h>

enum { VVI_RUN_INPUTS = 64 };

struct vv_run {
    vv_run_input inputs[VVI_RUN_INPUTS];
    vv_step *steps; /* n_steps */
    size_t n_inputs, n_steps;
    const char *name;
    vv_job *job;
    const char *path; /* of the output */
    bool written;
    vv_run_about about;
    /* of one that makes a mesh */
    const vv_mesh_write_options *mesh_options;
    vvi_file_labels labels; /* of the first input */
    vv_mesh *mesh;
    vv_status (*check)(void *user, const vv_step *step, const vv_data *input); /* NULL: no check */
    void *check_user;
    /* of one that makes fields */
    vv_write_options options;
    const vv_format *format;
    int64_t first_frame;
    vvi_layers layers; /* of the first input, in the place of time steps */
    vvi_stream stream;
    bool whole;        /* a step takes all samples at once */
    int64_t n_results; /* time steps, or layers */
    vv_field **results;
};

/** The time step of an input that is taken for time step `index` of the result. */
int64_t vvi_run_frame(const vv_run *run, const vv_run_input *input, int64_t index);
int64_t vvi_run_frames(const vv_run_input *input);

/* Where the last step makes a mesh. */
vv_status vvi_run_plan_mesh(vv_run *run);
vv_status vvi_run_make_mesh(vv_run *run);
vv_status vvi_run_write_mesh(vv_run *run);
/** People are told that a mesh is of the first of so many time steps; of one there is nothing to be told. */
void vvi_run_note_first(int64_t n_frames, vv_job *job);
#endif
