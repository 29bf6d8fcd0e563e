#include "completions.h"
#include "choices.h"
#include "usage.h"
#include <string.h>

static void add_path(void *user, const char *path, const vv_property *row)
{
    vvi_text *out = user;
    if (row->kind != VV_KIND_OBJECT && row->kind != VV_KIND_LIST && row->kind != VV_KIND_MAP &&
        row->kind != VV_KIND_VARIANTS)
        vvi_text_printf(out, "%s%s=", out->n ? " " : "", path);
}

bool cli_completions_choices(vvi_text *out, const vv_registry *registry, const vv_property *row)
{
    const size_t before = out->n;
    const char *choice;
    if (row->table && strcmp(row->table, "properties") == 0) {
        vvi_text paths = {0};
        cli_usage_paths(registry, add_path, &paths);
        vvi_text_add(out, paths.n ? paths.s : "");
        vvi_text_free(&paths);
    }
    for (size_t i = 0; (choice = cli_choice_of_row(registry, row, i)); i++)
        vvi_text_printf(out, "%s%s", i ? " " : "", choice);
    return out->n > before;
}

bool cli_completions_words(vvi_text *out, const vv_registry *registry, const cli_verb *verb)
{
    const char *choice;
    size_t n = 0;
    for (; verb->choices && (choice = cli_choice_nth(registry, verb->choices, n)); n++)
        vvi_text_printf(out, "%s%s", n ? " " : "", choice);
    return n > 0;
}

void cli_completions_quote(vvi_text *out, const char *s)
{
    for (; *s; s++) {
        if (*s == '\'')
            vvi_text_add(out, "'\\''");
        else
            vvi_text_add_n(out, s, 1);
    }
}
