/** @file
 * What a World has, found by its id or its place in the order of ids, as what it is. All is borrowed; NULL: there is no
 * such thing.
 */
#ifndef VVI_MODEL_CONTENTS_H
#define VVI_MODEL_CONTENTS_H
#include <volvis/model.h>

static inline const vv_dataset *vvi_dataset_named(const vv_world *world, const char *id)
{
    return (const vv_dataset *)(const void *)vv_collection_find(world->datasets, id);
}

static inline const vv_volume *vvi_volume_named(const vv_world *world, const char *id)
{
    return (const vv_volume *)(const void *)vv_collection_find(world->volumes, id);
}

static inline const vv_view *vvi_view_named(const vv_world *world, const char *id)
{
    return (const vv_view *)(const void *)vv_collection_find(world->views, id);
}

static inline const vv_measurement *vvi_measurement_named(const vv_world *world, const char *id)
{
    return (const vv_measurement *)(const void *)vv_collection_find(world->measurements, id);
}

/* i: less than there are. */
static inline const vv_dataset *vvi_dataset_nth(const vv_world *world, size_t i)
{
    return (const vv_dataset *)(const void *)world->datasets->entry[i].object;
}

static inline const vv_volume *vvi_volume_nth(const vv_world *world, size_t i)
{
    return (const vv_volume *)(const void *)world->volumes->entry[i].object;
}

static inline const vv_measurement *vvi_measurement_nth(const vv_world *world, size_t i)
{
    return (const vv_measurement *)(const void *)world->measurements->entry[i].object;
}

/** The first visible volume, and its id. */
const vv_volume *vvi_first_visible(const vv_world *world);
const char *vvi_first_visible_id(const vv_world *world);
/** The data that a volume shows: those that it names, else the World's first; and their id, which may be of none. */
const vv_dataset *vvi_volume_dataset(const vv_world *world, const vv_volume *volume);
const char *vvi_volume_dataset_id(const vv_world *world, const vv_volume *volume);
/** Whether they are a mesh. */
bool vvi_volume_is_mesh(const vv_world *world, const vv_volume *volume, vv_job *job);
/** "": the dataset is not of this World. */
const char *vvi_dataset_id(const vv_world *world, const vv_dataset *dataset);
#endif
