/* Rows of the tables by name, with the nearest real name where there is none. */
#include "core/names.h"
#include "registry.h"
#include <string.h>

/* More rows than any table has: names past it are found, but not proposed. */
enum { PROPOSED = 256 };

static const vv_registry *or_builtin(const vv_registry *registry)
{
    return registry ? registry : vv_registry_builtin();
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
    vvi_fail_name(VV_E_NOT_FOUND, NULL, NULL, name, &(vvi_known){names, n, "volvis formats", NULL}, "no format '%s'",
                  name);
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
    vvi_fail_name(VV_E_NOT_FOUND, NULL, NULL, name, &(vvi_known){names, n, "volvis operations", NULL},
                  "no operation '%s'", name);
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
    vvi_fail_name(VV_E_NOT_FOUND, NULL, NULL, name, &(vvi_known){names, n, "volvis methods", NULL}, "no method '%s'",
                  name);
    return NULL;
}

const vv_renderer *vv_registry_renderer_for(const vv_registry *registry, unsigned contents)
{
    const vv_renderer *const *rows = or_builtin(registry)->renderers, *first = NULL;
    for (const vv_renderer *const *row = rows; *row; row++) {
        if (contents && (*row)->best_for == contents && ((*row)->takes & contents) == contents)
            return *row;
        if (!first && ((*row)->takes & contents) == contents)
            first = *row;
    }
    return first ? first : rows[0];
}

const vv_renderer *vv_registry_plane_renderer(const vv_registry *registry)
{
    const vv_renderer *const *row = or_builtin(registry)->renderers;
    while (*row && !(*row)->plane)
        row++;
    return *row;
}
