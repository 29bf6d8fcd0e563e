/** @file
 * Data of datasets, from their files.
 */
#ifndef VVI_SCENE_LOAD_H
#define VVI_SCENE_LOAD_H
#include "core/status.h"
#include <volvis/file.h>
#include <volvis/model.h>

/** The file of a dataset that has a path, with what its header says; of one that is made, what does as if there were
 * one. The caller closes it. world: as of vv_dataset_field(). */
vv_status vvi_dataset_open(vv_file **out, const vv_world *world, const vv_dataset *dataset, vv_job *job);

#endif
