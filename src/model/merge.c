/* One World's data shown in another. */
#include "model/merge.h"
#include "core/property_impl.h"
#include "model/contents.h"
#include "model/context.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct merging {
    vv_object *world;
    vv_property_context context;
    vv_status st;
} merging;

enum { PATH_ROOM = VVI_ID_MOST + 32 };

void vvi_world_number_id(char out[VVI_ID_MOST + 1], const char *id, unsigned n)
{
    if (n < 2)
        snprintf(out, VVI_ID_MOST + 1, "%s", id);
    else
        snprintf(out, VVI_ID_MOST + 1, "%.*s_%u", VVI_ID_MOST - 11, id, n);
}

void vvi_world_free_id(char out[VVI_ID_MOST + 1], const vv_collection *taken, const char *id)
{
    unsigned n = 1;
    do
        vvi_world_number_id(out, id, n++);
    while (vv_collection_find(taken, out));
}

static const vv_world *now(const merging *m)
{
    return (const vv_world *)m->world;
}

static void put(merging *m, const char *map, const char *id, vv_object *object)
{
    char path[PATH_ROOM];
    snprintf(path, sizeof path, "%s.%s", map, id);
    if (m->st == VV_OK)
        m->st = vv_path_put(&m->world, path, object, &m->context);
}

static void name_data(merging *m, const char *volume, const char *dataset)
{
    char path[PATH_ROOM];
    snprintf(path, sizeof path, "volumes.%s.data", volume);
    if (m->st == VV_OK)
        m->st = vv_path_set(&m->world, path, dataset, &m->context);
}

/* What showed the only dataset must name it when there are more. */
static void name_only_data(merging *m)
{
    const vv_collection *datasets = now(m)->datasets;
    for (size_t i = 0; datasets->n == 1 && i < now(m)->volumes->n; i++) {
        const vv_entry *entry = &now(m)->volumes->entry[i];
        if (!((const vv_volume *)entry->object)->data)
            name_data(m, entry->id, now(m)->datasets->entry[0].id);
    }
}

/* What a dataset of the other World is called in this one. */
typedef char new_id[VVI_ID_MOST + 1];

/* A dataset and the volumes that show it. */
static void add_dataset(merging *m, const vv_world *from, size_t index, char data[VVI_ID_MOST + 1])
{
    const vv_entry *dataset = &from->datasets->entry[index];
    char id[VVI_ID_MOST + 1];
    vvi_world_free_id(data, now(m)->datasets, dataset->id);
    put(m, "datasets", data, dataset->object);
    for (size_t i = 0; i < from->volumes->n && m->st == VV_OK; i++) {
        const vv_entry *volume = &from->volumes->entry[i];
        const char *shows = ((const vv_volume *)volume->object)->data;
        if (shows ? vv_collection_find(from->datasets, shows) != dataset->object : from->datasets->n > 1)
            continue;
        vvi_world_free_id(id, now(m)->volumes, volume->id);
        put(m, "volumes", id, volume->object);
        name_data(m, id, data);
    }
}

static void rename_reference(merging *m, const vv_world *from, new_id *ids, const char *id, const char *path)
{
    const size_t at = id ? vvi_collection_index(from->datasets, id) : from->datasets->n;
    if (at < from->datasets->n && m->st == VV_OK)
        m->st = vv_path_set(&m->world, path, ids[at], &m->context);
}

/* What is made is made of the same as before, whatever that is called now. */
static void rename_inputs(merging *m, const vv_world *from, new_id *ids, size_t index)
{
    const vv_dataset *d = vvi_dataset_nth(from, index);
    char path[2 * PATH_ROOM];
    const char *name;
    json_t *value, *inputs = vvi_members_tree(&d->base, vv_class_find(&vv_dataset_class, "inputs"));
    if (!inputs && m->st == VV_OK)
        m->st = vv_fail_memory(PATH_ROOM);
    json_object_foreach(inputs, name, value)
    {
        snprintf(path, sizeof path, "datasets.%s.inputs.%.*s", ids[index], VVI_ID_MOST, name);
        if (strlen(name) <= VVI_ID_MOST && !strchr(name, '.'))
            rename_reference(m, from, ids, json_string_value(value), path);
    }
    json_decref(inputs);
    snprintf(path, sizeof path, "datasets.%s.source", ids[index]);
    rename_reference(m, from, ids, d->source, path);
}

vv_status vvi_world_merge(vv_world **world, const vv_world *from, const vv_registry *registry)
{
    merging m = {.world = vv_object_retain(&(*world)->base), .context = vvi_registry_context(registry)};
    new_id *ids = vvi_calloc(from->datasets->n + 1, sizeof *ids);
    if (!ids)
        m.st = vv_fail_memory(from->datasets->n * sizeof *ids);
    name_only_data(&m);
    for (size_t i = 0; i < from->datasets->n && m.st == VV_OK; i++)
        add_dataset(&m, from, i, ids[i]);
    for (size_t i = 0; i < from->datasets->n && m.st == VV_OK; i++)
        rename_inputs(&m, from, ids, i);
    free(ids);
    if (m.st != VV_OK) {
        vv_object_release(m.world);
        return m.st;
    }
    vv_object_release(&(*world)->base);
    *world = (vv_world *)m.world;
    return VV_OK;
}
