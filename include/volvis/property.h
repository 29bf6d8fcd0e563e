/** @file
 * The property engine: every field of every model object, verb option and operation parameter is one row of a table,
 * and from the rows come scene files, `--set`, the JSON Schema, help, undo and whatever later work reads.
 *
 * An object is a plain struct that begins with vv_object. Objects are reference-counted and, once shared, never
 * change: an edit makes new copies of the objects along one path (copy on write), so keeping a whole World as it was
 * costs one reference. Each property knows whether it was set: an unset one has its default, or, where `automatic`
 * says so, a value that is worked out when it is needed.
 */
#ifndef VOLVIS_PROPERTY_H
#define VOLVIS_PROPERTY_H
#include <volvis/field.h>
#include <volvis/status.h>
#include <volvis/vec.h>
VV_BEGIN_DECLS

typedef enum vv_type_kind {
    VV_KIND_BOOL,    /**< bool */
    VV_KIND_I64,     /**< int64_t */
    VV_KIND_F64,     /**< double; `quantity` says which units may be written after it */
    VV_KIND_ENUM,    /**< int; JSON: one of `names` */
    VV_KIND_STRING,  /**< char *, owned, NULL when unset without default */
    VV_KIND_PATH,    /**< char *, owned; a file: relative to the scene file in scenes */
    VV_KIND_REF,     /**< char *, owned; the id of an object in the World's map `ref_to` */
    VV_KIND_VEC3,    /**< vv_vec3; JSON [x, y, z] */
    VV_KIND_COLOR,   /**< vv_color, linear; JSON "#rrggbb[aa]" (sRGB), a CSS basic colour name, or [r, g, b(, a)] linear
                      */
    VV_KIND_NUMBERS, /**< vv_numbers *; JSON array, or array of arrays of `columns` numbers */
    VV_KIND_OBJECT,  /**< vv_object *, one of `cls`, never NULL */
    VV_KIND_LIST,    /**< vv_collection *, objects of `cls` by position: JSON array, path part is the index */
    VV_KIND_MAP,     /**< vv_collection *, objects of `cls` by id: JSON object, path part is the id */
    VV_KIND_VARIANTS, /**< vv_collection *, one object for each row of the registry's table `table`, by its name */
    VV_KIND_MEMBERS /**< char *, owned, NULL when unset: a JSON object, as compact text. What its members are is not the
                       engine's to judge; the last part of a path may name one */
} vv_type_kind;

/** What a number measures; decides the units that may be written after it. */
typedef enum vv_quantity {
    VV_Q_NONE,
    VV_Q_LENGTH, /**< stored in the World's unit: "1.5mm"; "3vox" where a grid is at hand */
    VV_Q_ANGLE,  /**< degrees outside (JSON, command line), radians inside (the struct) */
    VV_Q_TIME,   /**< seconds */
    VV_Q_BYTES,  /**< "8G" = 8 * 2^30 */
    VV_Q_RATIO,  /**< "50%" = 0.5 */
    VV_Q_LABEL /**< of i64, and of the first column of numbers: a vv_label_id, with all of its digits; beyond 2^53 it is
                  written as text, "864691135000000001", and read as that or as a number */
} vv_quantity;

typedef struct vv_class vv_class;
typedef struct vv_property vv_property;

/** Head of every property object. `set` bit i: property row i was set by somebody. */
typedef struct vv_object {
    const vv_class *cls;
    uint32_t refs; /**< atomic */
    uint64_t set;
    void *extra; /**< what a newer schema said and this one does not know, kept for saving */
} vv_object;

/** Immutable, reference-counted rows of numbers. */
typedef struct vv_numbers {
    uint32_t refs;             /**< atomic */
    size_t n;                  /**< how many doubles, rows * columns */
    const vv_label_id *labels; /**< where they are labels, the first column with all of its digits; else NULL */
    double v[];
} vv_numbers;

typedef struct vv_entry {
    char *id; /**< NULL in lists */
    vv_object *object;
} vv_entry;

/** Immutable, reference-counted; entries in the order they were added. */
typedef struct vv_collection {
    uint32_t refs; /**< atomic */
    size_t n;
    vv_entry entry[];
} vv_collection;

/** One row: one field of one struct. Rows end with name NULL. At most 64 rows a class. */
struct vv_property {
    const char *name;
    vv_type_kind kind;
    size_t offset;
    const char *doc;       /**< one line, lower case, no full stop */
    const char *automatic; /**< how it is worked out when unset; NULL: the default is used */
    vv_quantity quantity;
    const char *unit;         /**< shown to people where quantity says too little: "value", "1/mm" */
    bool limited;             /**< min and max hold */
    double min, max;          /**< inclusive; in outside units (degrees); max of texts: bytes */
    double def;               /**< of bool, i64, f64 (outside units), enum (its number) */
    const char *def_text;     /**< of strings, vec3, colour, numbers, as JSON text; NULL: 0, white, empty */
    const char *const *names; /**< enum: names by number, ends with NULL */
    const vv_class *cls;      /**< object, list, map */
    const char *ref_to;       /**< ref: the World's map that holds it */
    const char *table;        /**< variants: "renderers", ...; string: it names a row of that table, if any are known */
    int columns;              /**< numbers: 1, or how many a row */
    bool lone;   /**< numbers: one by itself, or one row of `columns`, will do, and needs no brackets of its own; of a
                    table that is not, each time that the option is given adds a row */
    char letter; /**< command line: -o; 0: none */
    bool positional;    /**< command line: taken from the words without dashes */
    bool hidden;        /**< command line: not listed */
    bool ranged;        /**< command line: LO..HI, of which this is LO, and the next row HI; both of kind f64 */
    const char *when;   /**< "mode=composite|mean": acts while that enum of its class has one of these values;
                           "pieces|least": while one of these is set; "data=labels", "data=values": of an
                           operation, on such samples; NULL: always */
    const char *option; /**< command line: what it is called there, where that is not its name, which is read too; "":
                           it is no option */
    const char *const *aliases; /**< enum, string: pairs of a word that people type and the name that it stands for;
                                   ends with NULL. Read, and never written or listed */
    const char *label; /**< what panels call it, in small letters, where its name says too little to whoever has not
                          read about it */
};

struct vv_class {
    const char *name; /**< "light" */
    const char *doc;
    size_t size; /**< sizeof the struct */
    const vv_property *properties;
    /** Fields outside the table (a loaded field, say): copy shares, drop gives back. NULL: there are none. */
    void (*copy_hidden)(vv_object *copy, const vv_object *from);
    void (*drop_hidden)(vv_object *object);
    /** Checks that need more than one property; NULL: there are none. */
    vv_status (*check)(const vv_object *object, const char *path);
};

/** What the engine must know of the world around it. All fields may be zero. */
typedef struct vv_property_context {
    /** Row `index` of registry table `table`: its parameter class and, through name_out, its name. NULL at the end. */
    const vv_class *(*variant)(const void *user, const char *table, size_t index, const char **name_out);
    const void *user;
    const char *length_unit; /**< what lengths are stored in: "mm"; NULL or "voxel": only bare numbers and vox */
    double voxel;            /**< length of one voxel in that unit; 0: "3vox" is an error */
    bool keep_unknown;       /**< the document is of a newer schema: keep unknown names instead of refusing them */
} vv_property_context;

#define VV_PROP(type, field) .name = #field, .offset = offsetof(type, field)

/* Objects ------------------------------------------------------------------------------------------------------- */

/** New, all defaults, nothing set. Nested objects exist; lists and maps are empty; variants hold every row. */
VV_API vv_status vv_object_new(vv_object **out, const vv_class *cls, const vv_property_context *context);
VV_API vv_object *vv_object_retain(const vv_object *object);
VV_API void vv_object_release(vv_object *object); /* NULL is fine */
VV_API bool vv_object_equal(const vv_object *a, const vv_object *b);

/** Whether the property of that name in that very object was set. */
VV_API bool vv_object_is_set(const vv_object *object, const char *name);
VV_API const vv_property *vv_class_find(const vv_class *cls, const char *name);
/** Entry by id, or NULL. */
VV_API vv_object *vv_collection_find(const vv_collection *collection, const char *id);

/* Paths ---------------------------------------------------------------------------------------------------------
 * "lights.key.intensity", "cut_planes.0.offset". Each edit takes the root by pointer and swaps it for a new one that
 * shares all that is not on the path; on failure the root is untouched and the error names the path and the nearest
 * real name. */

/** `json`: JSON text; a bare word is taken as a string, 1.5mm needs no quotes, 1,2,3 no brackets. "null" unsets
 * (entries of lists and maps: removes). Objects, lists and maps are replaced as a whole; a map entry that is not there
 * is made. */
VV_API vv_status vv_path_set(vv_object **root, const char *path, const char *json, const vv_property_context *context);
/** vv_path_set() of a number, in the units that it has outside: angles in degrees, lengths in context->length_unit. Not
 * finite: VV_E_ARGUMENT. context as in vv_path_set(); NULL will do where there are no units. */
VV_API vv_status vv_path_set_number(vv_object **root, const char *path, double value,
                                    const vv_property_context *context);
VV_API vv_status vv_path_set_integer(vv_object **root, const char *path, int64_t value,
                                     const vv_property_context *context);
VV_API vv_status vv_path_set_bool(vv_object **root, const char *path, bool value, const vv_property_context *context);
/** Of strings, files, names of an enum, ids, colours ("red"), and quantities with their unit ("1.5mm"). */
VV_API vv_status vv_path_set_text(vv_object **root, const char *path, const char *value,
                                  const vv_property_context *context);
/** Of vectors, colours and lists of numbers; tables row by row. */
VV_API vv_status vv_path_set_numbers(vv_object **root, const char *path, const double *values, size_t n,
                                     const vv_property_context *context);
/** The value as JSON text, yours to free(); unset properties give their default, or null where `automatic` says how
 * it is worked out. Of objects, lists and maps: what is set in them. */
VV_API vv_status vv_path_get(char **json_out, const vv_object *root, const char *path);
/** Back to unset. */
VV_API vv_status vv_path_unset(vv_object **root, const char *path, const vv_property_context *context);
/** Add an entry to a map ("lights", id) or at the end of a list (id NULL). json: its properties, or NULL. Of a table of
 * numbers: a row at its end, as in 1,2,3. */
VV_API vv_status vv_path_add(vv_object **root, const char *path, const char *id, const char *json,
                             const vv_property_context *context);
/** Remove "lights.key" or "cut_planes.2". */
VV_API vv_status vv_path_remove(vv_object **root, const char *path, const vv_property_context *context);
/** Make `path` in *root what it is in `source` (set or unset, present or absent, and for map entries at the same place
 * among those that both have): the step that undo is made of. */
VV_API vv_status vv_path_copy(vv_object **root, const vv_object *source, const char *path,
                              const vv_property_context *context);
/** Put a ready object in an object property or a map entry; retains it. */
VV_API vv_status vv_path_put(vv_object **root, const char *path, vv_object *object, const vv_property_context *context);
/** The object at a path, borrowed; NULL and an error when there is none. */
VV_API const vv_object *vv_path_object(const vv_object *root, const char *path);

/** Called for every property below an object: rows and full path. False stops. */
typedef bool vv_path_visit_fn(void *user, const char *path, const vv_property *property, const vv_object *owner);
VV_API bool vv_path_each(const vv_object *root, vv_path_visit_fn *visit, void *user);

/** One path that another stands for. What it returns but VV_OK ends vv_path_expand(), and is returned. */
typedef vv_status vv_path_fn(void *user, const char *path);

/**
 * Every path that `path` stands for: a part `*` is each entry of a map or list ("volumes.*.visible"), and a number in a
 * map the entry at that place, from 0 ("volumes.0.visible"). Other paths are told as they are, whether or not they lead
 * anywhere. Edits that fn makes of the root do not change what is told.
 *
 * Errors   VV_E_ARGUMENT for a star elsewhere; VV_E_NOT_FOUND where there are no entries; VV_E_MEMORY; those of fn
 */
VV_API vv_status vv_path_expand(const vv_object *root, const char *path, vv_path_fn *fn, void *user);

/**
 * The row that a path leads to, by classes alone: "lights.ANY.intensity" needs no light of that name.
 *
 * cls_out  the class of the objects there, for objects, lists and maps; else NULL
 * Errors   VV_E_NOT_FOUND with the nearest real name
 * Owns     borrowed from the classes
 */
VV_API vv_status vv_path_row(const vv_property **row_out, const vv_class **cls_out, const vv_class *root,
                             const char *path, const vv_property_context *context);

/* JSON ---------------------------------------------------------------------------------------------------------- */

/** Only what is set, keys in table order, numbers in the shortest form that reads back equal. Yours to free(). */
VV_API vv_status vv_object_to_json(char **json_out, const vv_object *object, int indent);
/** Strict: unknown names, wrong types and values out of range are errors that name their path. */
VV_API vv_status vv_object_from_json(vv_object **out, const vv_class *cls, const char *json, size_t length,
                                     const vv_property_context *context);
/** JSON Schema (2020-12) of a class. Yours to free(). */
VV_API vv_status vv_class_schema(char **json_out, const vv_class *cls, const vv_property_context *context);

/** The nearest of n names to what was typed, or NULL when none is near (more than a third of the letters differ). */
VV_API const char *vv_nearest_name(const char *typed, const char *const *names, size_t n);

VV_END_DECLS
#endif
