/** @file
 * A set of triangles by their corners, in this order of them.
 */
#ifndef VVI_FILTER_CORNER_SET_H
#define VVI_FILTER_CORNER_SET_H
#include "core/status.h"
#include <volvis/runtime.h>

typedef struct vvi_corner_set {
    uint32_t *at; /**< three for each of `room` places, a power of two; UINT32_MAX: nobody's */
    size_t room, n;
} vvi_corner_set;

/** With room for so many triangles; more are left out. Owns: vvi_corner_set_finish(). Errors: VV_E_MEMORY. */
vv_status vvi_corner_set_init(vvi_corner_set *set, size_t n_triangles, vv_job *job);
void vvi_corner_set_finish(vvi_corner_set *set);
void vvi_corner_set_clear(vvi_corner_set *set);
void vvi_corner_set_add(vvi_corner_set *set, const uint32_t corner[3]);
bool vvi_corner_set_has(const vvi_corner_set *set, const uint32_t corner[3]);
#endif
