#include "picture_notes.h"
#include "core/text.h"
#include "core/units.h"
#include "model/contents.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include <volvis/render.h>

enum { NOTE_MOST = 600 }; /* characters of a value that was worked out */

/* What the last error says is wrong with it. */
static bool has_changed(const vv_dataset *dataset)
{
    const vv_error *error = vv_error_last();
    return dataset->checksum && error->status == VV_E_FORMAT && error->file &&
           strcmp(error->file, dataset->path) == 0 && strstr(error->message, dataset->checksum);
}

vv_status cli_fail_moved(const char *word, const char *was, const char *checksum, const char *remedy)
{
    return vv_fail_at(VV_E_READ, word, NULL, "was made from '%s'%s%s, which is not there any more; %s", was,
                      checksum ? ", " : "", checksum ? checksum : "", remedy);
}

static vv_status fail_moved(const vv_dataset *dataset, const char *id, const char *word, bool settable)
{
    char remedy[200] = "name the file itself, where it is now";
    if (settable)
        snprintf(remedy, sizeof remedy, "give its new place by --set datasets.%s.path=FILE", id);
    return cli_fail_moved(word, dataset->path, dataset->checksum, remedy);
}

void cli_note_moved(cli_command *command, const vv_world *world, const char *word)
{
    for (size_t i = 0; i < world->datasets->n; i++) {
        const vv_dataset *dataset = vvi_dataset_nth(world, i);
        char remedy[200];
        if (!dataset->path || access(dataset->path, F_OK) == 0)
            continue;
        snprintf(
            remedy, sizeof remedy,
            "render, view and measure take its new place as --set datasets.%s.path=FILE; other verbs the file itself",
            world->datasets->entry[i].id);
        cli_fail_moved(word, dataset->path, dataset->checksum, remedy);
        cli_command_note(command, "%s", vv_error_last()->message);
    }
}

/* The file may be another one by now than that of the time. */
static vv_status fail_changed(const vv_dataset *dataset, const char *id, const char *word, bool settable)
{
    if (settable)
        return vv_fail_at(VV_E_FORMAT, word, NULL,
                          "was made from samples of %s, and those of '%s' are others now; accept them by --set "
                          "datasets.%s.checksum=null",
                          dataset->checksum, dataset->path, id);
    return vv_fail_at(
        VV_E_FORMAT, word, NULL,
        "was made from samples of %s, and those of '%s' are others now; name the file itself to use it as "
        "it is",
        dataset->checksum, dataset->path);
}

/* Whether the path is that of a --set, and not where the data were. */
static bool is_set_anew(const cli_command *command, const char *id)
{
    char path[160];
    const char *typed;
    const int n = snprintf(path, sizeof path, "datasets.%s.path=", id);
    for (size_t i = 0; (typed = cli_word_nth(command->common->set, i)); i++)
        if (strncmp(typed, path, (size_t)n) == 0)
            return true;
    return false;
}

vv_status cli_fail_data(const cli_command *command, const vv_world *world, const char *word, vv_status st)
{
    for (size_t i = 0; i < world->datasets->n && st != VV_OK; i++) {
        const vv_dataset *dataset = vvi_dataset_nth(world, i);
        const char *id = world->datasets->entry[i].id;
        if (!dataset->path || strcmp(dataset->path, word) == 0)
            continue;
        if (access(dataset->path, F_OK) != 0 && is_set_anew(command, id))
            return vv_fail_at(VV_E_READ, word, NULL, "--set datasets.%s.path: there is no '%s'", id, dataset->path);
        if (access(dataset->path, F_OK) != 0)
            return fail_moved(dataset, id, word, command->verb.world);
        if (has_changed(dataset))
            return fail_changed(dataset, id, word, command->verb.world);
    }
    return st;
}

/* JSON with as many digits of its numbers as people want to read. */
static void add_rounded(vvi_text *out, const char *json)
{
    for (bool quoted = false; *json;) {
        double number;
        char text[32];
        quoted ^= *json == '"';
        if (!quoted && strchr("-0123456789", *json) && vvi_scan_number(&number, json, &json)) {
            snprintf(text, sizeof text, "%.9g", number);
            vvi_text_add(out, text);
        } else {
            vvi_text_printf(out, "%c", *json++);
        }
    }
}

/* -v: what nobody said and was worked out; `fixed` has all of it. */
static void tell_property(cli_command *command, const vv_world *fixed, const char *path, const char *name)
{
    char whole[256];
    char *json = NULL;
    vvi_text rounded = {0};
    snprintf(whole, sizeof whole, "%s.%s", path, name);
    if (vv_path_get(&json, &fixed->base, whole) == VV_OK && strcmp(json, "null") != 0)
        add_rounded(&rounded, json);
    if (rounded.n && !rounded.bad)
        cli_command_note(command, "%s = %.*s%s", whole, NOTE_MOST, rounded.s, rounded.n > NOTE_MOST ? " ..." : "");
    vvi_text_free(&rounded);
    free(json);
}

/* The map whose two ends the rows of (value, r, g, b) have, either way round; NULL: none. */
static const char *map_of_rows(const vv_numbers *rows)
{
    const vv_preset *preset;
    const double *ends[2] = {rows->v + 1, rows->v + rows->n - 3};
    for (size_t i = 0; (preset = vv_preset_nth(i)); i++) {
        vv_color a, b;
        if (strcmp(preset->kind, "colormap") != 0 || !vv_colormap_sample(&a, preset->name, 0) ||
            !vv_colormap_sample(&b, preset->name, 1))
            continue;
        const vv_color *of[2] = {&a, &b};
        for (int turned = 0; turned < 2; turned++) {
            bool same = true;
            for (int e = 0; e < 2; e++) {
                const vv_color *c = of[e ^ turned];
                same &= ends[e][0] == c->r && ends[e][1] == c->g && ends[e][2] == c->b;
            }
            if (same)
                return preset->name;
        }
    }
    return NULL;
}

/* The colours of a transfer function: a named map over a range is said so, other rows are told one by one. */
static void tell_colors(cli_command *command, const vv_world *fixed, const char *path)
{
    const vv_transfer *transfer = (const vv_transfer *)(const void *)vv_path_object(&fixed->base, path);
    const vv_numbers *rows = transfer && vv_object_is_set(&transfer->base, "color") ? transfer->color : NULL;
    const char *map = rows && rows->n >= 8 ? map_of_rows(rows) : NULL;
    if (map)
        cli_command_note(command, "%s.color: %s, from %.9g to %.9g", path, map, rows->v[0], rows->v[rows->n - 4]);
    else
        tell_property(command, fixed, path, "color");
}

static bool is_word(const vv_world *world, const char *path, const char *word)
{
    char *json = NULL;
    const size_t n = strlen(word);
    const bool is =
        vv_path_get(&json, &world->base, path) == VV_OK && strlen(json) == n + 2 && strncmp(json + 1, word, n) == 0;
    free(json);
    return is;
}

static void tell_method(cli_command *command, const vv_world *fixed, const char *view, const char *method)
{
    static const char *const names[] = {"mode", "orientation"};
    char path[128];
    cli_command_note(command, "views.%s.render.method = \"%s\"", view, method);
    snprintf(path, sizeof path, "views.%s.render.%s", view, method);
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++)
        tell_property(command, fixed, path, names[i]);
    const vv_object *params = vv_path_object(&fixed->base, path);
    snprintf(path, sizeof path, "views.%s.render.%s.mode", view, method);
    const bool surface = !params || !vv_class_find(params->cls, "mode") || is_word(fixed, path, "isosurface");
    snprintf(path, sizeof path, "views.%s.render.%s", view, method);
    if (surface && params && vv_class_find(params->cls, "iso"))
        tell_property(command, fixed, path, "iso");
}

void cli_tell_choices(cli_command *command, const vv_world *fixed, const char *view, const char *method)
{
    static const char *const of_camera[] = {"projection", "eye", "at", "up", "fov", "height", "zoom"};
    static const char *const of_transfer[] = {"preset",   "colormap", "range_lo",
                                              "range_hi", "opacity",  "opacity_length"};
    static const char *const of_slices[] = {"window_lo", "window_hi", "colormap"};
    const vv_renderer *row = vv_registry_renderer(command->registry, method);
    const bool slices = row && row->plane;
    char path[128];
    tell_method(command, fixed, view, method);
    snprintf(path, sizeof path, "views.%s.camera", view);
    for (size_t i = 0; i < sizeof of_camera / sizeof of_camera[0]; i++)
        tell_property(command, fixed, path, of_camera[i]);
    for (size_t v = 0; v < fixed->volumes->n; v++) {
        const char *id = fixed->volumes->entry[v].id;
        snprintf(path, sizeof path, slices ? "volumes.%s.slices" : "volumes.%s.segmentation", id);
        if (!slices)
            tell_property(command, fixed, path, "kind");
        for (size_t i = 0; slices && i < sizeof of_slices / sizeof of_slices[0]; i++)
            tell_property(command, fixed, path, of_slices[i]);
        snprintf(path, sizeof path, "volumes.%s.segmentation.transfer", id);
        for (size_t i = 0; !slices && i < sizeof of_transfer / sizeof of_transfer[0]; i++)
            tell_property(command, fixed, path, of_transfer[i]);
        if (!slices)
            tell_colors(command, fixed, path);
    }
}
