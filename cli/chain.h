/** @file
 * Operations one after the other, as people type them: 'gaussian --sigma 1mm | threshold --range 80..'. Each becomes a
 * dataset of a World that is made of the one before it.
 */
#ifndef CLI_CHAIN_H
#define CLI_CHAIN_H
#include "input.h"

/**
 * Add the datasets of a chain to a World. Each step is an operation with its options, and with further inputs behind
 * them: files, datasets of the World, or either by name, as in values=ct.nrrd.
 *
 * id_out  the last dataset
 * from    what the first step works on, a dataset of the World
 * more    further inputs of the first step, n_more of them
 * Errors  VV_E_ARGUMENT, with the step that is at fault; what cannot be read of inputs
 */
vv_status cli_chain_add(vv_world **world, char id_out[64], cli_command *command, const char *chain, const char *from,
                        const char *const *more, size_t n_more);
/** The dataset that a World shows first, borrowed; NULL, and an error, where it shows none. input: in the error. */
const char *cli_chain_source(const vv_world *world, const char *input);
/** --apply: the chain takes the place of what a World shows first: a data file's World shows the result as if it were
 * the file; of a scene the first volume shows it, with the look that it has. */
vv_status cli_chain_apply(vv_world **world, cli_command *command, const char *chain, const char *input);
#endif
