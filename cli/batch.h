/** @file
 * One input after another: an output with {stem} in it is made for each input by itself.
 */
#ifndef CLI_BATCH_H
#define CLI_BATCH_H
#include "args.h"

/** How many runs the line is: 0 where its output has no {stem}, or the verb makes one output of all inputs. */
size_t cli_batch_count(const cli_args *args, const cli_verb *verb);
/** VV_E_ARGUMENT where two inputs would have one output, and where the output holds {another word} than stem, or {stem}
 * although the verb makes one output of all inputs. */
vv_status cli_batch_check(const cli_args *args, const cli_verb *verb);
/** A name with the stem of an input in the places of {stem}: *out is yours to free(). */
vv_status cli_batch_name(char **out, const char *pattern, const char *word);
/** Leaves input `index` alone, with the options that are for it, and the output that is its own: *output_out, which is
 * yours to free() after the words.
 */
vv_status cli_batch_take(char **output_out, cli_args *args, size_t index);
#endif
