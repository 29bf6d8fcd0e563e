/** @file
 * Where a field's samples lie. A field asks its store for boxes and knows nothing more of it: a new way to store
 * (blocks, codes, a remote file) is one more vvi_sample_store_class beside the linear array of linear.c.
 */
#ifndef VVI_GRID_STORE_H
#define VVI_GRID_STORE_H
#include "grid/field.h"
#include <stdatomic.h>

typedef struct vvi_sample_store vvi_sample_store;

typedef struct vvi_sample_store_class {
    const char *name;
    bool lazy; /**< samples are made when they are asked for, and not kept all at once */
    /** Fills data, stride, guard_bytes and owner; box, type and components are set and checked before. */
    vv_status (*brick)(vv_brick *out, const vvi_sample_store *store, const vv_box *box, vv_job *job);
    /** Work that has to be done once before any brick; NULL: none. */
    vv_status (*prepare)(vvi_sample_store *store, vv_job *job);
    /** Whether samples were lost after the field was made; NULL: never. */
    bool (*damaged)(const vvi_sample_store *store);
    void (*drop)(vvi_sample_store *store);
} vvi_sample_store_class;

/** Head of every store. Shared by fields that show the same samples under different infos. */
struct vvi_sample_store {
    const vvi_sample_store_class *cls;
    _Atomic uint32_t refs;
    _Atomic uint64_t checksum; /**< 1 << 32 | CRC-32 once it is known, else 0 */
};

/** Head of what a brick's `owner` points to. */
typedef struct vvi_brick_owner {
    void (*release)(struct vvi_brick_owner *owner);
} vvi_brick_owner;

/** A plain array. Takes `release` over also when it fails. */
vv_status vvi_sample_store_linear(vvi_sample_store **out, const vv_field_info *info, const void *data,
                                  size_t guard_bytes, vv_free_fn *release, bool (*damaged)(const void *user),
                                  void *user, vv_job *job);
vvi_sample_store *vvi_sample_store_retain(vvi_sample_store *store);
void vvi_sample_store_release(vvi_sample_store *store); /* NULL is fine */

/** A field on a store; takes the reference over also when it fails. `runtime` keeps the derived data of the field. */
vv_status vvi_field_on_samples(vv_field **out, const vv_field_info *info, vvi_sample_store *store, vv_runtime *runtime,
                               vv_job *job);
vvi_sample_store *vvi_field_store(const vv_field *field);
/** Whether its samples are made when they are asked for. */
bool vvi_field_is_lazy(const vv_field *field);
/** What bricks of it wait for is done now, in passes over all that it is made of: for whoever holds no memory yet. */
vv_status vvi_field_prepare(const vv_field *field, vv_job *job);
/** A part of a field as a store's brick, which keeps the field until it goes. Takes the reference over also when it
 * fails. *damaged is set then where samples of the field were lost; NULL: nobody asks. */
vv_status vvi_field_lend(vv_brick *out, vv_field *field, const vv_box *part, atomic_bool *damaged, vv_job *job);
/** vv_field_health() without a sentence. */
bool vvi_field_is_damaged(const vv_field *field);
#endif
