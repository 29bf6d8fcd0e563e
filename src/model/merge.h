/** @file
 * Worlds of meshes, and Worlds put together.
 */
#ifndef VVI_MODEL_MERGE_H
#define VVI_MODEL_MERGE_H
#include "core/status.h"
#include <volvis/model.h>
#include <volvis/sys/registry.h>

/** vv_world_for_file() of a mesh, from a stream too. format: NULL: by content; part: NULL: all of it. */
vv_status vvi_world_for_mesh(vv_world **out, const char *path, const char *format, const char *part, vv_job *job);

/** What a World calls the data of a file: "/data/8 heads.nii.gz" is v8_heads. */
void vvi_world_id(char out[64], const char *path);
/** The n-th thing that is called so: "head", "head_2", "head_3", ... */
void vvi_world_number_id(char out[64], const char *id, unsigned n);

/** The first of these that a map has not. */
void vvi_world_free_id(char out[64], const vv_collection *taken, const char *id);

/** Datasets and volumes of `from` put into *world, which is swapped for a new one; ids that are there already get a
 * number. On failure *world is what it was. */
vv_status vvi_world_merge(vv_world **world, const vv_world *from, const vv_registry *registry);
#endif
