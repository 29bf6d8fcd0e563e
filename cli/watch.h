/** @file
 * --watch: the work is done again whenever something that it read has changed.
 */
#ifndef CLI_WATCH_H
#define CLI_WATCH_H
#include "command.h"
#include "input.h"
#include "watch_files.h"

/** Option of verbs that make a file. */
typedef struct cli_watching {
    vv_object base;
    bool watch;
} cli_watching;
extern const vv_class cli_watching_class;

/** One output and what it is made of. */
typedef struct cli_watch {
    cli_watch_files files;
    cli_file_state written; /**< the output as the last run left it; 0: none was made */
    size_t n_runs;
} cli_watch;

/** Whether the command line asks for it. */
bool cli_watch_is_asked(const cli_args *args);
/** VV_E_ARGUMENT where there is nothing that could be watched, or nothing that is made. */
vv_status cli_watch_check(const cli_args *args, const cli_verb *verb, const vv_registry *registry);
/** At the begin of a run, when there is a job: listens to what is read. VV_E_ARGUMENT where the output is a file that
 * somebody else made. */
vv_status cli_watch_begin(cli_watch *watch, cli_command *command);
/** What is written, before anybody is told of it: who writes there from then on is somebody else. */
void cli_watch_written(cli_watch *watch, const cli_command *command);
/** After it; code: its exit code. */
void cli_watch_end(cli_watch *watch, const cli_command *command, int code);
/** "12:03:22 " before a line of the result. */
void cli_watch_stamp(vvi_text *text);

/** Runs number `index`; returns its exit code. */
typedef int cli_watch_run_fn(void *user, size_t index, cli_watch *watch);
/** Runs all n, then again those whose files change, until a signal ends the program with 130. Returns only where the
 * first run shows that the command line is wrong, or was stopped by a signal: its exit code. */
int cli_watch_loop(size_t n, cli_watch_run_fn *run, void *user, bool quiet);
#endif
