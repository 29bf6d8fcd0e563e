#include "properties.h"
#include "args.h"
#include "help.h"
#include "usage.h"

/* What is worked out has no default that could be given. */
static void add_default(vvi_result *json, const vv_property *row)
{
    if (row->automatic)
        vvi_result_string(json, "automatic", row->automatic);
    else if (!vvi_property_tell_default(json, row) && row->def_text)
        vvi_result_string(json, "default", row->def_text);
}

static void add_aliases(vvi_result *json, const vv_property *row)
{
    if (!row->aliases)
        return;
    vvi_result_open(json, "aliases", '{');
    for (const char *const *pair = row->aliases; pair[0]; pair += 2)
        vvi_result_string(json, pair[0], pair[1]);
    vvi_result_close(json, '}');
}

void cli_properties_json(vvi_result *json, const char *key, const vv_class *cls)
{
    vvi_result_open(json, key, '[');
    for (const vv_property *row = cls ? cls->properties : NULL; row && row->name; row++) {
        char letter[2] = {row->letter, 0};
        if (!cli_option_is_listed(row))
            continue;
        vvi_result_open(json, NULL, '{');
        vvi_property_tell(json, row);
        if (row->option)
            vvi_result_string(json, "option", row->option);
        if (row->letter)
            vvi_result_string(json, "letter", letter);
        if (row->kind == VV_KIND_ENUM)
            vvi_result_strings(json, "values", row->names);
        add_aliases(json, row);
        add_default(json, row);
        vvi_result_close(json, '}');
    }
    vvi_result_close(json, ']');
}

static void add_left(vvi_text *left, const char *prefix, const vv_property *row, bool as_options)
{
    const bool inner = row->kind == VV_KIND_OBJECT || row->kind == VV_KIND_MAP || row->kind == VV_KIND_LIST ||
                       row->kind == VV_KIND_VARIANTS;
    if (as_options) {
        cli_usage_option(left, row);
        return;
    }
    vvi_text_printf(left, "%s%s", prefix, row->name);
    if (inner)
        return;
    vvi_text_add(left, "=");
    if (row->kind == VV_KIND_BOOL)
        vvi_text_add(left, "true|false");
    else
        cli_usage_value(left, row);
}

void cli_properties_text(vvi_text *out, const char *prefix, const vv_class *cls, bool as_options)
{
    for (const vv_property *row = cls->properties; row->name; row++) {
        vvi_text left = {0}, right = {0};
        if (as_options ? !cli_option_is_listed(row) : row->hidden || row->kind == VV_KIND_VARIANTS)
            continue;
        add_left(&left, prefix, row, as_options);
        if (as_options)
            cli_usage_option_doc(&right, row);
        else
            cli_usage_doc(&right, row);
        if (left.bad || right.bad)
            out->bad = true;
        else
            cli_help_entry(out, left.s, right.s);
        vvi_text_free(&left);
        vvi_text_free(&right);
    }
}
