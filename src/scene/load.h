/** @file
 * Data of datasets, from their files.
 */
#ifndef VVI_SCENE_LOAD_H
#define VVI_SCENE_LOAD_H
#include "core/status.h"
#include <volvis/file.h>
#include <volvis/model.h>

/** The file of a dataset that has a path, with what its header says; the caller closes it. */
vv_status vvi_dataset_open(vv_file **out, const vv_dataset *dataset, vv_job *job);

#endif
