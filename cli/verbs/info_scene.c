#include "info_scene.h"
#include "core/property_impl.h"
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

static const char *text_or(const char *text, const char *other)
{
    return text ? text : other;
}

/* "volume" is not said where it is the only one. */
static void print_inputs(vvi_text *out, const vv_dataset *d)
{
    const char *name;
    json_t *value, *inputs = json_loads(text_or(d->inputs, "{}"), 0, NULL);
    const size_t n = json_object_size(inputs);
    if (n == 0)
        vvi_text_add(out, text_or(d->source, "nothing"));
    json_object_foreach(inputs, name, value)
    {
        vvi_text_printf(out, "%s%s%s", out->n ? ", " : "", n > 1 ? name : "", n > 1 ? "=" : "");
        vvi_text_add(out, text_or(json_string_value(value), "?"));
    }
    json_decref(inputs);
}

static void print_parameters(vvi_text *out, const vv_dataset *d)
{
    const char *name;
    json_t *value, *parameters = json_loads(text_or(d->parameters, "{}"), 0, NULL);
    json_object_foreach(parameters, name, value)
    {
        vvi_json json = {0};
        vvi_text_printf(out, "%s%s ", out->n ? ", " : ": ", name);
        vvi_json_tree(&json, value);
        vvi_text_add(out, json_is_string(value) ? json_string_value(value) : text_or(json.text.s, ""));
        vvi_text_free(&json.text);
    }
    json_decref(parameters);
}

/* Data that are made of others: each with its recipe. */
static void list_made(cli_command *command, const vv_collection *datasets)
{
    vvi_result_open(&command->json, "made", '[');
    for (size_t i = 0; i < datasets->n; i++) {
        const vv_dataset *d = (const vv_dataset *)(const void *)datasets->entry[i].object;
        vvi_text inputs = {0}, parameters = {0};
        if (!vv_dataset_is_made(d))
            continue;
        print_inputs(&inputs, d);
        print_parameters(&parameters, d);
        cli_command_line(command, "made", "%s: %s of %s%s%s", datasets->entry[i].id, d->operation,
                         text_or(inputs.s, ""), text_or(parameters.s, ""), d->on ? "" : " (off)");
        vvi_result_open(&command->json, NULL, '{');
        vvi_result_string(&command->json, "name", datasets->entry[i].id);
        vvi_result_string(&command->json, "operation", d->operation);
        if (d->source)
            vvi_result_string(&command->json, "source", d->source);
        vvi_result_raw(&command->json, "inputs", text_or(d->inputs, "{}"));
        vvi_result_raw(&command->json, "parameters", text_or(d->parameters, "{}"));
        if (!d->on)
            vvi_result_bool(&command->json, "on", false);
        vvi_result_close(&command->json, '}');
        vvi_text_free(&inputs);
        vvi_text_free(&parameters);
    }
    vvi_result_close(&command->json, ']');
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
    list_made(command, world->datasets);
    list_ids(command, "volumes", world->volumes);
    list_ids(command, "lights", world->lights);
    list_ids(command, "views", world->views);
    list_measurements(command, world->measurements);
    cli_note_moved(command, world, word);
    vv_object_release(&world->base);
    return VV_OK;
}
