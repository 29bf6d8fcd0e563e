/** @file
 * What the property engine must know of the model: the registry's tables and the World's unit.
 */
#ifndef VVI_MODEL_CONTEXT_H
#define VVI_MODEL_CONTEXT_H
#include <stddef.h>
#include <volvis/model.h>
#include <volvis/sys/registry.h>

/** A context that knows the rows of "renderers", "data_kinds" and "formats" of a registry (NULL: the built-in one).
 * Valid as long as the registry is. */
vv_property_context vvi_registry_context(const vv_registry *registry);
/** The same with the World's unit, and the voxel of its first dataset whose grid can be learned. Valid as long as the
 * World is. */
vv_property_context vvi_world_context(const vv_world *world, vv_job *job);
/** A World as of vv_world_for_file() that shows one dataset of another, and has all of that one's datasets. */
vv_status vvi_world_for_dataset(vv_world **out, const vv_world *from, const char *id, vv_job *job);
/** A sentence of n bytes at most, without the file's name, on a scene of a newer schema; false: it is none. */
bool vvi_schema_is_newer(char *out, size_t n, int64_t schema);
#endif
