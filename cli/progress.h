/** @file
 * How far a job is, shown on standard error: a bar with the time left on a terminal, a line now and then in a log, one
 * JSON object a line for programs.
 */
#ifndef CLI_PROGRESS_H
#define CLI_PROGRESS_H
#include "options.h"
#include <volvis/runtime.h>

typedef struct cli_progress {
    cli_progress_kind kind;
    bool log_lines;   /**< auto without a terminal */
    bool drawn;       /**< a bar stands on the current line */
    double next_s;    /**< log: when the next line is due */
    vv_progress last; /**< of JSON: the last report of the stage; stage NULL: none */
    double told_s;    /**< when a report of it was told last */
} cli_progress;

void cli_progress_init(cli_progress *progress, cli_progress_kind kind, bool quiet);
/** A vv_progress_fn; user is the cli_progress. */
bool cli_progress_show(void *user, const vv_progress *report);
/** The work is done: the last line of JSON has done = total. */
void cli_progress_end(cli_progress *progress);
/** Take a bar away, so that other text may follow. */
void cli_progress_clear(cli_progress *progress);
#endif
