/* Paths: from "views.main.camera.fov" to the property, and what stands there. */
#include "core/property_impl.h"
#include <string.h>

/* A cursor over the parts of a path. */
typedef struct walk {
    vvi_trail *trail;
    const vv_object *object; /* where we stand; NULL: nothing is below */
    const char *rest;
    char part[VVI_ID_MOST + 1];
} walk;

/* An error at the part that was just taken. */
static vvi_place place_here(const walk *w, char *out, size_t room)
{
    const size_t n = (size_t)(w->rest - w->trail->path);
    snprintf(out, room, "%.*s", (int)(n < room ? n : room - 1), w->trail->path);
    return (vvi_place){.name = out};
}

static vv_status take_part(walk *w)
{
    const size_t n = strcspn(w->rest, ".");
    char shown[256];
    if (n == 0 || n > VVI_ID_MOST) {
        const vvi_place place = place_here(w, shown, sizeof shown);
        return vvi_fail_place(&place, VV_E_ARGUMENT, n ? "the name '%.64s...' is too long" : "a name is missing",
                              w->rest);
    }
    memcpy(w->part, w->rest, n);
    w->part[n] = 0;
    w->rest += n;
    return VV_OK;
}

/* Past the dot to the next part; false at the end. */
static bool more(walk *w)
{
    if (*w->rest != '.')
        return false;
    w->rest++;
    return true;
}

static bool parse_index(size_t *out, const char *text)
{
    const size_t n = strspn(text, "0123456789");
    if (!n || text[n] || n > 6)
        return false;
    *out = strtoul(text, NULL, 10);
    return true;
}

static vv_status take_entry(walk *w, vvi_hop *hop)
{
    char shown[256];
    const vv_collection *collection = vvi_collection_of(hop->owner, hop->property);
    const bool list = hop->property->kind == VV_KIND_LIST;
    vv_status st = take_part(w);
    if (st != VV_OK)
        return st;
    const vvi_place place = place_here(w, shown, sizeof shown);
    hop->entry = true;
    memcpy(hop->id, w->part, sizeof hop->id);
    if (list && !parse_index(&hop->index, w->part))
        return vvi_fail_place(&place, VV_E_ARGUMENT, "expected the index of a list entry, found '%s'", w->part);
    if (!list)
        hop->index = vvi_collection_index(collection, w->part);
    if (hop->index < collection->n) {
        hop->object = collection->entry[hop->index].object;
        return VV_OK;
    }
    if (*w->rest != '.')
        return VV_OK;
    if (list)
        return vvi_fail_place(&place, VV_E_NOT_FOUND, "the list has %zu entries, counted from 0", collection->n);
    return vvi_fail_unknown_entry(&place, collection, w->part);
}

/* The last part: members are values. */
static vv_status take_member(walk *w, vvi_hop *hop)
{
    char shown[256];
    hop->member = w->rest;
    const vv_status st = take_part(w);
    const vvi_place place = place_here(w, shown, sizeof shown);
    return st == VV_OK && *w->rest
               ? vvi_fail_place(&place, VV_E_ARGUMENT, "'%s' is a plain value: it has no properties", w->part)
               : st;
}

static bool find_variant(vvi_hop *hop, const char *name)
{
    for (const vv_property *p = hop->owner->cls->properties; p->name; p++) {
        if (p->kind != VV_KIND_VARIANTS)
            continue;
        const vv_collection *variants = vvi_collection_of(hop->owner, p);
        hop->index = vvi_collection_index(variants, name);
        if (hop->index == variants->n)
            continue;
        hop->property = p;
        hop->entry = true;
        hop->object = variants->entry[hop->index].object;
        return true;
    }
    return false;
}

static vv_status take_hop(walk *w, vvi_hop *hop)
{
    char shown[256];
    *hop = (vvi_hop){.owner = w->object};
    hop->start = (size_t)(w->rest - w->trail->path);
    vv_status st = take_part(w);
    if (st != VV_OK)
        return st;
    const vvi_place place = place_here(w, shown, sizeof shown);
    hop->property = vv_class_find(hop->owner->cls, w->part);
    if (!hop->property) {
        memcpy(hop->id, w->part, sizeof hop->id);
        return find_variant(hop, w->part) ? VV_OK : vvi_fail_unknown_property(&place, hop->owner, w->part);
    }
    if (hop->property->kind == VV_KIND_OBJECT)
        hop->object = vvi_object_of(hop->owner, hop->property);
    else if (vvi_kind_is_collection(hop->property->kind))
        return more(w) ? take_entry(w, hop) : VV_OK;
    else if (hop->property->kind == VV_KIND_MEMBERS)
        return more(w) ? take_member(w, hop) : VV_OK;
    else if (*w->rest)
        return vvi_fail_place(&place, VV_E_ARGUMENT, "'%s' is a plain value: it has no properties", w->part);
    return VV_OK;
}

vv_status vvi_trail_find(vvi_trail *out, const vv_object *root, const char *path)
{
    char shown[256];
    walk w = {.trail = out, .object = root, .rest = path};
    out->path = path;
    out->n = 0;
    if (!*path)
        return VV_OK;
    do {
        if (out->n == VVI_HOPS_MOST) {
            const vvi_place place = place_here(&w, shown, sizeof shown);
            return vvi_fail_place(&place, VV_E_LIMIT, "the path is too deep");
        }
        vvi_hop *hop = &out->hop[out->n++];
        const vv_status st = take_hop(&w, hop);
        if (st != VV_OK)
            return st;
        w.object = hop->object;
    } while (more(&w));
    return VV_OK;
}

void vvi_trail_owner_path(char *out, size_t room, const vvi_trail *trail)
{
    const size_t start = trail->n ? trail->hop[trail->n - 1].start : 0;
    const size_t n = start ? start - 1 : 0; /* without the dot */
    snprintf(out, room, "%.*s", (int)(n < room ? n : room - 1), trail->path);
}

vv_status vvi_trail_fail_absent(const vvi_trail *trail)
{
    const vvi_hop *hop = &trail->hop[trail->n - 1];
    const vvi_place place = {.name = trail->path};
    const vv_collection *collection = vvi_collection_of(hop->owner, hop->property);
    if (hop->property->kind == VV_KIND_LIST)
        return vvi_fail_place(&place, VV_E_NOT_FOUND, "the list has %zu entries, counted from 0", collection->n);
    return vvi_fail_unknown_entry(&place, collection, hop->id);
}

/* The object that a trail leads to. */
static vv_status object_at(const vv_object **out, const vvi_trail *trail, const vv_object *root)
{
    const vvi_hop *last = trail->n ? &trail->hop[trail->n - 1] : NULL;
    const vvi_place place = {.name = trail->path};
    *out = last ? last->object : root;
    if (*out || !last)
        return VV_OK;
    if (last->entry)
        return vvi_trail_fail_absent(trail);
    return vvi_fail_place(&place, VV_E_NOT_FOUND, "'%s' is not an object", last->property->name);
}

const vv_object *vv_path_object(const vv_object *root, const char *path)
{
    vvi_trail trail;
    const vv_object *object = NULL;
    if (vvi_trail_find(&trail, root, path) != VV_OK || object_at(&object, &trail, root) != VV_OK)
        return NULL;
    return object;
}

vv_status vv_path_get(char **json_out, const vv_object *root, const char *path)
{
    vvi_trail trail;
    vvi_json json = {0};
    *json_out = NULL;
    vv_status st = vvi_trail_find(&trail, root, path);
    if (st != VV_OK)
        return st;
    const vvi_hop *last = trail.n ? &trail.hop[trail.n - 1] : NULL;
    if (!last || last->entry || last->object) {
        const vv_object *object = NULL;
        st = object_at(&object, &trail, root);
        return st == VV_OK ? vv_object_to_json(json_out, object, 0) : st;
    }
    if (last->member)
        vvi_members_print_one(&json, last->owner, last->property, last->member);
    else if (last->property->automatic && !vvi_property_is_set(last->owner, last->property))
        vvi_text_add(&json.text, "null");
    else
        vvi_json_value(&json, last->owner, last->property);
    *json_out = vvi_text_take(&json.text);
    return *json_out ? VV_OK : vv_fail_memory(1);
}

/* Visiting everything ------------------------------------------------------------------------------------------- */

typedef struct tour {
    vv_path_visit_fn *visit;
    void *user;
    vvi_text path;
} tour;

static bool visit_object(tour *t, const vv_object *object);

/* Adds a name to the path; what it was is restored by cutting back to the returned length. */
static size_t enter(tour *t, const char *name)
{
    const size_t n = t->path.n;
    vvi_text_printf(&t->path, "%s%s", n ? "." : "", name);
    return n;
}

static void leave(tour *t, size_t n)
{
    t->path.n = n;
    if (t->path.s)
        t->path.s[n] = 0;
}

static bool visit_entries(tour *t, const vv_collection *collection)
{
    bool go_on = true;
    for (size_t i = 0; go_on && i < collection->n; i++) {
        char number[24];
        snprintf(number, sizeof number, "%zu", i);
        const size_t n = enter(t, collection->entry[i].id ? collection->entry[i].id : number);
        go_on = visit_object(t, collection->entry[i].object);
        leave(t, n);
    }
    return go_on;
}

static bool visit_property(tour *t, const vv_object *object, const vv_property *p)
{
    if (p->kind == VV_KIND_VARIANTS)
        return visit_entries(t, vvi_collection_of(object, p));
    const size_t n = enter(t, p->name);
    bool go_on = !t->path.bad && t->visit(t->user, t->path.s, p, object);
    if (go_on && p->kind == VV_KIND_OBJECT)
        go_on = visit_object(t, vvi_object_of(object, p));
    else if (go_on && vvi_kind_is_collection(p->kind))
        go_on = visit_entries(t, vvi_collection_of(object, p));
    leave(t, n);
    return go_on;
}

static bool visit_object(tour *t, const vv_object *object)
{
    for (const vv_property *p = object->cls->properties; p->name; p++) {
        if (!visit_property(t, object, p))
            return false;
    }
    return true;
}

bool vv_path_each(const vv_object *root, vv_path_visit_fn *visit, void *user)
{
    tour t = {.visit = visit, .user = user};
    const bool whole = visit_object(&t, root);
    vvi_text_free(&t.path);
    return whole;
}
