#include "help.h"
#include "core/status.h"
#include "model/context.h"
#include "options.h"
#include "properties.h"
#include "terminal.h"
#include "usage.h"
#include "value.h"
#include <stdio.h>
#include <string.h>
#include <unistd.h>
#include <volvis/model.h>

enum { LEFT_COLUMN = 2, RIGHT_COLUMN = 30 };

static size_t width(void)
{
    return (size_t)cli_terminal_width(STDOUT_FILENO);
}

void cli_help_entry(vvi_text *out, const char *left, const char *right)
{
    const size_t columns = LEFT_COLUMN + cli_text_columns(left);
    vvi_text_printf(out, "%*s%s", LEFT_COLUMN, "", left);
    if (columns + 2 > RIGHT_COLUMN)
        vvi_text_printf(out, "\n%*s", RIGHT_COLUMN, "");
    else
        vvi_text_printf(out, "%*s", (int)(RIGHT_COLUMN - columns), "");
    cli_text_wrap(out, right, RIGHT_COLUMN, RIGHT_COLUMN, width());
}

/* title NULL: it goes on under the last one. */
static void add_class(vvi_text *out, const char *title, const vv_class *cls)
{
    if (title)
        vvi_text_printf(out, "\n%s\n", title);
    cli_properties_text(out, "", cls, true);
}

static void add_paragraph(vvi_text *out, const char *text)
{
    vvi_text_add(out, "\n");
    cli_text_wrap(out, text, 0, 0, width());
}

static void add_world(vvi_text *out, const vv_registry *registry)
{
    vvi_text_add(out, "\nProperties, for --set PATH=VALUE\n");
    for (size_t i = 0; registry->renderers[i]; i++) {
        char prefix[96];
        snprintf(prefix, sizeof prefix, "views.VIEW.render.%s.", registry->renderers[i]->name);
        cli_properties_text(out, prefix, registry->renderers[i]->params, false);
    }
    cli_properties_text(out, "", &vv_world_class, false);
}

void cli_help_verb(vvi_text *out, const cli_verb *verb, const vv_registry *registry)
{
    vvi_text_printf(out, "volvis %s: ", verb->name);
    cli_text_wrap(out, verb->doc, strlen(verb->name) + 9, 4, width());
    vvi_text_add(out, "\nusage: ");
    cli_usage_line(out, verb);
    vvi_text_add(out, "\n");
    if (verb->about)
        add_paragraph(out, verb->about);
    cli_usage_inputs(out, verb, "\nInputs\n", cli_help_entry);
    const char *last = NULL;
    for (size_t i = 0; i < CLI_VERB_CLASSES; i++) {
        const vv_class *cls = verb->options[i];
        const char *title = cli_is_reading(cls) ? "Reading" : cls == &cli_writing_class ? "Writing" : "Options";
        if (!cls || !cls->properties->name)
            continue;
        add_class(out, title == last ? NULL : title, cls);
        last = title;
    }
    add_class(out, "Options of every verb", verb->world ? &cli_common_class : &cli_common_plain_class);
    if (verb->world)
        add_world(out, registry);
    const char *example;
    if (cli_usage_example(verb, 0))
        vvi_text_add(out, "\nExamples\n");
    for (size_t i = 0; (example = cli_usage_example(verb, i)); i++)
        vvi_text_printf(out, "  %s\n", example);
}

static void add_verbs(vvi_text *out, const vv_registry *registry, bool operations)
{
    cli_verb verb;
    for (size_t i = 0; cli_verb_nth(&verb, registry, i); i++) {
        if (!verb.hidden && (verb.operation != NULL) == operations)
            cli_help_entry(out, verb.name, verb.doc);
    }
}

void cli_help_overview(vvi_text *out, const vv_registry *registry)
{
    vvi_text_add(out, "volvis: see, measure and change volumes\n\n"
                      "usage: volvis VERB [options] INPUT... [-o OUTPUT]\n\nVerbs\n");
    add_verbs(out, registry, false);
    vvi_text_add(out, "\nOperations: new data from old\n");
    add_verbs(out, registry, true);
    add_class(out, "Options of every verb", &cli_common_class);
    add_paragraph(out, "'volvis help VERB' explains a verb, 'volvis help PATH' a property such as "
                       "lights.key.intensity, and 'volvis doctor' shows what this installation can do.");
    add_paragraph(out,
                  "Exit codes: 0 done, 1 could not be done, 2 the command line is wrong, 3 an input cannot be read, 4 "
                  "the memory limit would be exceeded, 5 the output cannot be written, 6 a comparison differs, 7 "
                  "done in part, 75 stopped and to be gone on with, 130 interrupted, 141 whoever read the output has "
                  "closed it.");
}

static void add_one_property(vvi_text *out, const char *path, const vv_property *row)
{
    vvi_text text = {0};
    vvi_text_printf(out, "%s: ", path);
    cli_usage_doc(&text, row);
    cli_text_wrap(out, text.bad ? "" : text.s, strlen(path) + 2, 4, width());
    out->bad = out->bad || text.bad;
    vvi_text_free(&text);
    if (row->kind == VV_KIND_BOOL)
        vvi_text_printf(out, "\n  --set %s=true|false\n", path);
    else {
        vvi_text_printf(out, "\n  --set %s=", path);
        cli_usage_value(out, row);
        vvi_text_add(out, "\n");
    }
}

vv_status cli_help_path(vvi_text *out, const char *path, const vv_registry *registry)
{
    const vv_property_context context = vvi_registry_context(registry);
    const vv_property *row;
    const vv_class *cls;
    vv_status st;
    if ((st = vv_path_row(&row, &cls, &vv_world_class, path, &context)) != VV_OK)
        return st;
    if (!cls) {
        add_one_property(out, path, row);
        return VV_OK;
    }
    const bool entries = row->kind == VV_KIND_MAP || row->kind == VV_KIND_LIST;
    vvi_text prefix = {0};
    vvi_text_printf(&prefix, "%s.", path);
    if (entries && strcmp(path + strlen(path) - strlen(row->name), row->name) == 0)
        vvi_text_add(&prefix, row->kind == VV_KIND_MAP ? "ID." : "0.");
    vvi_text_printf(out, "%s: ", path);
    cli_text_wrap(out, cls->doc, strlen(path) + 2, 4, width());
    vvi_text_add(out, "\n");
    cli_properties_text(out, prefix.bad ? "" : prefix.s, cls, false);
    vvi_text_free(&prefix);
    return VV_OK;
}
