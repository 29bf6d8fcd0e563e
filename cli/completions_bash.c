#include "args.h"
#include "completions.h"
#include "options.h"
#include "usage.h"

/* A case for each option with a value: its list, or nothing, where files are bash's own default. */
static void add_values(vvi_text *out, const vv_registry *registry, const char *verb, const vv_class *cls)
{
    for (const vv_property *row = cls->properties; row->name; row++) {
        vvi_text choices = {0};
        char name[64];
        cli_option_name(name, row);
        if (!*name)
            continue;
        if (cli_completions_choices(&choices, registry, row)) {
            vvi_text_printf(out, "    %s:--%s) words='", verb, name);
            cli_completions_quote(out, choices.s);
            vvi_text_add(out, "' ;;\n");
        } else if (row->kind != VV_KIND_BOOL) {
            vvi_text_printf(out, "    %s:--%s", verb, name);
            if (row->letter)
                vvi_text_printf(out, "|%s:-%c", verb, row->letter);
            vvi_text_add(out, ") ;;\n");
        }
        vvi_text_free(&choices);
    }
}

static void add_options(vvi_text *out, const cli_verb *verb)
{
    const vv_class *cls;
    vvi_text_printf(out, "        %s) words='", verb->name);
    for (size_t c = 0; (cls = cli_usage_shown(verb, c)); c++) {
        for (const vv_property *row = cls->properties; row->name; row++) {
            char name[64];
            if (!cli_option_is_listed(row))
                continue;
            cli_option_name(name, row);
            vvi_text_printf(out, "--%s%s ", row->kind == VV_KIND_BOOL && row->def != 0 ? "no-" : "", name);
        }
    }
    vvi_text_add(out, "' ;;\n");
}

static void add_words(vvi_text *out, const vv_registry *registry, const cli_verb *verb)
{
    vvi_text choices = {0};
    if (cli_completions_words(&choices, registry, verb)) {
        vvi_text_printf(out, "        %s) words='", verb->name);
        cli_completions_quote(out, choices.s);
        vvi_text_printf(out, "'%s ;;\n", verb->files_too ? " files=-f" : "");
    }
    vvi_text_free(&choices);
}

static void for_verbs(vvi_text *out, const vv_registry *registry, int part)
{
    cli_verb verb;
    for (size_t i = 0; cli_verb_nth(&verb, registry, i); i++) {
        if (verb.hidden)
            continue;
        if (part == 0)
            vvi_text_printf(out, "%s ", verb.name);
        else if (part == 2)
            add_options(out, &verb);
        else if (part == 3)
            add_words(out, registry, &verb);
        const vv_class *cls;
        for (size_t c = 0; part == 1 && (cls = cli_usage_shown(&verb, c)); c++)
            if (cls != &cli_common_plain_class)
                add_values(out, registry, verb.name, cls);
    }
}

void cli_completions_bash(vvi_text *out, const vv_registry *registry)
{
    vvi_text_add(out, "# bash completion for volvis\n_volvis()\n{\n"
                      "    local cur=${COMP_WORDS[COMP_CWORD]} prev=${COMP_WORDS[COMP_CWORD-1]} verb=${COMP_WORDS[1]} "
                      "words= files=\n"
                      "    [[ $cur == = ]] && cur=\n"
                      "    if [[ $prev == = ]]; then prev=${COMP_WORDS[COMP_CWORD-2]}; fi\n"
                      "    if (( COMP_CWORD == 1 )); then\n        mapfile -t COMPREPLY < <(compgen -W '");
    for_verbs(out, registry, 0);
    vvi_text_add(out, "' -- \"$cur\")\n        return\n    fi\n    case $verb:$prev in\n");
    for_verbs(out, registry, 1);
    add_values(out, registry, "*", &cli_common_plain_class);
    vvi_text_add(out, "    *)\n        if [[ $cur == -* ]]; then case $verb in\n");
    for_verbs(out, registry, 2);
    vvi_text_add(out, "        esac; else case $verb in\n");
    for_verbs(out, registry, 3);
    vvi_text_add(out, "        esac; fi ;;\n    esac\n"
                      "    mapfile -t COMPREPLY < <(compgen $files -W \"$words\" -- \"$cur\")\n"
                      "    [[ $files && ${#COMPREPLY[@]} -gt 0 ]] && compopt -o filenames\n"
                      "    [[ ${COMPREPLY[0]} == *= ]] && compopt -o nospace\n"
                      "    return 0\n}\ncomplete -o default -F _volvis volvis\n");
}
