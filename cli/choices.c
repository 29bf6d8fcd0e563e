/* The tables that words of the command line are chosen from. */
#include "choices.h"
#include "core/names.h"
#include "edits.h"
#include "manipulate/directions.h"
#include "measure.h"
#include "model/context.h"
#include "value.h"
#include <string.h>
#include <unistd.h>
#include <volvis/model.h>
#include <volvis/render.h>

enum { MOST_NAMES = 128 };

static const char *verb_name(const vv_registry *registry, size_t index)
{
    cli_verb verb;
    for (size_t i = 0; cli_verb_nth(&verb, registry, i); i++) {
        if (!verb.hidden && index-- == 0)
            return verb.name;
    }
    return NULL;
}

static size_t add_each_once(const char **seen, size_t n, const char *const *names)
{
    for (size_t e = 0; names && names[e] && n < MOST_NAMES; e++) {
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
    const char *seen[MOST_NAMES];
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

/* Those of volumes, then those of meshes, then those of pictures; a name of several once. */
static const char *format_name(const vv_registry *registry, size_t index)
{
    const char *seen[MOST_NAMES];
    size_t n = 0;
    for (size_t i = 0; registry->formats[i]; i++)
        n = add_each_once(seen, n, (const char *[]){registry->formats[i]->name, NULL});
    for (size_t i = 0; registry->mesh_formats[i]; i++)
        n = add_each_once(seen, n, (const char *[]){registry->mesh_formats[i]->name, NULL});
    for (size_t i = 0; registry->image_formats[i]; i++)
        n = add_each_once(seen, n, (const char *[]){registry->image_formats[i]->name, NULL});
    n = add_each_once(seen, n, (const char *[]){"svg", NULL});
    return index < n ? seen[index] : NULL;
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
    const vvi_direction *direction = vvi_direction_nth(index);
    return direction ? direction->name : NULL;
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
    if (vv_path_row(&row, &cls, &vv_world_class, path, &context) != VV_OK || row->kind != VV_KIND_ENUM)
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

static const char *lighting_name(const vv_registry *registry, size_t index)
{
    return enum_name(registry, "views.VIEW.render.raycast.lighting", index);
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

static const char *colormap_name(const vv_registry *registry, size_t index)
{
    const vv_preset *preset;
    for (size_t i = 0; (preset = vv_preset_nth(i)); i++)
        if (strcmp(preset->kind, "colormap") == 0 && index-- == 0)
            return preset->name;
    return NULL;
}

static const char *measure_name(const vv_registry *registry, size_t index)
{
    return cli_measure_word_nth(index);
}

const char *cli_choice_nth(const vv_registry *registry, const char *table, size_t index)
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
        {"planes", plane_name},         {"colormaps", colormap_name},
        {"lightings", lighting_name},
    };
    for (size_t i = 0; i < sizeof lists / sizeof lists[0]; i++) {
        if (strcmp(lists[i].table, table) == 0)
            return lists[i].name(registry, index);
    }
    return NULL;
}

const char *cli_choice_of_row(const vv_registry *registry, const vv_property *row, size_t index)
{
    if (row->kind == VV_KIND_ENUM) {
        for (size_t i = 0; row->names[i]; i++) {
            if (i == index)
                return row->names[i];
        }
        return NULL;
    }
    return row->table ? cli_choice_nth(registry, row->table, index) : NULL;
}

static size_t collect(const char *names[MOST_NAMES], const vv_registry *registry, const char *table)
{
    size_t n = 0;
    while (n < MOST_NAMES && (names[n] = cli_choice_nth(registry, table, n)))
        n++;
    return n;
}

const char *cli_choice_word(const vv_registry *registry, const vv_property *row, const char *typed)
{
    static const char *const truths[] = {"false", "true"};
    const char *names[MOST_NAMES], *meant[MOST_NAMES];
    size_t n = 0;
    if (row->kind == VV_KIND_BOOL) {
        const size_t truth = vvi_name_find(typed, truths, 2);
        return truth < 2 ? truths[truth] : typed;
    }
    for (; n < MOST_NAMES && (names[n] = cli_choice_of_row(registry, row, n)); n++)
        meant[n] = names[n];
    for (const char *const *pair = row->aliases; pair && pair[0] && n < MOST_NAMES; pair += 2, n++) {
        names[n] = pair[0];
        meant[n] = pair[1];
    }
    const size_t found = vvi_name_find(typed, names, n);
    return found < n ? meant[found] : typed;
}

/* "presets" and "directions" are looked up where the user's own files and views are. */
static bool is_settled_later(const char *table)
{
    return table && (strcmp(table, "presets") == 0 || strcmp(table, "directions") == 0);
}

static void settle_words(cli_args *args, const cli_verb *verb, const vv_registry *registry)
{
    const vv_property row = {.kind = VV_KIND_STRING, .table = verb->choices};
    const size_t n = verb->files_too && args->n_words ? 1 : args->n_words;
    for (size_t i = 0; i < n && verb->choices; i++)
        if (access(args->words[i], F_OK) != 0)
            args->words[i] = cli_choice_word(registry, &row, args->words[i]);
}

void cli_choice_settle(cli_args *args, const cli_verb *verb, const vv_registry *registry)
{
    for (size_t i = 0; i < args->n_given; i++) {
        cli_given *given = &args->given[i];
        const vv_type_kind kind = given->row->kind;
        const bool word = kind == VV_KIND_ENUM || kind == VV_KIND_STRING || kind == VV_KIND_BOOL;
        if (word && !is_settled_later(given->row->table))
            given->text = cli_choice_word(registry, given->row, given->text);
    }
    settle_words(args, verb, registry);
}

vv_status cli_choice_fail(vv_status status, const vv_registry *registry, const char *table, const char *sentence,
                          const char *typed)
{
    const char *names[MOST_NAMES];
    const size_t n = collect(names, registry, table);
    return vvi_fail_name(status, NULL, NULL, typed, &(vvi_known){names, n, NULL, NULL}, "%s '%s'", sentence, typed);
}
