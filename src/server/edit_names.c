/* Names in what is edited that the model cannot know, since drawing has them: presets and colour maps. */
#include "scene/colormaps.h"
#include "scene/presets.h"
#include "server/session_impl.h"

#include <stdlib.h>
#include <string.h>
#include <volvis/render.h>

static vv_status check_preset(const char *path, const char *name)
{
    return vvi_preset_find(name, path) ? VV_OK : VV_E_NOT_FOUND;
}

static vv_status check_colormap(const char *path, const char *name)
{
    vv_color first;
    return vv_colormap_sample(&first, name, 0) ? VV_OK : vvi_colormap_fail(path, name);
}

static const struct {
    const char *table;
    vv_status (*check)(const char *path, const char *name);
} tables[] = {{"presets", check_preset}, {"colormaps", check_colormap}};

typedef struct checking {
    const vv_world *world, *before;
    vv_status status;
} checking;

static bool is_as_before(const checking *c, const char *path)
{
    char *now = NULL, *before = NULL;
    const bool same = vv_path_get(&now, &c->world->base, path) == VV_OK &&
                      vv_path_get(&before, &c->before->base, path) == VV_OK && strcmp(now, before) == 0;
    free(now);
    free(before);
    return same;
}

static bool check_name(void *user, const char *path, const vv_property *row, const vv_object *owner)
{
    checking *c = user;
    const char *name;
    if (row->kind != VV_KIND_STRING || !row->table)
        return true;
    memcpy(&name, (const char *)owner + row->offset, sizeof name);
    for (size_t i = 0; name && i < sizeof tables / sizeof *tables; i++)
        if (strcmp(tables[i].table, row->table) == 0 && !is_as_before(c, path))
            c->status = tables[i].check(path, name);
    return c->status == VV_OK;
}

vv_status vvi_session_check_names(const vv_world *world, const vv_world *before)
{
    checking c = {.world = world, .before = before};
    vv_path_each(&world->base, check_name, &c);
    return c.status;
}
