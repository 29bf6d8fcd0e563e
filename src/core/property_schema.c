/* JSON Schema (2020-12) from the tables. */
#include "core/property_impl.h"
#include <math.h>
#include <string.h>

#define ID_PATTERN "^[A-Za-z_][A-Za-z0-9_-]{0,62}$"

enum { CLASSES_MOST = 256 };

/* The classes that were met, each written once under $defs. */
typedef struct schema {
    vvi_json json;
    const vv_property_context *context;
    const vv_class *cls[CLASSES_MOST];
    char name[CLASSES_MOST][VVI_ID_MOST + 17];
    size_t n;
} schema;

static void member_string(schema *s, const char *key, const char *text)
{
    vvi_json_key(&s->json, key);
    vvi_json_string(&s->json, text);
}

static void member_number(schema *s, const char *key, double value)
{
    if (!isfinite(value) || fabs(value) >= 1e300)
        return;
    vvi_json_key(&s->json, key);
    vvi_json_number(&s->json, value);
}

static void open_object(schema *s, const char *key)
{
    if (key)
        vvi_json_key(&s->json, key);
    else
        vvi_json_item(&s->json);
    vvi_json_open(&s->json, '{');
}

static void close_object(schema *s)
{
    vvi_json_close(&s->json, '}');
}

static bool name_taken(const schema *s, const char *name)
{
    for (size_t i = 0; i < s->n; i++) {
        if (!strcmp(s->name[i], name))
            return true;
    }
    return false;
}

/* Number of a class under $defs; two classes of one name are told apart by a number. */
static size_t class_number(schema *s, const vv_class *cls)
{
    size_t i = 0;
    while (i < s->n && s->cls[i] != cls)
        i++;
    if (i < s->n)
        return i;
    vvi_check(i < CLASSES_MOST);
    char name[sizeof s->name[0]];
    snprintf(name, sizeof name, "%.63s", cls->name);
    for (int k = 2; name_taken(s, name); k++)
        snprintf(name, sizeof name, "%.63s-%d", cls->name, k);
    s->cls[i] = cls;
    memcpy(s->name[i], name, sizeof name);
    s->n++;
    return i;
}

static void class_reference(schema *s, const vv_class *cls)
{
    char reference[128];
    snprintf(reference, sizeof reference, "#/$defs/%s", s->name[class_number(s, cls)]);
    member_string(s, "$ref", reference);
}

static void number_type(schema *s, const vv_property *p, const char *type)
{
    member_string(s, "type", type);
    if (p->limited) {
        member_number(s, "minimum", p->min);
        member_number(s, "maximum", p->max);
    }
}

/* A number, or text with a unit where the quantity has one, or with all digits of a label. */
static void number_schema(schema *s, const vv_property *p, const char *type)
{
    if (p->quantity == VV_Q_NONE) {
        number_type(s, p, type);
        return;
    }
    vvi_json_key(&s->json, "anyOf");
    vvi_json_open(&s->json, '[');
    open_object(s, NULL);
    number_type(s, p, type);
    close_object(s);
    open_object(s, NULL);
    member_string(s, "type", "string");
    member_string(s, "pattern",
                  p->quantity == VV_Q_LABEL
                      ? "^[-+]?[0-9]+$"
                      : "^\\s*[-+]?([0-9]+\\.?[0-9]*|\\.[0-9]+)([eE][-+]?[0-9]+)?\\s*[^0-9\\s]*$");
    close_object(s);
    vvi_json_close(&s->json, ']');
}

static void array_schema(schema *s, const vv_property *p, size_t min, size_t max)
{
    member_string(s, "type", "array");
    member_number(s, "minItems", (double)min);
    member_number(s, "maxItems", (double)max);
    open_object(s, "items");
    number_schema(s, p, "number");
    close_object(s);
}

static void numbers_schema(schema *s, const vv_property *p)
{
    const size_t columns = (size_t)p->columns;
    if (p->columns <= 1) {
        array_schema(s, p, 0, VVI_COLLECTION_MOST);
        return;
    }
    member_string(s, "type", "array");
    member_number(s, "maxItems", VVI_COLLECTION_MOST);
    open_object(s, "items");
    array_schema(s, p, columns, columns);
    close_object(s);
}

static void color_schema(schema *s)
{
    const vv_property any = {.limited = true, .min = 0, .max = INFINITY};
    vvi_json_key(&s->json, "anyOf");
    vvi_json_open(&s->json, '[');
    open_object(s, NULL);
    member_string(s, "type", "string");
    member_string(s, "pattern", "^(#([0-9A-Fa-f]{3,4}|[0-9A-Fa-f]{6}|[0-9A-Fa-f]{8})|[A-Za-z]+)$");
    close_object(s);
    open_object(s, NULL);
    array_schema(s, &any, 3, 4);
    close_object(s);
    vvi_json_close(&s->json, ']');
}

static void enum_schema(schema *s, const char *const *names)
{
    vvi_json_key(&s->json, "enum");
    vvi_json_open(&s->json, '[');
    for (size_t i = 0; names[i]; i++) {
        vvi_json_item(&s->json);
        vvi_json_string(&s->json, names[i]);
    }
    vvi_json_close(&s->json, ']');
}

/* Text, or the names of a table of the registry. */
static void text_schema(schema *s, const vv_property *p)
{
    const char *name = NULL;
    const vv_property_context *context = s->context;
    member_string(s, "type", "string");
    if (p->kind == VV_KIND_REF)
        member_string(s, "pattern", ID_PATTERN);
    else
        member_number(s, "maxLength", (double)vvi_text_most(p)); /* of characters, which have a byte at least */
    if (!p->table || !context->variant || !context->variant(context->user, p->table, 0, &name))
        return;
    vvi_json_key(&s->json, "enum");
    vvi_json_open(&s->json, '[');
    for (size_t i = 0; context->variant(context->user, p->table, i, &name); i++) {
        vvi_json_item(&s->json);
        vvi_json_string(&s->json, name);
    }
    vvi_json_close(&s->json, ']');
}

static void list_schema(schema *s, const vv_property *p)
{
    member_string(s, "type", "array");
    member_number(s, "maxItems", VVI_COLLECTION_MOST);
    open_object(s, "items");
    class_reference(s, p->cls);
    close_object(s);
}

static void map_schema(schema *s, const vv_property *p)
{
    member_string(s, "type", "object");
    member_number(s, "maxProperties", VVI_COLLECTION_MOST);
    open_object(s, "propertyNames");
    member_string(s, "pattern", ID_PATTERN);
    close_object(s);
    open_object(s, "additionalProperties");
    class_reference(s, p->cls);
    close_object(s);
}

static void value_schema(schema *s, const vv_property *p)
{
    switch (p->kind) {
    case VV_KIND_BOOL:
        member_string(s, "type", "boolean");
        break;
    case VV_KIND_I64:
        number_schema(s, p, "integer");
        break;
    case VV_KIND_F64:
        number_schema(s, p, "number");
        break;
    case VV_KIND_ENUM:
        enum_schema(s, p->names);
        break;
    case VV_KIND_VEC3:
        array_schema(s, p, 3, 3);
        break;
    case VV_KIND_COLOR:
        color_schema(s);
        break;
    case VV_KIND_NUMBERS:
        numbers_schema(s, p);
        break;
    case VV_KIND_OBJECT:
        class_reference(s, p->cls);
        break;
    case VV_KIND_LIST:
        list_schema(s, p);
        break;
    case VV_KIND_MAP:
        map_schema(s, p);
        break;
    case VV_KIND_MEMBERS:
        member_string(s, "type", "object");
        break;
    default:
        text_schema(s, p);
        break;
    }
}

static bool is_plain(const vv_property *p)
{
    return p->kind != VV_KIND_OBJECT && !vvi_kind_is_collection(p->kind);
}

static const char *unit_of(const vv_property *p)
{
    static const char *const units[] = {
        [VV_Q_NONE] = NULL, [VV_Q_LENGTH] = "world", [VV_Q_ANGLE] = "deg", [VV_Q_TIME] = "s",
        [VV_Q_BYTES] = "B", [VV_Q_RATIO] = "ratio",  [VV_Q_LABEL] = NULL,
    };
    return p->unit ? p->unit : units[p->quantity];
}

/* `defaults`: an object with nothing set, to print defaults from. */
static void property_schema(schema *s, const vv_property *p, const vv_object *defaults)
{
    open_object(s, p->name);
    if (p->doc)
        member_string(s, "description", p->doc);
    if (unit_of(p))
        member_string(s, "x-unit", unit_of(p));
    if (p->automatic)
        member_string(s, "x-automatic", p->automatic);
    if (is_plain(p) && !p->automatic) {
        vvi_json_key(&s->json, "default");
        vvi_json_value(&s->json, defaults, p);
    }
    /* null stands for "not set" wherever a value may stand */
    vvi_json_key(&s->json, "anyOf");
    vvi_json_open(&s->json, '[');
    open_object(s, NULL);
    value_schema(s, p);
    close_object(s);
    open_object(s, NULL);
    member_string(s, "type", "null");
    close_object(s);
    vvi_json_close(&s->json, ']');
    close_object(s);
}

static void variants_schema(schema *s, const vv_property *p)
{
    const vv_property_context *context = s->context;
    const char *name = NULL;
    for (size_t i = 0; context->variant; i++) {
        const vv_class *cls = context->variant(context->user, p->table, i, &name);
        if (!cls)
            return;
        const vv_property row = {.name = name, .kind = VV_KIND_OBJECT, .cls = cls, .doc = cls->doc};
        property_schema(s, &row, NULL);
    }
}

static vv_status class_schema(schema *s, const vv_class *cls, bool root)
{
    vv_object *defaults = NULL;
    const vv_status st = vv_object_new(&defaults, cls, NULL);
    if (st != VV_OK)
        return st;
    if (cls->doc)
        member_string(s, "description", cls->doc);
    member_string(s, "type", "object");
    open_object(s, "properties");
    if (root) {
        open_object(s, "$schema");
        member_string(s, "type", "string");
        close_object(s);
    }
    for (const vv_property *p = cls->properties; p->name; p++) {
        if (p->kind == VV_KIND_VARIANTS)
            variants_schema(s, p);
        else
            property_schema(s, p, defaults);
    }
    close_object(s);
    vvi_json_key(&s->json, "additionalProperties");
    vvi_text_add(&s->json.text, "false");
    vv_object_release(defaults);
    return VV_OK;
}

static vv_status write_schema(schema *s, const vv_class *cls)
{
    vvi_json_open(&s->json, '{');
    member_string(s, "$schema", "https://json-schema.org/draft/2020-12/schema");
    member_string(s, "title", cls->name);
    vv_status st = class_schema(s, cls, true);
    open_object(s, "$defs");
    for (size_t i = 0; st == VV_OK && i < s->n; i++) { /* grows while classes name others */
        open_object(s, s->name[i]);
        st = class_schema(s, s->cls[i], false);
        close_object(s);
    }
    close_object(s);
    vvi_json_close(&s->json, '}');
    vvi_text_add(&s->json.text, "\n");
    return st;
}

vv_status vv_class_schema(char **json_out, const vv_class *cls, const vv_property_context *context)
{
    *json_out = NULL;
    schema *s = vvi_alloc_zeroed(NULL, sizeof *s, VVI_MEM_SCRATCH);
    if (!s)
        return vv_fail_memory(sizeof *s);
    s->json.indent = 2;
    s->context = vvi_context_or_empty(context);
    vv_status st = write_schema(s, cls);
    if (st == VV_OK && !(*json_out = vvi_text_take(&s->json.text)))
        st = vv_fail_memory(1);
    vvi_text_free(&s->json.text);
    vvi_free(s);
    return st;
}
