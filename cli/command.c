/* One run of the program, or several: from the words of the command line to the exit code. */
#include "command.h"
#include "batch.h"
#include "choices.h"
#include "command_words.h"
#include "core/job.h"
#include "help.h"
#include "io/source.h"
#include "limit_words.h"
#include "output.h"
#include "refusal.h"
#include "report.h"
#include "signals.h"
#include "watch.h"
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>
#include <volvis/version.h>

double cli_now_s(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

const void *cli_command_options(const cli_command *command, const vv_class *cls)
{
    for (size_t i = 0; i < CLI_VERB_CLASSES; i++) {
        const vv_object *options = command->options[i];
        if (options && (options->cls == cls || (cls == &cli_reading_class && cli_is_reading(options->cls))))
            return options;
    }
    vvi_check(!"a verb asks for options that are not its own");
    return NULL;
}

const char *cli_command_word(const cli_command *command, size_t index)
{
    return index < command->args.n_words ? command->args.words[index] : NULL;
}

vv_status cli_command_start(cli_command *command)
{
    vv_runtime_options options;
    vv_limits limits;
    vv_status st;
    if (command->runtime)
        return VV_OK;
    if ((st = cli_limits_read(&limits, command->common)) != VV_OK)
        return st;
    vv_runtime_options_init(&options, sizeof options);
    options.threads = vv_object_is_set(&command->common->base, "threads") ? (int)command->common->threads : 0;
    options.memory_bytes = vv_object_is_set(&command->common->base, "memory") ? (uint64_t)command->common->memory : 0;
    options.allow_outside = command->common->allow_outside;
    options.limits = &limits;
    options.safe = command->common->safe || (command->verb.safe && !vv_object_is_set(&command->common->base, "safe"));
    options.contain = options.safe || !vv_object_is_set(&command->common->base, "safe");
    options.log = cli_command_log;
    options.log_user = command;
    options.log_level = command->common->quiet ? VV_LOG_ERROR : command->common->verbose ? VV_LOG_INFO : VV_LOG_WARNING;
    if ((st = vv_runtime_new(&command->runtime, &options)) != VV_OK ||
        (st = vv_job_new(&command->job, command->runtime, cli_progress_show, &command->progress)) != VV_OK)
        return st;
    if (command->keeps_existing)
        vvi_job_keep_existing(command->job);
    vvi_job_has_overwrite(command->job);
    cli_signals_watch(command->job);
    return command->watch ? cli_watch_begin(command->watch, command) : VV_OK;
}

/* VOLVIS_THREADS and VOLVIS_MEMORY stand in for options that were not given. */
static vv_status read_environment(vv_object **common, const char *variable, const char *property)
{
    const char *text = getenv(variable);
    vv_status st;
    if (!text || !*text || vv_object_is_set(*common, property))
        return VV_OK;
    if ((st = vv_path_set(common, property, text, NULL)) != VV_OK)
        return vv_fail_in(st, "the environment's %s=%s", variable, text);
    return VV_OK;
}

static vv_status make_common(cli_command *command)
{
    vv_object *common = NULL;
    vv_status st;
    if ((st = cli_args_object(&common, &command->args, &cli_common_class, NULL)) != VV_OK)
        return st;
    if ((st = read_environment(&common, "VOLVIS_THREADS", "threads")) != VV_OK ||
        (st = read_environment(&common, "VOLVIS_MEMORY", "memory")) != VV_OK) {
        vv_object_release(common);
        return st;
    }
    command->common = (cli_common *)(void *)common;
    return VV_OK;
}

static vv_status make_options(cli_command *command)
{
    vv_status st = VV_OK;
    for (size_t i = 0; i < CLI_VERB_CLASSES && st == VV_OK; i++) {
        const vv_class *cls = command->verb.options[i];
        if (cls && cls != command->verb.own)
            st = cli_args_object(&command->options[i], &command->args, cls, NULL);
    }
    return st;
}

/* Not where help is asked for: it is wanted most when something is wrong. */
static vv_status take_defaults(cli_command *command)
{
    const cli_args *args = &command->args;
    bool wanted = !command->verb.plain;
    for (size_t i = 0; i < args->n_given; i++) {
        const cli_given *given = &args->given[i];
        if (given->cls != &cli_common_class)
            continue;
        if (strcmp(given->row->name, "defaults") == 0)
            wanted = strcmp(given->text, "true") == 0;
        else if (given->row->letter == 'h')
            return VV_OK;
    }
    return wanted ? cli_defaults_take(&command->defaults, &command->args, &command->verb, command->registry) : VV_OK;
}

/* -v, and after a mistake in the words: it may be one of the file's. */
static void tell_defaults(const cli_command *command)
{
    if (command->defaults.taken.n)
        fprintf(stderr, "volvis: %s adds %s; --no-defaults leaves it out\n", command->defaults.path,
                command->defaults.taken.s);
}

vv_status cli_command_drop_looks(cli_command *command, const vv_class *look)
{
    vv_object *common = NULL;
    vv_status st = VV_OK;
    cli_defaults_drop(&command->args, look, NULL);
    cli_defaults_drop(&command->args, &cli_common_class, "set");
    for (size_t i = 0; i < CLI_VERB_CLASSES && st == VV_OK; i++)
        if (command->options[i] && command->options[i]->cls == look) {
            vv_object_release(command->options[i]);
            command->options[i] = NULL;
            st = cli_args_object(&command->options[i], &command->args, look, NULL);
        }
    if (st == VV_OK)
        st = cli_args_object(&common, &command->args, &cli_common_class, NULL);
    if (st != VV_OK)
        return st;
    /* only this list is another: what was said elsewhere since, and who has a string of it, keep the rest */
    vv_collection *set = command->common->set;
    command->common->set = ((cli_common *)(void *)common)->set;
    ((cli_common *)(void *)common)->set = set;
    vv_object_release(common);
    return VV_OK;
}

/* Standard input is gone once it was looked into. */
static bool reads_standard_input(const cli_command *command)
{
    for (size_t i = 0; i < command->args.n_words; i++)
        if (strcmp(command->args.words[i], "-") == 0)
            return true;
    return false;
}

/* Once, and again without what the file of defaults says that does not fit. */
static vv_status run_fitting(cli_command *command)
{
    const vvi_result json = command->json;
    const size_t n_text = command->text.n;
    for (;;) {
        const vv_status st = command->verb.run(command);
        if (st == VV_OK || reads_standard_input(command) || !cli_refusal_gives_way(command))
            return st;
        vvi_text_cut(&command->text, n_text);
        vvi_text_cut(&command->json.text, json.text.n);
        command->json.depth = json.depth;
        command->json.filled = json.filled;
    }
}

/* index: of the input that is taken alone; -1: all are. */
static vv_status run_verb(cli_command *command, int argc, char **argv, long index)
{
    vv_status st;
    if ((st = cli_args_parse(&command->args, &command->verb, argc, argv)) != VV_OK ||
        (st = take_defaults(command)) != VV_OK)
        return st;
    cli_choice_settle(&command->args, &command->verb, command->registry);
    if ((index >= 0 && (st = cli_batch_take(&command->output, &command->args, (size_t)index)) != VV_OK) ||
        (st = make_common(command)) != VV_OK)
        return st;
    if (command->common->help) {
        cli_help_verb(&command->text, &command->verb, command->registry);
        command->verb.makes_file = false;
        return VV_OK;
    }
    if ((st = cli_command_take_output(command)) != VV_OK || (st = cli_command_check_words(command)) != VV_OK ||
        (st = make_options(command)) != VV_OK)
        return st;
    const char *output = command->common->output;
    if (output && !command->verb.makes_file && !command->verb.draws &&
        (st = cli_output_check_text(command, output)) != VV_OK)
        return st;
    if (command->common->verbose)
        tell_defaults(command);
    cli_progress_init(&command->progress, (cli_progress_kind)command->common->progress, command->common->quiet);
    st = run_fitting(command);
    if (st == VV_OK)
        cli_progress_end(&command->progress);
    cli_progress_clear(&command->progress);
    return st;
}

static void finish(cli_command *command)
{
    cli_signals_watch(NULL);
    for (size_t i = 0; i < CLI_VERB_CLASSES; i++)
        vv_object_release(command->options[i]);
    vv_object_release(command->common ? &command->common->base : NULL);
    vv_job_release(command->job);
    vv_runtime_release(command->runtime);
    cli_args_free(&command->args);
    cli_defaults_free(&command->defaults);
    free(command->output);
    vvi_text_free(&command->text);
    vvi_text_free(&command->said);
    vvi_text_free(&command->json.text);
}

static bool asks_json(int argc, char **argv)
{
    for (int i = 0; i < argc && strcmp(argv[i], "--") != 0; i++) {
        if (strcmp(argv[i], "--json") == 0)
            return true;
    }
    return false;
}

static bool is_broken_pipe(vv_status st)
{
    return st == VV_E_WRITE && errno == EPIPE;
}

/* Whatever failed because of it: it was stopped. */
static int report_interrupt(const cli_command *command, bool json)
{
    const bool quiet = command->common && command->common->quiet;
    vv_fail(VV_E_CANCELLED, "interrupted%s", command->verb.makes_file ? ": nothing was written" : "");
    return cli_report_error(VV_E_CANCELLED, NULL, json, quiet);
}

/* A file in the place of a verb is looked at. *n_before: words before those of the verb. */
static vv_status find_verb(cli_command *command, const char *word, int *n_before)
{
    const vv_status st = cli_verb_find(&command->verb, command->registry, word);
    *n_before = 2;
    if (st == VV_OK)
        return st;
    if (access(word, F_OK) != 0)
        return cli_choice_fail(st, command->registry, "verbs", "no verb or file", word);
    *n_before = 1;
    return cli_verb_find(&command->verb, command->registry, "view");
}

/* "volvis", "volvis --help", "volvis --version" */
static const char *word_for_option(int argc, char **argv)
{
    if (argc < 2 || strcmp(argv[1], "--help") == 0 || strcmp(argv[1], "-h") == 0)
        return "help";
    if (strcmp(argv[1], "--version") == 0 || strcmp(argv[1], "-V") == 0)
        return "version";
    return argv[1];
}

/* watch: NULL, or what is read is noted there. */
static int run_once(int argc, char **argv, long index, cli_watch *watch)
{
    cli_command command = {.registry = vv_registry_builtin(), .watch = watch};
    const bool json = asks_json(argc, argv);
    const unsigned faults = vvi_mapping_faults();
    cli_signals_watch(NULL);
    vvi_result_open(&command.json, NULL, '{');
    int n_before;
    vv_status st = find_verb(&command, word_for_option(argc, argv), &n_before);
    if (st == VV_OK)
        st = run_verb(&command, argc > n_before ? argc - n_before : 0, argv + n_before, index);
    if (st == VV_OK && !command.served)
        st = vvi_mapping_check_since(faults);
    if (st == VV_OK && watch) {
        cli_watch_written(watch, &command);
        cli_watch_stamp(&command.text);
    }
    if (st == VV_OK)
        st = cli_report_result(&command);
    const cli_common *common = command.common;
    int code = command.exit_code ? command.exit_code : vv_job_damaged(command.job) ? CLI_EXIT_PARTIAL : 0;
    if (is_broken_pipe(st))
        code = CLI_EXIT_UNREAD;
    else if (st == VV_OK && command.kept)
        code = CLI_EXIT_INTERRUPTED;
    else if (st != VV_OK && cli_signals_came() && !command.served)
        code = report_interrupt(&command, json);
    else if (st != VV_OK)
        code = cli_report_error(st, common ? common->output : NULL, json, common && common->quiet);
    if (st != VV_OK && code == CLI_EXIT_WORDS && !json && !(common && common->verbose))
        tell_defaults(&command);
    if (watch)
        cli_watch_end(watch, &command, code);
    finish(&command);
    return code;
}

/* One run after another; what fails is said, and the others go on. The first failure's code is that of all. */
static int run_each(int argc, char **argv, size_t n)
{
    const bool json = asks_json(argc, argv);
    int code = 0, last = 0;
    if (json)
        puts("[");
    for (size_t i = 0; i < n && !cli_signals_came(); i++) {
        if (json && i)
            puts(",");
        last = run_once(argc, argv, (long)i, NULL);
        code = code ? code : last;
    }
    if (json)
        puts("]");
    return !cli_signals_came() ? code : last == CLI_EXIT_RESUMABLE ? last : CLI_EXIT_INTERRUPTED;
}

typedef struct words {
    int argc;
    char **argv;
    bool each; /* of the inputs is taken alone */
} words;

static int run_watched(void *user, size_t index, cli_watch *watch)
{
    const words *w = user;
    return run_once(w->argc, w->argv, w->each ? (long)index : -1, watch);
}

static bool asks_quiet(const cli_args *args)
{
    bool quiet = false;
    for (size_t i = 0; i < args->n_given; i++)
        if (args->given[i].cls == &cli_common_class && args->given[i].row->letter == 'q')
            quiet = strcmp(args->given[i].text, "true") == 0;
    return quiet;
}

/* What has to be known of the words before the first run: whether there are several, and whether they are watched. Of
 * words that cannot be understood the run itself says so. */
int cli_command_main(int argc, char **argv)
{
    cli_command command = {.registry = vv_registry_builtin()};
    int n_before;
    size_t n = 0;
    bool watches = false, quiet = false, parsed = false;
    vv_status st = find_verb(&command, word_for_option(argc, argv), &n_before);
    if (st == VV_OK && argc > n_before &&
        cli_args_parse(&command.args, &command.verb, argc - n_before, argv + n_before) == VV_OK) {
        parsed = true;
        watches = cli_watch_is_asked(&command.args);
        quiet = asks_quiet(&command.args);
        n = cli_batch_count(&command.args, &command.verb);
        st = cli_batch_check(&command.args, &command.verb);
        if (st == VV_OK && watches)
            st = cli_watch_check(&command.args, &command.verb, command.registry);
    }
    cli_args_free(&command.args);
    if (parsed && st != VV_OK)
        return cli_report_error(st, NULL, asks_json(argc, argv), false);
    if (watches)
        return cli_watch_loop(n > 0 ? n : 1, run_watched, &(words){argc, argv, n > 0}, quiet);
    return n > 0 ? run_each(argc, argv, n) : run_once(argc, argv, -1, NULL);
}
