/** @file
 * Fields whose samples are made when they are asked for: what lets a volume that no memory holds go from file to file.
 */
#ifndef VVI_GRID_LAZY_H
#define VVI_GRID_LAZY_H
#include "grid/field.h"

/** Keeps the slabs made last. All fields of one stage (the time steps of a file, say) share one; fields that are made
 * of others need a pool other than theirs. Counted references. */
typedef struct vvi_lazy_pool vvi_lazy_pool;

/** Slabs of whole slices along z, of at most slab_bytes (at least one slice); two of them are kept. Where making one
 * fails for want of memory, they get thinner: down to least_bytes; where that is 0 to one slice, and one of them is
 * kept where that is enough. */
vv_status vvi_lazy_pool_new(vvi_lazy_pool **out, uint64_t slab_bytes, uint64_t least_bytes, vv_job *job);
vvi_lazy_pool *vvi_lazy_pool_retain(vvi_lazy_pool *pool);
void vvi_lazy_pool_release(vvi_lazy_pool *pool); /* NULL is fine */
/** No slab is kept any longer. */
void vvi_lazy_pool_empty(vvi_lazy_pool *pool);
/** Samples that were made for its fields so far. */
uint64_t vvi_lazy_pool_made(vvi_lazy_pool *pool);

typedef struct vvi_lazy_source {
    /** The samples of one box, as a field of its own. Never called twice at once for the fields of one pool. */
    vv_status (*make)(vv_field **out, void *user, const vv_box *box, vv_job *job);
    /** Once, when the field goes, and also when making it fails; NULL: nothing to do. */
    void (*drop)(void *user);
    void *user;
    /** vvi_field_prepare() of what make() asks; NULL: nothing to do. */
    vv_status (*prepare)(void *user, vv_job *job);
    bool boxes; /**< small boxes are as quick as what is in them: those that are no whole slices are made alone */
} vvi_lazy_source;

/** Bricks from any thread; one thread makes while others wait. Retains the pool. */
vv_status vvi_field_lazy(vv_field **out, const vv_field_info *info, const vvi_lazy_source *source, vvi_lazy_pool *pool,
                         vv_job *job);
#endif
