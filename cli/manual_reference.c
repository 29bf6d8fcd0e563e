#include "args.h"
#include "manual.h"
#include "options.h"
#include "usage.h"
#include <volvis/render.h>

/* A cell of a table: bars would end it, angle brackets would be HTML. */
static void add_cell(vvi_text *out, const char *s)
{
    for (; *s; s++) {
        if (*s == '|')
            vvi_text_add(out, "\\|");
        else if (*s == '<')
            vvi_text_add(out, "&lt;");
        else
            vvi_text_add_n(out, s, 1);
    }
}

static void add_entry(vvi_text *out, const char *left, const char *right)
{
    vvi_text_add(out, "| `");
    add_cell(out, left);
    vvi_text_add(out, "` | ");
    add_cell(out, right);
    vvi_text_add(out, " |\n");
}

static void add_row(vvi_text *out, const char *left, const vv_property *row, bool option)
{
    vvi_text right = {0};
    if (option)
        cli_usage_option_doc(&right, row);
    else
        cli_usage_doc(&right, row);
    add_entry(out, left, right.bad ? "" : right.s);
    vvi_text_free(&right);
}

static void add_class(vvi_text *out, const char *title, const vv_class *cls)
{
    vvi_text_printf(out, "\n%s\n\n| option | meaning |\n| --- | --- |\n", title);
    for (const vv_property *row = cls->properties; row->name; row++) {
        vvi_text left = {0};
        cli_usage_option(&left, row);
        if (cli_option_is_listed(row))
            add_row(out, left.bad ? "" : left.s, row, true);
        vvi_text_free(&left);
    }
}

static void add_verb(vvi_text *out, const cli_verb *verb)
{
    vvi_text usage = {0};
    const char *example;
    cli_usage_line(&usage, verb);
    vvi_text_printf(out, "\n### volvis %s\n\n%s.\n\n    %s\n", verb->name, verb->doc, usage.bad ? "" : usage.s);
    if (verb->about)
        vvi_text_printf(out, "\n%s\n", verb->about);
    cli_usage_inputs(out, verb, "\nInputs:\n\n| input | meaning |\n| --- | --- |\n", add_entry);
    for (size_t i = 0; i < CLI_VERB_CLASSES; i++) {
        const vv_class *cls = verb->options[i];
        const char *title = cli_is_reading(cls) ? "Reading:" : cls == &cli_writing_class ? "Writing:" : "Options:";
        if (cls && cls->properties->name)
            add_class(out, title, cls);
    }
    vvi_text_add(out, "\nExamples:\n\n");
    for (size_t i = 0; (example = cli_usage_example(verb, i)); i++)
        vvi_text_printf(out, "    %s\n", example);
    vvi_text_free(&usage);
}

static void add_path(void *user, const char *path, const vv_property *row)
{
    add_row(user, path, row, false);
}

static void add_lists(vvi_text *out, const vv_registry *registry)
{
    const vv_preset *preset;
    vvi_text_add(out, "\n## Formats\n\n| name | suffixes | reads | writes | |\n| --- | --- | --- | --- | --- |\n");
    for (size_t i = 0; registry->formats[i]; i++) {
        const vv_format *f = registry->formats[i];
        vvi_text_printf(out, "| %s |", f->name);
        for (size_t s = 0; f->suffixes && f->suffixes[s]; s++)
            vvi_text_printf(out, " `%s`", f->suffixes[s]);
        vvi_text_printf(out, " | %s | %s | %s |\n", f->read_header ? "yes" : "no", f->write ? "yes" : "no", f->doc);
    }
    vvi_text_add(out, "\n## Mesh formats\n\n| name | suffixes | encodings | |\n| --- | --- | --- | --- |\n");
    for (size_t i = 0; registry->mesh_formats[i]; i++) {
        const vv_mesh_format *f = registry->mesh_formats[i];
        vvi_text_printf(out, "| %s |", f->name);
        for (size_t s = 0; f->suffixes[s]; s++)
            vvi_text_printf(out, " `%s`", f->suffixes[s]);
        vvi_text_add(out, " |");
        for (size_t e = 0; f->encodings && f->encodings[e]; e++)
            vvi_text_printf(out, " %s", f->encodings[e]);
        vvi_text_printf(out, " | %s |\n", f->doc);
    }
    vvi_text_add(out, "\n## Rendering methods\n\n| name | |\n| --- | --- |\n");
    for (size_t i = 0; registry->renderers[i]; i++)
        vvi_text_printf(out, "| %s | %s |\n", registry->renderers[i]->name, registry->renderers[i]->doc);
    vvi_text_add(out, "\n## Presets\n\n| name | kind | |\n| --- | --- | --- |\n");
    for (size_t i = 0; (preset = vv_preset_nth(i)); i++)
        vvi_text_printf(out, "| %s | %s | %s |\n", preset->name, preset->kind, preset->doc);
}

void cli_manual_reference(vvi_text *out, const vv_registry *registry)
{
    cli_verb verb;
    vvi_text_add(out, "# VolVis reference\n\nMade by `volvis reference` from the program's own tables.\n\n## Verbs\n");
    for (size_t i = 0; cli_verb_nth(&verb, registry, i); i++) {
        if (!verb.hidden)
            add_verb(out, &verb);
    }
    add_class(out, "### Options of every verb", &cli_common_class);
    add_lists(out, registry);
    vvi_text_add(out, "\n## Properties of a World\n\nSet with `--set PATH=VALUE` and in scene files; ID stands for the "
                      "name of a thing, 0 for its place in a list. A star in place of either is all of them "
                      "(`volumes.*.visible=false`), and a number in place of ID the thing at that place "
                      "(`volumes.0.visible=false`).\n\n| path | meaning |\n| --- | --- |\n");
    cli_usage_paths(registry, add_path, out);
}
