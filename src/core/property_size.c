/* How large objects are: as text, and in memory beside an older version that shares most of them. */
#include "core/property_size.h"
#include "core/property_impl.h"
#include <string.h>

/* Text ---------------------------------------------------------------------------------------------------------- */

/* NUMBER: the longest, and what parts it from the next. ESCAPED: of a byte, \u001f. MARKS: quotes, colon, brackets,
 * line end and indentation of a member. WORD: of an enumeration or a colour. */
enum { NUMBER = 28, ESCAPED = 6, MARKS = 64, WORD = 64 };

static size_t text_of_tree(json_t *tree)
{
    return tree ? 4 * json_dumpb(tree, NULL, 0, JSON_INDENT(2)) : 0; /* our form, deeper down */
}

static size_t text_of_collection(const vv_collection *collection)
{
    size_t n = 0;
    for (size_t i = 0; i < collection->n; i++) {
        const vv_entry *entry = &collection->entry[i];
        n += MARKS + (entry->id ? strlen(entry->id) : 0) + vvi_object_text_most(entry->object);
    }
    return n;
}

static size_t text_of_value(const vv_object *object, const vv_property *p)
{
    const void *slot = vvi_slot_const(object, p);
    if (vvi_kind_is_text(p->kind))
        return *(char *const *)slot ? ESCAPED * strlen(*(char *const *)slot) : NUMBER;
    if (p->kind == VV_KIND_NUMBERS)
        return *(vv_numbers *const *)slot ? (*(vv_numbers *const *)slot)->n * (NUMBER + MARKS / 2) : 0;
    return p->kind == VV_KIND_ENUM ? WORD : 4 * NUMBER;
}

size_t vvi_object_text_most(const vv_object *object)
{
    size_t n = MARKS + text_of_tree(object->extra);
    for (const vv_property *p = object->cls->properties; p->name; p++) {
        if (p->kind == VV_KIND_OBJECT)
            n += MARKS + strlen(p->name) + vvi_object_text_most(vvi_object_of(object, p));
        else if (vvi_kind_is_collection(p->kind))
            n += MARKS + strlen(p->name) + text_of_collection(vvi_collection_of(object, p));
        else if (vvi_property_is_set(object, p))
            n += MARKS + strlen(p->name) + text_of_value(object, p);
    }
    return n;
}

/* Memory -------------------------------------------------------------------------------------------------------- */

/* Of what vvi_alloc() and malloc() add to a block. */
enum { BLOCK = 128, SMALL = 32 };

static size_t apart_collection(const vv_collection *collection, const vv_collection *from)
{
    size_t n = BLOCK + sizeof *collection + collection->n * sizeof(vv_entry), at = 0;
    if (collection == from)
        return 0;
    for (size_t i = 0; i < collection->n; i++, at++) {
        const vv_entry *entry = &collection->entry[i];
        /* one may have come or gone before it */
        if (from && at + 1 < from->n && from->entry[at + 1].object == entry->object)
            at++;
        else if (from && at > 0 && at <= from->n && from->entry[at - 1].object == entry->object)
            at--;
        n += entry->id ? SMALL + strlen(entry->id) : 0;
        n += vvi_object_apart(entry->object, from && at < from->n ? from->entry[at].object : NULL);
    }
    return n;
}

static size_t apart_value(const vv_object *object, const vv_object *from, const vv_property *p)
{
    const void *slot = vvi_slot_const(object, p), *old = from ? vvi_slot_const(from, p) : NULL;
    if (vvi_kind_is_text(p->kind)) /* each copy of an object has its own */
        return *(char *const *)slot ? SMALL + strlen(*(char *const *)slot) : 0;
    if (p->kind == VV_KIND_OBJECT)
        return vvi_object_apart(*(vv_object *const *)slot, old ? *(vv_object *const *)old : NULL);
    if (vvi_kind_is_collection(p->kind))
        return apart_collection(*(vv_collection *const *)slot, old ? *(vv_collection *const *)old : NULL);
    if (p->kind != VV_KIND_NUMBERS)
        return 0;
    const vv_numbers *numbers = *(vv_numbers *const *)slot;
    if (!numbers || (old && *(vv_numbers *const *)old == numbers))
        return 0;
    return BLOCK + sizeof *numbers + numbers->n * sizeof(double) * (numbers->labels ? 2 : 1);
}

size_t vvi_object_apart(const vv_object *object, const vv_object *from)
{
    if (object == from)
        return 0;
    const vv_object *old = from && from->cls == object->cls ? from : NULL;
    const bool shares = !object->extra || (old && old->extra == object->extra);
    size_t n = BLOCK + object->cls->size + (shares ? 0 : 4 * json_dumpb(object->extra, NULL, 0, 0));
    for (const vv_property *p = object->cls->properties; p->name; p++)
        n += apart_value(object, old, p);
    return n;
}
