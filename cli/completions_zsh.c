#include "args.h"
#include "completions.h"
#include "usage.h"
#include <string.h>

/* Text inside '...[...]...' of _arguments and _describe: brackets and colons mean something there. */
static void add_doc(vvi_text *out, const char *doc)
{
    for (; *doc; doc++) {
        if (strchr("[]:\\", *doc))
            vvi_text_add(out, "\\");
        const char one[2] = {*doc, 0};
        cli_completions_quote(out, one);
    }
}

static void add_action(vvi_text *out, const vv_registry *registry, const vv_property *row)
{
    vvi_text choices = {0};
    if (cli_completions_choices(&choices, registry, row)) {
        vvi_text_add(out, ":value:(");
        cli_completions_quote(out, choices.s);
        vvi_text_add(out, ")");
    } else if (row->kind == VV_KIND_PATH) {
        vvi_text_add(out, ":file:_files");
    } else {
        vvi_text_add(out, ":value: ");
    }
    vvi_text_free(&choices);
}

static void add_option(vvi_text *out, const vv_registry *registry, const vv_property *row)
{
    char name[64];
    vvi_text about = {0};
    cli_option_name(name, row);
    cli_usage_about(&about, row);
    vvi_text_printf(out, "            '%s--%s%s%s[", row->kind == VV_KIND_LIST || cli_option_adds_row(row) ? "*" : "",
                    row->kind == VV_KIND_BOOL && row->def != 0 ? "no-" : "", name,
                    row->kind == VV_KIND_BOOL ? ""
                    : cli_option_alone(row)   ? "=-"
                                              : "=");
    add_doc(out, about.bad ? "" : about.s);
    vvi_text_free(&about);
    vvi_text_add(out, "]");
    if (cli_option_alone(row))
        vvi_text_add(out, ":");
    if (row->kind != VV_KIND_BOOL)
        add_action(out, registry, row);
    vvi_text_add(out, "' \\\n");
    if (row->letter && row->kind == VV_KIND_PATH)
        vvi_text_printf(out, "            '-%c:file:_files' \\\n", row->letter);
}

static void add_verb(vvi_text *out, const vv_registry *registry, const cli_verb *verb)
{
    const vv_class *cls;
    vvi_text choices = {0};
    vvi_text_printf(out, "        %s)\n        _arguments \\\n", verb->name);
    for (size_t c = 0; (cls = cli_usage_shown(verb, c)); c++) {
        for (const vv_property *row = cls->properties; row->name; row++)
            if (cli_option_is_listed(row))
                add_option(out, registry, row);
    }
    if (cli_completions_words(&choices, registry, verb)) {
        vvi_text_printf(out, "            '*:word:%s(", verb->files_too ? "{_alternative \"words:word:" : "");
        cli_completions_quote(out, choices.s);
        vvi_text_printf(out, ")%s' ;;\n", verb->files_too ? "\" \"files:file:_files\"}" : "");
    } else {
        vvi_text_add(out, "            '*:file:_files' ;;\n");
    }
    vvi_text_free(&choices);
}

void cli_completions_zsh(vvi_text *out, const vv_registry *registry)
{
    cli_verb verb;
    vvi_text_add(out, "#compdef volvis\n_volvis()\n{\n    local -a verbs=(\n");
    for (size_t i = 0; cli_verb_nth(&verb, registry, i); i++) {
        if (verb.hidden)
            continue;
        vvi_text_printf(out, "        '%s:", verb.name);
        add_doc(out, verb.doc);
        vvi_text_add(out, "'\n");
    }
    vvi_text_add(out, "    )\n    if (( CURRENT == 2 )); then\n        _describe verb verbs\n        return\n    fi\n"
                      "    local verb=$words[2]\n    shift words\n    (( CURRENT-- ))\n    case $verb in\n");
    for (size_t i = 0; cli_verb_nth(&verb, registry, i); i++) {
        if (!verb.hidden)
            add_verb(out, registry, &verb);
    }
    vvi_text_add(out, "    esac\n}\n_volvis \"$@\"\n");
}
