/* Actions that name an operation, a method of drawing, or a preset. */
#include "input/bindings_impl.h"

#include <stdlib.h>
#include <string.h>
#include <volvis/render.h>
#include <volvis/sys/registry.h>

enum { NAMES_MOST = 512 };

static const char *operation_name(const vv_registry *registry, size_t index)
{
    return registry->operations && registry->operations[index] ? registry->operations[index]->name : NULL;
}

static const char *renderer_name(const vv_registry *registry, size_t index)
{
    return registry->renderers && registry->renderers[index] ? registry->renderers[index]->name : NULL;
}

static const char *preset_name(const vv_registry *registry, size_t index)
{
    const vv_preset *preset = vv_preset_nth(index);
    (void)registry;
    return preset ? preset->name : NULL;
}

static const struct {
    const char *kind, *prefix;
    const char *(*name)(const vv_registry *registry, size_t index);
} kinds[] = {
    {"operation", "operation-", operation_name},
    {"renderer", "renderer-", renderer_name},
    {"preset", "preset-", preset_name},
};

static vv_status check_among(const char *name, size_t kind, const vv_registry *registry)
{
    const char *names[NAMES_MOST];
    size_t n = 0;
    for (; n < NAMES_MOST && (names[n] = kinds[kind].name(registry, n)) != NULL; n++)
        if (strcmp(names[n], name) == 0)
            return VV_OK;
    const char *near = vv_nearest_name(name, names, n);
    return vv_fail_at(VV_E_ARGUMENT, NULL, "action", "there is no %s \"%.40s\"%s%s", kinds[kind].kind, name,
                      near ? "; the nearest is " : "", near ? near : "");
}

vv_status vvi_action_check_name(const char *action, const vv_registry *registry)
{
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; i++) {
        const size_t n = strlen(kinds[i].prefix);
        if (strncmp(action, kinds[i].prefix, n) == 0)
            return check_among(action + n, i, registry);
    }
    return VV_OK;
}
