#include "usage.h"
#include "args.h"
#include "core/units.h"
#include "edits.h"
#include "measure.h"
#include "model/context.h"
#include "operands.h"
#include "options.h"
#include "value.h"
#include <ctype.h>
#include <stdio.h>
#include <string.h>
#include <volvis/model.h>
#include <volvis/render.h>

static const char *quantity_value(vv_quantity quantity)
{
    switch (quantity) {
    case VV_Q_LENGTH:
        return "LENGTH";
    case VV_Q_ANGLE:
        return "ANGLE";
    case VV_Q_TIME:
        return "TIME";
    case VV_Q_BYTES:
        return "SIZE";
    case VV_Q_RATIO:
        return "RATIO";
    case VV_Q_LABEL:
    case VV_Q_NONE:
        break;
    }
    return "VALUE";
}

static void add_names(vvi_text *out, const char *const *names)
{
    for (size_t i = 0; names && names[i]; i++)
        vvi_text_printf(out, "%s%s", i ? "|" : "", names[i]);
}

/* Two numbers that are a range: one row, or its description shows one, as in "0..1500". */
static bool is_range(const vv_property *row)
{
    if (row->columns == 2 && row->lone)
        return true;
    const char *dots = row->columns == 1 && !row->lone ? strstr(row->doc, "..") : NULL;
    return dots && dots > row->doc && isdigit((unsigned char)dots[-1]) && isdigit((unsigned char)dots[2]);
}

void cli_usage_value(vvi_text *out, const vv_property *row)
{
    switch (row->kind) {
    case VV_KIND_BOOL:
        break;
    case VV_KIND_I64:
        vvi_text_add(out, "N");
        break;
    case VV_KIND_F64:
        vvi_text_add(out, quantity_value(row->quantity));
        break;
    case VV_KIND_ENUM:
        add_names(out, row->names);
        break;
    case VV_KIND_PATH:
        vvi_text_add(out, "FILE");
        break;
    case VV_KIND_VEC3:
        vvi_text_add(out, "X,Y,Z");
        break;
    case VV_KIND_COLOR:
        vvi_text_add(out, "COLOUR");
        break;
    case VV_KIND_NUMBERS:
        vvi_text_add(out, is_range(row) ? "LO..HI" : "N,N,...");
        break;
    default:
        vvi_text_add(out, row->unit ? row->unit : "TEXT");
        break;
    }
}

/* Whether it is one label or channel, by number or by name. */
static bool takes_name(const vv_property *row)
{
    return row->kind == VV_KIND_I64 && cli_option_is_named(row);
}

/* What an option takes that its property does not. */
static void add_value(vvi_text *out, const vv_property *row)
{
    if (takes_name(row))
        vvi_text_add(out, "N|NAME");
    else if (row->ranged)
        vvi_text_add(out, "LO..HI");
    else if (row->kind == VV_KIND_NUMBERS && row->columns == 3)
        vvi_text_add(out, "X,Y,Z");
    else
        cli_usage_value(out, row);
}

void cli_usage_option(vvi_text *out, const vv_property *row)
{
    char name[64];
    const bool switched_on = row->kind == VV_KIND_BOOL && row->def != 0;
    cli_option_name(name, row);
    if (row->letter)
        vvi_text_printf(out, "-%c, ", row->letter);
    vvi_text_printf(out, "--%s%s", switched_on ? "no-" : "", name);
    if (cli_option_alone(row)) {
        vvi_text_add(out, "[=");
        add_value(out, row);
        vvi_text_add(out, "]");
    } else if (row->kind != VV_KIND_BOOL) {
        vvi_text_add(out, " ");
        add_value(out, row);
    }
}

static void add_default(vvi_text *out, const vv_property *row)
{
    static const char *const units[] = {"", "", " deg", " s", "", "", ""};
    char number[32];
    if (row->automatic) {
        vvi_text_printf(out, "; default: %s", row->automatic);
        return;
    }
    switch (row->kind) {
    case VV_KIND_I64:
    case VV_KIND_F64:
        if (row->quantity == VV_Q_BYTES)
            vvi_print_bytes(number, (uint64_t)row->def);
        else
            vvi_print_number(number, row->def);
        vvi_text_printf(out, "; default %s%s", number, units[row->quantity]);
        break;
    case VV_KIND_ENUM:
        vvi_text_printf(out, "; default %s", row->names[(int)row->def]);
        break;
    case VV_KIND_BOOL:
        vvi_text_add(out, row->def != 0 ? "; default on" : "");
        break;
    default:
        if (row->def_text)
            vvi_text_printf(out, "; default %s", row->def_text);
        break;
    }
}

void cli_usage_doc(vvi_text *out, const vv_property *row)
{
    const bool far_limit = row->max >= 1e9; /* there only to keep numbers sane: nobody needs to read it */
    char lo[32], hi[32];
    vvi_text_add(out, row->doc);
    if (row->unit && row->kind == VV_KIND_F64)
        vvi_text_printf(out, " (%s)", row->unit);
    if (row->limited && (row->kind == VV_KIND_I64 || row->kind == VV_KIND_F64)) {
        vvi_print_number(lo, row->min);
        vvi_print_number(hi, row->max);
        if (!far_limit)
            vvi_text_printf(out, "; %s to %s", lo, hi);
        else if (row->min > -1e9 && row->quantity != VV_Q_BYTES)
            vvi_text_printf(out, "; at least %s", lo);
    }
    add_default(out, row);
    for (const char *const *pair = row->aliases; pair && pair[0]; pair += 2)
        vvi_text_printf(out, "%s%s for %s", pair == row->aliases ? "; also " : ", ", pair[0], pair[1]);
}

void cli_usage_about(vvi_text *out, const vv_property *row)
{
    if (row->ranged)
        vvi_text_printf(out, "LO is the %s, HI the %s; either may be omitted: 90.. and 90 are 90 and more", row[0].doc,
                        row[1].doc);
    else
        vvi_text_printf(out, "%s%s%s", row->doc, takes_name(row) ? "; N, or what the file calls it" : "",
                        cli_option_adds_row(row) ? "; may be repeated" : "");
}

void cli_usage_option_doc(vvi_text *out, const vv_property *row)
{
    if (row->kind == VV_KIND_BOOL && row->def != 0) {
        vvi_text_printf(out, "turn off: %s", row->doc);
    } else if (row->ranged || takes_name(row) || cli_option_adds_row(row)) {
        cli_usage_about(out, row);
        add_default(out, row);
    } else {
        cli_usage_doc(out, row);
    }
}

void cli_usage_line(vvi_text *out, const cli_verb *verb)
{
    vvi_text_printf(out, "volvis %s [options]", verb->name);
    if (verb->operation)
        cli_operands_line(out, verb->operation);
    else if (verb->words)
        vvi_text_printf(out, verb->min_words ? " %s" : " [%s]", verb->words);
    if (verb->makes_file)
        vvi_text_add(out, " -o FILE");
}

void cli_usage_inputs(vvi_text *out, const cli_verb *verb, const char *heading, cli_usage_entry_fn *fn)
{
    const vv_operation *operation = verb->operation;
    if (!operation || vv_operation_most(operation) == 1)
        return;
    vvi_text_add(out, heading);
    for (const vv_operand *o = operation->inputs; o->name; o++) {
        vvi_text left = {0}, right = {0};
        cli_operand_usage(&left, operation, o);
        vvi_text_printf(&right, "%s%s", o->doc, o->least > 0 ? "" : "; may be left out");
        fn(out, left.bad ? "" : left.s, right.bad ? "" : right.s);
        vvi_text_free(&left);
        vvi_text_free(&right);
    }
}

const char *cli_usage_example(const cli_verb *verb, size_t index)
{
    if (verb->operation)
        return index == 0 ? verb->operation->example : NULL;
    for (size_t i = 0; verb->examples && verb->examples[i]; i++) {
        if (i == index)
            return verb->examples[i];
    }
    return NULL;
}

const vv_class *cli_usage_class(const cli_verb *verb, size_t index)
{
    size_t n = 0;
    for (size_t i = 0; i < CLI_VERB_CLASSES; i++) {
        if (verb->options[i] && n++ == index)
            return verb->options[i];
    }
    return index == n ? &cli_common_class : NULL;
}

const vv_class *cli_usage_shown(const cli_verb *verb, size_t index)
{
    const vv_class *cls = cli_usage_class(verb, index);
    return cls == &cli_common_class && !verb->world ? &cli_common_plain_class : cls;
}

typedef struct path_walk {
    cli_usage_path_fn *fn;
    void *user;
} path_walk;

static bool visit(void *user, const char *path, const vv_property *row, const vv_object *owner)
{
    const path_walk *walk = user;
    walk->fn(walk->user, path, row);
    (void)owner;
    return true;
}

void cli_usage_paths(const vv_registry *registry, cli_usage_path_fn *fn, void *user)
{
    static const char *const samples[][2] = {{"datasets", "ID"}, {"volumes", "ID"},    {"lights", "ID"},
                                             {"views", "ID"},    {"cut_planes", NULL}, {"volumes.ID.cut_planes", NULL}};
    const vv_property_context context = vvi_registry_context(registry);
    path_walk walk = {fn, user};
    vv_object *world = NULL;
    vv_status st = vv_object_new(&world, &vv_world_class, &context);
    for (size_t i = 0; i < sizeof samples / sizeof samples[0] && st == VV_OK; i++)
        st = vv_path_add(&world, samples[i][0], samples[i][1], NULL, &context);
    if (st == VV_OK)
        vv_path_each(world, visit, &walk);
    vv_object_release(world);
}
