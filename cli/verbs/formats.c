#include "command.h"
#include "help.h"
#include "io/mesh_file.h"
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

static void list_images(cli_command *command)
{
    vvi_text_add(&command->text, "\nImages\n");
    vvi_result_open(&command->json, "images", '[');
    for (size_t i = 0; command->registry->image_formats[i]; i++) {
        const vv_image_format *f = command->registry->image_formats[i];
        describe(command, &(row){f->name, f->doc, f->read != NULL, f->write != NULL, f->suffixes, NULL});
    }
    vvi_result_close(&command->json, ']');
}

static void list_meshes(cli_command *command, const char *only)
{
    if (!only)
        vvi_text_add(&command->text, "\nMeshes\n");
    vvi_result_open(&command->json, "meshes", '[');
    for (size_t i = 0; command->registry->mesh_formats[i]; i++) {
        const vv_mesh_format *f = command->registry->mesh_formats[i];
        if (!only || strcmp(only, f->name) == 0)
            describe(command, &(row){f->name, f->doc, f->read != NULL, f->write != NULL, f->suffixes, f->encodings});
    }
    vvi_result_close(&command->json, ']');
}

static bool is_mesh(const cli_command *command, const char *name)
{
    const vv_mesh_format *format = vvi_mesh_format_find(name, command->registry);
    return format && strcmp(format->name, name) == 0;
}

static vv_status run(cli_command *command)
{
    const char *only = cli_command_word(command, 0);
    if (only && !is_mesh(command, only) && !vv_registry_format(command->registry, only))
        return vv_error_last()->status;
    vvi_result_open(&command->json, "formats", '[');
    for (size_t i = 0; command->registry->formats[i]; i++) {
        const vv_format *f = command->registry->formats[i];
        if (!only || strcmp(only, f->name) == 0)
            describe(command,
                     &(row){f->name, f->doc, f->read_header != NULL, f->write != NULL, f->suffixes, f->encodings});
    }
    vvi_result_close(&command->json, ']');
    list_meshes(command, only);
    if (!only)
        list_images(command);
    return VV_OK;
}

static const char *const examples[] = {"volvis formats", "volvis formats nrrd", NULL};

const cli_verb cli_verb_formats = {
    .name = "formats",
    .doc = "the file formats that are read and written",
    .words = "NAME",
    .choices = "formats",
    .max_words = 1,
    .examples = examples,
    .run = run,
};
