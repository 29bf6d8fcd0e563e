/** @file
 * What a run is made of: for src/run, and for those who run steps that are no plain chain.
 */
#ifndef VVI_RUN_IMPL_H
#define VVI_RUN_IMPL_H
#include "run/label_look.h"
#include "run/layers.h"
#include "run/stream.h"
#include <volvis/run.h>
#include <volvis/sys/registry.h>

enum { VVI_RUN_INPUTS = 64, VVI_RUN_GAP = -1 };

/** What a step takes, in the order of its operation's operands: the number of an input of the run, VVI_RUN_INPUTS + s
 * for what step s made before it, VVI_RUN_GAP for what is left out. */
typedef struct vvi_run_takes {
    size_t n;
    int from[VVI_RUN_INPUTS];
} vvi_run_takes;

/** Steps on inputs, each on what it likes of them and of what steps before it made; the last one makes the result. All
 * is borrowed. */
typedef struct vvi_run_plan {
    const vv_run_input *inputs; /**< the first is what the chain of first inputs begins with */
    size_t n_inputs;
    const vv_step *steps;
    const vvi_run_takes *takes; /**< of each step; NULL: all inputs go into the first, its result into the next one */
    size_t n_steps;
    const char *name; /**< for errors */
    bool settled;     /**< what samples decide of parameters has been decided */
} vvi_run_plan;

/** vv_run_new() of such steps. */
vv_status vvi_run_new(vv_run **out, const vvi_run_plan *plan, const vv_run_output *output, vv_job *job);

/** A field of which there is the grid alone: asking for samples is an error. */
vv_status vvi_run_grid(vv_field **out, const vv_field_info *info, vv_job *job);
/** About how many seconds the steps take for one time step, without reading and writing: from the middle 64^3 or 128^3
 * samples. NaN where that cannot be told: steps refuse a part, or work on meshes. */
double vvi_run_seconds(const vvi_run_plan *plan, vv_job *job);

/** An input, or what a step makes: what is planned of it. */
typedef struct vvi_run_node {
    vv_field_info info;      /**< of samples */
    int64_t n_frames;        /**< that the run takes of it */
    bool read;               /**< its samples are, and not its grid alone */
    size_t n_uses, last_use; /**< steps that take it; the last of them */
    size_t pool;             /**< of inputs: their slabs' where they stream; what is joined shares one */
} vvi_run_node;

struct vv_run {
    vv_run_input inputs[VVI_RUN_INPUTS];
    vv_step *steps;       /* n_steps */
    vvi_run_takes *takes; /* n_steps */
    vvi_run_node *nodes;  /* VVI_RUN_INPUTS + n_steps */
    vvi_stream_way *ways; /* n_steps, where it is streamed */
    size_t n_inputs, n_steps;
    const char *name;
    vv_job *job;
    const char *path; /* of the output */
    bool written, settled;
    bool whole;              /* a step takes all samples at once */
    uint64_t passes_scratch; /* bytes on the disk, of steps that stream in passes */
    int64_t chosen;          /* the time step that was chosen of the first input, and holds for others; -1: none was */
    vv_run_about about;
    int64_t n_results; /* time steps, or layers */
    vv_data *results;
    /* of one that makes a mesh */
    const vv_mesh_write_options *mesh_options;
    vvi_file_labels labels;                                                    /* of the first input */
    vv_status (*check)(void *user, const vv_step *step, const vv_data *input); /* NULL: no check */
    void *check_user;
    /* of one that makes fields */
    vv_write_options options;
    const vv_format *format;
    vvi_layers layers; /* of the first input, in the place of time steps */
    vvi_stream stream;
};

/** run_plan.c: all but results and what is written. */
vv_status vvi_run_plan_all(vv_run *run, const vv_run_output *output);
/** Of one that was to be in memory, and can stream: it does. Once. */
vv_status vvi_run_plan_streamed(vv_run *run);
/** The last node: what the run makes. */
int vvi_run_last(const vv_run *run);
/** Of what is joined in step `s` the one that has time step *index, which becomes its own. */
size_t vvi_run_joined(const vv_run *run, size_t s, int64_t *index);
/** Whole numbers that a format of labels is given are labels. */
void vvi_run_declare_label(vv_field_info *info, const vv_run *run);
/** run_need.c: vv_run_make() that leaves what the job was told before: run->results, and the first slab of what
 * streams, slab by slab where memory turns out not to hold the whole; VV_E_LIMIT says how much memory would be enough.
 */
vv_status vvi_run_make(vv_run *run);
/** Whether a run that is only planned will be refused so, where its first slab tells. */
vv_status vvi_run_try(vv_run *run);
/** run_make.c: run->results, as it is planned. */
vv_status vvi_run_make_all(vv_run *run);
/** People are told that a mesh is of the first of so many time steps; of one there is nothing to be told. */
void vvi_run_note_first(int64_t n_frames, vv_job *job);
#endif
