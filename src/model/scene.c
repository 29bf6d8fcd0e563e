/* Scene files: a World as JSON. */
#include "core/job.h"
#include "core/property_impl.h"
#include "model/changes.h"
#include "model/context.h"
#include "model/file_path.h"
#include <stdio.h>
#include <string.h>

/* A failure of the property engine, told as one of a file. */
static vv_status fail_in_file(vv_status st, const char *name)
{
    vvi_error_copy error;
    vvi_error_take(&error);
    const char *text = error.message ? error.message : "";
    const size_t n = error.where ? strlen(error.where) : 0;
    if (n && !strncmp(text, error.where, n) && text[n] == ':')
        text += n + 2;
    st = vv_fail_at(st == VV_E_ARGUMENT ? VV_E_FORMAT : st, name, error.where, "%s", text);
    vvi_error_copy_free(&error);
    return st;
}

static char *from_folder(void *user, const char *path)
{
    return vvi_path_from_folder(user, path);
}

static char *to_folder(void *user, const char *path)
{
    return vvi_path_to_folder(user, path);
}

bool vvi_schema_is_newer(char *out, size_t n, int64_t schema)
{
    snprintf(out, n, "schema version %lld is newer than %d: unknown properties are kept but have no effect",
             (long long)schema, VV_SCHEMA_VERSION);
    return schema > VV_SCHEMA_VERSION;
}

/* The context that a document asks for: its unit, and whether it is of a newer schema than ours. */
static vv_property_context context_of(const json_t *tree, const char *name, vv_job *job)
{
    vv_property_context context = vvi_registry_context(vvi_job_registry(job));
    const json_int_t schema = json_integer_value(json_object_get(tree, "schema"));
    context.length_unit = json_string_value(json_object_get(tree, "unit"));
    char newer[128];
    context.keep_unknown = vvi_schema_is_newer(newer, sizeof newer, schema);
    if (context.keep_unknown)
        vvi_log(job, VV_LOG_WARNING, "model", "%s: %s", name, newer);
    return context;
}

static vv_status world_from_tree(vv_world **out, const json_t *tree, const char *name, const char *folder, vv_job *job)
{
    vv_object *world = NULL;
    const vv_property_context context = context_of(tree, name, job);
    const vvi_reading reading = {.context = &context, .map_path = from_folder, .map_user = (void *)folder};
    const vv_status st = vvi_object_from_tree(&world, &vv_world_class, tree, &reading, NULL);
    if (st != VV_OK)
        return st;
    /* every scene file says its version: it is the file's, not something that was set in the World */
    if (((vv_world *)world)->schema == VV_SCHEMA_VERSION)
        vvi_set_mark(world, vv_class_find(&vv_world_class, "schema"), false);
    *out = (vv_world *)world;
    return VV_OK;
}

vv_status vv_scene_parse(vv_world **out, const char *json, size_t length, const char *name, const char *folder,
                         vv_job *job)
{
    json_t *tree = NULL;
    *out = NULL;
    vv_status st = vvi_json_parse(&tree, json, length, NULL);
    if (st == VV_OK)
        st = world_from_tree(out, tree, name ? name : "scene", folder, job);
    json_decref(tree);
    return st == VV_OK ? st : fail_in_file(st, name ? name : "scene");
}

vv_status vvi_world_with_schema(vv_object **out, const vv_world *world)
{
    const vv_status st = vvi_object_copy(out, &world->base);
    if (st == VV_OK)
        vvi_set_mark(*out, vv_class_find(&vv_world_class, "schema"), true);
    return st;
}

vv_status vv_scene_print(char **json_out, const vv_world *world, const char *folder)
{
    vvi_json json = {.indent = 2, .map_path = folder ? to_folder : NULL, .map_user = (void *)folder};
    vv_object *versioned = NULL;
    *json_out = NULL;
    const vv_status st = vvi_world_with_schema(&versioned, world);
    if (st != VV_OK)
        return st;
    vvi_json_open(&json, '{');
    vvi_json_members(&json, versioned);
    vvi_json_close(&json, '}');
    vvi_text_add(&json.text, "\n");
    vv_object_release(versioned);
    const size_t n = json.text.n;
    *json_out = vvi_text_take(&json.text);
    return *json_out ? VV_OK : vv_fail_memory(n);
}

vv_status vv_scene_schema(char **json_out, const struct vv_registry *registry)
{
    const vv_property_context context = vvi_registry_context(registry);
    return vv_class_schema(json_out, &vv_world_class, &context);
}
