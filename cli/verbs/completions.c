#include "completions.h"
#include "command.h"
#include "core/names.h"
#include "verbs.h"
#include <string.h>

static const struct {
    const char *shell;
    void (*write)(vvi_text *out, const vv_registry *registry);
} shells[] = {
    {"bash", cli_completions_bash},
    {"zsh", cli_completions_zsh},
    {"fish", cli_completions_fish},
};
enum { N_SHELLS = sizeof shells / sizeof shells[0] };

static vv_status run(cli_command *command)
{
    const char *shell = cli_command_word(command, 0);
    const char *names[N_SHELLS];
    for (size_t i = 0; i < N_SHELLS; i++) {
        names[i] = shells[i].shell;
        if (strcmp(shell, shells[i].shell) == 0) {
            shells[i].write(&command->text, command->registry);
            command->verbatim = true;
            return VV_OK;
        }
    }
    return vvi_fail_name(VV_E_ARGUMENT, NULL, NULL, shell, &(vvi_known){names, N_SHELLS, NULL, NULL},
                         "no completions for a shell '%s'", shell);
}

static const char *const examples[] = {"volvis completions bash", "volvis completions zsh",
                                       "volvis completions fish -o volvis.fish", NULL};

const cli_verb cli_verb_completions = {
    .name = "completions",
    .doc = "a script that completes verbs, options and names in a shell",
    .words = "bash|zsh|fish",
    .choices = "shells",
    .min_words = 1,
    .max_words = 1,
    .examples = examples,
    .plain = true,
    .run = run,
};
