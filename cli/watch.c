#include "watch.h"
#include "command_words.h"
#include "core/job.h"
#include "output.h"
#include "render/recipe.h"
#include "signals.h"
#include "watch_wait.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <volvis/image.h>

static const vv_property rows[] = {
    {VV_PROP(cli_watching, watch), .kind = VV_KIND_BOOL,
     .doc = "wait, and make the output again whenever a file that was read changes: data, scene, transfer function; "
            "Ctrl-C ends it, with exit code 130"},
    {0},
};

const vv_class cli_watching_class = {
    .name = "watching",
    .doc = "options of verbs that can wait for their inputs to change",
    .size = sizeof(cli_watching),
    .properties = rows,
};

static const cli_given *last_given(const cli_args *args, const vv_class *cls, const char *name)
{
    const cli_given *found = NULL;
    for (size_t i = 0; i < args->n_given; i++)
        if (args->given[i].cls == cls && strcmp(args->given[i].row->name, name) == 0)
            found = &args->given[i];
    return found;
}

static bool is_on(const cli_args *args, const vv_class *cls, const char *name)
{
    const cli_given *given = last_given(args, cls, name);
    return given && strcmp(given->text, "true") == 0;
}

bool cli_watch_is_asked(const cli_args *args)
{
    return is_on(args, &cli_watching_class, "watch") && !is_on(args, &cli_common_class, "help");
}

/* What comes only once cannot be read again. */
static vv_status check_input(const char *word, const char *output)
{
    cli_input_name name;
    struct stat about;
    vv_status st = cli_input_split(&name, word);
    if (st != VV_OK)
        return st;
    if (strcmp(name.path, "-") == 0)
        st = vv_fail(VV_E_ARGUMENT, "--watch: standard input can be read only once; give the input as a file");
    else if (stat(name.path, &about) == 0 && !S_ISREG(about.st_mode) && !S_ISDIR(about.st_mode))
        st = vv_fail_at(VV_E_ARGUMENT, name.path, NULL,
                        "is neither a file nor a folder, and can be read only once: --watch needs files");
    else if (cli_output_is(output, name.path))
        st = vv_fail_at(VV_E_ARGUMENT, output, NULL,
                        "is an input too: with --watch it would be made from itself again and again; name another "
                        "output");
    cli_input_name_free(&name);
    return st;
}

vv_status cli_watch_check(const cli_args *args, const cli_verb *verb, const vv_registry *registry)
{
    const cli_given *given = last_given(args, &cli_common_class, "output");
    const char *last = given ? NULL : cli_command_output_word(args, verb, registry),
               *output = given ? given->text : last;
    const size_t n_inputs = args->n_words - (last != NULL);
    vv_status st = VV_OK;
    if (is_on(args, &cli_common_class, "dry_run"))
        return vv_fail(VV_E_ARGUMENT, "--dry-run makes nothing that --watch could make again; omit one of them");
    if (output && strcmp(output, "-") == 0)
        return vv_fail(VV_E_ARGUMENT, "--watch: -o - cannot be replaced once it has been sent; give -o a file");
    for (size_t i = 0; i < n_inputs && st == VV_OK; i++)
        st = check_input(args->words[i], output);
    return st;
}

static void note_read(void *user, const char *path)
{
    cli_watch *watch = user;
    cli_watch_files_add(&watch->files, path);
}

/* Pictures say that VolVis made them. No job: this is not an input. */
static bool is_our_picture(const char *path)
{
    vv_text *text = NULL;
    size_t n = 0;
    if (vv_image_read_text(&text, &n, path, NULL) != VV_OK)
        return false;
    vv_text_free(text, n);
    return !vvi_recipe_is_missing(path, NULL);
}

static vv_status check_owner(const cli_watch *watch, const cli_command *command)
{
    const char *output = command->common->output;
    const cli_file_state now = output ? cli_file_state_of(&watch->files, output) : 0;
    if (now == 0 || now == watch->written || command->common->overwrite)
        return VV_OK;
    if (watch->written)
        return vv_fail_at(VV_E_ARGUMENT, output, NULL,
                          "was changed by another program, and is not replaced; move it away, or give --overwrite");
    if (is_our_picture(output))
        return VV_OK;
    return vv_fail_at(
        VV_E_ARGUMENT, output, NULL,
        "already exists, and --watch would replace it again and again; choose another name, or give --overwrite");
}

static void own_outputs(cli_watch *watch, const cli_command *command)
{
    const cli_args *args = &command->args;
    const char *output = command->common->output;
    for (size_t i = 0; i < args->n_given; i++)
        if (strcmp(args->given[i].row->name, "save_scene") == 0)
            cli_watch_files_own(&watch->files, args->given[i].text);
    if (!output)
        return;
    cli_watch_files_own(&watch->files, output);
    for (size_t i = 0; i < VV_LAYER_COUNT; i++) {
        char *path = vv_image_layer_path(output, i, command->job);
        if (path)
            cli_watch_files_own(&watch->files, path);
        free(path);
    }
}

vv_status cli_watch_begin(cli_watch *watch, cli_command *command)
{
    if (watch->n_runs++ == 0)
        own_outputs(watch, command);
    const vv_status st = check_owner(watch, command);
    for (size_t i = 0; i < command->args.n_words; i++) {
        cli_input_name name;
        if (cli_input_split(&name, command->args.words[i]) == VV_OK) {
            cli_watch_files_add(&watch->files, name.path);
            cli_input_name_free(&name);
        }
    }
    vvi_job_listen_reads(command->job, note_read, watch);
    return st;
}

void cli_watch_end(cli_watch *watch, const cli_command *command, int code)
{
    const bool made = code == CLI_EXIT_DONE || code == CLI_EXIT_PARTIAL;
    if (command->job)
        vvi_job_listen_reads(command->job, NULL, NULL);
    cli_watch_files_end(&watch->files, !made);
}

void cli_watch_written(cli_watch *watch, const cli_command *command)
{
    const char *output = command->common ? command->common->output : NULL;
    if (output)
        watch->written = cli_file_state_of(&watch->files, output);
}

void cli_watch_stamp(vvi_text *text)
{
    const time_t now = time(NULL);
    struct tm local;
    char stamp[16];
    vvi_text line = {0};
    if (!text->n || !localtime_r(&now, &local))
        return;
    strftime(stamp, sizeof stamp, "%H:%M:%S ", &local);
    vvi_text_add(&line, stamp);
    vvi_text_add_n(&line, text->s, text->n);
    vvi_text_free(text);
    *text = line;
}

/* What another try would not mend. */
static bool is_hopeless(int code)
{
    return code == CLI_EXIT_WORDS || code == CLI_EXIT_OUTPUT || code == CLI_EXIT_INTERRUPTED;
}

static void say_what_is_watched(const cli_watch *watches, size_t n)
{
    size_t n_files = 0;
    bool incomplete = false;
    for (size_t i = 0; i < n; i++) {
        n_files += watches[i].files.n;
        incomplete = incomplete || watches[i].files.incomplete;
    }
    fprintf(stderr, "volvis: watching %zu file%s%s; Ctrl-C ends it\n", n_files, n_files == 1 ? "" : "s",
            incomplete ? ", not all, as there is no memory for more" : "");
}

int cli_watch_loop(size_t n, cli_watch_run_fn *run, void *user, bool quiet)
{
    int code = 0;
    cli_watch *watches = calloc(n, sizeof *watches);
    bool hopeless = !watches;
    for (size_t i = 0; i < n && !hopeless; i++) {
        code = run(user, i, &watches[i]);
        hopeless = is_hopeless(code) || cli_signals_came();
    }
    if (!hopeless && !quiet)
        say_what_is_watched(watches, n);
    while (!hopeless && !cli_signals_came()) {
        const size_t changed = cli_watch_wait(watches, n);
        cli_watch_files_begin(&watches[changed].files); /* before all that may fail: what failed waits for a change */
        code = run(user, changed, &watches[changed]);
    }
    for (size_t i = 0; watches && i < n; i++)
        cli_watch_files_free(&watches[i].files);
    free(watches);
    return !watches ? CLI_EXIT_LIMIT : cli_signals_came() ? CLI_EXIT_INTERRUPTED : code;
}
