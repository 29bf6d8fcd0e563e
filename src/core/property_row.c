/* Where a property path leads, followed through the classes alone. */
#include "core/property_impl.h"
#include <stdio.h>
#include <string.h>

enum { MAX_PART = 128, MAX_NAMES = 128 };

typedef struct walk {
    const vv_property_context *context;
    const vv_class *cls;    /* of the object that we stand on; NULL: on a collection or a plain value */
    const vv_property *row; /* the last one taken */
    const char *path;
} walk;

static const vv_class *variant_class(const walk *w, const char *table, const char *name)
{
    const vv_class *cls;
    const char *row_name;
    if (!w->context || !w->context->variant)
        return NULL;
    for (size_t i = 0; (cls = w->context->variant(w->context->user, table, i, &row_name)); i++) {
        if (strcmp(row_name, name) == 0)
            return cls;
    }
    return NULL;
}

static size_t variant_names(const char **names, size_t room, const walk *w, const char *table)
{
    size_t n = 0;
    const char *row_name;
    if (!w->context || !w->context->variant)
        return 0;
    while (n < room && w->context->variant(w->context->user, table, n, &row_name))
        names[n++] = row_name;
    return n;
}

static vv_status fail_part(const walk *w, const char *part)
{
    const char *names[MAX_NAMES];
    size_t n = 0;
    for (const vv_property *row = w->cls->properties; row->name && n < MAX_NAMES; row++) {
        names[n++] = row->name;
        if (row->kind == VV_KIND_VARIANTS)
            n += variant_names(names + n, MAX_NAMES - n, w, row->table);
    }
    return vvi_fail_name(VV_E_NOT_FOUND, NULL, w->path, part, &(vvi_known){names, n, NULL, NULL},
                         "%s has no property '%s'", w->cls->name, part);
}

static vv_status fail_variant(const walk *w, const char *part)
{
    const char *names[MAX_NAMES];
    const size_t n = variant_names(names, MAX_NAMES, w, w->row->table);
    return vvi_fail_name(VV_E_NOT_FOUND, NULL, w->path, part, &(vvi_known){names, n, NULL, NULL}, "no '%s' in %s", part,
                         w->row->name);
}

/* A renderer's parameters stand directly below the object that keeps them. */
static bool step_to_variant(walk *w, const char *part)
{
    for (const vv_property *row = w->cls->properties; row->name; row++) {
        const vv_class *cls = row->kind == VV_KIND_VARIANTS ? variant_class(w, row->table, part) : NULL;
        if (cls) {
            w->row = row;
            w->cls = cls;
            return true;
        }
    }
    return false;
}

static vv_status step(walk *w, const char *part)
{
    if (!w->cls && !w->row)
        return vv_fail_at(VV_E_NOT_FOUND, NULL, w->path, "no such path");
    if (!w->cls && (w->row->kind == VV_KIND_MAP || w->row->kind == VV_KIND_LIST)) {
        w->cls = w->row->cls;
        return VV_OK;
    }
    if (!w->cls && w->row->kind == VV_KIND_VARIANTS) {
        w->cls = variant_class(w, w->row->table, part);
        return w->cls ? VV_OK : fail_variant(w, part);
    }
    if (!w->cls && w->row->kind == VV_KIND_MEMBERS) /* what has members of its own says itself which */
        return VV_OK;
    if (!w->cls)
        return vv_fail_at(VV_E_NOT_FOUND, NULL, w->path, "'%s' is a value and has no part '%s'", w->row->name, part);
    const vv_property *row = vv_class_find(w->cls, part);
    if (!row)
        return step_to_variant(w, part) ? VV_OK : fail_part(w, part);
    w->row = row;
    w->cls = row->kind == VV_KIND_OBJECT ? row->cls : NULL;
    return VV_OK;
}

vv_status vv_path_row(const vv_property **row_out, const vv_class **cls_out, const vv_class *root, const char *path,
                      const vv_property_context *context)
{
    walk w = {.context = context, .cls = root, .path = path};
    vv_status st = VV_OK;
    for (const char *at = path; *at && st == VV_OK;) {
        char part[MAX_PART];
        const size_t n = strcspn(at, ".");
        snprintf(part, sizeof part, "%.*s", (int)n, at);
        st = step(&w, part);
        at += n + (at[n] == '.');
    }
    *row_out = w.row;
    *cls_out = w.cls;
    if (st == VV_OK && !w.cls && w.row && (w.row->kind == VV_KIND_MAP || w.row->kind == VV_KIND_LIST))
        *cls_out = w.row->cls;
    return st;
}
