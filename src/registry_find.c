/* Rows of the tables by name, with the nearest real name where there is none. */
#include "core/status.h"
#include "core/text.h"
#include "registry.h"
#include <string.h>

/* More rows than any table has: names past it are found, but not proposed. */
enum { PROPOSED = 256 };
enum { LISTED = 8 }; /* so few are named in a sentence */

static const vv_registry *or_builtin(const vv_registry *registry)
{
    return registry ? registry : vv_registry_builtin();
}

static void fail_listed(const char *kind, const char *name, const char *const *names, size_t n)
{
    vvi_text list = {0};
    for (size_t i = 0; i < n; i++)
        vvi_text_printf(&list, "%s%s", i == 0 ? "" : i + 1 < n ? ", " : " and ", names[i]);
    vv_fail(VV_E_NOT_FOUND, "no %s '%s'; there are %s", kind, name, list.s && !list.bad ? list.s : "none");
    vvi_text_free(&list);
}

static void fail_unknown(const char *kind, const char *list_verb, const char *name, const char *const *names, size_t n)
{
    const char *near = vv_nearest_name(name, names, n);
    if (near)
        vv_fail(VV_E_NOT_FOUND, "no %s '%s'; did you mean '%s'?", kind, name, near);
    else if (n <= LISTED)
        fail_listed(kind, name, names, n);
    else
        vv_fail(VV_E_NOT_FOUND, "no %s '%s'; 'volvis %s' lists those there are", kind, name, list_verb);
}

const vv_format *vv_registry_format(const vv_registry *registry, const char *name)
{
    const char *names[PROPOSED];
    size_t n = 0;
    for (const vv_format *const *row = or_builtin(registry)->formats; *row; row++) {
        if (strcmp((*row)->name, name) == 0)
            return *row;
        if (n < PROPOSED)
            names[n++] = (*row)->name;
    }
    fail_unknown("format", "formats", name, names, n);
    return NULL;
}

const vv_operation *vv_registry_operation(const vv_registry *registry, const char *name)
{
    const char *names[PROPOSED];
    size_t n = 0;
    for (const vv_operation *const *row = or_builtin(registry)->operations; *row; row++) {
        if (strcmp((*row)->name, name) == 0)
            return *row;
        if (n < PROPOSED)
            names[n++] = (*row)->name;
    }
    fail_unknown("operation", "operations", name, names, n);
    return NULL;
}

const vv_renderer *vv_registry_renderer(const vv_registry *registry, const char *name)
{
    const char *names[PROPOSED];
    size_t n = 0;
    for (const vv_renderer *const *row = or_builtin(registry)->renderers; *row; row++) {
        if (strcmp((*row)->name, name) == 0)
            return *row;
        if (n < PROPOSED)
            names[n++] = (*row)->name;
    }
    fail_unknown("method", "methods", name, names, n);
    return NULL;
}
