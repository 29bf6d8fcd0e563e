/* The built-in tables with rows of a program's own behind theirs. */
#include "core/memory.h"
#include "core/runtime.h"
#include <string.h>
#include <volvis/sys/registry.h>

/* A table as the join sees it: every row begins with its version and its name. */
typedef struct row {
    int api;
    const char *name;
} row;

typedef struct table {
    const char *noun;
    int api;
    const row *const *builtin, *const *more; /* more: NULL is none */
    const row **out;
} table;

enum { TABLES = 6 };

static void list_tables(table out[TABLES], const vv_registry *a, const vv_registry *b)
{
#define TABLE(noun, api, member)                                                                                       \
    {                                                                                                                  \
        noun, api, (const row *const *)a->member, (const row *const *)b->member, NULL                                  \
    }
    const table tables[TABLES] = {
        TABLE("format", VV_FORMAT_API, formats),
        TABLE("image format", VV_IMAGE_FORMAT_API, image_formats),
        TABLE("mesh format", VV_MESH_FORMAT_API, mesh_formats),
        TABLE("operation", VV_OPERATION_API, operations),
        TABLE("method", VV_RENDERER_API, renderers),
        TABLE("data kind", VV_DATA_KIND_API, data_kinds),
    };
#undef TABLE
    memcpy(out, tables, sizeof tables);
}

static size_t count(const row *const *rows)
{
    size_t n = 0;
    while (rows && rows[n])
        n++;
    return n;
}

static bool has(const row *const *rows, size_t n, const char *name)
{
    for (size_t i = 0; i < n; i++)
        if (!strcmp(rows[i]->name, name))
            return true;
    return false;
}

static vv_status check(const table *t)
{
    for (size_t i = 0; i < count(t->more); i++) {
        const row *r = t->more[i];
        if (r->api != t->api)
            return vv_fail(VV_E_UNSUPPORTED,
                           "the %s '%.64s' is built for version %d of its table, but this library has version %d; "
                           "compile it again with this library's headers",
                           t->noun, r->api > 0 && r->name ? r->name : "?", r->api, t->api);
        if (!r->name || !*r->name)
            return vv_fail(VV_E_ARGUMENT, "%s %zu of the further rows has no name", t->noun, i);
        if (has(t->builtin, count(t->builtin), r->name) || has(t->more, i, r->name))
            return vv_fail(VV_E_ARGUMENT, "there are two of the name '%.64s' among the rows '%s'; give yours another",
                           r->name, t->noun);
    }
    return VV_OK;
}

static size_t room_of(const table tables[TABLES])
{
    size_t n = 0;
    for (int i = 0; i < TABLES; i++)
        n += count(tables[i].builtin) + count(tables[i].more) + 1;
    return n;
}

/* What is behind them is NULL already. */
static void fill(table *t, const row **out)
{
    const size_t n = count(t->builtin), m = count(t->more);
    t->out = out;
    memcpy(out, t->builtin, n * sizeof(void *)); /* copies: they stay pointers to what they are */
    if (m)
        memcpy(out + n, t->more, m * sizeof(void *));
}

vv_status vvi_registry_join(struct vv_registry **out, const struct vv_registry *base, const struct vv_registry *more)
{
    table tables[TABLES];
    *out = NULL;
    list_tables(tables, base, more);
    for (int i = 0; i < TABLES; i++) {
        const vv_status st = check(&tables[i]);
        if (st != VV_OK)
            return st;
    }
    const size_t bytes = sizeof(vv_registry) + room_of(tables) * sizeof(row *);
    vv_registry *registry = vvi_calloc(1, bytes);
    if (!registry)
        return vv_fail_memory(bytes);
    const row **at = (const row **)(registry + 1);
    for (int i = 0; i < TABLES; i++) {
        fill(&tables[i], at);
        at += count(tables[i].out) + 1;
    }
    *registry = (vv_registry){
        .formats = (const vv_format *const *)tables[0].out,
        .image_formats = (const vv_image_format *const *)tables[1].out,
        .mesh_formats = (const vv_mesh_format *const *)tables[2].out,
        .operations = (const vv_operation *const *)tables[3].out,
        .renderers = (const vv_renderer *const *)tables[4].out,
        .data_kinds = (const vv_data_kind *const *)tables[5].out,
        .made_data = base->made_data,
    };
    *out = registry;
    return VV_OK;
}
