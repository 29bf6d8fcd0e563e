/* Hidden: the reference pages of the documentation. */
#include "command.h"
#include "manual.h"
#include "verbs.h"

static vv_status run(cli_command *command)
{
    command->verbatim = true;
    cli_manual_reference(&command->text, command->registry);
    return VV_OK;
}

static const char *const examples[] = {"volvis reference -o reference.md", NULL};

const cli_verb cli_verb_reference = {
    .name = "reference",
    .doc = "all verbs, formats, methods, presets and properties, in Markdown",
    .examples = examples,
    .hidden = true,
    .plain = true,
    .run = run,
};
