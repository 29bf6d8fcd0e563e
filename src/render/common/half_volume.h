/** @file
 * A volume with every two samples of an axis made one, for pictures that must be quick.
 */
#ifndef VVI_RENDER_COMMON_HALF_VOLUME_H
#define VVI_RENDER_COMMON_HALF_VOLUME_H
#include <volvis/sys/scene.h>

/** What two samples become. */
typedef enum vvi_halving {
    VVI_HALVE_MEAN,    /**< of those that are numbers */
    VVI_HALVE_LARGEST, /**< nothing bright is lost: for projections that look for it */
    VVI_HALVE_SMALLEST
} vvi_halving;

/**
 * The actor with `times` halvings of its field, where it stands in the World: sample i is that of samples 2 i and
 * 2 i + 1, and lies between them. Axes of 8 samples or fewer stay. Everything else is the actor's and stays with it:
 * statistics, classification, planes.
 *
 * Errors   VV_E_MEMORY, VV_E_LIMIT, VV_E_READ, VV_E_CANCELLED
 * Owns     out->field is the caller's: vv_field_release()
 * Threads  same bytes for any thread count
 * Cost     one pass over the samples, once: kept in the runtime's cache
 */
vv_status vvi_actor_halve(vv_actor *out, const vv_actor *actor, int times, vvi_halving halving, vv_job *job);
/** How many halvings leave at most `most` samples. */
int vvi_halvings_to(const vv_field *field, int64_t most);
#endif
