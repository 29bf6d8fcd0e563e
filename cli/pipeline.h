/** @file
 * Data through operations into a file: what operation verbs and `convert` share.
 */
#ifndef CLI_PIPELINE_H
#define CLI_PIPELINE_H
#include "grid/info_text.h"
#include "input.h"
#include <volvis/run.h>

/**
 * Run the steps on the inputs (vv_run_new()), write -o, report.
 *
 * A time step that was chosen is taken alone; else every time step of the first input goes through. With --dry-run
 * nothing is read or written but headers.
 */
vv_status cli_pipeline_run(cli_command *command, const cli_input *inputs, size_t n_inputs, const vv_step *steps,
                           size_t n_steps);
#endif
