/* FNV-1a over set properties, each as its name and its value in bytes of a fixed order. */
#include "model/object_hash.h"
#include "core/cache.h"
#include "core/property_impl.h"
#include <string.h>

enum { DEPTH_MOST = 16 };

typedef struct walk {
    const vvi_hash_rules *rules;
    uint64_t hash;
    int depth; /* of references */
} walk;

uint64_t vvi_hash_u64(uint64_t value, uint64_t seed)
{
    uint8_t bytes[8];
    for (int i = 0; i < 8; i++)
        bytes[i] = (uint8_t)(value >> 8 * i);
    return vvi_hash(bytes, sizeof bytes, seed);
}

uint64_t vvi_hash_f64(double value, uint64_t seed)
{
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    return vvi_hash_u64(bits, seed);
}

/* Its length first: "ab" and "c" are not "a" and "bc". */
uint64_t vvi_hash_text(const char *text, uint64_t seed)
{
    const size_t n = text ? strlen(text) : 0;
    return vvi_hash(text ? text : "", n, vvi_hash_u64(text ? n : UINT64_MAX, seed));
}

static void add_u64(walk *w, uint64_t value)
{
    w->hash = vvi_hash_u64(value, w->hash);
}

static void add_f64(walk *w, double value)
{
    w->hash = vvi_hash_f64(value, w->hash);
}

static void add_text(walk *w, const char *text)
{
    w->hash = vvi_hash_text(text, w->hash);
}

static void add_numbers(walk *w, const vv_numbers *numbers, int columns)
{
    const size_t n = numbers ? numbers->n : 0;
    add_u64(w, n);
    for (size_t i = 0; i < n; i++)
        add_f64(w, numbers->v[i]);
    for (size_t i = 0; n && numbers->labels && i < n / (columns > 1 ? (size_t)columns : 1); i++)
        add_u64(w, (uint64_t)numbers->labels[i]);
}

static void add_object(walk *w, const vv_object *object);

static void add_collection(walk *w, const vv_collection *collection)
{
    add_u64(w, collection->n);
    for (size_t i = 0; i < collection->n; i++) {
        add_text(w, collection->entry[i].id);
        add_object(w, collection->entry[i].object);
    }
}

/* What a reference leads to; NULL: nothing, or it is not asked for. */
static const vv_object *target_of(const walk *w, const vv_property *row, const char *id)
{
    const vv_world *world = w->rules->world;
    if (!world || !id || !row->ref_to || w->depth >= DEPTH_MOST)
        return NULL;
    const vv_property *map = vv_class_find(world->base.cls, row->ref_to);
    return map && vvi_kind_is_collection(map->kind) ? vv_collection_find(vvi_collection_of(&world->base, map), id)
                                                    : NULL;
}

static void add_reference(walk *w, const vv_property *row, const char *id)
{
    const vv_object *target = target_of(w, row, id);
    if (!target) {
        add_text(w, id);
        return;
    }
    w->depth++;
    add_object(w, target);
    w->depth--;
}

static void add_value(walk *w, const vv_object *object, const vv_property *row)
{
    const void *slot = vvi_slot_const(object, row);
    switch (row->kind) {
    case VV_KIND_BOOL:
        add_u64(w, *(const bool *)slot);
        break;
    case VV_KIND_I64:
        add_u64(w, (uint64_t) * (const int64_t *)slot);
        break;
    case VV_KIND_F64:
        add_f64(w, *(const double *)slot);
        break;
    case VV_KIND_ENUM: /* numbers of names may change from version to version */
        add_text(w, row->names[*(const int *)slot]);
        break;
    case VV_KIND_STRING:
    case VV_KIND_PATH:
    case VV_KIND_MEMBERS:
        add_text(w, *(char *const *)slot);
        break;
    case VV_KIND_REF:
        add_reference(w, row, *(char *const *)slot);
        break;
    case VV_KIND_VEC3: {
        const vv_vec3 *v = slot;
        add_f64(w, v->x);
        add_f64(w, v->y);
        add_f64(w, v->z);
        break;
    }
    case VV_KIND_COLOR: {
        const vv_color *c = slot;
        add_f64(w, c->r);
        add_f64(w, c->g);
        add_f64(w, c->b);
        add_f64(w, c->a);
        break;
    }
    case VV_KIND_NUMBERS:
        add_numbers(w, *(vv_numbers *const *)slot, row->columns);
        break;
    case VV_KIND_OBJECT:
        add_object(w, vvi_object_of(object, row));
        break;
    case VV_KIND_LIST:
    case VV_KIND_MAP:
    case VV_KIND_VARIANTS:
        add_collection(w, vvi_collection_of(object, row));
        break;
    }
}

static bool is_left_out(const walk *w, const vv_object *owner, const vv_property *row)
{
    const vvi_hash_rules *rules = w->rules;
    return rules->leaves_out && rules->leaves_out(rules->user, owner, row);
}

/* An object of which nothing is set but what does not count: it counts no more than one that is not there. */
static bool is_emptied(const walk *w, const vv_object *owner, const vv_property *row)
{
    const vv_object *object = row->kind == VV_KIND_OBJECT ? vvi_object_of(owner, row) : NULL;
    bool any = false;
    for (const vv_property *own = object ? object->cls->properties : NULL; own && own->name; own++) {
        if (!vvi_property_is_set(object, own))
            continue;
        if (!is_left_out(w, object, own))
            return false;
        any = true;
    }
    return any;
}

static void add_object(walk *w, const vv_object *object)
{
    add_text(w, object->cls->name);
    for (const vv_property *row = object->cls->properties; row->name; row++) {
        if (!vvi_property_is_set(object, row) || is_left_out(w, object, row) || is_emptied(w, object, row))
            continue;
        add_text(w, row->name);
        add_value(w, object, row);
    }
    add_text(w, NULL); /* its end */
}

uint64_t vvi_object_hash(const vv_object *object, const vvi_hash_rules *rules, uint64_t seed)
{
    static const vvi_hash_rules all = {.world = NULL};
    walk w = {.rules = rules ? rules : &all, .hash = seed};
    add_object(&w, object);
    return w.hash;
}
