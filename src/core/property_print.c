/* Objects to JSON: only what is set, keys in table order, numbers that read back equal. */
#include "core/property_impl.h"
#include "core/units.h"
#include <inttypes.h>
#include <string.h>

static void new_line(vvi_json *json)
{
    vvi_text_add(&json->text, "\n");
    for (int i = 0; i < json->depth * json->indent; i++)
        vvi_text_add_n(&json->text, " ", 1);
}

void vvi_json_open(vvi_json *json, char bracket)
{
    vvi_text_add_n(&json->text, &bracket, 1);
    json->depth++;
    json->fresh = true;
}

void vvi_json_close(vvi_json *json, char bracket)
{
    json->depth--;
    if (!json->fresh && json->indent)
        new_line(json);
    vvi_text_add_n(&json->text, &bracket, 1);
    json->fresh = false;
}

void vvi_json_item(vvi_json *json)
{
    if (!json->fresh)
        vvi_text_add(&json->text, json->indent ? "," : ", ");
    if (json->indent)
        new_line(json);
    json->fresh = false;
}

void vvi_json_key(vvi_json *json, const char *name)
{
    vvi_json_item(json);
    vvi_text_json(&json->text, name);
    vvi_text_add(&json->text, ": ");
}

void vvi_json_string(vvi_json *json, const char *text)
{
    if (text)
        vvi_text_json(&json->text, text);
    else
        vvi_text_add(&json->text, "null");
}

void vvi_json_number(vvi_json *json, double value)
{
    vvi_number_print(&json->text, value, VV_Q_NONE);
}

void vvi_json_tree(vvi_json *json, const json_t *tree)
{
    char text[64];
    if (json_is_object(tree)) {
        vvi_json_open(json, '{');
        for (void *it = json_object_iter((json_t *)tree); it; it = json_object_iter_next((json_t *)tree, it)) {
            vvi_json_key(json, json_object_iter_key(it));
            vvi_json_tree(json, json_object_iter_value(it));
        }
        vvi_json_close(json, '}');
    } else if (json_is_array(tree)) {
        vvi_json_open(json, '[');
        for (size_t i = 0; i < json_array_size(tree); i++) {
            vvi_json_item(json);
            vvi_json_tree(json, json_array_get(tree, i));
        }
        vvi_json_close(json, ']');
    } else if (json_is_string(tree)) {
        vvi_json_string(json, json_string_value(tree));
    } else {
        vvi_text_add(&json->text, vvi_found(text, tree));
    }
}

static void print_cell(vvi_json *json, const vv_numbers *numbers, size_t row, size_t width, size_t column,
                       vv_quantity quantity)
{
    const double value = numbers->v[row * width + column];
    if (numbers->labels && column == 0)
        vvi_label_id_print(&json->text, numbers->labels[row], value);
    else
        vvi_number_print(&json->text, value, quantity);
}

static void print_numbers(vvi_json *json, const vv_numbers *numbers, int columns, vv_quantity quantity)
{
    const size_t width = columns > 1 ? (size_t)columns : 1, n = numbers ? numbers->n / width : 0;
    if (width == 1) {
        vvi_text_add(&json->text, "[");
        for (size_t i = 0; i < n; i++) {
            vvi_text_add(&json->text, i ? ", " : "");
            print_cell(json, numbers, i, 1, 0, quantity);
        }
        vvi_text_add(&json->text, "]");
        return;
    }
    vvi_json_open(json, '[');
    for (size_t i = 0; i < n; i++) {
        vvi_json_item(json);
        for (size_t c = 0; c < width; c++) {
            vvi_text_add(&json->text, c ? ", " : "[");
            print_cell(json, numbers, i, width, c, quantity);
        }
        vvi_text_add(&json->text, "]");
    }
    vvi_json_close(json, ']');
}

static void print_path(vvi_json *json, const char *path)
{
    if (!path) {
        vvi_json_string(json, NULL);
        return;
    }
    char *mapped = json->map_path ? json->map_path(json->map_user, path) : vvi_strdup(path);
    if (mapped)
        vvi_text_json_path(&json->text, mapped);
    else
        json->text.bad = true;
    free(mapped);
}

static void print_object(vvi_json *json, const vv_object *object)
{
    vvi_json_open(json, '{');
    vvi_json_members(json, object);
    vvi_json_close(json, '}');
}

static void print_collection(vvi_json *json, const vv_collection *collection, bool list)
{
    vvi_json_open(json, list ? '[' : '{');
    for (size_t i = 0; i < collection->n; i++) {
        if (list)
            vvi_json_item(json);
        else
            vvi_json_key(json, collection->entry[i].id);
        print_object(json, collection->entry[i].object);
    }
    vvi_json_close(json, list ? ']' : '}');
}

static void print_vec3(vvi_json *json, const vv_vec3 *v, vv_quantity quantity)
{
    const double components[3] = {v->x, v->y, v->z};
    for (int i = 0; i < 3; i++) {
        vvi_text_add(&json->text, i ? ", " : "[");
        vvi_number_print(&json->text, components[i], quantity);
    }
    vvi_text_add(&json->text, "]");
}

void vvi_json_value(vvi_json *json, const vv_object *object, const vv_property *p)
{
    const void *slot = vvi_slot_const(object, p);
    switch (p->kind) {
    case VV_KIND_BOOL:
        vvi_text_add(&json->text, *(const bool *)slot ? "true" : "false");
        break;
    case VV_KIND_I64:
        if (p->quantity == VV_Q_LABEL)
            vvi_label_id_print(&json->text, *(const int64_t *)slot, (double)*(const int64_t *)slot);
        else
            vvi_text_printf(&json->text, "%" PRId64, *(const int64_t *)slot);
        break;
    case VV_KIND_F64:
        vvi_number_print(&json->text, *(const double *)slot, p->quantity);
        break;
    case VV_KIND_ENUM:
        vvi_json_string(json, p->names[*(const int *)slot]);
        break;
    case VV_KIND_STRING:
    case VV_KIND_REF:
        vvi_json_string(json, *(char *const *)slot);
        break;
    case VV_KIND_PATH:
        print_path(json, *(char *const *)slot);
        break;
    case VV_KIND_MEMBERS:
        vvi_members_print(json, object, p);
        break;
    case VV_KIND_VEC3:
        print_vec3(json, slot, p->quantity);
        break;
    case VV_KIND_COLOR:
        vvi_color_print(&json->text, slot);
        break;
    case VV_KIND_NUMBERS:
        print_numbers(json, *(vv_numbers *const *)slot, p->columns, p->quantity);
        break;
    case VV_KIND_OBJECT:
        print_object(json, *(vv_object *const *)slot);
        break;
    default:
        print_collection(json, *(vv_collection *const *)slot, p->kind == VV_KIND_LIST);
        break;
    }
}

/* The entries of variants stand among the owner's own members. */
static void print_variants(vvi_json *json, const vv_collection *variants)
{
    for (size_t i = 0; i < variants->n; i++) {
        if (!vvi_object_has_content(variants->entry[i].object))
            continue;
        vvi_json_key(json, variants->entry[i].id);
        print_object(json, variants->entry[i].object);
    }
}

static void print_extra(vvi_json *json, const vv_object *object)
{
    json_t *extra = object->extra;
    for (void *it = json_object_iter(extra); it; it = json_object_iter_next(extra, it)) {
        const vv_property *known = vv_class_find(object->cls, json_object_iter_key(it));
        if ((known && vvi_property_is_set(object, known)) || !strcmp(json_object_iter_key(it), "$schema"))
            continue;
        vvi_json_key(json, json_object_iter_key(it));
        vvi_json_tree(json, json_object_iter_value(it));
    }
}

void vvi_json_members(vvi_json *json, const vv_object *object)
{
    const json_t *schema = json_object_get(object->extra, "$schema");
    if (schema) {
        vvi_json_key(json, "$schema");
        vvi_json_tree(json, schema);
    }
    for (const vv_property *p = object->cls->properties; p->name; p++) {
        if (p->kind == VV_KIND_VARIANTS) {
            print_variants(json, vvi_collection_of(object, p));
        } else if (vvi_property_is_set(object, p)) {
            vvi_json_key(json, p->name);
            vvi_json_value(json, object, p);
        }
    }
    print_extra(json, object);
}

vv_status vv_object_to_json(char **json_out, const vv_object *object, int indent)
{
    vvi_json json = {.indent = indent};
    print_object(&json, object);
    *json_out = vvi_text_take(&json.text);
    return *json_out ? VV_OK : vv_fail_memory(json.text.n);
}
