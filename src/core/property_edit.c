/* Edits: new objects along one path, everything else shared; on failure the root is as it was. */
#include "core/property_impl.h"
#include <string.h>

/* Puts the new version of what a hop leads to into a fresh copy of its owner. */
static vv_status put_child(vv_object *fresh, const vvi_hop *hop, const vv_object *child)
{
    void *slot = vvi_slot(fresh, hop->property);
    if (!hop->entry) {
        vv_object_release(*(vv_object **)slot);
        *(vv_object **)slot = vv_object_retain(child);
        return VV_OK;
    }
    const vv_collection *old = *(vv_collection **)slot;
    const bool there = hop->index < old->n;
    const char *id = hop->property->kind == VV_KIND_LIST ? NULL : hop->id;
    vv_collection *made = NULL;
    const vv_status st = vvi_collection_splice(&made, old, there ? hop->index : old->n, there ? 1 : 0, id, child);
    if (st != VV_OK)
        return st;
    vvi_value_drop(fresh, hop->property);
    *(vv_collection **)slot = made;
    return VV_OK;
}

/* Swaps the root for one whose object at the end of hops 0 .. n - 1 is `fresh`. Takes fresh, also on failure. */
static vv_status swap_root(vv_object **root, const vvi_trail *trail, size_t n, vv_object *fresh)
{
    vv_status st = VV_OK;
    while (st == VV_OK && n-- > 0) {
        vv_object *owner = NULL;
        st = vvi_object_copy(&owner, trail->hop[n].owner);
        if (st == VV_OK)
            st = put_child(owner, &trail->hop[n], fresh);
        vv_object_release(fresh);
        fresh = owner;
    }
    if (st != VV_OK) {
        vv_object_release(fresh);
        return st;
    }
    vv_object_release(*root);
    *root = fresh;
    return VV_OK;
}

/* Swaps the root for one where the owner of the last hop is `fresh`, after its class has looked at it. */
static vv_status swap_owner(vv_object **root, const vvi_trail *trail, vv_object *fresh)
{
    char path[512];
    vvi_trail_owner_path(path, sizeof path, trail);
    const vvi_place place = {.name = path};
    const vv_status st = vvi_object_check(fresh, &place);
    if (st != VV_OK) {
        vv_object_release(fresh);
        return st;
    }
    return swap_root(root, trail, trail->n - 1, fresh);
}

static const vvi_hop *last_hop(const vvi_trail *trail)
{
    return &trail->hop[trail->n - 1];
}

/* The class of the object that a trail leads to or would lead to; NULL: no object. */
static const vv_class *class_at(const vvi_trail *trail, const vv_object *root)
{
    if (!trail->n)
        return root->cls;
    const vvi_hop *last = last_hop(trail);
    if (last->object)
        return last->object->cls;
    return last->entry ? last->property->cls : NULL;
}

/* Entries that are not there yet can be made in maps, and at the end of lists. */
static vv_status check_new_entry(const vvi_hop *hop, const vvi_place *place)
{
    const vv_collection *collection = vvi_collection_of(hop->owner, hop->property);
    if (hop->object)
        return VV_OK;
    if (hop->property->kind == VV_KIND_LIST)
        return hop->index == collection->n
                   ? VV_OK
                   : vvi_fail_place(place, VV_E_NOT_FOUND, "the list has %zu entries, counted from 0", collection->n);
    if (!vvi_id_valid(hop->id))
        return vvi_fail_place(
            place, VV_E_ARGUMENT,
            "'%.80s' is not a valid name: expected 1 to %d letters, digits, _ and -, not starting with a digit or -",
            hop->id, VVI_ID_MOST);
    return VV_OK;
}

static vv_status set_property(vv_object **root, const vvi_trail *trail, const json_t *json, const vvi_reading *reading,
                              const vvi_place *place)
{
    vv_object *fresh = NULL;
    const vvi_hop *last = last_hop(trail);
    vv_status st = vvi_object_copy(&fresh, last->owner);
    if (st != VV_OK)
        return st;
    st = last->member ? vvi_members_read_one(fresh, last->property, last->member, json, place)
                      : vvi_property_read(fresh, last->property, json, reading, place);
    if (st != VV_OK) {
        vv_object_release(fresh);
        return st;
    }
    return swap_owner(root, trail, fresh);
}

static vv_status set_object(vv_object **root, const vvi_trail *trail, const json_t *json, const vvi_reading *reading,
                            const vvi_place *place)
{
    vv_object *made = NULL;
    vv_status st = trail->n && last_hop(trail)->entry ? check_new_entry(last_hop(trail), place) : VV_OK;
    if (st == VV_OK)
        st = vvi_object_from_tree(&made, class_at(trail, *root), json, reading, place);
    return st == VV_OK ? swap_root(root, trail, trail->n, made) : st;
}

/* Each by itself: no rows, no ranges. */
static bool lists_numbers(const vv_property *property)
{
    return property->kind == VV_KIND_NUMBERS && property->lone && property->columns <= 1;
}

vv_status vv_path_set(vv_object **root, const char *path, const char *text, const vv_property_context *context)
{
    vvi_trail trail;
    json_t *json = NULL;
    const vvi_place place = {.name = path};
    const vvi_reading reading = {.context = vvi_context_or_empty(context)};
    vv_status st = vvi_trail_find(&trail, *root, path);
    if (st != VV_OK)
        return st;
    const bool object = class_at(&trail, *root) != NULL;
    if (!object && lists_numbers(last_hop(&trail)->property) && text[0] != '[' && strstr(text, ".."))
        return vvi_fail_place(&place, VV_E_ARGUMENT,
                              "a range is not a list; write the numbers with commas, as in 10,20, "
                              "found '%.60s'",
                              text);
    const vv_type_kind kind = object || last_hop(&trail)->member ? VV_KIND_OBJECT : last_hop(&trail)->property->kind;
    st = vvi_json_parse_typed(&json, text, kind, &place);
    if (st == VV_OK && json_is_null(json))
        st = vv_path_unset(root, path, context);
    else if (st == VV_OK)
        st = object ? set_object(root, &trail, json, &reading, &place)
                    : set_property(root, &trail, json, &reading, &place);
    json_decref(json);
    return st;
}

static vv_status reset_object(vv_object **root, const vvi_trail *trail, const vv_property_context *context)
{
    vv_object *made = NULL;
    const vv_status st = vv_object_new(&made, class_at(trail, *root), context);
    return st == VV_OK ? swap_root(root, trail, trail->n, made) : st;
}

vv_status vv_path_unset(vv_object **root, const char *path, const vv_property_context *context)
{
    vvi_trail trail;
    const vvi_place place = {.name = path};
    const vvi_reading reading = {.context = vvi_context_or_empty(context)};
    vv_status st = vvi_trail_find(&trail, *root, path);
    if (st != VV_OK)
        return st;
    if (trail.n && last_hop(&trail)->entry && last_hop(&trail)->property->kind != VV_KIND_VARIANTS)
        return vv_path_remove(root, path, context);
    if (class_at(&trail, *root))
        return reset_object(root, &trail, context);
    json_t *null = json_null(); /* a constant of jansson: not counted */
    return set_property(root, &trail, null, &reading, &place);
}

/* At the end of a table. */
static vv_status add_row(vv_object **root, const vvi_trail *trail, const char *text, const vvi_reading *reading,
                         const vvi_place *place)
{
    char *rows = NULL;
    json_t *all = NULL, *row = NULL;
    vv_status st = vv_path_get(&rows, *root, trail->path);
    if (st == VV_OK && (st = vvi_json_parse(&all, rows, strlen(rows), place)) == VV_OK)
        st = vvi_json_parse_typed(&row, text, VV_KIND_NUMBERS, place);
    if (st == VV_OK && !json_is_array(all)) { /* null: nobody has set it */
        json_decref(all);
        all = json_array();
    }
    if (st == VV_OK && json_array_append(all, row))
        st = vv_fail_memory(strlen(text));
    if (st == VV_OK)
        st = set_property(root, trail, all, reading, place);
    json_decref(row);
    json_decref(all);
    free(rows);
    return st;
}

vv_status vv_path_add(vv_object **root, const char *path, const char *id, const char *json,
                      const vv_property_context *context)
{
    vvi_trail trail;
    const vvi_place place = {.name = path};
    const vvi_reading reading = {.context = vvi_context_or_empty(context)};
    vv_status st = vvi_trail_find(&trail, *root, path);
    if (st != VV_OK)
        return st;
    const vvi_hop *last = trail.n ? last_hop(&trail) : NULL;
    const vv_type_kind kind = last && !last->entry ? last->property->kind : VV_KIND_OBJECT;
    if (kind == VV_KIND_NUMBERS && last->property->columns > 1 && !id && json)
        return add_row(root, &trail, json, &reading, &place);
    if (kind != VV_KIND_LIST && kind != VV_KIND_MAP)
        return vvi_fail_place(&place, VV_E_ARGUMENT, "entries can be added only to lists and maps; this is neither");
    if ((kind == VV_KIND_LIST) != !id)
        return vvi_fail_place(&place, VV_E_ARGUMENT, id ? "entries of a list have no name" : "an entry needs a name");
    const vv_collection *collection = vvi_collection_of(last->owner, last->property);
    if (id && strchr(id, '.'))
        return vvi_fail_place(&place, VV_E_ARGUMENT, "'%.80s' is not a valid name: it must not contain a dot", id);
    if (id && vv_collection_find(collection, id))
        return vvi_fail_place(&place, VV_E_ARGUMENT, "'%s' already exists", id);
    char *entry = id ? vvi_asprintf("%s.%s", path, id) : vvi_asprintf("%s.%zu", path, collection->n);
    if (!entry)
        return vv_fail_memory(strlen(path) + VVI_ID_MOST);
    st = vv_path_set(root, entry, json ? json : "{}", context);
    free(entry);
    return st;
}

static vv_status remove_entry(vv_object **root, const vvi_trail *trail)
{
    vv_object *fresh = NULL;
    vv_collection *made = NULL;
    const vvi_hop *last = last_hop(trail);
    vv_status st = vvi_object_copy(&fresh, last->owner);
    if (st != VV_OK)
        return st;
    st = vvi_collection_splice(&made, vvi_collection_of(fresh, last->property), last->index, 1, NULL, NULL);
    if (st != VV_OK) {
        vv_object_release(fresh);
        return st;
    }
    vvi_value_drop(fresh, last->property);
    *(vv_collection **)vvi_slot(fresh, last->property) = made;
    return swap_owner(root, trail, fresh);
}

vv_status vv_path_remove(vv_object **root, const char *path, const vv_property_context *context)
{
    vvi_trail trail;
    const vvi_place place = {.name = path};
    (void)context;
    vv_status st = vvi_trail_find(&trail, *root, path);
    if (st != VV_OK)
        return st;
    if (!trail.n || !last_hop(&trail)->entry || last_hop(&trail)->property->kind == VV_KIND_VARIANTS)
        return vvi_fail_place(&place, VV_E_ARGUMENT, "only entries of lists and maps can be removed; unset it instead");
    if (!last_hop(&trail)->object)
        return vvi_trail_fail_absent(&trail);
    return remove_entry(root, &trail);
}

vv_status vv_path_put(vv_object **root, const char *path, vv_object *object, const vv_property_context *context)
{
    vvi_trail trail;
    const vvi_place place = {.name = path};
    (void)context;
    vv_status st = vvi_trail_find(&trail, *root, path);
    if (st != VV_OK)
        return st;
    const vv_class *cls = class_at(&trail, *root);
    if (cls != object->cls)
        return vvi_fail_place(&place, VV_E_ARGUMENT, "expected %s, found an object of class %s",
                              cls ? cls->name : "a plain value", object->cls->name);
    if (trail.n && last_hop(&trail)->entry && (st = check_new_entry(last_hop(&trail), &place)) != VV_OK)
        return st;
    return swap_root(root, &trail, trail.n, vv_object_retain(object));
}

/* Copying one path from another root ---------------------------------------------------------------------------- */

/* The place in `to` of the last entry before `before` in `from` that `to` has as well; SIZE_MAX: there is none. */
static size_t anchor(const vv_collection *to, const vv_collection *from, size_t before)
{
    while (before-- > 0) {
        const size_t at = vvi_collection_index(to, from->entry[before].id);
        if (at < to->n)
            return at;
    }
    return SIZE_MAX;
}

/* Whether an entry of both stands after the same common entries in both. */
static bool in_order(const vv_collection *to, size_t at, const vv_collection *from, size_t from_at)
{
    size_t before = at;
    while (before > 0 && vvi_collection_index(from, to->entry[before - 1].id) == from->n)
        before--;
    return (before ? before - 1 : SIZE_MAX) == anchor(to, from, from_at);
}

/* A map with the entry that `from` has under this id, at the place it has there among those that both have. */
static vv_status place_entry(vv_collection **out, const vv_collection *to, const vv_collection *from, size_t from_at)
{
    const vv_entry *entry = &from->entry[from_at];
    const size_t at = vvi_collection_index(to, entry->id);
    if (at < to->n && in_order(to, at, from, from_at))
        return vvi_collection_splice(out, to, at, 1, entry->id, entry->object);
    vv_collection *without = vvi_collection_retain(to);
    vv_status st = VV_OK;
    if (at < to->n) {
        vvi_collection_release(without);
        st = vvi_collection_splice(&without, to, at, 1, NULL, NULL);
    }
    if (st == VV_OK) {
        const size_t after = anchor(without, from, from_at);
        st = vvi_collection_splice(out, without, after == SIZE_MAX ? 0 : after + 1, 0, entry->id, entry->object);
    }
    vvi_collection_release(without);
    return st;
}

static vv_status copy_map_entry(vv_object **root, const vvi_trail *to, const vvi_trail *from)
{
    vv_object *fresh = NULL;
    vv_collection *made = NULL;
    const vvi_hop *last = last_hop(to), *source = last_hop(from);
    vv_status st = vvi_object_copy(&fresh, last->owner);
    if (st == VV_OK)
        st = place_entry(&made, vvi_collection_of(last->owner, last->property),
                         vvi_collection_of(source->owner, source->property), source->index);
    if (st != VV_OK) {
        vv_object_release(fresh);
        return st;
    }
    vvi_value_drop(fresh, last->property);
    *(vv_collection **)vvi_slot(fresh, last->property) = made;
    return swap_owner(root, to, fresh);
}

static vv_status copy_value(vv_object **root, const vvi_trail *to, const vv_object *source)
{
    vv_object *fresh = NULL;
    const vv_property *p = last_hop(to)->property;
    vv_status st = vvi_object_copy(&fresh, last_hop(to)->owner);
    if (st != VV_OK)
        return st;
    if (last_hop(to)->member) {
        st = vvi_members_share_one(fresh, source, p, last_hop(to)->member);
        if (st == VV_OK)
            return swap_root(root, to, to->n - 1, fresh);
        vv_object_release(fresh);
        return st;
    }
    vvi_value_drop(fresh, p);
    st = vvi_value_share(fresh, source, p);
    if (st == VV_OK)
        st = vvi_extra_share(fresh, source, p->name);
    if (st != VV_OK) {
        vv_object_release(fresh);
        return st;
    }
    vvi_set_mark(fresh, p, source->set >> vvi_property_index(source->cls, p) & 1);
    return swap_root(root, to, to->n - 1, fresh);
}

/* The source has nothing at the path, not even what should hold it. */
static vv_status copy_nothing(vv_object **root, const vvi_trail *to, const vv_property_context *context)
{
    const vvi_hop *last = last_hop(to);
    if (last->entry && !last->object)
        return VV_OK;
    return vv_path_unset(root, to->path, context);
}

vv_status vv_path_copy(vv_object **root, const vv_object *source, const char *path, const vv_property_context *context)
{
    vvi_trail to, from;
    vv_status st = vvi_trail_find(&to, *root, path);
    if (st == VV_E_NOT_FOUND && vvi_trail_find(&from, source, path) == VV_E_NOT_FOUND)
        return VV_OK; /* absent in both */
    if (st != VV_OK)
        return vvi_trail_find(&to, *root, path); /* the error again: looking into the source may have made another */
    if (!to.n)
        return swap_root(root, &to, 0, vv_object_retain(source));
    if (vvi_trail_find(&from, source, path) != VV_OK || (last_hop(&from)->entry && !last_hop(&from)->object))
        return copy_nothing(root, &to, context);
    const vvi_hop *last = last_hop(&to), *there = last_hop(&from);
    if (last->entry && last->property->kind == VV_KIND_MAP)
        return copy_map_entry(root, &to, &from);
    if (there->object)
        return swap_root(root, &to, to.n, vv_object_retain(there->object));
    return copy_value(root, &to, there->owner);
}
