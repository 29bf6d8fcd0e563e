#include "command.h"
#include "verbs.h"
#include <stdlib.h>
#include <volvis/model.h>

static vv_status run(cli_command *command)
{
    char *schema = NULL;
    const vv_status st = vv_scene_schema(&schema, command->registry);
    if (st != VV_OK)
        return st;
    command->verbatim = true;
    vvi_text_add(&command->text, schema);
    if (command->text.n && command->text.s[command->text.n - 1] != '\n')
        vvi_text_add(&command->text, "\n");
    free(schema);
    return VV_OK;
}

static const char *const examples[] = {"volvis schema", "volvis schema -o volvis.schema.json", NULL};

const cli_verb cli_verb_schema = {
    .name = "schema",
    .doc = "the JSON Schema of scene files",
    .examples = examples,
    .plain = true,
    .run = run,
};
