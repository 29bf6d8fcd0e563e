/** @file
 * One run of the program: what was asked, the runtime and job it works in, and its result as text and as JSON.
 */
#ifndef CLI_COMMAND_H
#define CLI_COMMAND_H
#include "args.h"
#include "core/result.h"
#include "core/status.h"
#include "core/text.h"
#include "defaults.h"
#include "options.h"
#include "progress.h"
#include "verb.h"
#include <volvis/runtime.h>

/** Exit codes that no status stands for. */
enum {
    CLI_EXIT_DONE = 0,
    CLI_EXIT_FAILED = 1,
    CLI_EXIT_WORDS = 2,
    CLI_EXIT_INPUT = 3,
    CLI_EXIT_LIMIT = 4,
    CLI_EXIT_OUTPUT = 5,
    CLI_EXIT_DIFFERS = 6,
    CLI_EXIT_PARTIAL = 7,
    CLI_EXIT_RESUMABLE = 75,
    CLI_EXIT_INTERRUPTED = 130,
    CLI_EXIT_UNREAD = 141 /* as shells say of what SIGPIPE ends */
};

typedef struct cli_command {
    cli_verb verb;
    cli_args args;
    cli_defaults defaults;
    vv_object *options[CLI_VERB_CLASSES]; /**< one a class of the verb; see cli_command_options() */
    cli_common *common;
    const vv_registry *registry;
    vv_runtime *runtime; /**< NULL until cli_command_start() */
    vv_job *job;
    cli_progress progress;
    vvi_text text;           /**< the result for people, or as it is where `verbatim` */
    vvi_result json;         /**< the result for programs; an object that run() adds keys to */
    bool served;             /**< a signal is how it ends: what fails at the end has failed by itself */
    bool verbatim;           /**< `text` is a document of its own (a schema, a script): the same with --json */
    vvi_text said;           /**< lines of the log, each with its line end: none is said twice */
    bool several;            /**< `json` is an array, of an object for each input */
    bool any_part;           /**< inputs are looked at, not used: of several parts none need be named */
    char *output;            /**< of one input among several, which -o names by {stem} */
    struct cli_watch *watch; /**< notes what is read; NULL: nobody watches */
    bool keeps_existing;     /**< its output is a word, and --overwrite was not given */
    bool kept;               /**< it was interrupted, and what was whole is written */
    int exit_code;           /**< of a run that did not fail: 6 where a comparison differs */
} cli_command;

/** The whole program. */
int cli_command_main(int argc, char **argv);

/** The verb's options of one class, borrowed. Not of the class that the verb makes by itself. */
const void *cli_command_options(const cli_command *command, const vv_class *cls);
/** Word by number; NULL past the end. */
const char *cli_command_word(const cli_command *command, size_t index);
/** What the file of defaults says of a picture holds no longer: the input is a scene, which says all of it itself. */
vv_status cli_command_drop_looks(cli_command *command, const vv_class *look);
/** Runtime and job, once; from then on Ctrl-C cancels the job. */
vv_status cli_command_start(cli_command *command);
/** A line of the text: a label, then what printf makes; long values are wrapped under themselves. */
void cli_command_line(cli_command *command, const char *label, const char *format, ...) VV_PRINTF(3, 4);
/** A line for the name of what follows: a path of a file as it may be shown. */
void cli_command_title(cli_command *command, const char *name);
/** A remark for people, on standard error, unless -q. */
void cli_command_note(cli_command *command, const char *format, ...) VV_PRINTF(2, 3);
/** A line of the library's log, for vv_runtime_options.log; `user` is the command. What is said twice in one run is
 * shown once. */
void cli_command_log(void *user, vv_log_level level, const char *component, const char *text);
/** Seconds of a clock that never goes back. */
double cli_now_s(void);
#endif
