/* One value in its slot: default, read, share, compare, drop, for each kind. */
#include "core/property_impl.h"
#include <string.h>

void vvi_value_drop(vv_object *object, const vv_property *p)
{
    void *slot = vvi_slot(object, p);
    if (vvi_kind_is_text(p->kind)) {
        free(*(char **)slot);
        *(char **)slot = NULL;
    } else if (p->kind == VV_KIND_NUMBERS) {
        vvi_numbers_release(*(vv_numbers **)slot);
        *(vv_numbers **)slot = NULL;
    } else if (p->kind == VV_KIND_OBJECT) {
        vv_object_release(*(vv_object **)slot);
        *(vv_object **)slot = NULL;
    } else if (vvi_kind_is_collection(p->kind)) {
        vvi_collection_release(*(vv_collection **)slot);
        *(vv_collection **)slot = NULL;
    }
}

static size_t plain_bytes(vv_type_kind kind)
{
    switch (kind) {
    case VV_KIND_BOOL:
        return sizeof(bool);
    case VV_KIND_I64:
        return sizeof(int64_t);
    case VV_KIND_F64:
        return sizeof(double);
    case VV_KIND_ENUM:
        return sizeof(int);
    case VV_KIND_VEC3:
        return sizeof(vv_vec3);
    case VV_KIND_COLOR:
        return sizeof(vv_color);
    default:
        return 0;
    }
}

vv_status vvi_value_share(vv_object *object, const vv_object *from, const vv_property *p)
{
    void *slot = vvi_slot(object, p);
    const void *source = vvi_slot_const(from, p);
    if (vvi_kind_is_text(p->kind)) {
        const char *text = *(char *const *)source;
        if (text && !(*(char **)slot = vvi_strdup(text)))
            return vv_fail_memory(strlen(text) + 1);
    } else if (p->kind == VV_KIND_NUMBERS) {
        *(vv_numbers **)slot = vvi_numbers_retain(*(vv_numbers *const *)source);
    } else if (p->kind == VV_KIND_OBJECT) {
        *(vv_object **)slot = vv_object_retain(*(vv_object *const *)source);
    } else if (vvi_kind_is_collection(p->kind)) {
        *(vv_collection **)slot = vvi_collection_retain(*(vv_collection *const *)source);
    } else {
        memcpy(slot, source, plain_bytes(p->kind));
    }
    return VV_OK;
}

static size_t columns_of(const vv_property *p)
{
    return p->columns > 1 ? (size_t)p->columns : 1;
}

static bool numbers_equal(const vv_numbers *a, const vv_numbers *b, size_t columns)
{
    return a == b || (a && b && a->n == b->n && !memcmp(a->v, b->v, a->n * sizeof(double)) &&
                      (!a->labels || !b->labels || !memcmp(a->labels, b->labels, a->n / columns * sizeof *a->labels)));
}

static bool texts_equal(const char *a, const char *b)
{
    return a == b || (a && b && !strcmp(a, b));
}

/* Bit for bit: -0 is not 0. */
bool vvi_value_equal(const vv_object *a, const vv_object *b, const vv_property *p)
{
    const void *slot_a = vvi_slot_const(a, p), *slot_b = vvi_slot_const(b, p);
    if (vvi_kind_is_text(p->kind))
        return texts_equal(*(char *const *)slot_a, *(char *const *)slot_b);
    if (p->kind == VV_KIND_NUMBERS)
        return numbers_equal(*(vv_numbers *const *)slot_a, *(vv_numbers *const *)slot_b, columns_of(p));
    if (p->kind == VV_KIND_OBJECT)
        return vv_object_equal(*(vv_object *const *)slot_a, *(vv_object *const *)slot_b);
    if (vvi_kind_is_collection(p->kind))
        return vvi_collection_equal(*(vv_collection *const *)slot_a, *(vv_collection *const *)slot_b);
    return !memcmp(slot_a, slot_b, plain_bytes(p->kind));
}

static vv_status variants_default(vv_collection **slot, const vv_property *p, const vv_property_context *context)
{
    const char *name = NULL;
    size_t n = 0;
    while (context->variant && context->variant(context->user, p->table, n, &name))
        n++;
    vv_status st = vvi_collection_new(slot, n);
    for (size_t i = 0; st == VV_OK && i < n; i++) {
        const vv_class *cls = context->variant(context->user, p->table, i, &name);
        vv_entry *entry = &(*slot)->entry[i];
        if (!(entry->id = vvi_strdup(name)))
            return vv_fail_memory(strlen(name) + 1);
        st = vv_object_new(&entry->object, cls, context);
    }
    return st;
}

static vv_status text_default(vv_object *object, const vv_property *p)
{
    static const vv_color white = {1, 1, 1, 1};
    if (!p->def_text) {
        if (p->kind == VV_KIND_COLOR)
            memcpy(vvi_slot(object, p), &white, sizeof white);
        return VV_OK;
    }
    json_t *json = NULL;
    const vvi_place place = {.name = p->name};
    const vvi_reading reading = {.context = vvi_context_or_empty(NULL)};
    vv_status st = vvi_json_parse_typed(&json, p->def_text, p->kind, &place);
    if (st == VV_OK)
        st = vvi_value_read(object, p, json, &reading, &place);
    json_decref(json);
    return st;
}

vv_status vvi_value_default(vv_object *object, const vv_property *p, const vv_property_context *context)
{
    void *slot = vvi_slot(object, p);
    switch (p->kind) {
    case VV_KIND_BOOL:
        *(bool *)slot = p->def != 0;
        return VV_OK;
    case VV_KIND_I64:
        *(int64_t *)slot = (int64_t)p->def;
        return VV_OK;
    case VV_KIND_F64:
        *(double *)slot = p->quantity == VV_Q_ANGLE ? vvi_radians(p->def) : p->def;
        return VV_OK;
    case VV_KIND_ENUM:
        *(int *)slot = (int)p->def;
        return VV_OK;
    case VV_KIND_OBJECT:
        return vv_object_new(slot, p->cls, context);
    case VV_KIND_LIST:
    case VV_KIND_MAP:
        return vvi_collection_new(slot, 0);
    case VV_KIND_VARIANTS:
        return variants_default(slot, p, context);
    case VV_KIND_VEC3:
        memset(slot, 0, sizeof(vv_vec3));
        return text_default(object, p);
    default:
        return text_default(object, p);
    }
}

/* Text that must name a row of one of the registry's tables. */
static vv_status check_table(const vv_property *p, const char *text, const vvi_reading *reading, const vvi_place *place)
{
    enum { MOST = 256 };
    const char *names[MOST];
    const vv_property_context *context = reading->context;
    size_t n = 0;
    if (!p->table || !context->variant || context->keep_unknown)
        return VV_OK;
    while (n < MOST && context->variant(context->user, p->table, n, &names[n])) {
        if (!strcmp(names[n++], text))
            return VV_OK;
    }
    return n ? vvi_fail_unknown(place, VV_E_ARGUMENT, p->name, text, &(vvi_known){names, n, NULL, p->aliases}) : VV_OK;
}

size_t vvi_text_most(const vv_property *p)
{
    if (p->limited)
        return (size_t)p->max;
    return p->kind == VV_KIND_PATH ? VVI_PATH_BYTES : VVI_JSON_STRING;
}

static const char *alias_of(const vv_property *p, const char *text)
{
    for (const char *const *pair = p->aliases; pair && pair[0]; pair += 2)
        if (!strcmp(pair[0], text))
            return pair[1];
    return text;
}

/* The bytes of a path, which a scene has relative to its folder. */
static char *read_path(const char *text, const vvi_reading *reading)
{
    char *path = vvi_strdup(text);
    if (!path)
        return NULL;
    vvi_path_of_text(path);
    if (!reading->map_path)
        return path;
    char *mapped = reading->map_path(reading->map_user, path);
    free(path);
    return mapped;
}

static vv_status read_string(vv_object *object, const vv_property *p, const json_t *json, const vvi_reading *reading,
                             const vvi_place *place)
{
    char found[64];
    const char *text = json_string_value(json);
    if (!text)
        return vvi_fail_place(place, VV_E_ARGUMENT, "expected text, found %s", vvi_found(found, json));
    if (json_string_length(json) > vvi_text_most(p))
        return vvi_fail_place(place, VV_E_LIMIT, "the text is %zu bytes long: at most %zu are allowed",
                              json_string_length(json), vvi_text_most(p));
    if (p->kind == VV_KIND_REF && !vvi_id_valid(text))
        return vvi_fail_place(place, VV_E_ARGUMENT, "expected the name of one of the World's %s, found '%.64s'",
                              p->ref_to ? p->ref_to : "objects", text);
    text = alias_of(p, text);
    const vv_status st = check_table(p, text, reading, place);
    if (st != VV_OK)
        return st;
    char *copy = p->kind == VV_KIND_PATH ? read_path(text, reading) : vvi_strdup(text);
    if (!copy)
        return vv_fail_memory(strlen(text) + 1);
    vvi_value_drop(object, p);
    *(char **)vvi_slot(object, p) = copy;
    return VV_OK;
}

static vv_status read_enum(int *out, const vv_property *p, const json_t *json, const vvi_place *place)
{
    char found[64], number[32];
    const char *text = json_string_value(json);
    size_t n = 0;
    if (json_is_integer(json) && strtod(p->names[0], NULL) != 0) { /* names that are numbers are typed as numbers */
        snprintf(number, sizeof number, "%" JSON_INTEGER_FORMAT, json_integer_value(json));
        text = number;
    }
    const char *name = text ? alias_of(p, text) : NULL;
    for (; p->names[n]; n++) {
        if (name && !strcmp(p->names[n], name)) {
            *out = (int)n;
            return VV_OK;
        }
    }
    if (!text)
        return vvi_fail_place(place, VV_E_ARGUMENT, "expected one of its words, as text, found %s",
                              vvi_found(found, json));
    return vvi_fail_unknown(place, VV_E_ARGUMENT, p->name, text, &(vvi_known){p->names, n, NULL, p->aliases});
}

static vv_status read_vec3(vv_vec3 *out, const vv_property *p, const json_t *json, const vvi_reading *reading,
                           const vvi_place *place)
{
    char found[64];
    double v[3] = {0};
    if (json_array_size(json) != 3)
        return vvi_fail_place(place, VV_E_ARGUMENT, "expected three numbers [x, y, z], found %s",
                              vvi_found(found, json));
    for (size_t i = 0; i < 3; i++) {
        const vvi_place at = {.up = place, .index = i};
        const vv_status st = vvi_number_read(&v[i], p, json_array_get(json, i), reading, &at);
        if (st != VV_OK)
            return st;
    }
    *out = (vv_vec3){v[0], v[1], v[2]};
    return VV_OK;
}

static vv_status read_label(vv_numbers *out, size_t row, const vv_property *p, const json_t *json,
                            const vvi_place *place)
{
    vv_label_id id;
    double value;
    const vv_status st = vvi_label_id_read(&id, &value, p, json, place);
    if (st == VV_OK)
        vvi_numbers_set_label(out, row, columns_of(p), id, value);
    return st;
}

static vv_status read_row(vv_numbers *numbers, size_t row, const vv_property *p, const json_t *json,
                          const vvi_reading *reading, const vvi_place *place)
{
    char found[64];
    const size_t columns = columns_of(p);
    double *out = numbers->v + row * columns;
    if (columns == 1)
        return numbers->labels ? read_label(numbers, row, p, json, place)
                               : vvi_number_read(out, p, json, reading, place);
    if (json_array_size(json) != columns)
        return vvi_fail_place(place, VV_E_ARGUMENT, "expected a row of %zu numbers, found %s", columns,
                              vvi_found(found, json));
    for (size_t i = 0; i < columns; i++) {
        const vvi_place at = {.up = place, .index = i};
        const json_t *cell = json_array_get(json, i);
        const vv_status st = i == 0 && numbers->labels ? read_label(numbers, row, p, cell, &at)
                                                       : vvi_number_read(&out[i], p, cell, reading, &at);
        if (st != VV_OK)
            return st;
    }
    return VV_OK;
}

/* A number, or a row of them, without the brackets around all. */
static bool stands_alone(const vv_property *p, const json_t *json)
{
    if (!p->lone)
        return false;
    if (columns_of(p) > 1)
        return json_array_size(json) > 0 && !json_is_array(json_array_get(json, 0));
    return json_is_number(json) || (p->quantity == VV_Q_LABEL && json_is_string(json));
}

static const char *wanted_numbers(const vv_property *p)
{
    if (p->columns == 2 && p->lone)
        return "two numbers, as in 0..300";
    return p->columns > 1 ? "an array of rows of numbers"
           : p->lone      ? "a number, or several as in 1,2,3"
                          : "several numbers, as in 1,2,3";
}

static vv_status read_numbers(vv_numbers **slot, const vv_property *p, const json_t *json, const vvi_reading *reading,
                              const vvi_place *place)
{
    char found[64];
    const size_t columns = columns_of(p);
    const bool labels = p->quantity == VV_Q_LABEL;
    const bool none =
        p->lone && columns == 1 && !labels && json_is_string(json) && strcmp(json_string_value(json), "none") == 0;
    const bool lone = stands_alone(p, json);
    const size_t n = lone ? 1 : json_array_size(json);
    if (!json_is_array(json) && !lone && !none)
        return vvi_fail_place(place, VV_E_ARGUMENT, "expected %s, found %s", wanted_numbers(p), vvi_found(found, json));
    if (n > VVI_COLLECTION_MOST)
        return vvi_fail_place(place, VV_E_LIMIT, "%zu rows are too many: at most %d are allowed", n,
                              VVI_COLLECTION_MOST);
    vv_numbers *numbers = NULL;
    vv_status st = labels ? vvi_numbers_new_labels(&numbers, n, columns) : vvi_numbers_new(&numbers, n * columns);
    for (size_t i = 0; st == VV_OK && i < n; i++) {
        const vvi_place at = {.up = place, .index = i};
        st = lone ? read_row(numbers, 0, p, json, reading, place)
                  : read_row(numbers, i, p, json_array_get(json, i), reading, &at);
    }
    if (st != VV_OK) {
        vvi_numbers_release(numbers);
        return st;
    }
    vvi_numbers_release(*slot);
    *slot = numbers;
    return VV_OK;
}

vv_status vvi_value_read(vv_object *object, const vv_property *p, const json_t *json, const vvi_reading *reading,
                         const vvi_place *place)
{
    char found[64];
    void *slot = vvi_slot(object, p);
    switch (p->kind) {
    case VV_KIND_BOOL:
        if (!json_is_boolean(json))
            return vvi_fail_place(place, VV_E_ARGUMENT, "expected true or false, found %s", vvi_found(found, json));
        *(bool *)slot = json_is_true(json);
        return VV_OK;
    case VV_KIND_I64:
        return p->quantity == VV_Q_LABEL ? vvi_label_id_read(slot, NULL, p, json, place)
                                         : vvi_integer_read(slot, p, json, reading, place);
    case VV_KIND_F64:
        return vvi_number_read(slot, p, json, reading, place);
    case VV_KIND_ENUM:
        return read_enum(slot, p, json, place);
    case VV_KIND_VEC3:
        return read_vec3(slot, p, json, reading, place);
    case VV_KIND_COLOR:
        return vvi_color_read(slot, json, place);
    case VV_KIND_NUMBERS:
        return read_numbers(slot, p, json, reading, place);
    case VV_KIND_MEMBERS:
        return vvi_members_read(object, p, json, place);
    default:
        return read_string(object, p, json, reading, place);
    }
}
