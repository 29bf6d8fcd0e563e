/** @file
 * Segmentations whose segments overlap: the layers of a file, for an output that holds all of them.
 */
#ifndef CLI_LAYERS_H
#define CLI_LAYERS_H
#include "input.h"

/** Zeroed is valid to close. */
typedef struct cli_layers {
    cli_input *input; /**< each layer as a file of its own */
    size_t n;         /**< 0: there are none, or one was named */
    vv_label *labels; /**< of all of them */
    size_t n_labels;
} cli_layers;

/** Whether an output is of a format that holds labels alone (.seg.nrrd). */
bool cli_layers_wanted(const cli_command *command);
/** Opens what else the file of an input holds beside the layer that was opened, unless that was named. */
vv_status cli_layers_open(cli_layers *out, cli_command *command, const cli_input *input);
void cli_layers_close(cli_layers *layers);
#endif
