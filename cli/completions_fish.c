#include "args.h"
#include "completions.h"
#include "usage.h"
#include <string.h>

/* Inside single quotes fish takes \' and \\. */
static void quote(vvi_text *out, const char *s)
{
    for (; *s; s++) {
        if (*s == '\'' || *s == '\\')
            vvi_text_add(out, "\\");
        vvi_text_add_n(out, s, 1);
    }
}

static void add_option(vvi_text *out, const vv_registry *registry, const char *verb, const vv_property *row)
{
    char name[64];
    vvi_text choices = {0}, about = {0};
    cli_option_name(name, row);
    cli_usage_about(&about, row);
    vvi_text_printf(out, "complete -c volvis -n '__fish_seen_subcommand_from %s' -l %s%s", verb,
                    row->kind == VV_KIND_BOOL && row->def != 0 ? "no-" : "", name);
    if (row->letter)
        vvi_text_printf(out, " -s %c", row->letter);
    if (row->kind == VV_KIND_PATH) {
        vvi_text_add(out, " -r");
    } else if (row->kind != VV_KIND_BOOL && !cli_option_alone(row)) {
        vvi_text_add(out, " -x");
        if (cli_completions_choices(&choices, registry, row)) {
            vvi_text_add(out, " -a '");
            quote(out, choices.s);
            vvi_text_add(out, "'");
        }
    }
    vvi_text_add(out, " -d '");
    quote(out, about.bad ? "" : about.s);
    vvi_text_add(out, "'\n");
    vvi_text_free(&about);
    vvi_text_free(&choices);
}

static void add_verb(vvi_text *out, const vv_registry *registry, const cli_verb *verb)
{
    const vv_class *cls;
    vvi_text choices = {0};
    vvi_text_printf(out, "complete -c volvis -f -n __fish_use_subcommand -a %s -d '", verb->name);
    quote(out, verb->doc);
    vvi_text_add(out, "'\n");
    if (cli_completions_words(&choices, registry, verb)) {
        vvi_text_printf(out, "complete -c volvis -f -n '__fish_seen_subcommand_from %s' -a '", verb->name);
        quote(out, choices.s);
        vvi_text_add(out, "'\n");
    }
    vvi_text_free(&choices);
    for (size_t c = 0; (cls = cli_usage_shown(verb, c)); c++) {
        for (const vv_property *row = cls->properties; row->name; row++)
            if (cli_option_is_listed(row))
                add_option(out, registry, verb->name, row);
    }
}

void cli_completions_fish(vvi_text *out, const vv_registry *registry)
{
    cli_verb verb;
    vvi_text_add(out, "# fish completion for volvis\n");
    for (size_t i = 0; cli_verb_nth(&verb, registry, i); i++) {
        if (!verb.hidden)
            add_verb(out, registry, &verb);
    }
}
