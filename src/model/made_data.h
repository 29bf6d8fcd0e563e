/** @file
 * Datasets that are made of others: what the model asks of src/run, which stands above it. The registry has the one
 * that there is (vv_registry.made_data).
 */
#ifndef VVI_MODEL_MADE_DATA_H
#define VVI_MODEL_MADE_DATA_H
#include <volvis/model.h>

/** Each is called for a dataset of `world` for which vv_dataset_is_made() holds. */
typedef struct vvi_made_data {
    /** As planned: nothing is read but headers. */
    vv_status (*info)(vv_field_info *out, const vv_world *world, const vv_dataset *dataset, vv_job *job);
    vv_status (*field)(vv_field **out, const vv_world *world, const vv_dataset *dataset, int64_t frame, vv_job *job);
    vv_status (*mesh)(vv_mesh **out, const vv_world *world, const vv_dataset *dataset, vv_job *job);
    /** As if a file held its samples, for whoever works on files; it holds the World. */
    vv_status (*open)(vv_file **out, const vv_world *world, const vv_dataset *dataset, vv_job *job);
    /** Whether its operation makes triangles; false also where there is no such operation. */
    bool (*is_mesh)(const vv_dataset *dataset, vv_job *job);
} vvi_made_data;

/** Hash of all that decides what a file or what is in memory holds. */
uint64_t vvi_dataset_content(const vv_dataset *dataset);
#endif
