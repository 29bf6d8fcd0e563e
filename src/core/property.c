/* Objects: made, shared, copied, compared. */
#include "core/json_text.h"
#include "core/property_impl.h"
#include <string.h>

const vv_property_context *vvi_context_or_empty(const vv_property_context *context)
{
    static const vv_property_context empty = {0};
    return context ? context : &empty;
}

const vv_property *vv_class_find(const vv_class *cls, const char *name)
{
    for (const vv_property *p = cls->properties; p->name; p++) {
        if (p->kind != VV_KIND_VARIANTS && !strcmp(p->name, name))
            return p;
    }
    return NULL;
}

size_t vvi_property_index(const vv_class *cls, const vv_property *property)
{
    return (size_t)(property - cls->properties);
}

void vvi_set_mark(vv_object *object, const vv_property *property, bool set)
{
    const uint64_t bit = UINT64_C(1) << vvi_property_index(object->cls, property);
    object->set = set ? object->set | bit : object->set & ~bit;
}

static bool collection_has_content(const vv_collection *collection, bool variants)
{
    if (!variants)
        return collection->n > 0;
    for (size_t i = 0; i < collection->n; i++) {
        if (vvi_object_has_content(collection->entry[i].object))
            return true;
    }
    return false;
}

bool vvi_property_is_set(const vv_object *object, const vv_property *p)
{
    if (p->kind == VV_KIND_OBJECT)
        return vvi_object_has_content(vvi_object_of(object, p));
    if (vvi_kind_is_collection(p->kind))
        return collection_has_content(vvi_collection_of(object, p), p->kind == VV_KIND_VARIANTS);
    return object->set >> vvi_property_index(object->cls, p) & 1;
}

bool vvi_object_has_content(const vv_object *object)
{
    if (object->set || object->extra)
        return true;
    for (const vv_property *p = object->cls->properties; p->name; p++) {
        if (vvi_property_is_set(object, p))
            return true;
    }
    return false;
}

bool vv_object_is_set(const vv_object *object, const char *name)
{
    const vv_property *p = vv_class_find(object->cls, name);
    return p && vvi_property_is_set(object, p);
}

vv_status vv_object_new(vv_object **out, const vv_class *cls, const vv_property_context *context)
{
    *out = NULL;
    vv_object *object = vvi_alloc_zeroed(NULL, cls->size, VVI_MEM_MODEL);
    if (!object)
        return vv_fail_memory(cls->size);
    object->cls = cls;
    object->refs = 1;
    for (const vv_property *p = cls->properties; p->name; p++) {
        const vv_status st = vvi_value_default(object, p, vvi_context_or_empty(context));
        if (st != VV_OK) {
            vv_object_release(object);
            return st;
        }
    }
    *out = object;
    return VV_OK;
}

vv_object *vv_object_retain(const vv_object *object)
{
    vv_object *shared = (vv_object *)object; /* the count is not part of what is constant */
    if (shared)
        __atomic_add_fetch(&shared->refs, 1, __ATOMIC_RELAXED);
    return shared;
}

void vv_object_release(vv_object *object)
{
    if (!object || __atomic_sub_fetch(&object->refs, 1, __ATOMIC_ACQ_REL))
        return;
    if (object->cls->drop_hidden)
        object->cls->drop_hidden(object);
    for (const vv_property *p = object->cls->properties; p->name; p++)
        vvi_value_drop(object, p);
    json_decref(object->extra);
    vvi_free(object);
}

vv_status vvi_object_copy(vv_object **out, const vv_object *from)
{
    *out = NULL;
    vv_object *copy = vvi_alloc_zeroed(NULL, from->cls->size, VVI_MEM_MODEL);
    if (!copy)
        return vv_fail_memory(from->cls->size);
    copy->cls = from->cls;
    copy->refs = 1;
    copy->set = from->set;
    copy->extra = json_incref(from->extra);
    if (from->cls->copy_hidden)
        from->cls->copy_hidden(copy, from);
    for (const vv_property *p = from->cls->properties; p->name; p++) {
        const vv_status st = vvi_value_share(copy, from, p);
        if (st != VV_OK) {
            vv_object_release(copy);
            return st;
        }
    }
    *out = copy;
    return VV_OK;
}

bool vv_object_equal(const vv_object *a, const vv_object *b)
{
    if (a == b)
        return true;
    if (!a || !b || a->cls != b->cls || a->set != b->set || !a->extra != !b->extra ||
        (a->extra && !json_equal(a->extra, b->extra)))
        return false;
    for (const vv_property *p = a->cls->properties; p->name; p++) {
        if (!vvi_value_equal(a, b, p))
            return false;
    }
    return true;
}

/* What a newer schema said: a JSON object that copies of this one share until it changes. */

static vv_status extra_own(vv_object *object)
{
    json_t *own = object->extra ? vvi_json_copy_object(object->extra) : json_object();
    if (!own)
        return vv_fail_memory(sizeof(json_t *));
    json_decref(object->extra);
    object->extra = own;
    return VV_OK;
}

vv_status vvi_extra_remove(vv_object *object, const char *name)
{
    if (!object->extra || !json_object_get(object->extra, name))
        return VV_OK;
    const vv_status st = extra_own(object);
    if (st != VV_OK)
        return st;
    json_object_del(object->extra, name);
    if (!json_object_size(object->extra)) {
        json_decref(object->extra);
        object->extra = NULL;
    }
    return VV_OK;
}

vv_status vvi_extra_put(vv_object *object, const char *name, const json_t *json)
{
    const vv_status st = extra_own(object);
    if (st != VV_OK)
        return st;
    /* trees that are kept are never changed: sharing them is enough */
    if (json_object_set(object->extra, name, (json_t *)json))
        return vv_fail_memory(strlen(name));
    return VV_OK;
}

vv_status vvi_extra_share(vv_object *object, const vv_object *from, const char *name)
{
    const json_t *json = from->extra ? json_object_get(from->extra, name) : NULL;
    return json ? vvi_extra_put(object, name, json) : vvi_extra_remove(object, name);
}
