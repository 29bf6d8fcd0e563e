/** @file
 * Maps that were freed and may be taken again with their pages. A system spends more time on giving zeroed pages, one
 * fault each, than Marching Cubes on what it writes into them; somebody who drags the value of a surface frees a mesh
 * and takes one of nearly the same size many times a second.
 *
 * What is kept never makes a peak: it goes when something is asked for that none of it fits, or that exceeds the limit
 * together with it.
 */
#ifndef VVI_CORE_KEPT_MAPS_H
#define VVI_CORE_KEPT_MAPS_H
#include <pthread.h>
#include <stddef.h>
#include <stdint.h>

enum { VVI_KEPT_MAPS = 8 };

/** Of one runtime. All fields are under the lock; zeros but for it at first. */
typedef struct vvi_kept_maps {
    pthread_mutex_t lock;
    struct vvi_kept_map {
        void *memory;
        size_t bytes;
    } map[VVI_KEPT_MAPS];
    int n;
    uint64_t bytes; /**< of all */
} vvi_kept_maps;

/** A map of `bytes` with whatever was in it, made of one that is not much smaller or larger; NULL: there is none, and
 * nothing is kept any more. `room`: bytes that may be kept beside it. */
void *vvi_kept_take(vvi_kept_maps *kept, size_t bytes, uint64_t room);
/** Keeps a map of vvi_os_map() or unmaps it. `room`: bytes that may be kept altogether. */
void vvi_kept_give(vvi_kept_maps *kept, void *memory, size_t bytes, uint64_t room);
void vvi_kept_drop(vvi_kept_maps *kept);
#endif
