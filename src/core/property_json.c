/* JSON to objects: parsed within the limits, then read strictly. */
#include "core/json_text.h"
#include "core/property_impl.h"
#include "core/units.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

static vv_status fail_syntax(const vvi_json_flaw *flaw, size_t length, const vvi_place *place)
{
    if (flaw->fault == VVI_JSON_MEMORY)
        return vv_fail_memory(length);
    if (place)
        return vvi_fail_place(place, VV_E_ARGUMENT, "not valid JSON: column %d: %s", flaw->column, flaw->text);
    char where[48];
    snprintf(where, sizeof where, "%d:%d", flaw->line, flaw->column);
    return vv_fail_at(VV_E_ARGUMENT, NULL, where, "%s", flaw->text);
}

vv_status vvi_json_parse(json_t **out, const char *text, size_t length, const vvi_place *place)
{
    vvi_json_flaw flaw;
    *out = NULL;
    if (length > VVI_JSON_BYTES)
        return vvi_fail_place(place, VV_E_LIMIT, "the document is %zu bytes long: at most %d are allowed", length,
                              VVI_JSON_BYTES);
    const size_t depth = vvi_json_nesting(text, length);
    if (depth > VVI_JSON_DEPTH)
        return vvi_fail_place(place, VV_E_LIMIT, "nested %zu deep: at most %d levels are allowed", depth,
                              VVI_JSON_DEPTH);
    if (vvi_json_tree_bytes(text, length) > VVI_JSON_TREE_BYTES + 2 * (uint64_t)length)
        return vvi_fail_place(place, VV_E_LIMIT, "the document holds so many values that they would take %llu MiB",
                              (unsigned long long)(vvi_json_tree_bytes(text, length) >> 20));
    *out = vvi_json_decode(text, length, JSON_REJECT_DUPLICATES | JSON_DECODE_ANY, &flaw);
    return *out ? VV_OK : fail_syntax(&flaw, length, place);
}

/* Names of files are any bytes. */
static vv_status bare_path(json_t **out, const char *path)
{
    vvi_text text = {0};
    vvi_text_path(&text, path);
    *out = text.bad ? NULL : json_string(text.s ? text.s : "");
    vvi_text_free(&text);
    return *out ? VV_OK : vv_fail_memory(strlen(path));
}

static vv_status bare_word(json_t **out, const char *text, vv_type_kind kind, const vvi_place *place)
{
    if (kind == VV_KIND_PATH)
        return bare_path(out, text);
    *out = json_string(text);
    if (*out)
        return VV_OK;
    const size_t n = strlen(text);
    for (size_t i = 0; i < n; i++) { /* only text outside of ASCII can be bad UTF-8 */
        if ((unsigned char)text[i] > 127)
            return vvi_fail_place(place, VV_E_ARGUMENT, "the text is not valid UTF-8");
    }
    return vv_fail_memory(n);
}

/* A part of a list as JSON has it: people write numbers in more ways, ".5" and "+3". */
static void add_part(vvi_text *out, const char *part, size_t n)
{
    char typed[64], number[32];
    double value;
    snprintf(typed, sizeof typed, "%.*s", (int)n, part);
    const size_t blank = strspn(typed, " ");
    const bool other = typed[blank] == '.' || typed[blank] == '+' || strstr(typed, "-.") || (n && part[n - 1] == '.');
    if (n < sizeof typed && other && vvi_parse_number(&value, typed) && isfinite(value)) {
        vvi_print_number(number, value);
        vvi_text_add(out, number);
    } else {
        vvi_text_printf(out, "%.*s", (int)n, part);
    }
}

/* "1,2,3" for [1,2,3]; "1..3", a range, for [1,3] */
static vv_status parse_bracketed(json_t **out, const char *text, const vvi_place *place)
{
    vvi_text bracketed = {0};
    const char *dots = strstr(text, "..");
    vvi_text_add(&bracketed, "[");
    for (const char *at = text;;) {
        const bool ranged = dots && dots >= at && !memchr(at, ',', (size_t)(dots - at));
        const size_t n = ranged ? (size_t)(dots - at) : strcspn(at, ",");
        add_part(&bracketed, at, n);
        at += n;
        if (!*at)
            break;
        vvi_text_add(&bracketed, ", ");
        at += ranged ? 2 : 1;
    }
    vvi_text_add(&bracketed, "]");
    vv_status st = bracketed.bad ? vv_fail_memory(bracketed.n) : vvi_json_parse(out, bracketed.s, bracketed.n, place);
    vvi_text_free(&bracketed);
    if (st != VV_OK && st != VV_E_MEMORY && st != VV_E_LIMIT)
        st = vvi_fail_place(place, st, "expected numbers with commas between them, as in 1,2,3, found '%.80s'", text);
    return st;
}

static bool kind_is_array(vv_type_kind kind)
{
    return kind == VV_KIND_VEC3 || kind == VV_KIND_NUMBERS || kind == VV_KIND_COLOR;
}

static bool looks_like_json(const char *text)
{
    return text[0] == '{' || text[0] == '[' || text[0] == '"';
}

/* Text for a text property is taken as it is, unless it is JSON text or null. */
static bool accept(const json_t *json, vv_type_kind kind)
{
    return !vvi_kind_is_text(kind) || kind == VV_KIND_MEMBERS || json_is_string(json) || json_is_null(json);
}

vv_status vvi_json_parse_typed(json_t **out, const char *text, vv_type_kind kind, const vvi_place *place)
{
    const size_t n = strlen(text);
    *out = NULL;
    if (vvi_kind_is_text(kind) && !looks_like_json(text) && strcmp(text, "null") != 0)
        return n > VVI_JSON_STRING ? vvi_fail_place(place, VV_E_LIMIT, "the text is too long: %zu bytes", n)
                                   : bare_word(out, text, kind, place);
    const vv_status st = vvi_json_parse(out, text, n, place);
    if (st == VV_OK && accept(*out, kind))
        return VV_OK;
    json_decref(*out);
    *out = NULL;
    if (st == VV_E_LIMIT || st == VV_E_MEMORY || (looks_like_json(text) && !vvi_kind_is_text(kind)))
        return st;
    double number;
    if (kind == VV_KIND_F64 && vvi_parse_number(&number, text) && isfinite(number)) { /* a whole one above 2^63 */
        *out = json_real(number);
        return *out ? VV_OK : vv_fail_memory(sizeof number);
    }
    /* ".5" and "+3"; digits alone are more than JSON's integers, and a label may be one of those */
    const bool other = strpbrk(text, ".+") && vvi_parse_number(&number, text);
    if (kind_is_array(kind) && (strchr(text, ',') || (kind == VV_KIND_NUMBERS && (strstr(text, "..") || other))))
        return parse_bracketed(out, text, place);
    return bare_word(out, text, kind, place);
}

vv_status vvi_object_check(const vv_object *object, const vvi_place *place)
{
    if (!object->cls->check)
        return VV_OK;
    char *path = vvi_place_text(place);
    if (!path)
        return vv_fail_memory(1);
    const vv_status st = object->cls->check(object, path);
    free(path);
    return st;
}

static vv_status read_list(vv_object *object, const vv_property *p, const json_t *json, const vvi_reading *reading,
                           const vvi_place *place)
{
    char found[64];
    if (!json_is_array(json))
        return vvi_fail_place(place, VV_E_ARGUMENT, "expected an array of objects, found %s", vvi_found(found, json));
    vv_collection *list = NULL;
    vv_status st = vvi_collection_new(&list, json_array_size(json));
    for (size_t i = 0; st == VV_OK && i < list->n; i++) {
        const vvi_place at = {.up = place, .index = i};
        st = vvi_object_from_tree(&list->entry[i].object, p->cls, json_array_get(json, i), reading, &at);
    }
    if (st != VV_OK) {
        vvi_collection_release(list);
        return st;
    }
    vvi_value_drop(object, p);
    *(vv_collection **)vvi_slot(object, p) = list;
    return VV_OK;
}

static vv_status read_entry(vv_entry *entry, const vv_class *cls, const char *id, const json_t *json,
                            const vvi_reading *reading, const vvi_place *place)
{
    const vvi_place at = {.up = place, .name = id};
    if (!vvi_id_valid(id))
        return vvi_fail_place(
            place, VV_E_ARGUMENT,
            "'%.80s' is not a valid name: expected 1 to %d letters, digits, _ and -, not starting with a digit or -",
            id, VVI_ID_MOST);
    if (!(entry->id = vvi_strdup(id)))
        return vv_fail_memory(strlen(id) + 1);
    return vvi_object_from_tree(&entry->object, cls, json, reading, &at);
}

static vv_status read_map(vv_object *object, const vv_property *p, const json_t *json, const vvi_reading *reading,
                          const vvi_place *place)
{
    char found[64];
    if (!json_is_object(json))
        return vvi_fail_place(place, VV_E_ARGUMENT, "expected an object of named objects, found %s",
                              vvi_found(found, json));
    vv_collection *map = NULL;
    vv_status st = vvi_collection_new(&map, json_object_size(json));
    size_t i = 0;
    json_t *members = (json_t *)json;
    for (void *it = json_object_iter(members); st == VV_OK && it; it = json_object_iter_next(members, it), i++)
        st = read_entry(&map->entry[i], p->cls, json_object_iter_key(it), json_object_iter_value(it), reading, place);
    if (st != VV_OK) {
        vvi_collection_release(map);
        return st;
    }
    vvi_value_drop(object, p);
    *(vv_collection **)vvi_slot(object, p) = map;
    return VV_OK;
}

static vv_status read_object(vv_object *object, const vv_property *p, const json_t *json, const vvi_reading *reading,
                             const vvi_place *place)
{
    vv_object *made = NULL;
    const vv_status st = vvi_object_from_tree(&made, p->cls, json, reading, place);
    if (st != VV_OK)
        return st;
    vvi_value_drop(object, p);
    *(vv_object **)vvi_slot(object, p) = made;
    return VV_OK;
}

static vv_status reset(vv_object *object, const vv_property *p, const vvi_reading *reading)
{
    vvi_value_drop(object, p);
    vvi_set_mark(object, p, false);
    return vvi_value_default(object, p, reading->context);
}

/* A word that a newer schema added to an enumeration is kept like a name that it added. */
static bool keeps_word(const vv_property *p, const json_t *json, const vvi_reading *reading)
{
    if (!reading->context->keep_unknown || p->kind != VV_KIND_ENUM || !json_is_string(json))
        return false;
    for (size_t i = 0; p->names[i]; i++) {
        if (!strcmp(p->names[i], json_string_value(json)))
            return false;
    }
    for (const char *const *pair = p->aliases; pair && pair[0]; pair += 2)
        if (!strcmp(pair[0], json_string_value(json)))
            return false;
    return true;
}

vv_status vvi_property_read(vv_object *object, const vv_property *p, const json_t *json, const vvi_reading *reading,
                            const vvi_place *place)
{
    vv_status st = vvi_extra_remove(object, p->name);
    if (st != VV_OK)
        return st;
    if (json_is_null(json))
        return reset(object, p, reading);
    if (keeps_word(p, json, reading))
        return vvi_extra_put(object, p->name, json);
    switch (p->kind) {
    case VV_KIND_OBJECT:
        return read_object(object, p, json, reading, place);
    case VV_KIND_LIST:
        return read_list(object, p, json, reading, place);
    case VV_KIND_MAP:
        return read_map(object, p, json, reading, place);
    default:
        st = vvi_value_read(object, p, json, reading, place);
        if (st == VV_OK)
            vvi_set_mark(object, p, true);
        return st;
    }
}

/* The variants entry of that name in an object nobody shares yet. */
static vv_entry *find_variant(vv_object *object, const char *name)
{
    for (const vv_property *p = object->cls->properties; p->name; p++) {
        if (p->kind != VV_KIND_VARIANTS)
            continue;
        vv_collection *variants = vvi_collection_of(object, p);
        const size_t i = vvi_collection_index(variants, name);
        if (i < variants->n)
            return &variants->entry[i];
    }
    return NULL;
}

static vv_status read_variant(vv_entry *entry, const json_t *json, const vvi_reading *reading, const vvi_place *place)
{
    vv_object *made = NULL;
    if (json_is_null(json))
        return VV_OK;
    const vv_status st = vvi_object_from_tree(&made, entry->object->cls, json, reading, place);
    if (st != VV_OK)
        return st;
    vv_object_release(entry->object);
    entry->object = made;
    return VV_OK;
}

static vv_status read_member(vv_object *object, const char *name, const json_t *json, const vvi_reading *reading,
                             const vvi_place *place)
{
    const vvi_place at = {.up = place, .name = name};
    const vv_property *p = vv_class_find(object->cls, name);
    if (!place && !strcmp(name, "$schema")) /* tells editors which schema the document follows; not ours to judge */
        return vvi_extra_put(object, name, json);
    if (p)
        return vvi_property_read(object, p, json, reading, &at);
    vv_entry *variant = find_variant(object, name);
    if (variant)
        return read_variant(variant, json, reading, &at);
    if (reading->context->keep_unknown)
        return vvi_extra_put(object, name, json);
    return vvi_fail_unknown_property(place, object, name);
}

vv_status vvi_object_from_tree(vv_object **out, const vv_class *cls, const json_t *tree, const vvi_reading *reading,
                               const vvi_place *place)
{
    char found[64];
    vv_object *object = NULL;
    *out = NULL;
    if (!json_is_object(tree))
        return vvi_fail_place(place, VV_E_ARGUMENT, "expected an object (%s), found %s", cls->name,
                              vvi_found(found, tree));
    vv_status st = vv_object_new(&object, cls, reading->context);
    json_t *members = (json_t *)tree;
    for (void *it = json_object_iter(members); st == VV_OK && it; it = json_object_iter_next(members, it))
        st = read_member(object, json_object_iter_key(it), json_object_iter_value(it), reading, place);
    if (st == VV_OK)
        st = vvi_object_check(object, place);
    if (st != VV_OK) {
        vv_object_release(object);
        return st;
    }
    *out = object;
    return VV_OK;
}

vv_status vv_object_from_json(vv_object **out, const vv_class *cls, const char *json, size_t length,
                              const vv_property_context *context)
{
    json_t *tree = NULL;
    const vvi_reading reading = {.context = vvi_context_or_empty(context)};
    *out = NULL;
    vv_status st = vvi_json_parse(&tree, json, length, NULL);
    if (st == VV_OK)
        st = vvi_object_from_tree(out, cls, tree, &reading, NULL);
    json_decref(tree);
    return st;
}
