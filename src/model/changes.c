/* Two Worlds that share what was not edited, compared: only what is not the same object is looked at. */
#include "model/changes.h"
#include "core/property_impl.h"
#include <stdio.h>
#include <string.h>

/* So many entries of a map that came or went one by one; past it the whole map is told. */
enum { ENTRIES_MOST = 64, PATH_ROOM = 1024 };

typedef struct telling {
    vvi_json json;
    char path[PATH_ROOM]; /* of what is looked at */
    size_t n;
    size_t most;
} telling;

static bool is_full(const telling *t)
{
    return t->json.text.n > t->most;
}

/* Steps ------------------------------------------------------------------------------------------------------------ */

/* One step down; where the path was before, for step_up(). A path that is too long ends the telling. */
static size_t step_down(telling *t, const char *name)
{
    const size_t before = t->n;
    const int n = snprintf(t->path + t->n, PATH_ROOM - t->n, "%s%s", t->n ? "." : "", name);
    t->n += (size_t)n;
    if (t->n >= PATH_ROOM) {
        t->n = before;
        t->most = 0;
    }
    return before;
}

static size_t step_into(telling *t, size_t index)
{
    char name[24];
    snprintf(name, sizeof name, "%zu", index);
    return step_down(t, name);
}

static void step_up(telling *t, size_t before)
{
    t->n = before;
    t->path[before] = 0;
}

/* Changes ---------------------------------------------------------------------------------------------------------- */

static void begin(telling *t, const char *op)
{
    vvi_json_item(&t->json);
    vvi_json_open(&t->json, '{');
    vvi_json_key(&t->json, "op");
    vvi_json_string(&t->json, op);
    vvi_json_key(&t->json, "path");
    vvi_json_string(&t->json, t->path);
}

static void end(telling *t)
{
    vvi_json_close(&t->json, '}');
}

static void put_object(telling *t, const vv_object *object)
{
    vvi_json_key(&t->json, "value");
    vvi_json_open(&t->json, '{');
    vvi_json_members(&t->json, object);
    vvi_json_close(&t->json, '}');
}

static void tell_unset(telling *t, const char *name)
{
    const size_t before = step_down(t, name);
    begin(t, "unset");
    end(t);
    step_up(t, before);
}

static void tell_set(telling *t, const vv_object *object, const vv_property *p)
{
    const size_t before = step_down(t, p->name);
    begin(t, "set");
    vvi_json_key(&t->json, "value");
    vvi_json_value(&t->json, object, p);
    end(t);
    step_up(t, before);
}

static void tell_object(telling *t, const char *name, const vv_object *object)
{
    const size_t before = step_down(t, name);
    begin(t, "set");
    put_object(t, object);
    end(t);
    step_up(t, before);
}

static void tell_add(telling *t, const vv_entry *entry, const char *after)
{
    begin(t, "add");
    vvi_json_key(&t->json, "id");
    vvi_json_string(&t->json, entry->id);
    vvi_json_key(&t->json, "after");
    vvi_json_string(&t->json, after);
    put_object(t, entry->object);
    end(t);
}

static void tell_remove(telling *t, const char *id)
{
    const size_t before = step_down(t, id);
    begin(t, "remove");
    end(t);
    step_up(t, before);
}

/* Maps and lists --------------------------------------------------------------------------------------------------- */

static void compare(telling *t, const vv_object *from, const vv_object *to);

static bool has(const vv_collection *all, const char *id)
{
    return vvi_collection_index(all, id) < all->n;
}

/* What came and went, in the order of the newer map; false: entries have changed places, or too many have come and
 * gone. */
static bool compare_entries(telling *t, const vv_collection *from, const vv_collection *to)
{
    size_t i = 0, j = 0, n = 0;
    while ((i < from->n || j < to->n) && !is_full(t)) {
        const vv_entry *old = i < from->n ? &from->entry[i] : NULL, *new = j < to->n ? &to->entry[j] : NULL;
        if (old && new &&strcmp(old->id, new->id) == 0) {
            const size_t before = step_down(t, new->id);
            compare(t, old->object, new->object);
            step_up(t, before);
            i++;
            j++;
        } else if (n++ == ENTRIES_MOST) {
            return false;
        } else if (old && !has(to, old->id)) {
            tell_remove(t, old->id);
            i++;
        } else if (new && !has(from, new->id)) {
            tell_add(t, new, j ? to->entry[j - 1].id : NULL);
            j++;
        } else {
            return false;
        }
    }
    return true;
}

static void compare_maps(telling *t, const vv_object *to, const vv_property *p, const vv_collection *a,
                         const vv_collection *b)
{
    const size_t n = t->json.text.n;
    const bool fresh = t->json.fresh;
    const size_t before = step_down(t, p->name);
    const bool told = compare_entries(t, a, b);
    step_up(t, before);
    if (told || is_full(t))
        return;
    vvi_text_cut(&t->json.text, n); /* as if nothing had been told of its entries */
    t->json.fresh = fresh;
    tell_set(t, to, p);
}

static void compare_lists(telling *t, const vv_object *to, const vv_property *p, const vv_collection *a,
                          const vv_collection *b)
{
    if (a->n != b->n) {
        tell_set(t, to, p);
        return;
    }
    const size_t before = step_down(t, p->name);
    for (size_t i = 0; i < a->n && !is_full(t); i++) {
        const size_t list = step_into(t, i);
        compare(t, a->entry[i].object, b->entry[i].object);
        step_up(t, list);
    }
    step_up(t, before);
}

/* They stand among the members of their owner. */
static void compare_variants(telling *t, const vv_collection *a, const vv_collection *b)
{
    for (size_t i = 0; i < b->n; i++) {
        const vv_object *from = vv_collection_find(a, b->entry[i].id), *to = b->entry[i].object;
        const bool was = from && from != to && vvi_object_has_content(from), is = vvi_object_has_content(to);
        if (from == to || (!was && !is))
            continue;
        if (!was) {
            tell_object(t, b->entry[i].id, to);
        } else if (!is) {
            tell_unset(t, b->entry[i].id);
        } else {
            const size_t before = step_down(t, b->entry[i].id);
            compare(t, from, to);
            step_up(t, before);
        }
    }
}

/* Objects ---------------------------------------------------------------------------------------------------------- */

static void compare_set(telling *t, const vv_object *from, const vv_object *to, const vv_property *p)
{
    const bool deep = p->kind == VV_KIND_LIST || p->kind == VV_KIND_MAP;
    const vv_collection *a = deep ? vvi_collection_of(from, p) : NULL, *b = deep ? vvi_collection_of(to, p) : NULL;
    if (p->kind == VV_KIND_OBJECT) {
        const size_t before = step_down(t, p->name);
        compare(t, vvi_object_of(from, p), vvi_object_of(to, p));
        step_up(t, before);
    } else if (deep && a != b) {
        (p->kind == VV_KIND_MAP ? compare_maps : compare_lists)(t, to, p, a, b);
    } else if (!deep && !vvi_value_equal(from, to, p)) {
        tell_set(t, to, p);
    }
}

static void compare_property(telling *t, const vv_object *from, const vv_object *to, const vv_property *p)
{
    if (p->kind == VV_KIND_VARIANTS) {
        compare_variants(t, vvi_collection_of(from, p), vvi_collection_of(to, p));
        return;
    }
    const bool was = vvi_property_is_set(from, p), is = vvi_property_is_set(to, p);
    if (was && is)
        compare_set(t, from, to, p);
    else if (is)
        tell_set(t, to, p);
    else if (was)
        tell_unset(t, p->name);
}

/* What a newer schema says stands among the members too. */
static bool same_extra(const vv_object *from, const vv_object *to)
{
    return from->extra == to->extra || json_equal(from->extra, to->extra);
}

static void compare(telling *t, const vv_object *from, const vv_object *to)
{
    if (from == to || is_full(t))
        return;
    if (from->cls != to->cls || !same_extra(from, to)) {
        begin(t, "set");
        put_object(t, to);
        end(t);
        return;
    }
    for (const vv_property *p = to->cls->properties; p->name && !is_full(t); p++)
        compare_property(t, from, to, p);
}

vv_status vvi_world_changes(char **out, const vv_world *from, const vv_world *to, size_t most)
{
    telling t = {.most = most};
    vv_object *a = NULL, *b = NULL;
    *out = NULL;
    vv_status st = vvi_world_with_schema(&a, from);
    if (st == VV_OK)
        st = vvi_world_with_schema(&b, to);
    vvi_json_open(&t.json, '[');
    if (st == VV_OK && from != to)
        compare(&t, a, b);
    vvi_json_close(&t.json, ']');
    vv_object_release(a);
    vv_object_release(b);
    const size_t n = t.json.text.n;
    if (st == VV_OK && n <= t.most && !(*out = vvi_text_take(&t.json.text)))
        return vv_fail_memory(n);
    vvi_text_free(&t.json.text);
    return st;
}
