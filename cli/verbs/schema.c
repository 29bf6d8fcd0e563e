#include "command.h"
#include "core/result.h"
#include "input/bindings.h"
#include "server/tables.h"
#include "verbs.h"
#include <stdlib.h>
#include <volvis/model.h>

typedef struct schema_options {
    vv_object base;
    bool tables;
} schema_options;

static const vv_property rows[] = {
    {VV_PROP(schema_options, tables), .kind = VV_KIND_BOOL,
     .doc = "instead, the tables that a page is given: classes, operations, renderers, presets, methods, bindings"},
    {0},
};

static const vv_class options_class = {
    .name = "schema",
    .doc = "options of schema",
    .size = sizeof(schema_options),
    .properties = rows,
};

/* As in the server's welcome, so that a page can be worked on without a server (docs/protocol.md). */
static vv_status tell_tables(cli_command *command)
{
    char *bindings = vvi_bindings_default();
    if (!bindings)
        return vv_fail_memory(0);
    vvi_result out = {0};
    vvi_result_open(&out, NULL, '{');
    vvi_result_raw(&out, "bindings", bindings);
    vvi_tables_tell(&out, command->registry);
    vvi_result_close(&out, '}');
    free(bindings);
    command->verbatim = true;
    const vv_status st = out.text.bad ? vv_fail_memory(out.text.n) : VV_OK;
    if (st == VV_OK) {
        vvi_text_add(&command->text, out.text.s);
        vvi_text_add(&command->text, "\n");
    }
    vvi_text_free(&out.text);
    return st;
}

static vv_status run(cli_command *command)
{
    const schema_options *options = cli_command_options(command, &options_class);
    if (options->tables)
        return tell_tables(command);
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

static const char *const examples[] = {"volvis schema", "volvis schema -o volvis.schema.json",
                                       "volvis schema --tables -o tables.json", NULL};

const cli_verb cli_verb_schema = {
    .name = "schema",
    .doc = "the JSON Schema of scene files",
    .examples = examples,
    .options = {&options_class},
    .plain = true,
    .run = run,
};
