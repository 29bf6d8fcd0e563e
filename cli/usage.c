#include "usage.h"
#include "args.h"
#include "core/units.h"
#include "edits.h"
#include "measure.h"
#include "model/context.h"
#include "options.h"
#include "value.h"
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
        vvi_text_add(out, "N,N,...");
        break;
    default:
        vvi_text_add(out, row->unit ? row->unit : "TEXT");
        break;
    }
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
        cli_usage_value(out, row);
        vvi_text_add(out, "]");
    } else if (row->kind != VV_KIND_BOOL) {
        vvi_text_add(out, " ");
        cli_usage_value(out, row);
    }
}

static void add_default(vvi_text *out, const vv_property *row)
{
    static const char *const units[] = {"", "", " deg", " s", " bytes", "", ""};
    char number[32];
    if (row->automatic) {
        vvi_text_printf(out, "; default: %s", row->automatic);
        return;
    }
    switch (row->kind) {
    case VV_KIND_I64:
    case VV_KIND_F64:
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
}

void cli_usage_option_doc(vvi_text *out, const vv_property *row)
{
    if (row->kind == VV_KIND_BOOL && row->def != 0)
        vvi_text_printf(out, "without what is the default: %s", row->doc);
    else
        cli_usage_doc(out, row);
}

void cli_usage_line(vvi_text *out, const cli_verb *verb)
{
    vvi_text_printf(out, "volvis %s [options]", verb->name);
    if (verb->words)
        vvi_text_printf(out, verb->min_words ? " %s" : " [%s]", verb->words);
    if (verb->makes_file)
        vvi_text_add(out, " -o FILE");
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

static const char *verb_name(const vv_registry *registry, size_t index)
{
    cli_verb verb;
    for (size_t i = 0; cli_verb_nth(&verb, registry, i); i++) {
        if (!verb.hidden && index-- == 0)
            return verb.name;
    }
    return NULL;
}

enum { ENCODINGS_MOST = 32 };

static size_t add_each_once(const char **seen, size_t n, const char *const *names)
{
    for (size_t e = 0; names && names[e] && n < ENCODINGS_MOST; e++) {
        size_t same = 0;
        while (same < n && strcmp(seen[same], names[e]) != 0)
            same++;
        if (same == n)
            seen[n++] = names[e];
    }
    return n;
}

/* Encodings of all formats, each once. */
static const char *encoding_name(const vv_registry *registry, size_t index)
{
    const char *seen[ENCODINGS_MOST];
    size_t n = 0;
    for (size_t f = 0; registry->formats[f]; f++)
        n = add_each_once(seen, n, registry->formats[f]->encodings);
    for (size_t f = 0; registry->mesh_formats[f]; f++)
        n = add_each_once(seen, n, registry->mesh_formats[f]->encodings);
    return index < n ? seen[index] : NULL;
}

#define NAME_OF_ROW(table)                                                                                             \
    for (size_t i = 0; registry->table[i]; i++) {                                                                      \
        if (i == index)                                                                                                \
            return registry->table[i]->name;                                                                           \
    }                                                                                                                  \
    return NULL

static const char *mesh_format_name(const vv_registry *registry, size_t index)
{
    NAME_OF_ROW(mesh_formats);
}

/* Those of volumes, then those of meshes. */
static const char *format_name(const vv_registry *registry, size_t index)
{
    for (size_t i = 0; registry->formats[i]; i++, index--) {
        if (index == 0)
            return registry->formats[i]->name;
    }
    return mesh_format_name(registry, index);
}

static const char *renderer_name(const vv_registry *registry, size_t index)
{
    NAME_OF_ROW(renderers);
}

static const char *type_name(const vv_registry *registry, size_t index)
{
    (void)registry;
    return index < VV_TYPE_COUNT ? vv_type_name((vv_type)index) : NULL;
}

static const char *direction_name(const vv_registry *registry, size_t index)
{
    (void)registry;
    return cli_direction_name(index);
}

static const char *layer_name(const vv_registry *registry, size_t index)
{
    (void)registry;
    return vv_layer_name(index);
}

static const char *shell_name(const vv_registry *registry, size_t index)
{
    static const char *const names[] = {"bash", "zsh", "fish"};
    (void)registry;
    return index < sizeof names / sizeof names[0] ? names[index] : NULL;
}

/* Names of the enum that a property path leads to. */
static const char *enum_name(const vv_registry *registry, const char *path, size_t index)
{
    const vv_property_context context = vvi_registry_context(registry);
    const vv_property *row = NULL;
    const vv_class *cls;
    if (cli_path_row(&row, &cls, &vv_world_class, path, &context) != VV_OK || row->kind != VV_KIND_ENUM)
        return NULL;
    for (size_t i = 0; row->names[i]; i++) {
        if (i == index)
            return row->names[i];
    }
    return NULL;
}

static const char *mode_name(const vv_registry *registry, size_t index)
{
    return enum_name(registry, "views.VIEW.render.raycast.mode", index);
}

static const char *plane_name(const vv_registry *registry, size_t index)
{
    return enum_name(registry, "views.VIEW.render.slice.orientation", index);
}

static const char *decoration_name(const vv_registry *registry, size_t index)
{
    return cli_decoration_word(index);
}

static const char *quality_name(const vv_registry *registry, size_t index)
{
    return enum_name(registry, "views.VIEW.render.quality", index);
}

static const char *operation_name(const vv_registry *registry, size_t index)
{
    NAME_OF_ROW(operations);
}

/* A colour map of a transfer function's name, which the name alone does not choose. */
static bool is_named_before(size_t index)
{
    for (size_t i = 0; i < index; i++)
        if (strcmp(vv_preset_nth(i)->name, vv_preset_nth(index)->name) == 0)
            return true;
    return false;
}

static const char *preset_name(const vv_registry *registry, size_t index)
{
    const vv_preset *preset;
    for (size_t i = 0; (preset = vv_preset_nth(i)); i++)
        if (!is_named_before(i) && index-- == 0)
            return preset->name;
    return NULL;
}

static const char *measure_name(const vv_registry *registry, size_t index)
{
    return cli_measure_kind_nth(index);
}

const char *cli_usage_choice(const vv_registry *registry, const char *table, size_t index)
{
    static const struct {
        const char *table;
        const char *(*name)(const vv_registry *registry, size_t index);
    } lists[] = {
        {"verbs", verb_name},           {"formats", format_name},
        {"encodings", encoding_name},   {"renderers", renderer_name},
        {"presets", preset_name},       {"operations", operation_name},
        {"measures", measure_name},     {"types", type_name},
        {"directions", direction_name}, {"shells", shell_name},
        {"modes", mode_name},           {"qualities", quality_name},
        {"layers", layer_name},         {"decorations", decoration_name},
        {"planes", plane_name},
    };
    for (size_t i = 0; i < sizeof lists / sizeof lists[0]; i++) {
        if (strcmp(lists[i].table, table) == 0)
            return lists[i].name(registry, index);
    }
    return NULL;
}

const char *cli_usage_value_choice(const vv_registry *registry, const vv_property *row, size_t index)
{
    if (row->kind == VV_KIND_ENUM) {
        for (size_t i = 0; row->names[i]; i++) {
            if (i == index)
                return row->names[i];
        }
        return NULL;
    }
    return row->table ? cli_usage_choice(registry, row->table, index) : NULL;
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
