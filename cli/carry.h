/** @file
 * What a file says of its channels and labels, carried through operations into what is written.
 */
#ifndef CLI_CARRY_H
#define CLI_CARRY_H
#include "pipeline.h"

/** Channels and labels of a result; they belong to the carrier, or to the input. Zeroed is valid to finish. */
typedef struct cli_carry {
    vv_channel *channels;
    size_t n_channels;
} cli_carry;

/** Into the writing options: the input itself, for what its header says, its channels, picked as the steps pick them,
 * and its labels where the result is still one of labels. Valid as long as both `carry` and `input` are. */
vv_status cli_carry_begin(cli_carry *carry, vv_write_options *options, const cli_input *input, const cli_step *steps,
                          size_t n_steps, const vv_field_info *result);
void cli_carry_finish(cli_carry *carry);
/** Number of the component that a channel's name or number says; an error that lists what there is. */
vv_status cli_carry_find(int *out, const cli_input *input, const char *word, size_t n);
#endif
