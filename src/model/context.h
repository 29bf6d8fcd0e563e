/** @file
 * What the property engine must know of the model: the registry's tables and the World's unit.
 */
#ifndef VVI_MODEL_CONTEXT_H
#define VVI_MODEL_CONTEXT_H
#include <volvis/model.h>
#include <volvis/sys/registry.h>

/** A context that knows the rows of "renderers", "data_kinds" and "formats" of a registry (NULL: the built-in one).
 * Valid as long as the registry is. */
vv_property_context vvi_registry_context(const vv_registry *registry);
/** The same with the World's unit, and the voxel of its first dataset whose grid can be learned. Valid as long as the
 * World is. */
vv_property_context vvi_world_context(const vv_world *world, vv_job *job);
#endif
