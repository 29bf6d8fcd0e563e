/** @file
 * What makes one World of another, for those who have the one as JSON.
 */
#ifndef VVI_MODEL_CHANGES_H
#define VVI_MODEL_CHANGES_H
#include <volvis/model.h>

/**
 * The changes from one World to another as the text of a JSON array, to be applied in order to what vv_scene_print()
 * says of the first; then it is what that says of the other, entries of maps in the same order:
 *
 *     {"op": "set", "path": "lights.key.intensity", "value": 2}    objects on the way are made
 *     {"op": "unset", "path": "lights.key.intensity"}              what is there goes
 *     {"op": "add", "path": "lights", "id": "fill", "after": "key", "value": {...}}   after null: it comes first
 *     {"op": "remove", "path": "lights.fill"}
 *
 * Worlds share what has not been edited, so the work follows the change, and otherwise the entries of maps that hold
 * one.
 *
 * most    bytes of the text; *out stays NULL where it would be longer
 * Owns    *out is yours to free()
 * Errors  VV_E_MEMORY
 */
vv_status vvi_world_changes(char **out, const vv_world *from, const vv_world *to, size_t most);
/** The World as scenes have it, with its version set (scene.c); *out is yours to release. */
vv_status vvi_world_with_schema(vv_object **out, const vv_world *world);
#endif
