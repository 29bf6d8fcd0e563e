#include "model/contents.h"

const char *vvi_first_visible_id(const vv_world *world)
{
    for (size_t i = 0; i < world->volumes->n; i++)
        if (vvi_volume_nth(world, i)->visible)
            return world->volumes->entry[i].id;
    return NULL;
}

const vv_volume *vvi_first_visible(const vv_world *world)
{
    const char *id = vvi_first_visible_id(world);
    return id ? vvi_volume_named(world, id) : NULL;
}

const char *vvi_volume_dataset_id(const vv_world *world, const vv_volume *volume)
{
    return volume->data ? volume->data : world->datasets->n ? world->datasets->entry[0].id : NULL;
}

const vv_dataset *vvi_volume_dataset(const vv_world *world, const vv_volume *volume)
{
    const char *id = vvi_volume_dataset_id(world, volume);
    return id ? vvi_dataset_named(world, id) : NULL;
}

bool vvi_volume_is_mesh(const vv_world *world, const vv_volume *volume, vv_job *job)
{
    const vv_dataset *dataset = vvi_volume_dataset(world, volume);
    return dataset && vv_dataset_is_mesh(dataset, job);
}

const char *vvi_dataset_id(const vv_world *world, const vv_dataset *dataset)
{
    for (size_t i = 0; i < world->datasets->n; i++)
        if (vvi_dataset_nth(world, i) == dataset)
            return world->datasets->entry[i].id;
    return "";
}
