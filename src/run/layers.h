/** @file
 * Segmentations whose segments overlap: the layers of a file, for an output that holds all of them.
 */
#ifndef VVI_RUN_LAYERS_H
#define VVI_RUN_LAYERS_H
#include <volvis/run.h>

/** Zeroed is valid to close. */
typedef struct vvi_layers {
    vv_file **file;   /**< each layer as a file of its own */
    size_t n;         /**< 0: there are none, or one was named */
    vv_label *labels; /**< of all of them */
    size_t n_labels;
} vvi_layers;

/** Opens what else the file of an input holds beside the layer that is open, unless that was named. */
vv_status vvi_layers_open(vvi_layers *out, const vv_run_input *input, vv_job *job);
void vvi_layers_close(vvi_layers *layers);
#endif
