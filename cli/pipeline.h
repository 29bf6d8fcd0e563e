/** @file
 * Data through operations into a file: what operation verbs and `convert` share.
 */
#ifndef CLI_PIPELINE_H
#define CLI_PIPELINE_H
#include "grid/info_text.h"
#include "input.h"
#include "run/run_impl.h"

/**
 * Run the steps on the inputs (vv_run_new()), write -o, report.
 *
 * A time step that was chosen is taken alone; else every time step goes through. With --dry-run nothing is
 * written, and nothing read but headers and what tells how long the work takes.
 */
vv_status cli_pipeline_run(cli_command *command, const cli_input *inputs, size_t n_inputs, const vv_step *steps,
                           size_t n_steps);
/** The same of any run. */
vv_status cli_pipeline_run_plan(cli_command *command, const vvi_run_plan *plan);
#endif
