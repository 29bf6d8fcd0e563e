/* Rows of the tables by name, with the nearest real name where there is none. */
#include "core/status.h"
#include "registry.h"
#include <string.h>

/* More rows than any table has: names past it are found, but not proposed. */
enum { PROPOSED = 256 };

static const vv_registry *or_builtin(const vv_registry *registry)
{
    return registry ? registry : vv_registry_builtin();
}

static void fail_unknown(const char *kind, const char *list_verb, const char *name, const char *const *names, size_t n)
{
    const char *near = vv_nearest_name(name, names, n);
    if (near)
        vv_fail(VV_E_NOT_FOUND, "no %s '%s'; did you mean '%s'?", kind, name, near);
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
