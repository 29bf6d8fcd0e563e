/** @file
 * Labels that lie in another layer of a file than the one that is read.
 */
#ifndef CLI_LABEL_LAYERS_H
#define CLI_LABEL_LAYERS_H
#include "input.h"

/** VV_E_NOT_FOUND: the label names nothing in the layer that is read, but something in another one, which is told. What
 * no layer names may be there all the same. */
vv_status cli_label_layer_check(const cli_command *command, const cli_input *input, vv_label_id label);
/** The same of a label of this name. */
vv_status cli_label_layer_check_name(const cli_command *command, const cli_input *input, const char *name);
#endif
