/* Paths that name entries of maps and lists by a star or by number: `volumes.*.visible`, `volumes.0.visible`. */
#include "core/memory.h"
#include "core/property_impl.h"
#include <stdlib.h>
#include <string.h>

typedef struct each {
    const vv_object *root;
    vv_path_fn *fn;
    void *user;
} each;

/* The map or list that the first n characters of a path lead to; NULL where that is none. */
static const vv_collection *collection_at(vv_type_kind *kind, const vv_object *root, const char *path, size_t n)
{
    char owner_path[512];
    const vv_property *row = NULL;
    if (n == 0 || n >= sizeof owner_path)
        return NULL;
    memcpy(owner_path, path, n);
    owner_path[n] = 0;
    char *dot = strrchr(owner_path, '.');
    if (dot)
        *dot = 0;
    const vv_object *owner = dot ? vv_path_object(root, owner_path) : root;
    row = owner ? vv_class_find(owner->cls, dot ? dot + 1 : owner_path) : NULL;
    if (!row || (row->kind != VV_KIND_MAP && row->kind != VV_KIND_LIST))
        return NULL;
    *kind = row->kind;
    return vvi_collection_of(owner, row);
}

static vv_status expand(const each *e, const char *path, size_t from);

/* With entry i's own name in place of the part of n characters. */
static vv_status expand_entry(const each *e, const char *path, const char *part, size_t n, vv_type_kind kind,
                              const vv_entry *entry, size_t i)
{
    const int n_before = (int)(part - path);
    char *made = kind == VV_KIND_MAP ? vvi_asprintf("%.*s%s%s", n_before, path, entry->id, part + n)
                                     : vvi_asprintf("%.*s%zu%s", n_before, path, i, part + n);
    if (!made)
        return vv_fail_memory(strlen(path));
    const vv_status st = expand(e, made, (size_t)n_before + strcspn(made + n_before, "."));
    free(made);
    return st;
}

static vv_status expand_star(const each *e, const char *path, const char *star)
{
    vv_type_kind kind = VV_KIND_MAP;
    const size_t n = star == path ? 0 : (size_t)(star - path) - 1;
    const vv_collection *c = collection_at(&kind, e->root, path, n);
    vv_status st = VV_OK;
    if (!c)
        return vv_fail_at(VV_E_ARGUMENT, NULL, path,
                          "a star stands for everything in a map or a list, as in volumes.*.visible=false");
    if (c->n == 0)
        return vv_fail_at(VV_E_NOT_FOUND, NULL, path, "there are no %.*s", (int)n, path);
    for (size_t i = 0; i < c->n && st == VV_OK; i++)
        st = expand_entry(e, path, star, 1, kind, &c->entry[i], i);
    return st;
}

/* Names of maps never begin with a digit: a number is a place. */
static const vv_entry *numbered(const each *e, const char *path, const char *part, size_t n)
{
    vv_type_kind kind = VV_KIND_LIST;
    if (n == 0 || n > 9 || strspn(part, "0123456789") < n || part == path)
        return NULL;
    const vv_collection *c = collection_at(&kind, e->root, path, (size_t)(part - path) - 1);
    const size_t i = strtoul(part, NULL, 10);
    return c && kind == VV_KIND_MAP && i < c->n ? &c->entry[i] : NULL;
}

/* From the part that begins at or after the character `from`. */
static vv_status expand(const each *e, const char *path, size_t from)
{
    for (const char *part = path + from; *part;) {
        part += *part == '.';
        const size_t n = strcspn(part, ".");
        if (n == 1 && *part == '*')
            return expand_star(e, path, part);
        const vv_entry *entry = numbered(e, path, part, n);
        if (entry)
            return expand_entry(e, path, part, n, VV_KIND_MAP, entry, 0);
        part += n;
    }
    return e->fn(e->user, path);
}

vv_status vv_path_expand(const vv_object *root, const char *path, vv_path_fn *fn, void *user)
{
    return expand(&(each){root, fn, user}, path, 0);
}
