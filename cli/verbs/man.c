/* Hidden: what the build installs as man pages. */
#include "command.h"
#include "manual.h"
#include "report.h"
#include "verbs.h"
#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

typedef struct man_options {
    vv_object base;
    char *into;
} man_options;

static const vv_property rows[] = {
    {VV_PROP(man_options, into), .kind = VV_KIND_PATH, .automatic = "one page is printed",
     .doc = "write all pages into this folder"},
    {0},
};

static const vv_class options_class = {
    .name = "man",
    .doc = "options of man",
    .size = sizeof(man_options),
    .properties = rows,
};

static vv_status write_page(cli_command *command, const char *folder, const char *name, vvi_text *page)
{
    char path[1024];
    vv_status st = VV_OK;
    if (snprintf(path, sizeof path, "%s/%s.1", folder, name) >= (int)sizeof path)
        st = vv_fail_at(VV_E_ARGUMENT, folder, NULL, "the folder's name is too long");
    else if (page->bad)
        st = vv_fail_memory(page->n);
    else
        st = cli_report_file(command, path, page->s, page->n);
    vvi_text_free(page);
    return st;
}

static vv_status write_all(cli_command *command, const char *folder)
{
    cli_verb verb;
    vvi_text page = {0};
    vv_status st;
    if (mkdir(folder, 0777) != 0 && errno != EEXIST)
        return vv_fail_at(VV_E_WRITE, folder, NULL, "the folder cannot be made: %s", strerror(errno));
    cli_manual_program(&page, command->registry);
    st = write_page(command, folder, "volvis", &page);
    for (size_t i = 0; cli_verb_nth(&verb, command->registry, i) && st == VV_OK; i++) {
        char name[96];
        if (verb.hidden)
            continue;
        snprintf(name, sizeof name, "volvis-%s", verb.name);
        cli_manual_verb(&page, &verb);
        st = write_page(command, folder, name, &page);
    }
    return st;
}

static vv_status run(cli_command *command)
{
    const man_options *options = cli_command_options(command, &options_class);
    const char *word = cli_command_word(command, 0);
    cli_verb verb;
    vv_status st;
    command->verbatim = true;
    if (options->into)
        return write_all(command, options->into);
    if (!word) {
        cli_manual_program(&command->text, command->registry);
        return VV_OK;
    }
    if ((st = cli_verb_find(&verb, command->registry, word)) == VV_OK)
        cli_manual_verb(&command->text, &verb);
    return st;
}

static const char *const examples[] = {"volvis man render", NULL};

const cli_verb cli_verb_man = {
    .name = "man",
    .doc = "a man page in roff",
    .words = "VERB",
    .choices = "verbs",
    .max_words = 1,
    .options = {&options_class},
    .examples = examples,
    .hidden = true,
    .plain = true,
    .run = run,
};
