/* Free JSON objects: what only others can judge, kept as compact text and reached into by paths. */
#include "core/json_text.h"
#include "core/property_impl.h"
#include <stdio.h>
#include <string.h>

static const char *text_of(const vv_object *object, const vv_property *p)
{
    return *(char *const *)vvi_slot_const(object, p);
}

/* The text was made here: it can be read, unless there is no memory. */
json_t *vvi_members_tree(const vv_object *object, const vv_property *p)
{
    const char *text = text_of(object, p);
    return text ? vvi_json_decode(text, strlen(text), JSON_ALLOW_NUL, NULL) : json_object();
}

/* Takes the tree's text; a tree without members is kept too: it says that there are none. */
static vv_status keep(vv_object *object, const vv_property *p, const json_t *tree, const vvi_place *place)
{
    vvi_json json = {0};
    vvi_json_tree(&json, tree);
    const size_t n = json.text.n;
    char *text = vvi_text_take(&json.text);
    if (!text)
        return vv_fail_memory(n);
    if (n > vvi_text_most(p)) {
        free(text);
        return vvi_fail_place(place, VV_E_LIMIT, "the text is %zu bytes long: at most %zu are allowed", n,
                              vvi_text_most(p));
    }
    vvi_value_drop(object, p);
    *(char **)vvi_slot(object, p) = text;
    return VV_OK;
}

/* Scenes once had such objects as texts of their own: "{\"sigma\": 2}". */
vv_status vvi_members_read(vv_object *object, const vv_property *p, const json_t *json, const vvi_place *place)
{
    char found[64];
    json_t *inner = NULL;
    vv_status st = VV_OK;
    if (json_is_string(json) && *json_string_value(json) == '{')
        st = vvi_json_parse(&inner, json_string_value(json), strlen(json_string_value(json)), place);
    const json_t *tree = inner ? inner : json;
    if (st == VV_OK && !json_is_object(tree))
        st = vvi_fail_place(place, VV_E_ARGUMENT, "expected an object as in {\"name\": 1}, found %s",
                            vvi_found(found, json));
    if (st == VV_OK)
        st = keep(object, p, tree, place);
    json_decref(inner);
    return st;
}

vv_status vvi_members_read_one(vv_object *object, const vv_property *p, const char *name, const json_t *value,
                               const vvi_place *place)
{
    json_t *tree = vvi_members_tree(object, p);
    vv_status st = VV_OK;
    if (!tree)
        return vv_fail_memory(strlen(name));
    if (!value || json_is_null(value))
        json_object_del(tree, name);
    else if (json_object_set(tree, name, (json_t *)value) != 0)
        st = vv_fail_memory(strlen(name));
    if (st == VV_OK)
        st = keep(object, p, tree, place);
    if (st == VV_OK)
        vvi_set_mark(object, p, true);
    json_decref(tree);
    return st;
}

void vvi_members_print(vvi_json *json, const vv_object *object, const vv_property *p)
{
    json_t *tree = vvi_members_tree(object, p);
    if (tree)
        vvi_json_tree(json, tree);
    else
        json->text.bad = true;
    json_decref(tree);
}

void vvi_members_print_one(vvi_json *json, const vv_object *object, const vv_property *p, const char *name)
{
    json_t *tree = vvi_members_tree(object, p);
    const json_t *value = json_object_get(tree, name);
    if (value)
        vvi_json_tree(json, value);
    else
        vvi_text_add(&json->text, "null");
    json->text.bad |= !tree;
    json_decref(tree);
}

vv_status vvi_members_share_one(vv_object *object, const vv_object *from, const vv_property *p, const char *name)
{
    const vvi_place place = {.name = name};
    json_t *tree = vvi_members_tree(from, p);
    const vv_status st = tree ? vvi_members_read_one(object, p, name, json_object_get(tree, name), &place)
                              : vv_fail_memory(strlen(name));
    json_decref(tree);
    if (st == VV_OK && !vvi_property_is_set(from, p) && !strcmp(text_of(object, p), "{}")) {
        vvi_value_drop(object, p);
        vvi_set_mark(object, p, false);
    }
    return st;
}
