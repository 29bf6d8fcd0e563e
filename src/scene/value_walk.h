/** @file
 * Derivatives at samples of a volume, as functions of the World: what is read of a field to know how steep it is.
 */
#ifndef VVI_SCENE_VALUE_WALK_H
#define VVI_SCENE_VALUE_WALK_H
#include "core/status.h"
#include <volvis/sys/scene.h>

typedef struct vvi_walk {
    vv_brick brick; /**< the slices about the sample that is visited */
    int64_t n[3];   /**< of the whole field */
    int component;
    vv_affine inverse; /**< World to index */
    double value_scale, value_offset;
} vvi_walk;

/** Called for a sample. */
typedef void vvi_walk_fn(void *user, const vvi_walk *walk, const int64_t at[3]);

/**
 * Visits an even grid of at most about 300000 samples, x fastest. Serial: same result always.
 *
 * Returns  VV_OK without a visit where the actor's place has no inverse
 * Errors   VV_E_MEMORY, VV_E_CANCELLED, and those of reading
 */
vv_status vvi_walk_samples(const vv_actor *actor, vvi_walk_fn *visit, void *user, vv_job *job);
/** As many visits as there are at most. */
enum { VVI_WALK_ALONG = 67, VVI_WALK_MOST = VVI_WALK_ALONG * VVI_WALK_ALONG * VVI_WALK_ALONG };

/** Finds something of an actor's samples. */
typedef vv_status vvi_walk_find_fn(void *out, const vv_actor *actor, vv_job *job);
/** What `find` finds, of so many bytes: once for a field in one place, kept in the cache under the name `what`. Errors:
 * those of `find`, VV_E_MEMORY. */
vv_status vvi_walk_once(void *out, size_t bytes, const char *what, vvi_walk_find_fn *find, const vv_actor *actor,
                        vv_job *job);

/** The value at the sample that is visited, or one beside it. */
double vvi_walk_value(const vvi_walk *walk, const int64_t at[3]);
/** At the one that is visited: value per world length, central differences, one-sided at the border. */
vv_vec3 vvi_walk_gradient(const vvi_walk *walk, const int64_t at[3]);
#endif
