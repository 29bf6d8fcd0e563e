#include "choices.h"
#include "command.h"
#include "help.h"
#include "verbs.h"
#include <string.h>

static void add_strings(vvi_text *out, const char *const *strings)
{
    for (size_t i = 0; strings && strings[i]; i++)
        vvi_text_printf(out, "%s%s", i ? " " : "", strings[i]);
}

typedef struct row {
    const char *name, *doc;
    bool reads, writes;
    const char *const *suffixes, *const *encodings;
} row;

static void describe(cli_command *command, const row *r)
{
    vvi_text right = {0};
    vvi_result *json = &command->json;
    vvi_text_printf(&right, "%s%s%s; ", r->reads ? "reads" : "", r->reads && r->writes ? ", " : "",
                    r->writes ? "writes" : "");
    add_strings(&right, r->suffixes);
    vvi_text_printf(&right, "\n%s", r->doc);
    if (r->encodings) {
        vvi_text_add(&right, "\nencodings: ");
        add_strings(&right, r->encodings);
    }
    cli_help_entry(&command->text, r->name, right.bad ? "" : right.s);
    vvi_text_free(&right);
    vvi_result_open(json, NULL, '{');
    vvi_result_string(json, "name", r->name);
    vvi_result_string(json, "doc", r->doc);
    vvi_result_bool(json, "reads", r->reads);
    vvi_result_bool(json, "writes", r->writes);
    vvi_result_strings(json, "suffixes", r->suffixes);
    vvi_result_strings(json, "encodings", r->encodings);
    vvi_result_close(json, '}');
}

/* What slices, meshes and plots are drawn into as shapes: pictures have no row for it. */
static const char *const svg_suffixes[] = {".svg", NULL};
static const row svg = {.name = "svg",
                        .doc = "SVG figures and plots: letters and triangles as shapes, other pictures in it as PNG",
                        .writes = true,
                        .suffixes = svg_suffixes};

/* Row by number in a list of all; false past the end. */
static bool volume_row(row *out, const vv_registry *registry, size_t index)
{
    const vv_format *f = registry->formats[index];
    if (f)
        *out = (row){f->name, f->doc, f->read_header != NULL, f->write != NULL, f->suffixes, f->encodings};
    return f;
}

static bool mesh_row(row *out, const vv_registry *registry, size_t index)
{
    const vv_mesh_format *f = registry->mesh_formats[index];
    if (f)
        *out = (row){f->name, f->doc, f->read != NULL, f->write != NULL, f->suffixes, f->encodings};
    return f;
}

static bool image_row(row *out, const vv_registry *registry, size_t index)
{
    size_t n = 0;
    while (n < index && registry->image_formats[n])
        n++;
    const vv_image_format *f = registry->image_formats[n];
    *out = f ? (row){f->name, f->doc, f->read != NULL, f->write != NULL, f->suffixes, NULL} : svg;
    return f || n == index;
}

static const struct {
    const char *key, *title;
    bool (*row)(row *out, const vv_registry *registry, size_t index);
} lists[] = {{"formats", NULL, volume_row}, {"meshes", "Meshes", mesh_row}, {"images", "Images", image_row}};
enum { N_LISTS = sizeof lists / sizeof *lists };

static bool is_named(const row *r, const char *name)
{
    for (const char *const *s = r->suffixes; s && *s; s++)
        if (name[0] == '.' && strcmp(*s, name) == 0)
            return true;
    return strcmp(r->name, name) == 0;
}

static vv_status run(cli_command *command)
{
    const char *only = cli_command_word(command, 0);
    size_t n = 0;
    row r;
    for (size_t l = 0; l < N_LISTS; l++) {
        size_t n_here = 0;
        vvi_result_open(&command->json, lists[l].key, '[');
        for (size_t i = 0; lists[l].row(&r, command->registry, i); i++) {
            if (only && !is_named(&r, only))
                continue;
            if (n_here++ == 0 && lists[l].title && (!only || n > 0))
                vvi_text_printf(&command->text, "\n%s\n", lists[l].title);
            describe(command, &r);
        }
        vvi_result_close(&command->json, ']');
        n += n_here;
    }
    return n ? VV_OK : cli_choice_fail(VV_E_NOT_FOUND, command->registry, "formats", "no format", only);
}

static const char *const examples[] = {"volvis formats", "volvis formats nrrd", "volvis formats .mha", NULL};

const cli_verb cli_verb_formats = {
    .name = "formats",
    .doc = "the file formats that are read and written",
    .words = "NAME",
    .choices = "formats",
    .max_words = 1,
    .examples = examples,
    .run = run,
};
