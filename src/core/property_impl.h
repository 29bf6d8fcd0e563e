/** @file
 * Inside the property engine: what its files share. JSON is read into jansson's tree and written by our own printer.
 */
#ifndef VVI_CORE_PROPERTY_IMPL_H
#define VVI_CORE_PROPERTY_IMPL_H
#include "core/memory.h"
#include "core/names.h"
#include "core/status.h"
#include "core/text.h"
#include <jansson.h>
#include <volvis/property.h>

/* Limits on outside input. */
#define VVI_JSON_DEPTH 32
#define VVI_JSON_STRING (1024 * 1024)
#define VVI_PATH_BYTES 4096 /* of a text that is one, where its row does not say otherwise: no system opens more */
#define VVI_JSON_BYTES (16 * 1024 * 1024)
#define VVI_JSON_TREE_BYTES ((uint64_t)6 * VVI_JSON_BYTES) /* of its values, and twice the text's own */
#define VVI_COLLECTION_MOST 65536
#define VVI_ID_MOST 63

/** Where a value stands, from the inside out; made into text only when something is wrong. */
typedef struct vvi_place {
    const struct vvi_place *up; /**< NULL: the outermost */
    const char *name;           /**< NULL: `index` is meant; "" is left out */
    size_t index;
} vvi_place;

/** "views.main.camera"; NULL without memory. Yours to free(). */
char *vvi_place_text(const vvi_place *place);
vv_status vvi_fail_place(const vvi_place *place, vv_status status, const char *format, ...) VV_PRINTF(3, 4);

/** Turns the path of a file that a document names into another one; yours to free(), NULL without memory. */
typedef char *vvi_map_path_fn(void *user, const char *path);

/** What reading needs to know. */
typedef struct vvi_reading {
    const vv_property_context *context; /**< never NULL */
    vvi_map_path_fn *map_path;          /**< NULL: paths as they are */
    void *map_user;
} vvi_reading;

/** The context itself, or one that knows nothing for NULL. */
const vv_property_context *vvi_context_or_empty(const vv_property_context *context);

/* Names (property_name.c) ------------------------------------------------------------------------------------ */

/** [A-Za-z_][A-Za-z0-9_-]{0,62} */
bool vvi_id_valid(const char *id);
/** "unknown <what> 'typed'; did you mean 'x'?", or the known ones where none is near. */
vv_status vvi_fail_unknown(const vvi_place *place, vv_status status, const char *what, const char *typed,
                           const vvi_known *names);
/** The same for a property name of an object, the names of its variants among the known ones. */
vv_status vvi_fail_unknown_property(const vvi_place *place, const vv_object *object, const char *typed);
/** The same for an entry of a collection. */
vv_status vvi_fail_unknown_entry(const vvi_place *place, const vv_collection *collection, const char *typed);

/* Values (property_value.c) ---------------------------------------------------------------------------------- */

static inline void *vvi_slot(vv_object *object, const vv_property *property)
{
    return (char *)object + property->offset;
}
static inline const void *vvi_slot_const(const vv_object *object, const vv_property *property)
{
    return (const char *)object + property->offset;
}
static inline bool vvi_kind_is_text(vv_type_kind kind)
{
    return kind == VV_KIND_STRING || kind == VV_KIND_PATH || kind == VV_KIND_REF || kind == VV_KIND_MEMBERS;
}
static inline bool vvi_kind_is_collection(vv_type_kind kind)
{
    return kind == VV_KIND_LIST || kind == VV_KIND_MAP || kind == VV_KIND_VARIANTS;
}
static inline vv_collection *vvi_collection_of(const vv_object *object, const vv_property *property)
{
    return *(vv_collection *const *)vvi_slot_const(object, property);
}
static inline vv_object *vvi_object_of(const vv_object *object, const vv_property *property)
{
    return *(vv_object *const *)vvi_slot_const(object, property);
}

/** How many bytes a text may have. */
size_t vvi_text_most(const vv_property *property);
/** Number of a row in its class: its bit in `set`. */
size_t vvi_property_index(const vv_class *cls, const vv_property *property);
void vvi_set_mark(vv_object *object, const vv_property *property, bool set);
/** Whether a row says anything: its bit, or content below it. */
bool vvi_property_is_set(const vv_object *object, const vv_property *property);
/** Whether anything at all is set in or below an object. */
bool vvi_object_has_content(const vv_object *object);

/** Take away what the slot holds (it is zero afterwards). */
void vvi_value_drop(vv_object *object, const vv_property *property);
/** Fill an empty slot with what another object has there: text is copied, the rest shared. */
vv_status vvi_value_share(vv_object *object, const vv_object *from, const vv_property *property);
bool vvi_value_equal(const vv_object *a, const vv_object *b, const vv_property *property);
/** Fill an empty slot with the default. */
vv_status vvi_value_default(vv_object *object, const vv_property *property, const vv_property_context *context);
/** Read one plain value (no object, list, map or variants; not null) into its slot, in place of the old one. */
vv_status vvi_value_read(vv_object *object, const vv_property *property, const json_t *json, const vvi_reading *reading,
                         const vvi_place *place);

/** Numbers by quantity (property_number.c): angles are degrees outside and radians inside. */
double vvi_radians(double degrees);
/** The degrees that give exactly these radians, the shortest to write where several do; the nearest when none do. */
double vvi_degrees(double radians);
vv_status vvi_number_read(double *out, const vv_property *property, const json_t *json, const vvi_reading *reading,
                          const vvi_place *place);
/** Digits as text, or a number; value_out: the nearest double, NULL: nobody asks. Ids of 2^63 and more are those of
 * uint64_t. */
vv_status vvi_label_id_read(vv_label_id *out, double *value_out, const vv_property *property, const json_t *json,
                            const vvi_place *place);
/** value: the nearest double, which says of which sign it is. */
void vvi_label_id_print(vvi_text *text, vv_label_id id, double value);
vv_status vvi_integer_read(int64_t *out, const vv_property *property, const json_t *json, const vvi_reading *reading,
                           const vvi_place *place);
void vvi_number_print(vvi_text *text, double stored, vv_quantity quantity);
/** "found" of an error: what a JSON value is, in a few words. */
const char *vvi_found(char out[64], const json_t *json);

/** Colours (property_color.c). */
vv_status vvi_color_read(vv_color *out, const json_t *json, const vvi_place *place);
void vvi_color_print(vvi_text *text, const vv_color *color);

/* Free JSON objects (property_members.c): of VV_KIND_MEMBERS. */

/** For json_decref(); NULL without memory. Of an unset one it is empty. */
json_t *vvi_members_tree(const vv_object *object, const vv_property *property);
vv_status vvi_members_read(vv_object *object, const vv_property *property, const json_t *json, const vvi_place *place);
/** One member; value NULL or null: it goes. */
vv_status vvi_members_read_one(vv_object *object, const vv_property *property, const char *name, const json_t *value,
                               const vvi_place *place);
vv_status vvi_members_share_one(vv_object *object, const vv_object *from, const vv_property *property,
                                const char *name);

/* Objects and collections (property.c, property_collection.c) ------------------------------------------------ */

/** A copy that shares everything below it: what an edit changes. */
vv_status vvi_object_copy(vv_object **out, const vv_object *from);
/** Leave out what a newer schema said under this name. */
vv_status vvi_extra_remove(vv_object *object, const char *name);
vv_status vvi_extra_put(vv_object *object, const char *name, const json_t *json);
/** Set the extra of `name` as `from` has it. */
vv_status vvi_extra_share(vv_object *object, const vv_object *from, const char *name);

/** n empty entries to fill before it is shared. */
vv_status vvi_collection_new(vv_collection **out, size_t n);
vv_collection *vvi_collection_retain(const vv_collection *collection);
void vvi_collection_release(vv_collection *collection);
bool vvi_collection_equal(const vv_collection *a, const vv_collection *b);
/** A copy with `n_gone` entries at `at` replaced by one (object NULL: by none); retains the object. */
vv_status vvi_collection_splice(vv_collection **out, const vv_collection *from, size_t at, size_t n_gone,
                                const char *id, const vv_object *object);
/** Position of an id; n when it is not there. */
size_t vvi_collection_index(const vv_collection *collection, const char *id);

vv_status vvi_numbers_new(vv_numbers **out, size_t n);
/** Rows that begin with a label; to be filled before they are shared. */
vv_status vvi_numbers_new_labels(vv_numbers **out, size_t rows, size_t columns);
void vvi_numbers_set_label(vv_numbers *numbers, size_t row, size_t columns, vv_label_id id, double value);
vv_numbers *vvi_numbers_retain(const vv_numbers *numbers);
void vvi_numbers_release(vv_numbers *numbers);

/* JSON (property_json.c, property_print.c) ------------------------------------------------------------------- */

/** Parse a document within the limits. Errors name line and column. */
vv_status vvi_json_parse(json_t **out, const char *text, size_t length, const vvi_place *place);
/** Parse what people type for a property of this kind: bare words and lists without brackets too. */
vv_status vvi_json_parse_typed(json_t **out, const char *text, vv_type_kind kind, const vvi_place *place);
/** A new object from a tree. */
vv_status vvi_object_from_tree(vv_object **out, const vv_class *cls, const json_t *tree, const vvi_reading *reading,
                               const vvi_place *place);
/** Any property from a tree; null unsets. */
vv_status vvi_property_read(vv_object *object, const vv_property *property, const json_t *json,
                            const vvi_reading *reading, const vvi_place *place);
/** The class's own check of an object that stands at `place`. */
vv_status vvi_object_check(const vv_object *object, const vvi_place *place);

/** JSON under construction. */
typedef struct vvi_json {
    vvi_text text;
    int indent; /**< spaces a level; 0: all on one line */
    int depth;
    bool fresh;                /**< nothing written at this level yet */
    vvi_map_path_fn *map_path; /**< of files; NULL: as they are */
    void *map_user;
} vvi_json;

void vvi_json_open(vvi_json *json, char bracket);
void vvi_json_close(vvi_json *json, char bracket);
/** Before each member of an object, before each item of an array. */
void vvi_json_key(vvi_json *json, const char *name);
void vvi_json_item(vvi_json *json);
void vvi_json_string(vvi_json *json, const char *text); /* NULL: null */
void vvi_json_number(vvi_json *json, double value);
/** A jansson tree as it is, numbers in our form. */
void vvi_json_tree(vvi_json *json, const json_t *tree);
/** The value in a slot, whatever its kind. */
void vvi_json_value(vvi_json *json, const vv_object *object, const vv_property *property);
/** Members of an object that are set, without the brackets. */
void vvi_json_members(vvi_json *json, const vv_object *object);
/** A free JSON object, and one member of it: null where it is not there. */
void vvi_members_print(vvi_json *json, const vv_object *object, const vv_property *property);
void vvi_members_print_one(vvi_json *json, const vv_object *object, const vv_property *property, const char *name);

/* Paths (property_path.c, property_edit.c) ------------------------------------------------------------------- */

/** One step of a path: a property of `owner`, or an entry of that property's collection. */
typedef struct vvi_hop {
    const vv_object *owner;
    const vv_property *property;
    bool entry;
    char id[VVI_ID_MOST + 1]; /**< of the entry in maps and variants */
    size_t index;             /**< of the entry; past the end when it is not there */
    vv_object *object;        /**< what the step leads to; NULL for plain values, collections and absent entries */
    size_t start;             /**< where the owner's own path ends in the whole path */
    const char *member;       /**< of a free JSON object: its name, the rest of the path; NULL: the whole is meant */
} vvi_hop;

enum { VVI_HOPS_MOST = 16 };
typedef struct vvi_trail {
    const char *path;
    vvi_hop hop[VVI_HOPS_MOST];
    size_t n; /**< 0: the root itself */
} vvi_trail;

/** Follow a path. Only the last entry may be absent; then its hop's object is NULL. */
vv_status vvi_trail_find(vvi_trail *out, const vv_object *root, const char *path);
/** The error for a trail whose last entry is not there. */
vv_status vvi_trail_fail_absent(const vvi_trail *trail);
/** Path of the object that owns the last step. */
void vvi_trail_owner_path(char *out, size_t room, const vvi_trail *trail);

#endif
