#include "info_scene.h"
#include "input.h"
#include "picture_notes.h"

static void list_ids(cli_command *command, const char *label, const vv_collection *collection)
{
    vvi_text text = {0};
    vvi_result_open(&command->json, label, '[');
    for (size_t i = 0; i < collection->n; i++) {
        vvi_result_string(&command->json, NULL, collection->entry[i].id);
        vvi_text_printf(&text, "%s%s", i ? ", " : "", collection->entry[i].id);
    }
    vvi_result_close(&command->json, ']');
    cli_command_line(command, label, "%s", text.n ? text.s : "none");
    vvi_text_free(&text);
}

/* With what each measures. */
static void list_measurements(cli_command *command, const vv_collection *stored)
{
    vvi_text text = {0};
    vvi_result_open(&command->json, "measurements", '[');
    for (size_t i = 0; i < stored->n; i++) {
        const vv_measurement *m = (const vv_measurement *)(const void *)stored->entry[i].object;
        const char *what = vv_class_find(m->base.cls, "what")->names[m->what];
        vvi_result_open(&command->json, NULL, '{');
        vvi_result_string(&command->json, "name", stored->entry[i].id);
        vvi_result_string(&command->json, "what", what);
        if (m->file)
            vvi_result_string(&command->json, "file", m->file);
        vvi_result_close(&command->json, '}');
        vvi_text_printf(&text, "%s%s (%s)", i ? ", " : "", stored->entry[i].id, what);
    }
    vvi_result_close(&command->json, ']');
    if (text.n)
        cli_command_line(command, "measurements", "%s", text.s);
    vvi_text_free(&text);
}

vv_status cli_info_scene(cli_command *command, const char *word, const char *format)
{
    vv_world *world = NULL;
    vvi_recipe recipe;
    const vv_status st = cli_input_world(&world, &recipe, command, word);
    if (st != VV_OK)
        return st;
    cli_command_title(command, word);
    vvi_result_string(&command->json, "file", word);
    vvi_result_string(&command->json, "format", format);
    cli_command_line(command, "format", "%s", format);
    if (world->title)
        cli_command_line(command, "title", "%s", world->title);
    vvi_result_string(&command->json, "title", world->title);
    vvi_result_string(&command->json, "unit", world->unit);
    list_ids(command, "datasets", world->datasets);
    list_ids(command, "volumes", world->volumes);
    list_ids(command, "lights", world->lights);
    list_ids(command, "views", world->views);
    list_measurements(command, world->measurements);
    cli_note_moved(command, world, word);
    vv_object_release(&world->base);
    return VV_OK;
}
