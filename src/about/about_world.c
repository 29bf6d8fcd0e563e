/* What a World has. */
#include "about/about.h"
#include "core/json_text.h"
#include "core/memory.h"
#include "core/property_impl.h"

static void list_ids(vv_answer *a, const char *label, const vv_collection *collection)
{
    vvi_text text = {0};
    vvi_tell_open(a, label, "[");
    for (size_t i = 0; i < collection->n; i++) {
        vvi_tell_text(a, NULL, collection->entry[i].id);
        vvi_text_printf(&text, "%s%s", i ? ", " : "", collection->entry[i].id);
    }
    vvi_tell_close(a, "]");
    a->bad |= text.bad;
    vvi_tell_line(a, label, "%s", text.n ? text.s : "none");
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
    json_t *value, *inputs = vvi_json_of_own(text_or(d->inputs, "{}"));
    out->bad |= !inputs;
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
    json_t *value, *parameters = vvi_json_of_own(text_or(d->parameters, "{}"));
    out->bad |= !parameters;
    json_object_foreach(parameters, name, value)
    {
        vvi_json json = {0};
        vvi_text_printf(out, "%s%s ", out->n ? ", " : ": ", name);
        vvi_json_tree(&json, value);
        vvi_text_add(out, json_is_string(value) ? json_string_value(value) : text_or(json.text.s, ""));
        out->bad |= json.text.bad;
        vvi_text_free(&json.text);
    }
    json_decref(parameters);
}

/* Data that are made of others: each with its recipe. */
static void list_made(vv_answer *a, const vv_collection *datasets)
{
    vvi_tell_open(a, "made", "[");
    for (size_t i = 0; i < datasets->n; i++) {
        const vv_dataset *d = (const vv_dataset *)(const void *)datasets->entry[i].object;
        vvi_text inputs = {0}, parameters = {0};
        if (!vv_dataset_is_made(d))
            continue;
        print_inputs(&inputs, d);
        print_parameters(&parameters, d);
        a->bad |= inputs.bad || parameters.bad;
        vvi_tell_line(a, "made", "%s: %s of %s%s%s", datasets->entry[i].id, d->operation, text_or(inputs.s, ""),
                      text_or(parameters.s, ""), d->on ? "" : " (off)");
        vvi_tell_open(a, NULL, "{");
        vvi_tell_text(a, "name", datasets->entry[i].id);
        vvi_tell_text(a, "operation", d->operation);
        if (d->source)
            vvi_tell_text(a, "source", d->source);
        vvi_tell_json(a, "inputs", text_or(d->inputs, "{}"));
        vvi_tell_json(a, "parameters", text_or(d->parameters, "{}"));
        if (!d->on)
            vvi_tell_bool(a, "on", false);
        vvi_tell_close(a, "}");
        vvi_text_free(&inputs);
        vvi_text_free(&parameters);
    }
    vvi_tell_close(a, "]");
}

/* With what each measures. */
static void list_measurements(vv_answer *a, const vv_collection *stored)
{
    vvi_text text = {0};
    vvi_tell_open(a, "measurements", "[");
    for (size_t i = 0; i < stored->n; i++) {
        const vv_measurement *m = (const vv_measurement *)(const void *)stored->entry[i].object;
        const char *what = vv_class_find(m->base.cls, "what")->names[m->what];
        vvi_tell_open(a, NULL, "{");
        vvi_tell_text(a, "name", stored->entry[i].id);
        vvi_tell_text(a, "what", what);
        if (m->file)
            vvi_tell_text(a, "file", m->file);
        vvi_tell_close(a, "}");
        vvi_text_printf(&text, "%s%s (%s)", i ? ", " : "", stored->entry[i].id, what);
    }
    vvi_tell_close(a, "]");
    a->bad |= text.bad;
    if (text.n)
        vvi_tell_line(a, "measurements", "%s", text.s);
    vvi_text_free(&text);
}

vv_status vv_about_world(vv_answer **out, const vv_world *world)
{
    vv_answer *a = *out = vvi_calloc(1, sizeof *a);
    if (!a)
        return vv_fail_memory(sizeof *a);
    if (world->title)
        vvi_tell_line(a, "title", "%s", world->title);
    vvi_tell_text(a, "title", world->title);
    vvi_tell_text(a, "unit", world->unit);
    list_ids(a, "datasets", world->datasets);
    list_made(a, world->datasets);
    list_ids(a, "volumes", world->volumes);
    list_ids(a, "lights", world->lights);
    list_ids(a, "views", world->views);
    list_measurements(a, world->measurements);
    return vvi_about_end(a, VV_OK);
}
